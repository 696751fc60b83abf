"""From materials to the constants of the contact law of spheres."""

import dataclasses
import math

import pytest

from granulab.contact import load_table
from granulab.contact.reduced import bore_curvature, reduced_mass, reduced_radius, sphere_mass
from granulab.contact.sphere_law import sphere_law, yield_velocity
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
