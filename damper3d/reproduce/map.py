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
    labels_of,
    panel,
)
from damper3d.reproduce.panels.counts import (
    DRAWN,
    STEADY,
    STEADY_ETA,
    WALL_WORK,
    by_count,
    judged_by_count,
    run_of_maps,
    standing,
    there,
)
from damper3d.reproduce.quantities.maps import MAPS, Maps, Ridges
from damper3d.studies.map.grid import FREQUENCIES, GAMMAS
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.claims.judge import report_claims
from granulab.campaign.output.layout import columns, paragraphs

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEEDS = 1
COLUMNS = (*PANEL_COLUMNS, WALL_WORK, "phase", STEADY)

_CRITERION = """\
A ridge has the highest peak of eta along Gamma within a factor of two of Gamma 3 (fluidisation) or
of eq. 6.11 for the close packing (bouncing bed), whichever is nearer; a peak stands out of the
noise by its prominence (docs/damper/map.md). In brackets the Gammas that it lies between. The last
columns have the work of the walls at the best eta, where the rest of what is dissipated the bed
gives itself, which packs down while it is shaken; and the same of a bed shaken on until its cycles
are alike. Counts: dissipated in five cycles (the thesis's), which is that of the table and of the
claims above; work of the walls in these; of the walls once the cycles are alike (steady), and what
is dissipated in five cycles at the same points (dissipated there)."""


def panels() -> list[Panel]:
    """The eight maps."""
    points = list(itertools.product(FREQUENCIES, GAMMAS))
    return [panel(o, height, 5, points) for o in ORIENTATIONS for height in HEIGHTS]


run = run_of_maps(panels)


def report(rows: list[Row]) -> str:
    """Return what lacks, the ridges of each map, the claims by each count, shares of the phases."""
    maps = by_count(rows)
    found = maps.get("dissipated", {})
    table = columns(
        ["orientation", "height", "f [Hz]", "fluidisation", "eta", "bouncing bed", "eta", "CP",
         "best Gamma", "eta", "of walls", "steady"],
        [line for key, one in found.items() for line in _lines(key, one)],
    )  # fmt: skip
    claims = claims_of("damper_map")
    return paragraphs(
        standing(rows, labels_of(panels()), SEEDS),
        table,
        report_claims(MAPS.judge(claims, found)),
        judged_by_count(claims, maps),
        _overestimates(found),
        _phases(found),
        _CRITERION,
    )


def _overestimates(found: Maps) -> str:
    """Sec. 8.5.2 as a consequence of what is counted; "" where no run has the walls' work."""
    if not any(WALL_WORK in one.result.columns for one in found.values()):
        return ""
    verdicts = MAPS.judge(claims_of("damper_overestimate"), found)
    return f"what is dissipated over the other counts, {report_claims(verdicts)}"


def _lines(key: tuple[str, int], one: Ridges) -> list[list[str]]:
    lines = []
    for frequency in one.frequencies:
        at = one.result.at(frequency)
        best = int(at[one.result.efficiency[at].argmax()])
        onset = one.prediction.best.onset(frequency)
        lines.append(
            [
                key[0],
                f"{key[1]} mm",
                f"{frequency:g}",
                *_peak(one, frequency, "fluidisation"),
                *_peak(one, frequency, "bouncing_bed"),
                "-" if onset is None else f"{onset:.3g}",
                f"{one.result.gamma[best]:g}",
                *(there(one, name, best) for name in ("efficiency", WALL_WORK, STEADY_ETA)),
            ]
        )
    return lines


def _peak(one: Ridges, frequency: float, ridge: str) -> list[str]:
    peak = one.peak(frequency, ridge)
    if peak is None:
        return ["-", "-"]
    low, high = peak.bracket
    return [f"{peak.gamma:.3g} [{low:g}, {high:g}]", f"{peak.efficiency:.3f}"]


def _phases(found: Maps) -> str:
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
    """A contour panel for each map and count, with onset lines, phases and peaks."""
    from damper3d.reproduce.figures.maps import draw_panels

    maps = by_count(rows)
    return draw_panels({words: maps[name] for name, words in DRAWN.items() if name in maps})
