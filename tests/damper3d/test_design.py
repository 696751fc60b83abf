"""Design of a damper: specifications, candidates, surrogate, and a small design from end to end."""

import json
import math
from pathlib import Path
from statistics import geometric_mean
from typing import Any

import numpy as np
import pytest
from refusals import assert_refused, assert_refuses
from small_damper import damper3d

from damper3d.studies.design import candidates as making
from damper3d.studies.design import verification as verifying
from damper3d.studies.design.candidates import Bed, Candidate
from damper3d.studies.design.design import Designer
from damper3d.studies.design.report import as_dict, remarks
from damper3d.studies.design.search import (
    Design,
    expected_improvement,
    field_from,
    gammas,
    judge,
    propose,
)
from damper3d.studies.design.spec import Task, example, read_catalogue, read_spec
from damper3d.studies.field.table import Field
from granulab.campaign.output.statistics import mean_sd
from granulab.errors import SimulationError

SPEC: dict[str, dict[str, Any]] = {
    "structure": {"mass": "2 kg", "frequency": 60.0, "damping_ratio": 0.005},
    "level": {"acceleration": "5 g"},
    "space": {"width": "60 mm", "height": "60 mm"},
    "budget": {},
    "search": {},
}
OWN = '[[kind]]\nname = "own"\nmaterials = "acrylic"\nmaterial = "acrylic"\ndiameters = ["5 mm"]\n'


def write_spec(folder: Path, changes: dict[str, Any] | None = None) -> Path:
    """Write spec.toml; a change to None takes a key out."""
    tables = {name: dict(table) for name, table in SPEC.items()}
    for place, value in (changes or {}).items():
        section, name = place.split(".")
        tables[section][name] = value
    lines = ["schema = 1"]
    for section, table in tables.items():
        lines += [f"[{section}]"]
        lines += [f"{k} = {json.dumps(v)}" for k, v in table.items() if v is not None]
    path = folder / "spec.toml"
    path.write_text("\n".join(lines) + "\n", "utf-8")
    return path


def task_of(folder: Path, changes: dict[str, Any] | None = None) -> Task:
    return read_spec(write_spec(folder, changes))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"structure.mass": None}, ["[structure]", "mass"]),
        ({"structure.mass": "2"}, ["mass = '2'", "unit is missing"]),
        ({"structure.damping_ratio": 0}, ["damping_ratio"]),
        ({"structure.damping_ratio": 1.5}, ["damping_ratio"]),
        ({"structure.frequency": "-2 Hz"}, ["frequency"]),
        ({"level.acceleration": None}, ["acceleration and force are missing"]),
        ({"level.force": "2 N"}, ["are both given"]),
        ({"level.range": [1.0, 0.5]}, ["range", "must rise"]),
        ({"level.range": []}, ["range"]),
        ({"level.orientation": "up"}, ["orientation"]),
        ({"space.width": "0 mm"}, ["width"]),
        ({"budget.added_mass": 1.5}, ["added_mass"]),
        ({"budget.catalogue": "nuts"}, ["nuts"]),
        ({"search.seeds": 1}, ["seeds"]),
        ({"search.fewest": 500}, ["fewest = 500", "most = 400"]),
        ({"search.trials": 3}, ["trials", "unknown key"]),
    ],
)
def test_specifications_that_cannot_be_are_refused_in_a_line(changes, words, tmp_path):
    assert_refuses(words, task_of, tmp_path, changes)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["no [[kind]]"]),
        (OWN + 'walls = "brass"\n', ["kind 1", "brass"]),
        (OWN + "walls = 7\n", ["kind 1", "walls = 7", "as text"]),
        (OWN.replace("materials", "matters"), ["kind 1", "materials is missing"]),
        (OWN + 'colour = "red"\n', ["unknown key 'colour'"]),
        (OWN.replace('["5 mm"]', "5"), ["diameters = 5", "a list"]),
        (OWN.replace('["5 mm"]', "[]"), ["diameters = []", "a list"]),
        (OWN.replace('materials = "acrylic"', "materials = 7"), ["materials = 7", "as text"]),
        ("kind = [3]\n", ["kind 1", "no table"]),
        (OWN.replace('"5 mm"', '"5"'), ["diameters = '5'", "unit is missing"]),
        (OWN.replace('"5 mm"', '"-5 mm"'), ["diameters", "above 0"]),
        (OWN.replace('= "acrylic"', '= "nut"'), ["nut"]),
    ],
)
def test_catalogues_that_cannot_be_are_refused_in_a_line(text, words, tmp_path):
    (tmp_path / "own.toml").write_text("schema = 1\n" + text, "utf-8")
    assert_refuses(words, read_catalogue, "own.toml", tmp_path)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"space.width": "5 mm"}, ["no design fits", "5 mm wide", "give more width"]),
        ({"space.height": "4 mm"}, ["no design fits", "4 mm high", "give more room"]),
        ({"budget.added_mass": 1e-6}, ["no design fits", "mass budget", "larger added_mass"]),
        ({"structure.mass": "2 t"}, ["no design fits", "more than 400", "larger balls"]),
    ],
)
def test_a_space_in_which_no_design_fits_says_what_binds(changes, words, tmp_path):
    assert_refuses(words, making.beds_of, task_of(tmp_path, changes))


