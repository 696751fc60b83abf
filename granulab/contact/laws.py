"""The contact laws: from overlap, rates and slip to force; and the conventions for all.

Conventions, everywhere in the project: the normal n points from body i to body j, the force is
that on j (i takes its opposite), velocities are those of j relative to i at the contact point,
the overlap d is positive in contact, and its rate d' is positive while the bodies approach.

Linear spring and dashpot with Coulomb slip (wood-silo paper, eqs 2.1-2.3; the preprint has
eq. 2.2, which the journal lost: Fe_n = -kn dxn n, Fe_t = -kt dxt t):

    f_n = kn d + m gamma_n d'                              m = m_i m_j / (m_i + m_j)
    f_t = -kt s - m gamma_t s'           |kt s| <= mu kn d

s is the slip: the tangential displacement that the spring still holds. The Coulomb limit caps
the elastic parts alone and both dashpots come on top, as the paper says. A tangent space has
one dimension in the plane and two (three components) in space: slips are tuples of either.

The functions below are those of the linear law. A law of another type has functions of its own for
some or all of them (`register`); the type of a law chooses its functions when a kernel is compiled.
"""

import inspect
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any, NamedTuple

from numba.extending import overload

from granulab.contact.jit import njit
from granulab.contact.vectors import add, dot, norm, scale


class LinearLaw(NamedTuple):
    """Constants of the linear law for one pair of materials."""

    kn: float  # normal stiffness [N/m]
    kt: float  # tangential stiffness [N/m], > 0
    mu: float  # coefficient of friction [-]
    gamma_n: float  # normal damping [1/s]
    gamma_t: float  # tangential damping [1/s]
    pulls: bool  # True: the contact ends at zero overlap; False: it ends at zero force


# The functions of a law by their names, and by the type of the law; those of LinearLaw serve every
# type that has none of its own.
_FUNCTIONS: dict[str, dict[type, Any]] = {}


def register(law: type, **functions: Callable[..., Any]) -> list[Path]:
    """Give a type of law functions of its own, and return the files that these stand in.

    law is the type of a named tuple; functions are plain functions, or njit ones, of a law and the
    further arguments of the functions of that name in this module, by position; `normal_force` and
    `normal_energy` belong together, as do `tangential_force`, `tangential_energy` and
    `tangential_damping`. For those that are not given the linear law's serve, which read its
    constants from the fields of the tuple. A law that belongs to no package is given to a simulator
    by way of its own `register_law`, which keeps kernels that call it apart from others.
    """
    for name, function in functions.items():
        if name not in _FUNCTIONS:
            raise TypeError(f"a law has no function {name!r}; it has {', '.join(_FUNCTIONS)}")
        expected, given = (
            len(inspect.signature(each).parameters)
            for each in (_python(_FUNCTIONS[name][LinearLaw]), _python(function))
        )
        if given != expected:
            raise TypeError(f"{name} takes {expected} arguments, the law first; not {given}")
        _FUNCTIONS[name][law] = function if hasattr(function, "py_func") else njit(function)
    return [Path(inspect.getfile(_python(function))) for function in functions.values()]


def _python(function: Any) -> Any:
    return getattr(function, "py_func", function)


def _of(name: str, law: type) -> Any:
    """Return the function of a name for a type of law."""
    known = _FUNCTIONS[name]
    return known.get(law, known[LinearLaw])


def _by_type(function):
    """Make a function of the linear law the one that serves every law, by the type of the law.

    The type is known when a kernel is compiled. A function that is handed over, or kept in a
    tuple, would break the cache on disk.
    """
    name = function.__name__
    _FUNCTIONS[name] = {LinearLaw: njit(function)}

    @wraps(function)
    def chosen(law, *arguments):
        return _python(_of(name, type(law)))(law, *arguments)

    @overload(chosen)
    def compiled(law, *arguments):
        kernel = _of(name, law.instance_class)
        return lambda law, *arguments: kernel(law, *arguments)

    return chosen


@_by_type
def normal_force(law, m, overlap, overlap_rate):
    """Return the normal force [N] and its part that is not elastic [N] (its power is dissipated).

    A contact that ends at zero overlap may pull shortly before it; one that ends at zero force
    may not.
    """
    elastic = law.kn * overlap
    force = elastic + m * law.gamma_n * overlap_rate
    if not law.pulls:
        force = max(force, 0.0)
    return force, force - elastic


@_by_type
def normal_energy(law, overlap):
    """Return what the normal spring holds [J]."""
    return 0.5 * law.kn * overlap**2


@njit
def coulomb(trial, limit):
    """Return the slip that the spring can hold: the tuple `trial` [m], at most `limit` [m] long."""
    if len(trial) == 1:  # a number needs no root: this is the innermost loop of the plane
        return (min(max(trial[0], -limit), limit),)
    size = norm(trial)
    return scale(limit / size, trial) if size > limit else trial


@_by_type
def slip_limit(law, overlap):
    """Return the largest slip [m] that the tangential spring holds: mu kn d/kt."""
    return law.mu * law.kn / law.kt * overlap


@_by_type
def tangential_force(law, m, overlap, slip, slip_step, slip_rate):
    """Return the tangential force [N], the slip that is kept [m], and the frictional loss [J].

    slip: what the spring held before [m]; slip_step: displacement since then [m]; slip_rate:
    velocity now [m/s]; all tuples in the tangent space. Friction takes the mean elastic force of
    the step over the displacement that the spring did not follow, which is second order in the
    step; the energy that the spring loses, (1/2) kt (trial^2 - held^2), would be first order.
    """
    trial = add(slip, slip_step)
    held = coulomb(trial, slip_limit(law, overlap))
    force = add(scale(-law.kt, held), scale(-m * law.gamma_t, slip_rate))
    lost = 0.5 * law.kt * dot(add(slip, held), add(trial, scale(-1.0, held)))
    return force, held, lost


@_by_type
def tangential_energy(law, slip):
    """Return what the tangential spring holds at a slip, a tuple [m], in joule."""
    return 0.5 * law.kt * dot(slip, slip)


@_by_type
def tangential_damping(law, m, slip_rate):
    """Return the power [W] of the tangential dashpot at a velocity, a tuple [m/s]."""
    return dot(scale(m * law.gamma_t, slip_rate), slip_rate)
