"""A door that is drawn: it drags particles by friction, lets them fall at its end, does work."""

import math
import random

import numpy as np
import pytest
from analytic import angular_frequency
from refusals import assert_refused
from scenes import LEVEL, SPHERORADIUS, WOOD, block, mass, position, simulation_of, velocity, wall
from small_silo import DischargeStop, silo2d, the_run, write_case

from granulab.campaign.runs.trajectory import read_trajectory
from granulab.errors import Stopped
from silo2d.case.case import SiloCase
from silo2d.engine import state
from silo2d.run import protocol
from silo2d.run.numbers import energy_closure
from silo2d.view.charts import energy_chart
from silo2d.view.scene import read_scene

G = 9.81
STEP = 4e-6  # [s]
SPEED = 0.5  # of the door [m/s]
FLAT = block(20e-3, 10e-3)
# As in test_motion_on_plane: it sinks in little, and its springs come to rest in milliseconds.
LAW = WOOD._replace(kn=1e6, kt=1e6, gamma_n=3000.0, gamma_t=0.0)


def on_door(law, x=0.3, half_length=0.5):
    """A block at rest on a level door that begins to move to the right."""
    weight = 54.0 * FLAT.area * G
    height = SPHERORADIUS - FLAT.core[:, 1].min() - weight / (2 * law.kn)
    door = wall(half_length=half_length)
    sim = simulation_of(
        [FLAT], [(x, LEVEL + height, 0.0)], walls=[door], law=law, time_step=STEP, gravity=G
    )
    sim.draw_door(0, SPEED)
    return sim


def swing(sim, law) -> float:
    """Speed [m/s] within which springs that take up friction swing: g mu/omega_t."""
    return law.mu * G / angular_frequency(law.kt, mass(sim), 2)


@pytest.mark.parametrize("mu", [0.2, 0.38])
def test_a_particle_on_the_door_is_dragged_to_its_speed(mu):
    """v = mu g t while it slides, then the door's speed (Coulomb). Tolerance: the springs build up
    friction in a swing of mu g/omega_t; once the particle rides, it swings on by as much."""
    law = LAW._replace(mu=mu)
    sim = on_door(law)
    whole = SPEED / (mu * G)
    for share in (0.3, 0.9):
        sim.run(round(share * whole / STEP) - sim.steps)
        assert velocity(sim)[0] == pytest.approx(mu * G * sim.time, abs=2 * swing(sim, law))
    sim.run(round(1.1 * whole / STEP) - sim.steps)
    assert velocity(sim)[0] == pytest.approx(SPEED, abs=2 * swing(sim, law))


def test_the_energy_balance_holds_the_work_of_the_door():
    """While the particle slides the door gives mu m g v t; the particle has m (mu g t)^2/2 of it,
    friction the rest; all energies together stay what they were. Tolerance: the friction builds up
    in a swing of 1/omega_t, a part 1/(omega_t t) of all."""
    law = LAW._replace(mu=0.38)
    sim = on_door(law)
    before = math.fsum(sim.energies().values())
    t = 0.1
    sim.run(round(t / STEP))
    table, m = sim.energies(), mass(sim)
    given = law.mu * m * G * SPEED * t
    late = 2 / (angular_frequency(law.kt, m, 2) * t)
    assert -table["given_to_door"] == pytest.approx(given, rel=late)
    assert table["kinetic"] == pytest.approx(0.5 * m * (law.mu * G * t) ** 2, rel=2 * late)
    friction = given - 0.5 * m * (law.mu * G * t) ** 2
    assert table["friction_grain_wall"] == pytest.approx(friction, rel=2 * late)
    assert math.fsum(table.values()) == pytest.approx(before, abs=1e-4 * given)


def test_the_force_on_the_door_is_the_mean_since_it_was_last_read():
    """The energies take the force of each step out of the sum that wall_forces gives: -mu m g along
    and the weight down."""
    law = LAW._replace(mu=0.38)
    sim = on_door(law)
    sim.run(5000)
    sim.wall_forces()
    sim.run(5000)
    weight = mass(sim) * G
    assert sim.wall_forces()[0] == pytest.approx([-law.mu * weight, -weight], rel=1e-2)


def test_a_particle_falls_where_the_door_ends():
    """Without friction a block rests until the door's end has passed its centroid, then tips over
    that end and falls: x = x0 - h + v t. Tolerance on the way down: the end has 5 mm of edge left
    to pass when the block is half over it, 10 ms in which it does not fall by g t^2/2 = 0.5 mm."""
    sim = on_door(LAW._replace(mu=0.0, gamma_t=0.0), x=0.0, half_length=0.05)
    rest = position(sim)[1]
    sim.run(round(0.095 / SPEED * 0.5 / STEP))  # 2.5 mm before the end is below the centroid
    assert position(sim)[1] == pytest.approx(rest, abs=1e-6)
    assert position(sim)[2] == pytest.approx(0.0, abs=1e-4)
    sim.run(round(0.2 / STEP) - sim.steps)
    assert not sim.door_moves
    assert position(sim)[1] < LEVEL - 20e-3


