"""The contacts kept in a run folder are those of the law, and keeping them changes nothing."""

import numpy as np
import pytest
import scenes
from small_silo import silo2d, the_run, write_case

from granulab.campaign.runs.trajectory import read_tables, read_trajectory
from silo2d.case.case import GRAVITY, SiloCase
from silo2d.engine import state
from silo2d.engine.simulation import Simulation
from silo2d.run.packing import load_packing
from silo2d.run.protocol import settle_under_own_law, world_behind_door

TIME_STEP = 2e-6


def behind_door(reference) -> tuple[SiloCase, Simulation]:
    """The small silo, poured and its door closed."""
    case = SiloCase.load(reference.path / "case.toml")
    (packing,) = reference.path.parent.glob("packings/*/packing.h5")  # locks stand next to it
    return case, Simulation(world_behind_door(case, load_packing(packing.parent)))


def opened(case: SiloCase, sim: Simulation) -> Simulation:
    """Its door gone, under the laws of the discharge."""
    sim.begin_phase(case.particle_law, case.wall_law, case.time_step)
    sim.remove_wall(len(case.outline.walls().names) - 1)
    return sim


def loads(contacts, n_bodies: int, rows) -> np.ndarray:
    """Force [N] and torque [N m] of a moment's contacts on each body (n_bodies, 3)."""
    total = np.zeros((n_bodies, 3))
    for column, sign in ((0, -1), (1, 1)):
        body, force = contacts["bodies"][:, column], sign * contacts["force"]
        arm = contacts["point"] - rows[body][:, [state.X, state.Y]]
        torque = arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]
        np.add.at(total, body, np.column_stack([force, torque]))
    return total


def test_contact_forces_are_mass_times_acceleration(reference):
    """Newton and Euler for every particle, and the load of every wall, at moments of a flow.

    The step takes the same forces, so only rounding is between the two: of sums of ten terms,
    1e-15 of the largest, and of the velocity's difference, 1e-16 of the velocity over the step.
    """
    flowing = opened(*behind_door(reference))
    moving = [state.VX, state.VY, state.OMEGA]
    seen = 0
    for _ in range(8):
        flowing.run(700)
        flowing.wall_forces()
        contacts, live = flowing.contacts(), flowing.live.copy()
        found = loads(contacts, len(flowing.world.bodies.row), flowing.world.bodies.row)
        before, rows = flowing.rows[:, moving].copy(), flowing.rows.copy()
        flowing.run(1)
        gained = (flowing.rows[:, moving] - before) / flowing.world.time_step
        inverse = [state.INV_MASS, state.INV_MASS, state.INV_INERTIA]
        expected = found[: flowing.n_particles] * rows[:, inverse] - [0.0, GRAVITY, 0.0]
        scale = np.abs(contacts["force"]).max() * rows[:, inverse].max(axis=0)
        error = np.abs(gained - expected)[live] / (scale + 1e-3 / TIME_STEP)
        assert error.max() < 1e-11
        walls = found[flowing.n_particles :, :2]
        np.testing.assert_allclose(
            flowing.wall_forces(), walls, rtol=0, atol=1e-12 * np.abs(contacts["force"]).max()
        )
        seen += len(contacts["force"])
        assert np.abs(walls).max() > 0
    assert seen > 200


def test_reading_the_contacts_changes_no_bit(reference):
    """Neither slips nor lists nor loads: the state after is that of a world never sampled."""
    flowing, other = (opened(*behind_door(reference)) for _ in range(2))
    for steps in (1, 3, 10, 100, 1000, 3000):
        flowing.run(steps)
        first, second = flowing.contacts(), flowing.contacts()
        for name, column in first.items():
            assert column.tobytes() == second[name].tobytes()
        other.run(steps)
    assert flowing.state_digest() == other.state_digest()
    assert flowing.world.account.tobytes() == other.world.account.tobytes()
    assert flowing.wall_forces().tobytes() == other.wall_forces().tobytes()


def test_two_pressed_particles():
    """Two blocks face to face, d deep: each of their pairs carries kn d along the normal.

    Eight vertex-edge pairs (spec: two aligned faces), two points, both on the middle plane.
    """
    law = scenes.WOOD._replace(gamma_n=0.0, gamma_t=0.0)
    sim, overlap = scenes.face_to_face(law, TIME_STEP), 1e-6
    sim.rows[0, state.Y] -= overlap
    contacts = sim.contacts()
    assert contacts["bodies"].tolist() == [[0, 1]] * 8
    # Overlaps carry the rounding of coordinates: 1e-17 m of 1e-6 m.
    np.testing.assert_allclose(contacts["overlap"], overlap, rtol=1e-6)
    np.testing.assert_allclose(contacts["force"], [[0, -law.kn * overlap]] * 8, atol=1e-6)
    np.testing.assert_allclose(contacts["normal"], [[0.0, -1.0]] * 8, atol=1e-9)
    middle = sim.rows[:2, state.Y].mean()
    np.testing.assert_allclose(contacts["point"][:, 1], middle, rtol=0, atol=1e-12)
    corner = np.abs(scenes.block(20e-3, 10e-3).core[:, 0]).max()
    np.testing.assert_allclose(np.abs(contacts["point"][:, 0]), corner, rtol=1e-9)
    assert not contacts["slides"].any()


