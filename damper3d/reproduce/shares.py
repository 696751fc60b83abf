"""Shares of the dissipated energy: particle-particle contacts, friction (Figs 6.28, 6.29).

Vertical motion at 40 and 160 Hz, fill ratio 0.466, spheres of 3 to 6 mm, over the thesis's Gammas.
Each share is given twice: of what our budget finds dissipated, and of the thesis's count (eq. 6.7),
in which friction is the whole force mu Fn times the sliding velocity, so that it is more.
"""

from functools import partial
from typing import TYPE_CHECKING, Any

from damper3d.reproduce.panels import SPHERES, completeness, point_cases, run_of_cases
from damper3d.reproduce.quantities.curves import curve
from damper3d.reproduce.quantities.shares import (
    COUNTS,
    SHARES,
    Landmarks,
    Readings,
    landmarks,
    of_size,
    quantities,
    tangential_damping,
)
from damper3d.studies.map.grid import GAMMAS
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.claims.judge import report_claims
from granulab.campaign.output.figure import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    VERMILION,
    headline,
    ruled,
    ticked,
)
from granulab.campaign.output.layout import columns, done, paragraphs

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Row = dict[str, Any]

SEEDS = 3
COLUMNS = (
    "diameter_mm", "frequency_hz", "gamma", "efficiency", "efficiency_interval", "shares.",
    "shares_contact_count.",
)  # fmt: skip

SIZES = (5, 4, 6, 3)  # [mm], dearest last
FREQUENCIES = (40.0, 160.0)  # [Hz]
_LABELS = "diameter_mm", "frequency_hz", "gamma"

_READING = """\
budget: share of what normal damping, tangential damping and friction dissipate together, friction
  being the work at the slider alone. thesis's count: the two terms of eq. 6.7, friction being the
  whole tangential one: mu Fn times the whole sliding velocity, the dashpot where nothing slides.
onset and optimum: peaks of eta along Gamma of the same runs, as `damper3d map` finds them, beyond
  noise; the thesis took them from Figs 6.8 and 6.22."""


def points() -> list[Row]:
    """The labels of each point of the table."""
    return [
        dict(zip(_LABELS, (diameter, frequency, gamma), strict=True))
        for diameter in SIZES
        for frequency in FREQUENCIES
        for gamma in GAMMAS
    ]


def _settings(point: Row) -> Row:
    return {
        "particles.shape": f"sphere:{point['diameter_mm']}mm",
        "particles.count": SPHERES[point["diameter_mm"]],
        "motion.frequency": point["frequency_hz"],
        "motion.gamma": point["gamma"],
        "output.keep": "summary",
    }


cases = partial(point_cases, points, _settings)
run = run_of_cases(lambda seeds: cases(seeds))


def report(rows: list[Row]) -> str:
    """Return what is there, the claims of sec. 6.5 judged, and the shares in figures."""
    found = landmarks(rows)
    return paragraphs(
        completeness(rows, points(), SEEDS),
        report_claims(SHARES.judge(claims_of("damper_shares"), Readings(rows, found))),
        *(_table(rows, found, frequency) for frequency in FREQUENCIES),
        tangential_damping(rows),
        _without_count(rows),
        _READING,
    )


def _table(rows: list[Row], found: Landmarks, frequency: float) -> str:
    """A line a Gamma: for each size the three shares, budget then the thesis's count."""
    sizes = [size for size in sorted(SIZES) if of_size(rows, size, frequency)]
    if not sizes:
        return ""
    curves = {
        (size, quantity, count): curve(of_size(rows, size, frequency), quantities(count)[quantity])
        for size in sizes
        for count in COUNTS
        for quantity in quantities(count)
    }
    lines = []
    for gamma in sorted({x for one in curves.values() for x in one.x}):
        cells = []
        for size in sizes:
            for quantity in quantities("budget"):
                values = [curves[size, quantity, count].between(gamma, gamma) for count in COUNTS]
                words = [f"{100 * one.mean[0]:.0f}" if one.mean else "-" for one in values]
                cells.append(" / ".join(words))
        lines.append([f"  {gamma:g}", *cells])
    header = ["  Gamma", *(f"{size} mm: {q}" for size in sizes for q in ("p-p", "fr", "fr p-p"))]
    title = f"{frequency:g} Hz, shares in %, budget / thesis's count ({found.words(frequency)})"
    return f"{title}\n{columns(header, lines)}"


