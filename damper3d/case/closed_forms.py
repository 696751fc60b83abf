"""Closed forms: onset and efficiency of the bouncing bed, and of fluidisation.

Granular-damper thesis, eqs 6.8-6.13. The enclosure moves by A sin(omega t), A = Gamma g/omega^2,
and the efficiency eta is the energy lost in a cycle over 4 (Gamma g/omega)^2 M.

**Bouncing bed.** A bed that leaves one end wall at its greatest speed A omega, and crosses the
clearance h while the wall comes back, arrives as the other end does where A >= A0 = h/pi
(eq. 6.11; Sack et al. 2013, Phys. Rev. Lett. 111, 018001). It sticks to the wall that it meets
(no rebound, no gravity), which it leaves when that one is fastest: with the phase phi of the
meeting since then,

    phi - sin phi = pi A0/A,        eta = (1 - cos phi)^2/4,        none below A0.

**Fluidisation.** A bed that does not rebound on a floor that goes up and down, without a lid,
leaves the floor at sin(phase) = 1/Gamma and meets it again within the cycle up to Gamma =
sqrt(1 + pi^2), where its flight lasts a whole one; from sqrt(4 + pi^2) on it meets it at other
phases in turn (the completely inelastic sphere: Mehta and Luck 1990, Phys. Rev. Lett. 65, 393). The
frequency does not enter, so its best Gamma is a ridge along the frequencies.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from damper3d.case.parts import GRAVITY
from damper3d.case.random_packing import CLOSE_PACKING, LOOSE_PACKING
from granulab.contact.files.units import nearest
from granulab.errors import InputError

Floats = NDArray[np.float64]

# Fill ratio of a bed of spheres where it is packed (thesis, below eq. 6.13).
PACKINGS = {"loose": LOOSE_PACKING, "close": CLOSE_PACKING}
WHOLE_FLIGHT = float(np.hypot(1.0, np.pi))  # Gamma at which a block flies for a whole cycle
PERIOD_DOUBLING = float(np.hypot(2.0, np.pi))  # Gamma above which its cycles are unlike


def excitation_amplitude(frequency: ArrayLike, gamma: ArrayLike) -> Any:
    """A = Gamma g/omega^2 [m] (eq. 6.2) of a frequency [Hz] and a dimensionless acceleration."""
    return np.asarray(gamma) * GRAVITY / (2 * np.pi * np.asarray(frequency)) ** 2


def effective_clearance(fill_ratio: float, length: float, packing: float) -> float:
    """Clearance [m] of a bed packed to the fill ratio `packing` between ends `length` apart.

    (1 - fill_ratio/packing) length, eq. 6.13. Raises InputError where the bed has no clearance.
    """
    if not 0 < packing <= 1:
        raise InputError(f"packing = {packing:g}: must be above 0 and at most 1, such as 0.64")
    if not 0 < fill_ratio < packing:
        raise InputError(
            f"fill ratio = {fill_ratio:.3f}: must be above 0 and below that of the packed bed, "
            f"{packing:g}; with more particles there is no clearance to cross"
        )
    return (1 - fill_ratio / packing) * length


def relative_clearance(count: int, full_count: int, length: float) -> float:
    """Clearance [m] from the number of particles that would fill the enclosure, eq. 6.12.

    Raises InputError where it is full.
    """
    if not 0 < count < full_count:
        raise InputError(
            f"full count = {full_count}: must be above the number of particles, {count}; "
            "give how many fill the enclosure to its lid"
        )
    return (1 - count / full_count) * length


def bouncing_bed_onset(frequency: ArrayLike, clearance: float) -> Any:
    """Gamma = omega^2 h/(pi g) at which the bouncing bed sets in, eq. 6.11: A = h/pi."""
    return (2 * np.pi * np.asarray(frequency)) ** 2 * clearance / (np.pi * GRAVITY)


def clearance_for(frequency: ArrayLike, gamma: ArrayLike) -> Any:
    """h = pi Gamma g/omega^2 [m] whose bouncing bed sets in, and damps best, there: eq. 6.11."""
    return np.pi * excitation_amplitude(frequency, gamma)


def meeting_phase(amplitude_ratio: ArrayLike) -> Floats:
    """phi [rad] at which an ideal bouncing bed meets a wall, for A/A0; NaN below 1."""
    ratio = np.asarray(amplitude_ratio, float)
    wanted = np.pi / np.where(ratio >= 1, ratio, np.nan)
    return _root(lambda phase: wanted - (phase - np.sin(phase)), 0 * wanted, 0 * wanted + np.pi)


def collect_and_collide(amplitude_ratio: ArrayLike) -> Floats:
    """Efficiency of the ideal bouncing bed, (1 - cos phi)^2/4, for A/A0; NaN below 1."""
    return (1 - np.cos(meeting_phase(amplitude_ratio))) ** 2 / 4


def fluidisation_threshold(orientation: str, friction: float) -> float:
    """Gamma above which a rigid bed moves against its enclosure.

    vertical: 1, the bed lifts off; horizontal: the friction at the wall, below which Coulomb's
    force carries a block on a flat floor along (a trough holds more); none: 0, nothing holds it.
    Measured between 3 and 15 Hz: 1 to 1.2 vertically, 0.8 to 0.9 horizontally (Tennakoon and
    Behringer 1998, Phys. Rev. Lett. 81, 794; thesis sec. 2.5.2).
    """
    known = {"vertical": 1.0, "horizontal": friction, "none": 0.0}
    if orientation not in known:
        raise InputError(f"orientation {orientation!r}: unknown; {nearest(orientation, known)}")
    return known[orientation]


def inelastic_flight(gamma: ArrayLike) -> Floats:
    """Phase [rad] for which a block that does not rebound is off a shaken floor, each cycle.

    0 up to Gamma = 1; NaN above PERIOD_DOUBLING, where its cycles are no longer alike.
    """
    gamma = np.asarray(gamma, float)
    flying = np.where((gamma > 1) & (gamma < WHOLE_FLIGHT), gamma, np.nan)
    start = np.arcsin(1 / flying)

    def gap(phase: Floats) -> Floats:
        """Between block and floor, over A; it curves down from pi - 2 start on: one root."""
        ballistic = np.sin(start) + np.cos(start) * phase - phase**2 / (2 * flying)
        return ballistic - np.sin(start + phase)

    flight = _root(gap, np.pi - 2 * start, np.full_like(start, 2 * np.pi))
    whole = (gamma >= WHOLE_FLIGHT) & (gamma <= PERIOD_DOUBLING)
    return np.where(gamma <= 1, 0.0, np.where(whole, 2 * np.pi, flight))


def inelastic_block(gamma: ArrayLike) -> Floats:
    """Efficiency of a block that does not rebound on a shaken floor, (v/(A omega))^2/8.

    v is the relative velocity with which it lands, once a cycle; NaN above PERIOD_DOUBLING.
    """
    gamma, flight = np.asarray(gamma, float), inelastic_flight(gamma)
    # It lands at v = g T after a whole cycle of flight, whatever the phase.
    start = np.arcsin(1 / np.clip(gamma, 1, WHOLE_FLIGHT))
    landing = np.cos(start) - flight / np.maximum(gamma, 1) - np.cos(start + flight)
    whole = -2 * np.pi / np.maximum(gamma, 1)
    return np.where(gamma >= WHOLE_FLIGHT, whole + 0 * flight, landing) ** 2 / 8


def fluidisation_optimum() -> tuple[float, float]:
    """Gamma at which inelastic_block dissipates best, and its efficiency there: 2.58 and 0.57."""
    from scipy.optimize import minimize_scalar

    best = minimize_scalar(lambda gamma: -inelastic_block(gamma), bounds=(1, WHOLE_FLIGHT))
    return float(best.x), float(-best.fun)


def bouncing_block_gammas(restitution: float) -> tuple[float, float]:
    """Least and greatest Gamma at which a block bounces once a cycle on a shaken floor, no lid.

    It meets the floor at cos(phase) = pi (1 - e)/((1 + e) Gamma), which takes the least, and a
    small deviation dies out up to the greatest (linear stability of that orbit).
    """
    e = restitution
    least = np.pi * (1 - e) / (1 + e)
    return float(least), float(np.hypot(least, 2 * (1 + e**2) / (1 + e) ** 2))


def bouncing_block_loss(mass: float, frequency: float, restitution: float) -> float:
    """Energy [J] lost a cycle by a block that bounces once: m g^2 T^2 (1 - e)/(2 (1 + e))."""
    fall = GRAVITY / frequency  # g T [m/s]
    return 0.5 * mass * fall**2 * (1 - restitution) / (1 + restitution)


def _root(falling: Callable[[Floats], Floats], low: Floats, high: Floats) -> Floats:
    """Root of a function that falls from low to high through zero, by halving; NaN stays NaN."""
    low, high = low + np.zeros(()), high + np.zeros(())
    for _ in range(60):  # 2 pi/2^60 is below the last digit
        middle = (low + high) / 2
        above = falling(middle) > 0
        low, high = np.where(above, middle, low), np.where(above, high, middle)
    return (low + high) / 2
