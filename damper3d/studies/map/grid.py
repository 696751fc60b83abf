"""The efficiency over frequency and Gamma: a grid of runs, refined about the peaks along Gamma."""

import itertools
import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from damper3d.case.case import DamperCase
from damper3d.run.sweep import run_cases
from damper3d.studies.map.peaks import Peak, between, find_peaks
from granulab.campaign.output.files import in_shell
from granulab.campaign.output.layout import stopped
from granulab.campaign.output.statistics import half_width_of_mean, mean_sd
from granulab.campaign.sweeps.sweep import Labelled, over_seeds, refuse_interrupted
from granulab.contact.files.units import nearest
from granulab.errors import InputError

if TYPE_CHECKING:
    from pandas import DataFrame

Floats = NDArray[np.float64]
Rows = list[dict[str, Any]]
Points = Sequence[tuple[float, float]]  # frequency [Hz] and Gamma

# Of the thesis (Table 6.1).
FREQUENCIES = (20.0, 40.0, 80.0, 125.0, 160.0, 200.0, 320.0, 625.0, 1024.0)  # [Hz]
GAMMAS = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 15.0, 20.0, 30.0, 40.0, 50.0,
          60.0, 80.0, 100.0)  # fmt: skip

STEEP = 0.2  # change of the efficiency to the next Gamma, from which on a map is steep


@dataclass(frozen=True)
class Grid:
    """Points of a map: frequencies [Hz] times Gammas, each for N packings.

    `seed` is that of the first packing; the others follow. `refine` is how often the intervals
    about each peak along Gamma are halved (damper3d.studies.map.peaks).
    Raises InputError where a list is empty or holds what is not above zero.
    """

    frequencies: tuple[float, ...] = FREQUENCIES
    gammas: tuple[float, ...] = GAMMAS
    packings: int = 1
    refine: int = 0
    seed: int = 1

    def __post_init__(self) -> None:
        object.__setattr__(self, "frequencies", rising("frequencies", self.frequencies))
        object.__setattr__(self, "gammas", rising("gammas", self.gammas))
        for name, value, least in (
            ("packings", self.packings, 1),
            ("refine", self.refine, 0),
            ("seed", self.seed, 0),
        ):
            if value < least:
                raise InputError(f"{name} = {value}: must be at least {least}")

    @property
    def points(self) -> list[tuple[float, float]]:
        """Frequency and Gamma of each point, before it is refined."""
        return list(itertools.product(self.frequencies, self.gammas))


