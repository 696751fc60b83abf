"""True velocities of a rendered discharge: how the film's material moves between two pictures.

A point of a particle at r from its centre c moves with it, rotation included; midway between
pictures

    v = (c(t + dt) - c(t) + 2 sin(dphi/2) (-r_y, r_x))/dt,   dphi = phi(t + dt) - phi(t)

A window's velocity is the mean over the area of particles in it, an interval's the mean over its
pairs of pictures in which particles cover half of the window at least, as PIV wants it.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibration.flow.velocity import VelocityField
from calibration.rendered.flow import Stage, poses_at

Floats = NDArray[np.float64]

_COVERED = 0.5  # of a window


class TrueField(NamedTuple):
    """At the points of a measured field (ny, nx); NaN where no particles are.

    vx, vy    m/s, y upwards
    strain    Frobenius norm of the velocity's gradient, by differences on the grid [1/s]
    wall      from a window's middle to the nearest wall [m]
    """

    vx: Floats
    vy: Floats
    strain: Floats
    wall: Floats


def true_field(stage: Stage, times: Floats, field: VelocityField) -> TrueField:
    """True field of the film; `times` of its pictures [s of the run].

    Windows overlap by half, so that their side is twice the grid's step.
    """
    left, side = stage.scene.window[0], 2 * float(field.x[1] - field.x[0])
    points = np.stack(np.meshgrid(field.x + left, field.y), axis=-1)
    middle = (times[:-1] + times[1:]) / 2
    pairs = np.flatnonzero((middle >= field.start) & (middle < field.end))
    found = np.array([_of_pair(stage, times[k], times[k + 1], points, side) for k in pairs])
    known = np.isfinite(found)
    count = known.sum(axis=0)
    mean = np.where(known, found, 0.0).sum(axis=0) / np.where(count > 0, count, np.nan)
    slopes = [np.gradient(mean[..., part], field.y, field.x) for part in (0, 1)]
    strain = np.sqrt(np.square(slopes).sum(axis=(0, 1)))
    return TrueField(mean[..., 0], mean[..., 1], strain, _to_walls(points, stage.scene.walls))


def _of_pair(stage: Stage, first: float, second: float, points: Floats, side: float) -> Floats:
    """Mean velocities (..., 2) [m/s] of windows about points (..., 2) [m]; NaN for few."""
    import cv2

    shown, velocity = _pixels(stage, first, second)
    finer = shown.shape[0] / stage.height
    at = (stage.pixels(points) * finer - 0.5).astype(np.float32)
    across, down = np.ascontiguousarray(at[..., 0]), np.ascontiguousarray(at[..., 1])
    size = round(side / stage.look.scale * finer)

    def mean(picture: Floats) -> Floats:
        means = cv2.boxFilter(picture.astype(np.float32), -1, (size, size))
        return np.asarray(cv2.remap(means, across, down, cv2.INTER_LINEAR), np.float64)

    share = mean(shown)
    covered = np.where(share > _COVERED, share, np.nan)
    return np.stack([mean(part) / covered for part in velocity], axis=-1)


def _pixels(stage: Stage, first: float, second: float) -> tuple[Floats, Floats]:
    """1 where a fine pixel (h, w) shows a particle, and its velocity (2, h, w) [m/s]; else 0."""
    midway = poses_at(stage.scene, (first + second) / 2)
    before, after = (np.full((3, stage.scene.n_particles), np.nan) for _ in range(2))
    for where, time in ((before, first), (after, second)):
        poses = poses_at(stage.scene, time)
        where[:, poses.which] = poses.x, poses.y, poses.angle
    step = (after - before)[:, midway.which]
    index = stage.index(midway)
    row, column = np.nonzero((index >= 0) & np.isfinite(step[0])[index])
    k = index[row, column]
    fine = stage.look.scale * stage.height / index.shape[0]
    rx = stage.left + (column + 0.5) * fine - midway.x[k]
    ry = stage.top - (row + 0.5) * fine - midway.y[k]
    rotation = 2 * np.sin(step[2, k] / 2)
    shown, velocity = np.zeros(index.shape), np.zeros((2, *index.shape))
    shown[row, column] = 1.0
    velocity[0, row, column] = (step[0, k] - rotation * ry) / (second - first)
    velocity[1, row, column] = (step[1, k] + rotation * rx) / (second - first)
    return shown, velocity


def _to_walls(points: Floats, walls: Floats) -> Floats:
    """Distances (...) of points (..., 2) to the nearest of the segments (n, 2, 2)."""
    out = np.full(points.shape[:-1], np.inf)
    for start, end in walls:
        along = end - start
        part = np.clip((points - start) @ along / (along @ along), 0.0, 1.0)
        out = np.minimum(out, np.linalg.norm(points - start - part[..., None] * along, axis=-1))
    return out
