"""Stages of a run for its loads: filled, at rest, just opened, in flow, and the end."""

from pathlib import Path

import numpy as np

from granulab.campaign.runs.trajectory import stored_tables
from granulab.errors import InputError
from silo2d.measures.basics.contacts import FEWEST_OUT, Moment, flowing, moment_at
from silo2d.measures.basics.particles import leavers
from silo2d.measures.basics.walls import Samples, samples_of
from silo2d.view.scene import Scene

_FIRST = 0.1  # [s] after the opening, of a run that hardly flows


def windows(
    scene: Scene, between: tuple[float, float] | None = None
) -> dict[str, tuple[float, float]]:
    """From and until [s] of the stages that last; between: in place of the flow's."""
    times, _ = leavers(scene)
    flows = len(times) >= FEWEST_OUT
    first, last = flowing(scene) if flows else (_FIRST, _FIRST)
    found = {"opening": (0.0, min(first, float(scene.time[-1])))}
    if between or flows:
        found["flow"] = between or (first, last)
    return found


def stage_samples(
    folder: Path, scene: Scene, between: tuple[float, float] | None = None
) -> dict[str, Samples]:
    """Contacts at the walls in each stage that a run has.

    In the opening and the flow from the samples of [output] wall_interval, or where a run has none
    from the frames with contacts. Raises InputError where a window given holds none.
    """
    tables = stored_tables(folder)
    contacts = tables.get("contacts")
    moments = [] if contacts is None else [
        moment_at(scene, contacts, k)
        for k in range(len(contacts))
        if contacts.frame[k] < len(scene.time)
    ]  # fmt: skip
    if not moments:
        raise InputError(f"{folder}: keeps no contacts; loads need a run of engine dem")
    found = {"filling": filled} if (filled := _filling(scene)) is not None else {}
    sampled = _sampled(tables["walls"].columns) if "walls" in tables else samples_of(moments)
    found["at_rest"] = sampled.between(-np.inf, 0.0)
    for stage, window in windows(scene, between).items():
        own = sampled.between(max(window[0], np.finfo(float).tiny), window[1])
        if len(own.time):
            found[stage] = own
        elif between and stage == "flow":
            raise InputError(
                f"between {between[0]:g} s and {between[1]:g} s: no sample; the run has them up to "
                f"{scene.time[-1]:.3g} s"
            )
    if _lies_at_the_end(scene, moments):
        found["end"] = samples_of(moments[-1:])
    return found


def _lies_at_the_end(scene: Scene, moments: list[Moment]) -> bool:
    lying = scene.summary.get("outcome") in ("clogged", "clogged_at_opening", "dead_zones")
    return lying and bool(moments[-1].inside.any())


def _filling(scene: Scene) -> Samples | None:
    """The walls once the silo was filled; None of runs of earlier versions."""
    static = scene.trajectory.static
    if "filling_wall" not in static:
        return None
    return _sampled({key: static[f"filling_{key}"] for key in ("time", "wall", "point", "force")})


def _sampled(columns: dict[str, np.ndarray]) -> Samples:
    time, moment = np.unique(columns["time"], return_inverse=True)
    return Samples(
        time, moment.ravel().astype(np.int64), columns["wall"].astype(np.int64),
        columns["point"].astype(float), columns["force"].astype(float),
    )  # fmt: skip
