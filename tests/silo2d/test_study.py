"""What a study file stands for: lists, ranges, distributions; and what is refused."""

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from refusals import assert_refused
from small_silo import silo2d, write_case

from granulab.campaign.sweeps.series import series
from granulab.campaign.sweeps.study import MAX_RUNS, read_study
from granulab.contact.files.datafile import data_file
from granulab.contact.files.units import to_si
from granulab.errors import InputError
from silo2d.run.protocol import run_digest
from silo2d.run.sweep import load_study

HEAD = 'schema = 1\ncase = "A4"\n'


def write_study(folder: Path, text: str, head: str = HEAD) -> Path:
    path = folder / "study.toml"
    path.write_text(head + text, encoding="utf-8")
    return path


def values(folder: Path, written: str, key: str = "law.mu_wall") -> list:
    """What a key takes, in SI."""
    loaded = load_study(write_study(folder, f"[vary]\n{key} = {written}\n"))
    (column,) = loaded.columns[1:]
    return [labels[column] for labels, _ in loaded.cases]


# What it may say


def test_every_value_with_every_other_times_cases_and_seeds(tmp_path):
    head = 'schema = 1\ncase = ["A4", "B3"]\nseeds = 3\n'
    text = '[vary]\nlaw.mu_wall = [0.1, 0.2]\nlaw.kn = ["1e3 N/mm", "1e4 N/mm"]\n'
    loaded = load_study(write_study(tmp_path, text, head))
    rows = [tuple(labels.values()) for labels, _ in loaded.cases]
    assert rows == list(itertools.product(["A4", "B3"], [0.1, 0.2], [1e6, 1e7], [1, 2, 3]))
    assert list(loaded.cases[0][0]) == ["case", "law.mu_wall", "law.kn_n_per_m", "seed"]
    for labels, case in loaded.cases:
        assert case.name == labels["case"]
        assert case.settings.run.seed == labels["seed"]
        assert case.wall_law.mu == labels["law.mu_wall"]
        assert case.particle_law.kn == labels["law.kn_n_per_m"]


def test_zip_takes_the_kth_of_each_together(tmp_path):
    text = 'combine = "zip"\n[vary]\nlaw.mu_wall = [0.1, 0.2]\nlaw.mu_particle = [0.3, 0.4]\n'
    loaded = load_study(write_study(tmp_path, text + 'law.kn = "2e3 N/mm"\n'))
    rows = [tuple(labels.values())[1:4] for labels, _ in loaded.cases]
    assert rows == [(0.1, 0.3, 2e6), (0.2, 0.4, 2e6)]


def test_a_combination_that_is_written_twice_is_one(tmp_path):
    """Means over seeds would count its runs twice."""
    assert values(tmp_path, '["1e3 N/mm", "1e6 N/m", "2e3 N/mm"]', "law.kn") == [1e6, 2e6]


def test_cases_of_the_same_stem_are_distinguished(tmp_path):
    """A4 and a file A4.toml: the labels, by which means are taken, differ."""
    write_case(tmp_path, name="A4")
    loaded = load_study(write_study(tmp_path, "", 'schema = 1\ncase = ["A4", "A4.toml"]\n'))
    assert [labels["case"] for labels, _ in loaded.cases] == ["A4", "A4.toml"]


def test_keys_that_stand_together_take_the_same_value(tmp_path):
    text = '[vary]\n"law.mu_wall, law.mu_particle" = [0.1, 0.5]\n'
    laws = [
        (c.wall_law.mu, c.particle_law.mu) for _, c in load_study(write_study(tmp_path, text)).cases
    ]
    assert laws == [(0.1, 0.1), (0.5, 0.5)]


def test_a_study_without_vary_is_its_cases_times_seeds(tmp_path):
    loaded = load_study(write_study(tmp_path, "", 'schema = 1\ncase = "A4"\nseeds = [7, 2]\n'))
    assert [tuple(labels.values()) for labels, _ in loaded.cases] == [("A4", 7), ("A4", 2)]
    assert loaded.study.name == "study"


def test_a_case_of_a_study_is_the_one_that_a_single_run_finds(tmp_path):
    """Values of a range are what a person would write: 0.3, not 0.1 + 2 x 0.1."""
    from silo2d.case.case import SiloCase

    assert 0.1 + 2 * 0.1 != 0.3
    text = '[vary]\nlaw.mu_wall = {start = 0.1, stop = 0.3, step = 0.1}\nsilo.outlet = "120 mm"\n'
    _, case = load_study(write_study(tmp_path, text)).cases[-1]
    single = SiloCase.load("A4", {"law.mu_wall": "0.3", "silo.outlet": "12 cm"})
    assert run_digest(case) == run_digest(single)


