"""Normal force of steel particles on a flat wall against their smooth bodies (Figs 5.6-5.13).

The sub-spheres' forces are the engine's, by each multi-contact model. The smooth bodies
are Hertz's where they touch at a point, and a line load on a ring for the lying toroid, where no
point contact is. The thesis does not print the displacements of its figures: here a thousandth of
the diameter, and 0.008 of the tube's for the lying toroid, beyond the limit of eq. 5.19.
"""

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.engine.multisphere.particles import TREATMENTS
from damper3d.shapes.multisphere import MultiSphere
from damper3d.shapes.surfaces.grooves import groove_depth
from damper3d.studies.single_contact import Found
from damper3d.studies.single_contact.particles.held import pressed
from damper3d.studies.single_contact.particles.smooth_body import Elastic
from damper3d.studies.single_contact.particles.steel_shapes import Setting, settings, steel
from granulab.campaign.output.figure import BLUE, GREEN, GREY, INK, VERMILION, headline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = dict(zip(TREATMENTS, (BLUE, VERMILION, GREEN), strict=True))
WIDTHS = dict(zip(TREATMENTS, (1.6, 3.0, 1.2), strict=True))  # those above let others be seen


def compute() -> Found:
    """Curves of every particle, number of sub-spheres and multi-contact model."""
    material, law = steel()
    numbers: dict[str, Any] = {}
    rows: list[dict[str, Any]] = []
    for setting in settings():
        overlaps = setting.overlaps
        smooth = setting.smooth(material, overlaps)
        unit = 1e3 * material.modulus * math.pi * setting.unit * overlaps[-1]
        for particle in setting.clusters():
            forces = {
                treatment: pressed(particle, setting.orientation, overlaps, law, treatment)
                for treatment in TREATMENTS
            }
            name = f"{setting.key}, {len(particle.radii)}"
            numbers[name] = _numbers(setting, particle, material, forces)
            rows += [
                {
                    "particle": setting.key, "sub_spheres": len(particle.radii),
                    "overlap_m": float(overlap),
                    "smooth_n": float(smooth[n]), "normal_unit_n": unit,
                    **{f"{treatment}_n": float(forces[treatment][n]) for treatment in TREATMENTS},
                }
                for n, overlap in enumerate(overlaps)
            ]  # fmt: skip
    remarks = (
        "each: the largest overlap of its figure; forces there and at a tenth of it, over that of "
        "the smooth body; from where on the sum exceeds it; depth of the groove (eq. 5.19)",
        "forces are divided by 10^3 E pi r d_max (eq. 5.17) in the figure",
    )
    return Found(numbers, rows, remarks)


def _numbers(
    setting: Setting, particle: MultiSphere, material: Elastic, forces: dict[str, np.ndarray]
) -> dict[str, Any]:
    overlaps = setting.overlaps
    smooth = setting.smooth(material, overlaps)
    tenth = len(overlaps) // 10
    return {
        "largest_overlap_m": float(overlaps[-1]),
        "smooth_n": float(smooth[-1]),
        **{f"{name}_over_smooth": float(found[-1] / smooth[-1]) for name, found in forces.items()},
        **{
            f"{name}_over_smooth_at_tenth": float(found[tenth] / smooth[tenth])
            for name, found in forces.items()
        },
        "sum_exceeds_smooth_from_m": exceeds_from(overlaps, forces["sum"] / smooth.clip(1e-300)),
        "groove_depth_m": groove_depth(particle) if setting.lies else None,
    }


def exceeds_from(overlaps: np.ndarray, ratio: np.ndarray) -> float | None:
    """The overlap [m] from which on a ratio of forces is above 1; None: it is not at the last."""
    if ratio[-1] <= 1.0:
        return None
    below = np.flatnonzero(ratio[1:] <= 1.0)
    if len(below) == 0:
        return 0.0
    n = int(below[-1]) + 1
    share = (1.0 - ratio[n]) / (ratio[n + 1] - ratio[n])
    return float(overlaps[n] + share * (overlaps[n + 1] - overlaps[n]))


def draw(found: Found) -> "Figure":
    """A panel for each particle."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12.5, 7.6), layout="constrained")
    panels = list(figure.subplots(2, 3).flat)
    for axes, setting in zip(panels, settings(), strict=False):
        _panel(axes, found, setting)
    legend = panels[-1]
    legend.axis("off")
    for name, colour in COLOURS.items():
        legend.plot([], [], color=colour, lw=WIDTHS[name], label=f"sub-spheres, {name}")
    legend.plot([], [], color=BLUE, lw=0.7, label="other numbers of sub-spheres, sum")
    legend.plot([], [], color=INK, ls="--", label="smooth body: Hertz; line load on a ring")
    legend.plot([], [], color=GREY, ls=":", label="depth of the groove (eq. 5.19)")
    legend.legend(loc="center left")
    headline(figure, "Steel particles pressed on a flat wall: normal force against overlap")
    return figure


def _panel(axes: "Axes", found: Found, setting: Setting) -> None:
    rows = [row for row in found.rows if row["particle"] == setting.key]
    numbers = list(dict.fromkeys(row["sub_spheres"] for row in rows))
    diameter = 2 * setting.unit
    for number in numbers:
        mine = [row for row in rows if row["sub_spheres"] == number]
        x = 1e3 * np.array([row["overlap_m"] for row in mine]) / diameter
        unit, main = mine[0]["normal_unit_n"], number == numbers[-1]
        for name in reversed(TREATMENTS) if main else TREATMENTS[:1]:
            y = np.array([row[f"{name}_n"] for row in mine]) / unit
            axes.plot(x, y, color=COLOURS[name], lw=WIDTHS[name] if main else 0.7,
                      zorder=1.5 if name == "deepest" else 2)  # fmt: skip
        axes.annotate(f"{number}", (x[-1], y[-1]), xytext=(4, 0), color=BLUE, va="center",
                      textcoords="offset points", fontsize=7)  # fmt: skip
    axes.plot(x, [row["smooth_n"] / unit for row in mine], color=INK, ls="--")
    depth = found.numbers[f"{setting.key}, {numbers[-1]}"]["groove_depth_m"]
    if depth is not None:
        axes.axvline(1e3 * depth / diameter, color=GREY, ls=":")
    axes.set(xlabel="overlap / diameter [10\u207b\u00b3]", xlim=(0, 1.06 * x[-1]),
             ylabel="force / (10\u00b3 E \u03c0 r d_max) [-]")  # fmt: skip
    axes.set_ylim(bottom=0)
    axes.ticklabel_format(axis="y", style="sci", scilimits=(0, 0))
    axes.set_title(f"{setting.key} (Fig. {setting.figure})", fontsize=9, loc="left")
