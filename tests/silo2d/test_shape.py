"""Particle cross sections: mass integrals against closed forms and shapely, and what is refused."""

import math

import numpy as np
import pytest
import shapely
from fuzzing import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from granulab.errors import InputError
from silo2d.case.shape import ShapeSet, mass_integrals, shape_from_outline
from silo2d.case.shapefile import load_shapes

SQUARE = np.array([[0.0, 0.0], [15e-3, 0.0], [15e-3, 15e-3], [0.0, 15e-3]])
QUAD_SEGS = 64


@st.composite
def convex_cores(draw):
    """Polygons with corners on an ellipse: convex, 3 to 9 corners, some of them sharp."""
    gaps = draw(st.lists(st.floats(0.3, 1.0), min_size=3, max_size=9))
    angle = 2 * np.pi * np.cumsum(gaps) / sum(gaps) + draw(st.floats(0.0, 6.0))
    axes = draw(st.floats(2e-3, 20e-3)), draw(st.floats(2e-3, 20e-3))
    return np.column_stack([axes[0] * np.cos(angle), axes[1] * np.sin(angle)])


def grown(core, spheroradius):
    """The outer outline of a core: its faces moved outwards, the corners kept sharp."""
    outline = shapely.Polygon(core).buffer(spheroradius, join_style="mitre", mitre_limit=1e9)
    return np.array(shapely.geometry.polygon.orient(outline).exterior.coords)[:-1]


def polar_moment(ring, about):
    """Fan of triangles, each A/12 (|a|^2 + |b|^2 + |c|^2 + |a + b + c|^2) about the origin."""
    b = np.asarray(ring) - about
    c = np.roll(b, -1, axis=0)
    area = (b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0]) / 2
    return (area / 12 * (b**2 + c**2 + (b + c) ** 2).sum(axis=1)).sum()


@given(core=convex_cores(), spheroradius=st.floats(0.1e-3, 3e-3))
@settings(max_examples=examples(60), deadline=None)
def test_mass_integrals_agree_with_a_dense_polygon(core, spheroradius):
    """Tolerance: the dense polygon's chords miss r^2/2 (a - sin a) of each arc step a, together
    at most pi r^2 a^2/6; GEOS steps by at most 1.5 quanta of 90 deg/QUAD_SEGS."""
    area, centroid, polar = mass_integrals(core, spheroradius)
    dense = shapely.Polygon(core).buffer(spheroradius, quad_segs=QUAD_SEGS)
    ring = np.array(shapely.geometry.polygon.orient(dense).exterior.coords)[:-1]
    step = 1.5 * np.pi / 2 / QUAD_SEGS
    missed = np.pi * spheroradius**2 * step**2 / 6
    reach = np.hypot(*(ring - centroid).T).max()
    rounding = 1e-9
    assert area == pytest.approx(dense.area, abs=missed, rel=rounding)
    middle = np.array(dense.centroid.coords[0])
    assert_allclose(centroid, middle, atol=missed * reach / area + rounding * reach, rtol=0)
    assert polar == pytest.approx(polar_moment(ring, centroid), abs=missed * reach**2, rel=rounding)


@given(core=convex_cores(), spheroradius=st.floats(0.1e-3, 3e-3))
@settings(max_examples=examples(60), deadline=None)
def test_shrinking_undoes_growing(core, spheroradius):
    """The core of a grown core is that core, moved to the centroid of the rounded shape.
    Tolerance: rounding, magnified by sharp corners (a mitre of up to some 100 r)."""
    shape = shape_from_outline("s", grown(core, spheroradius), spheroradius, "here")
    _, centroid, _ = mass_integrals(core, spheroradius)
    expected = core - centroid
    start = np.argmin(np.hypot(*(shape.core - expected[0]).T))
    assert_allclose(np.roll(shape.core, -start, axis=0), expected, rtol=0, atol=1e-9)


