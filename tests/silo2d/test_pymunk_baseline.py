"""pymunk as an engine: closed forms, momentum, and the contact law's results within a distance."""

import dataclasses
import json
import math
import shutil
import signal

import numpy as np
import pytest
from forking import Forked
from heaps import small_case
from hypothesis import given
from hypothesis import strategies as st
from same_run import assert_same_run
from scenes import SURFACE_DENSITY, block, disc
from small_silo import DRY, DischargeStop, finish, silo2d, start, the_run, write_case

from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.trajectory import read_trajectory
from granulab.errors import SimulationError, Stopped
from silo2d.baseline import discharge as pymunk_baseline
from silo2d.baseline.discharge import Baseline
from silo2d.baseline.space import Surface, add_particle, add_walls, empty_space
from silo2d.case.case import GRAVITY, SiloCase
from silo2d.case.impulses import factors
from silo2d.run import protocol
from silo2d.run.numbers import discharge_curve
from silo2d.run.packing import Packing
from silo2d.run.protocol import run_digest
from silo2d.view.compare import compare

STEP = 2.5e-4  # [s]
MU, E = (0.38, 0.44), (0.45, 0.53)  # particle-particle and particle-wall
FLOOR = np.array([[[-1.0, 0.0], [1.0, 0.0]]])
FLAT = block(20e-3, 10e-3)
PYMUNK = {"run.engine": "pymunk"}


def space_with_floor(mu=MU, e=(0.0, 0.0), gravity=(0.0, -GRAVITY)):
    """A space over a floor at y = 0, and what its particles have."""
    friction, elasticity = factors(*mu), factors(*e)
    space = empty_space(iterations=30, slop=1e-5)
    space.gravity = gravity
    add_walls(space, FLOOR, Surface(friction[1], elasticity[1]))
    return space, Surface(friction[0], elasticity[0])


def put(space, shape, pose, surface):
    return add_particle(space, shape, SURFACE_DENSITY, pose, surface).body


# The laws


@given(st.floats(0, 2), st.floats(0, 2))
def test_products_of_the_factors_are_the_pairs(particle_particle, particle_wall):
    """Within rounding; a particle-particle value below 1e-12 counts as that."""
    particle, wall = factors(particle_particle, particle_wall)
    assert particle * particle == pytest.approx(particle_particle, rel=1e-14, abs=1.1e-12)
    assert particle * wall == pytest.approx(particle_wall, rel=1e-14)


def test_pymunk_takes_the_pairs_friction_and_restitution():
    """As it reports them of the contacts: a particle on a particle on the floor."""
    space, surface = space_with_floor(e=E)
    lower = put(space, FLAT, [0.0, 5e-3, 0.0], surface)
    put(space, FLAT, [0.0, 15e-3, 0.0], surface)
    space.step(STEP)
    found = {}

    def note(arbiter):
        a_wall = space.static_body in arbiter.bodies or any(
            body.body_type == body.STATIC for body in arbiter.bodies
        )
        found["wall" if a_wall else "grain"] = arbiter.friction, arbiter.restitution

    lower.each_arbiter(note)
    assert found["grain"] == pytest.approx((MU[0], E[0]), rel=1e-12)
    assert found["wall"] == pytest.approx((MU[1], E[1]), rel=1e-12)


def test_mass_and_moment_are_those_of_the_rounded_outline():
    """Not those that pymunk would find for the core."""
    space, surface = space_with_floor()
    body = put(space, FLAT, [0.0, 0.1, 0.3], surface)
    assert body.mass == pytest.approx(SURFACE_DENSITY * FLAT.area)
    assert body.moment == pytest.approx(SURFACE_DENSITY * FLAT.polar_moment)


def test_free_fall():
    """v = g t; a step moves by the velocity before it, so y = g t (t - dt)/2."""
    space, surface = space_with_floor()
    body = put(space, FLAT, [0.0, 1.0, 0.0], surface)
    for _ in range(1000):
        space.step(STEP)
    t = 1000 * STEP
    assert -body.velocity.y == pytest.approx(GRAVITY * t, rel=1e-12)
    assert 1.0 - body.position.y == pytest.approx(GRAVITY * t * (t - STEP) / 2, rel=1e-12)


