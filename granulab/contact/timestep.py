"""The largest stable time step, from all contacts of the stiffest configuration at once.

A configuration of contacts is a Jacobian J: each row maps the velocities of the bodies into
the rate of one contact spring. With the springs' constants k and the inverse masses M^-1, the
highest squared frequency is the largest eigenvalue of M^-1/2 J^T k J M^-1/2; with the dashpots'
constants in place of k, it is the highest damping rate.

The integrator (leapfrog; damping from the velocity extrapolated by half a step) applied to
x'' + gamma x' + omega^2 x = 0 first fails where its root passes z = -1:

    (omega dt)^2 + 4 gamma dt = 4.

Spheres have Rayleigh's step instead, the time in which a surface wave crosses one (granular-damper
thesis, eq. 3.31).
"""

import math

import numpy as np

from granulab.contact.reduced import shear_modulus


def highest_rate(jacobian: np.ndarray, constants: np.ndarray, inverse_mass: np.ndarray) -> float:
    """Largest eigenvalue of M^-1/2 J^T diag(constants) J M^-1/2.

    jacobian (n_springs, n_dof); constants (n_springs,), stiffness [N/m] or damping [kg/s];
    inverse_mass (n_dof,), [1/kg] or [1/(kg m2)]. Returns [1/s2] or [1/s].
    """
    scaled = jacobian * np.sqrt(inverse_mass)
    return float(np.linalg.eigvalsh(scaled.T @ (constants[:, None] * scaled))[-1])


def stable_time_step(omega_squared: float, gamma: float) -> float:
    """The largest stable step [s] for a squared frequency [1/s2] and a damping rate [1/s]."""
    # The positive root of the line above, written so that nothing cancels.
    return 2.0 / (gamma + math.sqrt(gamma**2 + omega_squared))


def rayleigh_time_step(
    radius: float, density: float, youngs_modulus: float, poisson: float
) -> float:
    """Eq. 3.31: pi R sqrt(rho/G)/(0.1631 nu + 0.8766) [s]; a step of 0.1 to 0.4 of it is safe.

    radius [m] of the smallest sphere, density [kg/m3], youngs_modulus [Pa], poisson [-].
    """
    slowness = math.sqrt(density / shear_modulus(youngs_modulus, poisson))
    return math.pi * radius * slowness / (0.1631 * poisson + 0.8766)
