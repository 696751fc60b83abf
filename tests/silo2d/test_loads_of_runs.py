"""Loads by runs: forces against the weight, samples at the walls, pascals, and the command."""

import dataclasses
import json
import math
import shutil
from pathlib import Path

import analytic
import numpy as np
import pytest
import scenes
from hand_built import moment_of, scene_of, simulation_in
from refusals import assert_refused, assert_refuses, refusal
from shapely import contains_xy
from small_silo import DischargeStop, silo2d, the_run, write_case

from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.trajectory import read_tables, read_trajectory
from granulab.errors import Stopped
from silo2d.case.beds.openings import with_inserts, with_outlets
from silo2d.case.case import SiloCase
from silo2d.case.outline import hopper
from silo2d.case.shape import disc
from silo2d.measures import MEASURES, fields, janssen, loads
from silo2d.measures.basics import balance
from silo2d.measures.basics.coarse_graining import grid_round
from silo2d.measures.basics.contacts import GRAVITY
from silo2d.measures.basics.dead_zones import area_of_silo, standing
from silo2d.measures.basics.friction import effective_friction, ratio, shear_rate
from silo2d.measures.basics.particles import prism_length, with_pascals
from silo2d.measures.basics.walls import Samples, on_walls
from silo2d.run import protocol
from silo2d.view.loads import pooling, study
from silo2d.view.loads.sheet import in_words
from silo2d.view.loads.tables import balance_table
from silo2d.view.scene import read_scene

SAMPLED = {"output.wall_interval": "1 ms", "output.contact_interval": "10 ms"}
LENGTH = 0.12  # of the wood's prisms [m], data/materials/wood.toml


@pytest.fixture(scope="module")
def sampled(_finished_root, tmp_path_factory) -> Path:
    """The small silo with samples at its walls, poured as the reference, run now."""
    root = tmp_path_factory.mktemp("sampled")
    shutil.copytree(_finished_root / "runs" / "packings", root / "runs" / "packings")
    case = write_case(root, SAMPLED)
    result = silo2d("run", case, "-o", root / "runs", "--no-figures", "--quiet")
    assert result.code == 0, result.err
    return the_run(root / "runs").path


# Samples at the walls


def test_samples_at_the_walls_change_no_bit(sampled, reference):
    """Another folder, the same state: looked at a hundred times as often."""
    found, other = (json.loads((path / "summary.json").read_text())
                    for path in (sampled, reference.path))  # fmt: skip
    assert found["state_digest"] == other["state_digest"]
    assert sampled.name != reference.path.name


def test_a_run_without_samples_keeps_its_name():
    """[output] wall_interval names a run only where it is given."""
    assert "wall_interval" not in SiloCase.load("A4").identity()["settings"]["output"]
    case = SiloCase.load("A4", {"output.wall_interval": "1 ms"})
    assert case.identity()["settings"]["output"]["wall_interval"] == 1e-3


def test_samples_of_a_stopped_run_are_those_of_one_that_was_not(sampled, tmp_path):
    """Stopped between frames, where samples wait for the next one: they are in the checkpoint."""
    root = tmp_path / "runs"
    shutil.copytree(sampled.parent / "packings", root / "packings")
    case = SiloCase.load(write_case(tmp_path, SAMPLED | {"output.checkpoint_interval": "7 ms"}))
    stops, result = 0, None
    stop = DischargeStop(lambda: True)
    while result is None:
        try:
            patience = stop if stops < 9 else (lambda: False)
            result = protocol.run(case, out=root, progress=stop.progress, stop=patience)
        except Stopped:
            stops += 1
    assert stops == 9
    for name in ("walls", "settling"):
        found, whole = (read_tables(path, name) for path in (Path(result.run_folder), sampled))
        for column, rows in whole.columns.items():
            assert found.columns[column].tobytes() == rows.tobytes(), (name, column)


def test_samples_are_the_walls_contacts_of_the_same_moment(sampled):
    """At the frames both are kept: the same forces on every wall, to single precision."""
    contacts, walls = (read_tables(sampled, name) for name in ("contacts", "walls"))
    scene = read_scene(sampled)
    seen = 0
    for k in range(1, len(contacts) - 1):
        kept, frame = contacts.at(k), contacts.frame[k]
        here = np.flatnonzero(walls.frame == frame)
        sample = walls.at(int(here[0]))
        last = np.isclose(sample["time"], scene.time[frame], atol=1e-9)
        assert last.any()
        bodies = kept["bodies"][:, 1].astype(int) - scene.n_particles
        for wall in range(len(scene.wall_names)):
            expected = kept["force"][bodies == wall].sum(axis=0)
            found = sample["force"][last & (sample["wall"] == wall)].sum(axis=0)
            np.testing.assert_allclose(found, expected, atol=1e-4)
            seen += int((bodies == wall).sum())
    assert seen > 20


