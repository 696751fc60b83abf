"""Beds in two half containers (thesis, sec. 8.5.1.2): walls that move, the servo, whole tests."""

import math
import shutil
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cluster_beds import particle
from damper_beds import DENSITY, acrylic
from forking import forked
from refusals import assert_refused
from same_run import results
from slow_rigs import HALVES, UP, bed, rig
from small_damper import damper3d

from damper3d.engine import state
from damper3d.engine.walls import gap_to_wall
from damper3d.measures.efficiency import closure
from damper3d.shapes.multisphere import sphere
from damper3d.studies.quasistatic import course, protocol
from damper3d.studies.quasistatic.case import SAMPLES, SlowTest
from damper3d.studies.quasistatic.chart import draw
from damper3d.studies.quasistatic.claims import Readings, alike
from damper3d.studies.quasistatic.claims import verdicts as judged
from damper3d.studies.quasistatic.measure import Result, stiffness
from damper3d.studies.quasistatic.report import report, summary
from damper3d.studies.quasistatic.rig import BASE, BOTTOM_SIDE, TABLE, TOP_SIDE, Halves
from damper3d.studies.quasistatic.shapes import HOLES, SPHEROIDS, by_shape, scatter_of
from granulab.campaign.output.results import read_results
from granulab.campaign.runs.folder import RunFolder, open_run
from granulab.errors import InputError

RESULTS = Path(__file__).parents[2] / "docs" / "results" / "damper3d"
R = 2.2e-3  # radius of single spheres [m]
ROOM = HALVES.enclosure.height


# The engine of clusters, compiled for walls that move each by itself, takes over a minute of CPU.
compiled = pytest.mark.validation


def column_of(n: int, **options: Any):
    """n spheres of radius R on the axis, one on the other, the table on the last."""
    law = acrylic(friction=0.0)
    sim = rig(sphere(R), [[0, 0, (2 * k + 1) * R] for k in range(n)], law=law, **options)
    sim.put(TABLE, (2 * n * R - ROOM) * UP)
    return sim, law


def forces_of_a_step(sim) -> np.ndarray:
    """Those of the particles on the walls (4, 3) [N] in one more step."""
    sim.sample()  # the forces are means since then
    return sim.run(1)["wall_force"][0]


@compiled
@pytest.mark.parametrize("n", [1, 3])
def test_a_column_of_spheres_is_as_stiff_as_hertz_contacts_in_series(n):
    """z = sum (F/K)^(2/3), K = (4/3) E* sqrt(R*): R at both ends, R/2 between spheres (eq. 5.5).

    At 2 mm/s the dashpots add below 1e-3 of the force, and the column's own vibration, which the
    start at once sets off, dies out: 1 % covers both, and the mean over a step's displacement.
    """
    sim, law = column_of(n)
    sim.drive({TABLE: -2e-3 * UP})
    sim.step(20_000)
    pushed = forces_of_a_step(sim)
    z = (2 * n * R - ROOM) - sim.place[TABLE, 2]
    ends, between = law.hertz * math.sqrt(R), law.hertz * math.sqrt(0.5 * R)
    expected = (z / (2 * ends ** (-2 / 3) + (n - 1) * between ** (-2 / 3))) ** 1.5
    assert pushed[TABLE, 2] == pytest.approx(expected, rel=0.01)
    assert pushed[BASE, 2] == pytest.approx(-expected, rel=0.01)
    assert np.abs(pushed[[BOTTOM_SIDE, TOP_SIDE]]).max() == 0.0


def pressed_ring(preload: float):
    """A toroid flat on the base, which cannot roll, with the table held to a pre-load on it."""
    ring = particle("toroid:0.2", R)
    radius = ring.radii[0]
    sim = rig(ring, [[0, 0, radius]])
    sim.put(TABLE, (2 * radius - ROOM) * UP)
    sim.hold(TABLE, preload, 150.0, 0.05)
    sim.step(20_000)
    return sim, ring


