"""measure_drop: a track of a bouncing thing to restitution, speeds and a check of scale and rate.

Free fall ties scale and rate together: g = a s f^2, a the acceleration in units of the track per
frame^2, s the scale, f the rate. With both known, g is a check; with one, it gives the other; with
none, restitution is known all the same and speeds are not.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from calibration.bounce import STANDARD_GRAVITY, Bounces, find_bounces
from calibration.quantity import metres_per_pixel
from calibration.track import Track
from calibration.track_table import read_tracks
from calibration.uncertainty import Estimate, through
from contact.quantity import InputError

_FAR = 0.05  # share by which g may miss before scale or rate is doubted


@dataclass(frozen=True)
class Drop:
    """What a drop test gives; see Bounces for the parts without scale and rate.

    rate_header   frames/s that the track's time stamps say; None without them
    rate          frames/s used; sigma 0 where it was given
    scale         m per unit of the track; sigma 0 where it was given
    gravity       from free fall, where scale and rate are both known [m/s2]
    remarks       on the time base
    """

    bounces: Bounces
    rate_header: float | None
    rate: Estimate | None
    scale: Estimate | None
    gravity: Estimate | None
    remarks: tuple[str, ...]
    warnings: tuple[str, ...]
    sheet: Path | None = None

    @property
    def restitution(self) -> Estimate:
        """The pooled value."""
        return self.bounces.pooled

    def frame(self, clock: float) -> float:
        """The frame number of the file at a time of the clock; on its last step beyond it."""
        frames = self.bounces.track.frame[self.bounces.base.rows]
        return float(np.interp(clock, self.bounces.base.clock, frames))

    def seconds(self, clock: float) -> float | None:
        """Time of the recording in s at a time of the clock, from its first position on."""
        if self.rate is None:
            return None
        stamps = self.bounces.track.time
        start = 0.0 if stamps is None or self.rate.value != self.rate_header else float(stamps[0])
        return start + (clock - self.bounces.track.clock[0]) / self.rate.value

    def as_json(self) -> dict[str, Any]:
        """The object that `calibrate drop --json` prints; None where a value does not exist."""
        found = self.bounces
        return {
            "restitution": {
                "value": found.pooled.value,
                "sigma": found.pooled.sigma,
                "constant_within_noise": found.constant_within_noise,
                "p": found.p,
                "method": found.method,
                "speed_exponent": _pair(found.exponent),
            },
            "bounces": [self._bounce(k) for k in range(len(found.contacts))],
            "contact_times_s": self._contact_times(),
            "contact_frames": [self.frame(t) for t in found.contacts[:, 0]],
            "fps_header": self.rate_header,
            "fps_used": None if self.rate is None else self.rate.value,
            "fps_sigma": None if self.rate is None else self.rate.sigma,
            "time_base": {
                "duplicated_frames": found.base.duplicated_frames,
                "dropped_frames": found.base.dropped_frames,
                "remark": "; ".join(self.remarks) or "even",
            },
            "scale_m_per_px": None if self.scale is None else self.scale.value,
            "scale_sigma_m_per_px": None if self.scale is None else self.scale.sigma,
            "gravity_check_m_s2": None if self.gravity is None else self.gravity.value,
            "gravity_sigma_m_s2": None if self.gravity is None else self.gravity.sigma,
            "plate_drift_px": found.drift.value,
            "plate_drift_sigma_px": found.drift.sigma,
            "acceleration_px_per_frame2": found.flights.acceleration[0],
            "acceleration_sigma_px_per_frame2": found.flights.acceleration[1],
            "residual_sigma_px": found.flights.sigma,
            "track": found.track.name,
            "warnings": list(self.warnings),
            "sheet": None if self.sheet is None else str(self.sheet),
        }

    def _contact_times(self) -> list[float] | None:
        times = [self.seconds(t) for t in self.bounces.contacts[:, 0]]
        return None if self.rate is None else [time for time in times if time is not None]

    def _bounce(self, k: int) -> dict[str, float | None]:
        found = self.bounces
        inner = found.method == "times"
        best = k - 1 if inner else k
        has_best = 0 <= best < len(found.best)
        speed = self.speed(k)
        clock, sigma = found.contacts[k]
        return {
            "contact_time_s": self.seconds(clock),
            "contact_frame": self.frame(clock),
            "contact_frame_sigma": float(sigma),
            "from_times": _finite(found.times[k, 0]),
            "from_velocities": _finite(found.velocities[k, 0]),
            "from_heights": _finite(found.heights[k, 0]),
            "sigma": float(found.sigma[best]) if has_best else _finite(found.velocities[k, 1]),
            "sigma_times": _finite(found.times[k, 1]),
            "sigma_velocities": _finite(found.velocities[k, 1]),
            "sigma_heights": _finite(found.heights[k, 1]),
            "impact_speed_m_s": None if speed is None else speed.value,
            "impact_speed_sigma_m_s": None if speed is None else speed.sigma,
            "plate_level_px": float(found.plate[k, 0]),
        }

    def speed(self, k: int) -> Estimate | None:
        """Impact speed at contact k [m/s]; None where free fall cannot give it."""
        if self.rate is None or self.scale is None:
            return None
        value, sigma = map(float, self.bounces.speeds[k])
        seen = Estimate(value, sigma, 1)
        return through(lambda v, f, s: v * f * s, seen, self.rate, self.scale)


def measure_drop(
    source: str | Path | Track | Sequence[Track],
    *,
    fps: float | None = None,
    scale: str | float | None = None,
    track: str | None = None,
    one_bounce: bool = False,
    out: str | Path | None = None,
) -> Drop:
    """Restitution of a thing that falls on a plate and bounces, from its track.

    source      a track table (see track_table), or tracks
    fps         frames per second of the camera; overrides what time stamps say
    scale       "0.81 mm/px", or metres per unit of x and y
    track       name of the track, where several things bounce
    one_bounce  take a clip with a single bounce: eq. 3.5 without a check of one bounce by another
    out         folder for the sheet

    Raises InputError, one line, for what cannot be measured.
    """
    if isinstance(source, Track):
        tracks = [source]
    else:
        tracks = read_tracks(source) if isinstance(source, str | Path) else list(source)
    where = f"{source}: " if isinstance(source, str | Path) else ""
    length = _metres(scale)
    if fps is not None and not 0 < fps < math.inf:
        raise InputError(f"--fps = {fps!r}: frames per second of the camera, such as 240")
    found = _the_one_that_bounces(tracks, track, one_bounce, where)
    if length is not None and found.track.scale is not None:
        raise InputError(f"{where}--scale: the unit of y stands in the table's head already")
    drop = _with_free_fall(found, fps, found.track.scale if length is None else length)
    if out is None:
        return drop
    from calibration.drop_sheet import draw_sheet

    name = Path(source).stem if isinstance(source, str | Path) else found.track.name or "track"
    return replace(drop, sheet=draw_sheet(drop, Path(out) / f"drop-{name}.png", name))


def _metres(scale: str | float | None) -> float | None:
    """Metres per pixel of "0.81 mm/px" or a number."""
    if scale is None:
        return None
    if isinstance(scale, str):
        return metres_per_pixel(scale)
    if not 0 < scale < math.inf:
        raise InputError(f"--scale = {scale!r}: must be positive, such as '0.81 mm/px'")
    return scale


def _the_one_that_bounces(
    tracks: list[Track], name: str | None, one_bounce: bool, where: str
) -> Bounces:
    if name is not None:
        known = [track.name for track in tracks]
        if name not in known:
            raise InputError(f"{where}no track {name!r}; there are {', '.join(map(repr, known))}")
        tracks = [track for track in tracks if track.name == name]
    found, failures = [], []
    for track in tracks:
        try:
            found.append(find_bounces(track, one_is_enough=one_bounce))
        except InputError as error:
            failures.append((_range(track), error))
    if not found:
        raise InputError(f"{where}{max(failures, key=lambda failure: failure[0])[1]}")
    if len(found) > 1:
        names = ", ".join(repr(one.track.name) for one in found)
        raise InputError(f"{where}{len(found)} things bounce: choose one with --track ({names})")
    return found[0]


def _range(track: Track) -> float:
    """How far a track goes along y: the one that goes farthest says why nothing was found."""
    seen = track.y[np.isfinite(track.y)]
    return float(np.ptp(seen)) if len(seen) else 0.0


def _with_free_fall(found: Bounces, fps: float | None, scale: float | None) -> Drop:
    """Scale, rate or gravity from the acceleration, and what that says of the clip."""
    header = found.track.rate
    value, sigma = found.flights.acceleration
    fall = Estimate(abs(value), sigma, len(found.flights.rows))
    used = fps or header
    rate = Estimate(used, 0.0, 1) if used else None
    length = Estimate(scale, 0.0, 1) if scale else None
    gravity, remarks, warnings = None, list(found.base.remarks), list(found.warnings)
    if rate and length:
        gravity = through(lambda a, f, s: a * s * f**2, fall, rate, length)
        warnings += _doubts(gravity, rate, length)
    elif rate:
        length = through(lambda g, a, f: g / (a * f**2), STANDARD_GRAVITY, fall, rate)
        remarks.append("no scale: free fall gives it")
    elif length:
        rate = through(lambda g, a, s: math.sqrt(g / (a * s)), STANDARD_GRAVITY, fall, length)
        remarks.append("no rate: free fall gives it")
    else:
        remarks.append("neither rate nor scale: times in frames, no speeds")
    return Drop(found, header, rate, length, gravity, tuple(remarks), tuple(warnings))


def _doubts(gravity: Estimate, rate: Estimate, scale: Estimate) -> list[str]:
    ratio = gravity.value / STANDARD_GRAVITY.value
    assert gravity.sigma is not None
    off = abs(gravity.value - STANDARD_GRAVITY.value)
    if off < 3 * gravity.sigma or abs(ratio - 1) < _FAR:
        return []
    return [
        f"free fall gives g = {gravity.value:.4g} m/s2: with this scale the rate would be "
        f"{rate.value / math.sqrt(ratio):.4g} frames/s, with this rate the scale "
        f"{1e3 * scale.value / ratio:.4g} mm/px"
    ]


def _pair(estimate: Estimate | None) -> dict[str, float | None] | None:
    return None if estimate is None else {"value": estimate.value, "sigma": estimate.sigma}


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
