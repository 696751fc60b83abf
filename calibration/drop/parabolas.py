"""Parabolas of all flights of a clip in one robust fit, with the covariance of their parameters.

Flight k is y = c0 + c1 s + c2 s^2/2, s = t - centre of the flight. c2 is common to all flights.
Where that is refuted (drag, perspective) it scatters about a common one, by as much as the flights'
own say beyond their noise (DerSimonian and Laird 1986, doi 10.1016/0197-2456(86)90046-2): long
flights keep their own, short ones lean on the others.
The fit is robust (see robust.py), and sigma comes from the residuals alone.

Neighbouring parabolas meet in a contact. Functions of all m parabolas (centre (m,), coefficients
c (m, 3)) give one value per contact, so m - 1, but for those between two whole flights.
"""

from dataclasses import dataclass

import numpy as np

from calibration.statistics import shared_noise
from calibration.statistics.robust import influence, robust_fit, run_left_out
from calibration.tracking.track import Array, Rows
from granulab.errors import InputError

_REFUTED = 0.05  # p of a common acceleration below which the flights' own scatter about it
_FEWEST = 3  # points of a flight: two give its position and speed where others give the fall


def contact_times(centre: Array, coefficients: Array) -> Array:
    """(m - 1,) where neighbouring parabolas meet; NaN where they do not.

    For a common acceleration they meet once; else Newton's steps from halfway between the
    flights' centres end at the root there.
    """
    times = np.full(len(centre) - 1, np.nan)
    for k in range(len(times)):
        s = (centre[k] + centre[k + 1]) / 2
        for _ in range(50):
            gap, turn = _difference(centre, coefficients, k, s)
            step = -gap / turn if turn else np.nan
            s += step
            if not abs(step) > 1e-12 * max(1.0, abs(s)):
                break
        times[k] = s
    return times


def _difference(centre: Array, coefficients: Array, k: int, t: float) -> tuple[float, float]:
    """Flight k + 1 less flight k at time t: in position and in speed."""
    position, speed = [], []
    for i in (k, k + 1):
        s = t - centre[i]
        c = coefficients[i]
        position.append(c[0] + c[1] * s + c[2] * s**2 / 2)
        speed.append(c[1] + c[2] * s)
    return position[1] - position[0], speed[1] - speed[0]


def levels(centre: Array, c: Array) -> Array:
    """Position of each contact: the plate's level."""
    s = contact_times(centre, c) - centre[:-1]
    return c[:-1, 0] + c[:-1, 1] * s + c[:-1, 2] * s**2 / 2


def speeds(centre: Array, c: Array) -> tuple[Array, Array]:
    """Velocity before and after each contact."""
    times = contact_times(centre, c)
    before = c[:-1, 1] + c[:-1, 2] * (times - centre[:-1])
    return before, c[1:, 1] + c[1:, 2] * (times - centre[1:])


def from_velocities(centre: Array, c: Array) -> Array:
    """Restitution: speed after over speed before."""
    before, after = speeds(centre, c)
    return -after / before


def inner_velocities(centre: Array, c: Array) -> Array:
    """Of the contacts between two whole flights."""
    return from_velocities(centre, c)[1:-1]


def from_times(centre: Array, c: Array) -> Array:
    """Restitution T(k+1)/T(k) of the contacts between two whole flights, (m - 3,)."""
    flight = np.diff(contact_times(centre, c))
    return flight[1:] / flight[:-1]


def from_heights(centre: Array, c: Array) -> Array:
    """Eq. 3.5, over the plate's level as all contacts give it: their mean, and their line."""
    times, level = contact_times(centre, c), levels(centre, c)
    if len(times) > 2:  # the plate may drift in the picture
        plate = np.polyval(np.polyfit(times, level, 1), times)
    else:
        plate = np.full(len(times), level.mean())
    apex = c[:, 0] - c[:, 1] ** 2 / (2 * c[:, 2])
    ratio = (plate - apex[1:]) / (plate - apex[:-1])
    return np.sqrt(np.where(ratio > 0, ratio, np.nan))


class ShortFlightError(InputError):
    """Refusal of a flight, numbered from 0, that has too few positions for a parabola."""

    def __init__(self, flight: int, positions: int) -> None:
        """Say it of flight number flight + 1."""
        super().__init__(f"flight {flight + 1} has {positions} positions; {_FEWEST} are needed")
        self.flight = flight