@compiled
def test_a_sheared_ring_resists_as_mindlin_says_and_then_slides_at_coulombs_limit():
    """F = k x, k of n contacts above and as many below: n k_t/2, k_t = 8 G* sqrt(R d) (eq. 5.16),
    over 1 + 2 (k_t/k_n) (r/A)^2, as the couple 2 r F rocks the ring, of radius A and tube r, on its
    normal springs k_n = (3/2) N/(n d); then F = mu N. 2 % of the first, where it has reached a
    third of the limit: the law's dashpot; 0.1 % of the second: the pre-load as held."""
    preload = 5.0
    sim, ring = pressed_ring(preload)
    law, n = acrylic(), len(ring.radii)
    assert forces_of_a_step(sim)[TABLE, 2] == pytest.approx(preload, rel=1e-4)
    overlap = (preload / (n * law.hertz * math.sqrt(ring.radii[0]))) ** (2 / 3)
    each = law.tangential * law.hertz * math.sqrt(ring.radii[0] * overlap)
    tube_over_ring = ring.radii[0] / np.linalg.norm(ring.offsets[0])
    rocking = 2 * each / (1.5 * preload / (n * overlap)) * tube_over_ring**2
    spring = 0.5 * n * each / (1 + rocking)
    limit, speed = law.mu * preload, 1e-3
    sim.drive({TABLE: speed * np.array([1.0, 0, 0])})
    sim.step(round(limit / 3 / spring / speed / 1e-6))
    moved = sim.place[TABLE, 0]
    held = forces_of_a_step(sim)
    mean = 0.5 * (held[BASE, 0] - held[TABLE, 0])  # wherever between both the ring is now
    assert mean == pytest.approx(spring * moved, rel=0.02)
    sim.step(round(3 * limit / spring / speed / 1e-6))
    assert forces_of_a_step(sim)[BASE, 0] == pytest.approx(limit, rel=1e-3)


def test_the_gap_to_a_wall_is_that_to_its_nearest_point():
    """Against points that lie densely on each wall: side, rim and disc, from inside and outside.

    Points 0.1 mm apart are nearer than their spacing to the nearest point of all.
    """
    sim = rig(sphere(R), [[0, 0, R]])
    sim.put(TOP_SIDE, np.array([1e-3, 0.0, 0.0]))
    walls, rng = sim.world.walls, np.random.default_rng(2)
    turn = np.linspace(0.0, 2.0 * np.pi, 700)
    for _ in range(50):
        w, x = int(rng.integers(4)), rng.uniform([-9e-3, -9e-3, 0.0], [9e-3, 9e-3, 18e-3])
        low, high, bottom, top = walls.surface.line[w]
        radius = np.linspace(low, high, 1 if low == high else 100)
        height = np.linspace(bottom, top, 1 if bottom == top else 100)
        r, z, t = (g.ravel() for g in np.meshgrid(radius, height, turn))
        points = np.stack([r * np.cos(t), r * np.sin(t), z], axis=1) + sim.place[w]
        nearest = np.linalg.norm(points - x, axis=1).min()
        ours = gap_to_wall(walls, np.array([[*x, 0.0]]), w, 0, (0.0, 0.0, 0.0))
        assert nearest - 1e-4 <= ours <= nearest + 1e-12


@compiled
def test_a_sphere_rests_on_a_rim_and_is_pushed_from_its_nearest_point():
    """With its centre beyond the rim of the bottom half, pressed by the table: the contact's force
    on the wall points from the centre to the rim (frictionless)."""
    law = acrylic(friction=0.0)
    height, outwards = HALVES.height + 1.2e-3, 0.5 * HALVES.diameter - 1.6e-3
    sim = rig(sphere(2e-3 + 1e-6), [[outwards, 0.0, height]], law=law)
    force = sim.run(1)["wall_force"][0]
    assert force[BOTTOM_SIDE, 0] > 0.0
    assert force[BOTTOM_SIDE, 2] / force[BOTTOM_SIDE, 0] == pytest.approx(-1.2 / 1.6, rel=1e-9)


def sheared(treatment="sum"):
    """A bed whose walls move much faster than those of a test, the table held to 3 N."""
    sim = bed(treatment)
    sim.put(TABLE, -0.5e-3 * UP)
    sim.hold(TABLE, 3.0, 100.0, 0.5)
    along = np.array([0.3, 0.0, 0.0])
    sim.drive({TOP_SIDE: along, TABLE: along})
    return sim


@compiled
@pytest.mark.parametrize("treatment", ["sum", "deepest"])
def test_no_bit_depends_on_the_lists_of_walls_that_move(treatment):
    """Skins put to extremes every 50 steps; 3000 steps, in which the top half comes 0.9 mm."""
    undisturbed = sheared(treatment)
    undisturbed.step(3000)
    for skin in (0.002, 0.03):
        sim = sheared(treatment)
        for _ in range(60):
            sim.world.lengths[[state.INNER_SKIN, state.WALL_SKIN]] = skin * sim.world.cells.largest
            sim.world.counts[[state.STALE_INNER, state.STALE_WALL]] = 1
            sim.step(50)
        assert sim.state_digest() == undisturbed.state_digest()


