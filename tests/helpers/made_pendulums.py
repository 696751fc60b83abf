"""Tracks of objects on strings of known truth: integrated motion, then noise."""

from dataclasses import dataclass

import numpy as np

from calibration.rendered.strings import Strings, swing
from calibration.tracking.track import Track

PLAIN = Strings()


@dataclass(frozen=True)
class Made:
    """Tracks and the truth behind them; contacts in frames."""

    tracks: list[Track]
    contacts: np.ndarray
    strings: Strings


def made(strings=PLAIN, *, rate=100.0, scale=2e-3, noise=0.1, seed=1, tilt=0.0, extra=0.3):
    """Tracks at `rate` frames/s and `scale` m/px, y downwards; tilt: of the camera, in rad.

    A camera that looks down by `tilt` sees what comes nearer lower in the picture.
    """
    motion = swing(strings)
    frame = np.arange(int((motion.contacts[-1] + extra) * rate))
    theta, tau = motion.angles(frame / rate), motion.out_of_plane(frame / rate)
    rng, length = np.random.default_rng(seed), strings.length / scale
    tracks = []
    for k, one in enumerate(theta):
        x = 150 + length * np.sin(one) * np.cos(tau) + 40 * k
        y = 20 + length * (np.cos(one) * np.cos(tau) * np.cos(tilt) + np.sin(tau) * np.sin(tilt))
        x, y = (v + rng.normal(0, noise, len(frame)) for v in (x, y))
        tracks.append(Track(frame.astype(float), x, y, name=str(k + 1)))
    return Made(tracks, motion.contacts * rate, strings)
