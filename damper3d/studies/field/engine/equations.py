"""The harmonic balance of several dampers on several modes: its equations, solved by Newton.

At one frequency, with all lengths over that of Gamma 1 and all forces over omega^2 (so that a
field's knots are Gamma and m Gamma), the modes Q_r and the level L obey

    d_r Q_r - sum_d phi_r(d) f_d(y_d) = L g_r,    y_d = L b + sum_r phi_r(d) Q_r,
    f_d(y) = (alpha + beta |y|) y/|y|,    d_r = (w_r^2 - w^2 + 2 i zeta_r w_r w)/w^2

with alpha and beta of the piece of the damper's field, between two of its knots, in which |y_d|
lies. These are 2 r real equations for the 2 r + 1 unknowns z: Re Q_0, Im Q_0, Re Q_1, ..., L; their
solutions are curves. Lengths are those of the y_d, on which alone the forces depend, over |y_d|, or
over the first knot where that is more. Kernels; a piece (d,) is the number of each damper's.
"""

from typing import Any, NamedTuple

import numpy as np

from granulab.contact.jit import inner

_ITERATIONS = 12
_CONVERGED = 1e-8  # length of a Newton step: they fall by squares, so the next one is nothing
_ASTRAY = 1e6  # length of a step that leads nowhere


class Balance(NamedTuple):
    """The harmonic balance at one frequency: d dampers, r modes, at most k knots.

    Of several frequencies all but the shapes have them as their first axis.
    """

    modes: np.ndarray  # (r,) d_r [-]
    shapes: np.ndarray  # (d, r) [kg^-0.5]
    drive: np.ndarray  # (r,) g of level 1, over the length of Gamma 1 [kg^0.5]
    base: Any  # b of level 1, over the length of Gamma 1
    knots: np.ndarray  # (d, k) Gammas from 0 up
    force: np.ndarray  # (d, k) m Gamma there [kg]
    pieces: np.ndarray  # (d,) number of pieces of each field; later knots do not count


@inner
def dot(a, b):
    """Scalar product."""
    total = 0.0
    for k in range(len(a)):
        total += a[k] * b[k]
    return total


@inner
def displacement(balance, z, d):
    """The displacement y_d of a damper."""
    y = complex(balance.base * z[-1], 0.0)
    for r in range(len(balance.modes)):
        y += balance.shapes[d, r] * complex(z[2 * r], z[2 * r + 1])
    return y


@inner
def weigh(balance, z, weight):
    """Write the weights of squared displacements (d,) of lengths at a point."""
    for d in range(len(weight)):
        size = max(abs(displacement(balance, z, d)), balance.knots[d, 1])
        weight[d] = 1.0 / size**2


@inner
def length_of(balance, weight, step):
    """Length of a step of the unknowns."""
    total = 0.0
    for d in range(len(weight)):
        y = displacement(balance, step, d)
        total += weight[d] * (y.real * y.real + y.imag * y.imag)
    return np.sqrt(total)


@inner
def along(balance, weight, t, row):
    """Write the scalar product with t that belongs to lengths into row, to be multiplied by z."""
    for k in range(len(row)):
        row[k] = 0.0
    for d in range(len(weight)):
        y = weight[d] * displacement(balance, t, d)
        for r in range(len(balance.modes)):
            row[2 * r] += balance.shapes[d, r] * y.real
            row[2 * r + 1] += balance.shapes[d, r] * y.imag
        row[-1] += balance.base * y.real


@inner
def growth(balance, z, d, row):
    """Write the derivative of |y_d| by the unknowns into row."""
    y = displacement(balance, z, d)
    y /= abs(y)
    for r in range(len(balance.modes)):
        row[2 * r] = balance.shapes[d, r] * y.real
        row[2 * r + 1] = balance.shapes[d, r] * y.imag
    row[-1] = balance.base * y.real


