"""Avalanches of many outlets and seeds on many cores."""

from collections.abc import Sequence
from functools import partial
from typing import Any

from granulab.campaign.output import room
from granulab.campaign.runs.protocol import Stop, packing_sources
from granulab.campaign.sweeps.sweep import (
    Labelled,
    Simulator,
    Task,
    over_seeds,
    run_labelled,
    run_or_pack,
    silent,
)
from granulab.contact.jit import already_compiled
from silo2d.avalanches import protocol
from silo2d.avalanches.case import AvalancheCase, Protocol, expected_cpu_s, run_digest
from silo2d.avalanches.result import Avalanches
from silo2d.case.case import SiloCase
from silo2d.case.plan import expected_particles
from silo2d.engine import ENGINE
from silo2d.run.packing import load_packing, packing_folder
from silo2d.run.protocol import PACKAGES, get_packing, sources_of_both
from silo2d.run.sources import SOURCES
from silo2d.run.sweep import compile_kernels

_OF_A_PARTICLE, _OF_AN_AVALANCHE = 500, 200  # [B] of a checkpoint, of table and summary


def cases_of(
    case: str, outlets: Sequence[float], seeds: Sequence[int], protocol: Protocol,
    changes: dict[str, Any], labels: dict[str, Any] | None = None,
) -> list[Labelled]:  # fmt: skip
    """Cases of a silo with each outlet [m] and seed; InputError for what cannot be run."""
    return [
        labelled
        for outlet in outlets
        for labelled in over_seeds(
            {**(labels or {}), "outlet_mm": round(1e3 * outlet, 6)},
            AvalancheCase.of(
                SiloCase.load(case, {**changes, "silo.outlet": f"{1e3 * outlet:.9g} mm"}), protocol
            ),
            seeds,
        )
    ]


def run_task(task: Task, stop: Stop) -> Avalanches | None:
    """Run a case, or fill its packing; in a worker."""
    compile_kernels(drawn=task.case.silo.disorder is not None and not task.packing_only)
    return run_or_pack(task, stop, run=protocol.run, get_packing=_packing)


def _packing(case: AvalancheCase, *options: Any) -> Any:
    return get_packing(case.silo, *options)


def _disk_at_most(case: AvalancheCase) -> dict[str, int]:
    kept = expected_particles(case.silo) * _OF_A_PARTICLE
    return room.on_disk(
        frames=[], numbers=case.protocol.avalanches * _OF_AN_AVALANCHE / 8, contacts=(0, 0),
        parts=0, checkpoint=kept,
    )  # fmt: skip


AVALANCHES = Simulator(
    name="silo2d",
    digest=run_digest,
    packing_folder=lambda case, out: packing_folder(case.silo, out),
    packing_from=partial(packing_sources, load_packing),
    work=run_task,
    read=partial(protocol.read_finished, warn=silent),
    expected_cpu_s=expected_cpu_s,
    disk_at_most=_disk_at_most,
    sources=SOURCES,
    made_by=lambda case: (protocol.RUNS.sources(case), sources_of_both(case.silo)[1]),
    packages=PACKAGES,
    compiled=partial(already_compiled, ENGINE),
)
run_cases = partial(run_labelled, AVALANCHES)  # labelled AvalancheCases; a row for each
