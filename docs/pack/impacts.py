"""Cases of one impact: spheres on a wall or on each other, Hertz's law, no gravity."""

import math
from typing import Any

from analytic import damped_hertz_deepest, hertz_impact, sphere_after_gross_sliding
from record import CHUNG_OOI, Case, Row, hertz, sphere, wall

from granulab.contact import load_table
from granulab.contact.reduced import reduced_mass, reduced_modulus, reduced_radius, sphere_mass
from granulab.contact.restitution import ratio_of_restitution, restitution_of_ratio

STEPS = 1000  # of an elastic contact, with which the tolerances hold
ONE = 1 / STEPS
_LASTS = 6  # elastic contact times, after which the most damped impact is over
_REASON = f"""\
{STEPS} steps to an elastic contact: forces jump where a contact begins and ends, so that a sum \
over steps may miss one of them: 1/{STEPS} of what the impact changes, two for a time; angular \
velocities also by the largest overlap over the smallest radius, by which the arm of friction is \
shorter than the radius"""

# As restated by a benchmark written with PySPH: E, nu, rho.
ALUMINIUM_ALLOY = {"youngs_modulus_pa": 70e9, "poisson": 0.33, "density_kg_m3": 2700.0}
NYLON = {"youngs_modulus_pa": 2.5e9, "poisson": 0.4, "density_kg_m3": 1000.0}
STEEL = {"youngs_modulus_pa": 208e9, "poisson": 0.3, "density_kg_m3": 7850.0}
_RESTATED = "Chung and Ooi 2011, test {}; parameters as restated by a benchmark written with PySPH"

Material = dict[str, Any]


def of_table(name: str) -> Material:
    """A material of the project's table."""
    found = load_table(name).material(name)
    constants = found.youngs_modulus, found.poisson, found.density
    return dict(
        zip(("youngs_modulus_pa", "poisson", "density_kg_m3"),
            (one.value for one in constants if one is not None), strict=True)
    )  # fmt: skip


def two(first: Material, radius: float, second: Material | None, other_radius: float = math.inf):
    """Reduced modulus [Pa], radius [m] and mass [kg]; second None: a rigid wall."""
    own = first["youngs_modulus_pa"], first["poisson"]
    other = (math.inf, 0.0) if second is None else (second["youngs_modulus_pa"], second["poisson"])
    inverse = 0.0
    if math.isfinite(other_radius) and second is not None:
        inverse = 1 / sphere_mass(other_radius, second["density_kg_m3"])
    mass = reduced_mass(1 / sphere_mass(radius, first["density_kg_m3"]), inverse)
    return reduced_modulus(*own, *other), reduced_radius(1 / radius, 1 / other_radius), mass


def setup(materials, bodies, law, reduced, speed, walls=()) -> dict[str, Any]:
    """Bodies that touch at the start; step and duration by the elastic contact time."""
    _, _, lasts = hertz_impact(*reduced, speed)
    return {
        "time_step_s": lasts / STEPS, "duration_s": _LASTS * lasts, "gravity_m_s2": [0.0, 0.0, 0.0],
        "law": law, "material": materials, "wall": list(walls), "body": bodies, "variant": [],
    }  # fmt: skip


def at_zero_force(e: float) -> float:
    """Restitution up to the moment at which the force is zero, of the damping that gives e in all.

    Whatever pulls after that has no friction, so that the impulse of friction goes with it.
    """
    return restitution_of_ratio(ratio_of_restitution(e), "force")


def elastic_pair() -> Case:
    """Test 1: two equal spheres meet."""
    radius, speed, rows, variants = 10e-3, 10.0, [], []
    for name in ("glass", "limestone"):
        solid = of_table(name)
        reduced = two(solid, radius, solid, radius)
        rows += _elastic(name, reduced, 2 * speed, (speed, -speed))
        step = hertz_impact(*reduced, 2 * speed)[2]
        variants.append({
            "name": name, "time_step_s": step / STEPS, "duration_s": _LASTS * step,
            **{f"material.1.{key}": value for key, value in solid.items()},
        })  # fmt: skip
    solid = of_table("glass")
    bodies = [sphere(radius, h, (0.0, v), material=1)
              for h, v in ((radius, -speed), (-radius, speed))]  # fmt: skip
    made = setup([solid], bodies, hertz(0.0, 1.0), two(solid, radius, solid, radius), 2 * speed)
    return Case("elastic-pair", "Two equal elastic spheres meet", "Chung and Ooi 2011, test 1",
                _REASON, made | {"variant": variants}, tuple(rows), CHUNG_OOI)  # fmt: skip


