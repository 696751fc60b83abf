"""Yield velocities of spheres, and the fall of restitution above them (eq. 5.26, Fig. 5.15)."""

from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.studies.single_contact import Found
from damper3d.studies.single_contact.spheres.impact import Impact, run
from damper3d.studies.single_contact.spheres.large_spheres import RESTITUTIONS
from granulab.campaign.output.figure import BLUE, GREEN, GREY, VERMILION, headline
from granulab.contact.files.table import load_table
from granulab.contact.material import Material
from granulab.contact.reduced import reduced_mass, reduced_radius, sphere_mass
from granulab.contact.sphere_law import yield_velocity

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DIAMETER = 5e-3  # [m] of the damper's spheres
LARGE_DIAMETER = (
    12.7e-3  # [m] of the steel sphere of Fig. 5.15, measured to yield from about 0.3 m/s
)
_SPEEDS = np.geomspace(0.1, 20.0, 19)  # over the yield velocity


def compute() -> Found:
    """Yield velocities, impacts of acrylic over a range of speeds, and what is printed."""
    acrylic, steel, aluminium = (
        load_table(name).material(name) for name in ("acrylic", "steel", "aluminium")
    )
    numbers: dict[str, Any] = {
        f"{solid.name}, {1e3 * DIAMETER:g} mm": {
            "on_its_like_m_s": _yields_at(solid, solid, DIAMETER, sphere=True),
            "on_a_wall_of_it_m_s": _yields_at(solid, solid, DIAMETER, sphere=False),
        }
        for solid in (acrylic, steel, aluminium)
    }
    numbers["steel, 12.7 mm"] = {
        "on_a_wall_of_it_m_s": _yields_at(steel, steel, LARGE_DIAMETER, sphere=False),
        "measured_m_s": 0.3,
    }
    numbers["printed_m_s"] = {"acrylic on acrylic": 3.5, "steel on steel": 0.15}
    rows: list[dict[str, Any]] = []
    for sphere in (True, False):
        v_y = _yields_at(acrylic, acrylic, DIAMETER, sphere=sphere)
        for speed in _SPEEDS * v_y:
            impact = Impact(acrylic, acrylic, sphere=sphere, speed=float(speed), restitution=0.86,
                            yielding=True)  # fmt: skip
            rows.append(
                {
                    "against": "sphere" if sphere else "wall", "speed_m_s": float(speed),
                    "over_yield_velocity": float(speed / v_y),
                    "restitution": run(impact).normal_restitution,
                }
            )  # fmt: skip
    fast = [row for row in rows if row["over_yield_velocity"] > 2.0]
    over, out = (np.log([row[key] for row in fast])
                 for key in ("over_yield_velocity", "restitution"))  # fmt: skip
    numbers["exponent_above"] = float(np.polyfit(over, out, 1)[0])
    numbers["printed_restitution"] = {"steel, 40 mm": [8.1, 0.57]} | {
        f"aluminium, 200 mm, {v:g} m/s": [v / 0.001644, e] for v, e in RESTITUTIONS.items()
    }
    remark = (
        "above v_y the law takes e0 (v_y/v)^(1/4), Johnson's slope (Contact Mechanics, sec. 11.5); "
        "his and Thornton's factor before it, and a measured e0, are not in it"
    )
    return Found(numbers, rows, (remark,))


def _yields_at(first: Material, second: Material, diameter: float, *, sphere: bool) -> float:
    radius = 0.5 * diameter
    inverse = 1.0 / sphere_mass(radius, first.density.value)
    return yield_velocity(
        first,
        second,
        radius=reduced_radius(1.0 / radius, 1.0 / radius if sphere else 0.0),
        mass=reduced_mass(inverse, inverse if sphere else 0.0),
    )


def draw(found: Found) -> "Figure":
    """Restitution over speed, and over speed in yield velocities with what is printed."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 4.4), layout="constrained")
    plain, scaled = figure.subplots(1, 2)
    for against, colour, marker in (("sphere", BLUE, "o"), ("wall", VERMILION, "s")):
        rows = [row for row in found.rows if row["against"] == against]
        plain.plot([row["speed_m_s"] for row in rows], [row["restitution"] for row in rows],
                   marker, ls="-", color=colour, ms=3.5, lw=0.8,
                   label=f"acrylic, 5 mm, on a {against} of it")  # fmt: skip
        scaled.plot([row["over_yield_velocity"] for row in rows],
                    [row["restitution"] for row in rows], marker, color=colour, ms=3.5,
                    label=f"our law, acrylic on a {against}")  # fmt: skip
    line = np.geomspace(0.1, 200.0, 200)
    scaled.plot(line, 0.86 * np.minimum(1.0, line**-0.25), color=GREY,
                label="0.86 min(1, (v_y/v)^(1/4))")  # fmt: skip
    for n, (name, (x, e)) in enumerate(found.numbers["printed_restitution"].items()):
        scaled.plot(x, e, "D" if n == 0 else "^", color=GREEN, ms=7, ls="none",
                    label=f"thesis: {name.split(', ')[0]}" if n < 2 else None)  # fmt: skip
    plain.set(xscale="log", xlabel="impact speed [m/s]", ylabel="restitution [-]", ylim=(0, 1))
    scaled.set(xscale="log", xlabel="impact speed over yield velocity [-]",
               ylabel="restitution [-]", ylim=(0, 1))  # fmt: skip
    plain.legend(loc="lower left")
    scaled.legend(loc="lower left")
    headline(figure, "Restitution above the yield velocity")
    return figure
