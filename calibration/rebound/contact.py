"""Contacts of a particle with a plate: restitution, friction, energies, from motion and shape.

The point of contact is where the outline is nearest to the plate. The moment of the impulse about
the centroid says once more where it acts: r_t = (k^2 (omega' - omega) + r_n (v_t' - v_t)) /
(v_n' - v_n). Both are weighted by their variances; that they agree is a check of the shape, of the
radius of gyration, and of the contact being one.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from calibration.rebound.impact import Arm, Motion, at_contact, energy
from calibration.rebound.motion import Fitted
from calibration.rebound.shape import EDGE, Touch, touch
from calibration.statistics.correlated import propagated
from calibration.statistics.uncertainty import Estimate
from calibration.tracking.track import Array
from granulab.contact.material import Measured

_AGREE = 3.0  # sigma by which the two ways to the point of contact may differ
_JUMP = 5.0  # sigma of white noise by which a particle may not seem to jump at a contact
_ASIDE = 0.25  # of the radius of gyration: where the point is known no better, a side touches
SHARES = tuple(
    f"{part}_{when}"
    for when in ("before", "after")
    for part in ("normal", "tangential", "rotational")
)
VELOCITIES = tuple(
    f"{part}_{when}" for when in ("before", "after") for part in ("v_t", "v_n", "omega")
)
NAMES = (
    "restitution", "restitution_centroid", "tangential_restitution", "impulse_ratio",
    "energy_lost", *SHARES, "arm_t", "arm_n", *VELOCITIES, "speed_of_point",
)  # fmt: skip


class Contact(NamedTuple):
    """One contact.

    frame     when, on the clock of the track; sigma
    angle     of the particle then, counter-clockwise [rad]
    doubt     why it is no contact of one point; "" for one that is
    balance   point of contact by the impulse's moment less that by the outline, in sigma
    values    by NAMES; lengths in px, times in frames, energies in shares of that before
    """

    frame: float
    sigma: float
    angle: float
    balance: float
    doubt: str
    values: dict[str, Estimate]


@dataclass(frozen=True)
class Known:
    """Motion, outline (k, 2) at angle zero, radius of gyration with sigma [px], plate's angle."""

    fitted: Fitted
    outline: Array
    gyration: tuple[float, float]
    plane: Measured

    @property
    def motion(self) -> int:
        """Number of the motion's parameters."""
        return len(self.fitted.parameters)

    def angle(self, p: Array, j: int) -> float:
        """Of the particle at contact j [rad]."""
        times = self.fitted.layout.times(p)
        return float(self.fitted.layout.at(p, 2, j, times[j : j + 1])[0])

    def motions(self, p: Array, j: int, plane: float) -> tuple[Motion, Motion]:
        """Before and after contact j, along the plate and normal to it."""
        pairs = [self.fitted.layout.velocities(p, c, j) for c in range(3)]
        c, s = np.cos(plane), np.sin(plane)
        before, after = (
            Motion(float(c * x + s * y), float(-s * x + c * y), float(w))
            for x, y, w in zip(*pairs, strict=True)
        )
        return before, after


def of_contacts(known: Known) -> tuple[list[Contact], Array, Array]:
    """All contacts, their restitutions at the point of contact, and the covariance of these."""
    fitted = known.fitted
    count = fitted.layout.m - 1
    angles, spread = propagated(
        fitted.parameters,
        fitted.covariance,
        lambda p: np.array([known.angle(p, j) for j in range(count)]),
    )
    plane = known.plane.sigma or 0.0
    points = [
        touch(known.outline, angle, float(np.hypot(np.sqrt(var), plane)), known.plane.value)
        for angle, var in zip(angles, np.diag(spread), strict=True)
    ]
    values, covariance = _parameters(known, points)
    off, variance = propagated(
        values, covariance,
        lambda q: np.array([_by_moment(known, points, q, j).t - _by_outline(known, points, q, j).t
                            for j in range(count)]),
    )  # fmt: skip
    balance = off / np.sqrt(np.maximum(np.diag(variance), 1e-300))
    own = np.array([one.sigma_t**2 for one in points])
    weight = np.clip(own / np.maximum(np.diag(variance), 1e-300), 0.0, 1.0)
    found, whole = propagated(
        values, covariance,
        lambda q: np.concatenate([
            _quantities(known, points, weight[j], q, j) for j in range(count)
        ]),
    )  # fmt: skip
    sigma = np.sqrt(np.clip(np.diag(whole), 0, None))
    times = fitted.layout.times(fitted.parameters)
    contacts = [
        Contact(
            float(times[j]), float(np.sqrt(fitted.covariance[j, j])), float(angles[j]),
            float(balance[j]), _doubt(known, points[j], balance[j], j),
            {
                name: Estimate(float(found[k]), float(sigma[k]), 1)
                for k, name in enumerate(NAMES, j * len(NAMES))
            },
        )
        for j in range(count)
    ]  # fmt: skip
    rows = np.arange(count) * len(NAMES)
    return contacts, found[rows], whole[np.ix_(rows, rows)]


