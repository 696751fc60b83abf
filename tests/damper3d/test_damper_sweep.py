"""Studies of dampers: what they stand for, and a sweep to the same bits as single runs."""

import csv
from pathlib import Path

import pytest
from in_process import ThisProcess
from refusals import assert_refused
from small_damper import CASE, damper3d, write_damper
from small_silo import contents

from damper3d.case.case import DamperCase
from damper3d.run.protocol import run_digest
from damper3d.run.sweep import DAMPER, load_study
from granulab.campaign.sweeps import engine
from granulab.contact.files.datafile import data_file

STUDY = """
schema = 1
name = "gammas"
case = "small.toml"
[vary]
motion.gamma = [5, 10]
"""
SHAPES = 'particles.shape = ["prolate:1.5", "toroid:0.2"]\nparticles.count = 12'


def write_study(folder: Path, text: str = STUDY) -> Path:
    write_damper(folder)
    path = folder / "gammas.toml"
    path.write_text(text, encoding="utf-8")
    return path


def rows_of(study: Path) -> list[dict[str, str]]:
    (table,) = study.parent.glob("runs/studies/gammas-*/table.csv")
    return list(csv.DictReader(table.read_text().splitlines()))


# What a study stands for


def test_keys_are_those_of_a_damper_with_their_units(tmp_path):
    """Frequency and gamma are pure numbers; lengths and moduli carry units, kept in SI."""
    vary = '[vary]\nmotion.frequency = [20, 40]\nlaw.youngs_modulus = "3.3 GPa"\n'
    vary += 'enclosure.diameter = {start = "20 mm", stop = "30 mm", step = "5 mm"}\n'
    head = 'schema = 1\ncase = "thesis"\nseeds = [4]\n'
    loaded = load_study(write_study(tmp_path, head + vary))
    assert loaded.columns == (
        "case", "motion.frequency", "law.youngs_modulus_pa", "enclosure.diameter_m",
    )  # fmt: skip
    assert len(loaded.cases) == 6
    labels, case = loaded.cases[-1]
    assert tuple(labels.values()) == ("thesis", 40, 3.3e9, 0.03, 4)
    assert case.settings.motion.frequency == 40.0
    assert case.enclosure.radius == pytest.approx(0.015)


def test_a_case_of_a_study_is_the_one_that_a_single_run_finds(tmp_path):
    loaded = load_study(
        write_study(tmp_path, STUDY.replace("[5, 10]", "{start=5,stop=6,step=0.2}"))
    )
    single = DamperCase.load(tmp_path / "small.toml", {"motion.gamma": "5.6"})
    assert run_digest(loaded.cases[3][1]) == run_digest(single)


def test_steady_goes_for_every_run_unless_the_study_says_otherwise(tmp_path):
    """Runs of a sweep with --steady are those of single commands with it, and take more disk."""
    study = write_study(tmp_path)
    for _, case in load_study(study, {"run.steady": True}).cases:
        gamma = case.settings.motion.gamma
        alone = {"motion.gamma": gamma, "run.steady": True, "run.seed": case.settings.run.seed}
        assert run_digest(case) == run_digest(DamperCase.load(tmp_path / "small.toml", alone))
    own = write_study(tmp_path, STUDY.replace("motion.gamma = [5, 10]", "run.steady = [false]"))
    assert not any(
        case.settings.run.steady for _, case in load_study(own, {"run.steady": True}).cases
    )
    dry = ("--dry-run", "--no-figures", "--json", "-o", tmp_path / "runs")
    short, steady = (damper3d("sweep", write_study(tmp_path), *dry, *more).json
                     for more in ((), ("--steady",)))  # fmt: skip
    assert short["folder"] != steady["folder"]
    assert steady["disk_bytes_at_most"] > short["disk_bytes_at_most"]


def test_points_of_a_map_share_a_packing(tmp_path):
    """Frequency and acceleration act only once the enclosure moves; seeds are other packings."""
    text = STUDY.replace('case = "small.toml"', 'case = "small.toml"\nseeds = 2')
    loaded = load_study(write_study(tmp_path, text + "motion.frequency = [70, 80]\n"))
    files = {DAMPER.packing_file(case, tmp_path) for _, case in loaded.cases}
    assert (len(loaded.cases), len(files)) == (8, 2)


def test_the_shipped_study_can_be_run(tmp_path):
    path = data_file("studies", "damper")
    assert len(load_study(path).cases) == 30
    assert damper3d("init", "--study", tmp_path / "mine.toml").code == 0
    assert (tmp_path / "mine.toml").read_bytes() == path.read_bytes()
    again = damper3d("init", "--study", tmp_path / "mine.toml")
    assert_refused(again)


