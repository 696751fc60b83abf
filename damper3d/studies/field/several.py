"""Harmonic balance of several dampers on a structure: every amplitude that is found.

    X_d = X_b,d + sum_e H_de omega^2 m_e(omega, |X_e|) X_e,
    H_de = sum_r phi_r(d) phi_r(e)/d_r with d_r of structure.py

**Dampers in time.** Where the shapes of two dampers have one ratio c in all modes, and no base
moves them alike whatever c is, X_d = c X_e always: of one mode under a force all of them. They act
as one, whose force at the amplitude A of the first is sum c_d F_d(c_d A), again linear between the
knots A_d/c_d of all fields; c_d of the first is 1. Where all dampers are in time all solutions are
in closed form (balance.py).

**Others.** At each frequency the curve of solutions through zero is followed in the level to the
end of a field (engine/curve.py), and so are those that cross it and those that Newton's method
meets from the solutions at the neighbouring frequencies. What is connected neither with zero nor
with these is not found. A solution is stable where the level rises along the curve from zero; more
generally, where the derivatives by the modes have a positive determinant (engine/arcs.py).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from damper3d.case.parts import GRAVITY
from damper3d.studies.field.balance import Responses, Truths, closed_form
from damper3d.studies.field.structure import Structure
from damper3d.studies.field.table import Complexes, Field, Floats

_IN_TIME = 1e-13  # of the larger shape, that the shapes of dampers in time may be off
_ROOM = 8  # solutions of each level that there is room for at first


@dataclass(frozen=True)
class _Group:
    """Dampers in time: the number of the first, and the ratios of all to it."""

    first: int
    ratios: dict[int, float]


def respond_together(
    structures: Sequence[Structure],
    fields: Sequence[Field],
    frequency: ArrayLike,
    levels: ArrayLike = (1.0,),
) -> list[Responses]:
    """Responses of each damper at frequencies (f,) [Hz] and levels (l,), in the same solutions.

    structures: one for each damper, which differ in their shape. Solutions rise with the amplitude
    of the first damper. Raises InputError for a frequency outside a field.
    """
    frequency, levels = np.asarray(frequency, float), np.asarray(levels, float)
    groups = _groups(structures)
    knots = [_knots(group, fields, frequency) for group in groups]
    if len(groups) == 1:
        own = groups[0]
        found = closed_form(structures[own.first], *knots[0], frequency, levels)
        return [
            replace(
                found, amplitude=own.ratios[d] * found.amplitude,
                bare=_bare(structure, frequency, levels),
            )
            for d, structure in enumerate(structures)
        ]  # fmt: skip
    leads = [structures[group.first] for group in groups]
    amplitude, stable, beyond, lost = followed(leads, knots, frequency, levels)  # (g, l, f, s)
    each = {d: ratio * own for group, own in zip(groups, amplitude, strict=True)
            for d, ratio in group.ratios.items()}  # fmt: skip
    order, base = np.argsort(each[0], axis=2), structures[0].base(frequency)  # NaN last
    stable = np.take_along_axis(stable, order, axis=2)
    return [
        Responses(
            levels, frequency, _bare(structure, frequency, levels),
            np.take_along_axis(each[d], order, axis=2), beyond, stable, lost,
            base=base if base.any() else None,
        )
        for d, structure in enumerate(structures)
    ]  # fmt: skip


def act_as_one(structures: Sequence[Structure]) -> bool:
    """True where all dampers are in time, so that all solutions are in closed form."""
    return len(_groups(structures)) == 1


def _bare(structure: Structure, frequency: Floats, levels: Floats) -> Floats:
    """Amplitudes without any bed (l, f) [m]."""
    with np.errstate(divide="ignore"):
        return levels[:, None] * np.abs(structure.bare(frequency))


def _groups(structures: Sequence[Structure]) -> list[_Group]:
    """Dampers in time, each group with the one of the largest shapes first."""
    sizes = [float(np.abs(one.shape).max()) for one in structures]
    moved = bool(structures[0].base_displacement or structures[0].base_acceleration)
    groups: list[_Group] = []
    for d in sorted(range(len(sizes)), key=lambda d: -sizes[d]):
        for group in groups:
            lead, own = structures[group.first].shape, structures[d].shape
            ratio = float(lead @ own) / float(lead @ lead)
            alike = np.abs(own - ratio * lead).max() <= _IN_TIME * sizes[group.first]
            if alike and not (moved and abs(ratio - 1.0) > _IN_TIME):
                group.ratios[d] = abs(ratio)
                break
        else:
            groups.append(_Group(d, {d: 1.0}))
    return groups


def _knots(group: _Group, fields: Sequence[Field], frequency: Floats) -> tuple[Floats, Complexes]:
    """Gammas of the first damper (f, k) and the force m Gamma (f, k) [kg] of all in time with it.

    Up to where the first of them leaves its field, from where on the last one is repeated.
    """
    each = {d: fields[d].knots(frequency) for d in group.ratios}
    if len(each) == 1:
        return each[group.first]
    rows = []
    for f in range(len(frequency)):
        own = [(gamma[f], force[f], group.ratios[d]) for d, (gamma, force) in each.items()]
        own = [(gamma, force, c) for gamma, force, c in own if c > 0]
        at = np.unique(np.concatenate([gamma / c for gamma, _, c in own]))
        at = at[at <= min(gamma[-1] / c for gamma, _, c in own)]
        rows.append((at, sum(c * np.interp(c * at, gamma, force) for gamma, force, c in own)))
    most = max(len(at) for at, _ in rows)
    filled = [
        [np.pad(values, (0, most - len(values)), mode="edge") for values in row] for row in rows
    ]
    return np.array([at for at, _ in filled]), np.array([force for _, force in filled])


def followed(
    structures: Sequence[Structure],
    knots: Sequence[tuple[Floats, Complexes]],
    frequency: Floats,
    levels: Floats,
) -> tuple[Floats, Truths, Truths, Truths]:
    """Amplitudes (d, l, f, s) [m], whether they are stable (l, f, s), beyond (l, f), lost (f,)."""
    from damper3d.studies.field.engine.arcs import LEFT, Found
    from damper3d.studies.field.engine.solutions import solutions

    length = GRAVITY / (2.0 * math.pi * frequency) ** 2  # of Gamma 1
    balances = _balances(structures, knots, frequency, length)
    room, many, n = _ROOM * len(levels), len(frequency), 2 * len(structures[0].omega) + 1
    while True:
        found = Found(
            np.zeros((many, 1), np.int64), np.zeros((many, room), np.int64),
            np.zeros((many, room, n)), np.zeros((many, room), np.bool_),
        )  # fmt: skip
        ends = np.zeros((many, 2))
        if solutions(balances, length, levels, found, ends):
            break
        room *= 2
    amplitude, stable = _arranged(found, balances, length, len(levels))
    lost = ends[:, 0] != LEFT
    return amplitude, stable, (ends[:, 1] < levels[:, None]) & ~lost, lost


def _balances(
    structures: Sequence[Structure],
    knots: Sequence[tuple[Floats, Complexes]],
    frequency: Floats,
    length: Floats,
) -> Any:
    """The equations at all frequencies, as engine/equations.py has them."""
    from damper3d.studies.field.engine.equations import Balance

    most = max(gamma.shape[1] for gamma, _ in knots)
    padded = [
        [np.pad(values, ((0, 0), (0, most - values.shape[1])), mode="edge") for values in one]
        for one in knots
    ]
    modes, driven, base = structures[0].modal(frequency)
    gamma = np.stack([gamma for gamma, _ in padded], axis=1)
    return Balance(
        modes, np.array([one.shape for one in structures]),
        (driven / length[:, None]).astype(complex), base / length, gamma,
        np.stack([force for _, force in padded], axis=1), (np.diff(gamma) > 0).sum(axis=2),
    )  # fmt: skip


def _arranged(found: Any, balances: Any, length: Floats, levels: int) -> tuple[Floats, Truths]:
    """Amplitudes (d, l, f, s) [m] and whether they are stable (l, f, s), from the solutions."""
    many, room = found.level.shape
    f, s = np.nonzero(np.arange(room) < found.number)
    level, z = found.level[f, s], found.z[f, s]
    modes = z[:, 0:-1:2] + 1j * z[:, 1:-1:2]
    y = balances.base[f, None] * z[:, -1:] + modes @ balances.shapes.T  # (n, d)
    cell = level * many + f
    order = np.argsort(cell, kind="stable")
    each = np.bincount(cell, minlength=levels * many)
    place = np.empty(len(cell), np.int64)
    place[order] = np.arange(len(cell)) - np.repeat(np.cumsum(each) - each, each)
    shape = (levels, many, max(int(each.max(initial=0)), 1))
    amplitude = np.full((len(balances.shapes), *shape), math.nan)
    amplitude[:, level, f, place] = (np.abs(y) * length[f, None]).T
    stable = np.zeros(shape, np.bool_)
    stable[level, f, place] = found.stable[f, s]
    return amplitude, stable
