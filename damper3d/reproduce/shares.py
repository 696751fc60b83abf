"""Shares of the dissipated energy: particle-particle contacts, friction (Figs 6.28, 6.29).

Vertical motion at 40 and 160 Hz, fill ratio 0.466, spheres of 3 to 6 mm, over the thesis's Gammas.
Each share is given twice: of what our budget finds dissipated, and of the thesis's count (eq. 6.7),
in which friction is the whole force mu Fn times the sliding velocity, so that it is more.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from damper3d.reproduce.completeness import completeness
from damper3d.reproduce.panels import SPHERES, point_cases, run_of_cases
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
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.claims.judge import report_claims
from granulab.campaign.output.layout import columns, done, paragraphs

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from granulab.campaign.sweeps.sweep import Labelled

Row = dict[str, Any]

SEEDS = 3
COLUMNS = (
    "diameter_mm", "frequency_hz", "gamma", "efficiency", "efficiency_interval", "shares.",
    "shares_contact_count.",
)  # fmt: skip

SIZES = (5, 4, 6, 3)  # [mm], dearest last
FREQUENCIES = (40.0, 160.0)  # [Hz]
GAMMAS = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 15.0, 20.0, 30.0, 40.0, 50.0,
          60.0, 80.0, 100.0)  # fmt: skip
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


def cases(seeds: Sequence[int], changes: Row | None = None) -> "list[Labelled]":
    """Each point once for each seed; `changes` go over what the table sets."""
    return point_cases(points(), _settings, seeds, changes)


def _settings(point: Row) -> Row:
    return {
        "particles.shape": f"sphere:{point['diameter_mm']}mm",
        "particles.count": SPHERES[point["diameter_mm"]],
        "motion.frequency": point["frequency_hz"],
        "motion.gamma": point["gamma"],
        "output.keep": "summary",
    }


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


def draw(rows: list[Row]) -> "Figure":
    """Three rows of panels as in Figs 6.28 and 6.29; see figures.shares."""
    from damper3d.reproduce.figures.shares import share_panels

    return share_panels(rows, landmarks(rows), FREQUENCIES)
