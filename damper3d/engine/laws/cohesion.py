"""Cohesion of spheres: the normal forces of DMT and JKR, as LAMMPS's pair_style granular has them.

With the reduced radius R and modulus E, the contact radius a, the overlap d and the energy g of
each of the two surfaces [J/m2] (LAMMPS's gamma; the work of adhesion is 2 g):

    DMT     F = (4/3) E sqrt(R) d^1.5 - 4 pi g R,       d > 0
    JKR     F = (4/3) E a^3/R - 2 pi a^2 sqrt(4 g E/(pi a)),      d = a^2/R - 2 sqrt(pi g a/E)

(Derjaguin, Muller and Toporov, J. Colloid Interface Sci. 53 (1975) 314; Johnson, Kendall and
Roberts, Proc. R. Soc. A 324 (1971) 301.) A JKR contact begins at d = 0 and lasts, with a neck,
until the force is the pull-off force -3 pi g R, at a^3 = 9 pi g R^2/(4 E) and d = -a^2/(3 R): what
its neck holds there is lost. DMT's begins and ends at d = 0, so that its potential, from 0 there,
gives back what it takes.

Friction is limited by mu |F + 2 F_p|, F_p the pull-off force, 4 pi g R or 3 pi g R (Thornton, J.
Phys. D 24 (1991) 1942; LAMMPS).
"""

from typing import NamedTuple

import numpy as np

from granulab.contact.jit import inlined


class Dmt(NamedTuple):
    """Marks a law with DMT's cohesion."""

    pull: float = 4.0  # pull-off force over pi g R


class Jkr(NamedTuple):
    """Marks a law with JKR's cohesion."""

    pull: float = 3.0


@inlined
def dmt_force(stiffness, overlap, radius, surface):
    """Elastic and adhesive force [N], and the pull-off force; stiffness: Hertz's F/d [N/m]."""
    pull = 4.0 * np.pi * surface * radius if overlap > 0.0 else 0.0
    return stiffness * overlap - pull, pull


@inlined
def dmt_energy(stiffness, overlap, radius, surface):
    """Energy that the contact holds [J], from 0 where it begins."""
    return (0.4 * stiffness * overlap - 4.0 * np.pi * surface * radius) * overlap


@inlined
def jkr_contact_radius(modulus, radius, surface, overlap):
    """The a [m] of an overlap, down to that of the pull-off.

    The larger root of the quartic a^4 - 2 R d a^2 - (4 pi g R^2/E) a + R^2 d^2 = 0.
    """
    product, energy = radius * overlap, np.pi * surface * radius * radius / modulus
    square = product * product
    first = 27.0 * energy * energy
    second = 8.0 * square * product
    root = np.sqrt(max(energy * energy * (first + 2.0 * second), 0.0))
    cube = (first + second + 3.0 * np.sqrt(3.0) * root) ** (1.0 / 3.0)
    resolvent = 4.0 * square / cube + cube
    half = np.sqrt(max(2.0 * product + resolvent, 0.0))
    rest = 4.0 * product - resolvent + 6.0 * np.sqrt(6.0) * energy / half
    return (half + np.sqrt(max(rest, 0.0))) / np.sqrt(6.0)


@inlined
def jkr_force(modulus, radius, surface, contact_radius):
    """Elastic and adhesive force [N], and the pull-off force."""
    a = contact_radius
    force = 4.0 / 3.0 * modulus * a * a * a / radius
    force -= 4.0 * a * np.sqrt(np.pi * surface * modulus * a)
    return force, (3.0 * np.pi * surface * radius if a > 0.0 else 0.0)


@inlined
def jkr_energy(modulus, radius, surface, contact_radius):
    """Energy that the contact holds [J], from 0 where it begins: the integral of F over d.

    With c = sqrt(pi g/E): E (8 a^5/(15 R^2) - 8 c a^3.5/(3 R) + 2 c^2 a^2), less that of d = 0,
    where a^1.5 = 2 c R.
    """
    c = np.sqrt(np.pi * surface / modulus)
    a, first = contact_radius, (2.0 * c * radius) ** (2.0 / 3.0)
    return modulus * (_jkr_integral(c, radius, a) - _jkr_integral(c, radius, first))


@inlined
def _jkr_integral(c, radius, a):
    over = a / radius
    return a * a * (8.0 / 15.0 * a * over * over - 8.0 / 3.0 * c * over * np.sqrt(a) + 2.0 * c * c)


@inlined
def jkr_reach(modulus, radius, surface):
    """Distance of the surfaces at which a JKR contact ends [m]."""
    a = (9.0 * np.pi * surface * radius * radius / (4.0 * modulus)) ** (1.0 / 3.0)
    return a * a / (3.0 * radius)
