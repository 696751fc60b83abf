"""The slots on a GPU: one block of threads a damper, by numba-cuda. Nothing else knows a GPU.

numba-cuda compiles the functions of step.py, samples.py and of the contact laws anew for the
device, from their Python.
"""

import math
from functools import cache
from typing import Any

import numpy as np

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


@cache
def kernel(registers: int = REGISTERS) -> Any:
    """The kernel, called as kernel()[blocks, threads](slots, which, most).

    Block b lets slot which[b] go on for so many steps at most; slots: device arrays.
    """
    from numba import cuda

    teach_square_roots()
    advance = cuda.jit(device=True)(advancing(cuda.syncthreads))

    @cuda.jit(max_registers=registers)
    def go_on(slots, which, most):
        advance(slots, which[cuda.blockIdx.x], cuda.threadIdx.x, cuda.blockDim.x, most)

    return go_on


def threads_for(n_spheres: int) -> int:
    """Threads of a block: whole warps, as many as spheres or as fit."""
    return min(-(-n_spheres // _WARP) * _WARP, _THREADS)


def to_device(slots: Slots) -> Slots:
    """The slots as arrays of the device."""
    from numba import cuda

    return Slots(*(cuda.to_device(array) for array in slots))
