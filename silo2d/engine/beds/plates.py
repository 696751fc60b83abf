"""Friction of the front and the back plate on the faces of the prisms.

The contacts of a particle press on it; its mean pressure in the plane, over its area A and its
length L, is

    p = sum f_c l_c / (2 A L)

f_c the elastic normal force of contact c [N], l_c how far it acts from the centroid along its
normal [m] (the trace of the stress of one particle, e.g. Bagi, Mech. Mater. 22 (1996) 165). Across
the plane stands K p, K the lateral pressure ratio, on two faces of area A with the friction mu:

    F = 2 mu K p A = mu K sum f_c l_c / L     opposes the velocity, or holds up to it
    M = F (2/3) sqrt(A/pi)                    opposes the rotation: F over a disc of that area

Force and couple are taken each by itself, as if the other were not: for a particle that slides and
rotates at once this is too much. Both stop the particle within a step where they can, and no more:
Coulomb's law, implicit in the velocity.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import types

from granulab.contact.jit import inner, specialised, uncounted
from granulab.contact.laws import normal_force
from silo2d.engine.forces import edge_to_vertex
from silo2d.engine.geometry import rotated
from silo2d.engine.pair_law import law_of
from silo2d.engine.state import (
    COS,
    FRICTION,
    FX,
    FY,
    INNER,
    INV_INERTIA,
    INV_MASS,
    LIVE,
    OMEGA,
    PARTICLE_INNER,
    PARTICLE_WALL,
    SIN,
    TORQUE,
    VX,
    VY,
    X,
    Y,
)


class Plates(NamedTuple):
    """Front and back plate."""

    friction: float  # mu [-]
    ratio: float  # K [-]
    length: float  # L of the prisms [m]
    arm: np.ndarray  # (n_particles,) of the couple, (2/3) sqrt(A/pi) [m]
    pressing: np.ndarray  # (n_particles,) sum f_c l_c [N m], made again each step


@uncounted
def rub(world, plates):
    """Add what the plates do in this step to forces and torques, and what they dissipate."""
    row, counts, dt = world.bodies.row, world.counts, world.time_step
    press(world, plates)
    lost = 0.0
    for k in range(counts[LIVE]):
        i = world.bodies.live[k]
        most = plates.friction * plates.ratio * max(plates.pressing[i], 0.0) / plates.length
        vx = row[i, VX] + row[i, FX] * row[i, INV_MASS] * dt
        vy = row[i, VY] + (row[i, FY] * row[i, INV_MASS] - world.gravity) * dt
        omega = row[i, OMEGA] + row[i, TORQUE] * row[i, INV_INERTIA] * dt
        stopping = np.sqrt(vx * vx + vy * vy) / (row[i, INV_MASS] * dt)
        held = most / max(stopping, most) if most > 0.0 else 0.0  # at most what stops it
        fx, fy = -held * vx / (row[i, INV_MASS] * dt), -held * vy / (row[i, INV_MASS] * dt)
        most *= plates.arm[i]
        stopping = abs(omega) / (row[i, INV_INERTIA] * dt)
        held_rotation = most / max(stopping, most) if most > 0.0 else 0.0
        torque = -held_rotation * omega / (row[i, INV_INERTIA] * dt)
        row[i, FX] += fx
        row[i, FY] += fy
        row[i, TORQUE] += torque
        # At the mean of the velocities before and after: the work on the kinetic energy.
        lost -= 0.5 * fx * (row[i, VX] + (1.0 - held) * vx)
        lost -= 0.5 * fy * (row[i, VY] + (1.0 - held) * vy)
        lost -= 0.5 * torque * (row[i, OMEGA] + (1.0 - held_rotation) * omega)
    world.account[PARTICLE_WALL + FRICTION] += lost * dt


@inner
def press(world, plates):
    """Sum of elastic normal forces times their distance from the centroid, of each particle."""
    row, inner, counts = world.bodies.row, world.inner, world.counts
    pressing = plates.pressing
    for k in range(counts[LIVE]):
        pressing[world.bodies.live[k]] = 0.0
    for n in range(counts[INNER]):
        j, i = inner.vertex_body[n], inner.edge_body[n]
        between = row[j, X] - row[i, X], row[j, Y] - row[i, Y]
        arm_v = rotated(row[j, COS], row[j, SIN], (inner.vertex_x[n], inner.vertex_y[n]))
        dx, dy = edge_to_vertex(row, inner, n, between, arm_v)
        distance = np.sqrt(dx * dx + dy * dy)
        overlap = inner.cutoff[n] - distance
        if overlap <= 0.0:
            continue
        nx, ny = dx / distance, dy / distance
        depth = inner.depth[n] - 0.5 * overlap
        x, y = arm_v[0] - depth * nx, arm_v[1] - depth * ny
        if n < counts[PARTICLE_INNER]:
            force, _ = normal_force(law_of(world.particle_law, n), inner.mass[n], overlap, 0.0)
        else:
            force, _ = normal_force(law_of(world.wall_law, n), inner.mass[n], overlap, 0.0)
        if j < len(pressing):
            pressing[j] -= force * (x * nx + y * ny)
        if i < len(pressing):
            pressing[i] += force * ((between[0] + x) * nx + (between[1] + y) * ny)


def rub_plates(world: Any, plates: Plates | None) -> None:
    """Let the plates rub, where there are any."""
    if plates is not None:
        rub(world, plates)


@specialised(rub_plates)
def _rub_plates(world, plates):
    if isinstance(plates, types.NoneType):
        return lambda world, plates: None
    return lambda world, plates: rub(world, plates)
