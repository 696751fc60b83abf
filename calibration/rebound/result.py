"""The result of a rebound: restitutions, friction, energies; as numbers and as text."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from calibration.rebound.contact import SHARES, Contact, Known
from calibration.result import AsText, Parameter
from calibration.statistics.quantity import plus_minus
from calibration.statistics.uncertainty import Estimate, as_pair, through
from calibration.tracking.orientation import Orientation
from calibration.tracking.track import Array, Track

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_INDEFINITE = 0.5  # sigma of a ratio between -1 and 1 that says little of it
_SPEEDS = ("v_n_before", "v_t_before", "v_n_after", "v_t_after")


@dataclass(frozen=True, repr=False)
class Rebound(AsText):
    """Result of a rebound.

    track, seen   the particle's positions and orientations
    clock         (n,) time of each position [frames]: without frames that are shown twice
    known         its motion and shape; see calibration.rebound.contact
    contacts      in order of time
    pooled, p     restitution at the point of contact of all contacts; chance that they are one
    rate          frames/s; None where it is not known
    scale         m/px; None where it is not known
    """

    track: Track
    clock: Array
    seen: Orientation
    known: Known
    contacts: list[Contact]
    pooled: Estimate
    p: float | None
    rate: float | None
    scale: Estimate | None
    warnings: tuple[str, ...]
    path: Path = Path("film")

    def to_dict(self) -> dict[str, Any]:
        """Keys of docs/laboratory/rebound.md; None where a value does not exist."""
        return {
            "restitution": {
                "value": self.pooled.value, "sigma": self.pooled.sigma, "p": self.p,
                "at": "point of contact",
            },
            "contacts": [self._contact(one) for one in self.contacts],
            "gyration_px": dict(zip(("value", "sigma"), self.known.gyration, strict=True)),
            "gyration_m": as_pair(self.length(Estimate(*self.known.gyration, 1))),
            "plane_deg": {
                "value": float(np.degrees(self.known.plane.value)),
                "sigma": float(np.degrees(self.known.plane.sigma or 0.0)),
            },
            "period_deg": float(np.degrees(self.seen.period)),
            "silhouette_changes": self.seen.changes,
            "fps_used": self.rate,
            "scale_m_per_px": as_pair(self.scale),
            "noise_px": {"x": float(self.known.fitted.noise[0]),
                         "y": float(self.known.fitted.noise[1])},
            "noise_deg": float(np.degrees(self.known.fitted.noise[2])),
            "warnings": list(self.warnings),
        }  # fmt: skip

    def _contact(self, one: Contact) -> dict[str, Any]:
        known = one.values
        return {
            "frame": self.frame(one),
            "frame_sigma": one.sigma,
            "angle_deg": float(np.degrees(one.angle)),
            "restitution": as_pair(known["restitution"]),
            "restitution_centroid": as_pair(known["restitution_centroid"]),
            "tangential_restitution": as_pair(definite(known["tangential_restitution"])),
            "impulse_ratio": as_pair(known["impulse_ratio"]),
            "energy_lost": as_pair(known["energy_lost"]),
            "energy_shares": {name: as_pair(known[name]) for name in SHARES},
            "arm_px": {"tangential": as_pair(known["arm_t"]), "normal": as_pair(known["arm_n"])},
            "moment_balance_sigmas": one.balance,
            "doubt": one.doubt or None,
            "velocities_m_s": {name: as_pair(self.speed(known[name])) for name in _SPEEDS},
            "speed_of_point_m_s": as_pair(self.speed(known["speed_of_point"])),
            "angular_velocity_before_rad_s": as_pair(self.rotation(known["omega_before"])),
            "angular_velocity_after_rad_s": as_pair(self.rotation(known["omega_after"])),
        }

    def frame(self, one: Contact) -> float:
        """Number in the film of the frame, and part of one, at which a contact is."""
        return float(np.interp(one.frame, self.clock, self.track.frame))

    def length(self, known: Estimate) -> Estimate | None:
        """A length in px in m."""
        if self.scale is None:
            return None
        return through(lambda a, s: a * s, known, self.scale)

    def speed(self, known: Estimate) -> Estimate | None:
        """A velocity in px/frame in m/s."""
        if self.scale is None or self.rate is None:
            return None
        rate = self.rate
        return through(lambda v, s: v * s * rate, known, self.scale)

    def rotation(self, known: Estimate) -> Estimate | None:
        """An angular velocity in rad/frame in rad/s."""
        if self.rate is None:
            return None
        rate = self.rate
        return through(lambda w: w * rate, known)

    def text(self) -> str:
        """Restitution at the point and of the centroid, and where the energy went."""
        lines = [f"restitution at the point of contact {_said(self.pooled)}"]
        for one in self.contacts:
            lines += self._lines(one)
        k = self.length(Estimate(*self.known.gyration, 1))
        words = f"{_said(Estimate(*self.known.gyration, 1))} px"
        if k is not None:
            words += f", {_said(Estimate(1e3 * k.value, 1e3 * (k.sigma or 0.0), 1))} mm"
        lines.append(f"radius of gyration {words}")
        lines += [f"warning: {warning}" for warning in self.warnings]
        return "\n".join(lines)

    def _lines(self, one: Contact) -> list[str]:
        known = one.values
        before, after = (
            ", ".join(
                f"{100 * known[f'{part}_{when}'].value:.1f} % {word}" for part, word in _PARTS
            )
            for when in ("before", "after")
        )
        tangential = definite(known["tangential_restitution"])
        lines = [
            f"contact at frame {self.frame(one):.2f} +- {one.sigma:.1g}, rotated by "
            f"{np.degrees(one.angle):.1f} degrees",
            f"  restitution at the point {_said(known['restitution'])}; ratio of the centroid's "
            f"velocities {_said(known['restitution_centroid'])}",
            f"  tangential restitution {_said(tangential)}; tangential over normal impulse "
            f"{_said(known['impulse_ratio'])}",
            f"  energy before: {before}",
            f"  energy after:  {after}; lost {_said(known['energy_lost'], 100)} %",
            f"  point of contact {known['arm_t'].value:+.1f} px aside, {-known['arm_n'].value:.1f} "
            f"px below the centroid; impulse and rotation agree to {one.balance:+.1f} sigma",
        ]
        spin = [self.rotation(known[f"omega_{when}"]) for when in ("before", "after")]
        if spin[0] is not None and spin[1] is not None:
            lines.append(
                f"  angular velocity {_said(spin[0])} before, {_said(spin[1])} rad/s after "
                "(counter-clockwise)"
            )
        return lines

    def parameters(self) -> dict[str, Parameter]:
        """Restitution at the point of contact, which is the contact law's."""
        return {"restitution": Parameter(self.pooled, "rebound, at the point of contact")}

    def figure(self) -> "Figure":
        """Positions, angle, residuals, energies, and the particle at its contacts."""
        from calibration.rebound.figure import draw_figure

        return draw_figure(self)


_PARTS = (("normal", "normal"), ("tangential", "tangential"), ("rotational", "rotation"))


def definite(known: Estimate) -> Estimate | None:
    """None for a ratio of velocities of which nothing is known."""
    sigma = known.sigma
    if sigma is None or not np.isfinite(known.value) or sigma > _INDEFINITE:
        return None
    return known


def _said(known: Estimate | None, scale: float = 1.0) -> str:
    if known is None:
        return "not known"
    return plus_minus(scale * known.value, scale * (known.sigma or 0.0))
