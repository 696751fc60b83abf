"""Hertz, simplified Mindlin and Tsuji: the contact law of spheres, from overlap and slip to force.

Granular-damper thesis, eqs 5.5-5.7, 5.14-5.16, 5.21-5.24, 5.32 and 5.33; errata: eq. 5.6 has
(1 - nu^2), eq. 5.24 has the overlap under its root, and kn of eq. 5.32 is the secant stiffness.
Conventions as in contact/laws.py. With the reduced radius R, modulus E, shear modulus G and mass
m of a pair, and the stiffnesses kn = (4/3) E sqrt(R d) and kt = 8 G sqrt(R d),

    f_n = kn d + c_n d',           c_n = sqrt(5) b sqrt(kn m)
    f_t = -(kt s + c_t s'),        c_t = sqrt(10/3) b sqrt(kt m),      |f_t| <= mu max(f_n, 0)

with b = -ln e / sqrt(ln^2 e + pi^2). While a contact slides it has no tangential dashpot, and
its spring holds the displacement mu f_n / kt (eq. 5.22).

The functions have no branch that a compiler could not turn into a selection: they stand in the
innermost loop. A contact that does not touch has overlap 0, and its forces are exact zeros.
"""

from typing import NamedTuple

import numpy as np

from granulab.contact.jit import njit
from granulab.contact.vectors import add, dot, norm, scale


class HertzLaw(NamedTuple):
    """Constants of one pair of materials; what depends on radii and masses comes with a contact."""

    hertz: float  # (4/3) E, E the reduced modulus [Pa]
    tangential: float  # kt / kn = 6 G / E [-]
    mu: float  # coefficient of friction [-]
    damping: float  # b, from the restitution below the yield velocity [-]
    tangential_damping: float  # c_t / (b sqrt(kn m)) = sqrt(10/3 kt/kn); 0: no such dashpot [-]
    yielding: float  # v_y sqrt(m / R^3), eq. 5.26 [kg^0.5/(m^0.5 s)]; inf: it does not yield
    pulls: bool  # True: the contact ends at zero overlap; False: it ends at zero force
    stored_force: bool  # True: the spring's force is carried on; False: its displacement


NORMAL = np.sqrt(5.0)  # of eq. 5.32


@njit
def hertz_force(law, hertz, mass, damping, overlap, overlap_rate):
    """Secant stiffness [N/m], dashpot b sqrt(kn m) [kg/s], normal force and its inelastic part [N].

    hertz is law.hertz times the root of the reduced radius [N/m^1.5]; mass is the reduced mass
    [kg]; damping is the b of this contact.
    """
    stiffness = hertz * np.sqrt(overlap)
    dashpot = damping * np.sqrt(stiffness * mass)
    elastic = stiffness * overlap
    force = elastic + NORMAL * dashpot * overlap_rate
    if not law.pulls:
        force = max(force, 0.0)
    return stiffness, dashpot, force, force - elastic


@njit
def carried_spring(law, held, ahead, normal, kt_before, kt, moved):
    """Carry the tangential spring on: held a step before, and held now if it does not slip.

    Both in the tangent plane of now. The displacement since then is the mean of the velocities of
    then and now times the step: half of it is known from then, `ahead` [m], the other half is
    `moved` [m]. held and what is returned: displacements [m], or forces [N] where the law stores
    these; tuples of three. kt_before, kt: tangential stiffness then and now [N/m].
    """
    held = add(held, scale(-dot(held, normal), normal))
    ahead = add(ahead, scale(-dot(ahead, normal), normal))
    if law.stored_force:
        return held, add(held, add(scale(kt_before, ahead), scale(kt, moved)))
    return held, add(held, add(ahead, moved))


