"""The points of the table of cycles, and what happens within the cycle, from a run to its row."""

from typing import Any

import numpy as np

from granulab.campaign.runs.folder import FolderError

Row = dict[str, Any]

FREQUENCY = 40.0  # [Hz]
BOUNCING = (20.0, 30.0, 40.0, 60.0, 100.0)  # Gamma; the thesis names 20 and 100 (Fig. 6.10)
FLUIDISED = (1.5, 3.0, 4.0)  # Fig. 6.18; 3 is that of Fig. 6.16 too
_DIGITS = 5  # of what a row keeps of a history


def points() -> list[dict[str, Any]]:
    """The labels of each point of the table."""
    chosen = [("vertical", (*FLUIDISED, *BOUNCING)), ("horizontal", FLUIDISED)]
    return [{"orientation": o, "gamma": gamma} for o, gammas in chosen for gamma in gammas]


def with_history(row: Row) -> Row:
    """A row with its mean pair of counted cycles, read from its run folder.

    cycle.dissipated       (2 n + 1,) [J] since the pair began
    cycle.bed_velocity     (2 n + 1,) [m/s] along the motion, in the lab
    A run whose samples are not there any more becomes a failed one.
    """
    from damper3d.measures.efficiency import dissipated
    from damper3d.view.scene import read_scene

    if row["state"] != "done":
        return row
    try:
        scene = read_scene(row["run_folder"])
    except FolderError as error:
        return row | {"state": "failed", "reason": str(error)}
    energy = dissipated(scene.trajectory)
    bed = scene.along(scene.trajectory["mean_velocity"])
    per_pair, first = 2 * scene.samples_per_cycle, scene.counted.start * scene.samples_per_cycle
    pairs = len(scene.counted) // 2
    at = first + per_pair * np.arange(pairs)[:, None] + np.arange(per_pair + 1)
    histories = {"dissipated": energy[at] - energy[at[:, :1]], "bed_velocity": bed[at]}
    return row | {f"cycle.{name}": _short(pairs.mean(axis=0)) for name, pairs in histories.items()}


def _short(history: np.ndarray) -> list[float]:
    return [float(f"{value:.{_DIGITS}g}") for value in history]
