"""Walls that vibrate, all as one rigid body: x = x0 + A sin(2 pi f t) from the opening on.

As walls they have no inertia; the work of whatever moves them is accounted for with that of a
moving door. Their skin in the lists is the farthest that they come from where they were listed.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import types

from granulab.contact.jit import specialised, uncounted
from silo2d.engine.state import (
    FIRST,
    FX,
    GIVEN_TO_DOOR,
    STEP,
    UX,
    VERTEX_X,
    VERTEX_Y,
    VX,
    X,
    Y,
)


class Vibration(NamedTuple):
    """Motion of all walls."""

    amplitude: np.ndarray  # (2,) along x and y [m]
    omega: float  # 2 pi f [rad/s]
    home: np.ndarray  # (n_walls, 2) where they stand at rest [m]
    load: np.ndarray  # (n_walls, 2) forces added up before this step [N]


@uncounted
def note(world, vibration):
    """Put forces on the walls aside, so that those of this step alone do work."""
    row, first = world.bodies.row, len(world.bodies.live)
    for w in range(len(vibration.home)):
        for axis in range(2):
            vibration.load[w, axis] = row[first + w, FX + axis]
            row[first + w, FX + axis] = 0.0


@uncounted
def shake(world, vibration):
    """Move the walls to where they are now, account for the work, and put the forces back."""
    row, first = world.bodies.row, len(world.bodies.live)
    phase = vibration.omega * world.counts[STEP] * world.time_step
    for w in range(len(vibration.home)):
        for axis in range(2):
            amplitude = vibration.amplitude[axis]
            position = vibration.home[w, axis] + amplitude * np.sin(phase)
            path = position - row[first + w, X + axis]
            # The velocity of the time of the forces: second order in the step.
            power = row[first + w, FX + axis] * row[first + w, UX + axis]
            world.account[GIVEN_TO_DOOR] += power * world.time_step
            row[first + w, FX + axis] += vibration.load[w, axis]
            row[first + w, X + axis] = position
            row[first + w, VX + axis] = path / world.time_step
            row[first + w, UX + axis] = amplitude * vibration.omega * np.cos(phase)


@uncounted
def place(world, vibration):
    """Vertices of the walls in the silo's frame, for the lists."""
    bodies, first = world.bodies, len(world.bodies.live)
    for w in range(len(vibration.home)):
        for v in range(bodies.layout[first + w, FIRST], bodies.layout[first + w, FIRST] + 2):
            world.vertices[v, VERTEX_X] = bodies.row[first + w, X] + world.local[v, VERTEX_X]
            world.vertices[v, VERTEX_Y] = bodies.row[first + w, Y] + world.local[v, VERTEX_Y]


def note_loads(world: Any, vibration: Vibration | None) -> None:
    """See note; nothing where walls stand still."""
    if vibration is not None:
        note(world, vibration)


def shake_walls(world: Any, vibration: Vibration | None) -> None:
    """See shake; nothing where walls stand still."""
    if vibration is not None:
        shake(world, vibration)


def place_walls(world: Any, vibration: Vibration | None) -> None:
    """See place; nothing where walls stand still."""
    if vibration is not None:
        place(world, vibration)


@specialised(note_loads)
def _note_loads(world, vibration):
    if isinstance(vibration, types.NoneType):
        return lambda world, vibration: None
    return lambda world, vibration: note(world, vibration)


@specialised(shake_walls)
def _shake_walls(world, vibration):
    if isinstance(vibration, types.NoneType):
        return lambda world, vibration: None
    return lambda world, vibration: shake(world, vibration)


@specialised(place_walls)
def _place_walls(world, vibration):
    if isinstance(vibration, types.NoneType):
        return lambda world, vibration: None
    return lambda world, vibration: place(world, vibration)
