"""A shape family from outside the package: registered by a public call, named in a command."""

import numpy as np
import pytest
from small_damper import damper3d, write_damper

from damper3d import register_shape, shapes
from damper3d.case.case import DamperCase
from damper3d.shapes import Family, MultiSphere, Surface, Value, filled
from damper3d.shapes.surfaces.surface import unit_sphere
from granulab.errors import InputError


def ellipsoid(
    numbers: tuple[float, ...], sub_spheres: int | None, tolerance: float | None
) -> MultiSphere:
    """Half axes r, 1 and 1/r at an equal-volume radius of 1 m, filled with spheres."""
    half = np.array([numbers[0], 1.0, 1.0 / numbers[0]])
    ball = unit_sphere()
    surface = Surface(ball.vertices * half, ball.triangles)
    volume = 4.0 / 3.0 * np.pi
    inertia = volume / 5.0 * (np.sum(half**2) - half**2)
    area = float(0.5 * np.linalg.norm(np.cross(*np.diff(surface.corners, axis=1).swapaxes(0, 1)),
                                      axis=1).sum())  # fmt: skip
    solid = shapes.Solid(surface, 0.01, volume, area, inertia)
    return filled(solid, "ellipsoid", sub_spheres, tolerance)


FAMILY = Family("ellipsoid:1.5", ellipsoid, values=(Value("ratio of the half axes", 1.0, 3.0),))


@pytest.fixture
def registered():
    """The family, only as long as a test lasts."""
    register_shape("ellipsoid", FAMILY)
    yield "ellipsoid:1.5"
    del shapes.FAMILIES["ellipsoid"]


def test_a_case_names_a_shape_from_outside(registered):
    changes = {"particles.shape": registered, "particles.sub_spheres": 20}
    case = DamperCase.load("thesis", changes)
    assert case.particle.name == "ellipsoid:1.5"
    assert 1 < len(case.particle.radii) <= 20
    assert case.particle.equal_volume_radius == pytest.approx(3.8e-3)
    assert case.count == 90


def test_the_command_shakes_it_and_says_what_is_wrong_with_a_number(registered, tmp_path):
    changes = {"particles.shape": None, "particles.count": 6, "run.cycles": 1, "run.discard": 0}
    options = ["--particles", registered, "--sub-spheres", "4"]
    result = damper3d(
        "run", write_damper(tmp_path, changes), *options, "--out", tmp_path, "--json", "--quiet",
        "--no-figures",
    )  # fmt: skip
    found = result.json
    assert found["particles"] == "ellipsoid:1.5"
    assert found["n_particles"] == 6
    with pytest.raises(InputError, match=r"ratio of the half axes must be from 1 to 3"):
        DamperCase.load("thesis", {"particles.shape": "ellipsoid:4"})


def test_a_name_is_registered_once(registered):
    for name in ("ellipsoid", "prolate", "sphere", "mesh"):
        with pytest.raises(InputError, match="there is one of that name"):
            register_shape(name, FAMILY)
    with pytest.raises(InputError, match="must be a word"):
        register_shape("a b", FAMILY)