def test_a_sample_is_what_the_walls_bear_in_that_step():
    """A block that lands on a corner and one that lies, looked at after each of 3,000 steps: the
    forces of a sample are those of the step that comes, to single precision."""
    block, silo = scenes.block(20e-3, 10e-3), hopper(0.0, 0.06, 0.2, 0.4, "floor")
    walls = range(len(silo.walls().names))
    sim = simulation_in(silo, [block] * 2, [(-0.06, 5e-3, 0.0), (0.06, 7.5e-3, 0.3)])
    borne, sampled = np.zeros((2, 3_000, len(walls), 2))
    for found, every in zip(sampled, borne, strict=True):
        sim.sample_walls()
        now = sim.wall_samples()
        found[:] = [now["force"][now["wall"] == wall].sum(axis=0) for wall in walls]
        sim.run(1)
        every[:] = sim.wall_forces()
    largest = np.abs(borne).max()
    assert largest > 1.0  # [N] landed: they weigh less than 0.1 N each
    np.testing.assert_allclose(sampled, borne, atol=4 * np.finfo(np.float32).eps * largest)


# Forces against the weight


def test_walls_and_base_carry_the_weight_at_rest(sampled):
    """Forces of every step over the last looks, and the change of momentum, are the weight: what is
    left is rounding of single steps, 1e-3 here (70 particles; A4 has 1.5e-5)."""
    found = loads.measure(sampled)["stages"]["at_rest"]["balance"]
    scene = read_scene(sampled)
    mass = scene.trajectory.static["mass"].sum()
    assert found["weight_n"] == pytest.approx(GRAVITY * mass, rel=1e-6)
    assert abs(found["closure"]) < 1e-3
    assert found["walls_share"] == pytest.approx(0.0, abs=1e-3)  # filled without friction
    parts = ("walls", "hopper", "floor", "door", "inertia")
    assert sum(found[f"{part}_share"] for part in parts) - 1 == pytest.approx(found["closure"])


def test_forces_weight_and_acceleration_balance_in_the_flow(sampled):
    """Newton's second law over a window: 2 % of the weight, for what particles below the outlet
    still pass on when they are taken out."""
    found = loads.measure(sampled)["stages"]
    for stage in ("opening", "flow"):
        assert abs(found[stage]["balance"]["closure"]) < 0.02
    assert found["opening"]["balance"]["inertia_share"] > 0.1  # the door has just gone
    assert found["flow"]["balance"]["door_n"] == 0.0


def test_balance_of_a_lift():
    """Two particles accelerate by a between two frames: the walls bear m (g + a)."""
    block = scenes.block(10e-3, 10e-3)
    silo = hopper(0.0, 0.04, 0.1, 0.2, "lift")
    scene = scene_of([block], [0, 0], silo, np.zeros(2), np.array([0.05, 0.1]))
    frames = scene.trajectory.frames
    mass = scene.trajectory.static["mass"].sum()
    for name in list(frames):
        frames[name] = np.concatenate([frames[name], frames[name]])
    frames["time"] = np.array([0.0, 0.1])
    frames["vy"] = np.array([[0.0, 0.0], [0.3, 0.3]])
    force = np.zeros((2, len(scene.wall_names), 2))
    force[1, 0, 1] = -mass * (GRAVITY + 3.0)  # the first wall is the floor on the right
    frames["wall_force"] = force
    found = balance.balance_between(scene, 0.0, 0.1)
    assert found is not None
    assert found.floor == pytest.approx(mass * (GRAVITY + 3.0))
    assert found.inertia == pytest.approx(-3.0 * mass)
    assert found.closure == pytest.approx(0.0, abs=1e-12)


# Pressures


def test_pressure_is_force_over_stretch_times_prism_length():
    """One force of 6 N on a wall of 0.1 m in two stretches, 0.12 m deep: 6/(0.05 x 0.12) Pa on its
    own stretch, none on the other; friction down the wall likewise."""
    silo = hopper(0.0, 0.04, 0.1, 0.1, "box")
    scene = scene_of([scenes.block(10e-3, 10e-3)], [0], silo, np.zeros(1), np.full(1, 0.05))
    wall = scene.wall_names.index("right wall")
    force = np.array([[6.0, -3.0]])
    samples = Samples(
        np.zeros(1), np.zeros(1, int), np.array([wall]), np.array([[0.05, 0.02]]), force
    )
    found = on_walls(scene, samples, 0.05)[wall]
    np.testing.assert_allclose(found.height, [0.025, 0.075])
    np.testing.assert_allclose(found.normal / LENGTH, [[6 / (0.05 * 0.12), 0.0]])
    np.testing.assert_allclose(found.shear / LENGTH, [[3 / (0.05 * 0.12), 0.0]])
    numbers = loads._wall(found, "walls", samples.time, LENGTH)
    assert numbers["area_m2"] == pytest.approx(0.05 * 0.12)
    assert numbers["normal_pa"] == pytest.approx([1000.0, 0.0])


