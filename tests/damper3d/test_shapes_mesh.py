"""Meshes: reading, turning outwards, and the exact mass properties of what they enclose."""

import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_meshes import CUBE, CUBE_FACES, cuboid, rotation, write_obj

from damper3d.case.case import DamperCase
from damper3d.shapes.mesh import read_mesh
from damper3d.shapes.particle import parse_particle
from damper3d.shapes.surfaces.mesh_check import sound
from damper3d.shapes.surfaces.mesh_data import as_obj, mass_of, principal_axes, read_triangles
from damper3d.shapes.surfaces.surface import unit_sphere

SIDES = st.floats(0.1, 10.0)
POINT = st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3).map(np.array)


@given(st.tuples(SIDES, SIDES, SIDES), POINT, POINT, st.floats(0.0, 6.0))
@settings(deadline=None)
def test_mass_properties_of_a_box_at_any_position_and_orientation(sides, place, axis, angle):
    """V = abc, I = V (b^2 + c^2)/12; exact but for rounding, of which sides of 100:1 take 1e-8."""
    turn = rotation(axis + np.array([0.0, 0.0, 2.0]), angle)
    mass = mass_of(cuboid(sides) @ turn.T + 10.0 * place)
    a, b, c = sides
    volume = a * b * c
    assert mass.volume == pytest.approx(volume, rel=1e-9)
    assert mass.area == pytest.approx(2.0 * (a * b + b * c + c * a), rel=1e-9)
    middle = turn @ (0.5 * np.array(sides)) + 10.0 * place
    assert mass.centroid == pytest.approx(middle, abs=1e-9 * max(sides))
    moments = volume / 12.0 * (sum(x * x for x in sides) - np.square(sides))
    found, axes = principal_axes(mass.inertia)
    assert found == pytest.approx(np.sort(moments), rel=1e-8)
    tensor = turn @ np.diag(moments) @ turn.T
    assert mass.inertia == pytest.approx(tensor, abs=1e-8 * moments.max())
    assert axes @ np.diag(found) @ axes.T == pytest.approx(tensor, abs=1e-8 * moments.max())
    assert np.linalg.det(axes) == pytest.approx(1.0)


def test_mass_properties_of_a_pyramid_whose_corners_are_not_about_its_centroid():
    """V = a^2 h/3, centroid at h/4, I = V a^2/10 about its axis, V (a^2/20 + 3 h^2/80) across."""
    a, h = 2.0, 3.0
    base = 0.5 * a * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
    corners = np.vstack([base, [0.0, 0.0, h]])
    faces = [(0, 2, 1), (0, 3, 2), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    mass = mass_of(corners[np.array(faces)])
    volume = a**2 * h / 3.0
    assert mass.volume == pytest.approx(volume, rel=1e-12)
    assert mass.centroid == pytest.approx([0.0, 0.0, h / 4.0], abs=1e-12)
    across = volume * (a**2 / 20.0 + 3.0 * h**2 / 80.0)
    assert np.diag(mass.inertia) == pytest.approx([across, across, volume * a**2 / 10.0], rel=1e-12)


def test_mass_properties_of_a_regular_tetrahedron():
    """V = s^3/(6 sqrt 2), I = V s^2/20 about any axis through its centroid."""
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], float)
    faces = np.array([(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)])
    mass, side = mass_of(corners[faces]), np.sqrt(8.0)
    assert mass.volume == pytest.approx(side**3 / (6.0 * np.sqrt(2.0)), rel=1e-14)
    assert mass.inertia == pytest.approx(mass.volume * side**2 / 20.0 * np.eye(3), abs=1e-13)


def stl_binary(corners: np.ndarray) -> bytes:
    records = [struct.pack("<12fH", 0, 0, 0, *triangle.ravel().tolist(), 0) for triangle in corners]
    head = b"solid binary files may begin so".ljust(80)
    return head + struct.pack("<I", len(records)) + b"".join(records)


