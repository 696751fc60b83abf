"""Cases of bodies, of stress, and of one body that is shaken."""

import math
from typing import Any

from analytic import janssen_pressure
from impacts import of_table
from record import THESIS, WOOD, Case, Row, hertz, sphere, wall

from damper3d.case.closed_forms import (
    GRAVITY,
    bouncing_block_loss,
    collect_and_collide,
    excitation_amplitude,
    inelastic_block,
    inelastic_flight,
)
from granulab.contact.reduced import sphere_mass
from silo2d.loads.solid import find_row

RADIUS = 2.5e-3
DIGITS = 1e-11  # what twelve printed digits leave open
STICKS = 0.01  # restitution that stands for none


def spheropolygon() -> Case:
    """A rectangle with rounded corners: what its corners lack, taken off."""
    rows, variants = [], []
    for width, height, r in ((20e-3, 10e-3, 1e-3), (15e-3, 15e-3, 3e-3)):
        label = f"{1e3 * width:g} mm x {1e3 * height:g} mm, r {1e3 * r:g} mm"
        # A corner square of side r without its quarter disc: area, centroid, moment about it.
        area = (1 - math.pi / 4) * r**2
        off = (r**3 / 2 - r**2 * math.pi / 4 * r * (1 - 4 / (3 * math.pi))) / area
        own = r**4 * (1 / 3 - math.pi / 16 - math.pi / 4 * ((1 - 4 / (3 * math.pi)) ** 2
                                                           - (4 / (3 * math.pi)) ** 2))  # fmt: skip
        own -= area * off**2
        arm = (width / 2 - off) ** 2 + (height / 2 - off) ** 2
        polar = width * height * (width**2 + height**2) / 12 - 4 * (2 * own + area * arm)
        rows += [Row(label, "area", width * height - 4 * area, DIGITS * width * height, 1),
                 Row(label, "polar moment of area", polar, DIGITS * polar, 1)]  # fmt: skip
        variants.append({"name": label, "body.1.corner_radius_m": r,
                         "body.1.outline_m": [[0, 0], [width, 0], [width, height], [0, height]],
                         })  # fmt: skip
    body = {"shape": "spheropolygon", "outline_m": [], "corner_radius_m": 0.0}
    return Case("rounded-rectangle", "Area and polar moment of a rectangle with rounded corners",
                "closed form: rectangle less four corners; the particles of Alonso-Marroquin et "
                "al. 2013 are such shapes", "twelve printed digits",
                {"body": [body], "variant": variants}, tuple(rows), WOOD)  # fmt: skip


def two_spheres() -> Case:
    """Two spheres that overlap lose their lens."""
    rows, variants, first = [], [], 1e-3
    for second, distance in ((1e-3, 1e-3), (0.7e-3, 1.2e-3)):
        label = f"radii {1e3 * first:g} and {1e3 * second:g} mm, {1e3 * distance:g} mm apart"
        both, d = first + second, distance
        lens = math.pi * (both - d) ** 2 * (d**2 + 2 * d * both - 3 * (first - second) ** 2)
        volume = 4 / 3 * math.pi * (first**3 + second**3) - lens / (12 * d)
        rows.append(Row(label, "volume", volume, 1e-3 * volume, 1))
        variants.append({"name": label, "body.1.radii_m": [first, second],
                         "body.1.centres_m": [[0.0, 0.0, 0.0], [0.0, 0.0, d]]})  # fmt: skip
    body: dict[str, Any] = {"shape": "multi-sphere particle", "radii_m": [], "centres_m": []}
    return Case("two-sphere-lens", "Volume of two overlapping spheres", "closed form of the lens",
                "a thousandth, for codes that integrate the union by slices or bands",
                {"body": [body], "variant": variants}, tuple(rows))  # fmt: skip


def janssen() -> Case:
    """Stress in a silo of wheat by the mean values of EN 1991-4, Table E.1."""
    wheat, radius = find_row("wheat"), 2.5
    weight, ratio, mu = wheat.unit_weight, wheat.lateral_ratio, wheat.wall_friction[1]
    rows, variants = [], []
    for depth in (1.0, 5.0, 20.0, 100.0):
        label = f"{depth:g} m"
        pressure = janssen_pressure(depth, weight, mu, ratio, math.pi * radius**2,
                                    2 * math.pi * radius)  # fmt: skip
        rows.append(Row(label, "vertical stress", pressure / ratio, DIGITS * weight * depth))
        variants.append({"name": label, "silo.depth_m": depth})
    silo = {"area_over_perimeter_m": radius / 2, "unit_weight_n_m3": weight,
            "lateral_pressure_ratio": ratio, "wall_friction": mu, "depth_m": 1.0,
            "equation": "sigma = gamma z_o (1 - exp(-z/z_o)), z_o = (A/U)/(mu K)"}  # fmt: skip
    return Case("janssen", "Vertical stress in a cylindrical silo of wheat",
                "Janssen 1895; EN 1991-4:2006, eqs 5.1 to 5.6, numbers of Table E.1",
                "twelve printed digits, of the stress without walls",
                {"silo": silo, "variant": variants}, tuple(rows))  # fmt: skip


