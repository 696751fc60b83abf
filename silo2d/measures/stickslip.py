"""Stick and slip at the walls: particles that touch a wall, and how fast they slide along it.

A particle touches a wall where its outline comes within 0.1 mm of it: outlines are stored with five
points on each rounded corner, which is right to 0.02 mm. Its sliding velocity is that of the point
of its outline nearest to the wall, v + w x r, w its angular velocity, along the wall, positive
downwards (on a level floor: towards the outlet). It sticks where that is below 10 mm/s, a tenth of
a millimetre a frame, and slips otherwise. Both numbers are arguments.

An event is a row of frames in which a touching particle only sticks, or only slips. Those that a
frame of the other state bounds at both ends are complete, and have a duration (frames times the
frame interval); the others began or ended with the contact or the window. What changes faster than
the frames is not seen. The same count from every second frame shows how much that matters: where it
is about half, the events are shorter than the frames resolve, and their number and duration say
more about the frames than about the flow. The sticking fraction does not suffer from that.

The window is from the first frame after the opening to the last particle that leaves.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from granulab.campaign.output.figure import VERMILION, headline
from granulab.errors import InputError
from silo2d.measures.basics.particles import Series, outlet_centre
from silo2d.view.scene import Scene, read_scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

GAP = 1e-4  # m
THRESHOLD = 0.01  # m/s


@dataclass(frozen=True)
class Sliding:
    """Sliding of what touches one wall in the frames of the window.

    time        of the frames (F,) [s]
    speed       along the wall (F, n) [m/s], NaN where a particle does not touch it
    position       along the wall from its lower end (F, n) [m], NaN likewise
    """

    time: Series
    speed: Series
    position: Series


def sliding(scene: Scene, gap: float = GAP) -> dict[str, Sliding]:
    """Sliding along each wall but the door, by the wall's name."""
    frames = _frames(scene)
    shape = len(scene.walls), len(frames), scene.n_particles
    speed, position = np.full(shape, np.nan), np.full(shape, np.nan)
    lower, along = _downwards(scene)
    for f, frame in enumerate(frames):
        for particles, outlines in scene.outlines(int(frame)):
            for w in range(len(scene.walls)):
                near, at = _touching(outlines, lower[w], along[w], scene.walls[w], gap)
                which = particles[near]
                speed[w, f, which] = _speed(scene, int(frame), which, at) @ along[w]
                position[w, f, which] = (lower[w] - at) @ along[w]
    time = scene.time[frames]
    names = scene.wall_names[: len(scene.walls)]
    return {name: Sliding(time, speed[w], position[w]) for w, name in enumerate(names)}


def _frames(scene: Scene) -> NDArray[np.int64]:
    """Frames after the opening (where nothing has moved) until the last particle leaves."""
    left = scene.trajectory["out_time"][-1]
    end = np.nanmax(left) if np.isfinite(left).any() else scene.time[-1]
    return np.flatnonzero((scene.time > 0) & (scene.time <= end))


def _downwards(scene: Scene) -> tuple[Series, Series]:
    """End of each wall that particles slide to (w, 2) [m] and the unit vector to it (w, 2)."""
    first, second = scene.walls[:, 0], scene.walls[:, 1]
    to_outlet = np.abs(first[:, 0] - outlet_centre(scene)) < np.abs(
        second[:, 0] - outlet_centre(scene)
    )
    level = first[:, 1] == second[:, 1]
    swap = np.where(level, to_outlet, first[:, 1] < second[:, 1])[:, None]
    lower, upper = np.where(swap, first, second), np.where(swap, second, first)
    return lower, (lower - upper) / np.hypot(*(lower - upper).T)[:, None]


def _touching(
    outlines: Series, lower: Series, along: Series, wall: Series, gap: float
) -> tuple[NDArray[np.bool_], Series]:
    """Mask of the outlines (k, p, 2) that touch a wall, their nearest points (m, 2) [m]."""
    span = wall[1] - wall[0]
    length = float(np.hypot(*span))
    inwards = np.array([-span[1], span[0]]) / length  # the inside is on the left
    distance = (outlines - wall[0]) @ inwards
    # Half through a wall is no contact: it lies behind an insert or round a corner.
    through = distance.min(axis=1) < -0.5 * np.ptp(distance, axis=1)
    before_end = (lower - outlines) @ along
    distance[(before_end < 0) | (before_end > length)] = np.inf
    nearest = distance.argmin(axis=1)
    rows = np.arange(len(outlines))
    near = (distance[rows, nearest] <= gap) & ~through
    return near, outlines[rows, nearest][near]


def _speed(scene: Scene, frame: int, which: NDArray[np.int64], at: Series) -> Series:
    """Velocity (m, 2) [m/s] of points at (m, 2) [m] that belong to particles (m,)."""
    x, y, vx, vy, omega = (
        scene.trajectory[key][frame][which].astype(float) for key in ("x", "y", "vx", "vy", "spin")
    )
    return np.stack([vx - omega * (at[:, 1] - y), vy + omega * (at[:, 0] - x)], axis=1)


def states(speed: Series, threshold: float) -> NDArray[np.int64]:
    """0 where a particle does not touch, 1 where it sticks, 2 where it slips (F, n)."""
    slow = np.abs(np.nan_to_num(speed)) < threshold
    return np.where(np.isnan(speed), 0, np.where(slow, 1, 2))


