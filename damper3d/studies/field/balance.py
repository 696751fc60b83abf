"""Response of a host with a bed by harmonic balance: all amplitudes at which forces balance.

At omega the bed pushes the enclosure with omega^2 m X, m = m'(omega, A) - i m''(omega, A) and
A = |X|. With the receptance R of the host at the damper and the bare response X0,

    X (1 - omega^2 R m(A)) = X0,        so        A |1 - omega^2 R m(A)| = |X0|.

For one mode that is (k - omega^2 (M + m') + i omega (c + omega m'')) X = F. The table is linear in
ln A between its amplitudes: there m = m_0 + (m_1 - m_0) t with A = A_0 exp(L t), and the left side
is A_0 exp(L t) sqrt(q(t)) with a quadratic q. It has its extremes where 2 L q + q' = 0, another
quadratic: between them it is monotone, and each root is bracketed. None is missed.
"""

from typing import NamedTuple

import numpy as np

from damper3d.case.host import Drive, Modes
from damper3d.studies.field.table import Field, Floats

_HALVINGS = 20  # of a bracket, and then Newton's steps: to the last digits
_NEWTON = 4


class Branch(NamedTuple):
    """Solutions of responses, one a row; SI."""

    response: np.ndarray  # (n,) number of the response
    frequency: np.ndarray  # (n,) number of the frequency
    amplitude: Floats  # (n,) A [m]
    stable: np.ndarray  # (n,) whether the level grows with A: others are jumped over
    phase: Floats  # (n,) of X against the bare response [rad]


def solve(field: Field, modes: list[Modes], drives: list[Drive], omega: Floats) -> Branch:
    """All solutions of responses, each a host and what moves it, at frequencies omega (f,) [rad/s].

    Drives count by their force or base; their own frequency is not used. The bed is as at the
    least amplitude of the table below it; solutions beyond the greatest are left out, as nothing is
    known there.
    """
    mass, amplitude = field.at(omega)  # (f, g) complex, (f, g)
    hosts = [_host(host, drive, omega) for host, drive in zip(modes, drives, strict=True)]
    factor, bare = (np.array(part) for part in zip(*hosts, strict=True))  # (r, f)
    found = [_below(mass, amplitude, factor, bare), _between(mass, amplitude, factor, bare)]
    rows = [np.concatenate(parts) for parts in zip(*found, strict=True)]
    order = np.lexsort((rows[2], rows[1], rows[0]))
    return Branch(*(row[order] for row in rows))


def _host(modes: Modes, drive: Drive, omega: Floats) -> tuple[np.ndarray, np.ndarray]:
    """omega^2 R and X0 [m] of a host at each omega (f,)."""
    own, square = modes.omega[:, None], omega**2
    modal = 1.0 / (own**2 - square + 2j * modes.damping_ratio[:, None] * own * omega)
    forced = drive.force * modes.force_shape[:, None]
    forced = forced + drive.base * square * modes.participation[:, None]
    bare = drive.base + modes.shape @ (modal * forced)
    return square * (modes.shape**2 @ modal), bare


def _below(mass: np.ndarray, amplitude: Floats, factor: np.ndarray, bare: np.ndarray) -> Branch:
    """Solutions below the least amplitude of the table: one at most."""
    away = 1.0 - factor * mass[:, 0]
    x = bare / away
    response, frequency = np.nonzero(np.abs(x) < amplitude[:, 0])
    size = np.abs(x)[response, frequency]
    phase = -np.angle(away)[response, frequency]
    return Branch(response, frequency, size, np.ones(len(size), bool), phase)