def test_case_files_are_looked_for_in_the_study_s_folder(tmp_path):
    write_case(tmp_path)
    loaded = load_study(write_study(tmp_path, "", 'schema = 1\ncase = "small.toml"\n'))
    assert [(labels["case"], case.name) for labels, case in loaded.cases] == [("small", "small")]


def test_words_and_whole_numbers(tmp_path):
    assert values(tmp_path, '["published", "restitution"]', "law.damping") == [
        "published",
        "restitution",
    ]
    counts = values(tmp_path, "{start = 2, stop = 6, step = 2}", "run.opening_count")
    assert counts == [2, 4, 6]


@pytest.mark.parametrize(
    ("written", "expected"),
    [
        ('{start = "100 mm", stop = "150 mm", step = "25 mm"}', [0.1, 0.125, 0.15]),
        ('{start = "15 cm", stop = "100 mm", step = "-25 mm"}', [0.15, 0.125, 0.1]),
        ('{start = "100 mm", stop = "150 mm", number = 3}', [0.1, 0.125, 0.15]),
        ('{start = "40 mm", stop = "160 mm", number = 3, log = true}', [0.04, 0.08, 0.16]),
    ],
)
def test_ranges_hold_both_ends(tmp_path, written, expected):
    assert values(tmp_path, written, "silo.outlet") == expected


@given(
    start=st.integers(-999, 999), step=st.integers(1, 99), count=st.integers(1, 60),
    scale=st.sampled_from([1e-6, 1e-3, 1.0, 1e5]),
)  # fmt: skip
def test_a_range_by_step_has_the_values_of_the_decimals(start, step, count, scale):
    """Whatever the rounding of start + k step, the stop is met and none comes after it."""
    table = {
        "start": start * scale,
        "stop": (start + (count - 1) * step) * scale,
        "step": step * scale,
    }
    found = series(table, ("a.b",), lambda key, value: value, 1, 1000)
    exact = [(start + k * step) * scale for k in range(count)]
    assert len(found) == count
    # Twelve digits are kept, of numbers as large as the ends.
    np.testing.assert_allclose(found, exact, rtol=1e-11, atol=1e-11 * scale * 1e3)


def draw(seed: int = 1, key: str = "law.mu_wall", **table) -> np.ndarray:
    return np.array(series(table, (key,), lambda key, value: to_si(value, "1", key), seed, 10_000))


def test_what_was_drawn_is_known_and_how_people_write_it(tmp_path):
    """For the picture: a scatter over what was drawn, a curve over what was listed."""
    text = '[vary]\nlaw.mu_wall = { distribution = "uniform", min = 0.1, max = 0.2, number = 2 }\n'
    loaded = load_study(write_study(tmp_path, text + 'law.kn = ["1e3 N/mm"]\n'))
    assert [(one.label, one.unit, one.factor, one.drawn) for one in loaded.varied] == [
        ("case", "", 1.0, False), ("law.mu_wall", "", 1.0, True), ("law.kn", "N/mm", 1e3, False),
    ]  # fmt: skip


def test_draws_follow_their_distribution():
    """Mean and standard deviation of 4000 draws, to four standard errors; cut off where given."""
    count = 4000
    error = 4 / math.sqrt(count)
    x = draw(distribution="normal", number=count, mean=0.5, sd="10 %")
    assert abs(x.mean() - 0.5) < 0.05 * error
    assert abs(x.std() - 0.05) < 0.05 * error / math.sqrt(2)
    # exp(N(m, s)): the fourth moment is larger, and the error of the deviation with it.
    x = draw(distribution="lognormal", number=count, mean=0.5, sd=0.1)
    assert abs(x.mean() - 0.5) < 0.1 * error
    assert abs(x.std() - 0.1) < 0.1 * error
    assert abs(np.log(x).mean() - (math.log(0.5) - 0.5 * math.log(1.04))) < 0.2 * error
    x = draw(distribution="uniform", number=count, min=0.2, max=0.4)
    assert 0.2 < x.min() < x.max() < 0.4
    assert abs(x.mean() - 0.3) < 0.2 / math.sqrt(12) * error
    # A half normal: mean sd sqrt(2/pi), deviation sd sqrt(1 - 2/pi).
    x = draw(distribution="normal", number=count, mean=0.3, sd=0.1, min=0.3)
    assert x.min() >= 0.3
    assert abs(x.mean() - 0.3 - 0.1 * math.sqrt(2 / math.pi)) < 0.0603 * error


