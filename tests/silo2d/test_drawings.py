"""Silos and particles from drawings and photographs, against shapes of known area and size."""

import math
from pathlib import Path

import numpy as np
import pytest
from made_drawings import (
    A4,
    A4_DOWN,
    area_of,
    dxf,
    dxf_arc,
    dxf_line,
    dxf_polyline,
    photograph,
    regular,
    svg,
    svg_path,
)
from refusals import assert_refused, assert_refuses
from small_silo import DRY, silo2d

from silo2d.case.case import SiloCase
from silo2d.case.shapefile import load_shapes
from silo2d.drawings.curves import FLATNESS, joined, read_drawing
from silo2d.drawings.outline import outline_changes
from silo2d.drawings.photograph import read_photograph
from silo2d.drawings.shapes import import_shapes


def written(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def only_curve(path: Path, **options):
    (curve,) = joined(read_drawing(path, **options), "drawing")
    return curve


def like_a4(path: Path, **options) -> bool:
    """Whether a drawing's silo has the walls of the preset, wherever it stands."""
    drawn = {"outline": outline_changes(path, **options)["silo.outline"]}
    case = SiloCase.resolve({"name": "drawn", "silo": drawn}, "drawn", Path())
    own, preset = case.outline, SiloCase.load("A4").outline
    middle = own.polygon[:, 0].mean()
    moved = own.polygon - [middle, 0]
    rotations = [np.roll(moved, k, axis=0) for k in range(len(moved))]
    # a ten thousandth of a millimetre is what is written
    return math.isclose(own.outlet, preset.outlet, rel_tol=1e-6) and any(
        np.allclose(turned, preset.polygon, rtol=0, atol=1e-7) for turned in rotations
    )


SPLINE = "0\nSPLINE\n8\n{}\n"
# 600 mm wide and 500 mm high, of a view box of 300 by 500: it keeps its form.
STRETCHED = svg(svg_path(A4_DOWN), width="600mm").replace("<svg ", '<svg height="500mm" ')
DRAWN_A4 = {
    "a path with its y down": ("a.svg", svg(svg_path(A4_DOWN))),
    "a polygon, clockwise": (
        "a.svg",
        svg(f'<polygon points="{" ".join(f"{x},{y}" for x, y in reversed(A4_DOWN))}"/>'),
    ),
    "in centimetres, moved and rotated and back": (
        "a.svg",
        svg(
            '<g transform="translate(10 0)"><g transform="rotate(30) scale(0.5)">'
            '<g transform="matrix(2 0 0 2 0 0) rotate(-30) translate(7,-3)">'
            f"{svg_path(A4_DOWN)}</g></g></g>",
            width="30cm",
        ),
    ),
    "sides that are open at top and outlet": (
        "a.svg",
        svg(
            f'<polyline points="0,0 0,{500 - RISE_} 75,500"/>'
            f'<polyline points="225,500 300,{500 - RISE_} 300,0"/>'
        )
        if (RISE_ := A4[2][1])
        else "",
    ),
    "in a document wider than its view box": ("a.svg", STRETCHED),
    "by its height": ("a.svg", STRETCHED.replace('width="600mm"', "")),
    "with words and a hidden part": (
        "a.svg",
        svg(f'<text>A4</text><g visibility="hidden"><rect width="9"/></g>{svg_path(A4_DOWN)}'),
    ),
    "a closed polyline": ("a.dxf", dxf(dxf_polyline(A4))),
    "a polyline next to a sheet's frame": (
        "a.dxf",
        dxf(dxf_polyline(A4) + dxf_polyline([(0, 0), (9, 0), (9, 9)]) + "67\n1\n"),
    ),
    "lines in any order and direction": (
        "a.dxf",
        dxf(
            "".join(
                dxf_line(*((A4[k], A4[k - 1]) if k % 2 else (A4[k - 1], A4[k])))
                for k in (3, 0, 5, 1, 4, 2)
            )
        ),
    ),
    "in inches": ("a.dxf", dxf(dxf_polyline([(x / 25.4, y / 25.4) for x, y in A4]), units=1)),
}


@pytest.mark.parametrize("kind", DRAWN_A4)
def test_a_drawing_of_a_preset_is_that_silo(tmp_path, kind):
    name, text = DRAWN_A4[kind]
    assert like_a4(written(tmp_path, name, text))


def test_a_unit_that_is_given_goes_before_that_of_the_file(tmp_path):
    path = written(tmp_path, "a.dxf", dxf(dxf_polyline([(x / 10, y / 10) for x, y in A4])))
    assert like_a4(path, unit="cm")


def test_a_layer_is_read_alone(tmp_path):
    """What is not read on the others does not matter."""
    frame = dxf_polyline([(-50, -50), (400, -50), (400, 600), (-50, 600)], layer="frame")
    inside = dxf_polyline(A4, layer="inside")
    path = written(tmp_path, "b.dxf", dxf(frame + inside + SPLINE.format("frame")))
    assert like_a4(path, layer="inside")
    path = written(tmp_path, "a.dxf", dxf(frame + inside))
    assert_refuses(["2 closed curves", "layer"], outline_changes, path)
    assert_refuses(
        ["no layer 'insid'", "did you mean 'inside'"], outline_changes, path, None, "insid"
    )


def segment(large: int) -> str:
    """What a chord cuts off an ellipse of 90 by 45, rotated by 25 deg; flags without spaces."""
    turn = math.radians(25)
    ends = []
    for angle in (0.0, math.pi / 3):
        x, y = 90 * math.cos(angle), 45 * math.sin(angle)
        ends.append(
            (150 + x * math.cos(turn) - y * math.sin(turn),
             250 + x * math.sin(turn) + y * math.cos(turn))
        )  # fmt: skip
    (x, y), (to_x, to_y) = ends
    return f'<path d="M{x!r} {y!r}A90 45 25 {large}{1 - large}{to_x!r} {to_y!r}Z"/>'


def segment_area(large: int) -> float:
    """Of an ellipse a b/2 (t - sin t), t the angle in the circle that it is a picture of."""
    angle = 2 * math.pi - math.pi / 3 if large else math.pi / 3
    return 90 * 45 / 2 * (angle - math.sin(angle))


ELLIPSES = {
    "circle": ('<circle cx="150" cy="250" r="60"/>', math.pi * 60**2),
    "ellipse": ('<ellipse cx="150" cy="250" rx="90" ry="40"/>', math.pi * 90 * 40),
    "two arcs of a path": (
        '<path d="M60 250 a90 40 0 1 0 180 0 a90 40 0 1 0 -180 0z"/>',
        math.pi * 90 * 40,
    ),
    **{
        f"a segment of a rotated ellipse, {'large' if large else 'small'}": (
            segment(large),
            segment_area(large),
        )
        for large in (0, 1)
    },
    "a rectangle with round corners": (
        '<rect x="10" y="20" width="80" height="60" rx="10"/>',
        80 * 60 - (4 - math.pi) * 10**2,
    ),
    "a cubic with parallel handles": (  # 3/5 of width and height of its handles
        '<path d="M0 300 C0 200 100 200 100 300 Z"/>',
        3 / 5 * 100 * 100,
    ),
    "a parabola": ('<path d="M0 300 Q50 200 100 300 Z"/>', 2 / 3 * 50 * 100),
    "a parabola in two smooth halves": (
        '<path d="M0 300 Q25 250 50 250 T100 300 Z"/>',
        2 / 3 * 50 * 100,
    ),
}


@pytest.mark.parametrize("kind", ELLIPSES)
def test_curves_have_the_area_that_they_have_in_closed_form(tmp_path, kind):
    """Within their flatness: a polyline that leaves a curve by d loses at most d a length of it."""
    inner, area = ELLIPSES[kind]
    curve = only_curve(written(tmp_path, "a.svg", svg(inner)))
    assert curve.closed
    around = np.hypot(*(np.roll(curve.points, -1, axis=0) - curve.points).T).sum()
    largest = 1.01 * FLATNESS * np.ptp(curve.points, axis=0).max() * around
    assert abs(abs(area_of(curve.points)) - area) < largest


def test_a_bulge_is_the_tangent_of_a_quarter_of_the_angle_of_its_arc(tmp_path):
    """DXF reference, LWPOLYLINE code 42: 1 is a half circle, sqrt(2) - 1 a quarter."""
    disc = only_curve(written(tmp_path, "d.dxf", dxf(dxf_polyline([(-5, 0, 1.0), (5, 0, 1.0)]))))
    assert abs(area_of(disc.points)) == pytest.approx(math.pi * 25, rel=3e-3)
    assert np.hypot(*disc.points.T) == pytest.approx(5.0, rel=1e-5)
    quarter = math.sqrt(2) - 1
    corner = [(5, 0, quarter), (0, 5, 0.0), (0, 0, 0.0)]
    sector = only_curve(written(tmp_path, "s.dxf", dxf(dxf_polyline(corner))))
    assert area_of(sector.points) == pytest.approx(math.pi * 25 / 4, rel=3e-3)


def test_lines_and_arcs_that_share_their_ends_are_one_curve(tmp_path):
    """A stadium: two lines, two half circles; area 2 r l + pi r^2."""
    text = dxf(
        dxf_line((0, -4), (10, -4)) + dxf_arc((10, 0), 4, 270, 90)
        + dxf_line((10, 4), (0, 4)) + dxf_arc((0, 0), 4, 90, 270)
    )  # fmt: skip
    curve = only_curve(written(tmp_path, "stadium.dxf", text))
    assert curve.closed
    assert abs(area_of(curve.points)) == pytest.approx(2 * 4 * 10 + math.pi * 16, rel=3e-3)


REFUSED = {
    "no unit in an SVG": ("a.svg", svg(svg_path(A4_DOWN), width="300"), ["unit", "--unit mm"]),
    "no unit in a DXF": ("a.dxf", dxf(dxf_polyline(A4), units=None), ["unit", "--unit mm"]),
    "unitless DXF": ("a.dxf", dxf(dxf_polyline(A4), units=0), ["unit", "--unit mm"]),
    "another kind of file": ("a.svg", "not a drawing", ["neither SVG nor DXF"]),
    "broken XML": ("a.svg", "<svg><path", ["not valid XML"]),
    "XML that is no SVG": ("a.svg", "<html></html>", ["no SVG"]),
    "entities": ("a.svg", '<!DOCTYPE svg [<!ENTITY a "b">]><svg/>', ["entities"]),
    "an empty drawing": ("a.svg", svg(""), ["no curve"]),
    "text only": ("a.svg", svg("<text>Silo</text>"), ["no curve"]),
    "a hopper of splines": (
        "a.dxf",
        dxf(dxf_line((0, 500), (0, 130)) + dxf_line((300, 500), (300, 130)) + 2 * SPLINE.format(0)),
        ["2 SPLINE", "polylines"],
    ),
    "a block": ("a.dxf", dxf(dxf_polyline(A4) + "0\nINSERT\n8\n0\n2\nhopper\n"), ["1 INSERT"]),
    "a copy": ("a.svg", svg(svg_path(A4_DOWN) + '<use href="#a"/>'), ["1 use", "paths"]),
    "a drawing in a drawing": (
        "a.svg",
        svg(f'<svg viewBox="0 0 600 1000">{svg_path(A4_DOWN)}</svg>'),
        ["1 svg"],
    ),
    "a damaged DXF": ("a.dxf", dxf("0\nLINE\n10\nabc\n20\n0\n"), ["damaged DXF"]),
    "a damaged path": ("a.svg", svg('<path d="M 0 0 L 1"/>'), ["damaged"]),
    "a path with a letter of none": (
        "a.svg",
        svg('<path d="M0,0 V400 x L75,500 H225 L300,400 V0 Z"/>'),
        ["damaged"],
    ),
    "a turn in turns": ("a.svg", svg('<g transform="rotate(0.5turn)"/>'), ["rotate(0.5turn)"]),
    "a transform without numbers": ("a.svg", svg('<g transform="scale"/>'), ["transform s"]),
    "a transform of a style": (
        "a.svg",
        svg(f'<g style="transform: scale(2)">{svg_path(A4_DOWN)}</g>'),
        ["transform within a style"],
    ),
    "a stretched view box": (
        "a.svg",
        STRETCHED.replace("<svg ", '<svg preserveAspectRatio="none" '),
        ["stretch"],
    ),
    "a transform nobody knows": ("a.svg", svg('<g transform="bend(3)"><path/></g>'), ["bend(3)"]),
    "three lines that meet": (
        "a.dxf",
        dxf(dxf_line((0, 0), (1, 0)) + dxf_line((1, 0), (1, 1)) + dxf_line((1, 0), (2, 0))),
        ["three lines end at (1, 0)"],
    ),
    "three open curves": (
        "a.dxf",
        dxf("".join(dxf_line((x, 0), (x, 5)) for x in (0, 2, 4))),
        ["3 open curves", "layer"],
    ),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_a_drawing_that_is_no_silo_is_refused_in_one_line(tmp_path, kind):
    name, text, words = REFUSED[kind]
    path = written(tmp_path, name, text)
    assert_refuses([str(path), *words], outline_changes, path)


def test_files_that_are_no_text_are_refused(tmp_path):
    (tmp_path / "b.dxf").write_bytes(b"AutoCAD Binary DXF\r\n\x1a\0")
    (tmp_path / "p.svg").write_bytes(b"\x89PNG\r\n\x1a\n\0\0")
    assert_refuses(["binary DXF", "ASCII"], outline_changes, tmp_path / "b.dxf")
    assert_refuses(["not text"], outline_changes, tmp_path / "p.svg")
    assert_refuses(["cannot be read"], outline_changes, tmp_path / "none.svg")


def test_a_drawn_square_keeps_its_corners_and_its_area(tmp_path):
    """What is convex is not simplified; what rounding takes, (4 - pi) r^2, its sides give back.

    Its arcs are (sqrt 2 - 1) r from the corners, less half the diagonal of what the sides grow by.
    """
    text = svg('<rect x="10" y="10" width="12" height="12"/>', "100mm", "0 0 100 100")
    found = import_shapes(written(tmp_path, "square.svg", text), spheroradius=1e-3)
    (square,) = found.shapes
    assert len(square.corners) == 4
    whole = 144e-6 + (4 - math.pi) * 1e-6
    assert area_of(square.corners) == pytest.approx(whole, rel=1e-9)
    growth = math.sqrt(whole) - 12e-3
    assert square.error == pytest.approx(
        (math.sqrt(2) - 1) * 1e-3 - growth / math.sqrt(2), rel=1e-3
    )
    assert square.area == pytest.approx(1.0, rel=1e-9)


def test_particles_of_one_kind_have_one_area_at_any_spheroradius(tmp_path):
    """A square, turned, and one with a corner cut off by a tenth of a millimetre."""
    text = svg(
        '<rect width="10" height="10"/>'
        '<rect x="30" width="10" height="10" transform="rotate(20 35 5)"/>'
        '<polygon points="60,0 70,0 70,9.9 69.9,10 60,10"/>', "100mm", "0 0 100 100",
    )  # fmt: skip
    path = written(tmp_path, "squares.svg", text)
    for r in (0.2e-3, 3e-3):
        shapes = import_shapes(path, spheroradius=r).shapes
        assert [one.area for one in shapes] == pytest.approx([1.0] * 3, rel=1e-9)


def test_a_drawn_disc_is_within_the_tolerance_and_has_its_area(tmp_path):
    text = svg('<circle cx="50" cy="50" r="8"/>', "100mm", "0 0 100 100")
    path = written(tmp_path, "disc.svg", text)
    for tolerance in (0.4e-3, 0.1e-3):
        (disc,) = import_shapes(path, tolerance=tolerance).shapes
        assert disc.area == pytest.approx(1.0, rel=1e-9)
        assert disc.error <= tolerance
        distance = np.hypot(*(disc.rounded - [0.05, -0.05]).T)
        assert np.abs(distance - 8e-3).max() <= tolerance + 2 * FLATNESS * 16e-3
    fewer, more = (len(import_shapes(path, tolerance=t).shapes[0].corners) for t in (4e-4, 1e-4))
    assert fewer < more


def test_a_hollow_outline_says_how_deep_it_is(tmp_path):
    """An L of 10 mm with a notch of 4 by 4 mm: its hull is nearest sqrt(2) 2 mm from the notch."""
    text = svg('<polygon points="0,0 10,0 10,6 6,6 6,10 0,10"/>', "20mm", "0 0 20 20")
    (bent,) = import_shapes(written(tmp_path, "l.svg", text)).shapes
    assert bent.concavity == pytest.approx(2e-3 * math.sqrt(2), rel=1e-6)
    assert "hollow by 2.83 mm" in bent.in_words()


SCALE = "a bar that is darker than the particles: its ends are known to a quarter of a pixel"


@pytest.fixture(scope="module")
def stones(tmp_path_factory) -> tuple[Path, list[np.ndarray]]:
    """Six polygons of 70 px, 0.1 mm a pixel by a bar of 20 mm, and one cut by the border."""
    folder = tmp_path_factory.mktemp("stones")
    true = [
        regular(4 + k % 3, 70, (110 + 240 * (k % 3), 110 + 220 * (k // 3)), 0.3 * k)
        for k in range(6)
    ]
    cut = regular(5, 60, (895, 300))
    path = photograph(folder / "stones.png", [*true, cut], (600, 560, 800, 572))
    return path, true


def test_particles_of_a_photograph_have_their_areas(stones):
    """A border is known to 0.2 px or so: of 70 px, 2 x 0.2/70 of the area."""
    path, true = stones
    found = read_photograph(path, bar_length=20e-3)
    assert found.scale == pytest.approx(1e-4, rel=3e-3), SCALE
    assert found.left_out == 1
    ours = sorted(abs(area_of(outline)) for outline in found.outlines)
    exact = sorted(area_of(c) * found.scale**2 for c in true)
    assert ours == pytest.approx(exact, rel=6e-3)
    given = read_photograph(path, scale=1e-4)
    assert len(given.outlines) == 7, "without a bar that is known, the bar is an object"
    assert len(read_photograph(path, scale=1e-4, bar=found.bar).outlines) == 6


def test_photographed_polygons_get_their_corners_back(stones):
    """A small radius: the fewest corners within 3 px are the true ones."""
    path, true = stones
    found = import_shapes(path, bar_length=20e-3, spheroradius=0.5e-3, tolerance=0.3e-3)
    assert sorted(len(one.corners) for one in found.shapes) == sorted(len(c) for c in true)
    assert max(one.error for one in found.shapes) <= 0.3e-3
    assert [one.area for one in found.shapes] == pytest.approx(6 * [1.0], abs=1e-4)


PHOTOGRAPHS = {
    "no scale": ({}, ["no scale"]),
    "a bar without extent": ({"bar_length": 0.02, "bar": (5, 5, 5, 5)}, ["ends of the bar"]),
    "two scales": ({"scale": 1e-4, "bar_length": 0.02}, ["leave one of them out"]),
    "a unit": ({"unit": "mm"}, ["a photograph has no unit"]),
    "a spheroradius that swallows particles": (
        {"scale": 1e-4, "spheroradius": 9e-3},
        ["spheroradius = 9 mm", "too large"],
    ),
}


@pytest.mark.parametrize("kind", PHOTOGRAPHS)
def test_a_photograph_without_what_it_needs_is_refused(stones, kind):
    options, words = PHOTOGRAPHS[kind]
    assert_refuses([str(stones[0]), *words], import_shapes, stones[0], **options)


def test_pictures_without_particles_or_bar_are_refused(tmp_path):
    empty = photograph(tmp_path / "empty.png", [], None, noise=0.0)
    assert_refuses(["no particle stands out"], import_shapes, empty, scale=1e-4)
    one = photograph(tmp_path / "one.png", [regular(5, 60, (200, 200))], None)
    assert_refuses(["no scale bar found"], import_shapes, one, bar_length=0.02)
    broken = tmp_path / "broken.png"
    broken.write_bytes(b"\x89PNG\r\n\x1a\nnothing")
    assert_refuses(["not a picture"], import_shapes, broken, scale=1e-4)


def test_the_command_writes_a_shape_file_that_a_case_takes(stones, tmp_path):
    path, true = stones
    target = tmp_path / "stones.toml"
    done = silo2d("shapes", "import", path, "--bar", "20 mm", "--tolerance", "0.3 mm", "--json",
                  "-o", target)  # fmt: skip
    assert len(done.json["shapes"]) == 6
    assert done.json["scale_m_per_px"] == pytest.approx(1e-4, rel=3e-3), SCALE
    assert (tmp_path / "stones.png").read_bytes().startswith(b"\x89PNG")
    mean = float(np.mean([area_of(c) for c in true])) * 1e-8
    assert load_shapes(target).mean_area == pytest.approx(mean, rel=6e-3 + 2 * 3e-3)
    assert silo2d("run", "A4", "--shapes", target, "--dry-run").code == 0
    again = silo2d("shapes", "import", path, "--bar", "20 mm", "-o", target)
    assert_refused(again, "exists")
    wrong = silo2d("shapes", "import", path, "--scale", "2 kg", "-o", tmp_path / "o.toml")
    assert_refused(wrong, "--scale", "unit")


def test_the_gap_between_two_sides_is_the_outlet(tmp_path, monkeypatch):
    """45 mm from 35 to 80 mm in a floor of 160 mm: the floor on both sides of it stays."""
    monkeypatch.chdir(tmp_path)
    left, right = [(0, 300), (0, 0), (35, 0)], [(80, 0), (160, 0), (160, 300)]
    sides = "".join(dxf_polyline(one, closed=False) for one in (left, right))
    drawing = written(tmp_path, "sides.dxf", dxf(sides))
    assert silo2d("init", "drawn.toml", "--outline", drawing).code == 0
    outline = SiloCase.load("drawn.toml").outline
    assert (outline.outlet, outline.outlet_centre) == pytest.approx((0.045, 0.0575))
    assert [name for name in outline.walls().names if "floor" in name] == [
        "floor right", "floor left"
    ]  # fmt: skip
    shown = silo2d("run", "drawn.toml", "--dry-run", "--no-figures").out
    assert "outlet 0.045 m (0.0225 m off its middle)" in " ".join(shown.split())
    whole = written(
        tmp_path, "whole.dxf", dxf(dxf_polyline([*left[1:0:-1], *left[:1], *right[::-1]]))
    )
    shown = silo2d("run", "A4", "--outline", whole, "--fill-level", "200 mm", *DRY).out
    assert "outlet 0.16 m (all of its lowest edge" in " ".join(shown.split())


def test_a_drawing_that_is_no_case_is_refused_before_one_is_written(tmp_path, monkeypatch):
    """A floor that rises by a millimetre, and metres that were taken for millimetres."""
    monkeypatch.chdir(tmp_path)
    tilted = dxf_polyline([(0, 0), (160, 1), (160, 300), (0, 300)])
    small = dxf_polyline([(0, 0), (0.16, 0), (0.16, 0.3), (0, 0.3)])
    for name, text, words in (("tilt", tilted, "not horizontal"), ("small", small, "narrowest")):
        drawing = written(tmp_path, f"{name}.dxf", dxf(text))
        assert_refused(silo2d("init", "x.toml", "--outline", drawing), f"{name}.dxf", words)
    assert not (tmp_path / "x.toml").exists()
    assert_refused(silo2d("run", "tilt.dxf", "--dry-run"), "tilt.dxf", "a drawing", "init")


def test_run_and_init_take_the_silo_of_a_drawing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    drawing = written(tmp_path, "a.svg", svg(svg_path(A4_DOWN)))
    assert silo2d("init", "drawn.toml", "--outline", drawing).code == 0
    case = SiloCase.load("drawn.toml")
    changed = SiloCase.load("A4", outline_changes(drawing))
    assert np.array_equal(case.outline.polygon, changed.outline.polygon)
    assert "0.3 m wide, 0.5 m high" in silo2d("run", "B1", "--outline", drawing, "--dry-run").out
    assert_refused(silo2d("run", "A4", "--unit", "mm"), "--outline")
    low = written(
        tmp_path, "low.svg", svg('<rect width="100" height="120"/>', "100mm", "0 0 100 120")
    )
    assert silo2d("init", "low.toml", "--outline", low).code == 0
    assert SiloCase.load("low.toml").settings.fill.level == pytest.approx(0.108)
    assert_refused(silo2d("init", "x.toml", "--outline", low, "--study"), "leave --from")


def test_lines_of_a_drawing_of_its_back_are_where_they_are(tmp_path):
    """DXF reference, code 230: a line is in the world's axes whatever its extrusion, an arc is not.

    Two lines of a square that were drawn on the back still close it.
    """
    lines = [dxf_line((0, 0), (4, 0)), dxf_line((4, 0), (4, 4)), dxf_line((4, 4), (0, 4)),
             dxf_line((0, 4), (0, 0))]  # fmt: skip
    text = dxf("".join(line + "230\n-1\n" * (k % 2) for k, line in enumerate(lines)))
    square = only_curve(written(tmp_path, "square.dxf", text))
    assert square.closed
    assert abs(area_of(square.points)) == pytest.approx(16.0)


@pytest.mark.parametrize("how", ['display="none"', 'style="fill:red; display: none"'])
def test_what_an_svg_hides_is_not_drawn(tmp_path, how):
    """A hidden layer of Inkscape has it in its style."""
    text = svg(svg_path(A4_DOWN) + f'<g {how}><rect x="1" y="1" width="5" height="5"/></g>')
    assert len(only_curve(written(tmp_path, "hidden.svg", text)).points) >= 4
