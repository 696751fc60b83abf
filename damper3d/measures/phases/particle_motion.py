"""Measures of the particles: which are carried, which part and return, which travel; free paths.

All are without dimension; F frames of N particles, n frames a cycle (motion.py). Shares are of the
particles, and which particle counts is decided over all counted cycles together.
"""

import numpy as np

from damper3d.measures.phases.motion import Motion

SEEN = 0.1  # share of the energy below which a motion is taken as absent
DEEP = 0.2  # of the particles: the layers "near the contact with the enclosure" (sec. 6.4.3.4)
LOOKS = 10  # a cycle
RETURNED = 0.5  # who ends a cycle nearer than half of its farthest has returned
NEAR = 1.2  # neighbours: centres nearer than this many sums of the radii
# Free flight changes a velocity by g t alone. The tolerance, in units of the enclosure's largest
# speed, is above rounding in single precision and below any impact that could be noticed.
FREE = 1e-3


def particle_measures(motion: Motion) -> dict[str, float | None]:
    """Shares of carried, agitated and travelling particles, neighbours kept, paths between hits."""
    agitation, kept = neighbour_motion(motion)
    hits, free = hits_and_flight(motion)
    travelled = travel(motion)
    moves, returns = agitation >= SEEN, travelled <= RETURNED
    carried, deep = carried_energy(motion) < SEEN, deepest(motion)
    diameter = 2.0 * motion.radius.mean()
    return {
        "carried_share": float(np.mean(carried)),
        "deep_carried_share": None if deep is None else float(np.mean(carried[deep])),
        "agitated_share": float(np.mean(moves)),
        "fluidised_share": float(np.mean(moves & returns)),
        "convecting_share": float(np.mean(moves & ~returns)),
        "agitation": float(np.median(agitation)),
        "travelling_share": float(np.mean(~returns)),
        "travel": float(np.median(travelled)),
        "packed_share": packed_share(motion),
        "neighbours_kept": kept,
        "cycle_displacement": float(np.sqrt(cycle_msd(motion)) / diameter),
        "flight_share": free,
        "free_path": float(paths(motion) / max(hits, 1) / diameter),
    }


def carried_energy(motion: Motion) -> np.ndarray:
    """Mean square velocity of each particle against the enclosure over the latter's own (N,)."""
    relative = motion.v.copy()
    relative[:, :, 2] -= motion.frame_speed[:, None]
    return (relative**2).sum(axis=2).mean(axis=0) / (motion.frame_speed**2).mean()


def deepest(motion: Motion) -> np.ndarray | None:
    """The fifth of the particles that lies deepest along gravity (n,), or None without gravity."""
    if not motion.gravity.any():
        return None
    depth = motion.x.mean(axis=0) @ motion.gravity
    return np.argsort(depth)[-max(1, round(DEEP * len(depth))) :]


def neighbour_motion(motion: Motion) -> tuple[np.ndarray, float | None]:
    """Motion of neighbours against each other, and the share that stay neighbours over a cycle.

    Looked at LOOKS times a cycle, which is enough for a mean and costs less than every frame.

    First, of each particle, |v_i - v_j|^2 / 2 over its neighbours j and all looks, over the
    enclosure's mean square velocity (N,): for particles that move independently this is the mean
    square of their own velocities. Who has no neighbour in a frame is measured against the mean
    velocity of all. Second, the share of the pairs of a frame that are neighbours again one
    cycle later (None where nobody ever has a neighbour).
    """
    n_particles, n_frames = motion.x.shape[1], len(motion.x)
    energy, kept, had = np.zeros(n_particles), 0, 0
    looks = range(0, n_frames, max(1, motion.n // LOOKS))
    for k in looks:
        i, j = near_pairs(motion.x[k] + motion.cell, motion.radius)
        against = 0.5 * ((motion.v[k, i] - motion.v[k, j]) ** 2).sum(axis=1)
        both, weights = np.concatenate([i, j]), np.concatenate([against, against])
        count = np.bincount(both, minlength=n_particles)
        alone = ((motion.v[k] - motion.v[k].mean(axis=0)) ** 2).sum(axis=1)
        total = np.bincount(both, weights, n_particles)
        energy += np.where(count > 0, total / np.maximum(count, 1), alone)
        if k + motion.n < n_frames:
            later = motion.x[k + motion.n]
            apart = np.linalg.norm(later[i] - later[j], axis=1)
            kept += int(np.sum(apart < NEAR * (motion.radius[i] + motion.radius[j])))
            had += len(i)
    energy /= len(looks) * (motion.frame_speed**2).mean()
    return energy, (kept / had if had else None)


def near_pairs(x: np.ndarray, radius: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of particles whose centres are nearer than NEAR sums of their radii."""
    from scipy.spatial import cKDTree

    pairs = cKDTree(x).query_pairs(2.0 * NEAR * radius.max(), output_type="ndarray")
    i, j = pairs[:, 0], pairs[:, 1]
    near = np.linalg.norm(x[i] - x[j], axis=1) < NEAR * (radius[i] + radius[j])
    return i[near], j[near]


def travel(motion: Motion) -> np.ndarray:
    """Displacement of each particle in a cycle over the farthest from its start (N,).

    Both are distances in the laboratory, the second the largest within the cycle, averaged over
    the cycles that start at every frame. 0: it comes back as the enclosure does; 1: it goes on.
    In the laboratory, since a cloud at rest there goes to and fro for whoever moves with the
    enclosure.
    """
    x = motion.x.copy()
    x[:, :, 2] += motion.displacement[:, None]
    net, farthest = np.zeros(x.shape[1]), np.zeros(x.shape[1])
    for k in range(len(x) - motion.n):
        away = ((x[k + 1 : k + motion.n + 1] - x[k]) ** 2).sum(axis=2)
        net += np.sqrt(away[-1])
        farthest += np.sqrt(away.max(axis=0))
    return np.divide(net, farthest, out=np.zeros_like(net), where=farthest > 0.0)


def packed_share(motion: Motion) -> float:
    """Share of the particles in contact in the frame of a cycle with most; mean over cycles.

    A bed that comes together once a cycle has most of its particles in contact then.
    """
    whole = motion.touching[-(len(motion.touching) // motion.n) * motion.n :]
    return float(whole.reshape(-1, motion.n).max(axis=1).mean())


def cycle_msd(motion: Motion) -> float:
    """Mean square displacement over a cycle, less the bed's own [m2]."""
    step = motion.x[motion.n :] - motion.x[: -motion.n]
    step = step - step.mean(axis=1, keepdims=True)
    return float((step**2).sum(axis=2).mean())


def hits_and_flight(motion: Motion) -> tuple[int, float]:
    """Times between frames in which a particle touched anything, and the share in which it did not.

    Seen from velocities that change by more than gravity explains, so that no impact is too short.
    """
    time = motion.period / motion.n
    change = np.diff(motion.v, axis=0) - motion.gravity * time
    touched = np.linalg.norm(change, axis=2) > FREE * motion.peak_speed
    return int(touched.sum()), float(1.0 - touched.mean())


def paths(motion: Motion) -> float:
    """Length that all particles went, relative to the bed's mean, from first to last frame [m]."""
    step = np.diff(motion.x, axis=0)
    step -= step.mean(axis=1, keepdims=True)
    return float(np.linalg.norm(step, axis=2).sum())