def test_draws_depend_on_the_draw_seed_and_their_own_key_alone(tmp_path):
    """Twice the same; the same with a second key; others for another seed or key."""
    table = '{distribution = "normal", mean = 0.4, sd = 0.05, number = 3}'

    def draws(text: str, column: str = "law.mu_wall") -> list[float]:
        loaded = load_study(write_study(tmp_path, text))
        return list(dict.fromkeys(labels[column] for labels, _ in loaded.cases))

    wall = f"[vary]\nlaw.mu_wall = {table}\n"
    first = draws(wall)
    assert first == draws(wall)
    assert first == draws(f'{wall}law.mu_particle = {table}\nlaw.damping = "restitution"\n')
    assert not set(first) & set(draws("draw_seed = 2\n" + wall))
    assert not set(first) & set(draws(f"[vary]\nlaw.mu_particle = {table}\n", "law.mu_particle"))
    # Promised for every machine and version: 12 digits of what came out when this was written.
    assert first == FIRST_DRAWS


FIRST_DRAWS = [0.401404767187, 0.317087633434, 0.407134750181]


def test_the_shipped_study_can_be_run(tmp_path):
    path = data_file("studies", "friction")
    assert len(load_study(path).cases) == 30
    assert silo2d("init", "--study", tmp_path / "mine.toml").code == 0
    assert (tmp_path / "mine.toml").read_bytes() == path.read_bytes()


# What is refused

NORMAL = 'distribution = "normal", number = 3'
BAD: list[tuple[str, list[str]]] = [
    # names
    ("sedes = 5", ["unknown key 'sedes'", "did you mean 'seeds'?"]),
    ("[vary]\nlaw.mu_wal = [1]", ["[vary] unknown key 'law.mu_wal'", "did you mean 'law.mu_wall'"]),
    ("[vary]\nlow.mu_wall = [1]", ["unknown key 'low.mu_wall'", "did you mean 'law.mu_wall'?"]),
    ("[vary]\nmu = [0.1]", ["[vary] mu: write section.key"]),
    ('[vary]\n"law.kn, kt" = ["1 N/m"]', ["unknown key 'kt'"]),
    ("[vary]\nrun.seed = [1, 2]", ["run.seed", "seeds = 5"]),
    ('[vary]\n"law.kt" = ["1e5 N/m"]\nlaw.kt = ["1e5 N/m"]', ["law.kt", "stands there twice"]),
    # values
    ("[vary]\nlaw.mu_wall = []", ["[vary] law.mu_wall = []", "at least one value"]),
    ("[vary]\nlaw.kn = [1e7]", ["[vary] law.kn = 10000000.0", "unit is missing", "N/mm"]),
    ('[vary]\nlaw.kn = ["1e4 mm"]', ["law.kn = '1e4 mm'", "unit is wrong", "N/mm"]),
    ("[vary]\nlaw.mu_wall = [0.1, -0.1]", ["A4", "mu_wall", "greater than or equal to 0"]),
    ('[vary]\nlaw.damping = ["much"]', ["damping = 'much'", "'published' or 'restitution'"]),
    ("vary = 3", ["vary = 3", "[vary]"]),
    # ranges
    ("[vary]\nlaw.mu_wall = {start = 1}", ["law.mu_wall: stop is missing"]),
    ("[vary]\nlaw.mu_wall = {start = 1, stop = 2}", ["step or number"]),
    ("[vary]\nlaw.mu_wall = {start = 1, stop = 2, stepp = 1}", ["'stepp'", "mean 'step'?"]),
    ("[vary]\nlaw.mu_wall = {start = 0, stop = 1, step = -0.1}", ["step = -0.1", "from 0 to 1"]),
    ("[vary]\nlaw.mu_wall = {start = 0, stop = 1, step = 0}", ["step = 0", "does not lead"]),
    (
        "[vary]\nlaw.mu_wall = {start = 0.1, stop = 0.5, step = 0.3}",
        ["law.mu_wall: stop = 0.5 is 1.333 steps of 0.3 from 0.1", "another stop or step"],
    ),
    (
        '[vary]\nsilo.outlet = {start = "100 mm", stop = "140 mm", step = "1e-320 mm"}',
        ["silo.outlet: inf values", "at most 10,000"],
    ),
    ("[vary]\nlaw.mu_wall = {start = 0, stop = 1, number = 1}", ["number = 1", "2 or more"]),
    ("[vary]\nlaw.mu_wall = {start = 0, stop = 1, number = 3, log = true}", ["above 0"]),
    ('[vary]\nlaw.kn = {start = "1 N/m", stop = 2, number = 3}', ["law.kn = 2", "unit is missing"]),
    ('[vary]\nlaw.damping = {start = "a", stop = "b", number = 2}', ["start = 'a'", "number"]),
    # distributions
    ('[vary]\nlaw.mu_wall = {distribution = "norml"}', ["'norml'", "did you mean 'normal'?"]),
    ("[vary]\nlaw.mu_wall = {distribution = [1]}", ["distribution = [1]", "normal"]),
    (f"[vary]\nlaw.mu_wall = {{{NORMAL}, mean = 0.4}}", ["sd is missing"]),
    (f"[vary]\nlaw.mu_wall = {{{NORMAL}, mean = 0.4, sd = 0}}", ["sd = 0", "greater than 0"]),
    (f'[vary]\nlaw.mu_wall = {{{NORMAL}, mean = 0.4, sd = "a %"}}', ["'a %'", "not a quantity"]),
    (f"[vary]\nlaw.mu_wall = {{{NORMAL}, mean = 1, sd = 1, min = 2, max = 1}}", ["below max"]),
    (f"[vary]\nlaw.mu_wall = {{{NORMAL}, mean = 1, sd = 1, min = 20}}", ["nearly nothing"]),
    # numbers of runs
    ("seeds = 0", ["seeds = 0", "how many"]),
    ("seeds = [1, 1.5]", ["seeds = [1, 1.5]", "a list"]),
    ("seeds = [1, 99999999999999999999]", ["seeds = [1, 9", "0 to 9223372036854775807"]),
    ("draw_seed = -1", ["draw_seed = -1"]),
    ("seeds = 1000000", ["too many runs", f"{MAX_RUNS:,}"]),
    ("[vary]\nlaw.mu_wall = {start = 0, stop = 1, step = 1e-9}", ["1,000,000,001 values"]),
    (
        "seeds = 9\n[vary]\nlaw.mu_wall = {start = 0, stop = 1, number = 40}\n"
        "law.mu_particle = {start = 0, stop = 1, number = 50}",
        ["too many runs: 40 x 50 combinations x 9", "18,000", f"at most {MAX_RUNS:,}"],
    ),
    ('combine = "sum"', ["combine = 'sum'", "'product' or 'zip'"]),
    (
        'combine = "zip"\n[vary]\nlaw.mu_wall = [1, 2]\nlaw.mu_particle = [1, 2, 3]',
        ["law.mu_wall: 2 values, but another key has 3"],
    ),
    # files
    ("[vary", ["not valid TOML"]),
    ('name = "up/down"', ["name = 'up/down'"]),
]