def elastic_wall() -> Case:
    """Test 2: a sphere hits a rigid wall."""
    radius, speed, rows, variants = 0.1, 0.2, [], []
    for name in ("aluminium", "magnesium"):
        solid = of_table(name)
        reduced = two(solid, radius, None)
        rows += _elastic(name, reduced, speed, (speed,))
        step = hertz_impact(*reduced, speed)[2]
        variants.append({
            "name": name, "time_step_s": step / STEPS, "duration_s": _LASTS * step,
            **{f"material.1.{key}": value for key, value in solid.items()},
        })  # fmt: skip
    solid = of_table("aluminium")
    made = setup([solid], [sphere(radius, radius, (0.0, -speed), material=1)], hertz(0.0, 1.0),
                 two(solid, radius, None), speed, [wall("floor", 0.0, 1, "rigid")])  # fmt: skip
    return Case("elastic-wall", "An elastic sphere hits a rigid wall", "Chung and Ooi 2011, test 2",
                _REASON, made | {"variant": variants}, tuple(rows), CHUNG_OOI)  # fmt: skip


def _elastic(variant, reduced, speed, after) -> list[Row]:
    overlap, force, time = hertz_impact(*reduced, speed)
    found = [Row(variant, "deepest overlap", overlap, ONE * overlap),
             Row(variant, "largest normal force", force, ONE * force),
             Row(variant, "contact time", time, 2 * ONE * time)]  # fmt: skip
    return found + [Row(variant, "normal velocity", v, ONE * speed, body)
                    for body, v in enumerate(after, 1)]  # fmt: skip


def restitution() -> Case:
    """Test 3: alumina and cast iron with six restitutions."""
    radius, speed, rows, variants = 2.5e-3, 3.9, [], []
    for name in ("alumina", "cast_iron"):
        solid = of_table(name)
        reduced = two(solid, radius, solid)
        elastic, _, step = hertz_impact(*reduced, speed)
        for e in (0.2, 0.4, 0.6, 0.8, 0.9, 1.0):
            label = f"{name}, e {e}"
            deepest = damped_hertz_deepest(elastic, e)
            rows += [Row(label, "normal velocity", e * speed, ONE * speed, 1),
                     Row(label, "deepest overlap", deepest, ONE * elastic)]  # fmt: skip
            variants.append({
                "name": label, "law.restitution": e, "time_step_s": step / STEPS,
                "duration_s": _LASTS * step,
                **{f"material.1.{key}": value for key, value in solid.items()},
            })  # fmt: skip
    solid = of_table("alumina")
    made = setup([solid], [sphere(radius, radius, (0.0, -speed), material=1)], hertz(0.0, 1.0),
                 two(solid, radius, solid), speed, [wall("floor", 0.0, 1, 1)])  # fmt: skip
    return Case("restitution", "Restitution in is restitution out",
                "Chung and Ooi 2011, test 3; deepest overlap: Antypov and Elliott 2011, EPL 94, "
                "50004", _REASON, made | {"variant": variants}, tuple(rows), CHUNG_OOI)  # fmt: skip


def zero_force() -> Case:
    """The same damping where the contact ends at zero force."""
    radius, speed, solid, rows, variants = 2.5e-3, 3.9, of_table("alumina"), [], []
    for e in (0.2, 0.5, 0.7, 0.86, 0.9):
        label = f"e {e}"
        rows.append(Row(label, "normal velocity", at_zero_force(e) * speed, ONE * speed, 1))
        variants.append({"name": label, "law.restitution": e})
    made = setup([solid], [sphere(radius, radius, (0.0, -speed), material=1)],
                 hertz(0.0, 1.0, "force"), two(solid, radius, solid), speed,
                 [wall("floor", 0.0, 1, 1)])  # fmt: skip
    return Case("contact-ends-at-zero-force", "A contact that may not pull bounces higher",
                "Schwager and Poeschel 2007, Granular Matter 9, 465; thesis, eq. 5.30; for Hertz "
                "with Tsuji's dashpot by Antypov and Elliott 2011, EPL 94, 50004",
                _REASON, made | {"variant": variants}, tuple(rows), "10.1007/s10035-007-0065-z",
                )  # fmt: skip