def stage_with(silo, forces):
    """A stage of one moment in which a force [N] acts at the middle of each named wall."""
    scene = scene_of([scenes.block(10e-3, 10e-3)], [0], silo, np.zeros(1), np.full(1, 0.05))
    wall = np.array([scene.wall_names.index(name) for name in forces])
    point, force = scene.walls[wall].mean(axis=1), np.array(list(forces.values()))
    samples = Samples(np.zeros(1), np.zeros(len(wall), int), wall, point, force)
    return scene, loads._stage(scene, samples, None, LENGTH, 0.2, None), samples


def test_insert_is_no_side_of_the_silo():
    """6 N on each wall of 0.1 m, and 30 N on the upright side of a bar at the same height: the mean
    over the two sides is 6/(0.1 x 0.12) Pa; the bar's weight of 2 N on its top is an insert's."""
    silo = with_inserts(
        hopper(0.0, 0.04, 0.1, 0.1, "box"), [[[-5, 30], [5, 30], [5, 70], [-5, 70]]], 1e-3, "silo"
    )
    upright = next(
        name for name, (start, end) in zip(silo.walls().names, silo.walls().segments, strict=True)
        if name.startswith("insert") and np.isclose(start[0], end[0])
    )  # fmt: skip
    forces = {"left wall": (-6.0, 0.0), "right wall": (6.0, 0.0), upright: (30.0, -2.0)}
    scene, stage, samples = stage_with(silo, forces)
    height, value, _ = loads.profile(stage, "normal_pa")
    np.testing.assert_allclose(height, [0.05])
    np.testing.assert_allclose(value, [6 / (0.1 * LENGTH)])
    borne = balance.balance_of_samples(scene, samples, 0)
    assert (borne.inserts, borne.walls) == pytest.approx((2.0, 0.0))
    table = balance_table({"stages": {"at_rest": {"balance": borne.numbers()}}})
    assert "inserts" in table.head
    bare = borne._replace(inserts=0.0).numbers()
    assert "inserts" not in balance_table({"stages": {"at_rest": {"balance": bare}}}).head


def test_sides_are_averaged_where_both_have_a_wall():
    """An outlet from 30 to 60 mm in the right wall of a box of 0.1 m parts it in two; 6 N on the
    left wall and 1 N on the upper right piece of 40 mm: their mean at the heights of the pieces'
    middles, and none at 50 mm, the left one's, where the right side has no wall."""
    silo = with_outlets(hopper(0.0, 0.04, 0.1, 0.1, "box"), [[[50, 30], [50, 60]]], 1e-3, "silo")
    names = [name for name in silo.walls().names if name.startswith("right wall")]
    upper = max(names, key=lambda name: silo.walls().segments[silo.walls().names.index(name)].max())
    _, stage, _ = stage_with(silo, {"left wall": (-6.0, 0.0), upper: (1.0, 0.0)})
    height, value, _ = loads.profile(stage, "normal_pa")
    left, right = 6 / (0.1 * LENGTH), 1 / (0.04 * LENGTH)
    np.testing.assert_allclose(height, [0.015, 0.08])
    np.testing.assert_allclose(value, [left / 2, (left + right) / 2])


def test_fluctuation_is_about_the_trend_and_falls_with_the_time_it_is_averaged_over():
    """A falling pressure with noise of 100 Pa, 400 samples 1 ms apart: rms 100 Pa, and 100/sqrt(10)
    in means over 10 ms, to 10 % and 20 % (a chi-square's spread); the trend does not count."""
    rng = np.random.default_rng(5)
    time = 1e-3 * np.arange(400)
    series = (5e3 - 1e4 * time + rng.normal(scale=100.0, size=400))[:, None]
    assert loads.about_line(time, series)[0] == pytest.approx(100.0, rel=0.1)
    blocks = loads.in_blocks(time, series)
    assert blocks is not None
    assert len(blocks[0]) == 40
    assert loads.about_line(*blocks)[0] == pytest.approx(100 / math.sqrt(10), rel=0.2)
    assert loads.in_blocks(time[::10], series[::10]) is None  # a sample a block is no mean


def test_stresses_are_in_pascals_by_the_prisms_length(sampled):
    """Every number in N/m stands in Pa too: divided by the 0.12 m of the materials file."""
    assert prism_length(sampled) == pytest.approx(LENGTH)
    for what in ("stress", "janssen"):
        numbers = MEASURES.find(what).measure(sampled)
        plane = [key for key in numbers if key.endswith("_n_per_m")]
        assert len(plane) > 2
        for key in plane:
            pascals = numbers[f"{key.removesuffix('_n_per_m')}_pa"]
            if numbers[key] is None:
                assert pascals is None
            else:
                assert pascals == pytest.approx(numbers[key] / LENGTH)
    column = numbers["profiles"]["flow"]["column"]
    np.testing.assert_allclose(column["pressure_pa"], np.array(column["pressure"]) / LENGTH)
    assert with_pascals({"a_n_per_m": None, "b": 1}, 2.0) == {
        "a_n_per_m": None,
        "a_pa": None,
        "b": 1,
    }