def test_a_level_at_which_every_bed_rides_along_is_refused(tmp_path):
    """Vertically a rigid bed lifts off above 1 g: at 0.8 g and a fifth more it does not."""
    file = write_spec(tmp_path, {"level.acceleration": "0.8 g", "level.range": [0.8, 1.2]})
    assert_refused(damper3d("design", file, "--dry-run"), "0.96 g at most", "rides along up to 1 g")
    making.refuse_at_rest(task_of(tmp_path, {"level.acceleration": "0.9 g"}))


def test_the_force_is_that_of_the_bare_amplitude_at_resonance(tmp_path):
    """2 zeta M a, and back from the force."""
    task = task_of(tmp_path)
    assert task.force == pytest.approx(2 * 0.005 * 2.0 * 5 * 9.80665)
    again = task_of(tmp_path, {"level.acceleration": None, "level.force": f"{task.force!r} N"})
    assert again.bare_gamma == pytest.approx(task.bare_gamma)


def test_the_closed_form_is_where_the_powers_are_equal(tmp_path):
    """The force's pi F A is what structure and bed take, where nothing holds the bed."""
    task = task_of(tmp_path, {"level.orientation": "none", "level.range": [1.0]})
    a, own = making.closed_form(task), task.spec.structure
    taken = (
        2 * math.pi * own.damping_ratio * own.mass * (task.omega * a) ** 2
        + 4 * task.budget * (task.omega * a) ** 2
    )
    assert math.pi * task.force * a == pytest.approx(taken)
    held = task_of(tmp_path, {"level.range": [1.0]})
    assert making.closed_form(held) * held.omega**2 >= 1.2 * 9.81 * (1 - 1e-12)


def test_beds_are_shares_of_the_budget_of_each_ball_and_fit_the_space(tmp_path):
    task = task_of(tmp_path)
    beds = making.beds_of(task)
    assert {bed.ball.kind for bed in beds} == {"steel", "alumina"}  # acrylic takes above 400
    for bed in beds:
        full = math.floor(task.budget / bed.ball.mass * (1 + 1e-9))
        assert bed.count in {max(math.floor(share * full), 12) for share in making.SHARES}
        assert bed.mass <= task.budget * (1 + 1e-9)
        assert 3 * bed.ball.diameter * (1 - 1e-9) <= bed.width <= 0.06
        assert bed.depth + bed.ball.diameter <= 0.06
    drawn = making.random_beds(task, beds, 40)
    assert len({bed for bed, _ in drawn}) > 30
    assert all(bed.mass <= task.budget * (1 + 1e-9) and bed.width <= 0.06 for bed, _ in drawn)


def test_particles_of_a_catalogue_may_have_a_shape(tmp_path):
    """A prolate of aspect ratio 2 and the volume of a 5 mm sphere is 2^(2/3) times as long."""
    (tmp_path / "own.toml").write_text("schema = 1\n" + OWN + 'shape = "prolate:2"\n')
    task = task_of(tmp_path, {"budget.catalogue": "own.toml", "budget.added_mass": 0.004})
    (ball,) = task.catalogue
    assert ball.diameter == 0.005
    assert ball.extent == pytest.approx(0.005 * 2 ** (2 / 3), rel=1e-3)
    assert ball.mass == pytest.approx(1190 * math.pi / 6 * 0.005**3, rel=1e-3)
    beds = making.beds_of(task)
    assert all(bed.width >= 3 * ball.extent * (1 - 1e-4) for bed in beds)
    low = making.pool(beds, [0.006] * len(beds), 1e-5, 0.06)
    assert all(one.height >= ball.extent for one in low)


