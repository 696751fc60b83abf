"""A filled silo: where its particles are; kept, because filling costs more than discharging."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from granulab.campaign.runs.checkpoint import save_checkpoint
from granulab.campaign.runs.folder import digest
from granulab.campaign.runs.protocol import loaded
from silo2d.case.case import SiloCase, shapes_identity
from silo2d.case.outline import Outline
from silo2d.case.shape import ShapeSet


@dataclass(frozen=True, eq=False)
class Packing:
    """Particles at rest behind the closed door, numbered in rows from the bottom up."""

    kinds: np.ndarray  # (n,) index in the shape set
    poses: np.ndarray  # (n, 3) x, y [m], angle [rad]
    # area of particles over area of silo, well below the surface [-]; None: too few for one
    fraction: float | None
    coordination: float  # particles and walls that a particle touches, mean [-]
    poured_with: str
    cpu_s: float  # CPU time that the filling took [s]
    attempts: int = 1  # at the filling, each stiffer than the one before
    sources: str = ""  # digest of the sources that made it
    # Contacts at the walls in the last looks at the filling, under its laws, as of
    # Simulation.wall_samples; empty of packings of earlier versions.
    at_walls: dict[str, np.ndarray] = field(default_factory=dict)


_AT_WALLS = "at_walls_"


def packing_digest(case: SiloCase, seed: int) -> str:
    """Names a packing by all that it depends on, and by nothing that acts after the opening."""
    fill = case.settings.fill
    return digest(
        {
            "polygon": case.outline.polygon,
            "outlet": [case.outline.outlet, case.outline.outlet_centre],
            "shapes": shapes_identity(case.shapes),
            "surface_density": case.surface_density,
            "level": fill.level,
            "pour_with": fill.pour_with,
            "settled": fill.settled,
            "laws": [list(law) for law in case.pour_laws],
            "time_step": case.pour_time_step,
            "seed": seed,
            **({} if fill.layer is None else {"layer": fill.layer}),
            **({"inserts": list(case.outline.inserts)} if case.outline.inserts else {}),
            **({"outlets": list(case.outline.outlets)} if case.outline.outlets else {}),
        }
    )


def packing_folder(case: SiloCase, root: Path) -> Path:
    """Folder of the packing of a case below a folder of runs; it may not exist yet."""
    return root / "packings" / packing_digest(case, case.settings.run.seed)


def save_packing(packing: Packing, folder: Path) -> None:
    """Keep a packing in its folder, which is there; FolderError where it cannot be written."""
    arrays = {"kinds": packing.kinds, "poses": packing.poses}
    arrays |= {f"{_AT_WALLS}{name}": column for name, column in packing.at_walls.items()}
    known = ("kinds", "poses", "at_walls")
    meta = {key: value for key, value in vars(packing).items() if key not in known}
    save_checkpoint(folder / "packing.h5", arrays, meta)


def load_packing(folder: Path) -> Packing | None:
    """The packing kept in a folder, None where there is none; FolderError where it is damaged."""

    def packing(arrays: dict[str, np.ndarray], meta: dict[str, Any]) -> Packing:
        at_walls = {
            name.removeprefix(_AT_WALLS): column
            for name, column in arrays.items()
            if name.startswith(_AT_WALLS)
        }
        return Packing(arrays["kinds"], arrays["poses"], **meta, at_walls=at_walls)

    return loaded(folder, packing, "the silo is filled again")


_DEEP = 3  # largest particles one above the other, below which no fraction is known


def packing_fraction(
    outline: Outline, shapes: ShapeSet, kinds: np.ndarray, y: np.ndarray, level: float
) -> float | None:
    """Area of particles over area of silo, both up to one largest particle below `level` [-].

    A particle counts where its centroid is; those cut by the line cancel on average, where there
    are some: None for less than _DEEP particles below the line.
    """
    line = level - 2 * shapes.bounding_radius
    if line < _DEEP * 2 * shapes.bounding_radius:
        return None
    areas = np.array([shape.area for shape in shapes.shapes])[kinds]
    return float(areas[y < line].sum() / outline.area_below(line))


def in_rows(kinds: np.ndarray, poses: np.ndarray, height: float) -> tuple[np.ndarray, np.ndarray]:
    """The same particles, numbered by rows of a height [m] and from left to right in each.

    Particles that touch then stand near each other in memory.
    """
    order = np.lexsort((poses[:, 0], np.floor(poses[:, 1] / height)))
    return kinds[order], poses[order]
