"""The bed before a test: particles that grow at random places in both halves, then settle."""

import dataclasses
import math
import time
from pathlib import Path

from damper3d.run.fill import clusters, packed, random_start
from damper3d.run.packing import Packing, load_packing, save_packing
from damper3d.run.sources import SOURCES
from damper3d.studies.quasistatic.case import SlowTest
from damper3d.studies.quasistatic.rig import RigSimulation
from granulab.campaign.runs.folder import FolderError, digest
from granulab.campaign.runs.protocol import kept
from granulab.campaign.runs.provenance import Warn
from granulab.campaign.sweeps.task import Progress, Stop
from granulab.errors import Stopped

_LOOK = 1e-3  # [s] of simulated time between reports


def packing_folder(test: SlowTest, root: Path) -> Path:
    """Where the packing of a test is kept below a folder of runs; it may not exist yet."""
    return root / "packings" / digest(test.packing_identity())


def get_packing(test: SlowTest, root: Path, progress: Progress, stop: Stop, warn: Warn) -> Packing:
    """The packing of a test: kept under root/packings, or made and kept now; see protocol.kept."""
    folder = packing_folder(test, root)

    def make() -> Packing:
        packing = dataclasses.replace(settle(test, progress, stop), sources=SOURCES.digest)
        save_packing(packing, folder)
        return packing

    return kept(
        folder, load=load_packing, make=make, cure="delete it and the halves are filled anew",
        sources=SOURCES, stop=stop, warn=warn,
    )  # fmt: skip


def settle(test: SlowTest, progress: Progress, stop: Stop) -> Packing:
    """Fill both halves from the seed and let the particles settle under gravity.

    The table rests at the top of the top half meanwhile. Raises InputError where they do not fit,
    SimulationError, and Stopped.
    """
    damper = test.damper
    begun = time.process_time()
    sim = between_halves(test, *random_start(damper, damper.count))
    n_steps = math.ceil(damper.settings.fill.settle_time / test.time_step)
    n_looks = math.ceil(damper.settings.fill.settle_time / _LOOK)
    sim.steps_per_sample = math.ceil(n_steps / n_looks)
    for k in range(n_looks):
        sim.run(1)
        progress((k + 1) / n_looks, f"settling, t = {sim.time:.3f} s")
        if stop():
            raise Stopped("the same command fills the halves anew, from their seed")
    return packed(damper, sim, time.process_time() - begun)


def between_halves(test: SlowTest, centres, orientations=None) -> RigSimulation:
    """Particles at rest in both halves; centres (n, 3) [m], orientations (n, 4) or no turns."""
    return RigSimulation.between(test.halves.lines, clusters(test.damper, centres, orientations))


def settled(test: SlowTest, packing: Packing, folder: Path) -> RigSimulation:
    """The bed of a packing; FolderError where it does not fit the test."""
    sim = between_halves(test, packing.state["position"][:, :3])
    try:
        sim.restore(packing.state)
    except (IndexError, KeyError, ValueError):
        raise FolderError(
            f"{folder / 'packing.h5'}: damaged, or of another version; delete it and the halves "
            "are filled anew"
        ) from None
    sim.begin_phase()
    return sim