@pytest.mark.parametrize("settled", [0.05, 0.0105])
def test_clearances_count_from_the_bed_at_close_packing(tmp_path, settled):
    """Eq. 6.13's 0.55 over 0.64, but a layer of 10 mm stays one; no lower than it can be filled."""
    bed = Bed(next(b for b in task_of(tmp_path).catalogue if b.diameter == 0.01), 20, 0.06)
    close = max(settled * 0.55 / 0.64, 0.01)
    pool = making.pool([bed], [settled], 1e-4, 0.08)
    assert [one.height - one.clearance for one in pool] == pytest.approx([close] * len(pool))
    assert min(one.height for one in pool) >= (0.5 * (settled + close) if close > 0.01 else 0.01)
    assert max(one.clearance for one in pool) == pytest.approx(64e-4 * math.pi, rel=1e-3)


def test_a_bed_settles_whatever_the_space(tmp_path):
    """Twelve steel balls of 10 mm, one layer on 60 mm: 10 mm high, to a hundredth of bouncing."""
    for height in ("40 mm", "150 mm"):
        task = task_of(tmp_path, {"space.height": height})
        steel = next(b for b in task.catalogue if b.name == "10 mm steel")
        how = {"workers": 1, "quiet": True}
        designer = Designer(task, tmp_path / height[:2], how, lambda words: None)
        assert designer.heights([Bed(steel, 12, 0.06)]) == pytest.approx([0.010], rel=0.01)


def test_the_first_candidates_lie_apart_and_begin_with_the_closed_form(tmp_path):
    task = task_of(tmp_path)
    beds, amplitude = making.beds_of(task), making.closed_form(task)
    pool = making.pool(beds, [bed.depth for bed in beds], amplitude, 0.06)
    chosen = making.spread(pool, amplitude, 8)
    assert len(set(chosen)) == 8
    first = pool[chosen[0]]
    assert first.clearance == pytest.approx(math.pi * amplitude, rel=0.2)
    assert len({pool[k].bed for k in chosen}) >= 5
    assert all(one.height <= 0.06 for one in pool)


def test_expected_improvement_is_the_mean_of_what_is_gained():
    """Beside the mean of (best - y)+ over draws, to four standard errors of 0.4/sqrt(n)."""
    draws = np.random.default_rng(1).normal(0.3, 0.5, 400_000)
    found = expected_improvement(np.array([0.3]), np.array([0.5]), 0.2)[0]
    assert found == pytest.approx(np.maximum(0.2 - draws, 0).mean(), abs=4 * 0.4 / math.sqrt(4e5))


def test_the_surrogate_finds_the_least_of_a_smooth_function():
    """Of 400 places in a square, whose best ones are found by 20 looks, eight of them blind."""
    x = np.random.default_rng(2).uniform(size=(400, 2))
    value = np.exp(2.0 * (x[:, 0] - 0.7) ** 2 + 4.0 * (x[:, 1] - 0.2) ** 2)
    known = list(range(8))
    while len(known) < 20:
        known += propose(x, known, value[known].tolist(), 2)
    assert len(set(known)) == 20
    assert value[known].min() <= np.sort(value)[4]


@pytest.mark.parametrize("m", [0.05, 2.0])
def test_a_field_judges_a_rigid_bed_and_a_dashpot_as_their_closed_forms(tmp_path, m):
    """A mass shifts the peak to the same height of amplitude times omega^2 (M + m); a dashpot adds
    its damping. Frequencies are spaced to 0.2 % of a peak.
    """
    task = task_of(tmp_path, {"level.range": [1.0], "budget.added_mass": m / 2.0})
    own = task.spec.structure
    rows = [{"state": "done", "gamma": g, "mass_kg": m, "effective_mass.in_phase_kg": m,
             "effective_mass.out_of_phase_kg": 0.0} for g in gammas(task)]  # fmt: skip
    rigid = field_from(task, rows, own.frequency)
    assert rigid is not None
    (reduction,), ((peak, _),) = judge(task, rigid, [1.0])
    assert peak == pytest.approx(60.0 / math.sqrt(1 + m / 2.0), rel=1e-3)
    assert reduction == pytest.approx(math.sqrt(1 + m / 2.0), rel=5e-3)
    lossy = [row | {"effective_mass.in_phase_kg": 0.0, "effective_mass.out_of_phase_kg": 0.02}
             for row in rows]  # fmt: skip
    damped = field_from(task, lossy, own.frequency)
    assert damped is not None
    (reduction,), _ = judge(task, damped, [1.0])
    assert reduction == pytest.approx(0.005 / (0.005 + 0.02 / (2 * 2.0)), rel=5e-3)
    assert field_from(task, [{**rows[0], "state": "failed"}], 60.0) is None