@pytest.mark.parametrize("what", ["stress", "janssen", "fields", "massflow", "loads"])
def test_measures_take_a_window_of_time(sampled, tmp_path, what):
    """--between takes the flow's place; two windows give two results, each drawn."""
    run = shutil.copytree(sampled, tmp_path / "run")
    early, late = (
        silo2d("observe", run, what, "--between", window, "--json").json
        for window in ("40 ms,0.1 s", "0.1 s,0.16 s")
    )
    assert early != late
    assert (run / "figures" / f"{what}.png").stat().st_size > 10_000


BETWEEN = [
    ("stress", "0.2 s", ["write from and until"]),
    ("stress", "0.2 s,0.1 s", ["write from and until"]),
    ("stress", "0.2,0.3", ["the unit is missing"]),
    ("stress", "5 s,6 s", ["between 5 s and 6 s", "no contacts", "every 0.01 s"]),
    ("fields", "5 s,6 s", ["no frame"]),
    ("loads", "5 s,6 s", ["no sample"]),
    ("arch", "0.1 s,0.2 s", ["'arch' takes no --between", "janssen"]),
]


@pytest.mark.parametrize(("what", "between", "words"), BETWEEN)
def test_wrong_window_is_refused(sampled, what, between, words):
    result = silo2d("observe", sampled, what, "--between", between, "--no-figures")
    assert_refused(result, *words)


# Friction and dead zones


def test_effective_friction_of_a_made_stress():
    """Principal stresses 3:1 whatever their direction: sin delta = 1/2, 30 deg; of even parts the
    interval has no width, and four moments are too few for an angle."""
    angle = np.linspace(0, math.pi, 12).reshape(3, 4)
    stress = np.array([[2 + np.cos(2 * angle), np.sin(2 * angle)],
                       [np.sin(2 * angle), 2 - np.cos(2 * angle)]])  # fmt: skip
    where = np.ones((3, 4), bool)
    assert ratio(stress, where) == pytest.approx(0.5)
    found = effective_friction([stress] * 10, where)
    assert found is not None
    assert np.degrees(found) == pytest.approx([30.0] * 3)
    assert effective_friction([stress] * 4, where) is None
    assert effective_friction([stress] * 10, ~where) is None


def test_interval_of_the_friction_holds_the_truth_of_noisy_moments():
    """Stresses of sin delta = 1/2 with noise of a tenth of the pressure at 200 points, ten moments:
    the interval of 95 % holds 30 deg in 88 or more of 100 draws (binomial, three sigma)."""
    rng, held = np.random.default_rng(11), 0
    stress = np.array([[3.0, 0.0], [0.0, 1.0]])[:, :, None, None] * np.ones((10, 20))
    where = np.ones((10, 20), bool)
    for _ in range(100):
        common = rng.normal(scale=0.1, size=(10, 2, 2, 1, 1))
        found = effective_friction(list(stress + common), where)
        held += found.low < math.radians(30) < found.high
    assert held >= 88


def test_noise_of_few_moments_does_not_steepen_the_friction():
    """Noise of 0.7 of the pressure at each point and moment, eight moments: 33 deg of 30 by the
    mean stress alone. Of 40 draws the mean lies within a degree, four of its standard errors."""
    rng = np.random.default_rng(0)
    half, side = 0.5 * math.cos(math.pi / 3), 0.5 * math.sin(math.pi / 3)
    stress = np.array([[1 - half, side], [side, 1 + half]])[:, :, None, None]
    where, found = np.ones((10, 10), bool), []
    for _ in range(40):
        noisy = stress + 0.7 * rng.standard_normal((8, 2, 2, 10, 10))
        noisy[:, 1, 0] = noisy[:, 0, 1]
        found.append(math.degrees(effective_friction(list(noisy), where).value))
    assert np.mean(found) == pytest.approx(30.0, abs=1.0)


def test_a_block_that_is_cut_off_is_no_mean_over_ten_milliseconds():
    """101 samples of a millisecond: ten blocks, and a sample of the next."""
    time = 1e-3 * np.arange(101)
    series = np.r_[np.zeros(100), 1000.0][:, None]
    at, means = loads.in_blocks(time, series)
    assert len(at) == 10
    assert not means.any()
    assert len(loads.in_blocks(time[:100], series[:100])[0]) == 10


def test_a_seed_that_clogs_early_takes_no_stage_from_the_others():
    """Two runs that flowed and one that did not, in any order: the flow is that of the two."""

    def run(names, angle):
        stages = {name: {"balance": None, "walls": [], "from_s": 0.0, "until_s": 1.0,
                         "samples": 100} for name in names}  # fmt: skip
        ends = (angle - 1, angle + 2) if angle else (None, None)
        return {"stages": stages, "effective_friction_deg": angle,
                "effective_friction_low_deg": ends[0], "effective_friction_high_deg": ends[1],
                "at_rest_closure": 0.0, "prism_length_m": 0.12, "averaged_s": 0.01}  # fmt: skip

    flowed = run(("filling", "at_rest", "opening", "flow"), 33.0)
    stuck = run(("filling", "at_rest", "opening", "end"), None)
    for each in ([flowed, flowed, stuck], [stuck, flowed, flowed]):
        found = pooling.combined(each)
        assert list(found["stages"]) == ["filling", "at_rest", "opening", "flow", "end"]
        assert (found["stages"]["flow"]["runs"], found["stages"]["end"]["runs"]) == (2, 1)
    alone = pooling.combined([stuck, flowed])
    assert (alone["effective_friction_low_deg"], alone["effective_friction_high_deg"]) == (32, 35)


