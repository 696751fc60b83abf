"""Prior of a parameter, in a coordinate in which all priors are alike.

    x = (value - centre)/width,    for a lognormal prior (ln value - centre)/width

so that the prior is a uniform distribution between -sqrt 3 and sqrt 3, or a standard normal one
that is cut off: width is the prior's standard deviation. Normal priors end at three of them, as
nothing is simulated beyond. One of which min and max leave but a small part has the centre and the
width of that part.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from granulab.contact.files.units import nearest
from granulab.errors import InputError

Array = NDArray[np.float64]

_KEYS = {
    "uniform": ("min", "max"),
    "normal": ("mean", "sd", "min", "max"),
    "lognormal": ("mean", "sd", "min", "max"),
}
_REACH = 3.0  # standard deviations of a normal prior, 99.7 % of it
_LEAST = 1e-9  # deviations between min and max, of which a coordinate still has seven digits
_NODES = 40  # exact to rounding over the six deviations that a prior reaches at most
_NARROW = 0.5  # of the normal's deviation: a part that is narrower has a coordinate of its own


@dataclass(frozen=True)
class Prior:
    """The prior of one parameter, which may stand for several keys of a case.

    centre, width    of the coordinate, in SI, or of the logarithm
    low, high        where the prior ends, in the coordinate
    shift, stretch   of a normal prior: shift + stretch x is the standard normal deviate
    """

    keys: tuple[str, ...]
    kind: Literal["uniform", "normal", "lognormal"]
    centre: float
    width: float
    low: float
    high: float
    unit: str = "1"  # SI
    shift: float = 0.0
    stretch: float = 1.0

    @property
    def name(self) -> str:
        """Keys as the fit file has them."""
        return ", ".join(self.keys)

    def value(self, x: Any) -> Any:
        """The parameter in SI at a coordinate."""
        plain = self.centre + self.width * x
        return np.exp(plain) if self.kind == "lognormal" else plain

    def coordinate(self, value: float) -> float:
        """The coordinate of a parameter in SI."""
        plain = math.log(value) if self.kind == "lognormal" else value
        return (plain - self.centre) / self.width

    @property
    def ends(self) -> tuple[float, float]:
        """The least and the largest value, in SI."""
        return float(self.value(self.low)), float(self.value(self.high))

    def quantile(self, share: Array) -> Array:
        """The coordinate below which a share of the prior lies."""
        if self.kind == "uniform":
            return self.low + share * (self.high - self.low)
        from scipy.special import ndtr, ndtri

        below, above = ndtr(self._deviate(self.low)), ndtr(self._deviate(self.high))
        return (ndtri(below + share * (above - below)) - self.shift) / self.stretch

    def share(self, x: Array) -> Array:
        """Share of the prior that lies below a coordinate."""
        if self.kind == "uniform":
            return (x - self.low) / (self.high - self.low)
        from scipy.special import ndtr

        below, above = ndtr(self._deviate(self.low)), ndtr(self._deviate(self.high))
        return (ndtr(self._deviate(x)) - below) / (above - below)

    def log_density(self, x: Array) -> Array:
        """Up to a constant; minus infinity outside."""
        inside = (x >= self.low) & (x <= self.high)
        inner = np.zeros_like(x) if self.kind == "uniform" else -0.5 * self._deviate(x) ** 2
        return np.where(inside, inner, -math.inf)

    @property
    def sd(self) -> float:
        """Standard deviation of the coordinate: 1, or less where the prior is cut off."""
        if self.kind == "uniform":
            return (self.high - self.low) / math.sqrt(12)
        if self.stretch != 1.0:
            return 1.0
        from scipy.stats import truncnorm

        return float(truncnorm.std(self.low, self.high))

    def _deviate(self, x: Any) -> Any:
        return self.shift + self.stretch * x


def within(priors: Sequence[Prior], points: Array) -> Array:
    """Coordinates (n, p), put to the end of the prior where they lie beyond it."""
    return np.clip(points, [prior.low for prior in priors], [prior.high for prior in priors])


def prior_of(
    keys: tuple[str, ...],
    written: Any,
    read: Callable[[str, Any], float],
    unit_of: Callable[[str], str] = lambda key: "1",
) -> Prior:
    """The prior that a fit file has for some keys.

    read(name, value) gives a number in SI and unit_of(key) its unit. InputError, one line without
    the file, for what is wrong.
    """
    where = f"[parameters] {', '.join(keys)}"
    if not isinstance(written, dict) or written.get("distribution") not in tuple(_KEYS):
        names = ", ".join(_KEYS)
        raise InputError(
            f"{where}: write a prior, such as {{ distribution = 'uniform', min = 0.1, max = 0.8 }}"
            f"; distributions: {names}"
        )
    kind = written["distribution"]
    known, needed = _KEYS[kind], _KEYS[kind][:2]
    for key in written:
        if key not in known and key != "distribution":
            raise InputError(f"{where}: unknown key {key!r}; {nearest(key, known)}")
    if lacking := [key for key in needed if key not in written]:
        raise InputError(f"{where}: {lacking[0]} is missing; a {kind} prior has {', '.join(known)}")
    numbers = {key: read(key, written[key]) for key in known if key in written}
    if numbers.get("min", -math.inf) >= numbers.get("max", math.inf):
        raise InputError(f"{where}: min = {written['min']!r}: must be below max")
    unit = unit_of(keys[0])
    if kind == "uniform":
        return _uniform(keys, numbers["min"], numbers["max"], unit)
    return _normal(keys, kind, numbers, unit, where)


def _uniform(keys: tuple[str, ...], low: float, high: float, unit: str) -> Prior:
    end = math.sqrt(3)
    return Prior(keys, "uniform", (low + high) / 2, (high - low) / (2 * end), -end, end, unit)


def _normal(
    keys: tuple[str, ...], kind: Any, numbers: dict[str, float], unit: str, where: str
) -> Prior:
    mean, sd = numbers["mean"], numbers["sd"]
    if not sd > 0:
        raise InputError(f"{where}: sd = {sd:g}: must be above 0")
    centre, width = mean, sd
    transform: Callable[[float], float] = float
    if kind == "lognormal":
        if not mean > 0:
            raise InputError(f"{where}: mean = {mean:g}: must be above 0 for a lognormal prior")
        # The logarithm is normal; its two numbers follow from mean and deviation of the values.
        width = math.sqrt(math.log1p((sd / mean) ** 2))
        centre = math.log(mean) - width**2 / 2
        transform = _log
    low, high = (
        (transform(numbers[key]) - centre) / width if key in numbers else side * _REACH
        for key, side in (("min", -1), ("max", 1))
    )
    low, high = max(low, -_REACH), min(high, _REACH)
    if not high - low > _LEAST:
        raise InputError(f"{where}: nearly nothing of the prior is between min and max")
    shift, stretch = _cut_off(low, high)
    if stretch >= _NARROW:
        return Prior(keys, kind, centre, width, low, high, unit)
    own_low, own_high = ((end - shift) / stretch for end in (low, high))
    centre, width = centre + width * shift, width * stretch
    return Prior(keys, kind, centre, width, own_low, own_high, unit, shift, stretch)


def _cut_off(low: float, high: float) -> tuple[float, float]:
    """Mean and standard deviation of a standard normal distribution between two near ends.

    By Gauss and Legendre's quadrature: differences of the distribution function lose all digits
    where the ends are near.
    """
    at, weight = np.polynomial.legendre.leggauss(_NODES)
    middle, half = (low + high) / 2, (high - low) / 2
    off = half * at  # from the middle
    weight = weight * np.exp(-off * (middle + off / 2))
    mean = np.average(off, weights=weight)
    sd = math.sqrt(np.average((off - mean) ** 2, weights=weight))
    return float(middle + mean), sd


def _log(value: float) -> float:
    return math.log(value) if value > 0 else -math.inf