@compiled
def test_forces_on_all_walls_balance_weight_and_inertia_and_energy_is_accounted():
    """Newton's third law step by step: impulses on the walls are those of the weight less what the
    bed's momentum gained, but for the half steps at both ends; and wall work, table's and top
    half's, is what is dissipated, held and gained: 0.5 % at 1 us, as of the damper."""
    sim = sheared()
    sim.steps_per_sample = 200
    first, rows = sim.sample(), sim.run(30)
    mass = sim.mass.sum()
    force = rows["wall_force"].sum(axis=1)
    pushed = 200e-6 * force.sum(axis=0)
    gained = mass * (rows["mean_velocity"][-1] - first["mean_velocity"][0])
    weight = mass * np.array([0.0, 0.0, -9.81]) * 200e-6 * 30
    half_steps = 1e-6 * np.abs(force).max()
    assert np.abs(pushed + gained - weight).max() < 5 * half_steps
    samples = {name: np.concatenate([first[name], rows[name]]) for name in rows}
    assert abs(rows["wall_work"][-1]) > 0.1 * (rows["friction_particle_particle"][-1])
    assert abs(closure(samples)[0]) < 0.005


SMALL: dict[str, Any] = {
    "particles.shape": "prolate:1.5",
    "particles.equal_volume_radius": "2.2 mm",
    "particles.count": 36,
    "fill.settle_time": "60 ms",
}
ROUND = {"diameter": "17.6 mm", "half_height": "8.8 mm", "speed": "20 mm/s", "distance": "0.4 mm",
         "at": "0.2 mm"}  # fmt: skip


def small(kind="shear", seed=1, **options: str) -> SlowTest:
    """A test of 36 spheroids in halves of 17.6 mm."""
    return SlowTest.load(kind, SMALL, {**ROUND, "preload": "10 N", **options}, seed)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """The small shear test, never interrupted; to be read only."""
    root = tmp_path_factory.mktemp("undisturbed")
    protocol.run(small(), out=root)
    return root


def run_of(root: Path, kind: str = "shear"):
    (case,) = root.glob(f"{kind}-*/case.toml")
    return RunFolder(case.parent)


@compiled
def test_the_servo_holds_the_preload_while_the_top_half_moves(undisturbed):
    """To 10 % in the mean: where the loose bed collapses, as it does under shear, the table follows
    at its speed limit and the pre-load lacks meanwhile; on a ring that only slides it is exact."""
    found = run_of(undisturbed).read_summary()
    assert found["preload_mean_n"] == pytest.approx(10.0, rel=0.1)
    assert found["force_imbalance"] < 1e-3
    assert abs(found["energy_closure"]) < 0.005  # at 1 us
    assert found["stiffness_n_per_m"] > 0.0
    assert 0.0 < found["force_end_n"] - found["force_start_n"] < 2.0 * 10.0
    assert found["displacement_m"][-1] == pytest.approx(0.4e-3, rel=0.02)


@compiled
@pytest.mark.parametrize("write", [6, 7])
def test_a_test_that_is_killed_goes_on_to_the_same_bits(undisturbed, tmp_path, monkeypatch, write):
    """Killed at its so many-th write, in pre-load and test, with a checkpoint every nine rows."""
    monkeypatch.setattr(course, "_CHECKPOINT_WORK", 9 * 36 * 1000)
    shutil.copytree(undisturbed / "packings", tmp_path / "packings")
    assert forked(lambda: protocol.run(small(), out=tmp_path), kill_at_write=write) == -9
    assert run_of(tmp_path).checkpoint.exists()
    protocol.run(small(), out=tmp_path)
    assert results(run_of(tmp_path)) == results(run_of(undisturbed))