@inner
def linearise(balance, piece, z, m):
    """Write derivatives by the unknowns, and the negative residual, into the first rows of m.

    m (2 r + 1, 2 r + 2): the right side is the last column.
    """
    n = len(z) - 1
    for i in range(n):
        for j in range(n + 2):
            m[i, j] = 0.0
    for r in range(n // 2):
        own, drive = balance.modes[r], balance.drive[r]
        left = own * complex(z[2 * r], z[2 * r + 1]) - z[n] * drive
        m[2 * r, 2 * r], m[2 * r, 2 * r + 1] = own.real, -own.imag
        m[2 * r + 1, 2 * r], m[2 * r + 1, 2 * r + 1] = own.imag, own.real
        m[2 * r, n], m[2 * r + 1, n] = -drive.real, -drive.imag
        m[2 * r, n + 1], m[2 * r + 1, n + 1] = -left.real, -left.imag
    for d in range(len(piece)):
        _push(balance, piece[d], displacement(balance, z, d), d, m)


@inner
def _push(balance, k, y, d, m):
    """Take the force f_d and its derivatives off the equations in m; k: piece of damper d."""
    n = len(m) - 1
    width = balance.knots[d, k + 1] - balance.knots[d, k]
    beta = (balance.force[d, k + 1] - balance.force[d, k]) / width
    force, by_re, by_im = beta * y, beta, 1j * beta
    if k > 0:
        size = abs(y)
        rest = (balance.force[d, k] - beta * balance.knots[d, k]) * y / size  # alpha y/|y|
        force += rest
        by_re -= 1j * rest * y.imag / size**2
        by_im += 1j * rest * y.real / size**2
    for r in range(n // 2):
        own = balance.shapes[d, r]
        m[2 * r, n] -= own * balance.base * by_re.real
        m[2 * r + 1, n] -= own * balance.base * by_re.imag
        m[2 * r, n + 1] += own * force.real
        m[2 * r + 1, n + 1] += own * force.imag
        for s in range(n // 2):
            both = own * balance.shapes[d, s]
            m[2 * r, 2 * s] -= both * by_re.real
            m[2 * r + 1, 2 * s] -= both * by_re.imag
            m[2 * r, 2 * s + 1] -= both * by_im.real
            m[2 * r + 1, 2 * s + 1] -= both * by_im.imag


@inner
def solve(m):
    """Solve m (n, n + 1) for its last column, in place; the sign of the determinant, or 0."""
    n, sign = len(m), 1.0
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(m[i, k]) > abs(m[best, k]):
                best = i
        if not abs(m[best, k]) > 0.0:
            return 0.0
        if best != k:
            sign = -sign
            for j in range(k, n + 1):
                m[k, j], m[best, j] = m[best, j], m[k, j]
        if m[k, k] < 0.0:
            sign = -sign
        for i in range(k + 1, n):
            part = m[i, k] / m[k, k]
            for j in range(k + 1, n + 1):
                m[i, j] -= part * m[k, j]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            m[k, n] -= m[k, j] * m[j, n]
        m[k, n] /= m[k, k]
    return sign


@inner
def pieces_at(balance, z, piece):
    """Write the pieces where the amplitudes are, beyond a field its last; True if any changed."""
    changed = False
    for d in range(len(piece)):
        k, size = 0, abs(displacement(balance, z, d))
        while k + 1 < balance.pieces[d] and size > balance.knots[d, k + 1]:
            k += 1
        changed = changed or k != piece[d]
        piece[d] = k
    return changed


@inner
def newton(balance, piece, weight, z, row, wanted, knot, any_piece, m):
    """Move z onto the curve, where row . z is as wanted; True where it converged.

    knot: a damper whose amplitude is as wanted instead, with row its derivative; -1: none.
    any_piece: pieces follow the amplitudes, else the forces are those of piece beyond it too.
    """
    n = len(z) - 1
    for _ in range(_ITERATIONS):
        changed = any_piece and pieces_at(balance, z, piece)
        linearise(balance, piece, z, m)
        if knot >= 0:
            growth(balance, z, knot, row)
        now = abs(displacement(balance, z, knot)) if knot >= 0 else dot(row, z)
        for k in range(n + 1):
            m[n, k] = row[k]
        m[n, n + 1] = wanted - now
        if solve(m) == 0.0:
            return False
        for k in range(n + 1):
            z[k] += m[k, n + 1]
        step = length_of(balance, weight, m[:, n + 1])
        if not step < _ASTRAY:
            return False
        if step < _CONVERGED and not changed:
            return True
    return False


@inner
def tangent(balance, piece, weight, z, row, sign, t, m):
    """Write the tangent of length one whose product with row has this sign; the side of the curve.

    The side is the sign of the determinant of derivatives and tangent, 0 where there is none. It is
    the same all along a curve that is followed in one direction: also through knots, where the
    derivatives change by a matrix of rank one, if |y_d| goes on as it did.
    """
    n = len(z) - 1
    linearise(balance, piece, z, m)
    for k in range(n + 1):
        m[k, n + 1] = 0.0
        m[n, k] = row[k]
    m[n, n + 1] = sign
    side = sign * solve(m)
    for k in range(n + 1):
        t[k] = m[k, n + 1]
    length = length_of(balance, weight, t)
    if not 0.0 < length < np.inf:
        return 0.0
    for k in range(n + 1):
        t[k] /= length
    return side
