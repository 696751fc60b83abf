"""From materials to the constants of the contact law of spheres."""

import dataclasses
import math

import pytest
from analytic import hertz_impact

from granulab.contact import load_table
from granulab.contact.reduced import (
    bore_curvature,
    reduced_mass,
    reduced_radius,
    shear_modulus,
    sphere_mass,
)
from granulab.contact.sphere_law import hertz_validity, sphere_law, wave_speed, yield_velocity
from granulab.errors import InputError

ACRYLIC = load_table("acrylic").material("acrylic")
STEEL = load_table("steel").material("steel")


def test_constants_of_two_equal_materials():
    """kt/kn = 6 G*/E* = 3 (1 - nu)/(2 - nu), half of it on Mindlin's tangent stiffness
    (eqs 5.6, 5.14 with the erratum); b, c_n and c_t of eqs 5.32, 5.33."""
    law = sphere_law(ACRYLIC, ACRYLIC, friction=0.52, restitution=0.86)
    assert law.hertz == pytest.approx(4 / 3 * 3.3e9 / (2 * (1 - 0.37**2)))
    assert law.tangential == pytest.approx(3 * (1 - 0.37) / (2 - 0.37))
    assert law.damping == pytest.approx(-math.log(0.86) / math.hypot(math.log(0.86), math.pi))
    assert law.tangential_damping == pytest.approx(math.sqrt(10 / 3 * law.tangential))
    assert law.yielding == math.inf
    assert law.pulls
    assert not law.stored_force


def test_rigid_body_doubles_the_modulus_of_equal_spheres():
    alone = sphere_law(STEEL, None, friction=0.4, restitution=1.0)
    pair = sphere_law(STEEL, STEEL, friction=0.4, restitution=1.0)
    assert alone.hertz == pytest.approx(2 * pair.hertz)
    assert alone.tangential == pytest.approx(pair.tangential)
    assert alone.damping == 0.0


def test_unlike_materials_are_named_in_either_order():
    there = sphere_law(ACRYLIC, STEEL, friction=0.3, restitution=0.7)
    assert there == pytest.approx(sphere_law(STEEL, ACRYLIC, friction=0.3, restitution=0.7))


@pytest.mark.parametrize(("key", "example"), [("youngs_modulus", '"3.3 GPa"'), ("poisson", "0.37")])
def test_missing_constant_is_named(key, example):
    lacking = dataclasses.replace(ACRYLIC, **{key: None})
    with pytest.raises(InputError) as error:
        sphere_law(ACRYLIC, lacking, friction=0.5, restitution=0.8)
    assert (
        str(error.value) == f"material 'acrylic' has no {key}; give one, such as {key} = {example}"
    )


@pytest.mark.parametrize("e", [0.0, -0.1, 1.1])
def test_impossible_restitution_is_refused(e):
    with pytest.raises(InputError, match="must be above 0 and at most 1"):
        sphere_law(ACRYLIC, ACRYLIC, friction=0.5, restitution=e)


def test_curvature_of_a_wall():
    """Flat: R = r. The inside of a cylinder: r D/(D - r)."""
    assert reduced_radius(1 / 2.5e-3, 0.0) == pytest.approx(2.5e-3)
    assert reduced_radius(1 / 2.5e-3, bore_curvature(40e-3)) == pytest.approx(2.5e-3 * 40 / 37.5)


@pytest.mark.parametrize(
    ("material", "against", "radius", "published", "digits"),
    [
        (ACRYLIC, "sphere", 2.5e-3, 3.5, 0.05),  # sec. 6.2.2
        (ACRYLIC, "wall", 2.5e-3, 7.0, 0.05),
        (STEEL, "sphere", 2.5e-3, 0.15, 0.005),
    ],
)
def test_yield_velocity(material, against, radius, published, digits):
    """Thesis, eq. 5.26: as printed, to its digits; each pair with its own radius and mass."""
    inverse = 1 / sphere_mass(radius, material.density.value)
    pair = against == "sphere"
    r = reduced_radius(1 / radius, 1 / radius if pair else 0.0)
    m = reduced_mass(inverse, inverse if pair else 0.0)
    assert yield_velocity(material, material, radius=r, mass=m) == pytest.approx(
        published, abs=digits
    )


@pytest.mark.parametrize("material", [ACRYLIC, STEEL])
def test_wave_speed_is_that_of_the_constrained_modulus(material):
    """Eq. 5.12: rho c^2 = lambda + 2 G, the modulus of a column that cannot widen. Its
    1 - nu - 2 nu^2 is (1 + nu)(1 - 2 nu); steel of Table 5.1 has 5,940 m/s."""
    modulus, nu = material.youngs_modulus.value, material.poisson.value
    shear = shear_modulus(modulus, nu)
    column = shear * (2 * nu / (1 - 2 * nu) + 2)
    assert material.density.value * wave_speed(material) ** 2 == pytest.approx(column, rel=1e-12)
    assert wave_speed(STEEL) == pytest.approx(5940, abs=1)


@pytest.mark.parametrize("speed", [0.01, 1.0, 9.0])
@pytest.mark.parametrize("radius", [1.5e-3, 20e-3])
def test_validity_of_hertz_s_law_counts_waves_in_a_contact(speed, radius):
    """Eq. 5.11: with m = 4/3 pi rho R^3 a contact on a rigid wall lasts
    T = 2.8683 (m^2/(R E*^2 v))^(1/5), and with rho c^2 = M a wave crosses the sphere in it

        T c/(2 R) = 1.4342 (16 pi^2/9)^(1/5) (M/E*)^(2/5) (c/v)^(1/5)

    times, whatever the radius. Tolerance: the digits of 2.8683."""
    modulus, nu = ACRYLIC.youngs_modulus.value, ACRYLIC.poisson.value
    stiff, c = modulus / (1 - nu**2), wave_speed(ACRYLIC)
    mass = sphere_mass(radius, ACRYLIC.density.value)
    _, _, lasts = hertz_impact(stiff, radius, mass, speed)
    column = ACRYLIC.density.value * c**2
    factor = 1.43415 * (16 * math.pi**2 / 9) ** 0.2 * (column / stiff) ** 0.4
    crossings = lasts * c / (2 * radius)
    assert crossings == pytest.approx(factor * hertz_validity(c, speed), rel=1e-4)
