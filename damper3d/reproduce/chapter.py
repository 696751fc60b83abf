"""Chapter 6 whole: the maps of four sizes, four fills and two orientations (Table 6.1).

The thesis shows some of them (Figs 6.4, 6.5, 6.12, 6.22 and 6.26) and says that the others are
alike; here all are computed, at its nine frequencies and nineteen Gammas, one packing each.
"""

import itertools
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from damper3d.reproduce.dampers import HEIGHTS, ORIENTATIONS, SPHERES, panel
from damper3d.reproduce.fluidisation_statements import statements as fluidised
from damper3d.reproduce.map_statements import Ridges, likeness, points_of, statements
from damper3d.reproduce.maps import ridges_by_panel
from damper3d.reproduce.maps import run as run_maps
from damper3d.reproduce.runs import Panel, Row, labels_of
from damper3d.reproduce.standing import standing
from damper3d.reproduce.statements import report_statements
from damper3d.studies.map.grid import FREQUENCIES, GAMMAS
from granulab.campaign.output.layout import columns

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEEDS = 1

_STANDARD = 5  # mm, that the others are set beside
_CRITERION = """\
fluidisation, bouncing bed: of the peaks of each ridge that can be seen (docs/damper-map.md), the
geometric mean of Gamma and the exponent of f, and the range of eta. beside 5 mm: over the points
that both have, correlation of eta and root-mean-square difference."""


def panels() -> list[Panel]:
    """The 32 maps, the dearest last."""
    points = list(itertools.product(FREQUENCIES, GAMMAS))
    sizes = sorted(SPHERES, reverse=True)
    return [panel(o, h, size, points) for size in sizes for o in ORIENTATIONS for h in HEIGHTS]


def run(
    *,
    out: Path,
    seeds: Sequence[int],
    workers: int | None,
    quiet: bool,
    grid: Sequence[Panel] | None = None,
    **engine: str,
) -> list[Row]:
    """All points of the 32 maps, or of another grid, with all packings."""
    grid = panels() if grid is None else grid
    return run_maps(out=out, seeds=seeds, workers=workers, quiet=quiet, grid=grid, **engine)


def by_size(rows: Sequence[Row]) -> dict[int, dict[tuple[str, int], Ridges]]:
    """The maps of each diameter [mm] that has one, by orientation and height."""
    sizes = sorted({row["diameter_mm"] for row in rows})
    found = {
        size: ridges_by_panel([row for row in rows if row["diameter_mm"] == size]) for size in sizes
    }
    return {size: maps for size, maps in found.items() if maps}


def report(rows: list[Row]) -> str:
    """What lacks, a line for each map, and the statements about the maps of each size."""
    found = by_size(rows)
    table = columns(
        ["size", "orientation", "height", "best eta", "at f [Hz]", "Gamma", "fluidisation", "f^",
         "eta", "bouncing bed", "f^", "eta", "beside 5 mm", "rms"],
        [_line(size, key, found) for size, maps in found.items() for key in maps],
    )  # fmt: skip
    judged = [
        f"spheres of {size} mm, {report_statements([*statements(maps), *fluidised(maps)])}"
        for size, maps in found.items()
    ]
    parts = [
        standing(rows, labels_of(panels()), SEEDS),
        table,
        *judged,
        _CRITERION,
    ]
    return "\n\n".join(filter(None, parts))


def _line(
    size: int, key: tuple[str, int], found: dict[int, dict[tuple[str, int], Ridges]]
) -> list[str]:
    one, (orientation, height) = found[size][key], key
    eta = one.result.efficiency
    best = int(np.nanargmax(eta))
    return [
        f"{size} mm",
        orientation,
        f"{height} mm",
        f"{eta[best]:.3f}",
        f"{one.result.frequency[best]:g}",
        f"{one.result.gamma[best]:g}",
        *_ridge(one, "fluidisation"),
        *_ridge(one, "bouncing_bed"),
        *_beside(one, found.get(_STANDARD, {}).get(key), size),
    ]


def _ridge(one: Ridges, ridge: str) -> list[str]:
    points, exponent = points_of(one, ridge)
    if not points:
        return ["-", "-", "-"]
    mean = math.exp(sum(math.log(peak.gamma) for _, peak in points) / len(points))
    etas = [peak.efficiency for _, peak in points]
    return [
        f"{mean:.3g} ({len(points)})",
        "-" if exponent is None else f"{exponent:+.2f}",
        f"{min(etas):.2f} to {max(etas):.2f}",
    ]


def _beside(one: Ridges, standard: Ridges | None, size: int) -> list[str]:
    if standard is None or size == _STANDARD:
        return ["-", "-"]
    alike = likeness(one.result, standard.result)
    return ["-", "-"] if alike is None else [f"{number:.3f}" for number in alike]


def draw(rows: list[Row]) -> "Figure":
    """Contours with onset lines: a column for each size, a row for each fill and orientation."""
    from damper3d.reproduce.chapter_panels import draw_chapter

    return draw_chapter(by_size(rows))