@dataclass(frozen=True)
class Flights:
    """Parabolas of m flights that follow one another.

    centre         (m,) time at which s is zero [frames]
    coefficients   (m, 3) c0, c1, c2 [y, y/frame, y/frame^2]
    covariance     (3m, 3m) of the coefficients, flight by flight
    rows           for each flight, the points that are in its fit
    residuals      (n,) of all points of the track; NaN where in no flight
    weights        (n,) 0 where the fit took a point for an outlier
    sigma          scale of the residuals [y]
    acceleration   of the clip, and its sigma [y/frame^2]
    scatter        standard deviation of c2 among flights beyond noise; 0 for one common c2
    own            (m, 2) acceleration of each flight fitted alone, and its sigma
    p              of the chi-square test that one acceleration describes all flights
    """

    centre: Array
    coefficients: Array
    covariance: Array
    rows: list[Rows]
    residuals: Array
    weights: Array
    sigma: float
    acceleration: tuple[float, float]
    scatter: float
    own: Array
    p: float | None


def fit(t: Array, y: Array, ranges: list[tuple[int, int]], spread: Array | None = None) -> Flights:
    """The parabolas of the flights whose points are `ranges` (i, j not in it).

    t       (n,) time [frames]
    spread  (n,) standard deviation of y up to a factor, where it is known

    Points nearer to a contact than half a frame are left out: an exposure may see both flights.
    A last flight that has too few points then is left out with its contact.
    Raises ShortFlightError where another flight has too few points.
    """
    rows = [np.arange(i, j) for i, j in ranges]
    found = _fit(t, y, rows, spread)
    for _ in range(3):  # contacts move by hundredths of a frame from the second time on
        previous, rows = rows, _clear_of_contacts(t, found, ranges)
        if len(rows) > 2 and len(rows[-1]) < _FEWEST:
            return fit(t, y, ranges[:-1], spread)
        if all(np.array_equal(a, b) for a, b in zip(previous, rows, strict=True)):
            break
        found = _fit(t, y, rows, spread)
    return found


def _fit(t: Array, y: Array, rows: list[Rows], spread: Array | None) -> Flights:
    few = next((k for k, one in enumerate(rows) if len(one) < _FEWEST), None)
    if few is not None:
        raise ShortFlightError(few, len(rows[few]))
    spread = np.ones(len(y)) if spread is None else spread
    centre = np.array([t[one[[0, -1]]].mean() for one in rows])
    own, p = _own(t, y, rows, centre, spread)
    scatter = 0.0 if p is None or p >= _REFUTED else scatter_beyond_noise(own)
    mapping = _mapping(len(rows), scatter > 0)
    beta, covariance, residuals, weights, sigma = _on_rows(
        _design(t, rows, centre) @ mapping, t, y, rows, spread, _lean(len(rows), scatter)
    )
    acceleration = float(beta[-1]), float(np.sqrt(max(covariance[-1, -1], 0.0)))
    covariance = mapping @ covariance @ mapping.T + _of_positions_or_fall(t, rows, scatter)
    return Flights(
        centre, (mapping @ beta).reshape(-1, 3), covariance, rows, residuals, weights,
        sigma, acceleration, scatter, own, p,
    )  # fmt: skip


def _own(
    t: Array, y: Array, rows: list[Rows], centre: Array, spread: Array
) -> tuple[Array, float | None]:
    """Acceleration of each flight alone with its sigma; p of one acceleration for all."""
    from scipy.stats import chi2

    beta, covariance, *_ = _on_rows(_design(t, rows, centre), t, y, rows, spread)
    own = np.stack([beta[2::3], np.sqrt(np.maximum(np.diag(covariance)[2::3], 1e-300))], axis=1)
    if len(rows) < 2 or sum(map(len, rows)) <= 3 * len(rows):  # nothing is left that shows noise
        return own, None
    return own, float(chi2.sf(chi_square(own), len(rows) - 1))


