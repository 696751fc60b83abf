"""Impact times to restitutions: one for each pair of flights, pooled, and whether one will do.

e = T(k+1)/T(k) (thesis, eq. 7.5; eq. 7.2 with leaving over arriving, see the errata), and the body
arrives with v = g T(k)/2 (eq. 7.3). Neighbouring ratios share impacts, so that their errors hang
together: they are pooled by generalised least squares, and their chi-squared about the pooled
value tests whether one number describes them.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from calibration.statistics.uncertainty import Estimate, of_trials, through

GRAVITY = 9.81  # [m/s2]
_GRAVITY = Estimate(GRAVITY, 0.03, 1)  # sigma: what it varies by over the earth


@dataclass(frozen=True)
class Restitution:
    """Of one body against one surface, from n impacts.

    per_pair, per_pair_sigma   (n - 2,) T(k+1)/T(k), and its standard uncertainty
    impact_speeds_m_s          (n - 2,) with which the body arrives in between
    value, sigma               pooled; where the pairs differ by more than noise their plain mean,
                               and its Student's interval from their scatter
    p                          chance of pairs that differ so much if one number describes all
    """

    value: float | None
    sigma: float | None
    per_pair: tuple[float, ...] = ()
    per_pair_sigma: tuple[float, ...] = ()
    impact_speeds_m_s: tuple[float, ...] = ()
    p: float | None = None

    @property
    def constant_within_noise(self) -> bool | None:
        """True if one number describes all pairs (p at least 0.05); None for fewer than two."""
        return None if self.p is None else self.p >= 0.05


def restitution(times: NDArray[np.float64], sigmas: NDArray[np.float64]) -> Restitution:
    """From three impact times [s] or more, and their independent uncertainties [s]."""
    flights = np.diff(times)
    ratios = flights[1:] / flights[:-1]
    slopes = _slopes(flights)
    covariance = (slopes * sigmas**2) @ slopes.T
    value, sigma, p = _pooled(ratios, covariance)
    return Restitution(
        value,
        sigma,
        tuple(map(float, ratios)),
        tuple(map(float, np.sqrt(np.diag(covariance)))),
        tuple(map(float, 0.5 * GRAVITY * flights[:-1])),
        p,
    )


def _slopes(flights: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n - 2, n): of each ratio with each impact time."""
    slopes = np.zeros((len(flights) - 1, len(flights) + 1))
    for k, (before, after) in enumerate(pairwise(flights)):
        ratio = after / before
        slopes[k, k : k + 3] = ratio / before, -(1.0 + ratio) / before, 1.0 / before
    return slopes


def _pooled(
    ratios: NDArray[np.float64], covariance: NDArray[np.float64]
) -> tuple[float, float, float | None]:
    """Value, sigma and p: see Restitution."""
    from scipy.stats import chi2

    inverse = np.linalg.inv(covariance)
    weight = inverse.sum()
    value, n = float(inverse.sum(axis=0) @ ratios / weight), len(ratios)
    if n == 1:
        return value, float(weight**-0.5), None
    apart = ratios - value
    p = float(chi2.sf(apart @ inverse @ apart, n - 1))
    if p >= 0.05:
        return value, float(weight**-0.5), p
    mean = of_trials(ratios.tolist())
    assert mean.sigma is not None  # they differ
    return mean.value, mean.sigma, p


def first_restitution(flight: Estimate, height: Estimate) -> Estimate:
    """Of the first impact after a fall from a height [m]: leaving g T/2 over arriving sqrt(2 g h).

    Air drag is left out.
    """
    return through(lambda t, h, g: 0.5 * t * math.sqrt(0.5 * g / h), flight, height, _GRAVITY)