@pytest.mark.parametrize(
    ("vary", "words"),
    [
        ("motion.gama = 3", ["unknown key 'motion.gama'", "did you mean 'motion.gamma'?"]),
        ("silo.outlet = 3", ["unknown key 'silo.outlet'", "enclosure.diameter"]),
        ("enclosure.height = [40]", ["enclosure.height = 40", "unit is missing"]),
        ('motion.frequency = ["40 Hz"]', ["motion.frequency", "unit is wrong"]),
        ("motion.gamma = [5, 0]", ["gamma", "greater than 0"]),
        ("particles.count = [20, 5000]", ["count = 5000", "above random close packing"]),
    ],
)
def test_a_bad_study_is_refused_in_one_line(tmp_path, vary, words):
    study = write_study(tmp_path, f'schema = 1\ncase = "small.toml"\n[vary]\n{vary}\n')
    result = damper3d("sweep", study, "-o", tmp_path / "runs")
    assert_refused(result, *words)
    assert not (tmp_path / "runs").exists()


# The runs


@pytest.fixture(scope="module")
def swept(tmp_path_factory) -> Path:
    """The study of two accelerations, swept in this process, that share one packing."""
    study = write_study(tmp_path_factory.mktemp("swept"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(engine, "_pool", ThisProcess)
        result = damper3d("sweep", study, "-o", study.parent / "runs", "--quiet")
    assert result.code == 0, result.err
    return study


def test_a_sweep_has_the_bits_of_single_runs_and_one_packing(swept, tmp_path):
    """One filling for both, whoever does it; a row each, its results in columns."""
    rows = rows_of(swept)
    assert [(row["motion.gamma"], row["seed"], row["state"]) for row in rows] == [
        ("5.0", "1", "done"), ("10.0", "1", "done"),
    ]  # fmt: skip
    assert len(list(swept.parent.glob("runs/packings/*/packing.h5"))) == 1
    options = ["--gamma", 5, "-o", tmp_path, "--quiet", "--json", "--no-figures"]
    single = damper3d("run", swept.parent / "small.toml", *options).json
    assert single["state_digest"] == rows[0]["state_digest"] != rows[1]["state_digest"]
    whole = "efficiency_with_settling"
    assert float(rows[0][whole]) == single[whole]
    assert (rows[0]["efficiency"], single["efficiency"]) == ("", None)  # two cycles: it settles
    assert rows[0]["efficiency_note"] == single["efficiency_note"] != ""
    assert single["n_particles"] == CASE["particles.count"]


def test_a_sweep_of_shapes_has_the_same_bits_whatever_the_workers(tmp_path, request):
    """Two workers, then none."""
    study = write_study(tmp_path, STUDY.replace("motion.gamma = [5, 10]", SHAPES))
    digests = []
    for out in (tmp_path / "workers", tmp_path / "here"):
        words = ["-o", out, "--workers", 2, "--quiet", "--json"]
        table = Path(damper3d("sweep", study, *words).json["table"]).read_text()
        request.getfixturevalue("in_this_process")
        rows = csv.DictReader(table.splitlines())
        digests.append([(row["particles"], row["state_digest"]) for row in rows])
    assert digests[0] == digests[1]
    assert len({digest for _, digest in digests[0]}) == 2


def test_a_finished_run_is_not_done_again(swept):
    folders = [path.parent for path in swept.parent.glob("runs/*/case.toml")]
    before = {path: contents(path) for path in folders}
    table = damper3d("sweep", swept, "-o", swept.parent / "runs", "--quiet", "--json").json
    assert (table["done"], table["reused"]) == (2, 2)
    assert [row["efficiency.sd"] for row in table["combinations"]] == [None, None]  # of one seed
    assert {path: contents(path) for path in folders} == before


@pytest.mark.usefixtures("in_this_process")
def test_a_damaged_packing_is_a_row_that_says_what_to_delete(tmp_path):
    study = write_study(tmp_path, STUDY.replace("[5, 10]", "5"))
    case = load_study(study).cases[0][1]
    packing = DAMPER.packing_file(case, tmp_path / "runs")
    packing.parent.mkdir(parents=True)
    packing.write_bytes(b"nothing")
    result = damper3d("sweep", study, "-o", tmp_path / "runs", "--workers", 1, "--quiet")
    assert result.code == 3
    assert "1 of 1 runs failed" in result.err
    (row,) = rows_of(study)
    assert row["state"] == "failed"
    assert f"{packing}: damaged" in row["reason"]
    assert "delete it" in row["reason"]
    assert packing.read_bytes() == b"nothing"