@pytest.mark.parametrize("degrees", [25, 30, 40])
def test_a_block_slides_down_a_wall_and_another_block(degrees):
    """v = g (sin a - mu cos a) t with the mu of each pair, in tilted gravity.

    On the wall with mu_gw; on a plate that sticks to the wall (mu_gw above tan a) with mu_gg.
    Friction is capped by the normal impulse found so far: the first steps, in which that is not
    found yet, and where the front corner carries more than the rear one, leave 1 %.
    """
    a = math.radians(degrees)
    downhill = GRAVITY * math.sin(a), -GRAVITY * math.cos(a)
    t = 0.1
    for mu, on_plate in ((MU, False), ((MU[0], 1.2), True)):
        space, surface = space_with_floor(mu, gravity=downhill)
        base = 0.0
        if on_plate:
            plate = put(space, block(0.6, 20e-3), [0.0, 10e-3, 0.0], surface)
            base = 20e-3
        body = put(space, FLAT, [0.0, base + 5e-3, 0.0], surface)
        for _ in range(round(t / STEP)):
            space.step(STEP)
        acceleration = GRAVITY * (math.sin(a) - mu[0 if on_plate else 1] * math.cos(a))
        expected = acceleration * t
        assert body.velocity.x == pytest.approx(expected, rel=0.01)
        assert abs(body.angular_velocity) < 0.1
        if on_plate:
            assert plate.velocity.length < 1e-3 * expected


@pytest.mark.parametrize("degrees", [5, 15])
def test_a_block_sticks_below_the_angle_of_friction(degrees):
    """tan a < mu: it stays, where the contact law's spring would give way a little."""
    a = math.radians(degrees)
    space, surface = space_with_floor(gravity=(GRAVITY * math.sin(a), -GRAVITY * math.cos(a)))
    body = put(space, FLAT, [0.0, 5e-3, 0.0], surface)
    for _ in range(400):
        space.step(STEP)
    assert body.velocity.length < 1e-3 * GRAVITY * math.sin(a) * 400 * STEP


@pytest.mark.parametrize("shape", [disc(5e-3), FLAT], ids=["disc", "face"])
@pytest.mark.parametrize("speed", [0.1, 1.0])
def test_restitution_is_the_pairs_whatever_touches(shape, speed):
    """v' = e v for one contact and for a whole face, as the contact law's is not (0.79, 0.52).

    30 iterations between the two ends of a face leave less than 1e-3.
    """
    space, surface = space_with_floor(e=E, gravity=(0.0, 0.0))
    body = put(space, shape, [0.0, 6e-3, 0.0], surface)
    body.velocity = 0.0, -speed
    left, right = (put(space, shape, [x, 0.2, math.pi / 2], surface) for x in (-6e-3, 6e-3))
    left.velocity, right.velocity = (speed, 0.0), (-speed, 0.0)
    for _ in range(math.ceil(3e-3 / (speed * STEP))):
        space.step(STEP)
    assert body.velocity.y == pytest.approx(E[1] * speed, rel=1e-3)
    assert right.velocity.x - left.velocity.x == pytest.approx(E[0] * 2 * speed, rel=1e-3)


# A heap


@pytest.fixture
def heap(runs, tmp_path) -> tuple[SiloCase, Baseline]:
    """The small silo's packing in pymunk, the door closed."""
    case = SiloCase.load(write_case(tmp_path), PYMUNK)
    packing = protocol.get_packing(case, runs, lambda fraction, text: None)
    return case, Baseline(case, packing)


def test_walls_carry_what_the_momentum_balance_requires(heap):
    """Impulse on walls and door = weight t - change of momentum, to rounding, also in flow.

    The first sum is of pymunk's contacts, the second of its bodies. While particles rest, the mean
    over 0.1 s is the weight within 2 %.
    """
    _case, sim = heap

    def momentum():
        return sim.mass @ sim.motion[:, [3, 4]]

    sim.run(100)
    for phase in ("closed", "open"):
        sim.wall_forces()
        before, steps = momentum(), 400 if phase == "closed" else 60
        sim.run(steps)
        impulse = sim.wall_forces().sum(axis=0) * steps * STEP
        weight = GRAVITY * sim.mass.sum() * steps * STEP
        expected = np.array([0.0, -weight]) - (momentum() - before)
        np.testing.assert_allclose(impulse, expected, atol=1e-9 * weight)
        if phase == "closed":
            np.testing.assert_allclose(impulse, [0.0, -weight], atol=0.02 * weight)
            sim.open_door()
    assert len(sim.live) == sim.n_particles  # one that was dropped would have taken momentum along