@dataclass(frozen=True)
class MapResult:
    """The efficiency at n points, by rising frequency and then Gamma, from a row a run.

    A point whose runs all lack has NaN.
    """

    rows: Rows
    frequency: Floats  # (n,) [Hz]
    gamma: Floats  # (n,)
    _groups: list[Rows]  # the runs of each point that are done

    @classmethod
    def of(cls, rows: Iterable[dict[str, Any]]) -> "MapResult":
        """From rows as run_cases gives them, with the labels frequency_hz and gamma."""
        groups: dict[tuple[float, float], Rows] = {}
        for row in (rows := list(rows)):
            groups.setdefault((row["frequency_hz"], row["gamma"]), []).append(row)
        points = sorted(groups)
        done = [[row for row in groups[p] if row["state"] == "done"] for p in points]
        frequency, gamma = np.array(points, float).reshape(-1, 2).T
        return cls(rows, frequency, gamma, done)

    @cached_property
    def columns(self) -> list[str]:
        """Names of the columns of numbers that any row has."""
        named = (name for row in self.rows for name, value in row.items() if _is_number(value))
        return list(dict.fromkeys(named))

    @cached_property
    def efficiency(self) -> Floats:
        """Mean over the packings (n,)."""
        return self._mean("efficiency")

    @cached_property
    def half_width(self) -> Floats:
        """Half width of the efficiency's 95 % interval (n,), NaN where it is not known.

        Over packings where there are several, else that over the cycles of the one run.
        """
        return np.array([_half_width(group) for group in self._groups])

    @cached_property
    def packings(self) -> NDArray[np.int64]:
        """Runs that are done at each point (n,)."""
        return np.array([len(group) for group in self._groups])

    @cached_property
    def phases(self) -> list[str | None]:
        """Name of the phase that most runs of a point show; of equally many, the first run's."""
        return [_commonest([row.get("phase") for row in group]) for group in self._groups]

    def scatter(self, column: str) -> Floats:
        """Half width (n,) of the 95 % interval of a column's mean over the packings.

        Student's; NaN where there is one packing or none.
        """
        return np.array([_of_packings(_numbers(group, column)) for group in self._groups])

    def frame(self) -> "DataFrame":
        """A row a point: frequency, Gamma, mean efficiency, its half width, packings, phase."""
        from pandas import DataFrame

        return DataFrame({
            "frequency_hz": self.frequency, "gamma": self.gamma, "efficiency": self.efficiency,
            "half_width": self.half_width, "packings": self.packings, "phase": self.phases,
        })  # fmt: skip

    def mean(self, column: str) -> Floats:
        """Mean over the packings of a column of numbers (n,), such as "law_term".

        NaN where no run has a value. Raises InputError where no row has such a column.
        """
        if column not in self.columns:
            raise InputError(f"column {column!r}: not in the map; {nearest(column, self.columns)}")
        return self._mean(column)

    def _mean(self, column: str) -> Floats:
        values = [_numbers(group, column) for group in self._groups]
        return np.array([math.fsum(v) / len(v) if v else math.nan for v in values])

    def at(self, frequency: float) -> NDArray[np.int64]:
        """Indices of the points of a frequency [Hz] that have a value, by rising Gamma."""
        return np.flatnonzero((self.frequency == frequency) & np.isfinite(self.efficiency))

    def peaks(self, frequency: float) -> list[Peak]:
        """Maxima along Gamma that stand out of the noise; their index counts within at()."""
        chosen = self.at(frequency)
        return find_peaks(self.gamma[chosen], self.efficiency[chosen], self.half_width[chosen])

    def to_add(self) -> list[tuple[float, float]]:
        """The points that a further refinement computes."""
        return [
            (float(frequency), gamma)
            for frequency in np.unique(self.frequency)
            for chosen in [self.at(frequency)]
            for gamma in between(
                self.gamma[chosen], self.efficiency[chosen], self.half_width[chosen]
            )
        ]

    def steep(self) -> list[tuple[float, float]]:
        """The points whose efficiency is more than STEEP from that of the next Gamma."""
        found = []
        for frequency in np.unique(self.frequency):
            chosen = self.at(frequency)
            apart = np.flatnonzero(np.abs(np.diff(self.efficiency[chosen])) > STEEP)
            beside = chosen[np.union1d(apart, apart + 1)]
            found += [(float(frequency), float(gamma)) for gamma in self.gamma[beside]]
        return found


def counted(rows: Iterable[dict[str, Any]], column: str) -> Rows:
    """The rows with another column as their efficiency; its interval is that column's, or None."""
    interval = column.replace("efficiency", "efficiency_interval")
    return [
        row | {"efficiency": row.get(column), "efficiency_interval": row.get(interval)}
        for row in rows
    ]


def efficiency_map(
    name_or_path: str, changes: dict[str, Any], grid: Grid, *, out: Path, **engine: Any
) -> MapResult:
    """Run a case over a grid; runs that are finished below `out` are not done again.

    `name_or_path` and `changes` are those of DamperCase.load, `engine` is what run_cases takes.
    Points are added in rounds, after whole rounds only: the same grid gives the same points
    whatever was interrupted. Raises what DamperCase.load and run_cases raise. After Ctrl-C, or a
    notebook's interrupt, KeyboardInterrupt: what ran has kept its state, and the same call goes on.
    """
    result = map_so_far(name_or_path, changes, grid, out=out, **engine)
    refuse_interrupted(result.rows)
    return result


