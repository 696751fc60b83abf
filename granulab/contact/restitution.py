"""Restitution from damping and back, for the linear spring-dashpot and for Hertz with Tsuji's.

The overlap of two bodies obeys d'' + gamma d' + omega0^2 d = 0 (wood-silo paper, eq. 3.7). With
b = gamma/2 and w = sqrt(omega0^2 - b^2), the contact that starts at d = 0 ends

- at zero overlap: e = exp(-pi b/w) (eq. 3.8); an overdamped one (b >= omega0) never gets there;
- at zero force, where the spring no longer outweighs the dashpot:
  e = exp(-(b/w) (pi - atan2(2 b w, w^2 - b^2))) (Schwager and Poeschel 2007, Granular Matter 9,
  465), and for b > omega0, with W = sqrt(b^2 - omega0^2): e = exp(-(b/W) ln((b + W)/(b - W))).

n contacts in parallel between two bodies act as one with n kn and n gamma, so two faces that
touch in eight vertex-edge pairs bounce back less than one corner does.

Hertz with Tsuji's dashpot (granular-damper thesis, eqs 5.21, 5.23, 5.32; its number b = damping) is

    d'' + sqrt(5) b (kn/m)^(1/2) d' + (kn/m) d = 0,   kn/m = k sqrt(d).

With z = d^(5/4) and the time s, ds = d^(1/4) dt, it becomes z'' + sqrt(5 k) b z' + (5/4) k z = 0:
a linear spring and dashpot whose damping ratio is b (Antypov and Elliott 2011, EPL 94, 50004).
d' is (4/5) z', and the force of one vanishes with that of the other: so both formulas above hold
with b in place of b/omega0, whatever the speed. Eqs 5.29 and 5.30 are those formulas too, and
eq. 5.31 is (sqrt(5)/2) b.
"""

import math
from typing import Literal

ContactEnd = Literal["overlap", "force"]

# |1 - r^2| where both terms of the slope cancel to 10 digits or fewer; its limit is as good there.
_NEARLY_CRITICAL = 1e-6


def linear_restitution(
    gamma: float, kn: float, mass: float, *, end: ContactEnd = "overlap", contacts: int = 1
) -> float:
    """Restitution [-] of a head-on impact through `contacts` equal contacts in parallel.

    gamma [1/s] and kn [N/m] of one contact, `mass` the reduced mass [kg].
    """
    return restitution_of_ratio(0.5 * contacts * gamma / math.sqrt(contacts * kn / mass), end)


def restitution_of_ratio(ratio: float, end: ContactEnd = "overlap") -> float:
    """Restitution [-] of a linear contact of damping ratio b/omega0, or a Hertz one of that b."""
    if end == "overlap":
        return math.exp(-math.pi * ratio / math.sqrt(1 - ratio**2)) if ratio < 1 else 0.0
    if ratio < 1:
        w = math.sqrt(1 - ratio**2)
        return math.exp(-ratio / w * (math.pi - math.atan2(2 * ratio * w, w**2 - ratio**2)))
    if ratio == 1:
        return math.exp(-2.0)
    w = math.sqrt(ratio**2 - 1)
    # ln((b + W)/(b - W)) with b^2 - W^2 = 1: no difference of nearly equal numbers.
    return math.exp(-ratio / w * 2 * math.log(ratio + w))


def slope_of_restitution(ratio: float, end: ContactEnd = "overlap") -> float:
    """Return how restitution_of_ratio changes with the ratio [-]; never above 0.

    From eq. 3.8, de/dr = -pi e/w^3 with w = sqrt(1 - r^2). From eq. 5.30, which is
    ln e = -2 r arccos(r)/w, de/dr = -2 e (arccos(r) - r w)/w^3, and beyond critical damping the
    same with arcosh and W = sqrt(r^2 - 1).
    """
    if end == "overlap" and ratio >= 1:
        return 0.0
    e, w2 = restitution_of_ratio(ratio, end), abs(1 - ratio**2)
    if end == "overlap":
        return -math.pi * e / w2**1.5
    if w2 < _NEARLY_CRITICAL:
        return -4 / 3 * e
    w = math.sqrt(w2)
    if ratio < 1:
        return -2 * e * (math.acos(ratio) - ratio * w) / w**3
    return -2 * e * (ratio * w - math.acosh(ratio)) / w**3


def damping_for_restitution(
    restitution: float, kn: float, mass: float, *, end: ContactEnd = "overlap", contacts: int = 1
) -> float:
    """The damping gamma [1/s] with which `contacts` in parallel give `restitution`, in (0, 1].

    kn [N/m] and gamma are of each contact; see linear_restitution. Closed form where the contact
    ends at zero overlap, a root search where it ends at zero force. Raises ValueError outside
    (0, 1].
    """
    return 2 * math.sqrt(kn / (contacts * mass)) * ratio_of_restitution(restitution, end)


def ratio_of_restitution(restitution: float, end: ContactEnd = "overlap") -> float:
    """The damping ratio b/omega0 of a linear contact, or the b of a Hertz one, that gives it.

    Eq. 5.29 where the contact ends at zero overlap, eq. 5.30 solved where it ends at zero force.
    Raises ValueError outside (0, 1].
    """
    if not 0 < restitution <= 1:
        raise ValueError(f"restitution = {restitution}: must be in (0, 1]")
    if restitution == 1:
        return 0.0
    if end == "overlap":
        log = -math.log(restitution)
        return log / math.hypot(math.pi, log)
    from scipy.optimize import brentq

    def miss(log_ratio: float) -> float:
        return restitution_of_ratio(math.exp(log_ratio), "force") - restitution

    return math.exp(brentq(miss, -40.0, 40.0, xtol=1e-14))
