"""The result of a pendulum test: swings, collisions, restitution, amplitudes, heights."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from calibration.drop.bounce import STANDARD_GRAVITY
from calibration.pendulum.arc import Arc, planar
from calibration.pendulum.collisions import Collisions
from calibration.pendulum.contacts import Swings
from calibration.pendulum.fit import Fit, rests, starts
from calibration.pendulum.motion import across, amplitude, root_of_height
from calibration.pendulum.objects import Objects
from calibration.result import AsText, Parameter
from calibration.statistics.correlated import CHANCE
from calibration.statistics.uncertainty import Estimate, as_pair
from calibration.tracking.track import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, repr=False)
class Pendulum(AsText):
    """Result of a clip of b objects on strings and n contacts.

    objects       their tracks, from left to right
    arcs         the circle of each
    rough        the swings, and the contacts where parabolas had them [frames]
    fitted       all swings; without damping where that cannot be separated from leaving the plane
    damped       the same with the damping free, which is what the contacts' times come from
    collisions   by `fitted`
    times        (n, 2) contacts, where the swings of `damped` meet; sigma [frames]
    left_in       what the damping of `damped` would add to the restitution, where it is left in
    pooled       one restitution, and p of the test that it describes the clip
    masses       of the two blocks, where they were given
    """

    objects: Objects
    arcs: tuple[Arc, ...]
    swings: Swings
    fitted: Fit
    damped: Fit
    collisions: Collisions
    times: Array
    left_in: float
    pooled: Estimate
    p: float | None
    masses: tuple[float, float] | None
    warnings: tuple[str, ...] = ()
    sheet: Path | None = None

    @property
    def restitution(self) -> Estimate:
        """The pooled value."""
        return self.pooled

    @property
    def planar(self) -> bool | None:
        """True if the path is an arc that heights can be read off; None where it looks straight."""
        return planar(self.arcs)

    @property
    def constant_within_noise(self) -> bool | None:
        """True if one number describes the clip (p at least 0.01); None for one contact."""
        return None if self.p is None else self.p >= CHANCE

    def frame(self, clock: float) -> float:
        """The frame number of the file at a time of the clock."""
        return float(np.interp(clock, self.objects.t, self.objects.frame))

    def amplitudes(self) -> tuple[Array, Array]:
        """(b, n) before and after each contact [px]: how far a swing turns from where it hangs.

        Of a ball, from where it meets the wall, along x or the arc: what is seen in the picture.
        """
        found, b = self.fitted, len(self.arcs)
        start = starts(found.parameters, b)
        arc = amplitude(found.law, start[..., 0], start[..., 1])
        if not found.seen.angles:
            arc = across(found.law, arc)
        if b == 1:
            wall = float(np.median(self.collisions.gaps[:, 0])) - rests(found.parameters, 1)[0]
            side = np.sign(self.collisions.before[0, 0])
            arc = arc + side * wall
        return arc[:, self.swings.before], arc[:, self.swings.after]

    def from_amplitudes(self) -> Array | None:
        """(n,) amplitude after over before, as seen from the wall; None for two blocks."""
        before, after = self.amplitudes()
        return after[0] / before[0] if len(before) == 1 else None

    def heights(self) -> tuple[Array, Array] | None:
        """(b, n) H = L (1 - cos theta) before and after contacts [px]; None without a length."""
        found = self.fitted
        if found.law.kappa == 0:
            return None
        start = starts(found.parameters, len(self.arcs))
        root = root_of_height(found.law, amplitude(found.law, start[..., 0], start[..., 1]))
        height = found.law.kappa * root**2 / 2
        return height[:, self.swings.before], height[:, self.swings.after]

    def length_m(self) -> Estimate | None:
        """Of the string, from the period: g/omega^2; None without a rate."""
        if self.objects.rate is None:
            return None
        omega, sigma = self.fitted.law.omega, float(np.sqrt(self.fitted.covariance[0, 0]))
        length = STANDARD_GRAVITY.value / (omega * self.objects.rate) ** 2
        return Estimate(length, 2 * length * sigma / omega, 1)

    def to_dict(self) -> dict[str, Any]:
        """The object that `calibrate pendulum --json` prints; None where a value does not exist."""
        hit, damping, objects = self.collisions, self.damped.damping, self.objects
        assert damping.sigma is not None
        length, heights = self.length_m(), self.heights()
        before, after = self.amplitudes()
        seen = self.from_amplitudes()
        return {
            "restitution": {
                "value": self.pooled.value,
                "sigma": self.pooled.sigma,
                "per_collision": hit.restitution.tolist(),
                "per_collision_sigma": np.sqrt(np.diag(hit.covariance)).tolist(),
                "from_heights": hit.from_heights[:, 0].tolist(),
                "from_heights_sigma": hit.from_heights[:, 1].tolist(),
                "from_amplitudes": None if seen is None else seen.tolist(),
                "constant_within_noise": self.constant_within_noise,
                "p": self.p,
            },
            "contact_frames": [self.frame(time) for time in self.times[:, 0]],
            "contact_frames_sigma": self.times[:, 1].tolist(),
            "contact_times_s": _seconds(self),
            "amplitudes": _each(after),
            "amplitudes_before": _each(before),
            "heights": None if heights is None else _each(heights[1]),
            "heights_before": None if heights is None else _each(heights[0]),
            "unit": objects.unit,
            "planar": self.planar,
            "coordinate": "angle" if self.fitted.seen.angles else "x",
            "string_length": _best([one.length for one in self.arcs if one.known]),
            "string_length_m": None if length is None else length.value,
            "period_frames": 2 * np.pi / self.fitted.law.omega,
            "damping": {
                "per_frame": damping.value,
                "sigma": damping.sigma,
                "loss_between_contacts": _loss(self),
                "taken_off": self.fitted is self.damped,
            },
            "mass_ratio": None if hit.mass_ratio is None else hit.mass_ratio[0],
            "mass_ratio_sigma": None if hit.mass_ratio is None else hit.mass_ratio[1],
            "things": "ball and wall" if len(self.arcs) == 1 else "two blocks",
            "tracks": [one.name for one in objects.tracks],
            "fps_header": objects.rate_header,
            "fps_used": objects.rate,
            "time_base": {
                "duplicated_frames": list(objects.repeated),
                "remark": "; ".join(objects.time_remarks) or "even",
            },
            "warnings": list(self.warnings),
        }

    def text(self) -> str:
        """Restitution, each contact, and what it was found from."""
        one = {
            True: f"one number describes the clip (p = {self.p or 0:.2g})",
            False: f"one number does not describe the clip (p = {self.p or 0:.2g})",
            None: "one value: nothing to compare it with",
        }[self.constant_within_noise]
        what = "a ball against a wall" if len(self.arcs) == 1 else "two blocks"
        rate = self.objects.rate
        lines = [
            f"restitution {self.pooled.value:.4f} +- {self.pooled.sigma:.2g}, {what}; {one}",
            *_contacts(self),
            f"plane   {_plane(self)}",
            f"string  {_string(self)}",
            f"air     {_air(self)}",
            f"rate    {'not known' if rate is None else f'{rate:.5g} frames/s'}",
        ]
        if self.collisions.mass_ratio is not None:
            value, sigma = self.collisions.mass_ratio
            lines.append(f"masses  right over left {value:.4g} +- {sigma:.1g}, by momentum")
        lines += [f"time base: {remark}" for remark in self.objects.time_remarks]
        lines += [f"warning: {warning}" for warning in self.warnings]
        return "\n".join(lines)

    def parameters(self) -> dict[str, Parameter]:
        """The pooled restitution."""
        return {"restitution": Parameter(self.pooled, "pendulum")}

    def figure(self) -> "Figure":
        """Swings, residuals, arcs, restitution."""
        from calibration.pendulum.figure import draw_figure

        return draw_figure(self)


def _contacts(found: Pendulum) -> list[str]:
    hit, (before, after) = found.collisions, found.amplitudes()
    unit = found.objects.unit
    lines = [
        f"{'frame':>16} {'restitution':>18} {'from heights':>18} "
        f"{f'amplitudes [{unit}], before -> after':>36}"
    ]
    own = np.sqrt(np.diag(hit.covariance))
    for k, (time, sigma) in enumerate(found.times):
        turns = [" and ".join(f"{a:.4g}" for a in one[:, k]) for one in (before, after)]
        lines.append(
            f"{f'{found.frame(time):.2f} +- {sigma:.1g}':>16} "
            f"{f'{hit.restitution[k]:.4f} +- {own[k]:.1g}':>18} "
            f"{'{:.4f} +- {:.1g}'.format(*hit.from_heights[k]):>18} {' -> '.join(turns):>36}"
        )
    return lines


def _plane(found: Pendulum) -> str:
    return {
        True: "the paths are arcs: heights are known, angles are used",
        False: "not planar: x is used",
        None: "the paths look straight: x is used, swings are taken to be isochronous",
    }[found.planar]


def _string(found: Pendulum) -> str:
    unit, length = found.objects.unit, found.length_m()
    known = [
        f"{one.length.value:.4g} +- {one.length.sigma:.2g} {unit}"
        for one in found.arcs
        if one.known
    ]
    metres = [] if length is None else [f"{length.value:.4g} m by its period"]
    period = 2 * np.pi / found.fitted.law.omega
    return "; ".join([*known, *metres, f"period {period:.5g} frames"])


def _air(found: Pendulum) -> str:
    used = "taken off" if found.fitted is found.damped else "not taken off"
    return f"{100 * _loss(found):.2g} % of the speed from contact to contact, {used}"


def _loss(found: Pendulum) -> float:
    """Share of the amplitude that a swing loses to the air between contacts."""
    times = found.times[:, 0]
    swing = float(np.median(np.diff(times))) if len(times) > 1 else np.pi / found.fitted.law.omega
    return float(-np.expm1(-found.damped.damping.value * swing))


def _each(values: Array) -> list[Any]:
    """Of each contact: a number for a ball, [left, right] for two blocks."""
    return list(values[0].tolist() if len(values) == 1 else values.T.tolist())


def _best(known: list[Any]) -> dict[str, float | None] | None:
    return as_pair(min(known, key=lambda one: one.sigma, default=None))


def _seconds(found: Pendulum) -> list[float] | None:
    objects = found.objects
    if objects.rate is None:
        return None
    stamps = objects.tracks[0].time
    start = objects.t[0] / objects.rate
    if stamps is not None and objects.rate == objects.rate_header:
        start = float(stamps[0])
    return [start + (time - objects.t[0]) / objects.rate for time in found.times[:, 0]]
