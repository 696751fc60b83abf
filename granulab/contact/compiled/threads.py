"""Threads that share the steps of one run: how they meet within a kernel, and who runs them.

Each thread calls the same kernel, which keeps the GIL released, and comes to `wait` as often as the
others: nobody goes on before all are there. Waiting costs a fraction of a microsecond where each
has a core of its own. Who waits in vain for a while lets others have the core, so that more threads
than cores are slow, not stuck.

Which thread did what must not show in the results: a number is added to by one thread alone, in an
order that does not depend on how many threads there are.
"""

import platform
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from granulab.contact.jit import inlined_inner

_PATIENCE = 300  # looks at the clock, of some ten nanoseconds, before the core is let go
_let_go = types.ExternalFunction(
    "SwitchToThread" if sys.platform == "win32" else "sched_yield", types.int32()
)


def clock() -> np.ndarray:
    """Make a clock for threads to wait with: counts their arrivals, alone in its cache lines."""
    return np.zeros(16, np.int64)


@intrinsic
def _arrive(typingctx, clock):
    """Count one more arrival; what was written before is seen by who sees it."""

    def generate(context, builder, signature, arguments):
        array = context.make_array(signature.args[0])(context, builder, arguments[0])
        builder.atomic_rmw("add", array.data, ir.Constant(ir.IntType(64), 1), "seq_cst")
        return context.get_dummy_value()

    return types.void(clock), generate


@intrinsic
def _arrivals(typingctx, clock):
    """Return how many arrivals there were."""

    def generate(context, builder, signature, arguments):
        array = context.make_array(signature.args[0])(context, builder, arguments[0])
        return builder.load_atomic(array.data, ordering="seq_cst", align=8)

    return types.int64(clock), generate


@intrinsic
def _pause(typingctx):
    """Tell the processor that this is a loop which waits; those unknown here are told nothing."""

    def generate(context, builder, signature, arguments):
        if platform.machine() in ("x86_64", "AMD64"):
            kind = ir.FunctionType(ir.VoidType(), [])
            builder.call(builder.module.declare_intrinsic("llvm.x86.sse2.pause", (), kind), [])
        return context.get_dummy_value()

    return types.void(), generate


@inlined_inner
def wait(clock, n_threads, arrived):
    """Wait for the other threads; arrived: what this gave last, 0 at first."""
    _arrive(clock)  # type: ignore[call-arg]
    arrived += n_threads
    looks = 0
    while _arrivals(clock) < arrived:
        looks += 1
        if looks < _PATIENCE:
            _pause()
        else:
            _let_go()
    return arrived


class Crew:
    """Threads that run a kernel together; the caller's own is the first of them."""

    def __init__(self, n_threads: int) -> None:
        self.n_threads = n_threads
        self._others = ThreadPoolExecutor(n_threads - 1) if n_threads > 1 else None

    def run(self, kernel: Callable[..., Any], arguments: Sequence[tuple[Any, ...]]) -> Any:
        """Call a kernel with the arguments of each thread at once; what the first one returns.

        The kernel must be compiled: a thread that failed to begin would let the others wait.
        """
        if self._others is None:
            return kernel(*arguments[0])
        others = [self._others.submit(kernel, *own) for own in arguments[1:]]
        first = kernel(*arguments[0])
        for other in others:
            other.result()
        return first