@given(core=convex_cores(), spheroradius=st.floats(0.1e-3, 3e-3))
@settings(max_examples=examples(60), deadline=None)
def test_rounded_outline_lies_in_the_outline_and_touches_every_face(core, spheroradius):
    """Tolerance: rounding, 1e-12 m, and the same for the faces' distance."""
    outline = grown(core, spheroradius)
    shape = shape_from_outline("s", outline, spheroradius, "here")
    _, centroid, _ = mass_integrals(core, spheroradius)
    drawn = shape.rounded_outline(points_per_corner=7)
    assert len(drawn) == 7 * len(core)
    outer = shapely.Polygon(outline - centroid)
    assert outer.buffer(1e-9, join_style="mitre").contains(shapely.Polygon(drawn))
    ends = outline - centroid
    for a, b in zip(ends, np.roll(ends, -1, axis=0), strict=True):
        normal = np.array([b[1] - a[1], a[0] - b[0]]) / math.dist(a, b)
        assert ((drawn - a) @ normal).max() == pytest.approx(0.0, abs=1e-9)
    assert np.hypot(*drawn.T).max() <= shape.bounding_radius * (1 + 1e-12)


def test_rounded_square_has_its_closed_form_integrals():
    """Side a = s + 2 r: area s^2 + 4 s r + pi r^2; the moment is that of the core, four
    rectangles and four quarter discs moved to the corners. Tolerance: rounding."""
    s, r = 13e-3, 1e-3
    shape = shape_from_outline("12", SQUARE, r, "here")
    assert shape.area == pytest.approx(s**2 + 4 * s * r + np.pi * r**2, rel=1e-13)
    rectangle = s * r * ((s**2 + r**2) / 12 + (s / 2 + r / 2) ** 2)
    # Quarter disc at (s/2, s/2): 2 integral of (s/2 + x)^2 = 2 (s^2/4 A + s r^3/3) + pi r^4/8.
    quarter = 2 * (s**2 / 4 * np.pi * r**2 / 4 + s * r**3 / 3) + np.pi * r**4 / 8
    assert shape.polar_moment == pytest.approx(s**4 / 6 + 4 * rectangle + 4 * quarter, rel=1e-13)
    assert shape.bounding_radius == pytest.approx(s / math.sqrt(2) + r, rel=1e-13)


def test_unrounded_limit_is_the_rectangle():
    """r -> 0: area w h, moment w h (w^2 + h^2)/12. Tolerance: terms of order r/h."""
    w, h, r = 20e-3, 10e-3, 1e-9
    shape = shape_from_outline("13", [[0, 0], [w, 0], [w, h], [0, h]], r, "here")
    assert shape.area == pytest.approx(w * h, rel=r / h)
    assert shape.polar_moment == pytest.approx(w * h * (w**2 + h**2) / 12, rel=r / h)


def test_tiny_core_is_a_disc():
    """Core -> 0: area pi r^2, moment pi r^4/2. Tolerance: terms of order side/r."""
    r, side = 5e-3, 1e-6
    outline = SQUARE / 15e-3 * (2 * r + side)
    shape = shape_from_outline("disc", outline, r, "here")
    assert shape.area == pytest.approx(np.pi * r**2, rel=2 * side / r)
    assert shape.polar_moment == pytest.approx(np.pi * r**4 / 2, rel=4 * side / r)


@given(core=convex_cores(), angle=st.floats(0, 2 * np.pi), shift=st.floats(-1, 1))
@settings(max_examples=examples(40), deadline=None)
def test_mass_integrals_do_not_depend_on_where_the_outline_lies(core, angle, shift):
    """Tolerance: rounding of coordinates near 1 m against edges of some 1 mm."""
    r = 1e-3
    rotation = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    area, centroid, polar = mass_integrals(core, r)
    moved_area, moved_centroid, moved_polar = mass_integrals(core @ rotation.T + shift, r)
    assert moved_area == pytest.approx(area, rel=1e-10)
    assert moved_polar == pytest.approx(polar, rel=1e-10)
    assert_allclose(moved_centroid, rotation @ centroid + shift, atol=1e-12, rtol=0)


def test_core_is_given_about_the_centroid_of_the_rounded_shape():
    """A trapezoid, whose rounded centroid is not that of its core. Tolerance: rounding."""
    outline = 1e-3 * np.array([[0, 0], [20, 0], [15, 14], [5, 14]])
    shape = shape_from_outline("15", outline, 3e-3, "here")
    _, centroid, _ = mass_integrals(shape.core, 3e-3)
    assert_allclose(centroid, 0, atol=1e-16)
    assert abs(shapely.Polygon(shape.core).centroid.y) > 1e-5


