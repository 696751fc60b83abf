"""A slow test in its run folder: the packing, the course, the results; and many of them."""

import dataclasses
import math
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Any

from damper3d.engine import ENGINE
from damper3d.run.fill import packed, random_start, world_of
from damper3d.run.packing import Packing, load_packing, save_packing
from damper3d.run.protocol import PACKAGES
from damper3d.run.sources import SOURCES as OF_RUNS
from damper3d.run.vibration import MOST_UNACCOUNTED
from damper3d.studies.quasistatic.case import SAMPLES, SlowTest
from damper3d.studies.quasistatic.course import (
    LONGEST_PRELOAD,
    follow,
    go_on,
    steps_per_sample,
)
from damper3d.studies.quasistatic.measure import Result, summary
from damper3d.studies.quasistatic.rig import RigSimulation
from granulab.campaign.runs.folder import RunFolder, digest
from granulab.campaign.runs.protocol import (
    Progress,
    Runs,
    Stop,
    damaged,
    kept,
    packing_sources,
)
from granulab.campaign.runs.provenance import Warn
from granulab.campaign.runs.sharing import once
from granulab.campaign.runs.stages import Stages
from granulab.campaign.sweeps.sweep import Simulator, Task, run_or_pack, silent
from granulab.contact.jit import cache_folder
from granulab.errors import Stopped

SOURCES = OF_RUNS.plus(Path(__file__).parent)  # of a slow test and of its packing
_COMPILED = "quasistatic-compiled"  # file that says that the kernels of these walls are
_LOOK = 1e-3  # [s] of simulated time between reports
# Of a particle and step of a bed at rest under load, on a server of 2023 [s]: 100 spheres
# took 15 us, 100 particles of 50 sub-spheres 23 to 63.
_OF_A_PARTICLE, _OF_A_SUB_SPHERE = 1.5e-7, 5.5e-9


def run_digest(test: SlowTest) -> str:
    """Names a run: its case and seed."""
    return digest(test.identity())


def _compute(
    folder: RunFolder, test: SlowTest, stages: Stages, stop: Stop, warn: Warn
) -> dict[str, Any]:
    """The results of a test: halves filled, pre-loaded and moved, or gone on with."""
    out = folder.path.parent
    stages.expect(**expected_stages(test))
    packing = get_packing(test, out, stages, stop, warn)
    sim = settled(test, packing, packing_folder(test, out))
    sim.compile()
    course = go_on(sim, folder)
    follow(sim, test, course, folder, stages, stop)
    found = summary(test, course, sim)
    if abs(found["energy_closure"] or 0.0) > MOST_UNACCOUNTED:
        raise sim.failure(
            f"{abs(found['energy_closure']):.2g} of the dissipated energy is unaccounted for"
        )
    return {
        **found,
        "time_step_s": test.time_step,
        "steps": course.steps,
        "cpu_us_per_step": 1e6 * course.cpu_s / course.steps,
        "cpu_s": course.cpu_s + packing.cpu_s,
        "state_digest": sim.state_digest(),
    }


RUNS = Runs(
    result=Result,
    digest=run_digest,
    compute=_compute,
    packages=PACKAGES,
    sources=lambda test: SOURCES,
    compiling=lambda test: (100.0, 250),
)
run = RUNS.run


def packing_folder(test: SlowTest, root: Path) -> Path:
    """Folder of the packing of a test below a folder of runs; it may not exist yet."""
    return root / "packings" / digest(test.packing_identity())


def get_packing(
    test: SlowTest, root: Path, progress: Progress | Stages, stop: Stop, warn: Warn
) -> Packing:
    """The packing of a test: kept under root/packings, or made and kept now; see protocol.kept."""
    folder, stages = packing_folder(test, root), Stages.of(progress)

    def make() -> Packing:
        packing = dataclasses.replace(settle(test, stages, stop), sources=SOURCES.digest)
        save_packing(packing, folder)
        return packing

    with stages.watching():
        packing = kept(
            folder, load=load_packing, make=make, cure="delete it and the halves are filled again",
            sources=SOURCES, stop=stop, warn=warn,
        )  # fmt: skip
    stages.finish("settling")
    return packing


