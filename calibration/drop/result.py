"""What a drop test gives: restitution, the time base, scale and rate; as one object and as JSON."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from calibration.drop.bounce import Bounces
from calibration.statistics.uncertainty import Estimate, as_pair, through


@dataclass(frozen=True)
class Drop:
    """What a drop test gives; see Bounces for the parts without scale and rate.

    rate_header   frames/s that the track's time stamps say; None without them
    rate          frames/s used; sigma 0 where it was given
    scale         m per unit of the track; sigma 0 where it was given
    gravity       from free fall, where scale and rate are both known [m/s2]
    remarks       on the time base
    sheet, film   the picture and the annotated film, where they were asked for
    """

    bounces: Bounces
    rate_header: float | None
    rate: Estimate | None
    scale: Estimate | None
    gravity: Estimate | None
    remarks: tuple[str, ...]
    warnings: tuple[str, ...]
    sheet: Path | None = None
    film: Path | None = None

    @property
    def restitution(self) -> Estimate:
        """The pooled value."""
        return self.bounces.pooled

    def frame(self, clock: float) -> float:
        """The frame number of the file at a time of the clock; on its last step beyond it."""
        frames = self.bounces.track.frame[self.bounces.base.rows]
        return float(np.interp(clock, self.bounces.base.clock, frames))

    def seconds(self, clock: float) -> float | None:
        """Time of the recording in s at a time of the clock, at the rate used.

        It starts where stamps do; without them at the first position.
        """
        if self.rate is None:
            return None
        stamps, stamped = self.bounces.track.time, self.bounces.track.rate
        start = 0.0
        if stamps is not None and stamped:
            start = float(stamps[0]) * stamped / self.rate.value
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
                "speed_exponent": as_pair(found.exponent),
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
            "annotated_film": None if self.film is None else str(self.film),
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


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
