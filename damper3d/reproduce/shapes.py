"""Chapter 8: what the particles' shape does to the best Gamma and to the efficiency.

Spheroids and toroids of Tables 8.1 and 8.2 with the thesis's sum of sub-sphere contacts. Onsets of
the bouncing bed at 20 and 40 Hz in both orientations (Figs 8.9-8.14), refined twice about each
peak; vertical curves from 125 to 1024 Hz (Figs 8.21, 8.23, 8.25); the properties of Fig. 8.20; and
for two shapes the other treatments of several contacts of one pair.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from campaign.layout import columns, done
from damper3d.reproduce.optima import Optimum, pooled_scatter, with_scatter
from damper3d.reproduce.runs import Panel, Row, labels_of, run_panels
from damper3d.reproduce.shape_effects import (
    fluidisation_statements,
    past_onset,
    property_statements,
)
from damper3d.reproduce.shape_optima import Found, Line, optima
from damper3d.reproduce.shape_plan import (
    BOUNCING,
    TREATED,
    TREATED_AT,
    TREATMENTS,
    curve_panels,
    onset_panels,
    particle_text,
    sensitivity_panels,
    sphericities,
    treatment_panels,
)
from damper3d.reproduce.shape_statements import all_bouncing, bouncing_statements, onsets
from damper3d.reproduce.standing import standing
from damper3d.reproduce.statements import report_statements

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEEDS = 3
REFINE = 2
_PACKINGS = "close", "spheres"

_CRITERION = """\
onset: where the highest peak of eta along Gamma lies, by a parabola through its top, geometric mean
  +- standard deviation over the packings that have a peak (their number); bracket: between which
  Gammas the peak of the mean curve lies by more than noise; times: over the sphere's of the same
  family; own, spheres: eq. 6.11 with the clearance that the shape's own close packing leaves
  (damper3d reproduce packing), and that of spheres. fluidisation optimum: the
  same peak at 125 Hz and more. Statements: the thesis prints no value of its figures, so that each
  is judged by the rule in its words, on the optima themselves."""


def plan() -> list[tuple[list[Panel], int]]:
    """The dampers of the table, part by part, and how often each part is refined."""
    return [
        (onset_panels() + treatment_panels(), REFINE),
        (curve_panels() + sensitivity_panels(), 0),
    ]


def run(
    *,
    out: Path,
    seeds: Sequence[int],
    workers: int | None,
    quiet: bool,
    parts: Sequence[tuple[list[Panel], int]] | None = None,
    **engine: str,
) -> list[Row]:
    """All points of the table, or of other parts, with all packings."""
    rows: list[Row] = []
    for panels, refine in plan() if parts is None else parts:
        rows += run_panels(
            panels, seeds, refine=refine, out=out, workers=workers, quiet=quiet, **engine
        )
        if any(row["state"] == "interrupted" for row in rows):
            break
    return rows


def report(rows: list[Row]) -> str:
    """What lacks, the onsets, the treatments, the optima of fluidisation, the statements."""
    found = optima(rows)
    points = labels_of([panel for panels, _ in plan() for panel in panels])
    statements = [
        *bouncing_statements(found),
        past_onset(rows, found),
        *fluidisation_statements(found),
        *property_statements(rows),
    ]
    pooled = pooled_scatter(list(found.values()))
    parts = [
        standing(rows, points, SEEDS),
        _onset_table(found),
        "" if pooled is None else f"scatter over the packings: {100 * pooled[0]:.1f} %",
        _treatment_table(found),
        _fluidised_table(found),
        report_statements(statements),
        _CRITERION,
        _strained(rows),
    ]
    return "\n\n".join(filter(None, parts))


def _onset_table(found: Found) -> str:
    lines = []
    for like in all_bouncing(found):
        for family in ("spheroid", "toroid"):
            own = onsets(found, family, like)
            sphere = own.get(1.0 if family == "spheroid" else 0.0)
            for ratio, one in own.items():
                head = [f"{like.frequency:g}", like.orientation, family, f"{ratio:g}"]
                roundness = f"{sphericities()[family, ratio]:.3f}"
                lines.append(
                    [*head, roundness, *_cells(one), _times(one, sphere), *_predicted(one)]
                )
    heads = ["f [Hz]", "orientation", "shape", "ratio", "sphericity", "onset", "bracket", "eta",
             "times", "own", "spheres"]  # fmt: skip
    return columns(heads, lines) if lines else ""


def _treatment_table(found: Found) -> str:
    lines = []
    for shape in TREATED:
        own = {t: found.get(Line(shape, "vertical", TREATED_AT, t)) for t in TREATMENTS}
        lines += [
            [particle_text(shape), treatment, *_cells(one), _times(one, own["sum"])]
            for treatment, one in own.items()
            if one is not None
        ]
    heads = ["particles", "contacts", "onset", "bracket", "eta", "over sum's"]
    title = f"contacts of one pair, vertical, {TREATED_AT:g} Hz:\n"
    return title + columns(heads, lines) if lines else ""


def _fluidised_table(found: Found) -> str:
    """A line a shape, a column a frequency: Gamma and eta of the highest peak."""
    vertical = [line for line in found if line.frequency > max(BOUNCING)]
    frequencies = sorted({line.frequency for line in vertical})
    lines = []
    for shape in sorted({line.shape for line in vertical}):
        ones = [found.get(Line(shape, "vertical", f)) for f in frequencies]
        cells = [f"{one.gamma:.2f} ({one.mean.efficiency:.2f})" if one else "-" for one in ones]
        lines.append([shape[0], f"{shape[1]:g}", *cells])
    heads = ["shape", "ratio", *(f"{f:g} Hz" for f in frequencies)]
    title = "fluidisation optimum, vertical: Gamma (eta)\n"
    return title + columns(heads, lines) if lines else ""


def _cells(one: Optimum) -> list[str]:
    low, high = one.mean.bracket
    return [with_scatter(one), f"{low:.3g} to {high:.3g}", f"{one.mean.efficiency:.3f}"]


def _times(one: Optimum, reference: Optimum | None) -> str:
    return "-" if reference is None else f"{one.gamma / reference.gamma:.2f}"


def _predicted(one: Optimum) -> list[str]:
    """Eq. 6.11 with the close packing of the shape and of spheres."""
    onsets = [one.predicted(name) for name in _PACKINGS]
    return ["-" if onset is None else f"{onset:.3g}" for onset in onsets]


def _strained(rows: Sequence[Row]) -> str:
    """How well the energy books close where they close worst."""
    closures = [
        (abs(row["energy_closure"]), row)
        for row in done(rows)
        if row.get("energy_closure") is not None
    ]
    if not closures:
        return ""
    closure, row = max(closures, key=lambda pair: pair[0])
    return (
        f"largest unaccounted energy: {100 * closure:.2g} % of what is dissipated ({row['shape']} "
        f"{row['ratio']:g}, {row['frequency_hz']:g} Hz, Gamma {row['gamma']:g})"
    )


def draw(rows: list[Row]) -> "Figure":
    """Onsets by ratio and sphericity, curves, treatments, properties."""
    from damper3d.reproduce.shape_charts import draw_shapes

    return draw_shapes(rows, optima(rows))
