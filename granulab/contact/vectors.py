"""Vectors as tuples of 1, 2 or 3 numbers, for kernels: numba unrolls them into registers."""

import numpy as np

from granulab.contact.jit import njit


@njit
def add(a, b):
    """a + b."""
    if len(a) == 1:
        return (a[0] + b[0],)
    if len(a) == 2:
        return (a[0] + b[0], a[1] + b[1])
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@njit
def scale(s, a):
    """The number s times the vector a."""
    if len(a) == 1:
        return (s * a[0],)
    if len(a) == 2:
        return (s * a[0], s * a[1])
    return (s * a[0], s * a[1], s * a[2])


@njit
def dot(a, b):
    """The scalar product of a and b."""
    if len(a) == 1:
        return a[0] * b[0]
    if len(a) == 2:
        return a[0] * b[0] + a[1] * b[1]
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit
def norm(a):
    """The length of a."""
    return np.sqrt(dot(a, a))


@njit
def cross(a, b):
    """The vector product of a and b, in space."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