def stl_text(corners: np.ndarray) -> bytes:
    lines = ["solid box"]
    for triangle in corners.tolist():
        lines += ["facet normal 0 0 0", " outer loop"]
        lines += ["  vertex " + " ".join(f"{x:.8e}" for x in corner) for corner in triangle]
        lines += [" endloop", "endfacet"]
    return "\n".join([*lines, "endsolid box"]).encode()


@pytest.mark.parametrize("write", [stl_binary, stl_text, lambda c: as_obj(c).encode()])
@pytest.mark.parametrize("turned", ["outwards", "inwards", "mixed"])
def test_a_box_from_any_file_whatever_the_sense_of_its_faces(write, turned, tmp_path):
    """Single numbers of STL leave 1e-7."""
    corners = cuboid((1.0, 2.0, 3.0))
    flip = {"outwards": slice(0), "inwards": slice(None), "mixed": slice(0, None, 3)}[turned]
    corners[flip] = corners[flip, ::-1]
    path = tmp_path / ("box.obj" if write(corners)[:1] == b"v" else "box.stl")
    path.write_bytes(write(corners))
    solid, radius = read_mesh(path)
    assert solid.volume * radius**3 == pytest.approx(6.0, rel=1e-6)
    assert solid.area * radius**2 == pytest.approx(22.0, rel=1e-6)
    assert solid.inertia * radius**5 == pytest.approx([2.5, 5.0, 6.5], rel=1e-6)
    assert np.ptp(solid.surface.vertices, axis=0) * radius == pytest.approx([3, 2, 1], rel=1e-6)
    assert np.linalg.det(solid.surface.corners).sum() > 0.0


def test_faces_of_many_corners_and_numbers_from_the_end(tmp_path):
    write_obj(tmp_path / "cube.obj", CUBE, CUBE_FACES)
    backwards = [tuple(k - 8 for k in face) for face in CUBE_FACES]
    lines = [f"v {x} {y} {z}" for x, y, z in CUBE] + [
        "f " + " ".join(str(k) for k in face) for face in backwards
    ]
    (tmp_path / "back.obj").write_text("\n".join(lines), encoding="utf-8")
    for name in ("cube.obj", "back.obj"):
        assert mass_of(read_triangles(tmp_path / name)).volume == pytest.approx(1.0)


def test_touching_neighbours_do_not_count_as_a_cut():
    """A ball of 320 triangles, each of which touches 12 others at corners and edges."""
    ball = unit_sphere(2)
    assert len(sound(ball.corners, "ball").triangles) == 320


def test_a_run_keeps_its_mesh_and_is_the_same_from_its_folder(tmp_path):
    """Also with a unit: corners of 1.5 in units of 2 mm."""
    rounded = unit_sphere(1)
    path = write_obj(tmp_path / "ball.obj", 1.5 * rounded.vertices, rounded.triangles.tolist())
    changes = {
        "particles.shape": f"mesh:{path}",
        "particles.mesh_unit": "2 mm",
        "particles.tolerance": 0.1,
    }
    case = DamperCase.load("thesis", changes)
    assert 2.7e-3 < case.particle.equal_volume_radius < 3e-3
    folder = tmp_path / "run"
    folder.mkdir()
    for name, text in {**case.files, "case.toml": case.to_toml()}.items():
        (folder / name).write_text(text, encoding="utf-8")
    again = DamperCase.load(folder / "case.toml")
    for field in ("offsets", "radii", "inertia"):
        assert np.array_equal(getattr(again.particle, field), getattr(case.particle, field))
    assert again.particle.name == case.particle.name == "mesh:ball"
    assert again.particle.volume == case.particle.volume


def test_a_mesh_of_a_sphere_is_one_sub_sphere(tmp_path):
    """1280 triangles lie at most 0.5 % of the radius inside of the ball: one does for 2 %."""
    ball = unit_sphere(3)
    path = write_obj(tmp_path / "ball.obj", ball.vertices, ball.triangles.tolist())
    particle = parse_particle(f"mesh:{path}", 1.0)
    assert (len(particle.radii), particle.arrangement) == (1, "ball")
    assert particle.offsets == pytest.approx(0.0, abs=0.01)
    assert particle.surface_error < 0.01
