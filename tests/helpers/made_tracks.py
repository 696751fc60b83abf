"""Tracks of a bouncing object of known truth: exact flights, then noise and what goes wrong."""

from dataclasses import dataclass

import numpy as np

from calibration.tracking.track import Track


@dataclass(frozen=True)
class Made:
    """A made track and the truth behind it; times in frames, lengths in px, y downwards."""

    track: Track
    contacts: np.ndarray  # (n,)
    restitution: np.ndarray  # (n,)
    speeds: np.ndarray  # (n,) before each contact [px/frame]
    acceleration: float  # [px/frame^2]


def made_track(
    restitution,
    *,
    drop=500.0,
    fall_frames=40.3,
    held=12.6,
    noise=0.1,
    seed=1,
    upwards=False,
    drift=0.0,
):
    """An object held, let go, and bouncing with the restitution of each contact in turn.

    drop          height of the fall [px], which takes fall_frames
    drift         how far the plate moves along y while the clip lasts [px], at a steady rate
    """
    a = 2 * drop / fall_frames**2
    speed, contact = a * fall_frames, held + fall_frames
    contacts, speeds, starts = [], [], []
    for e in restitution:
        contacts.append(contact)
        speeds.append(speed)
        speed *= e
        starts.append(speed)
        contact += 2 * speed / a
    frame = np.arange(np.floor(contact))
    y = 0.5 * a * np.clip(frame - held, 0, None) ** 2
    for t0, v in zip(contacts, starts, strict=True):
        s = frame - t0
        y = np.where(s >= 0, drop - v * s + 0.5 * a * s**2, y)
    rng = np.random.default_rng(seed)
    y = y + drift * frame / frame[-1] + rng.normal(0, noise, len(frame))
    x = 100 + 0.5 * frame + rng.normal(0, noise, len(frame))
    track = Track(frame, x, -y if upwards else y)
    return Made(track, np.array(contacts), np.array(restitution), np.array(speeds), a)
