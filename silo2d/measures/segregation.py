"""Segregation index: how far a mixture in the silo is from one that is mixed at random.

After Lacey (J. Appl. Chem. 4 (1954) 257), as a segregation index: the particles inside lie in
square cells by their centroids, n_c in cell c, and a component has the share p of all N and p_c of
those in a cell. With

    s^2   = sum n_c (p_c - p)^2 / N          variance found
    s0^2  = p (1 - p)                        where each cell holds all of it or nothing
    sr^2  = p (1 - p) (C - 1)/(N - 1)        expected of particles dealt to C cells at random

it is S = (s^2 - sr^2)/(s0^2 - sr^2): 1 where the component is apart, 0 on average where it is mixed
at random, a little below 0 where it is more even than that; Lacey's mixing index is 1 - S. The
expectation is that of drawing without replacement (hypergeometric), exact for cells of any number.

Components are the parts of the mixture, and "fine": the particles smaller than the mean area.
"""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from granulab.campaign.output.figure import BLUE, INK, WALL, headline
from granulab.errors import InputError
from silo2d.measures.basics.particles import in_silo
from silo2d.view.scene import Scene, read_scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CELL = 4.0  # particle sizes (roots of the mean area) that a cell is wide
_FEWEST = 100  # particles inside, below which cells are too few
_MOST_PARTS = 8  # parts of a mixture that are looked at one by one


def measure(folder: Path) -> dict[str, Any]:
    """Index of each component at the opening and at the end, and over time.

    Frames with fewer than 100 particles inside have none. Raises InputError where all are alike.
    """
    scene = read_scene(folder)
    found, inside = components(scene), in_silo(scene)
    enough = np.flatnonzero(inside.sum(axis=1) >= _FEWEST)
    if not len(enough):
        raise InputError(f"fewer than {_FEWEST} particles: too few for cells of a mixture")
    side = CELL * scene.particle_size
    rows = []
    for name, member in found.items():
        series = [_of_frame(scene, frame, inside[frame], member, side) for frame in enough.tolist()]
        rows.append(
            {
                "component": name,
                "share": float(member.mean()),
                "at_opening": series[0],
                "at_end": series[-1],
                "index": series,
            }
        )
    ends = {
        f"{row['component']}_{when}": row[when] for row in rows for when in ("at_opening", "at_end")
    }
    return {"cell_m": side, **ends, "time_s": scene.time[enough].tolist(), "components": rows}


def components(scene: Scene) -> dict[str, NDArray[np.bool_]]:
    """Masks (n,) of the particles of each component, by name."""
    trajectory = scene.trajectory
    kind, size = trajectory.static["kind"], scene.areas
    found = {}
    parts = np.asarray(trajectory.static.get("shape_part", np.zeros(0, np.int64)))
    if 1 < len(np.unique(parts)) <= _MOST_PARTS:
        names = json.loads(trajectory.attributes["part_names"])
        found = {names[part]: parts[kind] == part for part in np.unique(parts)}
    if np.ptp(size) > 1e-6 * size.mean():
        found["below mean area" if "fine" in found else "fine"] = size < size.mean()
    found = {name: member for name, member in found.items() if 0 < member.sum() < len(member)}
    if not found:
        raise InputError("all particles are alike: there is nothing to segregate")
    return found


def _of_frame(
    scene: Scene, frame: int, inside: NDArray[np.bool_], member: NDArray[np.bool_], side: float
) -> float | None:
    x, y = (scene.trajectory[key][frame][inside].astype(float) for key in ("x", "y"))
    cells = np.column_stack([np.floor(x / side), np.floor(y / side)]).astype(np.int64)
    return segregation_index(cells, member[inside])


def segregation_index(cells: NDArray[np.int64], member: NDArray[np.bool_]) -> float | None:
    """Segregation index of a component in the cells (n, 2) that particles lie in.

    member (n,): which of them are of the component. None where all or none are, or all cells hold
    one particle.
    """
    _, which = np.unique(cells, axis=0, return_inverse=True)
    n_cell = np.bincount(which.ravel())
    n, p = len(member), float(member.mean())
    apart = p * (1.0 - p)
    if apart == 0.0 or len(n_cell) == n:
        return None
    share = np.bincount(which.ravel(), weights=member) / n_cell
    found = float((n_cell * (share - p) ** 2).sum()) / n
    at_random = apart * (len(n_cell) - 1) / (n - 1)
    return (found - at_random) / (apart - at_random)


def draw(folder: Path) -> "Figure":
    """The first component in the silo at the opening, and the index of each over time."""
    from matplotlib.collections import LineCollection, PolyCollection
    from matplotlib.figure import Figure

    scene, found = read_scene(folder), measure(folder)
    first, member = next(iter(components(scene).items()))
    figure = Figure(figsize=(9.2, 4.6), layout="constrained")
    headline(figure, scene.headline)
    silo, curve = figure.subplots(1, 2, width_ratios=[1, 1.4])
    for particles, outlines in scene.outlines(0):
        fills = [BLUE if member[particle] else "#eceae4" for particle in particles]
        silo.add_collection(
            PolyCollection(list(outlines), facecolors=fills, edgecolors=INK, linewidths=0.3)
        )
    silo.add_collection(LineCollection(list(scene.walls), colors=WALL, linewidths=2))
    left, right, _, top = scene.window
    bottom = scene.walls[..., 1].min() - 0.01 * top
    silo.set(xlim=(left - 0.004, right + 0.004), ylim=(bottom, top), aspect="equal")
    silo.set_axis_off()
    silo.set_title(f"{first}, at the opening", loc="left", fontsize=9)
    for row in found["components"]:
        curve.plot(found["time_s"], row["index"], label=row["component"])
    curve.axhline(0.0, color=INK, lw=0.7)
    curve.set(xlabel="time [s]", ylabel="segregation index: 0 at random, 1 apart")
    curve.legend(frameon=False, fontsize=9)
    curve.grid(axis="y")
    return figure
