"""Beverloo's law in two dimensions: rate against outlet, fitted, with a confidence band.

    W = rho_b sqrt(g) C (D - k d)^1.5

Beverloo, Leniger and van de Velde, Chem. Eng. Sci. 15 (1961) 260, for a slot: of particles in a
plane the rate goes with the power 3/2 of the outlet. rho_b is the bulk surface density [kg/m2], so
that W is in kg/s; C and k are fitted. The law is meant for outlets of several particles in a flat
floor, in a silo wider than 2.5 outlets and than the outlet and 30 particles, filled higher than 1.2
of its widths (as Mankoc et al., Granular Matter 9 (2007) 407, quote), and while the flow is steady.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from silo2d.case.case import GRAVITY

Series = NDArray[np.float64]

CONFIDENCE = 0.95
DRAWS = 500  # of the bootstrap
_FEWEST_OUTLETS = 3  # for two constants and something left to judge them by


@dataclass(frozen=True)
class Fit:
    """Constants with their intervals, and what is needed to draw the law.

    c, k          fitted; c_interval and k_interval of 95 % confidence
    draws         (draws, 2) constants C and k of the bootstrap
    scatter       of the runs about the law: rms of rate over law less one, n - 2 free [-]
    """

    c: float
    k: float
    c_interval: tuple[float, float]
    k_interval: tuple[float, float]
    draws: Series
    scatter: float
    density: float  # bulk surface density, mean of the runs [kg/m2]
    size: float  # d [m]

    def rate(self, outlet: ArrayLike) -> Series:
        """The law at outlets [m], in kg/s."""
        return law(np.asarray(outlet, float), self.c, self.k, self.density, self.size)

    def band(self, outlet: Series) -> tuple[Series, Series]:
        """Lower and upper end of the band of 95 % confidence of the law [kg/s]."""
        curves = [law(outlet, c, k, self.density, self.size) for c, k in self.draws]
        low, high = np.quantile(curves, _tails(), axis=0)
        return low, high


def law(outlet: ArrayLike, c: float, k: float, density: ArrayLike, size: float) -> Series:
    """W [kg/s] of outlets D [m], for a bulk density [kg/m2] and a particle size d [m]."""
    open_part = np.maximum(np.asarray(outlet) - k * size, 0.0)
    return np.asarray(density * np.sqrt(GRAVITY) * c * open_part**1.5, dtype=float)


def fit_law(
    outlet: ArrayLike,
    rate: ArrayLike,
    density: ArrayLike,
    size: float,
    error: ArrayLike,
    draws: int = DRAWS,
) -> Fit | None:
    """Fit C and k to runs (n,): outlets [m], rates [kg/s] with standard errors, bulk densities.

    Least squares weighted by the errors. The intervals come from a parametric bootstrap: rates are
    drawn `draws` times about the fitted law and fitted again. A run scatters by its own standard
    error, or by what the runs scatter about the law where that is more (root mean square of rate
    over law less one, for n - 2 degrees of freedom): what one filling differs from the next by is
    not in its own error. Drawing whole runs would not do for one or two at each outlet. None for
    fewer than three outlets.
    """
    rows = np.array([*np.broadcast_arrays(outlet, rate, density, error)], dtype=float)
    if len(np.unique(rows[0])) < _FEWEST_OUTLETS:
        return None
    c, k = _least_squares(rows, size)
    fitted = law(rows[0], c, k, rows[2], size)
    off = rows[1] / fitted - 1
    scatter = np.sqrt((off**2).sum() / (len(off) - 2))
    spread = np.maximum(rows[3], scatter * fitted)
    rng = np.random.default_rng(1)
    found = np.array([
        _least_squares(np.array([rows[0], rng.normal(fitted, spread), *rows[2:]]), size)
        for _ in range(draws)
    ])  # fmt: skip
    (c_low, k_low), (c_high, k_high) = np.quantile(found, _tails(), axis=0).tolist()
    return Fit(c, k, (c_low, c_high), (k_low, k_high), found, float(scatter),
               float(rows[2].mean()), size)  # fmt: skip


def _tails() -> list[float]:
    return [0.5 - CONFIDENCE / 2, 0.5 + CONFIDENCE / 2]


def _least_squares(rows: Series, size: float) -> tuple[float, float]:
    from scipy.optimize import curve_fit

    outlet, rate, density, error = rows
    model: Callable[..., Series] = lambda x, c, k: law(x, c, k, density, size)  # noqa: E731
    # (W/(rho_b sqrt(g)))^(2/3) is a straight line in D: that is where the search starts.
    slope, start = np.polyfit(outlet, (np.abs(rate) / (density * np.sqrt(GRAVITY))) ** (2 / 3), 1)
    guess = max(slope, 1e-3) ** 1.5, -start / max(slope, 1e-3) / size
    (c, k), _ = curve_fit(model, outlet, rate, p0=guess, sigma=error)
    return float(c), float(k)