def _between(mass: np.ndarray, amplitude: Floats, factor: np.ndarray, bare: np.ndarray) -> Branch:
    """Solutions within the intervals of the table."""
    c0 = 1.0 - factor[:, :, None] * mass[:, :-1]  # (r, f, g - 1)
    c1 = -factor[:, :, None] * np.diff(mass, axis=1)
    rise = np.log(amplitude[:, 1:] / amplitude[:, :-1])
    q = np.abs(c0) ** 2, 2.0 * (c0 * c1.conj()).real, np.abs(c1) ** 2
    level = np.log(np.abs(bare))[:, :, None] - np.log(amplitude[:, :-1])
    edges = _pieces(q, rise)
    heights = [_height(q, rise, t) - level for t in edges]
    found = []
    for low, high, at_low, at_high in zip(edges, edges[1:], heights, heights[1:], strict=False):
        # The end of a piece belongs to the next, but for the last of all.
        crosses = (high > low) & ((at_low <= 0) != (at_high <= 0))
        r, f, g = np.nonzero(crosses)
        if len(r):
            here = [part[r, f, g] for part in q]
            t = _root(here, rise[f, g], level[r, f, g], low[r, f, g], high[r, f, g])
            away = c0[r, f, g] + c1[r, f, g] * t
            size = amplitude[f, g] * np.exp(rise[f, g] * t)
            stable = at_high[r, f, g] > at_low[r, f, g]
            found.append(Branch(r, f, size, stable, -np.angle(away)))
    if not found:
        none = np.zeros(0, np.int64)
        return Branch(none, none, np.zeros(0), np.zeros(0, bool), np.zeros(0))
    return Branch(*(np.concatenate(parts) for parts in zip(*found, strict=True)))


def _height(q: tuple[Floats, ...], rise: Floats, t: Floats) -> Floats:
    """Logarithm of the left side over A_0 at t."""
    with np.errstate(divide="ignore"):
        return np.asarray(rise * t + 0.5 * np.log(q[0] + t * (q[1] + t * q[2])))


def _pieces(q: tuple[Floats, ...], rise: Floats) -> list[Floats]:
    """Ends of the monotone pieces of each interval, from 0 to 1."""
    # 2 L q + q' = 0: a t^2 + b t + c
    a, b, c = 2.0 * rise * q[2], 2.0 * (rise * q[1] + q[2]), 2.0 * rise * q[0] + q[1]
    square = b**2 - 4.0 * a * c
    root = np.sqrt(np.maximum(square, 0.0))
    # The form without cancellation: b > 0 or not decides which root is which.
    half = -0.5 * (b + np.where(b >= 0.0, root, -root))
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.stack([half / a, c / half])
    ends = np.where(np.isfinite(ends) & (square > 0.0), np.clip(ends, 0.0, 1.0), 0.0)
    first, second = np.sort(ends, axis=0)
    return [np.zeros_like(first), first, second, np.ones_like(first)]


def _root(q: list[Floats], rise: Floats, level: Floats, low: Floats, high: Floats) -> Floats:
    """Root of the height between two ends at which it has opposite signs (n,)."""
    own = tuple(q)
    grows = _height(own, rise, high) > _height(own, rise, low)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        above = (_height(own, rise, middle) > level) == grows
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    t = 0.5 * (low + high)
    for _ in range(_NEWTON):
        square = own[0] + t * (own[1] + t * own[2])
        slope = rise + 0.5 * (own[1] + 2.0 * t * own[2]) / square
        with np.errstate(divide="ignore", invalid="ignore"):
            step = (_height(own, rise, t) - level) / slope
        better = t - np.where(np.isfinite(step), step, 0.0)
        t = np.clip(better, low, high)
    return t


def jumps(branch: Branch, n_frequencies: int, response: int, *, upwards: bool) -> list[int]:
    """Frequencies at which a slow sweep leaves a branch that ends: it jumps to another there."""
    chosen = (branch.response == response) & branch.stable
    order = range(n_frequencies) if upwards else range(n_frequencies - 1, -1, -1)
    before: Floats | None = None
    now, found = None, []
    for k in order:
        here = branch.amplitude[chosen & (branch.frequency == k)]
        if not len(here):
            before = now = None
            continue
        if now is None or before is None:
            now = float(here.min())
        else:
            nearest = float(here[np.argmin(np.abs(np.log(here / now)))])
            # Where another branch is still there, the one that was followed has ended.
            if len(here) < len(before) and np.argmin(np.abs(np.log(before / nearest))) != np.argmin(
                np.abs(np.log(before / now))
            ):
                found.append(k)
            now = nearest
        before = here
    return found
