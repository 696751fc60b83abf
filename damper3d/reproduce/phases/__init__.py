"""Figs 2.12, 6.2 and 6.3: the phases over frequency and Gamma, and what the thesis says of them.

358 spheres of 5 mm at the thesis's points, below Gamma 1, after 50 cycles and without gravity.
Names are those of docs/damper/phases.md; where the text has two readings, both are judged.
"""

from typing import TYPE_CHECKING, Any

from damper3d.measures.phases.criteria import RULES, criteria_of
from damper3d.reproduce.panels import completeness, labels_of, run_of_panels
from damper3d.reproduce.phases.optima import optimum
from damper3d.reproduce.phases.points import panels
from damper3d.reproduce.phases.quantities import (
    PHASE_MAPS,
    counts,
    kept_names,
    label,
    leidenfrost_medians,
)
from damper3d.reproduce.phases.readings import READINGS, Points, points_of
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.claims.judge import report_claims
from granulab.campaign.output.layout import columns, paragraphs

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Row = dict[str, Any]

SEEDS = 1
_DESCRIBE = "deep_carried_share", "fluidised_share", "convecting_share", "low_density"
COLUMNS = (
    "orientation", "height_mm", "cycles", "frequency_hz", "gamma", "efficiency",
    "efficiency_wall_work", "phase",
    *sorted({f"phase_measures.{criterion.measure}" for o in RULES for criterion in criteria_of(o)}
            | {f"phase_measures.{name}" for name in _DESCRIBE}),
)  # fmt: skip
_SUSPENDED = "low_density", "hot_low", "stroke", "circulation"
_READING = """\
maps: points from Gamma 1 to 100. cycles: 8, of which 3 do not count, are the thesis's; of 60, 50 do
not. optimum: the largest efficiency up to Gamma 6, from 40 Hz on. Readings of the border of partial
fluidisation (docs/damper/phases.md): most rest, most particles do not move against neighbours;
a tenth rests; deep layers carried, most of the deepest fifth move with the enclosure; more return,
of those that move. low_density: solid volume of the lowest diameter over that of the fullest."""

run = run_of_panels(panels)


def report(rows: list[Row]) -> str:
    """Return what is there, the names of each map, the optima by each reading, and the claims."""
    points = points_of(rows)
    return paragraphs(
        completeness(rows, labels_of(panels()), SEEDS),
        _names(points),
        _optima(points),
        _suspended(points),
        _changes(points),
        report_claims(PHASE_MAPS.judge(claims_of("damper_phases"), points)),
        _READING,
    )


def _names(points: Points) -> str:
    """Numbers of points that each map has of each name, below Gamma 1 and from 1 on."""
    found: dict[str, list[str]] = {}
    for least, most, where in ((0.0, 0.99, "below Gamma 1"), (1.0, 100.0, "from Gamma 1 on")):
        for item in counts(points, least=least, most=most):
            if item["value"]:
                key = f"  {item['orientation']}, {item['height_mm']} mm, {item['cycles']} cycles"
                words = f"{item['label']} {item['value']}"
                found.setdefault(f"{key}, {where}", []).append(words)
    lines = [f"{key}: {', '.join(words)}" for key, words in found.items()]
    return "\n".join(["points of each phase:", *lines]) if lines else ""


def _optima(points: Points) -> str:
    """The optimum of fluidisation at each frequency, and its name by each reading."""
    by = {reading: optimum(points, reading=reading) for reading in READINGS}
    lines = [
        [f"  {ours['orientation']}", f"{ours['height_mm']} mm", f"{ours['cycles']}",
         f"{ours['frequency_hz']:g}", f"{ours['gamma']:g}", f"{ours['fluidised']:.2f}",
         f"{ours['travelling']:.2f}", *(item["is"] for item in items)]
        for items in zip(*by.values(), strict=True)
        for ours in items[:1]
        if ours["orientation"] == "horizontal"
    ]  # fmt: skip
    header = ["  optimum", "height", "cycles", "Hz", "Gamma", "fluidised", "travelling", *READINGS]
    return columns(header, lines) if lines else ""


def _suspended(points: Points) -> str:
    """Medians of measures of the Leidenfrost points, by where they are to the thesis's band."""
    lines = [
        [f"  {one['part']} Gamma 12 to 80", f"{one['cycles']}", f"{one['number']}",
         *(f"{one[name]:.2f}" for name in _SUSPENDED)]
        for one in leidenfrost_medians(points, _SUSPENDED)
    ]  # fmt: skip
    header = ["  Leidenfrost effect", "cycles", "points", *_SUSPENDED]
    return columns(header, lines) if lines else ""


def _changes(points: Points) -> str:
    """The points whose name after 50 cycles is another."""
    both = kept_names(points)
    lines = [
        [f"  {one['orientation']}", f"{one['frequency_hz']:g}", f"{one['gamma']:g}",
         label(one["short"]), label(one["long"])]
        for one in both
        if one["short"] != one["long"]
    ]  # fmt: skip
    if not both:
        return ""
    head = f"after 50 cycles {len(both) - len(lines)} of {len(both)} points keep their name"
    table = columns(["  motion", "Hz", "Gamma", "8 cycles", "60 cycles"], lines) if lines else ""
    return "\n".join([head, table])


def draw(rows: list[Row]) -> "Figure":
    """Phase maps of each orientation, height and number of cycles; shares about the optimum."""
    from damper3d.reproduce.phases.charts import phase_charts

    return phase_charts(rows)
