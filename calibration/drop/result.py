"""The result of a drop test: restitution, time base, scale and rate; as numbers and as text."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from calibration.drop.bounce import STANDARD_GRAVITY, Bounces
from calibration.drop.first import FirstBounce
from calibration.result import AsText, Parameter
from calibration.statistics.uncertainty import Estimate, as_pair, through

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from calibration.drop.view.annotate import Still


@dataclass(frozen=True, repr=False)
class Drop(AsText):
    """Result of a drop test; see Bounces for the parts without scale and rate.

    rate_header   frames/s that the track's time stamps say; None without them
    rate          frames/s used; sigma 0 where it was given
    scale         m per unit of the track; sigma 0 where it was given
    gravity       from free fall, where scale and rate are both known [m/s2]
    remarks       on the time base
    name          of the film or table, for the diagnostic figure
    first         H0, H1 and eq. 3.5 of the first contact
    pictures      of the film, with what was measured drawn in; see calibration.drop.view.annotate
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
    first: FirstBounce | None = None
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

    @property
    def in_metres(self) -> bool:
        """True of positions that a table gives as lengths, so that there is no scale of pixels."""
        return self.scale is not None and self.scale.value == 1.0

    def to_dict(self) -> dict[str, Any]:
        """The object that `calibrate drop --json` prints; None where a value does not exist."""
        found, per_pixel = self.bounces, None if self.in_metres else self.scale
        return {
            "restitution": {
                "value": found.pooled.value,
                "sigma": found.pooled.sigma,
                "constant_within_noise": found.constant_within_noise,
                "p": found.p,
                "method": found.method,
                "speed_exponent": as_pair(found.exponent),
            },
            "first_contact": None if self.first is None else self._first(self.first),
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
            "scale_m_per_px": None if per_pixel is None else per_pixel.value,
            "scale_sigma_m_per_px": None if per_pixel is None else per_pixel.sigma,
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

    def _first(self, first: FirstBounce) -> dict[str, Any]:
        """Keys of the first contact; lengths in px, or the track's unit, and in m with a scale."""
        found: dict[str, Any] = {
            "restitution": as_pair(first.restitution),
            "from_rest": first.held,
            "rebound_positions": first.positions,
        }
        seen = (first.fall, first.rise)
        for name, way, height in zip(("h0", "h1"), seen, self.heights(), strict=True):
            found |= {f"{name}_px": as_pair(way), f"{name}_m": as_pair(height)}
        turns = first.rotation or (None, None)
        for name, one in zip(("before", "after"), turns, strict=True):
            found[f"rotation_{name}_rad_per_s"] = as_pair(self._per_second(one))
        return found

    def _height(self, way: Estimate, time: Estimate) -> Estimate | None:
        """A height of the first contact [m]: by the scale, or of free fall in that time."""
        if self.rate is not None and self.gravity is None:
            return through(
                lambda g, frames, rate: g * (frames / rate) ** 2 / 2,
                STANDARD_GRAVITY, time, self.rate,
            )  # fmt: skip
        if self.scale is None:
            return None
        return through(lambda length, scale: length * scale, way, self.scale)

    def heights(self) -> tuple[Estimate | None, Estimate | None]:
        """H0 and H1 of the first contact [m]; None where neither rate nor scale is known."""
        one = self.first
        if one is None:
            return None, None
        return self._height(one.fall, one.fall_time), self._height(one.rise, one.rise_time)

    def _per_second(self, seen: Estimate | None) -> Estimate | None:
        """A change per frame in one per second, where there is a rate."""
        if seen is None or self.rate is None:
            return None
        return through(lambda change, rate: change * rate, seen, self.rate)

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
            *([] if self.first is None else _first_contact(self)),
        ]
        if found.exponent is not None:
            lines.append(f"restitution ~ speed^n, n = {_with(found.exponent, '')}")
        a, sigma = found.flights.acceleration
        lines.append(f"acceleration {abs(a):.5g} +- {sigma:.2g} per frame^2, y counts "
                     f"{'downwards' if a > 0 else 'upwards'}")  # fmt: skip
        lines += [
            f"rate   {_with(self.rate, 'frames/s')}",
            "scale  y is a length"
            if self.in_metres
            else f"scale  {_with(self.scale, 'm per unit of y')}",
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
        from calibration.drop.view.figure import draw_figure

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


def _first_contact(drop: "Drop") -> list[str]:
    """H0, H1 and rotation of the first contact."""
    first, shown = drop.first, []
    assert first is not None
    seen = (first.fall, first.rise)
    for name, way, height in zip(("H0", "H1"), seen, drop.heights(), strict=True):
        shown.append(f"{name} {_with(way, 'px') if height is None else _in_mm(height)}")
    began = "from rest" if first.held else "as if from rest"
    lines = [f"first contact: {began}, {', '.join(shown)}, sqrt(H1/H0) = "
             f"{_with(first.restitution, '')}"]  # fmt: skip
    if first.rotation is not None:
        turns = [drop._per_second(one) for one in first.rotation]
        unit = "rad/frame" if turns[0] is None else "rad/s"
        before, after = (
            _with(turn or one, unit) for turn, one in zip(turns, first.rotation, strict=True)
        )
        lines.append(f"rotation: {before} before, {after} after it")
    return lines


def _in_mm(length: Estimate) -> str:
    return _with(Estimate(1e3 * length.value, 1e3 * (length.sigma or 0.0), 1), "mm")


def _with(known: "Estimate | None", unit: str) -> str:
    """A value with its sigma and unit; "not known" for none."""
    if known is None:
        return "not known"
    sigma = f" +- {known.sigma:.2g}" if known.sigma else ""
    return f"{known.value:.5g}{sigma} {unit}".rstrip()