def test_a_peak_is_the_top_of_the_parabola_through_three_points():
    f = [59.0, 60.0, 61.5]
    assert verifying.peak_of(f, [3 - (x - 60.2) ** 2 for x in f]) == pytest.approx(3.0)
    assert verifying.peak_of([*f, 70.0], [*(3 - (x - 60.2) ** 2 for x in f), 0.0]) == pytest.approx(
        3.0
    )
    assert verifying.peak_of(f, [3.0, 2.0, 1.0]) == 3.0


def test_a_peak_at_the_edge_is_looked_for_one_step_further():
    """On the side of the larger mean over the packings; not where a run has failed."""

    def rows(values, state="done"):
        return [
            {"frequency_hz": frequency, "host.amplitude_m": value, "state": state}
            for frequency, pair in values.items() for value in pair
        ]  # fmt: skip

    falling, rising = {59.0: (3, 2), 60.0: (2, 2), 61.5: (1, 2)}, {59.0: (1, 1), 60.0: (2, 2)}
    assert verifying.beyond_edge(rows(falling)) == [58.0]
    assert verifying.beyond_edge(rows(rising)) == [61.0]
    assert verifying.beyond_edge(rows({59.0: (3, 0), 60.0: (2, 2), 61.5: (1, 2)})) == []
    assert verifying.beyond_edge(rows(falling, "failed")) == []


def test_a_largest_response_that_stays_at_an_end_of_the_frequencies_is_said(tmp_path):
    """It rises from 55 to 57 Hz in all packings, so that what lies beyond is not known."""
    rows = [{"seed": seed, "frequency_hz": f, "host.amplitude_m": 1e-4 * f, "state": "done"}
            for f in (55.0, 56.0, 57.0) for seed in (1, 2)]  # fmt: skip
    task = task_of(tmp_path)
    one = verifying.Verified(Design(Candidate(Bed(task.catalogue[0], 12, 0.03), 0.02, 0.001)))
    one.note(task, 0, rows)
    assert one.at_end == {0: (55.0, 57.0)}
    level = {"level": 0.8, "largest_at_end_of_hz": list(one.at_end[0])}
    results = {"designs": [{"verified_by_simulation": {"levels": [level]}}], "compared": [],
               "failed": 0}  # fmt: skip
    (said,) = remarks(results)
    assert "at level 0.8 is at an end of the simulated 55 to 57 Hz" in said


def test_two_designs_of_a_bed_at_most_are_verified(tmp_path):
    """The best first; those whose field failed are none."""
    ball = task_of(tmp_path).catalogue[0]
    beds = [Bed(ball, 20, 0.03)] * 4 + [Bed(ball, 20, 0.04)] * 2
    found = [Design(Candidate(bed, 0.02 + 0.001 * k, 0.001), Field.of([60], [1.0], [1j], 0.1))
             for k, bed in enumerate(beds)]  # fmt: skip
    found[1].field = None
    nobody = Candidate(Bed(ball, 12, 0.03), 0.02, 0.001)
    assert verifying.to_verify(found, 3, nobody) == [found[0], found[2], found[4]]
    assert verifying.to_verify(found, 9, nobody) == [found[0], found[2], found[4], found[5]]


def test_a_comparison_that_the_first_design_loses_is_said():
    """Means of logarithms: 0.30 of the first against 0.28; and runs that are not steady yet."""
    compared = [
        {"what": "first", "words": "A", "reductions": [0.25, 0.36]},
        {"what": "thumb", "words": "B", "reductions": [0.28, 0.28]},
        {"what": "random", "words": "C", "reductions": []},
    ]
    designs = [{"verified_by_simulation": {"not_steady": 2}}]
    better, unsteady, failed = remarks({"designs": designs, "compared": compared, "failed": 3})
    assert better.endswith("B, 0.280 against 0.300")
    assert unsteady.startswith("2 of its runs")
    assert failed.startswith("3 candidates")
    compared[1]["reductions"] = [0.31, 0.32]
    designs[0]["verified_by_simulation"] = {"not_steady": 0}
    assert remarks({"designs": designs, "compared": compared, "failed": 0}) == []