def test_collinear_points_are_merged():
    outline = [[0, 0], [7e-3, 0], [8e-3, 0], [15e-3, 0], [15e-3, 15e-3], [0, 15e-3], [0, 1e-3]]
    merged = shape_from_outline("s", outline, 1e-3, "here")
    plain = shape_from_outline("s", SQUARE, 1e-3, "here")
    assert_allclose(merged.core, plain.core, rtol=0, atol=1e-17)


@pytest.mark.parametrize(
    ("outline", "complaint"),
    [
        ([[0, 0], [1, 0]], "2 points; a polygon needs at least 3"),
        ([[0, 0], [1, 0], [1, 1], [0, 0]], "points 4 and 1 are the same"),
        ([[0, 0], [1, 0], [1, 0], [1, 1]], "points 2 and 3 are the same"),
        ([[0, 0], [0, 0], [0, 0]], "are the same"),
        ([[0, 0], [1, 0], [2, 0], [3, 0]], "zero area"),
        ([[0, 0], [1, 1], [1, 0], [0, 1]], "crosses or touches itself"),
        ([[0, 0], [1, 0], [2, 0], [1.5, 0], [1, 1]], "crosses or touches itself"),  # a spike
        ([[0, 0], [0, 1], [1, 1], [1, 0]], "clockwise; give the vertices counter-clockwise"),
        ([[0, 0], [2, 0], [2, 2], [1, 0.5]], r"concave at \(1000, 500\) mm"),
        ([[0, 0], [1, 0], [math.nan, 1]], "point 3 is not finite"),
        ([[0, 0], [1, 0], [1]], "expected a list of points"),
        ([[0, 0, 0], [1, 0, 0], [1, 1, 0]], "expected a list of points"),
        ([["0", "0"], ["1", "0"], ["1", "1"]], "expected a list of points"),
        ("square", "expected a list of points"),
    ],
)
def test_impossible_outlines_are_refused(outline, complaint):
    with pytest.raises(InputError, match=rf"^x\.toml: \[shape 12\] outline: .*{complaint}") as e:
        shape_from_outline("12", outline, 0.01, "x.toml")
    assert "\n" not in str(e.value)


@pytest.mark.parametrize("spheroradius", [0.0, -1e-3, math.nan, math.inf])
def test_spheroradius_must_be_positive(spheroradius):
    with pytest.raises(InputError, match=r"^here: \[shape a\] spheroradius = .* mm: must be pos"):
        shape_from_outline("a", SQUARE, spheroradius, "here")


def test_spheroradius_may_not_swallow_an_edge():
    """A 20 x 10 mm rectangle shrinks to a line at r = 5 mm; a short bevel goes much earlier:
    an edge l between two 45 deg turns is gone at l/(2 tan 22.5 deg)."""
    rectangle = 1e-3 * np.array([[0, 0], [20, 0], [20, 10], [0, 10]])
    shape_from_outline("r", rectangle, 4.99e-3, "here")
    with pytest.raises(InputError, match=r"\[shape r\] spheroradius = 5 mm: .* less than 5 mm"):
        shape_from_outline("r", rectangle, 5e-3, "here")
    bevelled = 1e-3 * np.array([[1, 0], [20, 0], [20, 10], [0, 10], [0, 1]])
    gone = math.sqrt(2) / (2 * math.tan(math.pi / 8))
    shape_from_outline("b", bevelled, 0.99e-3 * gone, "here")
    with pytest.raises(InputError, match=rf"less than {gone:.4g} mm would do"):
        shape_from_outline("b", bevelled, 1.01e-3 * gone, "here")


def test_shares_weight_the_mean_area():
    small = shape_from_outline("s", SQUARE, 1e-3, "here")
    large = shape_from_outline("l", 2 * SQUARE, 1e-3, "here")
    assert ShapeSet("both", (small, large)).shares == (0.5, 0.5)
    uneven = ShapeSet("both", (small, large), (3.0, 1.0))
    assert uneven.mean_area == pytest.approx(0.75 * small.area + 0.25 * large.area)
    assert uneven.bounding_radius == large.bounding_radius


