"""Course of a cycle: dissipation and the bed's velocity within it (Figs 6.7, 6.10, 6.16, 6.18).

358 spheres of 5 mm, fill ratio 0.466, 40 Hz: the bouncing bed at Gamma 20 to 100, and Gamma 1.5, 3
and 4 about the fluidisation optimum in both orientations. The rows hold the histories.
"""

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.reproduce.panels import completeness, point_cases, run_of_cases, with_read
from damper3d.reproduce.quantities.cycles import CYCLES, FREQUENCY, ideal_since, readings
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.claims.judge import report_claims
from granulab.campaign.output.layout import columns, done, paragraphs

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

Row = dict[str, Any]

SEEDS = 3
COLUMNS = ("orientation", "gamma", "frequency_hz", "mass_kg", "phase", "cycle.")

BOUNCING = (20.0, 30.0, 40.0, 60.0, 100.0)  # Gamma; the thesis names 20 and 100 (Fig. 6.10)
FLUIDISED = (1.5, 3.0, 4.0)  # Fig. 6.18; 3 is that of Fig. 6.16 too
_DIGITS = 5  # of what a row keeps of a history
_CYCLES, _DISCARD = 13, 3  # five pairs of cycles
_READING = """\
step: a stretch of the cycle in which more than the mean power is dissipated, with at least a tenth
  of a cycle's energy; it starts when a tenth of its energy is dissipated and ends when nine tenths
  are. since: part of the cycle from the enclosure's greatest speed the other way to the start; in
  brackets the ideal bouncing bed's (meeting_phase), with A0 of the close packing (eq. 6.13).
Velocities over V = Gamma g/omega. enclosure, half way: its speed when a step starts, and when half
  of its energy is dissipated; against: the bed's greatest velocity in the quarter cycle before the
  start, against the enclosure's half way. bed, relative: largest speed of the bed, and of the bed
  against the enclosure. together: part of the cycle in which the two differ by less than V/10.
  within: part of the energy that is dissipated at more than the mean power.
  uneven: |b - a|/(b + a) of the energies of successive cycles.
Histories are means over five pairs of cycles after three that do not count, so cycles 4 to 13; the
  thesis shows steady cycles and does not say which. Gamma 30, 40 and 60 are our choice."""


def points() -> list[Row]:
    """The labels of each point of the table."""
    chosen = [("vertical", (*FLUIDISED, *BOUNCING)), ("horizontal", FLUIDISED)]
    return [{"orientation": o, "gamma": gamma} for o, gammas in chosen for gamma in gammas]


def _settings(point: Row) -> Row:
    return {
        "motion.orientation": point["orientation"],
        "motion.frequency": FREQUENCY,
        "motion.gamma": point["gamma"],
        "run.cycles": _CYCLES,
        "run.discard": _DISCARD,
    }


cases = partial(point_cases, points, _settings)


def run(**options: Any) -> list[Row]:
    """Every point for each seed, with its histories; runs that are there are not done again."""
    rows = run_of_cases(lambda seeds: cases(seeds))(**options)
    return [with_read(row, history) for row in rows]


def history(folder: str) -> Row:
    """The mean pair of counted cycles of a run folder.

    cycle.dissipated       (2 n + 1,) [J] since the pair began
    cycle.bed_velocity     (2 n + 1,) [m/s] along the motion, in the lab
    """
    from damper3d.measures.efficiency import dissipated
    from damper3d.view.scene import read_scene

    scene = read_scene(folder)
    energy = dissipated(scene.trajectory)
    bed = scene.along(scene.trajectory["mean_velocity"])
    per_pair, first = 2 * scene.samples_per_cycle, scene.counted.start * scene.samples_per_cycle
    pairs = len(scene.counted) // 2
    at = first + per_pair * np.arange(pairs)[:, None] + np.arange(per_pair + 1)
    histories = {"dissipated": energy[at] - energy[at[:, :1]], "bed_velocity": bed[at]}
    return {f"cycle.{name}": _short(pairs.mean(axis=0)) for name, pairs in histories.items()}


def _short(history: np.ndarray) -> list[float]:
    return [float(f"{value:.{_DIGITS}g}") for value in history]


def report(rows: list[Row]) -> str:
    """Return what is there, the claims of secs 6.4.1 and 6.4.3 judged, and the readings."""
    found = readings(rows)
    return paragraphs(
        completeness(rows, points(), SEEDS),
        report_claims(CYCLES.judge(claims_of("damper_cycles"), found)),
        _table(rows, found),
        _READING,
    )


def _table(rows: list[Row], found: "DataFrame") -> str:
    """A line a point: means over the packings."""
    numbers = ("enclosure", "half_way", "against", "bed", "relative", "together", "within")
    lines = []
    for mean in found.to_dict("records"):
        point = mean["orientation"], mean["gamma"]
        phases = [str(row.get("phase")).replace("_", " ") for row in done(rows)
                  if (row["orientation"], row["gamma"]) == point]  # fmt: skip
        ideal = ideal_since(point[1]) if point[1] in BOUNCING else None
        since = _cell(mean["since"]) + (f" ({ideal:.2f})" if ideal else "")
        cells = [_cell(mean[name]) for name in ("duration", *numbers)]
        lines.append([
            f"  {point[0]}", f"{point[1]:g}", f"{mean['steps']:.2g}", since, *cells,
            f"{mean['deceleration']:.0f}", _cell(mean["unevenness"]),
            ", ".join(dict.fromkeys(phases)),
        ])  # fmt: skip
    header = ["  motion", "Gamma", "steps", "since", "duration",
              *(name.replace("_", " ") for name in numbers), "bed m/s2", "uneven",
              "phase"]  # fmt: skip
    return columns(header, lines) if lines else ""


def _cell(value: float) -> str:
    return "-" if np.isnan(value) else f"{value:.2f}"


def draw(rows: list[Row]) -> "Figure":
    """Five panels after the thesis's figures, and when the bouncing bed collides."""
    from damper3d.reproduce.figures.cycles import cycle_panels

    return cycle_panels(rows)
