"""A particle in numbers and in words: sizes, mass properties, errors, what it costs."""

from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.case.case import DamperCase
from damper3d.case.plan import expected_cpu_of_step, expected_cpu_s, steps_at_most
from damper3d.shapes.errors import Errors
from damper3d.shapes.multisphere import MultiSphere
from damper3d.shapes.surfaces.grooves import groove_depth, speed_to_groove
from damper3d.view.spheres import Window, draw_spheres
from granulab.campaign.output.figure import (
    BLUE,
    GREEN,
    GREY,
    PURPLE,
    SKY,
    VERMILION,
    headline,
    round_length,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def summary(case: DamperCase, errors: Errors) -> dict[str, Any]:
    """The keys of `damper3d shape --json`; the case is the thesis's damper with the particle."""
    particle = case.particle
    size = np.ptp(particle.surface.vertices, axis=0)
    return {
        "particles": particle.name,
        "sub_spheres": len(particle.radii),
        "arrangement": particle.arrangement,
        "equal_volume_radius_m": particle.equal_volume_radius,
        "size_m": size.tolist(),
        "volume_m3": particle.volume,
        "area_m2": particle.area,
        "sphericity": particle.sphericity,
        "inertia_over_density_m5": particle.inertia.tolist(),
        "density_kg_m3": case.density,
        "mass_kg": case.particle_mass,
        "surface_error_m": particle.surface_error,
        "surface_error": errors.surface,
        "volume_error": errors.volume,
        "area_error": errors.area,
        "section_area_error": errors.section_area,
        "section_perimeter_error": errors.section_perimeter,
        "groove_depth_m": groove_depth(particle),
        "speed_to_groove_m_s": speed_to_groove(particle, case.wall_law, case.particle_mass),
        "smallest_sub_sphere_m": particle.smallest_radius,
        "rayleigh_step_s": case.steps.rayleigh,
        "step_limit_s": case.steps.limit,
        "time_step_s": case.time_step,
        "n_particles": case.count,
        "fill_ratio": case.fill_ratio,
        "cycles": case.settings.run.cycles,
        "steps": steps_at_most(case),
        "expected_cpu_us_per_step": 1e6 * expected_cpu_of_step(case),
        "expected_min": sum(expected_cpu_s(case)) / 60,
    }


def as_text(found: dict[str, Any]) -> str:
    """Report of a particle for a person."""
    rows = [
        ("particle", found["particles"]),
        ("size", f"{_millimetres(found['size_m'])} mm (x, y, z)"),
        ("equal-volume radius", f"{1e3 * found['equal_volume_radius_m']:.4g} mm"),
        ("volume", f"{1e9 * found['volume_m3']:.5g} mm3"),
        ("surface", f"{1e6 * found['area_m2']:.5g} mm2"),
        ("sphericity", f"{found['sphericity']:.4f} (eq. 8.3)"),
        ("inertia over density", f"{_fifth(found['inertia_over_density_m5'])} mm5"),
        ("mass", f"{1e3 * found['mass_kg']:.4g} g at {found['density_kg_m3']:g} kg/m3"),
        ("sub-spheres", f"{found['sub_spheres']}, {_ARRANGED[found['arrangement']]}"),
        ("surface error", f"at most {1e6 * found['surface_error_m']:.4g} um, "
                          f"{_percent(found['surface_error'])} of the equal-volume radius"),
        ("volume error", _percent(found["volume_error"])),
        ("surface area error", _percent(found["area_error"])),
        ("section area error", _percent(found["section_area_error"])),
        ("section perimeter error", _percent(found["section_perimeter_error"])),
        ("groove under a wall", _groove(found)),
        ("smallest sub-sphere", f"{1e3 * found['smallest_sub_sphere_m']:.4g} mm: Rayleigh step "
                                f"{1e6 * found['rayleigh_step_s']:.3g} us"),
        ("time step", f"{1e6 * found['time_step_s']:.3g} us; the limit by its own contacts "
                      f"is {1e6 * found['step_limit_s']:.3g} us"),
        ("in 40 mm x 40 mm", f"{found['n_particles']}, a fill ratio of {found['fill_ratio']:.3f}: "
                             f"{found['n_particles'] * found['sub_spheres']} sub-spheres"),
        ("cost", f"about {found['expected_cpu_us_per_step']:.0f} us of CPU a step, "
                 f"{found['expected_min']:.1f} min for {found['cycles']} cycles of 40 Hz with the "
                 f"filling, {found['steps']:,} steps; to a factor of two"),
    ]  # fmt: skip
    return "\n".join(f"{name:24} {value}" for name, value in rows)


_ARRANGED = {
    "ball": "the shape itself",
    "row": "in a row along x",
    "ring": "in a ring round z",
    "any": "wherever they fill it",
}


def _groove(found: dict[str, Any]) -> str:
    depth, speed = found["groove_depth_m"], found["speed_to_groove_m_s"]
    if found["arrangement"] == "ball":
        return "none"
    if depth is None:
        return "known for rows and rings only; the surface error bounds it"
    return f"{1e6 * depth:.4g} um lying (eq. 5.19), reached by one contact at {speed:.3g} m/s"


def _millimetres(lengths: list[float]) -> str:
    return " x ".join(f"{1e3 * length:.4g}" for length in lengths)


def _fifth(moments: list[float]) -> str:
    return ", ".join(f"{1e15 * moment:.5g}" for moment in moments)


def _percent(share: float | None) -> str:
    return "not defined for this shape" if share is None else f"{100 * share:+.3g} %".lstrip("+")


_EYE = np.array([0.35, -0.75, 0.56])  # where it is seen from
_LIGHT = np.array([-0.45, 0.6, 0.661])  # right, up, towards the eye; as of the spheres
_PIXELS = 420  # across a picture


def draw_shape(particle: MultiSphere, curve: list[Errors], here: Errors) -> "Figure":
    """Three panels: the sub-spheres, the true surface, the errors."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.2, 3.9), layout="constrained")
    spheres, smooth, errors = figure.subplots(1, 3, width_ratios=(1.0, 1.0, 1.35))
    half = 1.03 * max(
        particle.bounding_radius, float(np.linalg.norm(particle.surface.vertices, axis=1).max())
    )
    _draw_spheres(spheres, particle, half)
    _draw_surface(smooth, particle, half)
    for axes, words in ((spheres, f"{len(particle.radii)} sub-spheres"), (smooth, "true surface")):
        axes.set(xlim=(-half, half), ylim=(-half, half), aspect="equal", title=words)
        axes.set_axis_off()
    _scale_bar(spheres, half)
    _draw_errors(errors, curve, here)
    apart = f"at most {100 * here.surface:.2g} % of the equal-volume radius apart"
    headline(figure, f"{particle.name}: the two surfaces are {apart}")
    return figure


def _view() -> np.ndarray:
    """Right, up and towards the eye in rows (3, 3)."""
    towards = _EYE / np.linalg.norm(_EYE)
    right = np.cross([0.0, 0.0, 1.0], towards)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(towards, right), towards])


def _draw_spheres(axes: "Axes", particle: MultiSphere, half: float) -> None:
    from matplotlib.colors import to_rgb

    window = Window(-half, half, -half, half, _PIXELS / (2.0 * half))
    colours = np.tile(np.array([to_rgb(SKY), to_rgb(BLUE)]), (len(particle.radii), 1))
    picture = draw_spheres(
        particle.offsets @ _view().T, particle.radii, colours[: len(particle.radii)], window,
        (1.0, 1.0, 1.0),
    )  # fmt: skip
    axes.imshow(picture, extent=(-half, half, -half, half), interpolation="none")


def _draw_surface(axes: "Axes", particle: MultiSphere, half: float) -> None:
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import to_rgb

    triangles, light = lit_triangles(particle)
    colours = light[:, None] * np.array(to_rgb(SKY))
    axes.add_collection(
        PolyCollection(list(triangles), facecolors=colours, edgecolors=colours, lw=0.3)
    )


def lit_triangles(particle: MultiSphere) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (m, 3, 2) [m] of the true surface that are seen, the nearest last, and their light.

    They are lit (m,) as the spheres of a picture are.
    """
    corners = particle.surface.corners @ _view().T
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    seen = np.flatnonzero(normals[:, 2] > 0.0)
    order = seen[np.argsort(corners[seen, :, 2].mean(axis=1), kind="stable")]
    return corners[order, :, :2], 0.42 + 0.58 * np.maximum(normals[order] @ _LIGHT, 0.0)


def _scale_bar(axes: "Axes", half: float) -> None:
    """A length of one, two or five times a power of ten, below the particle."""
    length = round_length(half)
    axes.plot([-half, length - half], [-0.97 * half] * 2, color=GREY, lw=3)
    axes.text(-half, -0.93 * half, f"{1e3 * length:g} mm", color=GREY, ha="left", va="bottom")


def _draw_errors(axes: "Axes", curve: list[Errors], here: Errors) -> None:
    from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter

    lines: list[tuple[str, str, str, Any]] = [
        ("surface", "distance of surfaces / radius (bound)", VERMILION, "o-"),
        ("volume", "volume", BLUE, "s-"),
        ("area", "surface area", GREEN, "^-"),
        ("section_area", "area of the section (thesis)", PURPLE, "v--"),
        ("section_perimeter", "perimeter of the section (thesis)", GREY, "D--"),
    ]
    for key, words, colour, style in lines:
        points = [(e.sub_spheres, abs(getattr(e, key))) for e in curve if getattr(e, key)]
        if points:
            axes.loglog(*zip(*points, strict=True), style, color=colour, label=words, ms=3.5)
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter(ScalarFormatter())
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.axvline(here.sub_spheres, color=GREY, lw=0.8, ls=":")
    axes.set(xlabel="sub-spheres", ylabel="size of the relative error", title="errors")
    axes.legend(fontsize=7, loc="upper center", bbox_to_anchor=(0.45, -0.17), ncols=2)
    axes.grid(alpha=0.2)
