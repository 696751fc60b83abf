"""Janssen's law: vertical stress in a prismatic silo whose walls carry a part of the weight.

A slice of area A and perimeter U, of unit weight gamma, pressed by K sigma from the walls and held
by mu times that, is balanced by

    d sigma/dz = gamma - (U/A) mu K sigma,   sigma(0) = 0
    sigma(z) = gamma z_o (1 - exp(-z/z_o)),   z_o = (A/U)/(mu K)

(Janssen 1895; EN 1991-4:2006, eqs 5.1 to 5.6). Between two plane walls W apart A/U = W/2.
"""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def janssen_stress(
    depth: Floats | float, density: float, friction_times_ratio: float, width: float
) -> Floats:
    """Vertical stress at a depth z (...): [Pa] for a unit weight in N/m3, [N/m] for one in N/m2.

    friction_times_ratio: mu K [-], 0 for the hydrostatic limit; width: 2 A/U [m], of two plane
    walls their distance.
    """
    depth = np.asarray(depth, dtype=float)
    if friction_times_ratio == 0:
        return density * depth
    length = width / (2 * friction_times_ratio)
    return -density * length * np.expm1(-depth / length)
