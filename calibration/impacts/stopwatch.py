"""Times of impacts that an acoustic stopwatch exports, to the restitution of each throw.

A phone writes a sheet with the times of what it heard and the intervals between ("Event time (s)",
"Interval (s)"), one throw below or next to the other. Events that no row of shrinking flights holds
(a knock, the ball that rolls) are found as in a signal, and left out with the reason.

e = T(k+1)/T(k) (thesis, eq. 7.5) rises with falling speed where air slows the flights: by drag that
goes as the square of speed, with w the speed at which a fall ends,

    T(k+1)/T(k) = e (1 - x(k)/w^2),      x = (u(k)^2 + u(k+1)^2)/4,      u = g T/2,

to first order in (u/w)^2 (calibration/drop/drag.py). The slope is fitted to all throws of a file
together, each with its own restitution. Where it differs from none (Student's test, p below 0.01)
the value is that with the drag term; a contact that gets more elastic with falling speed would look
the same, and both values are reported.
"""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from calibration.files.dialect import UTF_16, Row, name_and_unit, number
from calibration.files.dialect import rows as lines_of
from calibration.files.sheets import is_spreadsheet, sheets
from calibration.files.tables import text_of
from calibration.impacts.ratios import GRAVITY
from calibration.impacts.sequence import bouncing
from calibration.result import AsText, Parameter
from calibration.statistics.quantity import plus_minus
from calibration.statistics.uncertainty import Estimate, Pooled, of_trials, pooled
from granulab.contact.files.units import to_si
from granulab.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_EVENT = re.compile(r"event times?|ereigniszeit|time of event|impact times?", re.IGNORECASE)
_INTERVAL = re.compile(r"interval|intervall|difference|dt", re.IGNORECASE)
_LEAST = 4  # events of a throw: two ratios, of which the scatter can be seen
_SIGNIFICANT = 0.01
_LEVEL = 20.0  # [dB] for all: a stopwatch does not say how loud an event was
_FIRST_BYTES = 4096


@dataclass(frozen=True)
class Throw:
    """Events of one throw [s]: those of its row of flights, and the others with their reasons."""

    name: str
    group: str
    times_s: NDArray[np.float64]
    rejected: tuple[tuple[float, str], ...] = ()

    @property
    def flights(self) -> NDArray[np.float64]:
        """(n - 1,) [s]."""
        return np.diff(self.times_s)

    @property
    def ratios(self) -> NDArray[np.float64]:
        """(n - 2,) of each flight to the one before."""
        return self.flights[1:] / self.flights[:-1]

    @property
    def speeds(self) -> NDArray[np.float64]:
        """(n - 2,) with which the body arrives between two flights [m/s]."""
        return 0.5 * GRAVITY * self.flights[:-1]

    @property
    def slowed(self) -> NDArray[np.float64]:
        """(n - 2,) x of the head of this file [m2/s2]."""
        squares = (0.5 * GRAVITY * self.flights) ** 2
        return (squares[:-1] + squares[1:]) / 4


@dataclass(frozen=True)
class Drag:
    """The drag term: slope of the ratios against x [s2/m2], and the chance of such a one."""

    slope: float
    sigma: float
    p: float

    @property
    def seen(self) -> bool:
        """True if air, or a contact like it, shows."""
        return self.p < _SIGNIFICANT and self.slope > 0


