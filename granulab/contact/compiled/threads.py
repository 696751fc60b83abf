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
from concurrent.futures import Future, ThreadPoolExecutor
from concurrent.futures import wait as settled
from threading import Barrier
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


_LINES = 16  # numbers of eight bytes in two lines of the cache, which processors load together


def clock() -> np.ndarray:
    """Make a clock for threads to wait with: counts their arrivals, alone in its cache lines."""
    return rows_apart(1, 1)[0]


def rows_apart(n_rows: int, n: int) -> np.ndarray:
    """Rows of at least n integers, zeros, no two of which share a line of the cache."""
    width = -(-n // _LINES) * _LINES
    room = np.zeros(n_rows * width + _LINES, np.int64)
    begin = (-room.ctypes.data // room.itemsize) % _LINES
    return room[begin : begin + n_rows * width].reshape(n_rows, width)


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
    """Threads that run a kernel together, while the caller's waits for them.

    None of them is the one that hears Ctrl-C: a kernel that one of them did not begin would let the
    others wait for ever. So they are all there before the first kernel, and an interrupted caller
    waits until theirs have ended.
    """

    def __init__(self, n_threads: int) -> None:
        """Begin so many threads; RuntimeError where the machine does not let it."""
        self.n_threads = n_threads
        self._pool = ThreadPoolExecutor(n_threads)
        together = Barrier(n_threads + 1)
        try:
            for _ in range(n_threads):
                self._pool.submit(together.wait)
            together.wait()
        except BaseException:  # Ctrl-C too: no thread waits for ever
            together.abort()
            raise

    def run(self, kernel: Callable[..., Any], arguments: Sequence[tuple[Any, ...]]) -> Any:
        """Call a kernel with the arguments of each thread at once; what the first one returns.

        The kernel must be compiled.
        """
        first: Future[Any] | None = None
        try:
            first = self._pool.submit(self._lead, kernel, arguments)
            return first.result()
        finally:
            if first is not None:
                settled([first])

    def _lead(self, kernel: Callable[..., Any], arguments: Sequence[tuple[Any, ...]]) -> Any:
        others = [self._pool.submit(kernel, *own) for own in arguments[1:]]
        first = kernel(*arguments[0])
        for other in others:
            other.result()
        return first


def crew_of(n_threads: int) -> Crew | None:
    """A crew of so many threads; None of one, or where the machine does not let as many begin."""
    if n_threads < 2:
        return None
    try:
        return Crew(n_threads)
    except RuntimeError:
        print("warning: no more threads can begin here: one takes all steps", file=sys.stderr)
        return None
