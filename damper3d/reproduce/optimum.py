"""Table 6.3: the Gamma at which the bouncing bed damps best, with the thesis's and eq. 6.11.

Both orientations, the four heights with 358 spheres of 5 mm, 20 and 40 Hz, and 80 Hz where the
close packing's onset is within Gamma 100. The thesis's Gammas within a factor of two of that onset,
and 120 and 150, are run for each packing; then the intervals next to each peak are halved three
times.
"""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from damper3d.reproduce.panels import (
    HEIGHTS,
    ORIENTATIONS,
    PANEL_COLUMNS,
    Panel,
    Row,
    about,
    close_onset,
    completeness,
    labels_of,
    panel,
    run_of_panels,
)
from damper3d.reproduce.quantities.optima import (
    OPTIMA,
    Line,
    Optimum,
    Table63,
    optimum,
    with_scatter,
)
from damper3d.studies.map.grid import GAMMAS, MapResult
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.claims.judge import report_claims
from granulab.campaign.output.figure import (
    BLUE,
    GREY,
    INK,
    ORANGE,
    VERMILION,
    entries,
    headline,
    ticked,
)
from granulab.campaign.output.layout import columns, paragraphs, signed
from granulab.contact.files.datafile import shipped_rows

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SEEDS = 3
COLUMNS = PANEL_COLUMNS
FREQUENCIES = 20.0, 40.0, 80.0  # Hz
REFINE = 3
_AROUND = 2.0  # factor about the onset within which Gammas are run
_BEYOND = 120.0, 150.0  # Gammas that the thesis has not, so that a peak near 90 can stand out

_CRITERION = """\
ours: where the bouncing bed's peak of eta along Gamma lies, geometric mean +- standard deviation
  over the packings, each with its own peak (their number), by a parabola through its top, which on
  a steep rise lies some per cent high; top: the Gamma run with the largest mean eta; bracket:
  between which Gammas the peak of the mean curve lies by more than noise. "agrees" where the
  thesis's number is within root((t s sqrt(1 + 1/n))^2 + b^2) of ours in ln Gamma, which stands in
  brackets: s is the standard deviation pooled over all lines, b half the bracket. LP, CP: eq. 6.11
  with 0.55 and 0.64."""


def panels() -> list[Panel]:
    """The dampers of the table, with the points before their refinement."""
    return [
        panel(orientation, height, 5, [
            (frequency, gamma)
            for frequency in FREQUENCIES
            if close_onset(height, frequency) < GAMMAS[-1]
            for gamma in about(close_onset(height, frequency), _AROUND, _BEYOND)
        ])
        for height in HEIGHTS
        for orientation in ORIENTATIONS
    ]  # fmt: skip


run = run_of_panels(lambda: panels(), REFINE)


def published(height: int, orientation: str) -> dict[float, float | None]:
    """The thesis's optimum by frequency [Hz]; None where it is beyond its Gammas (">100")."""
    for row in shipped_rows("published", "damper_optimum_amplitude"):
        printed_height = round(1e3 * float(row["height_m"]))
        if (printed_height, row["approach"]) == (height, f"DEM-{orientation}"):
            printed = {f: row[f"f{f:g}Hz"] for f in FREQUENCIES}
            return {f: None if v.startswith(">") else float(v) for f, v in printed.items()}
    return dict.fromkeys(FREQUENCIES)


def optima(rows: Sequence[Row]) -> dict[Line, Optimum | None]:
    """The bouncing bed's optimum of each damper and frequency that there are rows of."""
    found: dict[Line, list[Row]] = {}
    for row in rows:
        line = (row["height_mm"], row["frequency_hz"], row["orientation"])
        found.setdefault(line, []).append(row)
    return {line: optimum(own, line[1], "bouncing_bed") for line, own in sorted(found.items())}


def report(rows: list[Row]) -> str:
    """Return what lacks, each line with the thesis's, the claims, the criterion."""
    found = optima(rows)
    judged = Table63.of(found)
    table = columns(
        ["height", "f [Hz]", "orientation", "thesis", "ours", "top", "bracket", "eta", "difference",
         "LP", "CP"],
        [_line(line, one, judged.pooled) for line, one in found.items()],
    )  # fmt: skip
    return paragraphs(
        completeness(rows, labels_of(panels()), SEEDS),
        table,
        _scatter(judged.pooled),
        report_claims(OPTIMA.judge(claims_of("damper_optimum"), judged)),
        _CRITERION,
    )


def _line(line: Line, found: Optimum | None, pooled: tuple[float, int] | None) -> list[str]:
    height, frequency, orientation = line
    theirs = published(height, orientation).get(frequency)
    head = [f"{height} mm", f"{frequency:g}", orientation, f"{theirs:g}" if theirs else "-"]
    if found is None:
        return [*head, "no peak", *["-"] * 6]
    low, high = found.mean.bracket
    return [
        *head,
        with_scatter(found),
        f"{found.top:.3g}",
        f"{low:.3g} to {high:.3g}",
        f"{found.mean.efficiency:.3f}",
        difference(found, theirs, pooled),
        *(_or_dash(found.predicted(name)) for name in ("loose", "close")),
    ]


