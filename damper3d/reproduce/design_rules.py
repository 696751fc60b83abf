"""Design rules I to III and the shape rule (secs 9.2 and 9.3), judged by computation.

The thesis's bed unless the label says otherwise; every run goes on until it is steady, as a damper
in service is, so that a bed that packs down does not count.
"""

from functools import partial
from typing import TYPE_CHECKING, Any

from damper3d.reproduce.panels import completeness, point_cases, run_of_cases
from damper3d.reproduce.quantities.curves import curve
from damper3d.reproduce.quantities.rules import (
    RULES,
    VARIANTS,
    Found,
    found_in,
    points,
    slenderness,
)
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.claims.judge import report_claims
from granulab.campaign.output.figure import (
    BLUE,
    GREEN,
    INK,
    ORANGE,
    PURPLE,
    VERMILION,
    headline,
    ruled,
    ticked,
)
from granulab.campaign.output.layout import columns, paragraphs

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Row = dict[str, Any]

SEEDS = 3
COLUMNS = (
    "variant", "frequency_hz", "gamma", "efficiency", "efficiency_interval", "efficiency_wall_work",
    "steady", "phase", "energy_closure",
)  # fmt: skip
_READING = """\
optimum: highest peak of eta along Gamma, with the interval that the noise leaves; it is shifted
  where the intervals have no point in common. Runs are steady ones, of at most 60 cycles."""


def _settings(point: Row) -> Row:
    return {
        "motion.frequency": point["frequency_hz"],
        "motion.gamma": point["gamma"],
        "run.steady": True,
        "output.keep": "summary",
        **VARIANTS[point["variant"]].changes,
    }


cases = partial(point_cases, points, _settings)
run = run_of_cases(lambda seeds: cases(seeds))


def report(rows: list[Row]) -> str:
    """Return what is there, the rules judged, and a line a variant with its optimum."""
    found = found_in(rows)
    return paragraphs(
        completeness(rows, points(), SEEDS),
        report_claims(RULES.judge(claims_of("damper_design_rules"), found)),
        _table(found),
        _READING,
    )


def _table(found: Found) -> str:
    lines = []
    for (name, frequency), own in found.items():
        optimum = (
            f"{own.peak.gamma:.2f} [{own.peak.low:.2f}, {own.peak.high:.2f}]" if own.peak else "-"
        )
        eta = f"{own.peak.efficiency:.3f}" if own.peak else "-"
        lines.append([f"  {name}", f"{frequency:g} Hz", optimum, eta, own.phase or "-"])
    header = ["  variant", "frequency", "optimum Gamma", "eta there", "phase there"]
    return columns(header, lines) if lines else ""


_DEPTH = 80.0  # [Hz] at which depth is swept, from flat to deep:
_DEEPER = ("50 mm wide", "vertical", "34 mm wide", "narrow", "24 mm wide")
# Title of a panel: its variants, and the frequency where only one is shown.
_PANELS: dict[str, tuple[tuple[str, ...], float | None]] = {
    "I: clearance": (("45 mm", "50 mm", "55 mm", "denser", "no gravity"), None),
    "II: frequency, vertical": (("vertical",), None),
    "II: frequency, horizontal": (("horizontal",), None),
    "9.3: shape": (("round", "oblate"), None),
    "II: depth at equal volume, 80 Hz": (_DEEPER, _DEPTH),
}
_COLOURS = (INK, BLUE, GREEN, ORANGE, PURPLE, VERMILION)


def draw(rows: list[Row]) -> "Figure":
    """Eta against Gamma, a panel for each rule; and the optimum against the depth of the bed."""
    from matplotlib.figure import Figure

    found = found_in(rows)
    figure = Figure(figsize=(13.4, 7.4), layout="constrained")
    headline(figure, "Design rules (thesis, secs 9.2 and 9.3): efficiency of steady beds")
    *panels, last = figure.subplots(2, 3).flat
    for axes, (title, (names, only)) in zip(panels, _PANELS.items(), strict=True):
        ruled(axes)
        keys = [(name, at) for name in names for own, at in found
                if own == name and only in (None, at)]  # fmt: skip
        for colour, key in zip(_COLOURS, keys, strict=False):
            own = curve(found[key].rows, "efficiency")
            axes.errorbar(own.x, own.mean, own.sd, fmt="o-", ms=3, color=colour, elinewidth=0.8,
                          label=_label(key, only))  # fmt: skip
        axes.set(xscale="log", ylim=(0, 1.1), xlabel="\u0393", ylabel="efficiency")
        ticked(axes, (1, 2, 3, 5, 10, 20, 30, 50, 100), axes.get_xlim())
        axes.set_title(title, loc="left", fontsize=10)
        if keys:
            axes.legend(fontsize=7.5)
    _draw_depth(last, found)
    return figure


def _label(key: tuple[str, float], only: float | None) -> str:
    """The variant and the frequency; where that is the same for all, how wide the bed is."""
    name, frequency = key
    return f"{name}, {frequency:g} Hz" if only is None else f"{VARIANTS[name].width:g} mm wide"


def _draw_depth(axes: "Axes", found: Found) -> None:
    """Gamma of the optimum with its interval against height over width."""
    ruled(axes)
    for name in _DEEPER:
        own = found.get((name, _DEPTH))
        if own is not None and (peak := own.peak) is not None:
            ends = [[peak.gamma - peak.low], [peak.high - peak.gamma]]
            axes.errorbar(slenderness(name), peak.gamma, ends, fmt="o", color=INK,
                          ms=4, elinewidth=0.9)  # fmt: skip
    axes.set(xscale="log", ylim=(0, 4), xlabel="height over width", ylabel="optimum \u0393")
    ticked(axes, (0.5, 1, 2, 5), axes.get_xlim())
    axes.set_title("II: depth and optimum, 80 Hz", loc="left", fontsize=10)