def events(state: NDArray[np.int64], kind: int) -> tuple[NDArray, NDArray[np.bool_]]:
    """Start frame, particle, length in frames (m, 3) of rows of one state; which are complete."""
    padded = np.zeros((state.shape[0] + 2, state.shape[1]), dtype=np.int64)
    padded[1:-1] = state
    edges = np.diff((padded == kind).astype(np.int64), axis=0)
    # Of the transpose: the rows of each particle in their order, so that starts and ends pair up.
    particle, start = np.nonzero(edges.T == 1)
    _, end = np.nonzero(edges.T == -1)
    other = 3 - kind
    complete = (padded[start, particle] == other) & (padded[end + 1, particle] == other)
    return np.stack([start, particle, end - start], axis=1), complete


def measure(folder: Path, threshold: float = THRESHOLD, gap: float = GAP) -> dict[str, Any]:
    """Sticking fraction, sticks and slips of each wall and of all; see the module's text.

    threshold   speed below which a particle sticks [m/s]; gap: within which it touches [m]

    Raises InputError of walls that vibrate.
    """
    scene = read_scene(folder)
    if "vibration_frequency" in scene.trajectory.attributes:
        raise InputError(
            f"{folder}: its walls vibrate: sticking is judged by velocities against walls at rest; "
            "take a run without vibration"
        )
    walls = sliding(scene, gap)
    interval = float(np.diff(scene.time[:3]).min()) if len(scene.time) > 2 else None
    both = np.concatenate([wall.speed for wall in walls.values()], axis=1)
    return {
        "threshold_m_per_s": threshold,
        "gap_m": gap,
        "frame_interval_s": interval,
        **_of(both, threshold, interval),
        "sticking_fraction_half_threshold": _fraction(both, threshold / 2),
        "sticking_fraction_twice_threshold": _fraction(both, 2 * threshold),
        "complete_sticks_from_every_second_frame": int(
            events(states(both[::2], threshold), 1)[1].sum()
        ),
        "walls": {name: _of(wall.speed, threshold, interval) for name, wall in walls.items()},
    }


def _fraction(speed: Series, threshold: float) -> float | None:
    state = states(speed, threshold)
    return float((state == 1).sum() / (state > 0).sum()) if (state > 0).any() else None


def _of(speed: Series, threshold: float, interval: float | None) -> dict[str, Any]:
    """The numbers of particles with these sliding velocities (F, n)."""
    state = states(speed, threshold)
    numbers: dict[str, Any] = {
        "touching_mean": float((state > 0).sum(axis=1).mean()) if len(state) else None,
        "sticking_fraction": _fraction(speed, threshold),
        "mean_sliding_m_per_s": float(np.nanmean(speed)) if (state > 0).any() else None,
    }
    for kind, name in ((1, "stick"), (2, "slip")):
        found, complete = events(state, kind)
        lengths = found[complete, 2]
        numbers[f"{name}s_complete"] = int(complete.sum())
        numbers[f"{name}s_cut_off"] = int((~complete).sum())
        known = interval is not None and len(lengths) > 0
        numbers[f"{name}_mean_s"] = float(lengths.mean() * interval) if known else None
        numbers[f"{name}_longest_s"] = float(lengths.max() * interval) if known else None
    return numbers


def draw(folder: Path) -> "Figure":
    """Sliding velocity over time and position at each wall; sticking has a colour of its own."""
    from matplotlib import colormaps
    from matplotlib.figure import Figure

    scene = read_scene(folder)
    walls = sliding(scene)
    figure = Figure(figsize=(9.2, 2.3 * len(walls) + 0.8), layout="constrained")
    headline(figure, scene.headline)
    panels = figure.subplots(len(walls), 1, sharex=True, squeeze=False)[:, 0]
    speeds = np.concatenate([wall.speed[np.isfinite(wall.speed)] for wall in walls.values()])
    fastest = max(float(np.quantile(speeds, 0.98)) if len(speeds) else 0.0, 2 * THRESHOLD)
    colours = colormaps["viridis"].with_extremes(under=VERMILION)
    for panel, (name, wall) in zip(panels, walls.items(), strict=True):
        seen = np.isfinite(wall.speed)
        frame, _ = np.nonzero(seen)
        points = panel.scatter(
            wall.time[frame], 1e3 * wall.position[seen], c=np.abs(wall.speed[seen]), s=5,
            marker="s", lw=0, cmap=colours, vmin=THRESHOLD, vmax=fastest,
        )  # fmt: skip
        fraction = _fraction(wall.speed, THRESHOLD)
        share = "nothing touches" if fraction is None else f"{100 * fraction:.0f} % stick"
        panel.set_title(f"{name}: {share}", loc="left", fontsize=9)
        panel.set_ylim(bottom=-0.5e3 * scene.particle_size)
    panels[-1].set_xlabel("time since the opening [s]")
    figure.supylabel("position along the wall, from its lower end [mm]", fontsize=9)
    figure.colorbar(points, ax=list(panels), extend="min", shrink=0.6,
                    label="sliding speed [m/s]; red: sticks")  # fmt: skip
    return figure