def test_it_starts_where_the_contact_law_starts(reference, runs, tmp_path):
    """The same particles; the two ways to settle behind the door move none by a spheroradius."""
    case = write_case(tmp_path)
    arguments = ["--no-figures", "--json", "--quiet", "--engine", "pymunk"]
    table = silo2d("run", case, "-o", runs, *arguments).json
    found = compare(reference.path, table["run_folder"])
    assert found["start_offset_m"] < 0.5e-3


def test_a_lost_particle_is_an_error(heap):
    """One that has passed a wall would fall for ever; the message says what to do."""
    case, sim = heap
    sim._particles[3].body.position = case.outline.width, 0.02
    with pytest.raises(
        SimulationError, match=r"lost 1 particles at t = .* shorter \[pymunk\] time"
    ):
        sim.run(1)


def test_a_particle_is_out_when_its_centroid_passes_the_outlet(tmp_path):
    """In free fall y = y0 - g t (t - dt)/2 at the steps, and on the chord between two of them: the
    step moves a particle by the velocity before it. Tolerance: rounding."""
    case, height = small_case(tmp_path, PYMUNK), 0.05
    kinds, poses = np.zeros(1, dtype=int), np.array([[0.0, height, 0.0]])
    sim = Baseline(case, Packing(kinds, poses, 0.0, 0.0, "by hand", 0.0))
    sim.open_door()
    sim.run(500)
    t = STEP * np.arange(501)
    y = height - GRAVITY * t * (t - STEP) / 2
    last = int(np.argmax(y < 0)) - 1
    expected = t[last] + STEP * y[last] / (y[last] - y[last + 1])
    assert sim.out_time[0] == pytest.approx(expected, abs=1e-12)


def test_without_friction_between_particles_walls_may_have_some(tmp_path):
    """mu_gg = 0 has no factor for mu_gw; 1e-12 stands for it."""
    case = small_case(tmp_path, {**PYMUNK, "law.mu_particle": 0.0, "law.mu_wall": 0.4})
    kinds, poses = np.zeros(1, dtype=int), np.array([[0.0, 0.05, 0.0]])
    sim = Baseline(case, Packing(kinds, poses, 0.0, 0.0, "by hand", 0.0))
    sim.open_door()
    particle, wall = sim._particles[0].shape.friction, sim._walls[0].shape.friction
    assert particle * wall == pytest.approx(0.4)
    assert particle * particle < 1e-11


# Runs


def run_quietly(case, root) -> RunFolder:
    """The run by pymunk of a case in a folder that has its packing."""
    result = silo2d("run", case, "-o", root, "--engine", "pymunk", "--no-figures", "--quiet")
    assert (result.code, result.err) == (0, "")
    return the_run(root)


@pytest.fixture(scope="module")
def finished_pymunk(_finished_root, tmp_path_factory) -> RunFolder:
    """A finished run by pymunk of the small silo, seed 1; to be read only."""
    folder = tmp_path_factory.mktemp("pymunk")
    shutil.copytree(_finished_root / "runs" / "packings", folder / "runs" / "packings")
    return run_quietly(write_case(folder), folder / "runs")


def test_it_empties_as_the_contact_law_does(reference, finished_pymunk):
    """The same outcome; the first seven particles within 2 ms; curves within 15 % of the time.

    The first seven leave before chance takes over: 30, 31 and 32 iterations gave them within 0.7 ms
    of the contact law's, another processor, whose bed is another, within 1.7 ms; without friction
    between particles it was 3.5 ms, at walls 5.6 ms, without any 10 ms. After that a silo of 67
    particles is chaotic: the same three left the curves 0.037, 0.011 and 0.014 s apart in the mean,
    where 15 % are 0.048 s.
    """
    law, own = reference.read_summary(), finished_pymunk.read_summary()
    assert own["outcome"] == law["outcome"] == "empty"
    assert own["n_out"] == law["n_out"]
    found = compare(reference.path, finished_pymunk.path)
    apart, folders = found["curve"], [row["run_folder"] for row in found["runs"]]
    assert apart["counts"] == law["n_out"]
    assert 0 < apart["mean_s"] < 0.15 * law["discharge_time_s"]
    times = [discharge_curve(read_trajectory(folder))[0][:7] for folder in folders]
    np.testing.assert_allclose(times[1], times[0], rtol=0, atol=2e-3)