@njit
def mindlin_force(law, stiffness, dashpot, normal_force, trial, slip_rate):
    """Tangential force [N], what the spring holds after slip, and the power of the dashpot [W].

    trial: what the spring would hold without slip, a displacement [m] or a force [N]; slip_rate:
    the velocity now [m/s]; tuples of three. The fourth that is returned is whether the contact
    slides (1.0 or 0.0). What is held is in the unit of trial.
    """
    kt = law.tangential * stiffness
    unit = 1.0 if law.stored_force else kt  # of what is held [N or N/m]
    wanted = add(scale(unit, trial), scale(law.tangential_damping * dashpot, slip_rate))
    size, limit = norm(wanted), law.mu * max(normal_force, 0.0)
    slides = 1.0 if size > limit else 0.0
    holds = limit / (unit * size) if size > limit else 0.0  # over what is wanted
    share = unit * holds if size > limit else 1.0
    held = add(scale(holds, wanted), scale(1.0 - slides, trial))
    power = (1.0 - slides) * law.tangential_damping * dashpot * dot(slip_rate, slip_rate)
    return scale(-share, wanted), held, power, slides


@njit
def spring_energy(law, stiffness, held):
    """Energy [J] that the tangential spring holds."""
    kt = law.tangential * stiffness
    if law.stored_force:
        return 0.5 * dot(held, held) / kt if kt > 0.0 else 0.0
    return 0.5 * kt * dot(held, held)


@njit
def spring_work(law, kt_before, kt, held_before, trial, held):
    """Energy [J] lost to friction in a step, and the work of the changing stiffness.

    The stiffness k changes with the overlap, so that the energy of the spring changes without work.
    In a step from b to n the trial displacement (or force) is what the spring would hold if it did
    not slip, and k the mean of k_b and k_n. With F = k s:

        stored displacement   E_n - E_b = (F_b + F_n)/2 (s_n - s_b) + (k_n - k_b) s_b s_n/2
        stored force          E_n - E_b = (F_b + F_n)/2 (F_n - F_b)/k
                                          + F_n^2 (1/k_n - 1/k)/2 - F_b^2 (1/k_b - 1/k)/2

    are identities: work of the mean force over the spring's displacement, and work of the changing
    stiffness. The rest of the trial, the slip, is friction's. So the energy balance of a contact
    closes as its motion does, to second order in the step, also where the spring begins with much
    displacement and no stiffness (a damped normal force lets it slide at once: s ~ mu f_n/kt is
    then unbounded, at finite energy).

    kt_before, kt: tangential stiffness at both ends of the step [N/m]; held_before, held: what the
    spring holds there, trial: what it would hold without slip; tuples of three, displacements [m],
    or forces [N] where the law stores these.
    """
    slip = add(trial, scale(-1.0, held))
    if law.stored_force:
        if kt == 0.0:
            return 0.0, 0.0
        mean = 0.5 * (kt_before + kt)
        friction = 0.5 * dot(add(held_before, held), slip) / mean
        work = 0.5 * dot(held, held) * (1.0 / kt - 1.0 / mean)
        if kt_before > 0.0:
            work -= 0.5 * dot(held_before, held_before) * (1.0 / kt_before - 1.0 / mean)
        return friction, work
    force = add(scale(kt_before, held_before), scale(kt, held))
    return 0.5 * dot(force, slip), 0.5 * (kt - kt_before) * dot(held_before, held)


@njit
def damping_of_impact(law, hertz, mass, speed):
    """The b of a contact that begins at an impact speed [m/s].

    Above the yield velocity (eq. 5.26) the restitution falls with the fourth root of the speed,
    e = e0 (v_y / v)^(1/4), as Johnson's theory of plastic impacts has it (Fig. 5.15 shows such a
    fall; the thesis does not print its function).
    """
    radius = (hertz / law.hertz) ** 2
    excess = speed / (law.yielding * np.sqrt(radius**3 / mass))
    if not excess > 1.0:
        return law.damping
    log = 0.25 * np.log(excess)  # of 1/e, to which that of 1/e0 is added
    if law.damping > 0.0:
        log += np.pi * law.damping / np.sqrt(1.0 - law.damping**2)
    return log / np.sqrt(log**2 + np.pi**2)


@njit
def with_history(law, stored_force):
    """The law with one of the two histories: a constant here lets the compiler drop the other's."""
    return HertzLaw(
        law.hertz, law.tangential, law.mu, law.damping, law.tangential_damping, law.yielding,
        law.pulls, stored_force,
    )  # fmt: skip
