"""The thesis's experiments, as far as a simulation can answer (chapter 7): two kinds of spheres.

358 spheres of 5 mm, fill ratio 0.466, shaken vertically: the smooth and the printed ones of the
experiments, which are their restitutions, 0.91 and 0.83 (Fig. 7.5). No measured signal is needed
and no signal analysis: force and acceleration of the enclosure are those of the run.
"""

from functools import partial
from typing import TYPE_CHECKING, Any

from damper3d.reproduce.panels import completeness, point_cases, run_of_cases, with_read
from damper3d.reproduce.quantities.experiments import (
    EXPERIMENTS,
    FREQUENCY,
    SURFACES,
    readings,
    signs_of,
)
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.claims.judge import report_claims
from granulab.campaign.output.layout import columns, done, paragraphs

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Row = dict[str, Any]

SEEDS = 3
COLUMNS = ("surface", "frequency_hz", "gamma", "efficiency_wall_work", "phase", "sign.")
# Gamma at 40 Hz: those of Figs 7.12 to 7.16, and between them; the shaker ended at 40.
GAMMAS = (1.5, 2.0, 3.0, 4.5, 8.0, 12.0, 20.0, 37.0)
FAST = 160.0  # [Hz], for "low amplitudes and high frequencies"
FAST_GAMMAS = (1.5, 3.0, 5.0, 8.0)
_CYCLES, _DISCARD = 13, 3  # five pairs of cycles, as in `reproduce cycles`
_READING = """\
collision: the moment of a cycle at which the net force of the bed, smoothed over a twentieth of it,
  is largest against an end. accel.: size of the enclosure's acceleration then, over Gamma g; force:
  over M g, of M the bed's mass; ends: how many of them reverse a quarter of 2 M V a cycle.
  unlike: |b - a|/(b + a) of the base's impulses in cycles that follow each other.
eta: of the shaker's work, as transducers have it (eqs 7.7 to 7.12); count: eq. 6.7 over cycles 4 to
  8, as the thesis's simulations have it.
Measured efficiencies are drawn in Figs 7.10 and 7.11 and not printed: none is compared."""


def points() -> list[Row]:
    """The labels of each point of the table."""
    chosen = [(FREQUENCY, gamma) for gamma in GAMMAS] + [(FAST, gamma) for gamma in FAST_GAMMAS]
    return [
        {"surface": surface, "frequency_hz": frequency, "gamma": gamma}
        for surface in SURFACES
        for frequency, gamma in chosen
    ]


def _settings(point: Row) -> Row:
    return {
        "law.restitution": SURFACES[point["surface"]],
        "motion.frequency": point["frequency_hz"],
        "motion.gamma": point["gamma"],
        "run.cycles": _CYCLES,
        "run.discard": _DISCARD,
        "output.frames": 10,
    }


cases = partial(point_cases, points, _settings)


def run(**options: Any) -> list[Row]:
    """Every point for each seed, with its signs; runs that are there are not done again."""
    rows = run_of_cases(lambda seeds: cases(seeds))(**options)
    return [with_read(row, signs) for row in rows]


def signs(folder: str) -> Row:
    """The signs of the counted cycles of a run folder."""
    from damper3d.measures.counted import read_cycles
    from damper3d.run.folders import shaken

    found = signs_of(read_cycles(shaken(folder).path))
    return {f"sign.{name}": float(f"{value:.5g}") for name, value in found.items()}


def report(rows: list[Row]) -> str:
    """Return what is there, the claims of secs 7.2 to 7.6 judged, and the readings."""
    found = readings(rows)
    return paragraphs(
        completeness(rows, points(), SEEDS),
        report_claims(EXPERIMENTS.judge(claims_of("damper_experiments"), found)),
        _table(rows),
        _READING,
    )


def _table(rows: list[Row]) -> str:
    """A line a point: means over the packings."""
    numbers = {
        "efficiency_wall_work": "eta", "sign.count": "count", "sign.ends": "ends",
        "sign.base_acceleration": "accel. base", "sign.lid_acceleration": "top",
        "sign.base_force": "force base", "sign.lid_force": "top", "sign.unlike": "unlike",
    }  # fmt: skip
    found = readings(rows)
    if not len(found):
        return ""
    lines = []
    for point in found.sort_values(["surface", "frequency_hz", "gamma"]).to_dict("records"):
        phases = {
            str(row["phase"]).replace("_", " ")
            for row in done(rows)
            if all(row[key] == point[key] for key in ("surface", "frequency_hz", "gamma"))
        }
        lines.append([
            f"  {point['surface']}", f"{point['frequency_hz']:g}", f"{point['gamma']:g}",
            *(f"{point[name]:.3g}" for name in numbers), ", ".join(sorted(phases)),
        ])  # fmt: skip
    return columns(["  spheres", "Hz", "Gamma", *numbers.values(), "phase"], lines)


def draw(rows: list[Row]) -> "Figure":
    """Efficiency of both surfaces, and when and how hard their beds collide."""
    from damper3d.reproduce.figures.experiments import experiment_panels

    return experiment_panels(rows)
