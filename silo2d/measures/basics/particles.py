"""Particles of a run: their size, columns across the silo, which are inside, which left when."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granulab.contact.files.table import load_table
from granulab.errors import FolderError, InputError
from silo2d.case.settings import check_settings, read_settings
from silo2d.measures.basics.coarse_graining import inside_polygon
from silo2d.view.scene import Scene

Series = NDArray[np.float64]

FEWEST_OUT = 20  # particles that leave, for a rate or a mean over the flow


def prism_length(folder: str | Path) -> float:
    """Length of a run's prisms [m], by which stresses of the plane [N/m] are pascals.

    It stands in the materials file of the run folder; FolderError where that is not there.
    """
    case, materials = Path(folder) / "case.toml", Path(folder) / "materials.toml"
    if not materials.is_file():
        raise FolderError(
            f"{folder}: holds no materials.toml with the prisms' length; --again computes it again"
        )
    particles = check_settings(read_settings(case), str(case)).particles
    length = load_table(materials).material(particles.names[0]).length
    if length is None:
        raise FolderError(f"{materials}: [material.{particles.names[0]}] length is missing")
    return length.value


def with_pascals(numbers: Mapping[str, Any], length: float) -> dict[str, Any]:
    """Numbers with those in N/m again in Pa behind them: NAME_n_per_m and NAME_pa."""
    found: dict[str, Any] = {}
    for key, value in numbers.items():
        found[key] = value
        if key.endswith("_n_per_m"):
            own = f"{key.removesuffix('_n_per_m')}_pa"
            found[own] = None if value is None else (np.asarray(value) / length).tolist()
    return found


def column_edges(scene: Scene) -> Series:
    """Edges (c + 1,) [m] of equal columns across the silo, an odd number, about two particles wide.

    An odd number puts one column in the middle of a silo whose outlet is there.
    """
    left, right = scene.across
    count = 2 * round(((right - left) / (2 * scene.particle_size) - 1) / 2) + 1
    return np.linspace(left, right, max(count, 3) + 1)


def outlet_centre(scene: Scene) -> float:
    """x of the outlet's middle [m]."""
    (left, _), (right, _) = scene.trajectory.attributes["lips"]
    return float(left + right) / 2


def in_silo(scene: Scene) -> NDArray[np.bool_]:
    """Mask (F, n) of the particles that are in the silo at each frame: they have not passed y = 0,
    were not taken out, and wait in no store.
    """
    out_time = scene.trajectory["out_time"][-1]
    there = scene.trajectory["inside"] & ~(out_time <= scene.time[:, None])  # NaN: never
    return there & ~beside(scene, scene.trajectory["x"], scene.trajectory["y"])


def beside(scene: Scene, x: NDArray, y: NDArray) -> NDArray[np.bool_]:
    """Mask of centroids [m] that have left through a window and fall beside the silo's walls."""
    if scene.n_doors < 2:
        return np.zeros(np.shape(x), bool)
    from shapely import Polygon, contains_xy

    silo = Polygon(inside_polygon(scene))
    below = y < scene.walls[..., 1].max()
    return below & (y >= 0.0) & ~contains_xy(silo, x, y)


def leavers(scene: Scene, fewest: int = 0, what: str = "this") -> tuple[Series, Series]:
    """Times [s] at which particles left, ascending, and their masses [kg].

    Raises InputError where fewer than `fewest` left, with `what` needs them.
    """
    times, mass = scene.trajectory["out_time"][-1], scene.trajectory.static["mass"]
    n = int((~np.isnan(times)).sum())
    if n < fewest:
        least = f"{fewest} particles" if fewest > 1 else "one"
        raise InputError(
            f"{n} particles left: {what} needs {least} at least; take a run that flows"
        )
    order = np.argsort(times)[:n]
    return times[order], mass[order]


def start_height(scene: Scene) -> Series:
    """Height of each particle at the opening (n,) [m]."""
    return scene.trajectory["y"][0].astype(float)


def numbers(series: NDArray) -> list:
    """A series as nested lists for JSON, NaN as None."""
    if series.ndim > 1:
        return [numbers(row) for row in series]
    return [None if np.isnan(value) else float(value) for value in series]