def test_the_rule_of_thumb_is_verified_too_and_starts_the_search(tmp_path):
    """Sec. 9.2, rule I: 8 mm, an eighth of 60 mm, as wide as the space, pi times the bare amplitude
    over the bed, which is 5 g/omega^2 = 0.345 mm."""
    task = task_of(tmp_path)
    beds = making.beds_of(task)
    heights = [0.01 if bed.ball.diameter != 0.007 else math.inf for bed in beds]
    rule = making.rule_of_thumb(task, beds, heights)
    assert rule.bed.ball.diameter == 0.008
    assert rule.bed.width == 0.06
    assert rule.bed.mass == max(b.mass for b in beds if b.ball == rule.bed.ball)
    amplitude = 5 * 9.80665 / (2 * math.pi * 60) ** 2
    assert rule.clearance == pytest.approx(math.pi * amplitude, rel=1e-2)
    pool = [rule, *making.pool(beds, heights, 1e-4, 0.06)]
    assert 0 in making.spread(pool, 1e-4, 4)
    known = Field.of([60], [1.0], [1j], 0.1)
    found = [Design(one, known) for one in pool[5:9]] + [Design(rule, known)]
    assert verifying.to_verify(found, 1, rule) == [found[-1], found[0]]


def test_the_rule_of_thumb_is_of_a_bed_that_the_space_holds(tmp_path):
    """A ball of an eighth of the width whose bed is too high for it is left out."""
    task = task_of(tmp_path)
    beds = making.beds_of(task)
    heights = [0.1 if bed.ball.diameter == 0.008 else 0.02 for bed in beds]
    rule = making.rule_of_thumb(task, beds, heights)
    assert rule.bed.ball.diameter != 0.008
    assert rule.height <= 0.06


def test_beds_none_of_which_settles_are_failed_runs(tmp_path, monkeypatch):
    monkeypatch.setattr(Designer, "heights", lambda _, beds: [math.inf] * len(beds))
    how = {"workers": 1, "quiet": True}
    with pytest.raises(SimulationError, match="settle failed; `damper3d list"):
        Designer(task_of(tmp_path), tmp_path / "runs", how, lambda words: None).searched()


def test_clearances_near_the_best_stay_in_the_space(tmp_path):
    bed = Bed(task_of(tmp_path).catalogue[0], 20, 0.03)
    best = Candidate(bed, 0.020, 0.004)
    near = making.nearby(best, 0.0210)
    assert [one.clearance for one in near] == pytest.approx([0.00284, 0.00336, 0.00476])
    assert all(one.height - one.clearance == pytest.approx(0.016) for one in near)


def test_intervals_of_verified_designs_pool_the_scatter_of_their_beds(tmp_path):
    """Student's for one more packing: of two beds with two packings each, two degrees; another
    design of a bed on the same packings adds none, and the same one on others does."""
    ball = task_of(tmp_path).catalogue[0]
    designs = [Design(Candidate(Bed(ball, 20, width), 0.02, 0.001)) for width in (0.03, 0.04)]
    levels = [{0: {2: 0.30, 3: 0.25}, 2: {2: 0.20, 3: 0.32}}, {1: {2: 0.40, 3: 0.44, 4: 0.5}}]
    levels[1][0] = {2: 0.1, 3: 0.1}  # the third packing is not done there
    made = [verifying.Verified(one, known) for one, known in zip(designs, levels, strict=True)]
    assert [one.reductions for one in made] == [[0.30, 0.32], [0.40, 0.44]]  # of the worst level
    low, high = verifying.interval(made[0], made)
    sd = math.sqrt(sum(mean_sd(np.log(v.reductions).tolist()).sd ** 2 for v in made) / 2)
    middle = math.sqrt(0.30 * 0.32)
    assert math.log(high / middle) == pytest.approx(4.3027 * sd * math.sqrt(1.5), rel=1e-4)
    assert low * high == pytest.approx(middle**2)
    alike = verifying.Verified(Design(Candidate(Bed(ball, 20, 0.03), 0.03, 0.011)), levels[1])
    assert verifying.interval(made[0], [*made, alike]) == pytest.approx((low, high))
    again = verifying.Verified(designs[0], {0: {9: 0.3, 10: 0.32}})
    _, narrower = verifying.interval(made[0], [*made, again])
    assert narrower < high


