"""A contact law of one's own: a spring that stiffens with the overlap, f = k d^(3/2), in a silo."""

from dataclasses import replace
from typing import NamedTuple

from silo2d import SiloCase, register_law, run


class Stiffening(NamedTuple):
    """Constants of the law."""

    k: float  # [N/m^1.5]
    kt: float  # tangential stiffness [N/m]
    mu: float  # friction [-]
    gamma_n: float  # dashpots [1/s]
    gamma_t: float


def normal_force(law, m, overlap, overlap_rate):
    damping = m * law.gamma_n * overlap_rate
    return law.k * overlap * overlap**0.5 + damping, damping


def normal_energy(law, overlap):
    return 0.4 * law.k * overlap**2 * overlap**0.5


def slip_limit(law, overlap):
    return law.mu * law.k * overlap * overlap**0.5 / law.kt


register_law(
    Stiffening, normal_force=normal_force, normal_energy=normal_energy, slip_limit=slip_limit
)

if __name__ == "__main__":
    law = Stiffening(k=1e9, kt=6.5e5, mu=0.38, gamma_n=6000.0, gamma_t=3.0)
    case = replace(SiloCase.load("A4"), particle_law=law, wall_law=law)
    result = run(case)
    print(result.outcome, result.discharge_time_s, result.energy_closure)