@compiled
def test_compression_stiffens_from_the_preload_on(undisturbed):
    """The base begins with the pre-load less what the sides carry; Hertz contacts stiffen."""
    found = protocol.run(small("compress", distance="0.1 mm", at="0.05 mm"), out=undisturbed)
    assert found.preload_mean_n is None
    assert 0.5 * 10.0 < found.force_start_n < 10.5
    rise = np.array(found.force_n) - found.force_start_n
    assert rise[-1] > 2.0 * rise[len(rise) // 2] > 0.0
    assert found.force_imbalance < 1e-3


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"gap": "6 mm"}, "--gap 6 mm: particles"),
        ({"distance": "6 mm"}, "--distance 6 mm: opens a crescent"),
        ({"at": "0.5 mm"}, "--at 0.5 mm: beyond the distance of 0.4 mm"),
        ({"kind": "compress", "distance": "30 mm"}, "--distance 30 mm: all voids"),
        ({"half_height": "500 mm"}, "--count 36: a bed of .* does not reach the top half"),
        ({"speed": "1000 m/s"}, "--speed 1e.06 mm/s: 0.4 mm are over in less than 100 time steps"),
        ({"at": "0.001 mm"}, "--at 0.001 mm: before the first of 100 rows; at least 0.004 mm"),
        ({"preload": "1e9 N"}, "--preload 1e.09 N: would press a layer"),
        ({"preload": "10"}, "--preload = '10': the unit is missing"),
        ({"speed": "-1 mm/s"}, "--speed = '-1 mm/s': must be above 0"),
    ],
)
def test_bad_input_is_refused_in_one_line(options, words):
    with pytest.raises(InputError, match=words) as refused:
        small(**options)
    assert "\n" not in str(refused.value)


def test_a_dry_run_says_what_it_costs_and_bad_shapes_end_with_code_two(tmp_path):
    planned = damper3d("shear", "--particles", "prolate:1,toroid:0.2", "--seeds", 2, "--dry-run")
    assert planned.code == 0
    assert "4 runs of 4 packings" in planned.out
    none = damper3d("shear", "--particles", "prolate:1", "--so-far", "-o", tmp_path)
    assert (none.code, none.out) == (2, "")
    refused = damper3d("compress", "--particles", "prolate:0.5", "-o", tmp_path, "--quiet")
    assert_refused(refused)


@pytest.mark.parametrize(("words", "cut_off"), [(["--no-figures"], False), ([], True)])
def test_a_table_without_a_picture_or_cut_off_is_written(tmp_path, monkeypatch, words, cut_off):
    """Of --no-figures, and of Ctrl-C, which leaves rows that are interrupted."""
    _, rows = read_results(RESULTS / "shear.csv")
    rows = rows[:2] + [{**rows[2], "state": "interrupted", "reason": "stopped"}] * cut_off
    monkeypatch.setattr("granulab.campaign.sweeps.sweep.run_labelled", lambda *_, **__: rows)
    result = damper3d("shear", "--particles", "prolate:1", "-o", tmp_path, "--quiet", *words)
    assert (result.code != 0) == cut_off
    assert sorted(path.suffix for path in tmp_path.iterdir()) == [".csv", ".parquet", ".txt"]


def test_the_kernels_are_compiled_where_those_of_these_walls_are(tmp_path, monkeypatch):
    """Those of a damper in the same folder are not theirs."""
    monkeypatch.setattr(protocol, "cache_folder", lambda room: str(tmp_path))
    (tmp_path / "kernels").mkdir()
    (tmp_path / "kernels" / "of_a_damper.nbc").touch()
    assert not protocol.SLOW_TESTS.compiled()
    monkeypatch.setattr(protocol, "once", lambda folder, name, work: (folder / name).touch())
    protocol.compile_kernels()
    assert protocol.SLOW_TESTS.compiled()


def test_a_step_costs_what_the_committed_tests_of_its_shape_took():
    """To a factor of two of the mean over the packings of each."""
    shapes = by_shape(read_results(RESULTS / "shear.csv")[1])
    for name, shape in shapes.items():
        test = SlowTest.load("shear", {"particles.shape": name}, {})
        steps = SAMPLES * course.steps_per_sample(test, True)
        step = 1e6 * protocol.expected_stages(test)["testing"] / steps
        assert 0.5 < step / shape.sample("cpu_us_per_step").mean < 2.0


def test_the_secant_to_the_whole_distance_is_that_to_the_last_point():
    """Which is half a row before it; of a straight line all secants are one."""
    way = np.append(0.0, 1e-5 * (np.arange(100) + 0.5))
    assert stiffness(1e-3, way, 5.0 + 3e4 * way) == pytest.approx(3e4, rel=1e-12)


def made(shape: str, values: list[float]) -> list[dict[str, Any]]:
    columns = [{"stiffness_n_per_m": v, "force_mean_n": v} for v in values]
    return [{"shape": shape, "state": "done", **own} for own in columns]


