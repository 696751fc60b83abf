"""The result of a drop test: restitution, time base, scale and rate; as numbers and as text."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from calibration.drop.bounce import Bounces
from calibration.result import Parameter
from calibration.statistics.uncertainty import Estimate, as_pair, through

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from calibration.drop.annotate import Still


@dataclass(frozen=True)
class Drop:
    """Result of a drop test; see Bounces for the parts without scale and rate.

    rate_header   frames/s that the track's time stamps say; None without them
    rate          frames/s used; sigma 0 where it was given
    scale         m per unit of the track; sigma 0 where it was given
    gravity       from free fall, where scale and rate are both known [m/s2]
    remarks       on the time base
    name          of the film or table, for the diagnostic figure
    pictures      of the film, with what was measured drawn in; see calibration.drop.annotate
    sheet, film   the diagnostic figure and the annotated film, where they were requested
    """

    bounces: Bounces
    rate_header: float | None
    rate: Estimate | None
    scale: Estimate | None
    gravity: Estimate | None
    remarks: tuple[str, ...]
    warnings: tuple[str, ...]
    name: str = ""
    pictures: tuple["Still", ...] = ()
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
            start = float(stamps[0]) * stamped * self.bounces.base.share / self.rate.value
        return start + (clock - self.bounces.track.clock[0]) / self.rate.value

    def to_dict(self) -> dict[str, Any]:
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

    def text(self) -> str:
        """Restitution, each bounce, and the time base, scale and rate that were used."""
        found = self.bounces
        one = {
            True: f"one number describes the clip (p = {found.p or 0:.2g})",
            False: f"one number does not describe the clip (p = {found.p or 0:.2g})",
            None: "one value: nothing to compare it with",
        }[found.constant_within_noise]
        lines = [
            f"restitution {_with(self.restitution, '')} from {found.method}; {one}",
            *_bounces(self),
        ]
        if found.exponent is not None:
            lines.append(f"restitution ~ speed^n, n = {_with(found.exponent, '')}")
        a, sigma = found.flights.acceleration
        lines.append(f"acceleration {abs(a):.5g} +- {sigma:.2g} per frame^2, y counts "
                     f"{'downwards' if a > 0 else 'upwards'}")  # fmt: skip
        lines += [
            f"rate   {_with(self.rate, 'frames/s')}",
            f"scale  {_with(self.scale, 'm per unit of y')}",
            f"g      {_with(self.gravity, 'm/s2')}",
            f"plate  moves by {_with(found.drift, '')} from the first contact to the last",
        ]
        lines += [f"time base: {remark}" for remark in self.remarks]
        lines += [f"warning: {warning}" for warning in self.warnings]
        return "\n".join(lines)

    def parameters(self) -> dict[str, Parameter]:
        """The pooled restitution."""
        return {"restitution": Parameter(self.restitution, "drop test")}

    def figure(self) -> "Figure":
        """Track, parabolas, residuals, restitution against speed, pictures of the film."""
        from calibration.drop.figure import draw_figure

        return draw_figure(self)


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _bounces(drop: "Drop") -> list[str]:
    found = drop.bounces
    lines = [
        f"{'frame':>9} {'from times':>16} {'from velocities':>16} {'from heights':>16} "
        f"{'impact speed':>12}"
    ]
    for k, (clock, _) in enumerate(found.contacts):
        ways = [found.times[k], found.velocities[k], found.heights[k]]
        cells = [f"{e:.4f} +- {s:.1g}" if np.isfinite(e) else "-" for e, s in ways]
        speed = drop.speed(k)
        cells.append(f"{speed.value:.3f} m/s" if speed else "-")
        lines.append(
            f"{drop.frame(clock):9.2f} "
            + " ".join(f"{cell:>16}" for cell in cells[:3])
            + f" {cells[3]:>12}"
        )
    return lines


def _with(known: "Estimate | None", unit: str) -> str:
    """A value with its sigma and unit; "not known" for none."""
    if known is None:
        return "not known"
    sigma = f" +- {known.sigma:.2g}" if known.sigma else ""
    return f"{known.value:.5g}{sigma} {unit}".rstrip()
