"""Dependence of the efficiency on density, modulus, restitution, friction (Fig. 6.13).

Vertical motion at 20 Hz, 358 spheres of 5 mm, fill ratio 0.466, one property changed at a time.
The values are those of the module properties.
"""

from functools import partial
from typing import TYPE_CHECKING, Any

from damper3d.reproduce.panels import completeness, point_cases, run_of_cases
from damper3d.reproduce.quantities.curves import curve
from damper3d.reproduce.quantities.properties import (
    FREQUENCY,
    STANDARD,
    VALUES,
    change,
    in_words,
    points,
)
from damper3d.reproduce.quantities.sensitivity import SENSITIVITY, Peaks, peaks_of
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.claims.judge import report_claims
from granulab.campaign.output.figure import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PURPLE,
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
    "property", "value", "gamma", "frequency_hz", "efficiency", "efficiency_interval",
    "energy_closure", "max_impact_over_yield_velocity.",
)  # fmt: skip

_READING = """\
Values are our choice, the thesis prints none. optimum: highest peak of eta along Gamma, from the
  parabola through the points about it, with the interval that the noise leaves.
It moves where that interval and the standard's have no point in common. bouncing bed: mean eta over
  the Gammas above the optimum of every value, the same for all; a trend is the least-squares slope
  of that mean, a run a point, over the logarithm of density and modulus, and over restitution and
  friction themselves, from the least value to the largest, with its 95 % interval.
Density and modulus enter as E/rho alone (forces grow with E, masses with rho, the walls have none):
  twice the density is half the modulus."""


def _settings(point: Row) -> Row:
    return {
        "motion.frequency": FREQUENCY,
        "motion.gamma": point["gamma"],
        "output.keep": "summary",
        **change(point["property"], point["value"]),
    }


cases = partial(point_cases, points, _settings)
run = run_of_cases(lambda seeds: cases(seeds))


def report(rows: list[Row]) -> str:
    """Return what is there, the claims judged, and a line a value with its optimum."""
    found = peaks_of(rows)
    return paragraphs(
        completeness(rows, points(), SEEDS),
        report_claims(SENSITIVITY.judge(claims_of("damper_sensitivity"), found)),
        _table(found),
        _READING,
        _ended(rows),
    )


def _table(found: Peaks) -> str:
    lines = []
    for (name, value), own in found.items():
        optimum = (
            f"{own.peak.gamma:.2f} [{own.peak.low:.2f}, {own.peak.high:.2f}]" if own.peak else "-"
        )
        eta = f"{own.peak.efficiency:.3f}" if own.peak else "-"
        mean = own.level()
        level = "-" if mean is None else f"{mean:.3f}"
        lines.append([f"  {name}", in_words(name, value), optimum, eta, level])
    header = ["  property", "value", "optimum Gamma", "eta there", "bouncing bed"]
    return columns(header, lines) if lines else ""


def _ended(rows: list[Row]) -> str:
    """Return how well the law holds where it was strained most."""
    ratios = [
        (ratio, row)
        for row in done(rows)
        for pair in ("particle_particle", "particle_wall")
        if (ratio := row.get(f"max_impact_over_yield_velocity.{pair}")) is not None
    ]
    closed = [abs(c) for row in done(rows) if (c := row.get("energy_closure")) is not None]
    if not ratios or not closed:
        return ""
    ratio, row = max(ratios, key=lambda pair: pair[0])
    return (
        f"largest impact over yield velocity: {ratio:.2g} ({row['property']} "
        f"{in_words(row['property'], row['value'])}, Gamma {row['gamma']:g}); largest unaccounted "
        f"energy: {100 * max(closed):.2g} % of what is dissipated"
    )


_COLOURS = [BLUE, GREEN, ORANGE, PURPLE]
_TITLES = {
    "density": "density of the particles",
    "modulus": "elastic modulus",
    "restitution": "coefficient of restitution",
    "friction": "coefficient of friction",
}


def draw(rows: list[Row]) -> "Figure":
    """Four panels as in Fig. 6.13: eta against Gamma, a line a value."""
    from matplotlib.figure import Figure

    found = peaks_of(rows)
    figure = Figure(figsize=(10.2, 7.4), layout="constrained")
    headline(figure, "Sensitivity: 358 spheres of 5 mm, fill ratio 0.466, 20 Hz vertical")
    panels = figure.subplots(2, 2, sharex=True, sharey=True)
    for axes, name in zip(panels.flat, VALUES, strict=True):
        _panel(axes, found, name)
    panels[0, 0].annotate(
        "marks: optima with their intervals", (0.99, 0.99), xycoords="axes fraction",
        ha="right", va="top", fontsize=7.5, color=GREY,
    )  # fmt: skip
    for axes in panels[:, 0]:
        axes.set_ylabel("efficiency")
    for axes in panels[-1]:
        axes.set_xlabel("\u0393")
    return figure


def _panel(axes: "Axes", found: Peaks, name: str) -> None:
    ruled(axes)
    values = sorted([*VALUES[name], STANDARD[name]])
    colours = iter(_COLOURS)
    for height, value in enumerate(values):
        standard = value == STANDARD[name]
        key = ("standard", 1.0) if standard else (name, value)
        colour = INK if standard else next(colours)
        if key not in found:
            continue
        own = curve(found[key].rows, "efficiency")
        label = in_words(name, value) + (" (standard)" if standard else "")
        axes.errorbar(own.x, own.mean, own.sd, fmt="o-", ms=3, color=colour, elinewidth=0.8,
                      label=label)  # fmt: skip
        if (peak := found[key].peak) is not None:
            y = 1.07 - 0.025 * height
            axes.plot([peak.low, peak.high], [y, y], color=colour, lw=1)
            axes.plot([peak.gamma], [y], "|", color=colour, ms=7, mew=1.6)
    axes.set_xscale("log")
    ticked(axes, (1, 2, 3, 5, 10, 20, 40))
    axes.set_ylim(0, 1.1)
    axes.set_title(_TITLES[name], loc="left", fontsize=10)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper left", fontsize=8)
