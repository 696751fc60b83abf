"""Runs that go on together on a GPU, in threads of one process; see damper3d/engine/batch."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from damper3d.case.case import DamperCase
from damper3d.engine.simulation import Simulation
from granulab.campaign.runs.provenance import to_stderr
from granulab.campaign.sweeps.task import EngineError

if TYPE_CHECKING:
    from damper3d.engine.batch.batch import Batch, Device
    from damper3d.engine.batch.slots import Slots

_MOST = 264  # dampers at once: two for each of the 132 multiprocessors of an H100
_MEMORY = 4 * 2**30  # bytes that their slots may take, on the device and here

_batch: "Batch | None" = None  # where the runs of this process go on, if they do


@contextmanager
def on_device(cases: Sequence[DamperCase]) -> Iterator[int]:
    """Let runs of these cases go on on the GPU of this machine within; how many at once.

    Raises EngineError where there is no GPU, or nothing to speak to it with.
    """
    from damper3d.engine.batch import device

    if lacks := device.missing():
        raise EngineError(
            f"engine cuda: this machine lacks {lacks}; without --engine the runs go to its cores"
        )
    with going_on(cases, device.Gpu, device.name()) as at_once:
        yield at_once


@contextmanager
def going_on(
    cases: Sequence[DamperCase], kind: "Callable[[Slots], Device]", name: str
) -> Iterator[int]:
    """Likewise on a device of another kind, with a name.

    What it does not take goes on on the processor, and is said at the end.
    """
    from damper3d.engine.batch.batch import Batch
    from damper3d.engine.batch.slots import empty

    global _batch
    sizes: dict[str, Any] = {
        "n_spheres": max((case.count for case in cases if case.of_spheres), default=1),
        "n_walls": max(len(case.wall_names) for case in cases),
        "rows": max(case.settings.output.samples for case in cases),
    }
    each = sum(array.nbytes for array in empty(1, **sizes))
    at_once = min(max(_MEMORY // each, 1), _MOST, len(cases))
    slots = empty(at_once, **sizes)
    _batch = batch = Batch(kind(slots), slots, name)
    try:
        yield at_once
    finally:
        _batch = None
        batch.close()
        for reason, count in batch.refused.items():
            to_stderr(f"{count} of {len(cases)} runs went on on the processor: {reason}")


def joined(sim: Simulation) -> Simulation:
    """A simulation that goes on where the runs of this process do."""
    if _batch is None:
        return sim
    from damper3d.engine.batch.batch import Batched

    return Batched(sim, _batch)


def left(sim: Simulation) -> str | None:
    """Let a simulation leave the device at its end; the device's name, None of the processor."""
    leave: Callable[[], str | None] | None = getattr(sim, "leave", None)
    return None if leave is None else leave()