def _slides(label, e, mu, radius, arm, v_n, v_t=0.0, spin=0.0) -> list[Row]:
    """A sphere that slides through all of its impact on a wall; arm: overlap over radius."""
    push = mu * (1 + at_zero_force(e)) * v_n
    slip = v_t - radius * spin
    assert abs(slip) > 3.5 * push, label
    side = math.copysign(1.0, slip)
    _, turned, _ = sphere_after_gross_sliding(v_n, v_t, at_zero_force(e), mu, radius)
    return [
        Row(label, "normal velocity", e * v_n, ONE * v_n, 1),
        Row(label, "tangential velocity", v_t - side * push, 2 * ONE * push, 1),
        Row(label, "angular velocity", spin + side * turned, (2 * ONE + arm) * turned, 1),
    ]


def _on_wall(solid, radius, law, v_n, runs) -> tuple[dict[str, Any], list[Row]]:
    """Runs of one set-up: (label, v_n, v_t, spin)."""
    reduced, rows, variants = two(solid, radius, solid), [], []
    for label, normal, along, spin in runs:
        deepest, _, lasts = hertz_impact(*reduced, normal)
        rows += _slides(label, law["restitution"], law["friction"], radius, deepest / radius,
                        normal, along, spin)  # fmt: skip
        variants.append({
            "name": label, "time_step_s": lasts / STEPS, "duration_s": _LASTS * lasts,
            "body.1.velocity_m_s": [along, 0.0, -normal],
            "body.1.angular_velocity_rad_s": [0.0, spin, 0.0],
        })  # fmt: skip
    made = setup([solid], [sphere(radius, radius, (0.0, -v_n), material=1)], law, reduced, v_n,
                 [wall("floor", 0.0, 1, 1)])  # fmt: skip
    return made | {"variant": variants}, rows


def oblique() -> Case:
    """Test 4: alumina at angles at which it slides throughout."""
    runs = [(f"{angle} deg", *(3.9 * f(math.radians(angle)) for f in (math.cos, math.sin)), 0.0)
            for angle in (40, 50, 60, 70, 80)]  # fmt: skip
    made, rows = _on_wall(of_table("alumina"), 2.5e-3, hertz(0.092, 0.98), 3.9, runs)
    return Case("oblique-impact", "A sphere slides through an oblique impact",
                "Chung and Ooi 2011, test 4, in gross sliding", _REASON, made, tuple(rows),
                CHUNG_OOI)  # fmt: skip


def tangential_speeds() -> Case:
    """Test 5: steel spheres of 10 um at one normal and several tangential speeds."""
    runs = [(f"{v} m/s", 5.0, float(v), 0.0) for v in (15, 30, 70)]
    made, rows = _on_wall(STEEL, 1e-5, hertz(0.3, 1.0), 5.0, runs)
    return Case("tangential-speeds", "One normal and several tangential speeds",
                _RESTATED.format(5) + ", in gross sliding", _REASON, made, tuple(rows),
                CHUNG_OOI)  # fmt: skip


def spin_on_wall() -> Case:
    """Test 6: spheres that rotate hit a wall head-on."""
    runs = [(f"{w} rad/s", 0.2, 0.0, float(w)) for w in (5, 9, 22)]
    made, rows = _on_wall(ALUMINIUM_ALLOY, 0.1, hertz(0.4, 0.5), 0.2, runs)
    return Case("rotating-on-wall", "A rotating sphere hits a wall head-on",
                _RESTATED.format(6) + ", in gross sliding", _REASON, made, tuple(rows),
                CHUNG_OOI)  # fmt: skip


def grazing() -> Case:
    """A grazing impact, in which a code once gained a third of the energy."""
    acrylic, radius, angle, mu = of_table("acrylic"), 2.5e-3, math.radians(76), 0.5
    v_n, v_t = 3.9 * math.cos(angle), 3.9 * math.sin(angle)
    made, rows = _on_wall(acrylic, radius, hertz(mu, 1.0), v_n, [("76 deg", v_n, v_t, 0.0)])
    mass, push = sphere_mass(radius, acrylic["density_kg_m3"]), mu * 2 * v_n
    lost = mass * push * (v_t - 1.75 * push)
    arm = hertz_impact(*two(acrylic, radius, acrylic), v_n)[0] / radius
    rows.append(Row("76 deg", "energy lost", lost, (2 * ONE + arm) * lost))
    return Case("grazing-impact", "A grazing impact loses energy",
                "LAMMPS, pull request 5007 (2026): fix wall/gran hooke/history gained up to 34 % "
                "there; closed form: J (v_t - 1.75 J/m), J = mu m (1 + e) v_n",
                _REASON, made, tuple(rows))  # fmt: skip


