"""The slots on a GPU: one block of threads a damper, by numba-cuda. Nothing else knows a GPU.

numba-cuda compiles the functions of step.py, samples.py and of the contact laws anew for the
device, from their Python. It is imported here, so that this module is to be imported only where a
GPU is asked for.
"""

import math
from functools import cache
from typing import Any

import numpy as np
from numba import config, cuda

from damper3d.engine.batch.loop import advancing
from damper3d.engine.batch.slots import Slots

# Registers of a thread: 168 of 65,536 let a block of 384 threads in. More threads than spheres are
# of no use, and of more than 384 spheres a thread has several.
REGISTERS = 168
_THREADS = 384
_WARP = 32


def teach_square_roots() -> None:
    """Let the device's compiler know np.sqrt, which numba-cuda 0.30 lacks."""
    try:
        from numba.cuda.mathimpl import get_unary_impl_for_fn_and_ty
        from numba.cuda.ufuncs import ufunc_db
    except ImportError:  # the simulator, which has numpy itself
        return

    def root(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return get_unary_impl_for_fn_and_ty(math.sqrt, sig.args[0])(context, builder, sig, args)

    ufunc_db().setdefault(np.sqrt, {"d->d": root})


def together() -> None:
    """Wait for the other threads of the block."""
    cuda.syncthreads()


@cache
def kernel(registers: int = REGISTERS) -> Any:
    """The kernel, called as kernel()[blocks, threads](slots, which, most).

    Block b lets slot which[b] go on for so many steps at most; slots: device arrays.
    """
    teach_square_roots()
    advance = cuda.jit(device=True)(advancing(cuda.jit(device=True)(together)))

    limited = {} if config.ENABLE_CUDASIM else {"max_registers": registers}

    @cuda.jit(**limited)
    def go_on(slots, which, most):
        advance(slots, which[cuda.blockIdx.x], cuda.threadIdx.x, cuda.blockDim.x, most)

    return go_on


def threads_for(n_spheres: int) -> int:
    """Threads of a block: whole warps, as many as spheres or as fit."""
    return min(-(-n_spheres // _WARP) * _WARP, _THREADS)


class Gpu:
    """The slots on a GPU, one block of threads each: see batch.Device.

    All calls are to come from one thread, as the device's context is that thread's.
    """

    def __init__(self, slots: Slots, threads: int | None = None) -> None:
        self._sizes = slots
        self._slots: Slots | None = None
        self._kernel = kernel()
        self._threads = threads or threads_for(slots.position.shape[1])

    def _arrays(self) -> Slots:
        """The device's arrays; made at the first call, by the thread that works with them."""
        if self._slots is None:
            self._slots = Slots(*(cuda.device_array(a.shape, a.dtype) for a in self._sizes))
        return self._slots

    def bring(self, s: int, one: Slots) -> None:
        """Take over slot s from the arrays of a single slot."""
        for name, array in one._asdict().items():
            if name not in _SCRATCH:
                getattr(self._arrays(), name)[s].copy_to_device(array[0])

    def go_on(self, clock: np.ndarray, which: np.ndarray, most: int) -> None:
        """Let these slots go on for so many steps at most; their rows of `clock` follow."""
        slots = self._arrays()
        slots.clock.copy_to_device(clock)
        self._kernel[len(which), self._threads](slots, cuda.to_device(which), most)
        slots.clock.copy_to_host(clock)

    def fetch(self, slots: Slots, names: tuple[str, ...]) -> None:
        """Bring the named arrays of all slots into those of the host."""
        for name in names:
            getattr(self._arrays(), name).copy_to_host(getattr(slots, name))


# Arrays that need not be brought: the loop writes them before it reads them.
_SCRATCH = ("load", "seen", "drift", "constants", "parts", "rows")


def missing() -> str | None:
    """The reason why there is no GPU to use; None where there is one."""
    try:
        return None if cuda.is_available() else "an NVIDIA GPU, or its driver"
    except Exception as error:
        return f"a driver of an NVIDIA GPU that answers ({error})"


def name() -> str:
    """The name of the GPU, and the version of the package that speaks to it."""
    from importlib.metadata import version

    found = cuda.get_current_device().name
    words = found.decode() if isinstance(found, bytes) else found
    return f"{words}, numba-cuda {version('numba-cuda')}"