def _shaken(step, e, motion, height, velocity, cycles, skipped, **more) -> dict[str, Any]:
    """A sphere of acrylic without friction over a floor that moves along z."""
    acrylic = of_table("acrylic")
    down = more.pop("down", -GRAVITY)
    walls = [wall("floor", 0.0, 1, 1)]
    if "lid" in more:
        walls.append(wall("lid", more.pop("lid"), -1, 1))
    motion = {"equation": "u(t) = amplitude sin(2 pi frequency t + phase) of all walls, along z",
              **motion}  # fmt: skip
    return {
        "time_step_s": step, "cycles": cycles, "cycles_not_counted": skipped,
        "gravity_m_s2": [0.0, 0.0, down], "law": hertz(0.0, e), "material": [acrylic],
        "motion": motion, "wall": walls, "variant": [],
        "body": [sphere(RADIUS, height, (0.0, velocity), material=1)], **more,
    }  # fmt: skip


def _mass() -> float:
    return sphere_mass(RADIUS, of_table("acrylic")["density_kg_m3"])


def bouncing_block() -> Case:
    """A body that bounces once a cycle on a shaken floor, started at the top of its orbit.

    It leaves the floor at the phase of closed_forms.bouncing_block_gammas with g T/2.
    """
    e, gamma, frequency = 0.5, 1.3, 25.0
    phase = math.acos(math.pi * (1 - e) / ((1 + e) * gamma))
    amplitude = float(excitation_amplitude(frequency, gamma))
    motion = {"amplitude_m": amplitude, "frequency_hz": frequency, "phase_rad": phase + math.pi}
    top = amplitude * math.sin(phase) + RADIUS + GRAVITY / frequency**2 / 8
    lost = bouncing_block_loss(_mass(), frequency, e)
    made = _shaken(5e-7, e, motion, top, 0.0, 6, 2)
    return Case("bouncing-block", "A body bounces once a cycle on a shaken floor",
                "closed form: m g^2 T^2 (1 - e)/(2 (1 + e)) a cycle (damper3d.case.closed_forms)",
                "an impact takes a thousandth of the period, in which floor and gravity act on: "
                "of the impact speed at either end, squared in the energy", made,
                (Row("", "energy lost a cycle", lost, 5e-3 * lost),))  # fmt: skip


def sticking_block() -> Case:
    """A body that hardly rebounds on a shaken floor: fluidisation."""
    frequency, rows, variants = 25.0, [], []
    impact = 1e-3  # of the period
    for gamma in (1.5, 2.0, 2.58, 3.0):
        label = f"Gamma {gamma:g}"
        amplitude = float(excitation_amplitude(frequency, gamma))
        eta = float(inelastic_block(gamma))
        # Landing a time dt late changes the relative speed by (g + A omega^2) dt at most.
        speed = math.sqrt(8 * eta)  # over A omega
        late = 2 * math.pi * impact * (1 + 1 / gamma)
        rows.append(Row(label, "efficiency", eta, eta * (2 * late / speed + STICKS)))
        variants.append({"name": label, "motion.amplitude_m": amplitude})
        assert math.isfinite(float(inelastic_flight(gamma)))
    motion = {"amplitude_m": 0.0, "frequency_hz": frequency, "phase_rad": 0.0}
    made = _shaken(5e-7, STICKS, motion, RADIUS, 0.0, 5, 2)
    return Case("sticking-block", "A body that does not rebound on a shaken floor",
                "closed form of flight and landing (Mehta and Luck 1990, Phys. Rev. Lett. 65, 393)",
                "an impact takes a thousandth of the period, by which the landing is late; "
                f"e = {STICKS} stands for none", made | {"variant": variants}, tuple(rows),
                "10.1103/PhysRevLett.65.393")  # fmt: skip


def collects() -> Case:
    """A body that sticks to the walls of a shaken box without gravity."""
    frequency, clearance, impact = 40.0, 11e-3, 1e-3
    rows, variants = [], []
    for ratio in (1.25, 2.0, 5.0):
        label, amplitude = f"A/A0 {ratio:g}", ratio * clearance / math.pi
        eta = float(collect_and_collide(ratio))
        # It leaves, and meets, a time dt late: phase 2 pi dt/T, twice.
        speed = 2 * math.sqrt(eta)
        late = 2 * 2 * math.pi * impact
        rows.append(Row(label, "efficiency", eta, eta * (2 * late / speed + STICKS)))
        variants.append({"name": label, "motion.amplitude_m": amplitude})
    motion = {"amplitude_m": 0.0, "frequency_hz": frequency, "phase_rad": 0.0}
    made = _shaken(5e-7, STICKS, motion, RADIUS, 0.0, 6, 2, lid=clearance + 2 * RADIUS, down=0.0)
    return Case("collect-and-collide", "A body sticks to both walls of a shaken box, no gravity",
                f"{THESIS}, eq. 6.11; Sack et al. 2013, Phys. Rev. Lett. 111, 018001: "
                "phi - sin phi = pi A0/A, eta = (1 - cos phi)^2/4, A0 = clearance/pi",
                "an impact takes a thousandth of the period, by which body and wall meet and part "
                f"late; e = {STICKS} stands for none", made | {"variant": variants}, tuple(rows),
                "10.1103/PhysRevLett.111.018001")  # fmt: skip


def cases() -> list[Case]:
    """All of this module."""
    return [spheropolygon(), two_spheres(), janssen(), bouncing_block(), sticking_block(),
            collects()]  # fmt: skip