def test_wood19_has_the_sizes_of_the_reconstruction():
    """Mean area about 193 mm2, the primitives' own areas, no core edge below 0.5 mm."""
    wood = load_shapes("wood19")
    assert [shape.name for shape in wood.shapes] == [str(k) for k in range(1, 20)]
    assert 1e6 * wood.mean_area == pytest.approx(193, abs=1)
    rounded = {shape.name: shape.area for shape in wood.shapes}
    corner = (4 - np.pi) * 1e-6  # four right angles rounded by 1 mm
    assert rounded["12"] == pytest.approx(225e-6 - corner)
    assert rounded["13"] == pytest.approx(200e-6 - corner)
    # Three corners of 60 deg lose r^2 (cot 30 deg - 60 deg) each; 3 decimals of mm in the file.
    assert rounded["14"] == pytest.approx(
        math.sqrt(3) / 4 * 441e-6 - (3 * math.sqrt(3) - np.pi) * 1e-6, rel=5e-5
    )
    edges = [np.hypot(*(np.roll(s.core, -1, axis=0) - s.core).T).min() for s in wood.shapes]
    assert min(edges) > 0.5e-3


GOOD = """
schema = 1
spheroradius = "1 mm"
unit = "cm"
[[shape]]
name = "a"
share = 3
outline = [[0, 0], [2, 0], [2, 1], [0, 1]]
[[shape]]
name = "b"
outline = [[0, 0], [1, 0], [0, 1]]
"""


def test_shape_file_carries_units_and_shares(tmp_path):
    """Tolerance: rounding."""
    file = tmp_path / "mine.toml"
    file.write_text(GOOD)
    shapes = load_shapes(file)
    assert shapes.name == "mine"
    assert shapes.shares == (0.75, 0.25)
    assert shapes.shapes[0].area == pytest.approx(200e-6 - (4 - np.pi) * 1e-6, rel=1e-12)
    assert shapes.shapes[1].spheroradius == 1e-3


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("schema = 1", "schema = 2", r": schema = 2: unknown; this version reads 1"),
        ("schema = 1", "", r": schema is missing"),
        ('"1 mm"', "1", r": spheroradius = 1: the unit is missing"),
        ('"1 mm"', '"1e-200 mm"', r": spheroradius = 1e-203 m: 1e-10 to 1e\+07 m are taken"),
        ('"1 mm"', '"9 mm"', r": \[shape a\] spheroradius = 9 mm: too large"),
        ('"cm"', '"kg"', r": unit = '1 kg': the unit is wrong here"),
        ('"cm"', "10", r": unit = 10: expected a unit of length"),
        ("unit", "units", r": unknown key 'units'; did you mean 'unit'\?"),
        ("share = 3", "shares = 3", r": \[shape a\]: unknown key 'shares'; did you mean 'share'"),
        ("share = 3", "share = -1", r": \[shape a\] share = -1: must be positive"),
        ("share = 3", "share = nan", r": \[shape a\] share = nan: not a finite number"),
        ('name = "a"', "name = 12", r": \[shape number 1\] name = 12: expected a text"),
        ('name = "a"', "", r": missing: \[shape number 1\] name"),
        ('name = "a"', 'name = "b"', r": \[shape b\] occurs twice"),
        ("[0, 1]]\n[", "[0, 0.5, 1]]\n[", r": \[shape a\] outline: expected a list of points"),
        ("[0, 1]]\n[", "[nan, 1]]\n[", r": \[shape a\] outline: point 4 is not finite"),
        ("[2, 1], [0, 1]", "[0, 1], [2, 1]", r": \[shape a\] outline: crosses"),
        ("[[shape]]", "[[grain]]", r": unknown key 'grain'"),
        (GOOD[GOOD.index("[[") :], "shape = []", r": shape: write one \[\[shape\]\]"),
        (GOOD[GOOD.index("[[") :], "shape = [1]", r": \[shape number 1\]: expected a table"),
        ('"1 mm"', "1 mm", r": not valid TOML: .*line 3"),
    ],
)
def test_bad_shape_files_are_refused_in_one_line(tmp_path, old, new, complaint):
    file = tmp_path / "mine.toml"
    assert old in GOOD
    file.write_text(GOOD.replace(old, new))
    with pytest.raises(InputError, match=rf"mine\.toml{complaint}") as e:
        load_shapes(file)
    assert "\n" not in str(e.value)


def test_missing_shape_files_are_named(tmp_path):
    with pytest.raises(InputError, match=r"wood91: no such shapes file.*did you mean 'wood19'"):
        load_shapes("wood91")
    with pytest.raises(InputError, match="not a file"):
        load_shapes(tmp_path)
