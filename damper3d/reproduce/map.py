"""Figs 6.4 and 6.5: efficiency over frequency and Gamma for four fills in both orientations.

358 spheres of 5 mm at the thesis's nine frequencies and nineteen Gammas; one packing unless more
seeds are requested.
"""

import itertools
from typing import TYPE_CHECKING

from damper3d.measures.phases.criteria import PHASES
from damper3d.reproduce.panels import (
    HEIGHTS,
    ORIENTATIONS,
    PANEL_COLUMNS,
    Panel,
    Row,
    completeness,
    labels_of,
    panel,
    run_of_panels,
)
from damper3d.reproduce.quantities.maps import MAPS, Ridges, ridges_by_panel
from damper3d.studies.map.grid import FREQUENCIES, GAMMAS
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.claims.judge import report_claims
from granulab.campaign.output.layout import columns, paragraphs

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEEDS = 1
COLUMNS = (*PANEL_COLUMNS, "efficiency_wall_work", "phase")

_WALL_WORK = "efficiency_wall_work"

_CRITERION = """\
A ridge has the highest peak of eta along Gamma within a factor of two of Gamma 3 (fluidisation) or
of eq. 6.11 for the close packing (bouncing bed), whichever is nearer; a peak stands out of the
noise by its prominence (docs/damper-map.md). In brackets the Gammas that it lies between. The last
column has the best eta from the work of the walls: the rest of what is dissipated there the bed
gives itself, which packs down while it is shaken."""


def panels() -> list[Panel]:
    """The eight maps."""
    points = list(itertools.product(FREQUENCIES, GAMMAS))
    return [panel(o, height, 5, points) for o in ORIENTATIONS for height in HEIGHTS]


run = run_of_panels(panels)


def report(rows: list[Row]) -> str:
    """Return what lacks, the ridges of each map, the claims, the shares of the phases."""
    found = ridges_by_panel(rows)
    table = columns(
        ["orientation", "height", "f [Hz]", "fluidisation", "eta", "bouncing bed", "eta", "CP",
         "best Gamma", "eta", "of walls"],
        [line for key, one in found.items() for line in _lines(key, one)],
    )  # fmt: skip
    return paragraphs(
        completeness(rows, labels_of(panels()), SEEDS),
        table,
        report_claims(MAPS.judge(claims_of("damper_map"), found)),
        _phases(found),
        _CRITERION,
    )


def _lines(key: tuple[str, int], one: Ridges) -> list[list[str]]:
    lines = []
    for frequency in one.frequencies:
        eta = one.result.efficiency[one.result.at(frequency)]
        gamma = one.result.gamma[one.result.at(frequency)]
        onset = one.prediction.best.onset(frequency)
        best = [f"{gamma[eta.argmax()]:g}", f"{eta.max():.3f}", _by_the_walls(one, frequency)]
        lines.append(
            [
                key[0],
                f"{key[1]} mm",
                f"{frequency:g}",
                *_peak(one, frequency, "fluidisation"),
                *_peak(one, frequency, "bouncing_bed"),
                "-" if onset is None else f"{onset:.3g}",
                *best,
            ]
        )
    return lines


def _by_the_walls(one: Ridges, frequency: float) -> str:
    """The best eta of a frequency, from the work of the walls instead of what is dissipated."""
    at = one.result.at(frequency)
    best = at[one.result.efficiency[at].argmax()]
    known = _WALL_WORK in one.result.columns
    return f"{one.result.mean(_WALL_WORK)[best]:.3f}" if known else "-"


def _peak(one: Ridges, frequency: float, ridge: str) -> list[str]:
    peak = one.peak(frequency, ridge)
    if peak is None:
        return ["-", "-"]
    low, high = peak.bracket
    return [f"{peak.gamma:.3g} [{low:g}, {high:g}]", f"{peak.efficiency:.3f}"]


def _phases(found: dict[tuple[str, int], Ridges]) -> str:
    """Return how many points of each map show which phase (thesis, Figs 6.2 and 6.3)."""
    lines = []
    for (orientation, height), one in found.items():
        names = [phase for phase in one.result.phases if phase]
        counts = [
            f"{look.label} {names.count(name)}"
            for name, look in PHASES[orientation].items()
            if name in names
        ]
        lines.append(f"  {orientation}, {height} mm: {', '.join(counts) or 'none named'}")
    return "\n".join(["points of each phase:", *lines]) if lines else ""


def draw(rows: list[Row]) -> "Figure":
    """A contour panel for each map, with onset lines, phases and peaks."""
    from damper3d.reproduce.figures.maps import draw_panels

    return draw_panels(ridges_by_panel(rows))
