"""Where the time of a step goes: a clock at the borders of its stages, put into the kernels.

    python -m benchmarks.speed.stages silo2d|damper3d

The step's own functions are compiled once more, without the cache on disk, with each stage inside
two readings of the processor's counter; nothing of the step is written a second time. Prints JSON:
shares by scene and stage.
"""

import importlib
import inspect
import json
import os
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from types import ModuleType
from typing import Any, NamedTuple

import llvmlite.binding
import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.core.dispatcher import Dispatcher
from numba.extending import intrinsic

from granulab.contact.jit import inlined_inner

REST = "rest"
STRETCHES = 200
INTERRUPTED = 0.05  # of the wall time of a stretch, in which the process had no core


class Step(NamedTuple):
    """The stages of a package's step.

    modules  whose functions call stages, or call what calls them
    stages   functions by stage; those that an engine does not have are left out
    """

    modules: Sequence[str]
    stages: dict[str, Sequence[str]]


STEPS = {
    "silo2d": Step(
        ("silo2d.engine.forces", "silo2d.engine.simulation"),
        {
            "search": ["search"],
            "gather, geometry, law": ["contact_forces"],
            "scatter, energy": ["add_loads"],
            "integrate": ["move"],
        },
    ),
    "damper3d": Step(
        (
            "damper3d.engine.forces", "damper3d.engine.integrate", "damper3d.engine.sampling",
            "damper3d.engine.simulation",
        ),
        {
            "search": ["search"],
            "filter": ["choose_pairs", "find_at_wall"],
            "gather": ["gather"],
            "geometry": ["between_spheres", "with_wall", "note_laws"],
            "law": ["contact_law", "begin_contacts"],
            "history": ["keep_history"],
            "scatter, sums": ["add_and_sum"],
            "energy": ["roll", "tear", "take_totals", "take_push"],
            "integrate": ["move", "drive_walls"],
            "samples": ["sample"],
        },
    ),
}  # fmt: skip


@intrinsic
def ticks(typingctx):
    """The processor's counter now; what reads or writes memory stays on its side of it."""

    def generate(context, builder, signature, arguments):
        nothing = ir.FunctionType(ir.VoidType(), ())
        kind = ir.FunctionType(ir.IntType(64), ())
        builder.asm(nothing, "", "~{memory}", (), side_effect=True)
        counter = builder.module.declare_intrinsic("llvm.readcyclecounter", (), kind)
        now = builder.call(counter, ())
        builder.asm(nothing, "", "~{memory}", (), side_effect=True)
        return now

    return types.int64(), generate


@intrinsic
def add_at(typingctx, address, number):
    """Add a number to the integer at an address."""

    def generate(context, builder, signature, arguments):
        place = builder.inttoptr(arguments[0], ir.IntType(64).as_pointer())
        builder.store(builder.add(builder.load(place), arguments[1]), place)
        return context.get_dummy_value()

    return types.void(types.int64, types.int64), generate


def timed(function: Callable[..., Any], count: np.ndarray) -> Callable[..., Any]:
    """A stage that adds the ticks that it takes to a count (1,), which it keeps.

    Its arguments are named as the stage's: numba puts nothing in that is called with *arguments.
    """
    names = ", ".join(inspect.signature(getattr(function, "py_func", function)).parameters)
    text = f"""def stage({names}):
        began = ticks()
        result = function({names})
        add_at(address, ticks() - began)
        return result"""
    known = {"ticks": ticks, "add_at": add_at, "function": function, "count": count,
             "address": count.ctypes.data}  # fmt: skip
    exec(text, known)
    return numba.njit(**options_of(function))(known["stage"])


def options_of(function: Callable[..., Any]) -> dict[str, Any]:
    """The options that a stage is compiled with; of one that is chosen by types, a kernel's."""
    like = function if isinstance(function, Dispatcher) else inlined_inner(timed)
    return {name: value for name, value in like.targetoptions.items() if name != "nopython"}


def put_clocks(step: Step) -> dict[str, np.ndarray]:
    """Put clocks into the stages of a package that has compiled nothing yet; their counts.

    Each of the modules' functions is decorated again, so that it is compiled with what is put in.
    """
    llvmlite.binding.initialize_native_asmparser()  # for the barriers of ticks
    modules = [importlib.import_module(name) for name in step.modules]
    counts = {stage: np.zeros(1, np.int64) for stage in step.stages}
    owner = {name: stage for stage, names in step.stages.items() for name in names}
    new: dict[int, Any] = {}
    for module in modules:
        for name, value in functions_of(module):
            if name in owner and id(value) not in new:
                new[id(value)] = timed(value, counts[owner[name]])
            elif isinstance(value, Dispatcher) and value.py_func.__module__ == module.__name__:
                new.setdefault(id(value), numba.njit(**options_of(value))(value.py_func))
    for module in modules:
        for name, value in functions_of(module):
            if id(value) in new:
                setattr(module, name, new[id(value)])
    return counts


def functions_of(module: ModuleType) -> list[tuple[str, Any]]:
    """Names and values of a module's functions, its own and imported."""
    return [(name, value) for name, value in vars(module).items() if callable(value)]


def shares(run: Callable[[], object], counts: dict[str, np.ndarray]) -> dict[str, float]:
    """Shares of the stages in stretches of about a millisecond, and the rest.

    Stretches in which another process had the core for a while are left out.
    """
    run()  # compiles
    clock = numba.njit(lambda: ticks())
    clock()
    ticked = dict.fromkeys(counts, 0)
    whole = 0
    for _ in range(STRETCHES):
        for count in counts.values():
            count[0] = 0
        wall, cpu, began = time.perf_counter(), time.thread_time(), clock()
        run()
        lasted = clock() - began
        cpu, wall = time.thread_time() - cpu, time.perf_counter() - wall
        if wall - cpu < INTERRUPTED * wall:
            whole += lasted
            ticked = {stage: ticked[stage] + int(count[0]) for stage, count in counts.items()}
    if not whole:
        raise RuntimeError("every stretch was interrupted: the machine is too busy")
    found = {stage: n / whole for stage, n in ticked.items()}
    return {**found, REST: 1.0 - sum(found.values())}


def of_package(package: str) -> dict[str, dict[str, float]]:
    """Shares of each scene of a package."""
    counts = put_clocks(STEPS[package])
    if package == "silo2d":
        from benchmarks.speed import silo

        case, packing = silo.poured("A4")
        sim = silo.opened(case, packing)
        found = {"A4, door closed": shares(lambda: sim.run(50), counts)}
        silo.open_door(sim, case)
        sim.run(round(0.2 / sim.time_step))
        return {**found, "A4, flowing": shares(lambda: sim.run(50), counts)}
    from benchmarks.speed import damper

    case, state = damper.filled("sphere:5mm")
    still, moving = (damper.bed(case, state, moves=moves) for moves in (False, True))
    damper.go_on(moving, 2 * round(case.period / case.time_step))
    sample = case.steps_per_sample
    return {
        "thesis, 358 spheres, at rest": shares(lambda: damper.go_on(still, sample), counts),
        "thesis, 358 spheres, bouncing": shares(lambda: damper.go_on(moving, sample), counts),
    }


def main() -> None:
    """Print the shares; what is compiled with clocks is kept nowhere."""
    with tempfile.TemporaryDirectory() as folder:
        os.environ["NUMBA_CACHE_DIR"] = folder  # read when the first kernel is decorated
        print(json.dumps(of_package(sys.argv[1])))


if __name__ == "__main__":
    main()
