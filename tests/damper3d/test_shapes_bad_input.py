"""Shapes that cannot be: one line that says what is wrong and what would do."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from fuzzing import examples
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from made_meshes import CUBE, CUBE_FACES, rotation, write_obj

from damper3d.shapes.multisphere import MultiSphere
from damper3d.shapes.particle import FAMILIES, parse_particle
from damper3d.shapes.surfaces.mesh_check import sound
from damper3d.shapes.surfaces.surface import unit_sphere
from granulab.errors import InputError


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("prolate:0.5", ["aspect ratio", "from 1 to 10", "prolate:1.5"]),
        ("prolate:nan", ["from 1 to 10"]),
        ("prolate:long", ["not a number", "prolate:1.5"]),
        ("oblate:1.5", ["from 0.2 to 1", "oblate:0.7"]),
        ("toroid:1", ["hole ratio", "from 0 to 0.8"]),
        ("toroid", ["hole ratio", "not a number"]),
        ("cylinder:1.5", ["length over diameter, rounding", "cylinder:1.5,0.2"]),
        ("cylinder:0.3,0.5", ["at most the length"]),
        ("superquadric:1,1,0.1,1", ["exponent e1", "from 0.3 to 1.6"]),
        ("prolat:2", ["did you mean 'prolate'"]),
        ("mesh:none.stl", ["'none.stl'", "cannot be read"]),
        ("mesh:", ["cannot be read"]),
    ],
)
def test_a_shape_that_cannot_be(text, words):
    with pytest.raises(InputError) as error:
        parse_particle(text)
    line = str(error.value)
    assert "\n" not in line
    for word in words:
        assert word in line


@pytest.mark.parametrize(
    ("text", "given_values", "words"),
    [
        ("prolate:2", {"sub_spheres": 50}, ["must be odd", "51"]),
        ("prolate:10", {"sub_spheres": 21}, ["from 23 to 1000"]),
        ("toroid:0.2", {"sub_spheres": 4}, ["from 5 to 1000"]),
        ("oblate:0.7", {"sub_spheres": 1001}, ["from 1 to 1000"]),
        ("oblate:0.7", {"tolerance": 1e-4}, ["from 0.001 to 0.5"]),
        ("toroid:0.2", {"tolerance": 0.01, "sub_spheres": 50}, ["both given"]),
        ("sphere:5mm", {"sub_spheres": 3}, ["sub_spheres goes with other shapes", "leave it out"]),
        ("sphere:5mm", {"tolerance": 0.1}, ["tolerance goes with other shapes"]),
        ("toroid:0.2", {"mesh_unit": "mm"}, ["mesh_unit goes with a mesh"]),
        ("mesh:x.stl", {"mesh_unit": "mm", "equal_volume_radius": 1e-3}, ["leave one of them"]),
        ("mesh:x.stl", {"mesh_unit": "nan"}, ["mesh_unit", "unknown unit 'nan'"]),
        ("mesh:x.stl", {"mesh_unit": "1e-300 mm"}, ["mesh_unit = 1e-303 m", "check the unit"]),
    ],
)
def test_sub_spheres_that_cannot_be(text, given_values, words):
    with pytest.raises(InputError) as error:
        parse_particle(text, **given_values)
    for word in words:
        assert word in str(error.value)


def two_cubes(apart: float) -> tuple[np.ndarray, list[tuple[int, ...]]]:
    """One next to the other."""
    faces = [tuple(k + 8 for k in face) for face in CUBE_FACES]
    return np.concatenate([CUBE, CUBE + np.array([apart, 0.0, 0.0])]), [*CUBE_FACES, *faces]


def bent_through() -> tuple[np.ndarray, list[tuple[int, ...]]]:
    """A ball with one corner pushed through the opposite side."""
    ball = unit_sphere(1)
    vertices = ball.vertices.copy()
    vertices[0] *= -2.0
    return vertices, [tuple(t) for t in ball.triangles.tolist()]


def fanned(x: float, y: float) -> tuple[np.ndarray, list[tuple[int, ...]]]:
    """The cube with one face cut into triangles about a point of its plane, from 0 to 1 inside."""
    low, high = CUBE.min(axis=0), CUBE.max(axis=0)
    face = next(f for f in CUBE_FACES if (CUBE[list(f), 2] == high[2]).all())
    apex = low + np.array([x, y, 1.0]) * (high - low)
    fan = [(a, b, 8) for a, b in zip(face, [*face[1:], face[0]], strict=True)]
    return np.vstack([CUBE, apex]), [*(f for f in CUBE_FACES if f != face), *fan]


def folded_within() -> tuple[np.ndarray, list[tuple[int, ...]]]:
    """The same, one of its four triangles cut about a point that lies in the next but one."""
    vertices, faces = fanned(0.5, 0.5)
    *others, (a, b, apex) = faces
    point = 1.5 * vertices[apex] - 0.25 * (vertices[a] + vertices[b])
    return np.vstack([vertices, point]), [*others, (a, b, 9), (b, apex, 9), (apex, a, 9)]


def with_a_sliver() -> tuple[np.ndarray, list[tuple[int, ...]]]:
    """The cube with a corner on one edge that one of the two faces there does not have."""
    (a, b, c, d), *others = CUBE_FACES
    middle = 0.5 * (CUBE[a] + CUBE[b])
    return np.vstack([CUBE, middle]), [(a, 8, c, d), (8, b, c), (a, b, 8), *others]


MESHES = {
    "folded": (folded_within, ["has faces that lie on each other, near ("]),
    "sliver": (with_a_sliver, ["1 triangles have their corners in a line", "T-vertices"]),
    "open": (lambda: (CUBE, CUBE_FACES[1:]), ["4 edges are of one triangle only", "close"]),
    "walled": (lambda: two_cubes(1.0), ["of three triangles or more"]),
    "pieces": (lambda: two_cubes(5.0), ["more than one piece"]),
    "crossing": (bent_through, ["cuts itself", "near ("]),
    "flat": (lambda: (CUBE, [(0, 1, 2), (0, 2, 1)]), ["no volume"]),
    "empty": (lambda: (CUBE, []), ["no triangles"]),
}


@pytest.mark.parametrize("kind", MESHES)
def test_a_mesh_that_encloses_no_body(kind, tmp_path):
    make, words = MESHES[kind]
    path = write_obj(tmp_path / "bad.obj", *make())
    with pytest.raises(InputError) as error:
        parse_particle(f"mesh:{path}")
    assert "\n" not in str(error.value)
    for word in ["bad.obj", *words]:
        assert word in str(error.value)


@given(st.floats(-0.5, 1.5), st.floats(-0.5, 1.5), st.floats(0.0, 6.0))
def test_a_face_that_is_folded_back_is_found_wherever_it_is(x, y, angle):
    """And only then: the point about which it is cut lies outside the face, where its triangles
    are a flap without thickness (which may touch other faces too, and in line with a rim has
    none); however the cube is turned."""
    margin = min(x, y, 1.0 - x, 1.0 - y)
    assume(abs(margin) > 0.01)  # nearer to its rim triangles are flat or nearly so
    vertices, faces = fanned(x, y)
    vertices = vertices @ rotation(np.array([1.0, 2.0, -1.0]), angle).T
    corners = np.array([vertices[[f[0], b, c]] for f in faces for b, c in pairwise(f[1:])])
    if margin > 0.0:
        assert len(sound(corners, "cube").triangles) == len(corners)
    else:
        with pytest.raises(InputError, match=r"'cube': (has faces that|cuts itself|1 tri)"):
            sound(corners, "cube")


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("x.ply", b"ply"), ("x.stl", b""), ("x.stl", b"\x00" * 90),
        ("x.stl", b"solid\nvertex 0 0 zero\n"), ("x.obj", b"f 1 2 3\n"),
        ("x.obj", b"v 0 0 0\nv 1 0 0\nv 0 inf 0\nf 1 2 3\n"),
        ("x.obj", b"v 0 0\nv 1 0\nv 0 1\nf 1 2 3\n"), ("x.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n"),
        ("x.stl", b"solid x\nendsolid x\n"),
    ],
)  # fmt: skip
def test_a_file_that_is_no_mesh(name, data, tmp_path):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError, match=r"mesh '.*x\.\w+'"):
        parse_particle(f"mesh:{name}", folder=tmp_path)


def particle_or_line(text: str) -> MultiSphere | str:
    try:
        return parse_particle(text, folder=Path("none"))
    except InputError as error:
        return str(error)


@given(st.text(max_size=12), st.sampled_from(["sphere", "prolate", "toroid", "mesh", ""]))
@settings(deadline=None, max_examples=examples(40))
def test_any_text_is_a_particle_or_refused_in_one_line(text, kind):
    """Of families that cost nothing to make; the others share their reading of numbers."""
    found = particle_or_line(f"{kind}:{text}")
    if isinstance(found, str):
        assert found.isprintable()
    else:
        assert found.volume > 0.0


@given(st.sampled_from(sorted(FAMILIES)), st.lists(st.floats(), min_size=1, max_size=5))
@settings(deadline=None)
def test_numbers_of_a_shape_are_as_written_and_in_range(kind, numbers):
    family = FAMILIES[kind]
    text = ",".join(repr(number) for number in numbers)
    in_range = len(numbers) == len(family.values) and all(
        value.low <= number <= value.high
        for number, value in zip(numbers, family.values, strict=True)
    )
    if in_range:
        assert family.numbers(kind, text) == tuple(numbers)
    else:
        with pytest.raises(InputError):
            family.numbers(kind, text)
