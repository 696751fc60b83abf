"""Measures of the bed: velocity fluctuations by layer, height, and whether it rolls (motion.py)."""

import numpy as np

from damper3d.measures.phases.motion import Motion

LOWEST = 0.05  # of the particles, about half of what a bed at rest has on its floor
LAYERS = 5  # equal numbers of particles, by their height in each frame


def flow_measures(motion: Motion) -> dict[str, float]:
    """Fluctuation of the layers at the ends over the middle's, heights, and the rolls' share."""
    fluctuation = layer_fluctuation(motion)
    low, middle, high = fluctuation[0], fluctuation[len(fluctuation) // 2], fluctuation[-1]
    gap = floor_gap(motion)
    ring, roll = ring_share(motion), roll_share(motion)
    return {
        "hot_low": float(low / middle) if middle > 0.0 else 1.0,
        "hot_high": float(high / middle) if middle > 0.0 else 1.0,
        "low_density": low_density(motion),
        "across_share": across_share(motion),
        "bed_height": float(motion.bed_height.mean() / motion.length),
        "floor_gap_least": float(gap.min() / motion.clearance),
        "floor_gap_largest": float(gap.max() / motion.clearance),
        "ring_share": ring,
        "roll_share": roll,
        "circulation": max(ring, roll),
    }


def layer_fluctuation(motion: Motion) -> np.ndarray:
    """Mean square velocity about the bed's mean, of layers from the bottom up (LAYERS,) [m2/s2]."""
    about = motion.v - motion.v.mean(axis=1, keepdims=True)
    fluctuation = (about**2).sum(axis=2)
    by_height = np.take_along_axis(fluctuation, np.argsort(motion.x[:, :, 2], axis=1), axis=1)
    mean = by_height.mean(axis=0)
    return np.array([layer.mean() for layer in np.array_split(mean, min(LAYERS, len(mean)))])


def low_density(motion: Motion) -> float:
    """Solid volume of the lowest slice over that of the fullest, slices of a mean diameter.

    Over all frames, of the spheres around the particles. About 1 for a bed on the floor; a dense
    cluster over a thin gas, the Leidenfrost effect of the literature, has far less: for this
    nothing needs to be known of how fast the particles are.
    """
    diameter = 2.0 * motion.radius.mean()
    edges = np.arange(int(np.ceil(motion.x[:, :, 2].max() / diameter)) + 2) * diameter
    # Part of a sphere below a plane at the height s of its own diameter: 3 s^2 - 2 s^3.
    low = motion.x[:, :, 2] - motion.radius
    below = []
    for edge in edges:
        s = np.clip((edge - low) / (2.0 * motion.radius), 0.0, 1.0)
        below.append(float(((3.0 - 2.0 * s) * s**2 @ motion.radius**3).sum()))
    slices = np.diff(below)
    return float(slices[0] / slices.max())


def across_share(motion: Motion) -> float:
    """Share of the energy about the mean motion that is across the direction of shaking.

    2/3 where all directions are alike.
    """
    about = motion.v - motion.v.mean(axis=1, keepdims=True)
    total = (about**2).sum()
    return float((about[:, :, :2] ** 2).sum() / total) if total > 0.0 else 0.0


def floor_gap(motion: Motion) -> np.ndarray:
    """Height over the lower end below which LOWEST of the particles are (F,) [m].

    Of their lowest points; not of the lowest particle, since a few never follow the bed.
    """
    return np.quantile(motion.x[:, :, 2] - motion.radius, LOWEST, axis=1)


def transport(motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Mean positions about their centre; displacements over all whole cycles, less their mean."""
    cycles = (len(motion.x) - 1) // motion.n
    whole = motion.x[: cycles * motion.n + 1]
    moved, position = whole[-1] - whole[0], whole.mean(axis=0)
    return position - position.mean(axis=0), moved - moved.mean(axis=0)


def roll_share(motion: Motion) -> float:
    """Share of the transport's energy that one roll about a line across the motion explains.

    The transport regressed on the rotation e x r about the centre, e the line of its moment.
    """
    position, moved = transport(motion)
    moment = np.cross(position, moved).sum(axis=0)[:2]
    size = np.linalg.norm(moment)
    if size == 0.0:
        return 0.0
    line = np.array([*(moment / size), 0.0])
    return _explained(np.cross(line, position), moved)


def ring_share(motion: Motion) -> float:
    """Share of the transport's energy that a ring-shaped roll about the axis explains.

    Up in the middle and down at the side, or the reverse: regressed on (-(z - z0), r - r0) in
    every half-plane through the axis, about the mean radius and height.
    """
    position, moved = transport(motion)
    r = np.hypot(position[:, 0], position[:, 1])
    outwards = np.divide(
        position[:, :2], r[:, None], out=np.zeros((len(r), 2)), where=r[:, None] > 0
    )
    field = np.column_stack([-position[:, 2:3] * outwards, r - r.mean()])
    return _explained(field, moved)


def _explained(field: np.ndarray, moved: np.ndarray) -> float:
    """Share of sum |moved|^2 along a field (N, 3), by regression."""
    total, size = (moved**2).sum(), (field**2).sum()
    return float((moved * field).sum() ** 2 / (size * total)) if size > 0.0 and total > 0.0 else 0.0