@pytest.mark.parametrize(("text", "words"), BAD)
def test_a_bad_study_is_refused_in_one_line(tmp_path, text, words):
    path = write_study(tmp_path, text + "\n")
    result = silo2d("sweep", path, "-o", tmp_path / "runs")
    assert_refused(result, *words)
    assert [path] == list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("head", "words"),
    [
        ('case = "A4"\n', ["schema = 1"]),
        ('schema = 9\ncase = "A4"\n', ["schema must be 1"]),
        ("schema = 1\n", ["case = None", "preset or a case file"]),
        ('schema = 1\ncase = "A5"\n', ["'A5'", "did you mean 'A"]),
        ("schema = 1\ncase = []\n", ["case = []"]),
    ],
)
def test_a_study_needs_a_case_and_a_schema(tmp_path, head, words):
    result = silo2d("sweep", write_study(tmp_path, "", head), "-o", tmp_path / "runs")
    assert_refused(result, *words)


def test_a_study_that_is_not_there(tmp_path):
    result = silo2d("sweep", tmp_path / "none.toml")
    assert_refused(result, "cannot be read")


def test_the_reader_alone_knows_what_keys_mean(tmp_path):
    """The study itself is without physics: any words do, and any error of the reader comes out."""
    path = write_study(tmp_path, '[vary]\nrocket.colour = ["red", "blue"]\n')
    study = read_study(path, lambda key, value: f"{key}:{value}")
    assert study.combinations == (
        {"rocket.colour": "rocket.colour:red"},
        {"rocket.colour": "rocket.colour:blue"},
    )

    def refuse(key, value):
        raise InputError("not this")

    with pytest.raises(InputError, match="not this"):
        read_study(path, refuse)
