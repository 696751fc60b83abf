"""Chapter 8: what the particles' shape does to the best Gamma and to the efficiency.

Spheroids and toroids of Tables 8.1 and 8.2 with the thesis's sum of sub-sphere contacts. Onsets of
the bouncing bed at 20 and 40 Hz in both orientations (Figs 8.9-8.14), those of 40 Hz refined twice
about each peak, as the Gammas of 20 Hz lie closer; vertical curves from 125 to 1024 Hz (Figs 8.21,
8.23, 8.25); the properties of Fig. 8.20; and for two shapes the other treatments of several
contacts of one pair. High frequencies and 20 Hz take every third packing, for their cost.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

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
from granulab.campaign.output.layout import columns, done

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEEDS = 3
SELDOM = 3  # every third packing alone runs what costs most
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


class Part(NamedTuple):
    """Dampers that are run alike.

    refine   how often, about each peak
    every    1: with each of the packings; 3: with the first, the fourth, ...
    """

    name: str
    panels: list[Panel]
    refine: int = 0
    every: int = 1

    def standing(self, rows: Sequence[Row]) -> str:
        """How much of it there is."""
        frequencies = {frequency for panel in self.panels for frequency, _ in panel.points}
        own = [
            row
            for panel in self.panels
            for row in panel.of(rows)
            if row["frequency_hz"] in frequencies
        ]
        packings = len(range(0, SEEDS, self.every))
        return f"{self.name}: {standing(own, labels_of(self.panels), packings)}"


def plan() -> list[Part]:
    """What the table runs, in this order."""
    low, high = BOUNCING
    return [
        Part(f"{high:g} Hz", onset_panels(high), refine=REFINE),
        Part("treatments", treatment_panels(), refine=REFINE),
        Part("properties", sensitivity_panels()),
        Part("high frequencies", curve_panels(), every=SELDOM),
        Part(f"{low:g} Hz", onset_panels(low), every=SELDOM),
    ]


def run(
    *,
    out: Path,
    seeds: Sequence[int],
    workers: int | None,
    quiet: bool,
    **engine: str,
) -> list[Row]:
    """All points of the table with their packings."""
    rows: list[Row] = []
    for part in plan():
        rows += run_panels(
            part.panels, seeds[:: part.every],
            refine=part.refine, out=out, workers=workers, quiet=quiet, **engine,
        )  # fmt: skip
        if any(row["state"] == "interrupted" for row in rows):
            break
    return rows


def report(rows: list[Row]) -> str:
    """What lacks, the onsets, the treatments, the optima of fluidisation, the statements."""
    found = optima(rows)
    statements = [
        *bouncing_statements(found),
        past_onset(rows, found),
        *fluidisation_statements(found),
        *property_statements(rows),
    ]
    pooled = pooled_scatter(list(found.values()))
    parts = [
        "\n".join(part.standing(rows) for part in plan()),
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
