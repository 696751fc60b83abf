"""Mindlin and Deresiewicz exactly: the tangential force of spheres in partial slip; a reference.

Where the simplified law (contact/hertz.py) has one spring that sticks or slides, the contact area
of two spheres slides from its rim inwards. Under a constant normal force N, with kt = 8 G a, a the
radius of the contact area, the force after a displacement s from nothing is

    T(s) = mu N (1 - (1 - 2 kt s/(3 mu N))^(3/2))   up to s = 3 mu N/(2 kt),  then mu N,

whose slope kt sqrt(1 - 2 kt s/(3 mu N)) is the bracket of the granular-damper thesis's eq. 5.13
(erratum: its root is over Req times the overlap). Reversed at (s', T') it goes as
T' - 2 T((s' - s)/2), and forwards again likewise (Mindlin and Deresiewicz 1953, J. Appl. Mech.
20, 327).

For any history of normal and tangential displacement (the kernel below) the contact is a row of
independent springs: at the distance x from the middle a spring of stiffness 4 G per length holds
while its force is below mu E (d - x^2/R), per length too, E the reduced modulus, d the overlap.
Summed over x^2 < R d they give Hertz's force, 8 G a, and the curves above, and they follow the
exact theory through loading and unloading of both kinds, since every such history is a sum of
Hertz distributions (Jaeger 1993, Arch. Appl. Mech. 63, 534; Popov and Hess 2014, Facta Univ.
Mech. Eng. 12, 1: the method of dimensionality reduction). Each spring is passive: no history gains
energy. With a dashpot the pressure is that of the damped normal force, spread as Hertz has it.
"""

import numpy as np

from granulab.contact.jit import njit
from granulab.contact.vectors import add, dot, norm, scale

N_SPRINGS = 400  # the sum over springs is exact to 1/N_SPRINGS^2


def loading_force(kt: float, limit: float, displacement: np.ndarray) -> np.ndarray:
    """T(s) [N] for stiffness kt [N/m], limit mu N [N] and displacements s >= 0 [m]."""
    held = np.clip(1.0 - 2.0 * kt * np.asarray(displacement) / (3.0 * limit), 0.0, None)
    return limit * (1.0 - held**1.5)


def turned_force(
    kt: float, limit: float, displacement: np.ndarray, reversal: float, force: float
) -> np.ndarray:
    """The force [N] after a reversal at displacement `reversal` [m] and `force` [N], either way."""
    back = reversal - np.asarray(displacement)
    way = np.sign(back)
    return force - 2.0 * way * loading_force(kt, limit, 0.5 * np.abs(back))


@njit
def partial_slip_force(
    law, stiffness, dashpot, normal_force, normal, overlap, area, springs, reach, half_step, rate
):  # fmt: skip
    """Tangential force [N] and what is dissipated, in place of contact.hertz.mindlin_force.

    stiffness, dashpot, normal_force: of hertz_force; normal: unit vector; overlap [m]; area: the
    radius of the contact area, sqrt(R d) [m]; springs (N, 3): displacements [m] of the springs
    from the middle of the contact to `reach` [m], half a step ahead, which are changed; half_step:
    displacement in half a step [m]; rate: slip velocity [m/s]. Returns the force, the power of the
    dashpot [W], the energy lost to friction in this step [J] and that of the springs [J].
    """
    n_springs = len(springs)
    width = reach / n_springs
    pressed = law.mu * max(normal_force, 0.0)
    elastic = stiffness * overlap
    share = pressed / elastic if elastic > 0.0 else 0.0  # of the elastic pressure
    total, friction, energy, stuck = (0.0, 0.0, 0.0), 0.0, 0.0, 0
    for k in range(n_springs):
        covered = min(max(area - k * width, 0.0), width)
        if covered == 0.0:
            springs[k, 0] = springs[k, 1] = springs[k, 2] = 0.0
            continue
        # Both sides of the middle: 2 x 4 G and 2 x E (d - x^2/R) a length, R d = area^2.
        x, y = k * width / area, (k * width + covered) / area
        constant = law.tangential * law.hertz * covered
        depth = overlap * area * (y - x - (y**3 - x**3) / 3.0)
        limit = share * 1.5 * law.hertz * depth
        ahead = springs[k, 0], springs[k, 1], springs[k, 2]
        trial = add(add(ahead, scale(-dot(ahead, normal), normal)), half_step)
        size = constant * norm(trial)
        held = scale(limit / size, trial) if size > limit else trial
        if size <= limit:
            stuck += 1
        unfollowed = add(trial, scale(-1.0, held))
        step_ago = add(trial, scale(-2.0, half_step))
        friction += 0.5 * constant * dot(add(step_ago, held), unfollowed)
        energy += 0.5 * constant * dot(held, held)
        total = add(total, scale(-constant, held))
        springs[k, 0] = held[0] + half_step[0]
        springs[k, 1] = held[1] + half_step[1]
        springs[k, 2] = held[2] + half_step[2]
    damped = scale(-law.tangential_damping * dashpot, rate)
    damped = scale(_fitting(total, damped, pressed) if stuck > 0 else 0.0, damped)
    return add(total, damped), -dot(damped, rate), friction, energy


@njit
def _fitting(force, more, limit):
    """The largest part, at most 1, of `more` with which `force` stays within the Coulomb limit."""
    if norm(add(force, more)) <= limit:
        return 1.0
    a, b, c = dot(more, more), dot(force, more), dot(force, force) - limit**2
    if a == 0.0 or c >= 0.0:
        return 0.0
    return (np.sqrt(b * b - a * c) - b) / a