def _doubt(known: Known, point: Touch, balance: float, j: int) -> str:
    """Reason why contact j is not one of a single point; "" for one that is."""
    gyration = known.gyration[0]
    if point.sigma_t > _ASIDE * gyration:
        return "it lands on a side, and no single point touches"
    size = np.abs(known.fitted.jumps[j] * [1.0, gyration])
    sigma = known.fitted.jumps_sigma[j] * [1.0, gyration]
    if np.any((size > EDGE) & (size > _JUMP * sigma)):
        return (
            "its positions and angles before and after do not meet in one moment: another point "
            "touched within a few frames"
        )
    if abs(balance) > _AGREE:
        return (
            f"rotation and velocities do not fit one impulse at the outline's lowest point "
            f"({balance:+.1f} sigma): another point touched within a few frames, or its mass is "
            "not that of a prism (--gyration)"
        )
    return ""


def _parameters(known: Known, points: list[Touch]) -> tuple[Array, Array]:
    """Motion, radius of gyration, plate's angle, and errors of each point along t and n."""
    fitted = known.fitted
    errors = [e for one in points for e in (one.sigma_t, one.sigma_n)]
    sigma = np.array([known.gyration[1], known.plane.sigma or 0.0, *errors])
    size = known.motion + len(sigma)
    covariance = np.zeros((size, size))
    covariance[: known.motion, : known.motion] = fitted.covariance
    covariance[np.arange(known.motion, size), np.arange(known.motion, size)] = sigma**2
    start = [*fitted.parameters, known.gyration[0], known.plane.value, *np.zeros(len(errors))]
    return np.array(start), covariance


def _by_outline(known: Known, points: list[Touch], q: Array, j: int) -> Arm:
    place = known.motion + 2 + 2 * j
    return Arm(points[j].arm.t + float(q[place]), points[j].arm.n + float(q[place + 1]))


def _by_moment(known: Known, points: list[Touch], q: Array, j: int) -> Arm:
    """The point at the outline's lowest level through which the impulse goes."""
    before, after = known.motions(q, j, float(q[known.motion + 1]))
    n = _by_outline(known, points, q, j).n
    return Arm(_line(before, after, float(q[known.motion]), n), n)


def _line(before: Motion, after: Motion, k: float, n: float) -> float:
    return (k**2 * (after.omega - before.omega) + n * (after.t - before.t)) / (after.n - before.n)


def _quantities(known: Known, points: list[Touch], weight: float, q: Array, j: int) -> Array:
    """NAMES of contact j."""
    before, after = known.motions(q, j, float(q[known.motion + 1]))
    k = float(q[known.motion])
    seen = _by_outline(known, points, q, j)
    arm = Arm(seen.t + weight * (_line(before, after, k, seen.n) - seen.t), seen.n)
    (t, n), (t_after, n_after) = at_contact(before, arm), at_contact(after, arm)
    first, last = energy(before, k), energy(after, k)
    whole = first.whole
    return np.array([
        -n_after / n, -after.n / before.n, -t_after / t if t else np.nan,
        (after.t - before.t) / (after.n - before.n), 1 - last.whole / whole,
        *(part / whole for part in first), *(part / whole for part in last),
        arm.t, arm.n, *before, *after, n,
    ])  # fmt: skip
