"""Rotations: unit quaternions, the axes they stand for, and a step of free rotation.

With the angular momentum L of the laboratory, the energy of rotation is a sum of three terms,

    H = L^2/(2 I_1) + (1/2) (1/I_2 - 1/I_1) L_2^2 + (1/2) (1/I_3 - 1/I_1) L_3^2,

L_2 and L_3 along the particle's axes. Each alone rotates it at a constant rate: the first about L,
by h L/I_1 in the laboratory, which the others do not touch; the others about an own axis, by
h (1/I_k - 1/I_1) L_k. Half a step of the third, a step of the second, half of the third (Strang)
is of second order, can be run backwards, and keeps L and |q| to rounding. Where two moments are
equal the third axis is the odd one, the second term is nothing, and a step is exact.
"""

import numpy as np

from granulab.contact.jit import inner

_SMALL = 2.5e-3  # square of half an angle below which the series is exact to rounding


@inner
def half_turn(square):
    """cos(h) and sin(h)/h of half an angle h, from its square."""
    if square < _SMALL:
        cosine = 1.0 - square / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0 * (
            1.0 - square / 56.0)))  # fmt: skip
        sine = 1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0))
        return cosine, sine
    half = np.sqrt(square)
    return np.cos(half), np.sin(half) / half


@inner
def product(p, q):
    """Of two quaternions (w, x, y, z): turns by q first."""
    a, b, c, d = p
    w, x, y, z = q
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )


@inner
def axes_of(q):
    """The particle's x, y and z axes in the laboratory, of a unit quaternion."""
    w, x, y, z = q
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)),
        (2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)),
        (2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)),
    )


@inner
def turned_about(q, along, axis, angle):
    """q after a turn about its own axis 0, 1 or 2, and a fixed vector along its axes then."""
    cosine, sine = half_turn(0.25 * angle * angle)
    sine *= 0.5 * angle
    c, s = cosine * cosine - sine * sine, 2.0 * sine * cosine
    x, y, z = along
    if axis == 0:
        return product(q, (cosine, sine, 0.0, 0.0)), (x, c * y + s * z, c * z - s * y)
    if axis == 1:
        return product(q, (cosine, 0.0, sine, 0.0)), (c * x - s * z, y, c * z + s * x)
    return product(q, (cosine, 0.0, 0.0, sine)), (c * x + s * y, c * y - s * x, z)


@inner
def freely_turned(q, momentum, inverse_inertia, odd, h):
    """q after a time h of free rotation with an angular momentum (x, y, z) of the laboratory."""
    second, first = (odd + 1) % 3, (odd + 2) % 3
    rest = inverse_inertia[first]
    excess, odd_excess = inverse_inertia[second] - rest, inverse_inertia[odd] - rest
    x, y, z = momentum
    a, b, c = axes_of(q)
    along = (
        a[0] * x + a[1] * y + a[2] * z,
        b[0] * x + b[1] * y + b[2] * z,
        c[0] * x + c[1] * y + c[2] * z,
    )
    if excess == 0.0:
        q, along = turned_about(q, along, odd, h * odd_excess * along[odd])
    else:
        q, along = turned_about(q, along, odd, 0.5 * h * odd_excess * along[odd])
        q, along = turned_about(q, along, second, h * excess * along[second])
        q, along = turned_about(q, along, odd, 0.5 * h * odd_excess * along[odd])
    half = 0.5 * h * rest
    cosine, sine = half_turn(half * half * (x * x + y * y + z * z))
    sine *= half
    w, i, j, k = product((cosine, sine * x, sine * y, sine * z), q)
    scale = 1.0 / np.sqrt(w * w + i * i + j * j + k * k)
    return scale * w, scale * i, scale * j, scale * k