def test_the_results_have_the_same_fields_and_none_that_impulses_do_not_give(
    reference, finished_pymunk
):
    """No energy balance, so no closure; the restitution is the one given."""
    law, own = reference.read_summary(), finished_pymunk.read_summary()
    assert own.keys() == law.keys()
    assert own["engine"] == "pymunk"
    assert own["energy_closure"] is None
    assert own["dissipated_j"] == dict.fromkeys(law["dissipated_j"])
    assert own["time_step_s"] == STEP
    assert own["restitution"]["particle_particle"] == {"one_contact": 0.45, "face_to_face": 0.45}
    assert own["packing_fraction"] == law["packing_fraction"]
    frames = read_trajectory(finished_pymunk.path)
    assert set(frames) < set(read_trajectory(reference.path))
    energy = frames["kinetic"] + frames["potential"] + frames["carried_out"]
    # Impulses only take; pushing overlaps of some um apart may lift by that.
    assert (np.diff(energy) < 1e-3 * np.ptp(energy)).all()
    assert energy[-1] < energy[0]


def test_it_clogs_where_the_contact_law_clogs(tmp_path):
    """Over 12 mm particles of 5 to 10 mm stand at once (test_outcome.py has the contact law)."""
    narrow = {"silo.outlet": "12 mm", "silo.width": "70 mm", "silo.height": "60 mm"}
    rough = {"law.mu_particle": 0.4, "law.mu_wall": 0.4, "fill.level": "40 mm"}
    case = write_case(tmp_path, {**narrow, **rough, **PYMUNK})
    table = silo2d("run", case, "-o", tmp_path, "--no-figures", "--quiet", "--json").json
    assert table["outcome"] == "clogged_at_opening"
    assert table["discharge_time_s"] is None


def test_figures_and_report_say_what_is_not_known(finished_pymunk, tmp_path):
    """The chart of energy has no mechanisms; the headline names the engine."""
    from silo2d.view.charts import energy_chart
    from silo2d.view.scene import read_scene

    scene = read_scene(finished_pymunk.path)
    assert scene.headline.startswith("Silo small, pymunk: empty after")
    figure = energy_chart(scene)
    assert [axes.get_ylabel() for axes in figure.axes] == ["particles inside [J]", "lost [J]"]
    assert "impulses have no energy balance" in silo2d("show", finished_pymunk.path).out


def test_the_same_bits_again_and_none_twice(finished_pymunk, runs, tmp_path):
    """In another folder, and by another process; requested again, the result that is there."""
    case = write_case(tmp_path)
    assert_same_run(run_quietly(case, runs), finished_pymunk)
    arguments = ["run", case, "-o", runs, "--engine", "pymunk", "--json", "--quiet", "--no-figures"]
    assert silo2d(*arguments).json["reused"]
    fresh = Forked(silo2d, *arguments, "--again").finish().json
    assert not fresh["reused"]
    assert fresh["state_digest"] == finished_pymunk.read_summary()["state_digest"]


def test_a_run_that_is_stopped_starts_from_the_opening(finished_pymunk, runs, tmp_path):
    """Its frames can be drawn; the second time the bits are those of an uninterrupted run."""
    case = SiloCase.load(write_case(tmp_path), PYMUNK)
    looks = iter(range(20))
    stop = DischargeStop(lambda: next(looks) == 12)
    with pytest.raises(Stopped, match="runs it again, from the opening"):
        protocol.run(case, out=runs, progress=stop.progress, stop=stop)
    assert len(read_trajectory(the_run(runs).path)["time"]) > 10
    result = protocol.resume(the_run(runs).path)
    assert not result.reused
    assert_same_run(the_run(runs), finished_pymunk)


