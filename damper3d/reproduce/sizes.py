"""Figs 6.12, 6.22 and 6.26: spheres of 3, 4, 5 and 6 mm, the same volume, at 20 and 160 Hz.

In the cylinder of 40 mm (fill ratio 0.466), in both orientations. At 20 Hz the optimum is the
bouncing bed's onset, at 160 Hz that of fluidisation. The thesis's Gammas are run for each packing,
then the intervals beside each peak are halved twice.
"""

import itertools
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from damper3d.reproduce.dampers import ORIENTATIONS, SPHERES, about, close_onset, panel
from damper3d.reproduce.optima import Optimum, optimum, pooled_scatter, with_scatter
from damper3d.reproduce.runs import Panel, Row, labels_of, run_panels
from damper3d.reproduce.standing import standing
from damper3d.reproduce.statements import Check, Statement, all_of, report_statements
from damper3d.studies.map.grid import MapResult
from granulab.campaign.output.layout import columns
from granulab.campaign.output.statistics import slope

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEEDS = 3
RIDGES = {20.0: "bouncing_bed", 160.0: "fluidisation"}  # by frequency [Hz]
REFINE = 2
_HEIGHT = 40  # mm
_FLUIDISED = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 15.0, 20.0]  # Gammas at 160 Hz
_AROUND = 2.5  # factor about the onset of the bouncing bed at 20 Hz
_SMALL = 1.5  # largest over least optimum that is a small effect; see sizes in the docs
_NOTABLE = 0.1  # of eta: root-mean-square difference of two sizes that is notable

Key = tuple[str, float]  # orientation, frequency [Hz]

_CRITERION = f"""\
ours: where eta peaks along Gamma on the ridge named, geometric mean +- standard deviation over the
  packings, each with its own peak (their number); bracket: between which Gammas the peak of the
  mean curve lies by more than noise; +-: the scatter of the mean, pooled over all lines, and
  half the bracket together. A small effect: largest over least optimum at most {_SMALL:g}, about
  what 5 mm of height do at 40 mm (eq. 6.11, close packing). The trend is the slope of ln Gamma
  against ln diameter through the optima of all packings, with its 95 % interval."""


def panels() -> list[Panel]:
    """The eight dampers, with the points before their refinement."""
    points = [(20.0, g) for g in about(close_onset(_HEIGHT, 20.0), _AROUND)]
    points += [(160.0, g) for g in _FLUIDISED]
    return [panel(o, _HEIGHT, diameter, points) for o in ORIENTATIONS for diameter in SPHERES]


def run(
    *,
    out: Path,
    seeds: Sequence[int],
    workers: int | None,
    quiet: bool,
    grid: Sequence[Panel] | None = None,
    refine: int = REFINE,
    **engine: str,
) -> list[Row]:
    """All points of the table, or of another grid, with all packings."""
    return run_panels(
        panels() if grid is None else grid, seeds, refine=refine, out=out, workers=workers,
        quiet=quiet, **engine,
    )  # fmt: skip


Found = Mapping[Key, Mapping[int, Optimum | None]]  # then by diameter [mm]


def optima(rows: Sequence[Row]) -> dict[Key, dict[int, Optimum | None]]:
    """The optima of each orientation and frequency, by the spheres' diameter [mm]."""
    found: dict[Key, dict[int, Optimum | None]] = {}
    for (orientation, frequency), diameter in itertools.product(_keys(rows), SPHERES):
        own = [row for row in rows if _is_of(row, (orientation, frequency), diameter)]
        if own:
            here = found.setdefault((orientation, frequency), {})
            here[diameter] = optimum(own, frequency, RIDGES[frequency])
    return found


def _keys(rows: Sequence[Row]) -> list[Key]:
    return sorted({(row["orientation"], row["frequency_hz"]) for row in rows}, reverse=True)


def _is_of(row: Row, key: Key, diameter: int) -> bool:
    return (row["orientation"], row["frequency_hz"], row["diameter_mm"]) == (*key, diameter)


def report(rows: list[Row]) -> str:
    """What lacks, the optimum of each size, the statements, the criterion."""
    found = optima(rows)
    pooled = pooled_scatter([one for own in found.values() for one in own.values()])
    lines = [
        _line(key, diameter, one, pooled)
        for key, own in found.items()
        for diameter, one in own.items()
    ]
    heads = [
        "orientation",
        "f [Hz]",
        "ridge",
        "spheres",
        "ours",
        "bracket",
        "+-",
        "eta",
        "LP",
        "CP",
    ]
    parts = [
        standing(rows, labels_of(panels()), SEEDS),
        columns(heads, lines),
        report_statements(statements(rows, found)),
        _CRITERION,
    ]
    return "\n\n".join(filter(None, parts))


