"""Relaxation: particles that overlap go down the energy of the overlaps, by FIRE.

The energy is the sum of overlap^2/2; particles have unit mass and springs unit stiffness (FIRE:
Bitzek et al. 2006, 10.1103/PhysRevLett.97.170201). Which particles they are, and between which
walls, is said by the type of the bed: spheres (spheres.py), multi-sphere particles of a world
(multisphere.py), or such in a periodic cell (periodic.py). Each pushes and displaces its own.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from granulab.contact.jit import njit

Grown = Callable[[float], None]  # takes the part (0 to 1) of a growth that is over

# How a relaxation ends. Where a list is full, the caller makes it longer and comes back.
PUSHED, AT_REST, JAMMED, IMPATIENT, OUTER_FULL, INNER_FULL = range(6)

_STAGES = 24  # of equal growth of the radius, from the first size to the full one
MARGIN = 1e-3  # that particles grow beyond their size: they end without an overlap
TOLERANCE = 1e-3  # overlap over radius that ends a stage; at most twice the margin
PATIENCE = 4000  # steps of a stage; those that end take some ten to a few hundred

# Particles times steps of a call of the kernel, which hears no Ctrl-C: a tenth of a second or so.
_AT_A_TIME = 20_000

# FIRE's constants, as published.
_LONGEST, _GROW, _SHRINK, _MIX, _MIX_SHRINK, _WAIT = 0.5, 1.1, 0.5, 0.1, 0.99, 5
_FIRST_PACE = 0.1, _MIX, 0


def first_size(fill_ratio: float, start: float) -> float:
    """Size [-] at which a fill ratio of full size is a smaller one, to start with; at most 1."""
    return min((start / fill_ratio) ** (1 / 3), 1.0)


def grow_to_size(
    first: float, comes_to_rest: Callable[[float], bool], grown: Grown | None = None
) -> float:
    """Let particles grow in stages from their first size [-] to 1; the size that they reached.

    comes_to_rest gives them a size and says whether they found a place without overlaps; grown is
    called with the part (0 to 1) of the stages that is over.
    """
    reached = first
    for k, size in enumerate(np.linspace(first, 1.0, _STAGES + 1)[1:], 1):
        if not comes_to_rest(float(size)):
            break
        reached = float(size)
        if grown is not None:
            grown(k / _STAGES)
    return float(reached)


def push_apart(bed, force):
    """Set what pushes (and turns) each particle; PUSHED or why not, deepest overlap, mean push."""


def displace(bed, velocity, dt):
    """Move (and rotate) the particles of a bed."""


def relax(
    bed: Any, velocity: np.ndarray, force: np.ndarray, allowed: float, patience: int, steady: float
) -> tuple[int, float, int]:
    """Move the particles until no overlap is above `allowed`; how it ended.

    Also the deepest overlap and the steps taken. velocity and force: room of as many numbers as the
    particles have degrees of freedom. JAMMED: the rms force on a particle is below `steady` times
    the mean push on one, so that overlaps stay; not asked where steady is 0.
    """
    velocity[:] = 0.0
    pace, taken = _FIRST_PACE, 0
    at_a_time = max(_AT_A_TIME // len(velocity), 1)
    while True:
        most = min(at_a_time, patience - taken)
        outcome, deepest, steps, pace = go_on(bed, velocity, force, allowed, most, steady, pace)
        taken += steps
        if outcome != IMPATIENT or taken == patience:
            return outcome, deepest, taken


@njit
def go_on(bed, velocity, force, allowed, patience, steady, pace):
    """Go on with a relaxation at FIRE's pace; see relax, and the pace to go on with."""
    deepest = 0.0
    for step in range(patience):
        outcome, deepest, mean_push = push_apart(bed, force)
        if outcome != PUSHED:
            return outcome, deepest, step, pace
        if deepest <= allowed:
            return AT_REST, deepest, step, pace
        if steady > 0.0 and np.sqrt(np.sum(force**2) / len(force)) < steady * mean_push:
            return JAMMED, deepest, step, pace
        pace = descend(velocity, force, pace)
        displace(bed, velocity, pace[0])
    return IMPATIENT, deepest, patience, pace


@njit
def descend(velocity, force, pace):
    """One step of FIRE: the velocities after it; and its time step, mix, and steps downhill."""
    dt, mix, downhill = pace
    power = np.sum(force * velocity)
    if power > 0.0:
        downhill += 1
        share = mix * np.sqrt(np.sum(velocity**2) / np.sum(force**2))
        velocity *= 1.0 - mix
        velocity += share * force
        if downhill > _WAIT:
            dt, mix = min(dt * _GROW, _LONGEST), mix * _MIX_SHRINK
    else:
        velocity[:] = 0.0
        dt, mix, downhill = dt * _SHRINK, _MIX, 0
    velocity += dt * force
    return dt, mix, downhill
