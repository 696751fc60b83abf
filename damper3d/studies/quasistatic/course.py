"""The course of a slow test: the table is pressed on the bed until both rest, then the test.

Samples are taken at fixed numbers of steps. Force and energies of a row are those of its moment or
means since the row before, the walls' displacements those at its end.
"""

import math
import time
from dataclasses import dataclass, field

import numpy as np

from damper3d.studies.quasistatic.case import SAMPLES, TOLERANCE, SlowTest
from damper3d.studies.quasistatic.rig import TABLE, TOP_SIDE, RigSimulation
from granulab.campaign.runs.checkpoint import load_checkpoint, save_checkpoint
from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.protocol import Stop
from granulab.campaign.runs.stages import Stages
from granulab.errors import FolderError, SimulationError, Stopped

WINDOW = 10  # rows of the pre-load over which it must be steady
_PRELOAD_SAMPLE = 1e-3  # [s]
LONGEST_PRELOAD = 1.0  # [s]
_CHECKPOINT_WORK = 2e7  # particles times steps between checkpoints, some ten seconds of work
_UP = np.array([0.0, 0.0, 1.0])

Samples = dict[str, np.ndarray]


@dataclass
class Course:
    """State of a test besides the world, kept in the checkpoint."""

    testing: bool = False  # whether the pre-load is over
    cpu_s: float = 0.0  # CPU time of the step loop
    steps: int = 0  # of both phases
    touch: float = 0.0  # displacement of the table where it met the bed [m]
    preload: Samples = field(default_factory=dict)
    test: Samples = field(default_factory=dict)

    @property
    def rows(self) -> Samples:
        """Rows of the phase that goes on."""
        return self.test if self.testing else self.preload

    @property
    def n_rows(self) -> int:
        """Number of rows of that phase."""
        return len(self.rows.get("time", ()))


def follow(
    sim: RigSimulation, test: SlowTest, course: Course, folder: RunFolder, stages: Stages,
    stop: Stop,
) -> None:  # fmt: skip
    """Go on to the end of the test; the state is kept at times, and before Stopped is raised.

    Raises SimulationError where it fails, or the pre-load does not come to rest.
    """
    if not course.testing and course.n_rows == 0:
        begin_preload(sim, test, course)
    sim.steps_per_sample = steps_per_sample(test, course.testing)
    while not (course.testing and course.n_rows == SAMPLES + 1):
        begun = time.process_time()
        take(course, sim.run(1), sim)
        course.cpu_s += time.process_time() - begun
        course.steps += sim.steps_per_sample
        if not course.testing and is_steady(test, course):
            begin_test(sim, test, course)
        elif not course.testing and sim.time > LONGEST_PRELOAD:
            raise SimulationError(
                f"the pre-load of {test.preload:g} N did not come to rest in {LONGEST_PRELOAD:g} "
                "s; give another --preload"
            )
        report(test, course, stages)
        every = max(int(_CHECKPOINT_WORK / (test.damper.count * sim.steps_per_sample)), 1)
        if stop():
            keep(sim, course, folder)
            raise Stopped("the same command goes on from there")
        if course.n_rows % every == 0:
            keep(sim, course, folder)


def steps_per_sample(test: SlowTest, testing: bool) -> int:
    """Steps from one row to the next."""
    length = test.distance / test.speed / SAMPLES if testing else _PRELOAD_SAMPLE
    return max(math.ceil(length / test.time_step * (1 - 1e-9)), 1)


def begin_preload(sim: RigSimulation, test: SlowTest, course: Course) -> None:
    """Put the table on top of the bed and let the servo press it."""
    course.touch = min(sim.top(_UP) - test.halves.enclosure.height, 0.0)
    sim.put(TABLE, course.touch * _UP)
    sim.hold(TABLE, test.preload, *test.servo)


def is_steady(test: SlowTest, course: Course) -> bool:
    """True where the mean force is the pre-load and the table rests, over the last rows.

    To within TOLERANCE of the pre-load, and of the test's speed.
    """
    rows = course.preload
    if course.n_rows <= WINDOW:
        return False
    force = rows["wall_force"][-WINDOW:, TABLE, 2].mean()
    height, when = rows["place"][-WINDOW - 1 :, TABLE, 2], rows["time"][-WINDOW - 1 :]
    speed = abs(height[-1] - height[0]) / (when[-1] - when[0])
    return bool(
        abs(force - test.preload) <= TOLERANCE * test.preload and speed <= TOLERANCE * test.speed
    )


def begin_test(sim: RigSimulation, test: SlowTest, course: Course) -> None:
    """Let the top half move sideways with the table, or the table down without its servo."""
    above = test.halves.gap + test.halves.height + sim.place[TABLE, 2]
    least = test.distance if test.kind == "compress" else 0.0
    if above <= least:
        raise SimulationError(
            f"the table came to {1e3 * above:.3g} mm above the rim of the top half, and must stay "
            f"more than {1e3 * least:.3g} mm above it; give more particles, or larger ones"
        )
    sim.begin_phase()
    if test.kind == "shear":
        along = np.array([test.speed, 0.0, 0.0])
        sim.drive({TOP_SIDE: along, TABLE: along})
    else:
        sim.let_go()
        sim.drive({TABLE: -test.speed * _UP})
    course.testing = True
    sim.steps_per_sample = steps_per_sample(test, True)
    take(course, sim.sample(), sim)


def take(course: Course, rows: Samples, sim: RigSimulation) -> None:
    """Append a row."""
    row = {**rows, "place": sim.place[None]}
    for name, value in row.items():
        before = course.rows.get(name)
        course.rows[name] = value if before is None else np.concatenate([before, value])


def report(test: SlowTest, course: Course, stages: Stages) -> None:
    """Report how far the test is; of the pre-load the part of the longest time that it may take."""
    if course.testing:
        stages.hedge = ""
        stages.finish("pre-load")
        done = (course.n_rows - 1) / SAMPLES
        words = f"{test.kind}, {1e3 * done * test.distance:.3g} mm"
        stages.report("testing", done, 1.0 - done, words)
    else:
        stages.hedge = " at most"
        longest = LONGEST_PRELOAD / _PRELOAD_SAMPLE
        words = f"{course.n_rows} ms"
        stages.report("pre-load", course.n_rows, max(longest - course.n_rows, 1.0), words)


_ARRAYS = ("preload", "test")


def keep(sim: RigSimulation, course: Course, folder: RunFolder) -> None:
    """Write the checkpoint."""
    rows = {f"{p}/{k}": v for p in _ARRAYS for k, v in getattr(course, p).items()}
    meta = {name: getattr(course, name) for name in ("testing", "cpu_s", "steps", "touch")}
    save_checkpoint(folder.checkpoint, {**sim.save(), **rows}, meta)


def go_on(sim: RigSimulation, folder: RunFolder) -> Course:
    """The course of the checkpoint, whose state the simulation takes; a new one if there is none.

    Raises FolderError where the checkpoint does not fit.
    """
    if not folder.checkpoint.exists():
        return Course()
    saved, meta = load_checkpoint(folder.checkpoint)
    try:
        course = Course(**meta)
        for phase in _ARRAYS:
            rows = getattr(course, phase)
            for name in [n for n in saved if n.startswith(f"{phase}/")]:
                rows[name.removeprefix(f"{phase}/")] = saved.pop(name)
        sim.restore(saved)
    except (IndexError, KeyError, TypeError, ValueError) as error:
        raise FolderError(
            f"{folder.checkpoint}: does not fit this test ({error}); delete it and the test starts "
            "from its pre-load"
        ) from None
    return course
