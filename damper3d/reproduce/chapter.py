"""Chapter 6 whole: the maps of four sizes, four fills and two orientations (Table 6.1).

The thesis shows some of them (Figs 6.4, 6.5, 6.12, 6.22 and 6.26) and says that the others are
alike; here all are computed, at its nine frequencies and nineteen Gammas, one packing each.
"""

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from damper3d.reproduce.panels import (
    HEIGHTS,
    ORIENTATIONS,
    PANEL_COLUMNS,
    SPHERES,
    Panel,
    Row,
    labels_of,
    panel,
)
from damper3d.reproduce.panels.counts import (
    DRAWN,
    STEADY,
    WALL_WORK,
    by_count,
    judged_by_count,
    run_of_maps,
    standing,
    there,
)
from damper3d.reproduce.quantities.maps import (
    MAPS,
    Maps,
    Ridges,
    exponent,
    geometric_mean,
    likeness,
)
from damper3d.studies.map.grid import FREQUENCIES, GAMMAS
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.claims.judge import report_claims
from granulab.campaign.output.layout import columns, paragraphs

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEEDS = 1
COLUMNS = (*PANEL_COLUMNS, WALL_WORK, STEADY)

_STANDARD = 5  # mm, that the others are compared with
_CRITERION = """\
fluidisation, bouncing bed: of the peaks of each ridge that can be seen (docs/damper/map.md), the
geometric mean of Gamma and the exponent of f, and the range of eta. against 5 mm: over the points
that both have, correlation of eta and root-mean-square difference."""


def panels() -> list[Panel]:
    """The 32 maps, the dearest last."""
    points = list(itertools.product(FREQUENCIES, GAMMAS))
    sizes = sorted(SPHERES, reverse=True)
    return [panel(o, h, size, points) for size in sizes for o in ORIENTATIONS for h in HEIGHTS]


run = run_of_maps(panels)


def by_size(rows: Sequence[Row]) -> dict[int, dict[str, Maps]]:
    """The maps of each diameter [mm] that has one, by count, then by orientation and height."""
    sizes = sorted({row["diameter_mm"] for row in rows})
    found = {size: by_count([row for row in rows if row["diameter_mm"] == size]) for size in sizes}
    return {size: maps for size, maps in found.items() if maps}


def report(rows: list[Row]) -> str:
    """Return what lacks, a line for each map, and the claims about the maps of each size."""
    sizes = by_size(rows)
    found = {size: maps["dissipated"] for size, maps in sizes.items()}
    table = columns(
        ["size", "orientation", "height", "best eta", "of walls", "at f [Hz]", "Gamma",
         "fluidisation", "f^", "eta", "bouncing bed", "f^", "eta", "against 5 mm", "rms"],
        [_line(size, key, found) for size, maps in found.items() for key in maps],
    )  # fmt: skip
    claims = claims_of("damper_map")
    judged = [
        f"spheres of {size} mm, {text}"
        for size, maps in sizes.items()
        for text in (
            report_claims(MAPS.judge(claims, maps["dissipated"])),
            judged_by_count(claims, maps),
        )
        if text
    ]
    return paragraphs(
        standing(rows, labels_of(panels()), SEEDS),
        table,
        *judged,
        _CRITERION,
    )


def _line(size: int, key: tuple[str, int], found: dict[int, Maps]) -> list[str]:
    one, (orientation, height) = found[size][key], key
    eta = one.result.efficiency
    best = int(np.nanargmax(eta))
    return [
        f"{size} mm",
        orientation,
        f"{height} mm",
        f"{eta[best]:.3f}",
        there(one, WALL_WORK, best),
        f"{one.result.frequency[best]:g}",
        f"{one.result.gamma[best]:g}",
        *_ridge(one, "fluidisation"),
        *_ridge(one, "bouncing_bed"),
        *_compared(one, found.get(_STANDARD, {}).get(key), size),
    ]


def _ridge(one: Ridges, ridge: str) -> list[str]:
    points = one.along(ridge)
    if not points:
        return ["-", "-", "-"]
    gammas = [peak.gamma for _, peak in points]
    etas = [peak.efficiency for _, peak in points]
    power = exponent([f for f, _ in points], gammas)
    return [
        f"{geometric_mean(gammas):.3g} ({len(points)})",
        "-" if power is None else f"{power:+.2f}",
        f"{min(etas):.2f} to {max(etas):.2f}",
    ]


def _compared(one: Ridges, standard: Ridges | None, size: int) -> list[str]:
    if standard is None or size == _STANDARD:
        return ["-", "-"]
    alike = likeness(one.result, standard.result)
    return ["-", "-"] if alike is None else [f"{number:.3f}" for number in alike]


def draw(rows: list[Row]) -> "Figure":
    """Contours with onset lines: columns of sizes and counts, rows of fills and orientations."""
    from damper3d.reproduce.figures.maps import draw_chapter

    sizes = by_size(rows)
    several = any(len(maps.keys() & DRAWN) > 1 for maps in sizes.values())
    return draw_chapter(
        {
            f"{size} mm, {words}" if several else f"{size} mm": maps[name]
            for size, maps in sizes.items()
            for name, words in DRAWN.items()
            if name in maps
        }
    )