def difference(found: Optimum, theirs: float | None, pooled: tuple[float, int] | None) -> str:
    """Return how far ours is from the thesis's, and whether that is within the scatter."""
    if theirs is None:
        return "-"
    off, allowed = math.log(found.gamma / theirs), found.allowance(pooled)
    word = "agrees" if abs(off) <= allowed else ("high" if off > 0 else "low")
    return f"{word} {signed(math.expm1(off))} (+- {100 * allowed:.0f} %)"


def _scatter(pooled: tuple[float, int] | None) -> str:
    if pooled is None:
        return "scatter over the packings: not known (one packing)"
    return f"scatter over the packings: {100 * pooled[0]:.1f} % ({pooled[1]} degrees of freedom)"


def _or_dash(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


_COLOURS = {"vertical": BLUE, "horizontal": ORANGE}
_SHIFT = {"vertical": -0.35, "horizontal": 0.35}  # mm, so that the two stand side by side
_LINES = {"loose": "--", "close": "-"}
_HEIGHT_LINES = {0: "-", 1: "--", 2: "-.", 3: ":"}

Optima = Mapping[Line, Optimum | None]


def draw(rows: list[Row]) -> "Figure":
    """Optimum against clearance at each frequency, with eq. 6.11; and eta against Gamma."""
    from matplotlib.figure import Figure

    found = optima(rows)
    frequencies = sorted({row["frequency_hz"] for row in rows})
    figure = Figure(figsize=(1.2 + 3.3 * len(frequencies), 7.2), layout="constrained")
    headline(figure, "Where the bouncing bed damps best")
    panels = figure.subplots(2, len(frequencies), squeeze=False)
    for k, frequency in enumerate(frequencies):
        here = {line: one for line, one in found.items() if line[1] == frequency}
        _draw_heights(panels[0, k], here, frequency)
        _draw_curves(panels[1, k], [r for r in rows if r["frequency_hz"] == frequency], here)
        panels[0, k].set_title(f"{frequency:g} Hz", loc="left", fontsize=10)
    panels[0, 0].set_ylabel("Γ at the optimum [-]")
    panels[1, 0].set_ylabel("efficiency [-]")
    for legends in panels:
        named = entries(legends)
        legends[-1].legend(named.values(), named.keys(), loc="upper left", bbox_to_anchor=(1, 1))
    return figure


def _draw_heights(axes: "Axes", here: Optima, frequency: float) -> None:
    for orientation, colour in _COLOURS.items():
        for (height, _, own), one in here.items():
            if own != orientation:
                continue
            at = height + _SHIFT[orientation]
            theirs = published(height, orientation).get(frequency)
            if theirs is not None:
                axes.plot(at, theirs, "D", color=VERMILION, ms=5, mfc="white", zorder=3,
                          label="thesis, DEM")  # fmt: skip
            if one is None:
                continue
            spread = np.abs(np.array(one.mean.bracket).reshape(2, 1) - one.gamma)
            axes.errorbar(at, one.gamma, spread, fmt="o", color=colour, ms=4.5, capsize=3,
                          label=f"ours, {orientation}\n(bars: bracket)")  # fmt: skip
    _draw_predicted(axes, here)
    axes.set_xlabel("height [mm]")
    axes.set_xticks(sorted({height for height, _, _ in here}))
    axes.margins(x=0.15)
    if len({height for height, _, _ in here}) == 1:
        axes.margins(x=2.0)  # else the two orientations stand at the ends
    axes.set_ylim(bottom=0)


def _draw_predicted(axes: "Axes", here: Optima) -> None:
    by_height = {height: one for (height, _, _), one in sorted(here.items()) if one is not None}
    for name, style in _LINES.items():
        gammas = [one.predicted(name) or np.nan for one in by_height.values()]
        axes.plot(list(by_height), gammas, style, marker="_", color=GREY, lw=1.2, zorder=1,
                  label=f"eq. 6.11, {name} packing")  # fmt: skip


def _draw_curves(axes: "Axes", rows: Sequence[Row], here: Optima) -> None:
    heights = sorted({height for height, _, _ in here})
    for height, frequency, orientation in here:
        own = [r for r in rows if (r["height_mm"], r["orientation"]) == (height, orientation)]
        result = MapResult.of(own)
        chosen = result.at(frequency)
        style = _HEIGHT_LINES[heights.index(height) % len(_HEIGHT_LINES)]
        axes.errorbar(
            result.gamma[chosen], result.efficiency[chosen],
            np.nan_to_num(result.half_width[chosen]), color=_COLOURS[orientation], ls=style,
            marker=".", ms=3, lw=1, elinewidth=0.6, label=f"{height} mm, {orientation}",
        )  # fmt: skip
    axes.axhline(0.3, color=INK, lw=0.6, zorder=0)
    axes.set(xscale="log", xlabel="Γ [-]", ylim=(0, None))
    gammas = sorted({row["gamma"] for row in rows})
    ticked(axes, (1, 2, 3, 5, 10, 20, 40, 70, 100), (gammas[0], gammas[-1]))
