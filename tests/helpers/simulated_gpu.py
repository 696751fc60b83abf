"""Slots that go on on numba's simulator of a GPU, and by one thread; run as a script.

    simulated_gpu.py SLOTS.npz THREADS MOST RESULT.npz

With NUMBA_ENABLE_CUDASIM=1 and NUMBA_DISABLE_JIT=1, so that all of it is Python. The result has
each array twice, as name and as name_alone.
"""

import sys

import numpy as np

from damper3d.engine.batch.device import Gpu
from damper3d.engine.batch.loop import Processor
from damper3d.engine.batch.slots import Slots


def gone_on(device, slots: Slots, most: int) -> Slots:
    """The slots after so many steps at most."""
    for s in range(len(slots.clock)):
        device.bring(s, Slots(*(array[s : s + 1] for array in slots)))
    after = Slots(*(array.copy() for array in slots))
    device.go_on(after.clock, np.arange(len(slots.clock)), most)
    device.fetch(after, Slots._fields[1:])
    return after


if __name__ == "__main__":
    given, threads, most, result = sys.argv[1:]
    with np.load(given) as arrays:
        slots = Slots(**{name: arrays[name] for name in Slots._fields})
    gpu = Gpu(slots, threads=int(threads))
    found = gone_on(gpu, slots, int(most))._asdict()
    alone = gone_on(Processor(slots), slots, int(most))._asdict()
    np.savez(result, **found, **{f"{name}_alone": array for name, array in alone.items()})