def test_the_bulk_density_of_the_column_is_that_of_the_space_beside_an_insert():
    """A lattice of discs round a wedge between the walls: as dense as without, to its edges."""
    found = []
    for inserts in ([], [[[-90, 190], [90, 190], [0, 330]]]):
        outline = SiloCase.load("A4", {"silo.inserts": inserts}).outline
        across, up = np.meshgrid(np.arange(-0.148, 0.15, 4e-3), np.arange(2e-3, 0.475, 4e-3))
        inside = contains_xy(outline.inside, across.ravel(), up.ravel())
        x, y = across.ravel()[inside], up.ravel()[inside]
        scene = scene_of([disc("a", 4e-3)], np.zeros(len(x), int), outline, x, y)
        none = {key: np.zeros((0, 2)) for key in ("bodies", "point", "force", "normal")}
        found.append(janssen.column([moment_of(scene, none)]).density)
    assert found[1] == pytest.approx(found[0], rel=0.01)


def test_shear_rate_of_simple_shear_and_of_a_rotation():
    """v_x = 2 y: 1/s, half the rate; a rigid rotation shears nothing; v = (x, -y): 1/s."""
    y, x = np.mgrid[0:5, 0:6] * 0.1
    for velocity, expected in (([2 * y, 0 * y], 1.0), ([-y, x], 0.0), ([x, -y], 1.0)):
        found = shear_rate(np.array(velocity), 0.1)
        np.testing.assert_allclose(found, expected, atol=1e-12)


def test_dead_zones_of_a_flow_between_two_standing_corners():
    """A box of 0.2 m x 0.3 m that flows at 0.5 m/s but for the outer 30 mm: dead there, three
    tenths of the area, to a row of the grid."""
    silo = hopper(0.0, 0.1, 0.2, 0.3, "corners")
    scene = scene_of([scenes.block(10e-3, 10e-3)], [0], silo, np.zeros(1), np.full(1, 0.1))
    polygon = silo.polygon
    grid = grid_round(polygon.min(axis=0), polygon.max(axis=0), 2e-3)
    x, y = np.meshgrid(grid.x, grid.y)
    solid = np.where((np.abs(x) < 0.1) & (y > 0) & (y < 0.3), 0.8, np.nan)
    speed = np.where(np.abs(x) < 0.07, 0.5, 0.0)
    found = standing(scene, grid, solid, speed, mass_flow=0.14 * 0.5 * 40, density=40.0)
    assert area_of_silo(scene, grid) == pytest.approx(0.06, rel=0.02)
    assert found.share == pytest.approx(0.3, abs=0.02)
    assert found.area == pytest.approx(0.018, rel=0.05)
    assert not (found.dead & found.flowing).any()
    still = standing(scene, grid, solid, speed * 0.0, mass_flow=0.0, density=40.0)
    assert still.area == pytest.approx(0.06, rel=0.02)  # without a flow all of it stands
    assert not still.flowing.any()


def test_left_zones_of_an_emptied_silo_are_none(sampled):
    """Seed 1 empties: nothing is left, and in the flow at 45 deg little stands."""
    found = fields.measure(sampled)
    assert (found["left_area_m2"], found["left_share"]) == (0.0, 0.0)
    assert 0.0 <= found["dead_share"] < 0.3


# The command


@pytest.fixture(scope="module")
def assessed(sampled):
    """Loads of the sampled run as JSON."""
    angle = ("--internal-friction", "30 deg")
    return silo2d("loads", sampled, *angle, "--json", "--no-figures").json


def test_loads_compare_a_run_with_the_closed_forms(assessed, sampled):
    """The slot between the walls, filled to its level: A/U = W/2, Janssen's law written out with
    the run's bulk weight and the case's wall friction."""
    silo, solid = assessed["closed_forms"]["silo"], assessed["closed_forms"]["solid"]
    assert silo["width_m"] == pytest.approx(0.08)
    assert silo["half_angle_deg"] == pytest.approx(45.0)
    assert silo["area_m2"] / silo["perimeter_m"] == pytest.approx(0.04)
    case = SiloCase.load(sampled / "case.toml")
    assert solid["wall_friction"] == case.wall_law.mu
    scene = read_scene(sampled)
    bulk = GRAVITY * scene.trajectory.static["mass"].sum() / LENGTH / case.outline.area_below(
        case.settings.fill.level
    )  # fmt: skip
    assert solid["unit_weight_n_per_m3"] == pytest.approx(bulk, rel=0.1)
    for row in assessed["compared"]:
        expected = solid["lateral_ratio"] * analytic.janssen(
            row["depth_m"], solid["unit_weight_n_per_m3"], solid["wall_friction"],
            solid["lateral_ratio"], 0.08,
        )  # fmt: skip
        assert row["janssen_pa"] == pytest.approx(expected)