@dataclass(frozen=True, repr=False)
class Stopwatch(AsText):
    """Restitution of the throws of a file; a result (calibration.result).

    plain, with_drag   pooled over the throws, without the drag term and with it
    """

    path: Path
    throws: tuple[Throw, ...]
    plain: Pooled
    with_drag: Pooled | None
    drag: Drag | None
    warnings: tuple[str, ...]

    @property
    def found(self) -> Pooled:
        """Pooled restitution that the drag term decides for."""
        if self.with_drag is not None and self.drag is not None and self.drag.seen:
            return self.with_drag
        return self.plain

    def to_dict(self) -> dict[str, Any]:
        """The object that --json prints."""
        whole, one = self.found.all, self.throws[0] if len(self.throws) == 1 else None
        return {
            "impact_times_s": None if one is None else one.times_s.tolist(),
            "restitution": {
                "value": whole.value,
                "sigma": whole.sigma,
                "per_pair": [float(r) for throw in self.throws for r in throw.ratios],
                "constant_within_noise": None if self.drag is None else not self.drag.seen,
                "without_drag": _of(self.plain.all),
                "with_drag": None if self.with_drag is None else _of(self.with_drag.all),
                "drag_p": None if self.drag is None else self.drag.p,
                "final_speed_m_s": self._final_speed(),
                "groups": {name: _of(each) for name, each in self.found.groups.items()},
                "groups_alike": self.found.alike,
            },
            "throws": [
                {
                    "throw": throw.name,
                    "group": throw.group,
                    "impact_times_s": throw.times_s.tolist(),
                    "per_pair": throw.ratios.tolist(),
                    "impact_speeds_m_s": throw.speeds.tolist(),
                    "rejected": [{"time_s": t, "reason": why} for t, why in throw.rejected],
                }
                for throw in self.throws
            ],
            "warnings": list(self.warnings),
        }

    def text(self) -> str:
        """A line a throw, then what they give together."""
        width = max(len(throw.name) for throw in self.throws)
        lines = []
        for throw in self.throws:
            ratios = " ".join(f"{ratio:.3f}" for ratio in throw.ratios)
            lines.append(f"{throw.name:{width}}  {len(throw.times_s)} impacts, e = {ratios}")
        several = len(self.found.groups) > 1
        for name, one in self.found.groups.items() if several else ():
            lines.append(f"{name}: {_said(one)}, {one.trials} throws")
        if self.drag is not None and self.with_drag is not None:
            lines.append(
                f"without a drag term {_said(self.plain.all)}, with one "
                f"{_said(self.with_drag.all)} (p = {self.drag.p:.2g} that there is none)"
            )
        lines.append(f"restitution {_said(self.found.all)}")
        return "\n".join([*lines, *(f"warning: {words}" for words in self.warnings)])

    def parameters(self) -> dict[str, Parameter]:
        """The pooled restitution."""
        return {"restitution": Parameter(self.found.all, "times of an acoustic stopwatch")}

    def figure(self) -> "Figure":
        """Ratios of flights against impact speed, and what is fitted to them."""
        from matplotlib.figure import Figure

        from granulab.campaign.output.figure import BLUE, GREY, VERMILION, headline

        figure = Figure(figsize=(9.0, 5.0), layout="constrained")
        axes = figure.add_subplot()
        for throw in self.throws:
            axes.plot(throw.speeds, throw.ratios, "o-", color=BLUE, linewidth=0.6, markersize=4)
        plain = self.plain.all.value
        axes.axhline(plain, color=GREY, label=f"no drag: e = {plain:.4f}")
        if self.with_drag is not None and self.drag is not None:
            speeds = np.linspace(0.0, max(float(throw.speeds.max()) for throw in self.throws), 50)
            e, slope = self.with_drag.all.value, self.drag.slope
            x = speeds**2 * (1 + e**2) / 4
            axes.plot(speeds, e - slope * x, color=VERMILION, label=f"drag: e = {e:.4f} at rest")
        axes.set_xlabel("impact speed [m/s]")
        axes.set_ylabel("flight over the one before [-]")
        axes.legend()
        headline(
            figure, f"{self.path.name}: {len(self.throws)} throws, e = {_said(self.found.all)}"
        )
        return figure

    def _final_speed(self) -> float | None:
        """Speed at which a fall through the air would end [m/s]; None where no drag shows."""
        if self.drag is None or self.with_drag is None or not self.drag.seen:
            return None
        return math.sqrt(self.with_drag.all.value / self.drag.slope)


def measure_stopwatch(path: str | Path) -> Stopwatch | None:
    """The throws of a stopwatch's export (xls, xlsx, csv); None for a file of another kind.

    Raises InputError where it holds events of which no three flights shrink.
    """
    path = Path(path)
    read = list(_columns_of(path))
    if not read:
        return None
    throws, short = [], []
    for name, group, times in read:
        row = bouncing(times, np.full(len(times), _LEVEL)) if len(times) >= _LEAST else []
        if len(row) < _LEAST:
            short.append(name)
            continue
        throws.append(Throw(name, group, times[row], tuple(_left_out(times, row))))
    if not throws:
        raise InputError(
            f"{path}: no throw: none of its columns of events has {_LEAST} whose intervals shrink "
            "as those of a bouncing body do"
        )
    drag = _drag_of(throws)
    plain = _pooled(throws, [throw.ratios for throw in throws])
    with_drag = None
    if drag is not None:
        slowed = float(np.mean([throw.slowed.mean() for throw in throws]))
        corrected = [throw.ratios + drag.slope * throw.slowed for throw in throws]
        with_drag = _wider(_pooled(throws, corrected), drag.sigma * slowed)
    return Stopwatch(
        path, tuple(throws), plain, with_drag, drag, tuple(_warnings(throws, short, drag))
    )


def _columns_of(path: Path) -> Iterator[tuple[str, str, NDArray[np.float64]]]:
    """Name, sheet and events [s] of each throw that a file holds."""
    if is_spreadsheet(path):
        for sheet, lines in sheets(path).items():
            for name, times in _throws_of(lines, str(path)):
                yield f"{sheet.strip()}{name}", sheet.strip(), times
    elif _names_events(path):
        for name, times in _throws_of(lines_of(text_of(path), str(path)), str(path)):
            yield f"{path.stem}{name}", path.stem, times


def _names_events(path: Path) -> bool:
    """True for a text whose first line names events: other files are not read whole for it."""
    try:
        with path.open("rb") as file:
            start = file.read(_FIRST_BYTES)
    except (OSError, ValueError):
        return False
    wide = start.startswith(UTF_16)
    first = start.decode("utf-16" if wide else "utf-8", errors="replace").partition("\n")[0]
    return re.search(_EVENT.pattern, first, re.IGNORECASE) is not None


