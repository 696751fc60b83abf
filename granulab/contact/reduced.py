"""Reduced quantities of a pair of bodies: mass, radius, modulus, shear modulus.

Granular-damper thesis, eqs 5.5, 5.6, 5.9 and 5.14; erratum: eq. 5.6 has (1 - nu^2).
"""

import math

from granulab.contact.jit import njit


@njit
def reduced_mass(inverse_mass_i, inverse_mass_j):
    """m_i m_j / (m_i + m_j) [kg], from inverse masses [1/kg]: a wall has inverse mass zero.

    Eq. 5.9.
    """
    return 1.0 / (inverse_mass_i + inverse_mass_j)


@njit
def reduced_radius(curvature_i, curvature_j):
    """Eq. 5.5: 1 / (1/R_i + 1/R_j) [m], from curvatures [1/m].

    A sphere has 1/R, a plane zero, the inside of a cylinder -1/D (see bore_curvature).
    """
    return 1.0 / (curvature_i + curvature_j)


@njit
def bore_curvature(diameter):
    """Mean curvature [1/m] of the inside of a cylinder of that diameter [m]: -1/D.

    It is -2/D across the axis and none along it. A sphere of radius r then has the reduced
    radius r D/(D - r). The thesis takes the wall as flat, with curvature 0.
    """
    return -1.0 / diameter


def shear_modulus(youngs_modulus: float, poisson: float) -> float:
    """E / (2 (1 + nu)) [Pa] of an isotropic solid."""
    return youngs_modulus / (2.0 * (1.0 + poisson))


def reduced_modulus(
    modulus_i: float, poisson_i: float, modulus_j: float, poisson_j: float
) -> float:
    """Eq. 5.6 as it holds: 1 / ((1 - nu_i^2)/E_i + (1 - nu_j^2)/E_j) [Pa].

    A rigid body has the modulus math.inf.
    """
    return 1.0 / ((1.0 - poisson_i**2) / modulus_i + (1.0 - poisson_j**2) / modulus_j)


def reduced_shear_modulus(
    modulus_i: float, poisson_i: float, modulus_j: float, poisson_j: float
) -> float:
    """Eq. 5.14: 1 / ((2 - nu_i)/G_i + (2 - nu_j)/G_j) [Pa], from Young's moduli [Pa].

    A rigid body has the modulus math.inf.
    """
    compliance_i = (2.0 - poisson_i) / shear_modulus(modulus_i, poisson_i)
    compliance_j = (2.0 - poisson_j) / shear_modulus(modulus_j, poisson_j)
    return 1.0 / (compliance_i + compliance_j)


def sphere_mass(radius: float, density: float) -> float:
    """(4/3) pi R^3 rho [kg]."""
    return 4.0 / 3.0 * math.pi * radius**3 * density
