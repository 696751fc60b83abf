"""Packing fraction and velocity in the flow: coarse-grained particles, mean over a time window.

    rho(r) = sum m phi(r - x),   p(r) = sum m v phi(r - x),   V = <p>/<rho>

over the particles in the silo (centroid above the outlet); <> is the mean over the frames while a
tenth to a half of the particles that leave were out. The integral of rho over the plane is their
mass and that of p their momentum, exactly; rho and p obey d(rho)/dt + div p = 0 but for particles
that pass the outlet.

At walls a part of each kernel lies outside. rho and p keep it (so they conserve); the packing
fraction, sum A phi(r - x) over the part of phi(r - .) that lies inside the silo, does not miss
it: a uniform field is uniform up to the walls. In V = <p>/<rho> it cancels. The silo goes on
upwards beyond its open top and ends at the outlet. Dead zones: see basics/dead_zones.py.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from granulab.campaign.output.figure import BLUE, GREEN, GREY, ORANGE, headline
from granulab.errors import FolderError, InputError
from silo2d.measures.basics.coarse_graining import (
    Grid,
    draw_map,
    grid_round,
    inside_edges,
    inside_mask,
    part_inside,
)
from silo2d.measures.basics.contacts import flowing
from silo2d.measures.basics.dead_zones import (
    DeadZones,
    area_of_silo,
    draw_dead_zones,
    filled,
    standing,
)
from silo2d.measures.basics.particles import beside
from silo2d.view.scene import Scene, read_scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

HEIGHTS = 0.2, 0.4, 0.6  # of the profiles, over the fill level
_LEAST_DENSITY = 0.02  # of the largest: where there is less, no velocity is given
_LEAST_DRAWN = 0.1  # packing fraction for a velocity in the picture


@dataclass(frozen=True, eq=False)
class FlowField:
    """Means over frames, on a grid.

    density     (j, i) [kg/m2]
    momentum    (2, j, i) [kg/(m s)]
    solid       (j, i) area of particles over area of the silo's inside [-]
    frames      (f,) over which the mean is
    """

    grid: Grid
    density: Floats
    momentum: Floats
    solid: Floats
    frames: NDArray[np.int64]

    @property
    def velocity(self) -> Floats:
        """(2, j, i) [m/s]; NaN where there is next to nothing."""
        some = self.density > _LEAST_DENSITY * self.density.max()
        return np.where(some, self.momentum / np.where(some, self.density, 1.0), np.nan)


def field_of(scene: Scene, frames: NDArray[np.int64], width: float | None = None) -> FlowField:
    """Mean fields of some frames, on a grid over the silo and six widths round it.

    width of the Gaussian [m]; one typical particle size (root of the mean area) unless given.
    """
    edges = inside_edges(scene)
    ends = edges.min(axis=(0, 1)), edges.max(axis=(0, 1))
    grid = grid_round(*ends, width or scene.particle_size)
    size = scene.areas
    sums = np.zeros((4, len(grid.y), len(grid.x)))
    for frame in frames:
        which = in_silo(scene, frame)
        position, velocity = _vectors(scene, frame, which, "x", "y", "vx", "vy")
        mass = scene.trajectory.static["mass"][which, None]
        sums += grid.deposit(position, np.hstack([mass, mass * velocity, size[which, None]]))
    sums /= len(frames)
    part = part_inside(grid, edges)
    solid = np.where(inside_mask(edges, grid), sums[3] / np.maximum(part, 0.05), np.nan)
    return FlowField(grid, sums[0], sums[1:3], solid, frames)


def in_silo(scene: Scene, frame: int) -> NDArray[np.bool_]:
    """Particles with their centroid above the outlet, and not beside the silo (n,)."""
    x, y = (scene.trajectory[key][frame] for key in ("x", "y"))
    return scene.trajectory["inside"][frame] & (y >= 0) & ~beside(scene, x, y)


def _vectors(scene: Scene, frame: int, which: NDArray, *keys: str) -> tuple[Floats, Floats]:
    columns = [scene.trajectory[key][frame][which].astype(np.float64) for key in keys]
    return np.column_stack(columns[:2]), np.column_stack(columns[2:])


def flow_frames(scene: Scene, between: tuple[float, float] | None = None) -> NDArray[np.int64]:
    """Frames of a window of time [s], or while a tenth to a half of the leavers were out (f,)."""
    first, last = between or flowing(scene)
    frames = np.flatnonzero((scene.time >= first) & (scene.time <= last))
    if between and not len(frames):
        raise InputError(
            f"between {first:g} s and {last:g} s: no frame; the run has them from 0 to "
            f"{scene.time[-1]:.3g} s"
        )
    if not len(frames):
        raise FolderError("no frame while the silo flowed; keep more with [output] frame_interval")
    return frames


def profile(field: FlowField, height: float) -> tuple[Floats, Floats]:
    """Vertical velocity [m/s] and momentum density [kg/(m s)] over x at a height [m]."""
    j = int(np.abs(field.grid.y - height).argmin())
    return field.velocity[1, j], field.momentum[1, j]


def dead_zones(scene: Scene, field: FlowField) -> DeadZones:
    """Dead zones of the flow."""
    _, middle, _ = _heights(scene)
    mass_flow = max(-float(profile(field, middle)[1].sum()) * _step(field), 0.0)
    speed, filling = np.hypot(*field.velocity), filled(field.solid)
    density = float(np.median(field.density[filling]))
    return standing(scene, field.grid, field.solid, speed, mass_flow, density)


def left_zones(scene: Scene, field: FlowField) -> DeadZones | None:
    """Zones that the last frame still fills; None for a run that did not come to its end."""
    if scene.summary.get("outcome") not in ("empty", "dead_zones"):
        return None
    whole = area_of_silo(scene, field.grid)
    end = len(scene.time) - 1
    if not in_silo(scene, end).any():
        none = np.zeros_like(field.density, bool)
        return DeadZones(field.grid, none, none, whole)
    last = filled(field_of(scene, np.array([end])).solid)
    return DeadZones(field.grid, last, ~last, whole)


def _step(field: FlowField) -> float:
    return float(field.grid.x[1] - field.grid.x[0])


def measure(folder: Path, between: tuple[float, float] | None = None) -> dict[str, Any]:
    """Numbers, profiles and fields of the flow.

    between: from and until [s], taken in place of the usual part of the flow.

    width_m                       of the Gaussian
    from_s, until_s, frames       the window
    mass_in_silo_kg               integral of the density over the plane, mean over the window
    bulk_fraction                 mean packing fraction between the lowest and highest profile,
                                  where 0.99 of the kernel is inside, of what is filled
    dead_area_m2, dead_share      dead zones in the flow, and over the silo below the fill level
    left_area_m2, left_share      what is filled at the end of a run that emptied or left dead zones
    profiles                      for each height: height_m, x_m, velocity_m_per_s (downwards is
                                  negative; None outside), mass_flow_kg_per_s through it
    fields                        x_m, y_m, packing fraction, velocity_x, velocity_y, dead (j, i)

    Raises InputError for a run of which fewer than twenty particles left, without a window.
    """
    scene = read_scene(folder)
    field = field_of(scene, flow_frames(scene, between))
    dead, left = dead_zones(scene, field), left_zones(scene, field)
    grid, time = field.grid, scene.time[field.frames]
    names = {"packing_fraction": field.solid, "velocity_x": field.velocity[0],
             "velocity_y": field.velocity[1]}  # fmt: skip
    return {
        "width_m": grid.width,
        "from_s": float(time[0]),
        "until_s": float(time[-1]),
        "frames": len(field.frames),
        "mass_in_silo_kg": float(grid.integral(field.density)),
        "bulk_fraction": _bulk_fraction(scene, field),
        "dead_area_m2": dead.area,
        "dead_share": dead.share,
        "left_area_m2": None if left is None else left.area,
        "left_share": None if left is None else left.share,
        "profiles": [_profile_numbers(scene, field, height) for height in _heights(scene)],
        "fields": {
            "x_m": grid.x.tolist(),
            "y_m": grid.y.tolist(),
            **{name: _listed(values) for name, values in names.items()},
            "dead": dead.dead.astype(int).tolist(),
        },
    }


def _heights(scene: Scene) -> list[float]:
    return [part * float(scene.trajectory.attributes["level"]) for part in HEIGHTS]


def _bulk_fraction(scene: Scene, field: FlowField) -> float | None:
    low, *_, high = _heights(scene)
    part = part_inside(field.grid, inside_edges(scene))
    level = (field.grid.y >= low) & (field.grid.y <= high)
    bulk = field.solid[(part > 0.99) & level[:, None] & filled(field.solid)]
    return float(bulk.mean()) if len(bulk) else None


def _profile_numbers(scene: Scene, field: FlowField, height: float) -> dict[str, Any]:
    velocity, momentum = profile(field, height)
    inside = _inside_at(scene, field, height)
    return {
        "height_m": height,
        "x_m": field.grid.x.tolist(),
        "velocity_m_per_s": _listed(np.where(inside, velocity, np.nan)),
        "mass_flow_kg_per_s": float(-momentum.sum() * _step(field)),
    }


def _inside_at(scene: Scene, field: FlowField, height: float) -> NDArray[np.bool_]:
    j = int(np.abs(field.grid.y - height).argmin())
    return inside_mask(inside_edges(scene), field.grid)[j]


def _listed(values: Floats) -> list[Any]:
    """Lists for JSON, None where there is no number."""
    rounded = np.round(values, 6).astype(object)
    rounded[~np.isfinite(values)] = None
    return rounded.tolist()


def draw(folder: Path, between: tuple[float, float] | None = None) -> "Figure":
    """Maps of packing fraction, speed and dead zones, and profiles of the vertical velocity."""
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    scene = read_scene(folder)
    field = field_of(scene, flow_frames(scene, between))
    time = scene.time[field.frames]
    figure = Figure(figsize=(17, 5.8), layout=ConstrainedLayoutEngine(w_pad=0.15))
    headline(figure, f"{scene.headline}; mean from {time[0]:.2f} to {time[-1]:.2f} s")
    solid, speed, zones, lines = figure.subplots(1, 4, width_ratios=[1, 1, 0.8, 1.1])
    fraction = _filled(field.solid)
    draw_map(solid, scene, field.grid, fraction, "packing fraction",
             cmap="YlOrBr", vmin=0.4, vmax=0.95)  # fmt: skip
    magnitude = np.hypot(*field.velocity)
    inside = inside_mask(inside_edges(scene), field.grid) & (field.solid > _LEAST_DRAWN)
    shown = np.where(fraction > _LEAST_DRAWN, magnitude, np.nan)
    draw_map(speed, scene, field.grid, shown, "speed [m/s]",
             cmap="YlGnBu", vmin=0, vmax=magnitude[inside].max())  # fmt: skip
    _arrows(speed, field, inside)
    draw_dead_zones(zones, scene, dead_zones(scene, field), left_zones(scene, field))
    _draw_profiles(lines, scene, field)
    return figure


def _filled(values: Floats) -> Floats:
    """Points outside the silo with the nearest value inside, so that colours reach the walls."""
    from scipy.ndimage import distance_transform_edt

    nearest = distance_transform_edt(np.isnan(values), return_distances=False, return_indices=True)
    return values[tuple(nearest)]


def _arrows(axes: "Axes", field: FlowField, inside: NDArray[np.bool_]) -> None:
    step = 4
    chosen = inside[::step, ::step] & np.isfinite(field.velocity[0, ::step, ::step])
    x, y = np.meshgrid(field.grid.x[::step], field.grid.y[::step])
    u, v = field.velocity[:, ::step, ::step]
    axes.quiver(x[chosen], y[chosen], u[chosen], v[chosen], color="#2b2b2b", width=4e-3)


def _draw_profiles(axes: "Axes", scene: Scene, field: FlowField) -> None:
    for height, colour in zip(_heights(scene), (BLUE, GREEN, ORANGE), strict=True):
        velocity, _ = profile(field, height)
        inside = _inside_at(scene, field, height)
        axes.plot(field.grid.x[inside], velocity[inside], color=colour,
                  label=f"{1e3 * height:.0f} mm over the outlet")  # fmt: skip
    axes.axhline(0, color=GREY, lw=0.6)
    axes.set(xlabel="x [m]", ylabel="vertical velocity [m/s]")
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1))