def test_the_door_is_gone_when_it_has_passed_the_outlet():
    """After outlet/speed, to a step; its length then is what is left."""
    sim = on_door(LAW, x=0.03, half_length=0.05)
    for t in (0.05, 0.15):
        sim.run(round(t / STEP) - sim.steps)
        length = sim.world.bodies.size[1, state.BOUNDING_RADIUS]
        assert length == pytest.approx(0.1 - SPEED * sim.time, abs=1e-12)
    sim.run(round(0.1 / SPEED / STEP) - 2 - sim.steps)
    assert sim.door_moves
    sim.run(4)
    assert not sim.door_moves
    assert not len(sim.touching())


# Whole runs of the small silo, whose outlet of 50 mm is then open after 0.1 s


@pytest.fixture(scope="module")
def drawn(_finished_root, tmp_path_factory):
    """A finished run of the small silo with a door that is drawn."""
    root = tmp_path_factory.mktemp("drawn")
    case = write_case(root, {"run.door_speed": "0.5 m/s"})
    result = silo2d("run", case, "-o", root / "runs", "--no-figures", "--quiet", "--json")
    return result.json, the_run(root / "runs")


def test_the_energy_balance_closes_with_a_moving_door(drawn):
    """As those of a run whose door is gone at once: a few parts in a thousand."""
    result, folder = drawn
    frames = read_trajectory(folder.path)
    assert frames["given_to_door"][-1] < 0
    assert abs(result["energy_closure"]) < 0.01
    unaccounted, _ = energy_closure(frames)
    assert abs(unaccounted).max() < 0.01 * frames["potential"][0]


def test_pictures_have_the_door_where_it_is(drawn, reference):
    """From outlet x/2 = -25 mm at 0.5 m/s to the right lip, in all pictures of frames, and its work
    in the chart; a door that is gone at once is not drawn."""
    scene = read_scene(drawn[1].path)
    for frame, t in enumerate(scene.time):
        expected = [[(-0.025 + 0.5 * t, 0.0), (0.025, 0.0)]] if t < 0.0999 else np.zeros((0, 2, 2))
        np.testing.assert_allclose(scene.door(frame), expected, atol=1e-12)
    assert len(scene.door(0)) > len(scene.door(len(scene.time) - 1))
    held, *_ = energy_chart(scene).axes
    lines = {line.get_label(): line.get_ydata() for line in held.lines}
    given = -scene.trajectory["given_to_door"][-1]
    assert lines["work of the door"][-1] == pytest.approx(given) != 0
    plain = read_scene(reference.path)
    assert not len(plain.door(0))
    held, *_ = energy_chart(plain).axes
    assert "work of the door" not in [line.get_label() for line in held.lines]


def test_times_count_from_the_start_of_the_motion(drawn, reference):
    """Through a door that opens in 0.1 s the first particle leaves later than through one that is
    gone at once, and so do the first ten on average. (The last ones leave as chance has it.)"""
    result, folder = drawn
    assert result["outcome"] == "empty"
    drawn_open, at_once = (
        np.sort(read_trajectory(f.path)["out_time"][-1]) for f in (folder, reference)
    )
    assert drawn_open[0] > at_once[0]
    assert drawn_open[:10].mean() > at_once[:10].mean()
    assert folder.path.name != reference.path.name


def test_a_run_with_a_door_that_moves_goes_on_with_the_same_bits(drawn, tmp_path):
    """Stopped at random looks and gone on with, its lists made again with other skins.

    The heap that rests on the door has more close pairs than one block of the force pass holds:
    the energy balance, too, must not depend on which pairs are listed together.
    """
    case = SiloCase.load(write_case(tmp_path, {"run.door_speed": "0.5 m/s"}))
    chance, stops, result = random.Random(5), 0, None
    stop = DischargeStop(lambda: chance.random() < 0.3)
    while result is None:
        try:
            result = protocol.run(case, out=tmp_path / "runs", progress=stop.progress, stop=stop)
        except Stopped:
            stops += 1
    assert stops >= 5
    assert result.state_digest == drawn[0]["state_digest"]
    frames, others = (read_trajectory(f.path) for f in (the_run(tmp_path / "runs"), drawn[1]))
    for name in frames:
        assert frames[name].tobytes() == others[name].tobytes(), name


@pytest.mark.parametrize(
    ("speed", "words"),
    [
        ("0 m/s", ["[run] door_speed = '0 m/s'", "greater than 0"]),
        ("0.5", ["door_speed = '0.5'", "unit is missing", "0.5 m/s"]),
        (0.5, ["door_speed = 0.5", "unit is missing"]),
    ],
)
def test_a_door_speed_that_cannot_be(speed, words, tmp_path):
    case = write_case(tmp_path, {"run.door_speed": speed})
    assert_refused(silo2d("run", case, "--dry-run"), *words)


def test_a_door_that_is_taken_away_leaves_no_energy_behind():
    """A gate that opens under load: what its contacts held is carried out, and all adds up."""
    height = SPHERORADIUS - FLAT.core[:, 1].min() - 1e-5
    sim = simulation_of([FLAT], [(0.0, LEVEL + height, 0.0)], walls=[wall()], law=LAW,
                        time_step=STEP, gravity=G)  # fmt: skip
    before = sim.energies()
    sim.remove_wall(0)
    after = sim.energies()
    assert before["elastic_normal"] > 0 == after["elastic_normal"]
    assert sum(after.values()) == pytest.approx(sum(before.values()), rel=1e-12)