def verdicts(kind: str, means: dict[str, float], scatter: float = 0.01) -> list[bool | None]:
    """Of packings that scatter by so much about the means."""
    rows = [row for shape, mean in means.items()
            for row in made(shape, [(1 - scatter) * mean, mean, (1 + scatter) * mean])]  # fmt: skip
    return [one.holds for one in judged(kind, by_shape(rows))]


def test_the_thesis_statements_hold_of_made_stiffnesses_as_stated_and_fail_of_others():
    ratios = ["prolate:1", "prolate:1.5", "prolate:3", "toroid:0", "toroid:0.05", "toroid:0.2",
              "toroid:0.33"]  # fmt: skip

    def of(*values: float) -> dict[str, float]:
        return dict(zip(ratios, values, strict=True))

    assert verdicts("compress", of(1, 2, 1.5, 1, 2, 1.5, 1.2)) == [True, True]
    assert verdicts("compress", of(1, 2, 3, 1, 2, 1.5, 0.5)) == [False, False]
    for values in ((1, 2, 1.5, 1, 2, 1.5, 1.2), (1, 2, 2.1, 1, 2, 1.5, 1.2), (3, 2, 1, 3, 2, 2, 1)):
        # where packings scatter by a half, the largest may lie anywhere
        assert verdicts("compress", of(*values), scatter=0.5)[1] is None
    assert verdicts("shear", of(1, 2, 2, 1, 2, 2, 1)) == [True] * 6
    assert verdicts("shear", of(2, 1, 3, 2, 1, 3, 4)) == [False] * 6
    assert verdicts("shear", of(1, 1, 1, 1, 1, 1, 1))[0] is None  # within the scatter
    single = [row for shape in ratios for row in made(shape, [1.0])]
    assert {one.holds for one in judged("shear", by_shape(single))} == {None}


def test_shapes_that_are_alike_seldom_fail_by_the_scatter_of_their_packings():
    """Five packings of twelve shapes of one stiffness, which scatter by 30 %: at most 5 % of 200
    tables and three standard errors of that count. By single intervals the first failed in 18 %.
    """
    random = np.random.default_rng(5)
    shapes = [f"{kind}:{ratio:g}" for kind, ratios in (("prolate", SPHEROIDS), ("toroid", HOLES))
              for ratio in ratios]  # fmt: skip
    failed = np.zeros(2)
    for _ in range(200):
        tables = (made(one, list(1 + 0.3 * random.standard_normal(5))) for one in shapes)
        found = judged("compress", by_shape([row for rows in tables for row in rows]))
        failed += [one.holds is False for one in found]
    assert failed.max() <= 200 * (0.05 + 3 * math.sqrt(0.05 * 0.95 / 200))


