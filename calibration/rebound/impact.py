"""Plane impact of a rigid body on a fixed surface: the equations of impulse and momentum.

An impulse p acts at the point of contact, at the arm r from the centroid (Brach 1991, Mechanical
Impact Dynamics, ch. 3; Stronge 2000, Impact Mechanics, ch. 3), with m the mass and k the radius of
gyration:

    v' - v = p/m        omega' - omega = (r x p)/(m k^2)        u = v + omega x r

u is the velocity of the point of contact. Along the normal, u_n' = -e u_n (Newton's restitution at
the point: what a contact law has); the centroid's own ratio -v_n'/v_n also holds what the rotation
took or gave, and is no property of the contact. Components are (t, n): n away from the surface, t
to its right; omega counts from t to n, counter-clockwise where n is upwards.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Motion(NamedTuple):
    """Velocity of the centroid along the tangent and the normal, and angular velocity."""

    t: float
    n: float
    omega: float


class Arm(NamedTuple):
    """The point of contact, from the centroid."""

    t: float
    n: float


class Energy(NamedTuple):
    """Kinetic energy per mass: of the centroid's motion along normal and tangent, of rotation."""

    normal: float
    tangential: float
    rotational: float

    @property
    def whole(self) -> float:
        """The sum."""
        return self.normal + self.tangential + self.rotational


def at_contact(motion: Motion, arm: Arm) -> tuple[float, float]:
    """Velocity u of the point of contact: tangential, normal."""
    return motion.t - motion.omega * arm.n, motion.n + motion.omega * arm.t


def energy(motion: Motion, gyration: float) -> Energy:
    """The three parts of the kinetic energy per mass."""
    return Energy(motion.n**2 / 2, motion.t**2 / 2, (gyration * motion.omega) ** 2 / 2)


def mobility(arm: Arm, gyration: float) -> Array:
    """(2, 2) change of u per impulse per mass, tangential and normal."""
    t, n = arm.t / gyration, arm.n / gyration
    return np.array([[1 + n * n, -n * t], [-n * t, 1 + t * t]])


def after_impulse(motion: Motion, arm: Arm, gyration: float, impulse: Array) -> Motion:
    """The motion after an impulse per mass (tangential, normal) at the point of contact."""
    t, n = float(impulse[0]), float(impulse[1])
    return Motion(motion.t + t, motion.n + n, motion.omega + (arm.t * n - arm.n * t) / gyration**2)


def after_impact(
    motion: Motion, arm: Arm, gyration: float, restitution: float, tangential: float,
    friction: float = np.inf,
) -> Motion:  # fmt: skip
    """The motion after an impact with Newton's restitution at the point of contact.

    tangential   ratio -u_t'/u_t that friction brings about where it suffices, -1 to 1
    friction     the largest ratio of the tangential impulse to the normal one; where it does not
                 suffice the point slides throughout
    """
    u = np.array(at_contact(motion, arm))
    change = np.array([-(1 + tangential) * u[0], -(1 + restitution) * u[1]])
    matrix = mobility(arm, gyration)
    impulse = np.linalg.solve(matrix, change)
    if abs(impulse[0]) > friction * impulse[1]:
        ratio = float(np.copysign(friction, impulse[0]))
        normal = change[1] / (matrix[1, 1] + matrix[1, 0] * ratio)
        impulse = np.array([ratio * normal, normal])
    return after_impulse(motion, arm, gyration, impulse)
