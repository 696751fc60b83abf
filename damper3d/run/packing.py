"""A settled bed: the state of its particles at rest in the enclosure; kept, to be shared.

It does not depend on how the enclosure will move, so that all points of a map start from one.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from damper3d.case.case import DamperCase
from damper3d.engine.enclosures import Enclosure
from granulab.campaign.runs.checkpoint import save_checkpoint
from granulab.campaign.runs.folder import digest
from granulab.campaign.runs.protocol import loaded

REFILLED = "the enclosure is filled again"  # where a packing is deleted
_INNER = 0.8  # part of the particles, from below, that the packing fraction is taken over


@dataclass(frozen=True, eq=False)
class Packing:
    """A bed at rest under gravity, in the enclosure's frame."""

    state: dict[str, np.ndarray]  # what Simulation.save gave
    fraction: float  # volume of the particles over that of the space, inside the bed [-]
    height: float  # of the highest particle's top over the enclosure's lowest point [m]
    coordination: float  # particles and walls that a particle touches, mean [-]
    rms_speed: float  # that is left [m/s]
    cpu_s: float  # CPU time that the filling took [s]
    sources: str = ""  # digest of the sources that made it


def packing_folder(case: DamperCase, root: Path) -> Path:
    """Folder of the packing of a case below a folder of runs; it may not exist yet."""
    return root / "packings" / digest(case.packing_identity())


def save_packing(packing: Packing, folder: Path) -> None:
    """Keep a packing in its folder, which is there; FolderError where it cannot be written."""
    meta = {name: value for name, value in vars(packing).items() if name != "state"}
    save_checkpoint(folder / "packing.h5", packing.state, meta)


def load_packing(folder: Path) -> Packing | None:
    """The packing kept in a folder, None where there is none; FolderError where it is damaged."""
    return loaded(folder, lambda arrays, meta: Packing(arrays, **meta), REFILLED)


def packing_fraction(
    centres: np.ndarray, volumes: float | np.ndarray, enclosure: Enclosure, up: np.ndarray
) -> float:
    """Volume of the particles over that of the space, up to where 80 % of the centres are [-].

    centres (n, 3) [m]; volumes of all, or of each (n,) [m3]. The loose surface is left out. Of a
    particle that the level cuts the part below it counts, as of a sphere of its volume: a few
    particles on a floor, which stand up out of that space, do not fill more than it.
    """
    order = np.argsort(centres @ up)
    heights = (centres @ up)[order]
    count = max(round(_INNER * len(heights)), 1)
    level = float(heights[count - 1 : count + 1].mean())
    radius = (0.75 * np.broadcast_to(volumes, len(order))[order] / np.pi) ** (1 / 3)
    deep = np.clip(level - heights + radius, 0.0, 2.0 * radius)  # of each sphere, below the level
    inside = float((np.pi * deep**2 * (radius - deep / 3.0)).sum())
    return inside / enclosure.volume_below(up, level)
