"""Two motions at once, along the enclosure's direction and along another one."""

from typing import Any, NamedTuple

import numpy as np

from damper3d.engine.motions import registry
from granulab.contact.jit import njit


class Crossed(NamedTuple):
    """A motion along the direction of the world, and one along a direction of its own."""

    along: Any  # a registered motion [m]
    across: Any  # likewise
    direction: np.ndarray  # (3,) of the second, of length one


@njit
def displacement(motion, t):
    """Return the displacement along the world's direction [m], the second's part left out."""
    return registry.displacement(motion.along, t)


@njit
def velocity(motion, t):
    """Return its velocity [m/s]."""
    return registry.velocity(motion.along, t)


def crosses(shaker):
    """Return whether a motion, of a type as numba has it, is of two directions."""
    return getattr(shaker, "instance_class", None) is Crossed
