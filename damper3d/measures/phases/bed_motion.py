"""Measures of the bed as a whole: its collisions with the two ends, its height, what it moves like.

All are without dimension; C cycles of S samples (motion.py).
"""

import numpy as np

from damper3d.measures.phases.motion import Motion

BURST = 0.15  # of a cycle: the time over which a collision's share of the impulse is taken


def bed_measures(motion: Motion) -> dict[str, float | None]:
    """Impulses of the ends on the bed, its stroke and its coherence."""
    impulse = end_impulses(motion)  # (C, 2)
    low, high = impulse.mean(axis=0)
    return {
        "low_impulse": float(low),
        "high_impulse": float(high),
        "low_burst": burst(motion.push[:, :, 0]),
        "high_burst": burst(motion.push[:, :, 1]),
        "low_phase_deg": collision_phase(motion.push[:, :, 0]),
        "high_phase_deg": collision_phase(motion.push[:, :, 1]),
        "contrast": contrast(impulse[:, 0]),
        "stroke": stroke(motion),
        "coherence": coherence(motion),
        "slip_energy": slip_energy(motion),
    }


def end_impulses(motion: Motion) -> np.ndarray:
    """Impulse of each end on the bed in each cycle, over 2 M V (C, 2).

    A bed that arrives with the enclosure's largest velocity V, against it, and leaves with it
    takes 2 M V: the ideal collision of eq. 6.10. What carries the weight for a cycle is pi / Gamma
    in these units, for one sine.
    """
    sample = motion.period / motion.push.shape[1]
    return motion.push.sum(axis=1) * sample / (2.0 * motion.mass.sum() * motion.peak_speed)


def burst(push: np.ndarray) -> float | None:
    """Share of the impulse that falls in the BURST of each cycle with most of it; mean over cycles.

    `push` (C, S). BURST for an even push, 1 for a sharp collision; None where nothing pushes.
    """
    struck = push[push.sum(axis=1) > 0.0]
    if len(struck) == 0:
        return None
    width = max(1, round(BURST * push.shape[1]))
    # Round the cycle, since a collision may lie across its end.
    sums = np.cumsum(np.pad(np.hstack([struck, struck[:, :width]]), ((0, 0), (1, 0))), axis=1)
    return float(np.mean((sums[:, width:] - sums[:, :-width]).max(axis=1) / struck.sum(axis=1)))


def collision_phase(push: np.ndarray) -> float | None:
    """Phase of the cycle at the centre of the impulse [deg, 0 to 360]; 0: u = 0, moving up."""
    angle = 2.0 * np.pi * (np.arange(push.shape[1]) + 0.5) / push.shape[1]
    centre = push.sum(axis=0) @ np.exp(1j * angle)
    return float(np.degrees(np.angle(centre)) % 360.0) if abs(centre) > 0.0 else None


def contrast(impulse: np.ndarray) -> float:
    """Mean of |b - a| / (b + a) over impulses a, b of cycles that follow each other.

    0: every cycle alike, or but one cycle; 1/3: one collision twice as strong as the next; 1: one
    in two cycles.
    """
    if len(impulse) < 2:
        return 0.0
    a, b = np.maximum(impulse[:-1], 0.0), np.maximum(impulse[1:], 0.0)
    both = a + b
    return float(np.mean(np.divide(np.abs(b - a), both, out=np.zeros_like(a), where=both > 0)))


def stroke(motion: Motion) -> float:
    """Travel of the bed's mass to and fro in a cycle, over the clearance; mean over cycles."""
    return float(np.mean(np.ptp(motion.bed_height, axis=1)) / motion.clearance)


def coherence(motion: Motion) -> float:
    """Share of the particles' kinetic energy that is in their mean motion, in the laboratory."""
    mean = np.einsum("fnk,n->fk", motion.v, motion.mass) / motion.mass.sum()
    total = np.einsum("fnk,fnk,n->", motion.v, motion.v, motion.mass)
    return float((mean**2).sum() * motion.mass.sum() / total) if total > 0.0 else 1.0


def slip_energy(motion: Motion) -> float:
    """Kinetic energy relative to the enclosure over that of the same mass moving with it."""
    relative = motion.v - motion.frame_speed[:, None, None] * np.array([0.0, 0.0, 1.0])
    slipping = np.einsum("fnk,fnk,n->", relative, relative, motion.mass)
    return float(slipping / ((motion.frame_speed**2).sum() * motion.mass.sum()))