def _throws_of(lines: Sequence[Row], where: str) -> Iterator[tuple[str, NDArray[np.float64]]]:
    """Events of each column of a sheet that is named so; an interval behind them adds one."""
    if not lines:
        return
    head = lines[0][1]
    columns = [k for k, field in enumerate(head) if _EVENT.fullmatch(name_and_unit(field)[0])]
    for count, k in enumerate(columns, start=1):
        unit = name_and_unit(head[k])[1]
        scale = to_si(f"1 {unit}", "s", f"{where}: {head[k]!r}") if unit else 1.0
        times = _numbers_of(lines[1:], k)
        if k + 1 < len(head) and _INTERVAL.fullmatch(name_and_unit(head[k + 1])[0]):
            last = _numbers_of(lines[1:], k + 1)
            if len(last) == len(times) > 0 and last[-1] > 0:  # to an event that has no line
                times = [*times, times[-1] + last[-1]]
        if any(later <= earlier for earlier, later in pairwise(times)):
            raise InputError(f"{where}: {head[k]!r}: times do not rise from line to line")
        if times:
            name = f", throw {count}" if len(columns) > 1 else ""
            yield name, scale * np.array(times)


def _numbers_of(lines: Sequence[Row], column: int) -> list[float]:
    """The numbers of a column, down to its last."""
    fields = [number(fields[column]) for _, fields in lines if column < len(fields)]
    return [value for value in fields if value is not None and math.isfinite(value)]


def _left_out(times: NDArray[np.float64], row: list[int]) -> Iterator[tuple[float, str]]:
    """Events outside a row, and why they are none of its impacts."""
    kept = times[row]
    usual = float(np.median(np.diff(kept)[1:] / np.diff(kept)[:-1]))
    for k in sorted(set(range(len(times))) - set(row)):
        time = float(times[k])
        if time > kept[-1]:
            flight = time - max(float(times[k - 1]), float(kept[-1]))
            before = float(times[k - 1] - times[k - 2])
            yield (
                time,
                (
                    f"its flight is {flight / before:.2f} of the one before, and those of the row "
                    f"{usual:.2f}: no bounce of it"
                ),
            )
        elif time < kept[0]:
            yield time, "before the first flight of the row"
        else:
            yield time, "between two impacts, within a flight"


def _drag_of(throws: Sequence[Throw]) -> Drag | None:
    """Slope of the ratios against x, each throw with its own mean; None with too few pairs."""
    from scipy.stats import t

    x = np.concatenate([throw.slowed - throw.slowed.mean() for throw in throws])
    y = np.concatenate([throw.ratios - throw.ratios.mean() for throw in throws])
    freedom = len(x) - len(throws) - 1
    if freedom < 2 or not x.any():
        return None
    slope = -float(x @ y / (x @ x))
    left = y + slope * x
    sigma = math.sqrt(float(left @ left) / freedom / float(x @ x))
    p = 2 * float(t.sf(abs(slope) / sigma, freedom)) if sigma else 0.0
    return Drag(slope, sigma, p)


def _pooled(throws: Sequence[Throw], ratios: Sequence[NDArray[np.float64]]) -> Pooled:
    """One throw from its pairs; several as trials, in groups of the sheets that they stand on."""
    if len(throws) == 1:
        one = of_trials(ratios[0].tolist())
        return Pooled(one, {throws[0].group: one}, None)
    groups: dict[str, list[float]] = {}
    for throw, each in zip(throws, ratios, strict=True):
        groups.setdefault(throw.group, []).append(float(each.mean()))
    return pooled(groups)


def _wider(found: Pooled, by: float) -> Pooled:
    """The same with the uncertainty of what all throws share."""

    def one(each: Estimate) -> Estimate:
        sigma = None if each.sigma is None else math.hypot(each.sigma, by)
        return Estimate(each.value, sigma, each.trials, each.scatter)

    groups = {name: one(each) for name, each in found.groups.items()}
    return Pooled(one(found.all), groups, found.p)


def _warnings(throws: Sequence[Throw], short: Sequence[str], drag: Drag | None) -> Iterator[str]:
    for throw in throws:
        for time, why in throw.rejected:
            yield f"{throw.name}: event at {time:.4f} s left out: {why}"
    for name in short:
        yield f"{name} left out: fewer than {_LEAST} events whose intervals shrink"
    if drag is not None and drag.seen:
        yield (
            f"the ratios rise as the body gets slower (p = {drag.p:.2g}), as air drag makes them; "
            "a contact that is more elastic at lower speed would look the same"
        )
    elif drag is not None and drag.p < _SIGNIFICANT:
        yield (
            f"the ratios fall as the body gets slower (p = {drag.p:.2g}): no air drag; one number "
            "does not describe them"
        )


def _of(one: Estimate) -> dict[str, Any]:
    return {"value": one.value, "sigma": one.sigma, "trials": one.trials}


def _said(one: Estimate) -> str:
    return plus_minus(one.value, one.sigma) if one.sigma else f"{one.value:.4g}"
