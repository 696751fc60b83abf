"""Registry of the motions, and the two kernels that stand for those of any of them."""

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from numba.extending import overload

from damper3d.engine import ENGINE
from granulab.contact.jit import extend, njit


class Motion(NamedTuple):
    """A kind of motion that cases may have."""

    of_case: Callable[..., Any]
    units: dict[str, str]  # SI units of the keys of [motion] that it takes besides the usual ones


MOTIONS: dict[str, Motion] = {}  # by the kind that a case names
_COMPILED: dict[type, tuple[Any, Any]] = {}  # displacement and velocity, by the type of the numbers


def register(
    kind: str,
    numbers: type,
    displacement: Callable[..., float],
    velocity: Callable[..., float],
    of_case: Callable[..., Any],
    units: dict[str, str] | None = None,
    *helpers: str | Path,
) -> None:
    """Let cases have a kind of motion.

    numbers is the type of a named tuple. displacement(motion, t) [m] and velocity(motion, t) [m/s]
    are plain functions of such a tuple and the time t >= 0 [s], which the engine compiles; velocity
    is the exact derivative of displacement, or the energy balance does not close.
    of_case(gamma, frequency, gravity, ramp, **own) returns the tuple of a case: its largest
    acceleration over gravity [-], frequency of a cycle [Hz], gravity [m/s2], cycles over which the
    amplitude grows, and the values of the keys that the kind has besides, which `units` names.
    helpers are files with functions that these call, where they do not stand in their file: an edit
    in any of these files compiles the kernels again, and calls runs that were made before it
    outdated.
    """
    functions = [getattr(each, "py_func", each) for each in (displacement, velocity)]
    sources = [Path(source).resolve() for source in [*map(inspect.getfile, functions), *helpers]]
    outside = [path for path in sources if ENGINE not in path.parents]
    if outside:
        extend(ENGINE, numbers.__module__, *outside)
    MOTIONS[kind] = Motion(of_case, units or {})
    compile_for(numbers, displacement, velocity)


def compile_for(
    numbers: type, displacement: Callable[..., float], velocity: Callable[..., float]
) -> None:
    """Let the engine have a type of motion that no case names; see register."""
    _COMPILED[numbers] = _compiled(displacement), _compiled(velocity)


def _compiled(function: Any) -> Any:
    return function if hasattr(function, "py_func") else njit(function)


def displacement(motion, t):
    """Return the displacement of the enclosure along its direction [m] at the time t >= 0 [s]."""
    return _kernels(type(motion))[0](motion, t)


def velocity(motion, t):
    """Return its velocity [m/s], the exact derivative of the displacement."""
    return _kernels(type(motion))[1](motion, t)


def _kernels(numbers: type) -> tuple[Any, Any]:
    if numbers not in _COMPILED:
        raise LookupError(f"{numbers}: not registered; see damper3d.engine.motions.register")
    return _COMPILED[numbers]


# Kernels choose by the type of the motion while they are compiled: a function that is handed over,
# or caught by a function made at run time, would break the cache on disk.
@overload(displacement)
def _displacement(motion, t):
    chosen = _kernels(motion.instance_class)[0]
    return lambda motion, t: chosen(motion, t)


@overload(velocity)
def _velocity(motion, t):
    chosen = _kernels(motion.instance_class)[1]
    return lambda motion, t: chosen(motion, t)
