"""Closed forms of contacts in the plane, for two like half-planes and plane strain.

E* = E/(2 (1 - nu^2)). K. L. Johnson, Contact Mechanics, 1985; loads are per unit depth.
"""

import numpy as np

from calibration.stiffness_fe.blocks import Elastic


def contact_modulus(material: Elastic) -> float:
    """E* of two bodies of one material [Pa]."""
    return material.youngs_modulus / (2 * (1 - material.poisson**2))


def hertz_half_width(load: float, radius: float, modulus: float) -> float:
    """a = sqrt(4 P R/(pi E*)) [m] (Johnson eq. 4.43)."""
    return float(np.sqrt(4 * load * radius / (np.pi * modulus)))


def hertz_pressure(x: np.ndarray, load: float, half_width: float) -> np.ndarray:
    """p = 2 P/(pi a) sqrt(1 - (x/a)^2) [Pa] (Johnson eqs 4.44, 4.45)."""
    inside = np.clip(1 - (x / half_width) ** 2, 0, None)
    return 2 * load / (np.pi * half_width) * np.sqrt(inside)


def stick_half_width(half_width: float, drag: float, load: float, friction: float) -> float:
    """c = a sqrt(1 - Q/(mu P)) [m]: Cattaneo 1938, Mindlin 1949 (Johnson eq. 7.28)."""
    return float(half_width * np.sqrt(max(0.0, 1 - drag / (friction * load))))


def westergaard_share(pressure: float, amplitude: float, wave: float, modulus: float) -> float:
    """2 a/lambda of a wavy surface of this amplitude that is pressed on a flat one.

    Mean pressure p = p* sin^2(pi a/lambda), p* = pi E* amplitude/lambda (Westergaard 1939;
    Johnson eq. 13.7 and 13.8).
    """
    full = np.pi * modulus * amplitude / wave
    return float(2 / np.pi * np.arcsin(np.sqrt(min(1.0, pressure / full))))
