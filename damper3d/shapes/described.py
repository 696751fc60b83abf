"""A particle in numbers and in words: sizes, mass properties, errors, what it costs."""

from typing import Any

import numpy as np

from damper3d.case.case import DamperCase
from damper3d.case.plan import expected_cpu_of_step, expected_cpu_s, steps_at_most
from damper3d.shapes.errors import Errors
from damper3d.shapes.surfaces.grooves import groove_depth, speed_to_groove


def answers(case: DamperCase, errors: Errors) -> dict[str, Any]:
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
    """What a person reads."""
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
        ("time step", f"{1e6 * found['time_step_s']:.3g} us; the limit by the body's own contacts "
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