def test_the_response_of_the_first_design_is_of_packings_it_was_not_chosen_by(tmp_path):
    """On those that it was chosen by, the least of several is too low: the others go before."""
    bed = Bed(task_of(tmp_path).catalogue[0], 20, 0.03)
    design = Design(Candidate(bed, 0.02, 0.001), reductions=[0.3], peaks=[(60.0, 1e-4)])
    seen = verifying.Verified(design, {0: {2: 0.20, 3: 0.25}})
    again = verifying.Verified(design, {0: {1001: 0.30, 1002: 0.40}})
    task = task_of(tmp_path, {"level.range": [1.0]})
    found = as_dict(task, design, 1, [seen], None, again)
    assert found["reduction"] == pytest.approx(math.sqrt(0.3 * 0.4))
    assert found["reduction_interval"] == list(verifying.interval(again, [seen]))
    assert found["verified_by_simulation"]["unseen"] == [0.30, 0.40]
    assert found["verified_by_simulation"]["reductions"] == [0.20, 0.25]
    assert found["walls"] == "acrylic"


def test_the_example_is_a_specification_that_is_taken(tmp_path):
    file = tmp_path / "mine.toml"
    assert damper3d("init", file, "--design").code == 0
    assert file.read_text("utf-8") == example()
    planned = damper3d("design", file, "--dry-run", "--json")
    assert planned.code == 0, planned.err
    found = json.loads(planned.out)
    assert found["candidates"] >= 12
    parts = found["parts_cpu_min"]
    assert found["expected_cpu_min"] == pytest.approx(sum(parts.values()))
    assert all(cost > 0 for cost in parts.values())
    more = json.loads(damper3d("design", file, "--dry-run", "--json", "--compare", 30).out)
    assert more["parts_cpu_min"]["fields"] == parts["fields"]
    assert all(more["parts_cpu_min"][name] > parts[name] for name in parts.keys() - {"fields"})


TINY = {
    "structure.mass": "0.1 kg", "structure.frequency": 80.0, "structure.damping_ratio": 0.02,
    "level.acceleration": "4 g", "level.range": [1.0], "space.width": "25 mm",
    "space.height": "25 mm", "budget.catalogue": "own.toml", "budget.added_mass": 0.05,
    "search.candidates": 3, "search.verified": 1,
}  # fmt: skip


@pytest.mark.validation
def test_a_small_design_is_made_told_and_not_computed_again(tmp_path):
    (tmp_path / "own.toml").write_text(
        "schema = 1\n" + OWN.replace('"5 mm"', '"4 mm", "5 mm"') + 'youngs_modulus = "0.1 GPa"\n'
    )
    file = write_spec(tmp_path, TINY)
    command = ("design", file, "--out", tmp_path / "runs", "--json", "--compare", 2)
    done = damper3d(*command)
    assert done.code == 0, done.err
    found = json.loads(done.out)
    first = found["designs"][0]
    ranks = [one["rank"] for one in found["designs"]]
    assert ranks == list(range(1, len(ranks) + 1))
    assert len(ranks) >= 3
    assert 0 < first["reduction"] < 1
    low, high = first["reduction_interval"]
    assert low <= first["reduction"] <= high
    assert first["added_mass_kg"] <= 0.05 * 0.1
    assert first["verified_by_simulation"]["reduction"] == first["reduction"]
    assert first["reduction"] == pytest.approx(
        geometric_mean(first["verified_by_simulation"]["unseen"])
    )
    seen = first["verified_by_simulation"]["levels"]
    assert [one["level"] for one in seen] == [one["level"] for one in first["levels"]]  # all
    assert {one["what"] for one in found["compared"]} <= {"first", "thumb", "random"}
    folder = Path(found["folder"])
    assert {"summary.json", "design.png", "sketch.png", "design.html"} == {
        p.name for p in folder.iterdir()
    }
    again = damper3d(*command)
    assert json.loads(again.out)["designs"] == found["designs"]
    assert "done," not in again.err  # no progress: every run was there