def test_damping_is_part_of_the_force():
    """A disc that approaches a wall at v: f = kn d + m gamma_n v (eqs 2.1, 2.3), on the wall."""
    law, overlap, v = scenes.WOOD, 1e-6, 0.5
    sim = scenes.disc_on_wall(10e-3, law, TIME_STEP, overlap=overlap)
    scenes.launch(sim, vy=-v)
    contacts = sim.contacts()
    force = law.kn * overlap + scenes.mass(sim) * law.gamma_n * v
    assert contacts["bodies"].tolist() == [[0, 1]] * scenes.DISC_CONTACTS
    # The disc's core corners lie 1e-10 m about its middle, 1e-4 of the overlap.
    np.testing.assert_allclose(contacts["force"][:, 1], -force, rtol=1e-4)


def test_a_block_that_slides_says_so():
    """On a slope steeper than its friction both contacts are at the Coulomb limit, and creeping
    dashpots come on top; on a flatter one neither is."""
    law = scenes.WOOD._replace(mu=0.3)
    for angle, slides in ((np.arctan(0.6), True), (np.arctan(0.1), False)):
        shape = scenes.block(20e-3, 10e-3)
        sim = scenes.block_on_wall(shape, law, TIME_STEP, angle=angle, gravity=GRAVITY)
        sim.run(20000)
        contacts = sim.contacts()
        assert len(contacts["slides"]) == 2
        assert (contacts["slides"] == slides).all()
        weight = scenes.mass(sim) * GRAVITY
        pressing = (contacts["force"] * contacts["normal"]).sum()
        assert pressing == pytest.approx(weight * np.cos(angle), rel=1e-3)


def test_first_and_last_frame_have_contacts_and_every_fifth_between(reference):
    """Frames every 10 ms, contacts every 50 ms; the first with the door's, which then is gone."""
    frames, contacts = read_trajectory(reference.path), read_tables(reference.path, "contacts")
    last = len(frames["time"]) - 1
    assert contacts.frame.tolist() == sorted({*range(0, last + 1, 5), last})
    door = len(frames.static["kind"]) + len(frames.static["wall_segments"]) - 1
    assert (contacts.at(0)["bodies"] == door).any()
    assert not any((contacts.at(k)["bodies"] == door).any() for k in range(1, len(contacts)))


def test_kept_contacts_are_those_of_the_moment(reference):
    """Run to the same moments without a folder: the same numbers, rounded to single precision.

    Frame 0 is just before the opening, behind the door and without friction.
    """
    kept = read_tables(reference.path, "contacts")
    case, sim = behind_door(reference)
    settle_under_own_law(sim, case, lambda fraction, text: None)
    moments = [sim.contacts()]
    opened(case, sim).run(round(0.05 / case.time_step))
    moments.append(sim.contacts())
    for k, moment in enumerate(moments):
        assert len(moment["overlap"]) > 5  # a dozen to sixty, while it flows
        for name, column in kept.at(k).items():
            assert column.tobytes() == moment[name].astype(column.dtype).tobytes(), name


def test_kept_columns_are_single_precision(reference):
    """What is kept is small: 37 bytes a contact before compression."""
    columns = read_tables(reference.path, "contacts").columns
    assert {k: str(v.dtype) for k, v in columns.items()} == {
        "bodies": "uint32",
        "point": "float32",
        "force": "float32",
        "normal": "float32",
        "overlap": "float32",
        "slides": "bool",
    }


@pytest.mark.parametrize(("interval", "every"), [("4 ms", 1), ("24 ms", 2), ("1 s", 100)])
def test_contacts_come_at_whole_frames(runs, tmp_path, interval, every):
    """The interval is rounded to frames of 10 ms, and is one frame at least."""
    changes = {"output.contact_interval": interval, "run.max_time": "60 ms"}
    silo2d("run", write_case(tmp_path, changes), "-o", runs, "--no-figures", "--quiet")
    assert read_tables(the_run(runs).path, "contacts").frame.tolist() == sorted(
        {*range(0, 7, every), 6}
    )
