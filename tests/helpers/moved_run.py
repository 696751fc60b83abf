"""A run folder in which particles move as a test says: the oracle of measures of motion."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from fake_run import write_fake_run

from granulab.campaign.runs.trajectory import TrajectoryWriter, read_trajectory
from silo2d.case.outline import Outline

Points = np.ndarray  # (n, 2) [m]
# Starting places (n, 2) [m] and a time [s] -> x, y, vx, vy (4, n)
Motion = Callable[[Points, float], np.ndarray]


def write_moved_run(
    folder: Path,
    motion: Motion,
    *,
    silo: Outline | None = None,
    out_time: Callable[[Points], np.ndarray] = lambda start: np.full(len(start), np.nan),
    n_frames: int = 51,
    spacing: float = 0.012,
    spin: Callable[[Points, float], np.ndarray] = lambda start, time: np.zeros(len(start)),
) -> Points:
    """Write a finished run, frames 10 ms apart; the starting places (n, 2) [m].

    out_time    of starting places (n, 2): when each particle leaves [s], NaN for those that stay
    """
    write_fake_run(folder, silo=silo, spacing=spacing, n_frames=n_frames)
    made = read_trajectory(folder)
    start = np.column_stack([made["x"][0], made["y"][0]]).astype(float)
    leaves = out_time(start)
    writer = TrajectoryWriter(folder)
    for frame, time in enumerate(0.01 * np.arange(n_frames)):
        row = {key: array[frame] for key, array in made.frames.items()}
        moved = np.asarray(motion(start, time), dtype=np.float32)
        row |= dict(zip(("x", "y", "vx", "vy"), moved, strict=True))
        gone = leaves <= time
        row |= {
            "time": time,
            "angle": np.zeros(len(start), np.float32),
            "spin": spin(start, time).astype(np.float32),
            "inside": ~gone,
            "n_out": int(gone.sum()),
            "out_time": np.where(gone, leaves, np.nan),
        }
        writer.append(row)
    writer.finish(made.static, made.attributes)
    return start


def falling(start: Points, time: float, speed: float | np.ndarray) -> np.ndarray:
    """Particles that come straight down at a speed [m/s] each."""
    down = np.broadcast_to(speed, len(start))
    nothing = np.zeros(len(start))
    return np.array([start[:, 0], start[:, 1] - down * time, nothing, -down])