def test_report_of_loads_fits_eighty_columns(assessed):
    text = in_words(assessed, 80)
    assert max(map(len, text.splitlines())) <= 80
    for word in ("at rest", "Janssen", "EN disch", "accelerates", "Jenike", "assumes"):
        assert word in text


def test_sheet_is_one_file_that_needs_no_other(sampled, tmp_path):
    """PNG and HTML in figures/; the page names no address, and has its picture in it."""
    run = shutil.copytree(sampled, tmp_path / "run")
    result = silo2d("loads", run, "--internal-friction", "30 deg")
    assert result.code == 0, result.err
    page = (run / "figures" / "loads.html").read_text()
    assert (run / "figures" / "loads.png").stat().st_size > 20_000
    assert page.count("data:image/png;base64,") == 1
    for address in ("http:", "https:", "<link", "<script", "@import"):
        assert address not in page
    assert "base and walls against the weight" in page


def test_runs_of_several_seeds_are_pooled_with_intervals(sampled):
    """Twice the same run: means as of one, no spread, samples twice as many."""
    one, two = (study.study([sampled] * n, None, {"solid.internal_friction": "30 deg"})
                for n in (1, 2))  # fmt: skip
    first, both = (found["dem"]["stages"]["flow"] for found in (one, two))
    assert both["samples"] == 2 * first["samples"]
    for wall, pooled in zip(first["walls"], both["walls"], strict=True):
        assert pooled["normal_pa"] == pytest.approx(wall["normal_pa"])
        assert pooled["normal_half_width_pa"] == pytest.approx([0.0] * len(wall["normal_pa"]))


def test_half_width_of_a_mean_is_students():
    """t(2) = 4.303 for 95 %: 1, 2, 3 have sd 1, so 4.303/sqrt(3)."""
    assert pooling.half_width([1.0, 2.0, 3.0]) == pytest.approx(4.3027 / math.sqrt(3), rel=1e-4)
    assert pooling.half_width([1.0]) == 0.0


def test_a_run_that_is_given_twice_is_one(sampled, tmp_path):
    (tmp_path / "table.csv").write_text(f"seed,run_folder\n1,{sampled}\n")
    found = silo2d("loads", sampled, tmp_path, "--internal-friction", "30 deg", "--no-figures",
                   "--json").json  # fmt: skip
    assert found["seeds"] == [1]


def test_a_case_keeps_the_intervals_that_it_gives(tmp_path, monkeypatch):
    """Loads sample walls and contacts more often than usual, unless the file says how often."""
    asked = []

    def run(case, **how):
        asked.append((case.settings.output.wall_interval, case.settings.output.contact_interval))
        raise Stopped("seen")

    monkeypatch.setattr(protocol, "run", run)
    for given, expected in (({}, (1e-3, 10e-3)), ({"contact_interval": "2 ms"}, (1e-3, 2e-3)),
                            ({"wall_interval": "4 ms"}, (4e-3, 10e-3))):  # fmt: skip
        case = write_case(tmp_path, {f"output.{key}": value for key, value in given.items()})
        silo2d("loads", case, "-o", tmp_path / "runs", "--quiet")
        assert asked[-1] == expected


def test_a_sweeps_table_stands_for_its_runs(tmp_path):
    """Run folders as its table names them, from where it stands; an empty one is refused."""
    (tmp_path / "table.csv").write_text("seed,run_folder\n1,../a\n2,../b\n2,../b\n3,/c\n")
    assert study.runs_of(tmp_path) == [tmp_path / "../a", tmp_path / "../b", Path("/c")]
    assert study.runs_of(tmp_path / "other") == [tmp_path / "other"]
    (tmp_path / "table.csv").write_text("seed,run_folder\n")
    with pytest.raises(Exception, match="no finished run"):
        study.runs_of(tmp_path)


def test_runs_of_unlike_silos_are_not_pooled(sampled, reference):
    """What differs besides seed and output refuses."""
    changes = {"run.seed": 2, "output.wall_interval": "2 ms"}, {"law.mu_wall": 0.1}
    like, unlike = (SiloCase.load(sampled / "case.toml", one) for one in changes)
    own = SiloCase.load(sampled / "case.toml")
    study._refuse_unlike([Path("a"), Path("b")], [own, like])
    line = refusal(study._refuse_unlike, [Path("a"), Path("b")], [own, unlike])
    assert "b: differs from a in more than its seed" in line


