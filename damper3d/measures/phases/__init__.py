"""The motional phases of a run, from its folder: motion, measures, criteria, phase map."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from damper3d.measures.phases.criteria import classify, criteria_of, phase_of_run
from damper3d.measures.phases.motion import of_run
from damper3d.measures.phases.motion_measures import measure_motion
from granulab.campaign.output.figure import BLUE, GREY, headline
from granulab.errors import FolderError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["classify", "draw", "measure", "phase_of_run"]


def measure(folder: Path) -> dict[str, Any]:
    """Phase, neighbouring phases and measures of the motion; None where too little was kept."""
    return phase_of_run(folder)


def draw(folder: Path) -> "Figure":
    """The measures that decide over their thresholds, and the phase that they make.

    Raises FolderError where the run keeps too few frames to name its phase.
    """
    from matplotlib.figure import Figure

    motion = of_run(folder)
    if motion is None:
        raise FolderError(
            f"{folder}: too few frames were kept to name a phase; run it with output.frames = 8 "
            "or more"
        )
    measures = measure_motion(motion)
    phase = classify(measures, motion.orientation)
    criteria = criteria_of(motion.orientation)
    figure = Figure(figsize=(7.2, 4.4), layout="constrained")
    headline(figure, f"phase: {phase.name.replace('_', ' ')}")
    axes = figure.subplots()
    names = [f"{c.measure.replace('_', ' ')} / {c.threshold:.3g}" for c in criteria]
    ratios = [max(measures[c.measure] or 0.0, 0.0) / c.threshold for c in criteria]
    axes.barh(names, ratios, color=BLUE)
    axes.axvline(1.0, color=GREY, lw=0.9)
    axes.invert_yaxis()
    axes.set_xlabel("measure over its threshold [-]")
    return figure