def test_ctrl_c_ends_with_one_line(runs, tmp_path):
    """Exit code 130. Many iterations in short steps take long enough to be interrupted."""
    slow = ["--iterations", 300, "--pymunk-time-step", "0.05 ms"]
    case = write_case(tmp_path)
    process = start("run", case, "-o", runs, "--engine", "pymunk", "--no-figures", *slow)
    for line in process.stderr:
        if "out" in line and "t =" in line:
            break
    process.send_signal(signal.SIGINT)
    result = finish(process)
    assert result.code == 130
    assert "runs it again, from the opening" in result.err
    assert "Traceback" not in result.err


# Settings


def test_settings_of_pymunk_name_its_runs_and_no_others():
    """A run of the contact law keeps its folder, whatever stands in [pymunk]."""
    usual = run_digest(SiloCase.load("A4"))
    changes = [
        {"pymunk.iterations": 10},
        {"pymunk.time_step": "0.5 ms"},
        {"pymunk.restitution": "none"},
        {},
    ]
    assert {run_digest(SiloCase.load("A4", change)) for change in changes} == {usual}
    names = {run_digest(SiloCase.load("A4", {**change, **PYMUNK})) for change in changes}
    assert len(names | {usual}) == 5


def test_a_case_gives_pymunk_the_pairs():
    """Table 4's friction, and the restitution of Tables 2 and 3 as measured."""
    given = SiloCase.load("A4", PYMUNK).impulses
    assert given is not None
    assert (given.iterations, given.time_step) == (30, STEP)
    assert given.friction == (0.38, 0.44)
    assert given.restitution == (0.45, 0.53)
    assert SiloCase.load("A4").impulses is None
    plastic = SiloCase.load("A4", {**PYMUNK, "pymunk.restitution": "none", "law.mu_wall": 0.2})
    assert plastic.impulses is not None
    assert dataclasses.asdict(plastic.impulses) | {"friction": (0.38, 0.2), "restitution": (0, 0)} \
        == dataclasses.asdict(plastic.impulses)  # fmt: skip


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--engine", "bullet"], ["engine", "'bullet'", "'dem' or 'pymunk'"]),
        (["--engine", "pymunk", "--iterations", "0"], ["iterations = 0", "1"]),
        (["--engine", "pymunk", "--iterations", "many"], ["iterations", "'many'", "whole number"]),
        (["--engine", "pymunk", "--pymunk-time-step", "2 ms"],
         ["[pymunk] time_step = 2 ms", "1.3 m/s", "at most 2"]),
        (["--engine", "pymunk", "--disorder", "pair", "--time-step", "1 us"],
         ["[disorder] per", "engine = 'dem'"]),
        (["--engine", "pymunk", "--door-speed", "1 m/s"], ["door_speed", "engine = 'dem'"]),
        (["--engine", "pymunk", "--pymunk-time-step", "0 ms"], ["time_step", "greater than 0"]),
        (["--engine", "pymunk", "--pymunk-time-step", "3"], ["time_step", "unit"]),
    ],
)  # fmt: skip
def test_bad_settings_are_refused_in_one_line(options, words, tmp_path):
    """With the key, what was given and what would do."""
    result = silo2d("run", write_case(tmp_path), "-o", tmp_path / "runs", *options)
    assert result.code == 2
    assert result.out == ""
    assert len(result.err.splitlines()) == 1
    for word in words:
        assert word in result.err
    assert not (tmp_path / "runs").exists()


def test_dry_run_says_what_pymunk_is_given():
    """Iterations, step, what is left out of the law; a number of steps of its own."""
    said = silo2d("run", "A4", "--engine", "pymunk", "--iterations", 10, *DRY).out
    for words in (
        "10 iterations in steps of 0.00025 s",
        "overlaps of 1e-05 m",
        "0.45 face to face",
    ):
        assert words in said
    plan = json.loads(silo2d("run", "A4", "--engine", "pymunk", *DRY, "--json").out)
    assert (plan["engine"], plan["steps_at_most"]) == ("pymunk", 24000)


def test_a_warm_up_carries_the_weight(heap):
    """Without it the first impulses start from nothing, and the heap falls for some steps."""
    _case, sim = heap
    steps = round(pymunk_baseline._WARM_UP / STEP)
    sim.run(steps - 10)
    sim.wall_forces()
    sim.run(10)
    weight = GRAVITY * sim.mass.sum()
    assert -sim.wall_forces()[:, 1].sum() == pytest.approx(weight, rel=0.1)
