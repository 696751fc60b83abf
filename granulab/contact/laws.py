"""The contact laws: from overlap, rates and slip to force. The only place where a force stands.

Conventions, everywhere in the project: the normal n points from body i to body j, the force is
that on j (i takes its opposite), velocities are those of j relative to i at the contact point,
the overlap d is positive in contact, and its rate d' is positive while the bodies approach.

Linear spring and dashpot with Coulomb slip (wood-silo paper, eqs 2.1-2.3; the preprint has
eq. 2.2, which the journal lost: Fe_n = -kn dxn n, Fe_t = -kt dxt t):

    f_n = kn d + m gamma_n d'                              m = m_i m_j / (m_i + m_j)
    f_t = -kt s - m gamma_t s'           |kt s| <= mu kn d

s is the slip: the tangential displacement that the spring still holds. The Coulomb limit caps
the elastic parts alone and both dashpots come on top, as the paper says. A tangent space has
one dimension in the plane and two (three components) in space: slips are tuples of either.
"""

from typing import NamedTuple

from granulab.contact.jit import njit
from granulab.contact.vectors import add, dot, norm, scale


class LinearLaw(NamedTuple):
    """Constants of the linear law for one pair of materials."""

    kn: float  # normal stiffness [N/m]
    kt: float  # tangential stiffness [N/m], > 0
    mu: float  # coefficient of friction [-]
    gamma_n: float  # normal damping [1/s]
    gamma_t: float  # tangential damping [1/s]
    pulls: bool  # True: the contact ends at zero overlap; False: it ends at zero force


@njit
def normal_force(law, m, overlap, overlap_rate):
    """Normal force [N] and the part of it that is not elastic [N] (its power is dissipated).

    A contact that ends at zero overlap may pull shortly before it; one that ends at zero force
    may not.
    """
    elastic = law.kn * overlap
    force = elastic + m * law.gamma_n * overlap_rate
    if not law.pulls:
        force = max(force, 0.0)
    return force, force - elastic


@njit
def coulomb(trial, limit):
    """The slip that the spring can hold: the tuple `trial` [m], no longer than `limit` [m]."""
    if len(trial) == 1:  # a number needs no root: this is the innermost loop of the plane
        return (min(max(trial[0], -limit), limit),)
    size = norm(trial)
    return scale(limit / size, trial) if size > limit else trial


@njit
def tangential_force(law, m, overlap, slip, slip_step, slip_rate):
    """Tangential force [N], the slip that is kept [m], and what friction dissipates [J].

    slip: what the spring held before [m]; slip_step: displacement since then [m]; slip_rate:
    velocity now [m/s]; all tuples in the tangent space. Friction takes the mean elastic force of
    the step over the displacement that the spring did not follow, which is second order in the
    step; the energy that the spring loses, (1/2) kt (trial^2 - held^2), would be first order.
    """
    trial = add(slip, slip_step)
    held = coulomb(trial, law.mu * law.kn / law.kt * overlap)
    force = add(scale(-law.kt, held), scale(-m * law.gamma_t, slip_rate))
    rubbed = 0.5 * law.kt * dot(add(slip, held), add(trial, scale(-1.0, held)))
    return force, held, rubbed