def _line(
    key: Key, diameter: int, one: Optimum | None, pooled: tuple[float, int] | None
) -> list[str]:
    orientation, frequency = key
    ridge = RIDGES[frequency].replace("_", " ")
    head = [orientation, f"{frequency:g}", ridge, f"{diameter} mm"]
    if one is None:
        return [*head, "no peak", "-", "-", "-", "-", "-"]
    low, high = one.mean.bracket
    onsets = [one.predicted(name) for name in ("loose", "close")]
    shown = [f"{onset:.3g}" if onset and ridge == "bouncing bed" else "-" for onset in onsets]
    error = f"{100 * one.error(pooled):.0f} %"
    return [*head, with_scatter(one), f"{low:.3g} to {high:.3g}", error,
            f"{one.mean.efficiency:.3f}", *shown]  # fmt: skip


def statements(rows: Sequence[Row], found: Found) -> list[Statement]:
    """What the thesis says of the sizes: sec. 6.4.1 of 20 Hz, sec. 6.4.3.2 of 160 Hz."""
    bouncing = {key: own for key, own in found.items() if key[1] == 20.0}
    fluidised = {key: own for key, own in found.items() if key[1] == 160.0}
    return [
        _small_effect(bouncing, "the bouncing bed's optimum"),
        _falls_with_size(bouncing),
        _small_effect(fluidised, "the fluidisation optimum"),
        _curves_alike(rows, [key for key in fluidised if key[0] == "vertical"]),
    ]


def _small_effect(found: Found, what: str) -> Statement:
    words = f"size has a small effect on {what}: largest over least at most {_SMALL:g}"
    ratios = {}
    for key, own in found.items():
        gammas = [one.gamma for one in own.values() if one]
        if len(gammas) > 1:
            ratios[key] = max(gammas) / min(gammas)
    shown = ", ".join(f"{_place(key)} {ratio:.2f}" for key, ratio in ratios.items())
    return Statement(words, [Check(all_of([ratio <= _SMALL for ratio in ratios.values()]), shown)])


def _falls_with_size(found: Found) -> Statement:
    holds, shown = [], []
    for key, own in found.items():
        known = {diameter: one for diameter, one in own.items() if one}
        x = [math.log(d) for d, one in known.items() for _ in range(max(one.logarithms.n, 1))]
        y = [v for one in known.values() for v in _alone(one)]
        trend = slope(x, y)
        if trend is not None:
            holds.append(trend.value < 0)
            noise = " (within noise)" if abs(trend.value) <= trend.half_width else ""
            shown.append(f"{_place(key)} d^{trend.value:.2f} +- {trend.half_width:.2f}{noise}")
    words = "the bouncing bed's optimum generally falls with size: slope below 0"
    return Statement(words, [Check(all_of(holds), ", ".join(shown))])


def _alone(one: Optimum) -> tuple[float, ...]:
    """ln Gamma of each packing's peak; of none, that of the mean curve."""
    return one.alone or (math.log(one.gamma),)


def _curves_alike(rows: Sequence[Row], keys: Sequence[Key]) -> Statement:
    """Each size's curve against that of 5 mm, at the Gammas that both have."""
    words = (
        "vertical fluidisation and convection are not notably affected by size: eta within "
        f"{_NOTABLE:g} (rms) of 5 mm"
    )
    away = {}
    for key in keys:
        curves = {d: _curve([r for r in rows if _is_of(r, key, d)]) for d in SPHERES}
        for diameter, curve in curves.items():
            common = curve.keys() & curves[5].keys()
            if diameter != 5 and common:
                squares = [(curve[gamma] - curves[5][gamma]) ** 2 for gamma in common]
                away[f"{diameter} mm"] = math.sqrt(math.fsum(squares) / len(squares))
    shown = ", ".join(f"{name} {value:.3f}" for name, value in away.items())
    return Statement(words, [Check(all_of([value <= _NOTABLE for value in away.values()]), shown)])


def _curve(rows: Sequence[Row]) -> dict[float, float]:
    result = MapResult.of(rows)
    known = zip(result.gamma.tolist(), result.efficiency.tolist(), strict=True)
    return {gamma: eta for gamma, eta in known if math.isfinite(eta)}


def _place(key: Key) -> str:
    return f"{key[0]} {key[1]:g} Hz"


def draw(rows: list[Row]) -> "Figure":
    """Efficiency against Gamma of each size, a panel for each orientation and frequency."""
    from damper3d.reproduce.sizes_chart import draw_sizes

    return draw_sizes(rows, optima(rows))
