"""The result of a triaxial test: kn and kt, the contact moment; as numbers and as text."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from calibration.result import AsText, Parameter
from calibration.statistics.quantity import plus_minus
from calibration.statistics.uncertainty import Estimate, as_pair
from calibration.tracking.track import Array
from calibration.triaxial.blocks import Line, Relative
from calibration.triaxial.markers import Dots
from calibration.triaxial.stiffness import Slopes
from granulab.contact.material import Measured

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Setting:
    """Contact in the picture, its inclination [rad], the scale [m/px], x of the load [px]."""

    line: Line
    inclination: Measured
    scale: Measured
    load_line: float | None


@dataclass(frozen=True, repr=False)
class Triaxial(AsText):
    """Result of a triaxial test; values by name, see calibration.triaxial.measure [SI].

    load   (n,) at each frame of `dots` [N]
    """

    dots: Dots
    moved: Relative
    load: Array
    setting: Setting
    fitted: Slopes
    values: dict[str, Estimate]
    warnings: tuple[str, ...] = ()
    path: Path = Path("film")

    @property
    def peak(self) -> float:
        """The highest load that was filmed, compression positive [N]."""
        return float(np.nanmax(self.load))

    def moment(self) -> Estimate | None:
        """Contact moment at the highest load: load times lever [N m]."""
        lever = self.values.get("eccentricity")
        if lever is None:
            return None
        return Estimate(self.peak * lever.value, self.peak * (lever.sigma or 0.0), lever.trials)

    def rotation(self) -> Estimate:
        """Relative rotation of the blocks for the highest load, unloading, clockwise [rad]."""
        one = self.values["rotation_per_load"]
        return Estimate(self.peak * one.value, self.peak * (one.sigma or 0.0), one.trials)

    def to_dict(self) -> dict[str, Any]:
        """Keys of docs/laboratory/triaxial.md; None where a value does not exist."""
        known = self.values
        return {
            "kn_n_per_m": as_pair(known["kn"]),
            "kt_n_per_m": as_pair(known["kt"]),
            "kt_over_kn": as_pair(known["kt_over_kn"]),
            "contact_moment": {
                "at_load_n": self.peak,
                "moment_n_m": as_pair(self.moment()),
                "eccentricity_m": as_pair(known.get("eccentricity")),
                "rotation_rad": as_pair(self.rotation()),
                "rotational_stiffness_n_m_per_rad": as_pair(known.get("rotational_stiffness")),
                "kn_rotation_left_in_n_per_m": as_pair(known["kn_rotation_left_in"]),
                "kt_rotation_left_in_n_per_m": as_pair(known["kt_rotation_left_in"]),
            },
            "inclination_deg": {
                "value": float(np.degrees(self.setting.inclination.value)),
                "sigma": float(np.degrees(self.setting.inclination.sigma or 0.0)),
            },
            "scale_m_per_px": {
                "value": self.setting.scale.value, "sigma": self.setting.scale.sigma or 0.0,
            },
            "unloadings": [
                {"first_frame": float(self.dots.frame[one[0]]),
                 "last_frame": float(self.dots.frame[one[-1]]), "frames": len(one)}
                for one in self.fitted.branches
            ],
            "markers": {"upper": int(self.moved.upper.sum()),
                        "lower": int((~self.moved.upper).sum())},
            "marker_noise_px": self.moved.scatter,
            "warnings": list(self.warnings),
        }  # fmt: skip

    def text(self) -> str:
        """kn, kt and their ratio, the contact moment and its rotation."""
        known = self.values
        angle = self.setting.inclination
        degrees = Estimate(np.degrees(angle.value), np.degrees(angle.sigma or 0.0), 1)
        lines = [
            f"normal stiffness kn      {_said(known['kn'], 1e-3)} N/mm",
            f"tangential stiffness kt  {_said(known['kt'], 1e-3)} N/mm",
            f"kt/kn                    {_said(known['kt_over_kn'])}",
            f"from {len(self.fitted.branches)} unloadings, contact inclined by {_said(degrees)} "
            f"degrees; {self.moved.upper.sum()} + {(~self.moved.upper).sum()} markers, rigid "
            f"within {self.moved.scatter:.2g} px",
        ]
        moment, lever = self.moment(), known.get("eccentricity")
        if moment is None or lever is None:
            lines.append("contact moment           not known: no --load-line")
        else:
            lines.append(
                f"contact moment           {_said(moment)} N m at {self.peak:.4g} N, which acts "
                f"{_said(lever, 1e3)} mm beside the contact's middle"
            )
        stiff = known.get("rotational_stiffness")
        words = "" if stiff is None else f"; rotational stiffness {_said(stiff)} N m/rad"
        lines.append(
            f"relative rotation        {_said(self.rotation(), 1e3)} mrad for that load{words}"
        )
        lines.append(
            f"with rotation left in    kn {_said(known['kn_rotation_left_in'], 1e-3)}, kt "
            f"{_said(known['kt_rotation_left_in'], 1e-3)} N/mm (markers' mean displacements)"
        )
        lines += [f"warning: {warning}" for warning in self.warnings]
        return "\n".join(lines)

    def parameters(self) -> dict[str, Parameter]:
        """kn and kt of the pair."""
        return {
            name: Parameter(self.values[name], "miniature triaxial test, markers on film")
            for name in ("kn", "kt")
        }

    def figure(self) -> "Figure":
        """First frame with markers and contact; load, displacements, rotation; the fits."""
        from calibration.triaxial.figure import draw_figure

        return draw_figure(self)


def _said(one: Estimate, factor: float = 1.0) -> str:
    return plus_minus(factor * one.value, factor * (one.sigma or 0.0))