WRONG = [
    ([], ["CASE", "--silo"]),
    (["A4", "D4"], ["one CASE, or run folders"]),
    (["A4", "--engine", "pymunk"], ["--engine", "contacts of dem"]),
    (["A4", "--seeds", "2", "--seed", "3"], ["--seeds says this"]),
    (["A4", "--between", "7 s,8 s"], ["--between 7", "6 s", "--max-time"]),
    (["nowhere"], ["no such preset"]),
    (["A4", "--solid", "wheet"], ["did you mean 'wheat'"]),
    (["A4", "--solid", "wheat", "--lateral-ratio", "0.95"], ["lateral_ratio = 0.95", "0.9009"]),
    (["A4", "--repose", "400 deg"], ["repose = 400 deg", "5 to 75 deg"]),
    (["A4", "--silo", "none.toml"], ["none.toml: no such file", "--loads"]),
    (["--silo", "none.toml"], ["none.toml: no such file"]),
    (["--silo", "none.toml", "--seeds", "2"], ["closed form"]),
    (["--silo", "none.toml", "--dry-run"], ["closed form"]),
]


def test_what_loads_of_a_case_will_take_is_said_and_nothing_is_run(tmp_path, monkeypatch):
    """A packing and a run of each seed; of run folders there is nothing to be said."""
    monkeypatch.chdir(tmp_path)
    found = silo2d("loads", "A4", "--seeds", "3", "--dry-run")
    assert found.out.startswith("3 runs of 3 packings, about "), found
    planned = json.loads(silo2d("loads", "A4", "--seeds", "3", "--dry-run", "--json").out)
    assert (planned["runs"], planned["packings"]) == (3, 3)
    assert not list(tmp_path.iterdir())
    assert_refused(silo2d("loads", tmp_path, "--dry-run"), "run folders are as they are")


@pytest.mark.parametrize(("arguments", "words"), WRONG)
def test_wrong_use_of_loads_is_refused_before_anything_is_run(
    tmp_path, monkeypatch, arguments, words
):
    monkeypatch.chdir(tmp_path)
    assert_refused(silo2d("loads", *arguments), *words)
    assert not list(tmp_path.iterdir())


OUTLINED = dict.fromkeys(f"silo.{key}" for key in ("angle", "outlet", "width", "height"))
NO_VESSEL = [  # corners of the silo [mm], height of the fill [m], and what is said
    ([[-25, 0], [25, 0], [60, 80], [60, 200], [-60, 200], [-60, 80]], 0.08,
     ["[fill] level = 0.08 m", "vertical walls, 0.08 m", "--fill-level '0.16 m'", "observe RUN"]),
    ([[-25, 0], [25, 0], [60, 40], [60, 200], [-60, 200], [-60, 80]], 0.15,
     ["23.6 deg and 41.2 deg", "symmetric", "silo2d observe RUN loads"]),
]  # fmt: skip


@pytest.mark.parametrize(("corners", "fill", "words"), NO_VESSEL)
def test_runs_that_closed_forms_do_not_hold_for_are_refused_with_what_works(
    tmp_path, corners, fill, words
):
    silo = SiloCase.load(write_case(tmp_path, OUTLINED | {"silo.outline": corners})).outline
    heights = np.array([0.6 * fill, fill - 5e-3])
    scene = scene_of([scenes.block(10e-3, 10e-3)], [0, 0], silo, np.zeros(2), heights)
    scene.trajectory.attributes["level"] = fill
    none = dict.fromkeys(("bodies", "point", "force", "normal"), np.zeros((0, 2)))
    own = janssen.column([moment_of(scene, none)])
    assert_refuses(words, study.vessel_of, scene, own, LENGTH, False)


def test_case_without_loads_to_compare_is_refused_before_it_is_run(tmp_path):
    """A funnel all the way up has no vertical walls, whatever is in it; impulses keep no contacts;
    of others the closed forms do not hold."""
    funnel = OUTLINED | {"silo.outline": [[-25, 0], [25, 0], [60, 80], [-60, 80]]}
    bar = [[-5, 40], [5, 40], [5, 60], [-5, 60]]
    for changes, words in (
        (funnel, ["vertical wall on each side"]),
        (funnel | {"silo.inserts": [bar]}, ["vertical wall on each side"]),
        ({"run.engine": "pymunk"}, ["dem"]),
        ({"silo.outlets": [[[40, 40], [40, 60]]]}, ["[silo] outlets", "0.06 m", "observe RUN"]),
        *(
            (OUTLINED | {"silo.outline": corners, "fill.level": f"{fill} m"}, words)
            for corners, fill, words in NO_VESSEL
        ),
    ):
        case = write_case(tmp_path, changes)
        assert_refused(silo2d("loads", case, "-o", tmp_path / "runs"), *words)
    assert not list((tmp_path / "runs").glob("*/case.toml"))