def rotating_pair(name: str, title: str, test: int, times: float, heavier: float) -> Case:
    """Tests 7 and 8: a rotating sphere meets another, so many times as large and as dense.

    Friction's impulse is J = mu m (1 + e) v, m the reduced mass; it takes 2.5 J/(m_i r_i) off the
    angular velocity of either, and slip falls by 3.5 J/m.
    """
    radius, e, mu, speed = 0.1, 0.5, 0.4, 0.2
    radii, rows, variants = (radius, times * radius), [], []
    for kind, solid in (("aluminium alloy", ALUMINIUM_ALLOY), ("nylon", NYLON)):
        both = solid, solid | {"density_kg_m3": heavier * solid["density_kg_m3"]}
        reduced = two(both[0], radii[0], both[1], radii[1])
        masses = [sphere_mass(r, m["density_kg_m3"]) for r, m in zip(radii, both, strict=True)]
        deepest, _, lasts = hertz_impact(*reduced, speed)
        push = mu * reduced[2] * (1 + at_zero_force(e)) * speed
        near = 2 * ONE + deepest / radius
        for spin in (5.0, 22.0):
            label = f"{kind}, {spin:g} rad/s"
            assert radius * spin > 3.5 * push / reduced[2]
            for body, (m, r) in enumerate(zip(masses, radii, strict=True), 1):
                along = push / m * (1 if body == 1 else -1)
                turned = 2.5 * push / (m * r)
                rows += [Row(label, "tangential velocity", along, near * abs(along), body),
                         Row(label, "angular velocity", (spin if body == 1 else 0.0) - turned,
                             near * turned, body)]  # fmt: skip
            variants.append({
                "name": label, "time_step_s": lasts / STEPS, "duration_s": _LASTS * lasts,
                "body.1.angular_velocity_rad_s": [0.0, spin, 0.0],
                **{f"material.{k}.{key}": value for k in (1, 2)
                   for key, value in both[k - 1].items()},
            })  # fmt: skip
    heavy = ALUMINIUM_ALLOY | {"density_kg_m3": heavier * ALUMINIUM_ALLOY["density_kg_m3"]}
    bodies = [sphere(radii[0], radii[0], (0.0, -speed), 5.0, material=1),
              sphere(radii[1], -radii[1], material=2)]  # fmt: skip
    made = setup([ALUMINIUM_ALLOY, heavy], bodies, hertz(mu, e),
                 two(ALUMINIUM_ALLOY, radii[0], heavy, radii[1]), speed)  # fmt: skip
    reason = f"{_REASON}; the line of centres turns by as little, which shares are taken of"
    return Case(name, title, _RESTATED.format(test) + ", in gross sliding", reason,
                made | {"variant": variants}, tuple(rows), CHUNG_OOI)  # fmt: skip


def no_slip() -> Case:
    """Opposite angular velocities of two equal spheres without slip stay as they are."""
    radius, speed, spin, solid = 2.5e-3, 3.9, 300.0, of_table("alumina")
    reduced = two(solid, radius, solid, radius)
    bodies = [sphere(radius, radius, (0.0, -speed / 2), spin, material=1),
              sphere(radius, -radius, (0.0, speed / 2), -spin, material=1)]  # fmt: skip
    rounding = 1e-9 * spin
    rows = [Row("", "angular velocity", spin, rounding, 1),
            Row("", "angular velocity", -spin, rounding, 2),
            Row("", "normal velocity", 0.8 * speed / 2, ONE * speed, 1)]  # fmt: skip
    return Case("no-slip", "Spheres that roll on each other keep their angular velocities",
                "closed form: the surfaces move alike, so that there is no friction",
                f"{_REASON}; without slip rounding of the steps alone",
                setup([solid], bodies, hertz(0.5, 0.8), reduced, speed), tuple(rows))  # fmt: skip


def cases() -> list[Case]:
    """All of this module."""
    pair = rotating_pair("rotating-pair", "A rotating sphere meets an equal one", 7, 1.0, 1.0)
    unlike = rotating_pair("rotating-on-larger", "A rotating sphere meets a larger one", 8, 5.0,
                           1000.0)  # fmt: skip
    return [elastic_pair(), elastic_wall(), restitution(), zero_force(), oblique(),
            tangential_speeds(), spin_on_wall(), pair, unlike, no_slip(), grazing()]  # fmt: skip
