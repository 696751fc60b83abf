"""The values that a key takes in a study: listed, in a range, or drawn from a distribution."""

import hashlib
import math
from collections.abc import Callable
from typing import Any

from granulab.contact.files.units import nearest

_RANGE = ("start", "stop", "step", "number", "log")
_DRAWN = {
    "normal": ("mean", "sd", "min", "max"),
    "lognormal": ("mean", "sd", "min", "max"),
    "uniform": ("min", "max"),
}
_OFF = 1e-6  # of a step that stop may be off, by rounding
_DIGITS = 12  # that a value of a range or a distribution has: 0.3, not 0.30000000000000004


class SeriesError(ValueError):
    """Values that cannot be understood; one line that says what would do."""


def series(
    written: Any, keys: tuple[str, ...], read: Callable[[str, Any], Any], seed: int, most: int
) -> list[Any]:
    """The values, in SI, that are written for some keys; each key's reader must take them all.

    Values drawn depend on the seed and the keys alone. Raises SeriesError, also for more than
    `most` values, and what `read` raises.
    """
    where = f"[vary] {', '.join(keys)}"

    def one(value: Any) -> Any:
        values = [read(key, value) for key in keys]  # each of them must take it
        return values[0]

    def number(name: str, value: Any) -> float:
        found = one(value)
        if isinstance(found, bool) or not isinstance(found, int | float):
            raise SeriesError(f"{where}: {name} = {value!r}: must be a number; words go in a list")
        return found

    if isinstance(written, list):
        if not written:
            raise SeriesError(f"{where} = []: give at least one value")
        return [one(value) for value in written]
    if not isinstance(written, dict):
        return [one(written)]
    if "distribution" in written:
        return _drawn(written, where, number, (seed, keys), most)
    return _range(written, where, number, most)


def _range(
    table: dict[str, Any], where: str, number: Callable[[str, Any], float], most: int
) -> list[float]:
    _check_names(table, _RANGE, ("start", "stop"), where)
    start, stop = number("start", table["start"]), number("stop", table["stop"])
    if ("step" in table) == ("number" in table):
        raise SeriesError(f"{where}: write step or number, one of them")
    log = table.get("log", False)
    if not isinstance(log, bool):
        raise SeriesError(f"{where}: log = {log!r}: must be true or false")
    if "step" in table:
        step = number("step", table["step"])
        if log:
            raise SeriesError(f"{where}: a range with log = true takes number, not step")
        if step == 0 or (stop - start) / step < 0:
            raise SeriesError(
                f"{where}: step = {table['step']!r} does not lead from {table['start']!r} to "
                f"{table['stop']!r}"
            )
        steps = (stop - start) / step
        _check_count(steps + 1, where, most)
        count = round(steps) + 1
        if abs(steps - round(steps)) > _OFF:
            raise SeriesError(
                f"{where}: stop = {table['stop']!r} is {steps:.4g} steps of {table['step']!r} from "
                f"{table['start']!r}, no whole number; give another stop or step, or number"
            )
        return [_tidy(start + k * step) for k in range(count)]
    count = _count(table, where, most, least=2)
    if log:
        if start <= 0 or stop <= 0:
            raise SeriesError(f"{where}: a range with log = true needs start and stop above 0")
        ratio = math.log(stop / start)
        return [_tidy(start * math.exp(ratio * k / (count - 1))) for k in range(count)]
    return [_tidy(start + (stop - start) * k / (count - 1)) for k in range(count)]


def _drawn(
    table: dict[str, Any],
    where: str,
    number: Callable[[str, Any], float],
    stream: tuple[int, tuple[str, ...]],
    most: int,
) -> list[float]:
    """Draws by the inverse of the distribution function, cut off at min and max."""
    from scipy.special import ndtr, ndtri

    kind = table["distribution"]
    if kind not in tuple(_DRAWN):  # also a list, which has no hash
        raise SeriesError(f"{where}: distribution = {kind!r}: {nearest(str(kind), list(_DRAWN))}")
    known = ("distribution", "number", *_DRAWN[kind])
    needed = ("number", *(("min", "max") if kind == "uniform" else ("mean", "sd")))
    _check_names(table, known, needed, where)
    u = _uniform(*stream, _count(table, where, most, least=1))
    low = number("min", table["min"]) if "min" in table else -math.inf
    high = number("max", table["max"]) if "max" in table else math.inf
    if not low < high:
        raise SeriesError(f"{where}: min = {table['min']!r}: must be below max, {table['max']!r}")
    if kind == "uniform":
        return [_tidy(low + (high - low) * x) for x in u]
    mean = number("mean", table["mean"])
    sd = _deviation(table["sd"], mean, number)
    if not sd > 0:
        raise SeriesError(f"{where}: sd = {table['sd']!r}: must be greater than 0")
    if kind == "lognormal":
        if mean <= 0:
            raise SeriesError(f"{where}: mean = {table['mean']!r}: must be greater than 0")
        # The logarithm is normal; its two numbers follow from mean and deviation of the values.
        spread = math.sqrt(math.log1p((sd / mean) ** 2))
        centre, transform = math.log(mean) - spread**2 / 2, math.exp
        low, high = (math.log(x) if x > 0 else -math.inf for x in (low, high))
    else:
        spread, centre, transform = sd, mean, float
    below, above = ndtr((low - centre) / spread), ndtr((high - centre) / spread)
    if not above - below > 1e-9:
        raise SeriesError(f"{where}: nearly nothing of the distribution is between min and max")
    return [_tidy(transform(centre + spread * ndtri(below + (above - below) * x))) for x in u]


def _deviation(written: Any, mean: float, number: Callable[[str, Any], float]) -> float:
    """A standard deviation in the unit of the key, or in % of the mean."""
    if isinstance(written, str) and written.strip().endswith("%"):
        try:
            return abs(mean) * float(written.strip().removesuffix("%")) / 100
        except ValueError:
            pass  # the reader says what is wrong
    return number("sd", written)


def _uniform(seed: int, keys: tuple[str, ...], count: int) -> Any:
    """Numbers between 0 and 1, ends excluded, that other keys of the study do not change.

    Made from the bits themselves: these are promised for every version of numpy.
    """
    import numpy as np

    named = hashlib.sha256(", ".join(keys).encode()).digest()
    bits = np.random.PCG64([seed, *np.frombuffer(named, "<u4").tolist()]).random_raw(count)
    return ((bits >> np.uint64(11)) + 0.5) * 2.0**-53


def _tidy(value: float) -> float:
    return value if isinstance(value, int) else float(f"{value:.{_DIGITS}g}")


def _count(table: dict[str, Any], where: str, most: int, least: int) -> int:
    count = table["number"]
    if not isinstance(count, int) or isinstance(count, bool) or count < least:
        raise SeriesError(f"{where}: number = {count!r}: must be an integer, {least} or more")
    _check_count(count, where, most)
    return count


def _check_count(count: float, where: str, most: int) -> None:
    if not count < most + 1:
        raise SeriesError(f"{where}: {count:,.12g} values; at most {most:,} runs in one study")


def _check_names(
    table: dict[str, Any], known: tuple[str, ...], needed: tuple[str, ...], where: str
) -> None:
    unknown = next((name for name in table if name not in known), None)
    if unknown is not None:
        raise SeriesError(f"{where}: unknown key {unknown!r}; {nearest(unknown, known)}")
    missing = next((name for name in needed if name not in table), None)
    if missing is not None:
        raise SeriesError(f"{where}: {missing} is missing; known: {', '.join(known)}")