def test_an_outlet_out_of_the_middle_is_as_eccentric_as_it_is(sampled, monkeypatch):
    """EN 1991-4, 5.1: e_o is the distance of the outlet's middle from the axis, of the largest one;
    a rule that is given goes before it."""
    box = [[-60, 0], [60, 0], [60, 200], [-60, 200]]
    silo = {"outline": box, "outlet": "40 mm", "outlet_centre": "30 mm"}
    other = {"silo": silo | {"outlets": [[[-55, 0], [-15, 0]]]}, "fill": {"level": "150 mm"}}
    load = SiloCase.load
    monkeypatch.setattr(
        study.SiloCase, "load",
        lambda path: dataclasses.replace(
            load(path), outline=SiloCase.resolve({"name": "box", **other}, "box", Path()).outline
        ),
    )  # fmt: skip
    for changes, expected in (({}, 0.035), ({"rules.outlet_eccentricity": "10 mm"}, 0.010)):
        given = {"solid.internal_friction": "30 deg"} | changes
        found = study.study([sampled], None, given)
        rules = found["closed_forms"]["rules"]
        assert rules["outlet_eccentricity"] == pytest.approx(expected, abs=1e-9)
        said = " ".join(in_words(found).split())
        assert f"{expected:.3g} m ({expected / 0.08:.2f} d_c) off the middle" in said
        assert "flow also left and right of the outlet" in said
        for row in found["compared"]:
            both = row["flow_left_pa"] + row["flow_right_pa"]
            assert both / 2 == pytest.approx(row["flow_pa"])


def test_what_is_of_the_runs_in_place_of_the_table_is_said(sampled, monkeypatch):
    """A named solid whose unit weight and friction the runs have: with those of table E.1; and a
    run that clogged, one whose fill is not at rest."""
    measured = loads.measure

    def restless(folder, between, stretch):
        found = measured(folder, between, stretch)
        found["stages"]["at_rest"]["balance"]["inertia_share"] = -0.107
        return found

    monkeypatch.setattr(study.loads, "measure", restless)
    summary = RunFolder(sampled).read_summary()
    monkeypatch.setattr(RunFolder, "read_summary", lambda _: summary | {"outcome": "clogged"})
    found = study.study([sampled], None, {"solid.name": "maize"})
    said = " ".join(in_words(found).split())
    assert "of the runs, not of maize in table E.1: unit weight" in said
    assert "(table: 8)" in said
    assert "accelerates, by -11 % of its weight" in said
    assert "clogged 1 of 1 runs: particles arch over the outlet by their size" in said
    given = {"solid.name": "maize", "solid.unit_weight": "8 kN/m3",
             "solid.internal_friction": "31 deg"}  # fmt: skip
    assert "in table E.1" not in in_words(study.study([sampled], None, given))


def test_case_with_a_silo_in_the_file_of_its_solid_is_refused(tmp_path):
    path = tmp_path / "wheat.toml"
    path.write_text('schema = 1\n[silo]\nwidth = "5 m"\nheight = "9 m"\n[solid]\nname = "wheat"\n')
    assert_refused(silo2d("loads", "A4", "--silo", path, "-o", tmp_path), "the case has its own")
    result = silo2d("loads", "--silo", path, "-o", tmp_path / "out", "--assessment-class", 1)
    assert result.code == 0, result.err
    assert "action assessment class 1" in " ".join(result.out.split())
    assert (tmp_path / "out" / "loads" / "wheat" / "loads.html").exists()


# Janssen by simulation


@pytest.mark.validation
def test_tall_column_of_discs_hangs_on_its_walls(tmp_path):
    """Discs of 6 mm poured in layers of 40 mm with friction between walls 60 mm apart, 0.7 m high:
    vertical stress within 12 % (rms) of Janssen's law with the K and friction that the run
    mobilises, and at the foot less than half of the weight above."""
    (tmp_path / "discs.toml").write_text(
        'schema = 1\nspheroradius = "2.5 mm"\nunit = "mm"\n[[shape]]\nname = "disc"\noutline = '
        "[[3.4641, 0], [1.73205, 3], [-1.73205, 3], [-3.4641, 0], [-1.73205, -3], [1.73205, -3]]\n"
    )
    (tmp_path / "column.toml").write_text(
        'schema = 1\nname = "column"\n[silo]\nangle = "0 deg"\noutlet = "40 mm"\nwidth = "60 mm"\n'
        'height = "720 mm"\n[particles]\nshapes = "discs.toml"\n[law]\nkn = "1e3 N/mm"\n'
        'kt = "700 N/mm"\nmu_particle = 0.3\nmu_wall = 0.4\n[fill]\nlevel = "700 mm"\n'
        'friction = true\nlayer = "40 mm"\n[run]\nmax_time = "20 ms"\n'
    )
    result = protocol.run(SiloCase.load(tmp_path / "column.toml"), out=tmp_path / "runs")
    found = MEASURES.find("janssen").measure(Path(result.run_folder))
    assert found["before_opening_rms_over_janssen"] < 0.12
    assert found["before_opening_wall_friction"] > 0.1
    foot, weight = (found[f"before_opening_bottom_{k}_pa"] for k in ("vertical", "hydrostatic"))
    assert foot < 0.5 * weight
    assert read_trajectory(result.run_folder)["time"][-1] > 0