def settle(test: SlowTest, stages: Stages, stop: Stop) -> Packing:
    """Fill both halves from the seed and let the particles settle under gravity.

    The table rests at the top of the top half meanwhile. Raises InputError where they do not fit,
    SimulationError, and Stopped.
    """
    damper = test.damper.settling
    begun = time.process_time()
    test = dataclasses.replace(test, damper=damper)
    sim = between_halves(test, *random_start(damper, damper.count))
    n_steps = math.ceil(damper.settings.fill.settle_time / test.time_step)
    n_looks = math.ceil(damper.settings.fill.settle_time / _LOOK)
    sim.steps_per_sample = math.ceil(n_steps / n_looks)
    for k in range(n_looks):
        sim.run(1)
        stages.report("settling", k + 1, n_looks - k - 1, f"t = {sim.time:.3f} s")
        if stop():
            raise Stopped("the same command fills the halves again, from their seed")
    return packed(damper, sim, time.process_time() - begun)


def between_halves(test: SlowTest, centres, orientations=None) -> RigSimulation:
    """Particles at rest in both halves; centres (n, 3) [m], orientations (n, 4) or no turns."""
    return RigSimulation.between(
        test.halves.lines, world_of(test.damper, centres, orientations, rotating=True)
    )


def settled(test: SlowTest, packing: Packing, folder: Path) -> RigSimulation:
    """The bed of a packing; FolderError where it does not fit the test."""
    sim = between_halves(test, packing.state["position"][:, :3])
    try:
        sim.restore(packing.state)
    except (IndexError, KeyError, ValueError):
        raise damaged(folder, "the halves are filled again") from None
    sim.begin_phase()
    return sim


def run_task(task: Task, stop: Stop) -> Result | None:
    """Run a test, or fill its halves; in a worker."""
    compile_kernels()
    return run_or_pack(task, stop, run=run, get_packing=get_packing)


def compile_kernels() -> None:
    """Compile what is not compiled yet, while other processes that need it wait."""

    def test_a_few() -> None:
        few = {"particles.count": 8, "fill.settle_time": "1 ms"}
        with tempfile.TemporaryDirectory() as folder:
            for shape in ("prolate:1", "prolate:1.5"):
                test = SlowTest.load("compress", {"particles.shape": shape, **few}, {})
                settled(test, get_packing(test, Path(folder), *_QUIETLY), Path(folder)).sample()

    once(Path(cache_folder(ENGINE)), _COMPILED, test_a_few)


_QUIETLY: tuple[Progress, Stop, Warn] = (lambda fraction, text: None, lambda: False, silent)


def expected_stages(test: SlowTest) -> dict[str, float]:
    """About what each stage of a test costs [s of CPU]; a pre-load takes a tenth of its most."""
    sub_spheres = float(test.damper.sub_spheres.mean())
    each = (_OF_A_PARTICLE + _OF_A_SUB_SPHERE * sub_spheres) * test.damper.count
    return {
        "settling": each * test.settings.fill.settle_time / test.time_step,
        "pre-load": 0.1 * each * LONGEST_PRELOAD / test.time_step,
        "testing": each * SAMPLES * steps_per_sample(test, True),
    }


def expected_cpu_s(test: SlowTest) -> tuple[float, float]:
    """About what filling and test cost [s of CPU]."""
    settling, *testing = expected_stages(test).values()
    return settling, sum(testing)


SLOW_TESTS = Simulator(
    name="damper3d",
    digest=run_digest,
    packing_folder=packing_folder,
    packing_from=partial(packing_sources, load_packing),
    work=run_task,
    read=partial(Result.read, reused=True),
    expected_cpu_s=expected_cpu_s,
    sources=SOURCES,
    packages=PACKAGES,
    compiled=lambda: (Path(cache_folder(ENGINE)) / _COMPILED).exists(),
)
