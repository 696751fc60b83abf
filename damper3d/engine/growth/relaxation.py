"""Relaxation: particles that overlap go down the energy of the overlaps, by FIRE.

The energy is the sum of overlap^2/2; particles have unit mass and springs unit stiffness (FIRE:
Bitzek et al. 2006, 10.1103/PhysRevLett.97.170201). Which particles they are, and between which
walls, is said by the type of the bed: spheres (spheres.py), multi-sphere particles of a world
(multisphere.py), or such in a periodic cell (periodic.py). Each pushes and displaces its own.
"""

from collections.abc import Callable

import numpy as np

from granulab.contact.jit import njit

# How a relaxation ends. Where a list is full, the caller makes it longer and comes back.
PUSHED, AT_REST, JAMMED, IMPATIENT, OUTER_FULL, INNER_FULL = range(6)

_STAGES = 24  # of equal growth of the radius, from the first size to the full one
MARGIN = 1e-3  # that particles grow beyond their size: they end without an overlap
TOLERANCE = 1e-3  # overlap over radius that ends a stage; at most twice the margin
PATIENCE = 4000  # steps of a stage; those that end take some ten to a few hundred

# FIRE's constants, as published.
_LONGEST, _GROW, _SHRINK, _MIX, _MIX_SHRINK, _WAIT = 0.5, 1.1, 0.5, 0.1, 0.99, 5
_FIRST_PACE = 0.1, _MIX, 0


def first_size(fill_ratio: float, start: float) -> float:
    """Size [-] at which a fill ratio of full size is a smaller one, to start with; at most 1."""
    return min((start / fill_ratio) ** (1 / 3), 1.0)


def grow_to_size(first: float, comes_to_rest: Callable[[float], bool]) -> float:
    """Let particles grow in stages from their first size [-] to 1; the size that they reached.

    comes_to_rest gives them a size and says whether they found a place without overlaps.
    """
    reached = first
    for size in np.linspace(first, 1.0, _STAGES + 1)[1:]:
        if not comes_to_rest(float(size)):
            break
        reached = float(size)
    return float(reached)


def push_apart(bed, force):
    """Set what pushes (and turns) each particle; PUSHED or why not, deepest overlap, mean push."""


def displace(bed, velocity, dt):
    """Move (and rotate) the particles of a bed."""


@njit
def relax(bed, velocity, force, allowed, patience, steady):
    """Move the particles until no overlap is above `allowed`; how it ended.

    Also the deepest overlap and the steps taken. velocity and force: room of as many numbers as the
    particles have degrees of freedom. JAMMED: the rms force on a particle is below `steady` times
    the mean push on one, so that overlaps stay; not asked where steady is 0.
    """
    velocity[:] = 0.0
    pace = _FIRST_PACE
    deepest = 0.0
    for step in range(patience):
        outcome, deepest, mean_push = push_apart(bed, force)
        if outcome != PUSHED:
            return outcome, deepest, step
        if deepest <= allowed:
            return AT_REST, deepest, step
        if steady > 0.0 and np.sqrt(np.sum(force**2) / len(force)) < steady * mean_push:
            return JAMMED, deepest, step
        pace = descend(velocity, force, pace)
        displace(bed, velocity, pace[0])
    return IMPATIENT, deepest, patience


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
