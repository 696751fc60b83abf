"""What is taken from a damper's samples and frames, whatever the direction of the motion."""

import numpy as np
import pytest
from small_damper import CASE

from damper3d.case.case import DamperCase
from damper3d.measures.phases.criteria import classify
from damper3d.measures.phases.motion import Motion, spheres_around, take
from damper3d.measures.phases.motion_measures import measure_motion

BOX = {
    **CASE,
    "enclosure.diameter": None,
    "enclosure.shape": "box",
    "enclosure.width": "20 mm",
    "enclosure.depth": "20 mm",
    "enclosure.height": "20 mm",
    "particles.count": 8,
}
MIDDLE = np.array([0.0, 0.0, 0.01])
ALONG_X = {"motion.direction": [1.0, 0.0, 0.0], "motion.gravity": [-1.0, 0.0, 0.0]}


def box(**changes: object) -> DamperCase:
    """The small damper with 8 particles in a cube of 20 mm."""
    given = {key: value for key, value in {**BOX, **changes}.items() if value is not None}
    return DamperCase.load("thesis", given)


def made_up(case: DamperCase, seed: int = 1) -> tuple[dict, dict]:
    """Samples and frames of a run that nobody computed, moving along z; walls: as the box has."""
    rng = np.random.default_rng(seed)
    output, cycles = case.settings.output, case.settings.run.cycles
    time = np.arange(cycles * output.samples + 1) * case.period / output.samples
    omega = 2.0 * np.pi / case.period
    n = len(time)
    outwards = np.zeros((len(case.wall_names), 3))
    outwards[: len(case.enclosure.planes)] = -5.0 * case.enclosure.planes[:, :3]
    samples = {
        "time": time,
        "displacement": case.amplitude * np.sin(omega * time),
        "velocity": case.peak_speed * np.cos(omega * time),
        "wall_force": rng.normal(size=(n, len(case.wall_names), 3)) + outwards,
        "mean_position": rng.uniform(0.0, 0.005, (n, 3)) + MIDDLE,
        "mean_velocity": rng.normal(size=(n, 3)),
    }
    row = np.arange(0, n, output.samples // output.frames)
    spot = rng.uniform(-0.007, 0.007, (len(row), case.count, 3)) + MIDDLE
    v, share = 0.1 * rng.normal(size=spot.shape), rng.uniform(size=len(row))
    frames = {"row": row, "x": spot, "v": v, "touching": share}
    return samples, {**frames, **spheres_around(case)}


def along_x(samples: dict, frames: dict) -> tuple[dict, dict]:
    """The same run rotated so that z becomes x; bottom and top swap with left and right."""

    def turned(vectors: np.ndarray) -> np.ndarray:  # about the middle of the cube
        return np.stack([vectors[..., 2], -vectors[..., 1], vectors[..., 0]], axis=-1)

    moved = {
        **samples,
        "wall_force": turned(samples["wall_force"])[:, [2, 3, 0, 1, 5, 4]],
        "mean_position": turned(samples["mean_position"] - MIDDLE) + MIDDLE,
        "mean_velocity": turned(samples["mean_velocity"]),
    }
    x = turned(frames["x"] - MIDDLE) + MIDDLE
    return moved, {**frames, "x": x, "v": turned(frames["v"])}


def taken(case: DamperCase, samples: dict, frames: dict) -> Motion:
    motion = take(case, samples, frames)
    assert motion is not None
    return motion


def test_a_motion_along_x_is_the_same_as_one_along_z():
    """Frame indifference: box, gravity and all vectors turned together give the same numbers."""
    case = box()
    samples, frames = made_up(case)
    upright = measure_motion(taken(case, samples, frames))
    turned = measure_motion(taken(box(**ALONG_X), *along_x(samples, frames)))
    assert turned == pytest.approx(upright, rel=1e-9)


def test_the_push_of_an_end_is_what_it_gives_to_the_bed():
    """The bottom pushed down by 3 N pushes the bed up by 3 N; the top likewise down."""
    case = box()
    samples, frames = made_up(case)
    samples["wall_force"][:] = 0.0
    names = case.wall_names
    samples["wall_force"][:, names.index("bottom"), 2] = -3.0
    samples["wall_force"][:, names.index("top"), 2] = 2.0
    push = taken(case, samples, frames).push
    assert (push[:, :, 0] == 3.0).all()
    assert (push[:, :, 1] == 2.0).all()


def test_the_first_cycles_do_not_count():
    """4 cycles of which 2 are discarded: 100 samples, 20 frames and the one before them."""
    case = box()
    motion = taken(case, *made_up(case))
    assert motion.push.shape == (2, 50, 2)
    assert len(motion.x) == 21
    assert motion.n == 10
    # The displacement is nought where the first counted cycle begins.
    assert motion.displacement[0] == pytest.approx(0.0, abs=1e-12 * case.amplitude + 1e-15)


@pytest.mark.parametrize(
    "changes", [{"run.discard": 4, "run.cycles": 5, "output.frames": 5}, {"output.frames": 5}]
)
def test_too_few_frames_give_no_phase(changes):
    """Fewer than eight frames a cycle: a particle could go to and fro unseen."""
    case = box(**changes)
    assert take(case, *made_up(case)) is None


@pytest.mark.parametrize(
    ("gravity", "orientation"),
    [
        ([0.0, 0.0, -1.0], "vertical"),
        ([-1.0, 0.0, 0.0], "horizontal"),
        ([0.6, 0.0, 0.8], "vertical"),
    ],
)
def test_orientation_is_how_gravity_points_to_the_motion(gravity, orientation):
    """Nearer to the axis of the motion than to the plane across it: vertical."""
    case = box(**{"motion.gravity": gravity})
    assert taken(case, *made_up(case)).orientation == orientation


def test_without_gravity_the_horizontal_names_serve():
    case = box(**{"motion.orientation": "none"})
    motion = taken(case, *made_up(case))
    assert motion.orientation == "none"
    measures = measure_motion(motion)
    assert classify(measures, "none").name == classify(measures, "horizontal").name


CELLS = {"enclosure.cells": [2, 2], "enclosure.cell_wall": "1 mm", "particles.count": 32}


@pytest.mark.parametrize("direction", [{}, ALONG_X])
def test_cells_have_the_phases_of_one_of_them(direction):
    """The same motion in each of four cells, whose particles are no neighbours of the others'."""
    one = box(**direction)
    four = box(**direction, **CELLS)
    samples, frames = made_up(one)
    cells = np.column_stack([four.enclosure.cells, np.zeros(4)])
    spread = {
        "row": frames["row"],
        "x": np.concatenate([frames["x"] + at for at in cells], axis=1),
        "v": np.concatenate([frames["v"]] * 4, axis=1),
        "touching": frames["touching"],
        **spheres_around(four),
    }
    alone = measure_motion(taken(one, samples, frames))
    fourfold = {**samples, "wall_force": 4.0 * samples["wall_force"]}
    found = measure_motion(taken(four, fourfold, spread))
    for name in ("hot_low", "hot_high", "floor_gap_least", "floor_gap_largest"):
        del alone[name], found[name]  # by ranks, which so few particles divide otherwise
    assert found == pytest.approx(alone, rel=1e-9)


FUNNEL = {"enclosure.width": None, "enclosure.depth": None, "enclosure.shape": "frustum",
          "enclosure.diameter": "4 mm", "enclosure.top_diameter": "40 mm",
          "enclosure.height": "15 mm", "particles.shape": "sphere:1mm"}  # fmt: skip


@pytest.mark.parametrize(
    ("changes", "forces", "pushes"),
    [  # on the walls, outwards [N]
        ({}, {"bottom": (0, 0, -3), "top": (0, 0, 5)}, (3, 5)),
        (ALONG_X, {"left": (-3, 0, 0), "right": (5, 0, 0), "bottom": (0.2, 0, -9)}, (3, 5)),
        (ALONG_X | CELLS,
         {"left": (-3, 0, 0), "right": (5, 0, 0), "bottom": (0.2, 0, -9)}, (3, 5)),
        (FUNNEL, {"bottom": (0, 0, -3), "side": (1, 0, -5), "top": (0, 0, 2)}, (8, 2)),
        (FUNNEL | {"enclosure.height": "80 mm"},
         {"bottom": (0, 0, -3), "side": (1, 0, -5)}, (3, 0)),
        (ALONG_X | {"enclosure.shape": "cylinder", "enclosure.diameter": "20 mm",
                    "enclosure.width": None, "enclosure.depth": None},
         {"side": (-3, 0, 0), "bottom": (0.2, 0, -9)}, (3, 0)),
    ],
)  # fmt: skip
def test_an_end_is_every_wall_that_faces_the_motion(changes, forces, pushes):
    """Also curved ones: the sides of cells, and a funnel's, which is flatter than 45 degrees."""
    case = box(**changes)
    samples, frames = made_up(case)
    force = np.zeros_like(samples["wall_force"])
    for name, vector in forces.items():
        force[:, case.enclosure.wall_names.index(name)] = vector
    motion = taken(case, {**samples, "wall_force": force}, frames)
    assert motion.push.reshape(-1, 2) == pytest.approx(np.tile(pushes, (motion.push.size // 2, 1)))