def _without_count(rows: list[Row]) -> str:
    """Return how many runs do not know the thesis's shares."""
    column = "shares_contact_count.particle_particle.friction"
    old = sum(row.get("shares.particle_particle.friction") is not None and row.get(column) is None
              for row in done(rows))  # fmt: skip
    if not old:
        return ""
    return (
        f"{old} of {len(done(rows))} runs were made before the shares of the thesis's count were "
        "kept; delete their folders and the same command makes them again"
    )


_COLOURS = {3: BLUE, 4: GREEN, 5: VERMILION, 6: ORANGE}
_STYLES: dict[str, dict[str, Any]] = {
    "budget": {"ls": "-", "marker": "o", "ms": 3},
    "thesis's count": {"ls": (0, (2, 1.5)), "lw": 0.9},
}
_LINES_OF = 5  # mm: the size whose peaks are drawn, as in the thesis's Fig. 6.8
_WORDS = {"fluidisation": "fluidisation\noptimum", "bouncing bed": "bouncing-bed\nonset"}


def draw(rows: list[Row]) -> "Figure":
    """As Figs 6.28 and 6.29: a row a share, a column a frequency; bars are standard deviations."""
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    marks = landmarks(rows)
    figure = Figure(figsize=(9.6, 9.2), layout="constrained")
    headline(figure, "Shares of what is dissipated: vertical, fill ratio 0.466")
    names = list(quantities("budget"))
    panels = figure.subplots(len(names), len(FREQUENCIES), sharex=True, sharey=True, squeeze=False)
    for number, (axes_row, quantity) in enumerate(zip(panels, names, strict=True)):
        for axes, frequency in zip(axes_row, FREQUENCIES, strict=True):
            _panel(axes, rows, quantity, frequency)
            _landmarks(axes, marks, frequency, named=number == 0)
        axes_row[0].set_ylabel(f"{quantity} share [%]")
    for axes, frequency in zip(panels[0], FREQUENCIES, strict=True):
        axes.set_title(f"{frequency:g} Hz", loc="left", fontsize=10, pad=24)
    for axes in panels[-1]:
        axes.set_xlabel("\u0393")
    lines = [Line2D([], [], color=c, marker="o", ms=3) for c in _COLOURS.values()]
    lines += [Line2D([], [], color=INK, **_STYLES[count]) for count in COUNTS]
    words = [f"{size} mm" for size in _COLOURS] + list(COUNTS)
    figure.legend(lines, words, loc="outside lower center", ncols=len(words))
    return figure


def _panel(axes: "Axes", rows: list[dict[str, Any]], quantity: str, frequency: float) -> None:
    ruled(axes)
    for size, colour in _COLOURS.items():
        for count in COUNTS:
            own = curve(of_size(rows, size, frequency), quantities(count)[quantity])
            if own.x:
                shares = [100 * share for share in own.mean]
                bars = [100 * sd for sd in own.sd] if count == "budget" else None
                axes.errorbar(own.x, shares, bars, color=colour, elinewidth=0.8, **_STYLES[count])
    axes.set_xscale("log")
    ticked(axes, (1, 2, 3, 5, 10, 20, 40, 100))
    axes.set_ylim(0, 100)


def _landmarks(axes: "Axes", marks: Landmarks, frequency: float, named: bool) -> None:
    """The peaks of eta of 5 mm spheres, where these runs have them."""
    for name, gamma in marks.of(_LINES_OF, frequency).items():
        axes.axvline(gamma, color=GREY, lw=0.9, ls=(0, (5, 3)), zorder=0)
        if named:
            axes.annotate(
                _WORDS[name], (gamma, 1), (0, 2), xycoords=("data", "axes fraction"),
                textcoords="offset points", ha="center", va="bottom", fontsize=7.5, color=GREY,
            )  # fmt: skip
