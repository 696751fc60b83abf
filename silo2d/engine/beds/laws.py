"""Laws of contacts that hold together, and of contacts with a measured curve of force.

CohesiveLaw: the linear law with a constant pull c while two bodies touch,

    f_n = kn d - c + m gamma_n d'          |kt s| <= mu kn d = mu (f_n + c)

the elastic parts alone in the limit (as Gilabert, Roux and Castellanos, Phys. Rev. E 75 (2007)
011303, and Rognon et al., J. Fluid Mech. 596 (2008) 21, have it): a static contact rests at
d = c/kn and takes a pull up to c. There is no bridge: it ends at zero overlap.

CurveLaw: the elastic force is any rising function of the overlap, F(d), straight between points of
even distance and beyond the last; gamma_n and kt are those of the linear law.
"""

from typing import NamedTuple

import numpy as np

from granulab.contact.jit import uncounted
from granulab.contact.laws import register


class CohesiveLaw(NamedTuple):
    """Constants of the linear law, and the pull of a contact."""

    kn: float  # [N/m]
    kt: float  # [N/m]
    mu: float  # [-]
    gamma_n: float  # [1/s]
    gamma_t: float  # [1/s]
    pulls: bool  # whether damping may pull on top of the cohesion
    pull: float  # c [N]


class CurveLaw(NamedTuple):
    """Constants of the linear law, kn the stiffest of the curve, and the curve."""

    kn: float  # [N/m]
    kt: float  # [N/m]
    mu: float  # [-]
    gamma_n: float  # [1/s]
    gamma_t: float  # [1/s]
    pulls: bool
    spacing: float  # of the points [m]
    force: np.ndarray  # (n,) at k times the spacing [N], 0 first
    energy: np.ndarray  # (n,) its integral [J]


def cohesive_force(law, m, overlap, overlap_rate):
    """Return the normal force [N] and its part that is not elastic [N].

    m is 0 of a pair that does not touch, whose force is 0.
    """
    held = law.pull if m > 0.0 else 0.0
    elastic = law.kn * overlap - held
    force = elastic + m * law.gamma_n * overlap_rate
    if not law.pulls:
        force = max(force, -held)
    return force, force - elastic


def cohesive_energy(law, overlap):
    """Return what the normal spring holds [J], less what the pull has done."""
    return 0.5 * law.kn * overlap**2 - law.pull * overlap


@uncounted
def elastic_force(law, overlap):
    """Return the force [N] of the curve at an overlap [m]."""
    at = overlap / law.spacing
    k = min(int(at), len(law.force) - 2)
    return law.force[k] + (at - k) * (law.force[k + 1] - law.force[k])


def curve_force(law, m, overlap, overlap_rate):
    """Return the normal force [N] and its part that is not elastic [N]."""
    elastic = elastic_force(law, overlap)
    force = elastic + m * law.gamma_n * overlap_rate
    if not law.pulls:
        force = max(force, 0.0)
    return force, force - elastic


def curve_energy(law, overlap):
    """Return the integral of the curve up to an overlap [J]."""
    at = overlap / law.spacing
    k = min(int(at), len(law.force) - 2)
    part = at - k
    rise = law.force[k + 1] - law.force[k]
    return law.energy[k] + law.spacing * part * (law.force[k] + 0.5 * part * rise)


def curve_slip_limit(law, overlap):
    """Return the largest slip [m] that the tangential spring holds: mu F(d)/kt."""
    return law.mu / law.kt * elastic_force(law, overlap)


register(CohesiveLaw, normal_force=cohesive_force, normal_energy=cohesive_energy)
register(
    CurveLaw, normal_force=curve_force, normal_energy=curve_energy, slip_limit=curve_slip_limit
)
