"""Numbers that the thesis prints, and what their size does: fill, Rayleigh's step, yielding.

The fill of toroids (sec. 8.3) and the step (Table 6.1) need no run. Impacts beyond the yield
velocity (sec. 6.2.2) are where the map has its fastest: with constant restitution as in the thesis,
and with one that falls above the yield velocity, as sec. 5.5 has it.
"""

from functools import partial
from typing import TYPE_CHECKING, Any

from damper3d.reproduce.panels import SPHERES, completeness, point_cases, run_of_cases
from damper3d.reproduce.printed.quantities import (
    LAWS,
    POINT,
    PRINTED,
    change_by_yielding,
    fastest,
    points,
)
from damper3d.reproduce.quantities.curves import curve
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.claims.judge import report_claims
from granulab.campaign.output.figure import BLUE, ORANGE, headline, ruled
from granulab.campaign.output.layout import columns, paragraphs

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Row = dict[str, Any]

SEEDS = 3
COLUMNS = (
    "law", "orientation", "height_mm", "frequency_hz", "gamma", "efficiency",
    "efficiency_interval", "efficiency_wall_work", "peak_wall_force_n",
    "max_impact_over_yield_velocity.", "impacts_beyond_yield.", "phase", "energy_closure",
)  # fmt: skip
_READING = """\
impact: fastest between particles over their yield velocity (eq. 5.26, 3.5 m/s), of all packings,
  with constant restitution; beyond: part of their impacts above it. efficiency, force: with
  constant restitution and with one that falls above the yield velocity, and by how much they
  differ with the noise of the packings."""


def _settings(point: Row) -> Row:
    return {
        "motion.orientation": point["orientation"],
        "motion.frequency": point["frequency_hz"],
        "motion.gamma": point["gamma"],
        "enclosure.height": f"{point['height_mm']} mm",
        "particles.count": SPHERES[5],
        "law.yielding": LAWS[point["law"]],
        "output.keep": "summary",
    }


cases = partial(point_cases, points, _settings)
run = run_of_cases(lambda seeds: cases(seeds))


def report(rows: list[Row]) -> str:
    """Return what is there, the printed numbers judged, and a line a point."""
    return paragraphs(
        completeness(rows, points(), SEEDS),
        report_claims(PRINTED.judge(claims_of("damper_printed"), rows)),
        _table(rows),
        _READING,
    )


def _table(rows: list[Row]) -> str:
    efficiency, force = (
        {_point(one): one for one in change_by_yielding(rows, column)}
        for column in ("efficiency", "peak_wall_force_n")
    )
    lines = []
    for one in fastest(rows, "constant"):
        if (point := _point(one)) not in efficiency:
            continue  # one of the two laws lacks
        eta, newton = efficiency[point], force[point]
        lines.append([
            f"  {one['orientation']}", f"{one['height_mm']} mm", f"{one['frequency_hz']:g}",
            f"{one['gamma']:g}", f"{one['value']:.2f}", f"{100 * one['beyond']:.2g} %",
            f"{eta['constant']:.3f} {eta['yielding']:.3f}",
            f"{100 * eta['value']:+.1f} +- {100 * eta['noise']:.1f} %",
            f"{newton['constant']:.0f} {newton['yielding']:.0f} N",
            f"{100 * newton['value']:+.0f} +- {100 * newton['noise']:.0f} %",
        ])  # fmt: skip
    header = ["  motion", "height", "Hz", "Gamma", "impact", "beyond", "efficiency", "change",
              "force", "change"]  # fmt: skip
    return columns(header, lines) if lines else ""


def _point(one: Row) -> tuple[Any, ...]:
    return tuple(one[key] for key in POINT)


def draw(rows: list[Row]) -> "Figure":
    """Efficiency and largest force of both restitutions against the fastest impact."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.6, 4.0), layout="constrained")
    headline(figure, "Impacts beyond the yield velocity: constant restitution, and one that falls")
    impacts = {_point(one): one["value"] for one in fastest(rows, "constant")}
    placed = [row | {"impact": impact} for row in rows
              if (impact := impacts.get(_point(row))) is not None]  # fmt: skip
    for axes, column, label in zip(
        figure.subplots(1, 2), ("efficiency", "peak_wall_force_n"),
        ("efficiency", "largest force on the walls [N]"), strict=True,
    ):  # fmt: skip
        ruled(axes)
        for law, colour, marker in (("constant", BLUE, "o"), ("yielding", ORANGE, "s")):
            own = curve([row for row in placed if row["law"] == law], column, "impact")
            axes.errorbar(own.x, own.mean, own.sd, fmt=marker, ms=4, color=colour, elinewidth=0.8,
                          label=f"restitution {law}")  # fmt: skip
        axes.set(xlabel="fastest impact over yield velocity", ylabel=label)
        axes.set_ylim(bottom=0)
        if placed:
            axes.legend(fontsize=8)
    return figure