def map_so_far(
    name_or_path: str, changes: dict[str, Any], grid: Grid, *, out: Path, **engine: Any
) -> MapResult:
    """The efficiency map, after Ctrl-C of the runs that are done; the others are among its rows."""
    rounds = iter(range(grid.refine))

    def to_add(result: MapResult) -> Points:
        return result.to_add() if next(rounds, None) is not None else []

    return grow(name_or_path, changes, grid, to_add, out=out, **engine)


def grow(
    name_or_path: str,
    changes: dict[str, Any],
    grid: Grid,
    to_add: Callable[[MapResult], Points],
    *,
    out: Path,
    **engine: Any,
) -> MapResult:
    """Run a case over a grid, then at the points that to_add gives of what is there, until none.

    After whole rounds only. The other arguments, and what is raised, are those of map_so_far.
    """
    rows = run_cases(map_cases(name_or_path, changes, grid), out=out, **engine)
    while not stopped(rows):
        added = to_add(MapResult.of(rows))
        if not added:
            break
        cases = map_cases(name_or_path, changes, grid, added)
        rows = rows + run_cases(cases, out=out, **engine)
    return MapResult.of(rows)


def map_cases(
    name_or_path: str,
    changes: dict[str, Any],
    grid: Grid,
    points: Points | None = None,
) -> list[Labelled]:
    """The case at each point of a grid, or at `points` instead, once for each packing.

    A point is (frequency, Gamma); the labels are frequency_hz, gamma and seed. InputError where the
    case has a host or an excitation.
    """
    own = DamperCase.load(name_or_path, changes)
    moved = "host" if own.modes is not None else "excitation" if own.excitation is not None else ""
    if moved:
        respond = (
            f"damper3d response {in_shell(str(name_or_path))} --simulate --frequencies 38,40,42"
        )
        raise InputError(
            f"{name_or_path}: [{moved}] moves the enclosure, and runs over frequency and Gamma are "
            f"of a prescribed sine; give a case without [{moved}]"
            + (f", or ask for its response: {respond}" if moved == "host" else "")
        )
    cases: list[Labelled] = []
    for frequency, gamma in grid.points if points is None else points:
        here = {"motion.frequency": frequency, "motion.gamma": gamma, "output.keep": "summary"}
        case = DamperCase.load(name_or_path, changes | here)
        labels = {"frequency_hz": frequency, "gamma": gamma}
        cases += over_seeds(labels, case, range(grid.seed, grid.seed + grid.packings))
    return cases


def rising(name: str, values: Sequence[float]) -> tuple[float, ...]:
    """The values, each once and rising; InputError where there is none or one is not usable."""
    if not values:
        raise InputError(f"{name}: empty; give numbers above 0, such as 20,40,80")
    for value in values:
        if not 0 < value < math.inf:
            raise InputError(f"{name}: {value:g}: must be above 0, such as 20")
    return tuple(sorted({float(value) for value in values}))


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float | np.number) and not isinstance(value, bool)


def _numbers(group: Rows, column: str) -> list[float]:
    return [row[column] for row in group if _is_number(row.get(column))]


def _of_packings(values: list[float]) -> float:
    """Half width of the interval of the mean of some packings' values; NaN for fewer than two."""
    half = half_width_of_mean(mean_sd(values))
    return math.nan if half is None else half


def _half_width(group: Rows) -> float:
    """Half width of the interval of a point's efficiency, from its runs that are done."""
    group = [row for row in group if row["efficiency"] is not None]  # the bed settles
    over_packings = _of_packings([row["efficiency"] for row in group])
    if not math.isnan(over_packings):
        return over_packings
    interval = group[0].get("efficiency_interval") if group else None
    if interval is None or None in interval:
        return math.nan
    low, high = interval
    return (high - low) / 2


def _commonest(phases: list[str | None]) -> str | None:
    named = [phase for phase in phases if phase]
    return Counter(named).most_common(1)[0][0] if named else None