@pytest.mark.parametrize("few", [1.5, 2, 3])
def test_shapes_are_not_alike_where_few_packings_of_any_of_them_hide_a_half(few):
    """Of a deviation of a half, 20 packings of each of two resolve 0.3, and two of one 0.75."""
    packings = {ratio: 2 if ratio == few else 20 for ratio in (1.5, 2, 3)}
    rows = [row for ratio, n in packings.items()
            for row in made(f"prolate:{ratio:g}", [0.5, 1.5] * (n // 2))]  # fmt: skip
    shapes = by_shape(rows)
    readings = Readings(shapes, "force_mean_n", scatter_of(shapes, "shear", "force_mean_n"))
    (check,) = alike(readings, "prolate")
    assert check.holds is None
    assert "would hide a half" in check.found


def test_toroids_without_a_sphere_of_their_own_name_the_run_that_lacks():
    """That of 3.5 mm; prolate:1 has 3.8 mm."""
    rows = made("prolate:1", [1.0, 1.1]) + made("toroid:0.2", [1.0, 1.1])
    toroids = judged("shear", by_shape(rows))[2]
    (check,) = toroids.checks
    assert check.found.startswith("no run of toroid:0, their sphere")


def test_the_scatter_of_a_packing_is_pooled_over_the_shapes():
    """Pairs 0.9 m, 1.1 m about any m: variance 0.02 m^2 of each with one degree of freedom; the
    interval of a mean of two is t(2) sqrt(0.02) m/sqrt(2)."""
    rows = made("prolate:1", [0.9, 1.1]) + made("prolate:2", [9.0, 11.0])
    shapes = by_shape(rows)
    scatter = scatter_of(shapes, "compress", "stiffness_n_per_m")
    assert (scatter.sd, scatter.freedom) == (pytest.approx(math.sqrt(0.02)), 2)
    width = scatter.half_width(shapes["prolate:2"].sample("stiffness_n_per_m"))
    assert width == pytest.approx(4.303 * math.sqrt(0.02) * 10.0 / math.sqrt(2), rel=1e-3)


@pytest.mark.parametrize(("kind", "packings"), [("compress", 5), ("shear", 20)])
def test_the_words_of_a_committed_table_are_what_its_rows_say(kind, packings):
    """The report is made again from the rows: neither can be changed alone."""
    head, rows = read_results(RESULTS / f"{kind}.csv")
    assert head["command"].startswith(f"damper3d {kind} --seeds {packings}")
    text = (RESULTS / f"{kind}.txt").read_text(encoding="utf-8")
    words = "\n".join(line for line in text.splitlines() if not line.startswith("# "))
    assert words.strip() == report(rows).strip()
    assert [row["state"] for row in rows] == ["done"] * 13 * packings


@pytest.mark.parametrize(
    ("own", "words"),
    [
        ({"inertial_number": 8.6e-2}, "an inertial number of 8.6e-02, above 0.001, is not slow"),
        ({"preload_mean_n": 23.5}, "a mean pre-load 53 %, more than 25 %, off"),
    ],
)
def test_tests_that_are_not_slow_or_not_under_their_preload_are_warned_of_and_not_judged(
    own, words
):
    _, rows = read_results(RESULTS / "shear.csv")
    assert summary("shear", rows)["warnings"] == []
    spoilt = [{**rows[0], **own}, *rows[1:]]
    assert f"warning: {words}: no claim is judged; give a lower --speed" in report(spoilt)
    assert "claims:" not in report(spoilt)
    found = summary("shear", spoilt)
    assert len(found["warnings"]) == 1
    assert found["statements"] == []


def test_the_picture_shows_the_stiffest_shape_of_either_family():
    """Spheroids and toroids share an axis; here toroids need the more of it."""
    _, rows = read_results(RESULTS / "compress.csv")
    figure = draw([row for row in rows if row["shape"] in ("prolate:1", "toroid:0", "toroid:0.05")])
    spheroids, toroids = figure.axes[2:]
    assert toroids.dataLim.y1 > spheroids.dataLim.y1
    assert spheroids.get_ylim() == toroids.get_ylim()
    assert toroids.get_ylim()[0] == 0.0
    assert toroids.get_ylim()[1] > toroids.dataLim.y1


def kept_test(root: Path, finished: bool) -> RunFolder:
    """The folder of a test of the committed table, as a run leaves it."""
    _, rows = read_results(RESULTS / "shear.csv")
    names = {field.name for field in fields(Result)}
    folder = open_run(root, "shear", "0")
    folder.write_case(small().to_toml())
    if finished:
        found = {name: value for name, value in rows[0].items() if name in names}
        impacts = {"particle_particle": None, "particle_wall": None}
        folder.write_summary({**found, "max_impact_over_yield_velocity": impacts})
    return folder


def test_a_slow_test_is_shown_and_refused_where_particles_are_wanted(tmp_path):
    folder = kept_test(tmp_path, finished=True)
    shown = damper3d("show", folder.path)
    assert shown.code == 0
    assert shown.out.startswith("shear of 100 of prolate:1, seed 1: secant stiffness")
    run = folder.path
    for words in (["render", run], ["export", run, "--to", "csv"], ["compare", run, run],
                  ["run", "--resume", run]):  # fmt: skip
        refused = damper3d(*words)
        assert_refused(refused, "of damper3d shear or compress")
    unfinished = damper3d("show", kept_test(tmp_path / "begun", finished=False).path)
    assert "unfinished; the same damper3d shear or compress goes on with it" in unfinished.out


def test_the_inertial_number_of_the_thesis_test_is_quasi_static():
    """v sqrt(rho/p) below 1e-3 with 50 N on 40 mm at 5 mm/s (GDR MiDi 2004)."""
    test = SlowTest.load("shear", {"particles.shape": "prolate:1.5"}, {})
    pressure = 50.0 / (math.pi * 0.02**2)
    assert test.inertial_speed(1.0) == pytest.approx(math.sqrt(pressure / DENSITY), rel=1e-12)
    assert test.speed < test.inertial_speed(1e-3)
    assert test.halves == Halves()