def _on_rows(
    design: Array, t: Array, y: Array, rows: list[Rows], spread: Array, lean: Array | None = None
) -> tuple[Array, Array, Array, Array, float]:
    """Coefficients, covariance, residuals and weights of all points (NaN in no flight), scale.

    The scale is raised until no run of points is left out.
    """
    every = np.concatenate(rows)
    divided, least = design / spread[every, None], 0.0
    while True:
        beta, _, kept, sigma = robust_fit(divided, y[every] / spread[every], lean, least)
        residuals, weights = np.full(len(y), np.nan), np.full(len(y), np.nan)
        residuals[every], weights[every] = y[every] - design @ beta, kept
        if not any(run_left_out(residuals[one], weights[one]) for one in rows):
            break
        least = 1.5 * sigma
    pulls = np.full(len(y), np.nan)
    pulls[every] = influence(residuals[every] / spread[every], sigma)
    noise = shared_noise.covariances(pulls, y, t, rows)
    lean = np.empty((0, len(beta))) if lean is None else lean
    covariance = shared_noise.of_parameters(divided, noise, lean)
    return beta, covariance, residuals, weights, sigma


def _of_positions_or_fall(t: Array, rows: list[Rows], scatter: float) -> Array:
    """(3m, 3m) variance of the coefficients from not knowing what the scatter of c2 is of.

    It may be of the fall, or of positions that are seen wrong over a whole flight (light, blur),
    which residuals do not show. The two differ by c2 - a in c2, and by -(c2 - a) T^2/8 in c0: at
    the plate neighbouring flights see the same position, with the same error, and still meet when
    they do.
    """
    extra = np.zeros((3 * len(rows), 3 * len(rows)))
    for k, one in enumerate(rows):
        way = scatter * np.array([-(np.ptp(t[one]) ** 2) / 8, 0.0, 1.0])
        extra[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = np.outer(way, way)
    return extra


def chi_square(known: Array) -> float:
    """Of values (k, 2) with their sigma about their weighted mean."""
    weight = 1 / known[:, 1] ** 2
    mean = np.sum(weight * known[:, 0]) / weight.sum()
    return float(np.sum(weight * (known[:, 0] - mean) ** 2))


def scatter_beyond_noise(known: Array) -> float:
    """Standard deviation of values (k, 2) beyond their sigma, by moments (DerSimonian, Laird)."""
    weight = 1 / known[:, 1] ** 2
    excess = chi_square(known) - (len(known) - 1)
    return float(np.sqrt(max(excess, 0.0) / (weight.sum() - np.sum(weight**2) / weight.sum())))


def _lean(m: int, scatter: float) -> Array:
    """(m, 3m + 1) rows that say how far each c2 is from the common one, in its scatter."""
    if scatter == 0:
        return np.empty((0, 2 * m + 1))
    rows = np.zeros((m, 3 * m + 1))
    rows[np.arange(m), 3 * np.arange(m) + 2] = 1 / scatter
    rows[:, -1] = -1 / scatter
    return rows


def _design(t: Array, rows: list[Rows], centre: Array) -> Array:
    """(points, 3m) of 1, s, s^2/2 in the columns of each point's flight."""
    design = np.zeros((sum(map(len, rows)), 3 * len(rows)))
    first = 0
    for k, one in enumerate(rows):
        s = t[one] - centre[k]
        design[first : first + len(one), 3 * k : 3 * k + 3] = np.stack([s**0, s, s**2 / 2], axis=1)
        first += len(one)
    return design


def _mapping(m: int, scatters: bool) -> Array:
    """From the fit's parameters, the last of which is the common c2, to the (3m,) coefficients."""
    if scatters:
        return np.eye(3 * m, 3 * m + 1)
    mapping = np.zeros((3 * m, 2 * m + 1))
    for k in range(m):
        mapping[3 * k, 2 * k] = mapping[3 * k + 1, 2 * k + 1] = mapping[3 * k + 2, -1] = 1.0
    return mapping


def _clear_of_contacts(t: Array, found: Flights, ranges: list[tuple[int, int]]) -> list[Rows]:
    """The points of each flight, from half a frame after its contact to half a frame before."""
    contacts = contact_times(found.centre, found.coefficients)
    lowest = np.concatenate([[t[ranges[0][0]]], contacts + 0.5])
    highest = np.concatenate([contacts - 0.5, [t[ranges[-1][1] - 1]]])
    return [np.flatnonzero((t >= a) & (t <= b)) for a, b in zip(lowest, highest, strict=True)]
