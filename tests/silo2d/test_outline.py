"""Silo outlines: presets, walls and their corners, areas, and what is refused."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from granulab.errors import InputError
from silo2d.case.outline import PRESETS, hopper, outline_from_polygon, preset

# A bin with a step in its left side and an undercut right side: not convex.
STEPPED = [(0, 1), (4, 1), (5, 3), (4, 6), (1, 6), (1, 3), (0, 3)]

# Half the lowest edge from its middle is its left end only up to rounding.
OFF_CENTRE = outline_from_polygon([(0.1, 0), (0.4, 0), (0.4, 0.5), (0.1, 0.5)])


def corner_points(walls):
    """The end points that the walls count as corners."""
    return [
        tuple(point)
        for segment, count in zip(walls.segments, walls.corners, strict=True)
        for point in segment[:count]
    ]


@pytest.mark.parametrize("name", PRESETS)
def test_presets_have_the_papers_sizes(name):
    """Sec. 4.1: 300 mm wide, 500 mm high, hopper of (300 - D)/2 tan(angle). Exact but rounding."""
    angle = math.radians({"A": 60, "B": 45, "C": 30, "D": 0}[name[0]])
    outlet = {"1": 0.04, "2": 0.06, "3": 0.1, "4": 0.15}[name[1]]
    silo = preset(name)
    assert (silo.name, silo.outlet) == (name, outlet)
    assert_allclose(silo.lips, [(-outlet / 2, 0), (outlet / 2, 0)], atol=1e-15)
    assert (silo.width, silo.height) == pytest.approx((0.3, 0.5))
    knee = (0.3 - outlet) / 2 * math.tan(angle)
    assert sorted(silo.polygon[:, 1])[-4] == pytest.approx(knee)
    hopper_area = (0.3 + outlet) / 2 * knee
    assert silo.area_below(9.0) == pytest.approx(hopper_area + 0.3 * (0.5 - knee))


def test_a4_hopper_is_130_mm_high():
    """(150 - 75) mm tan 60 deg = 129.9 mm. Tolerance: the printed digits."""
    heights = 1e3 * np.unique(preset("A4").polygon[:, 1])
    assert_allclose(heights, [0, 129.904, 500], atol=1e-3)


def test_sixteen_presets():
    assert len(set(PRESETS)) == 16
    assert (PRESETS[0], PRESETS[-1]) == ("A1", "D4")


def test_hopper_walls_are_named_and_run_with_the_inside_on_their_left():
    walls = preset("B3").walls()
    assert walls.names == ["right hopper", "right wall", "left wall", "left hopper", "door"]
    inside = np.array([0.0, 0.25])
    a, b = walls.segments[:, 0], walls.segments[:, 1]
    side = (b - a)[:, 0] * (inside - a)[:, 1] - (b - a)[:, 1] * (inside - a)[:, 0]
    assert (side > 0).all()


def test_flat_floor_has_two_pieces_next_to_the_outlet():
    walls = preset("D1").walls()
    assert walls.names == ["floor right", "right wall", "left wall", "floor left", "door"]
    assert_allclose(walls.segments[0], [(0.02, 0), (0.15, 0)])
    assert_allclose(walls.segments[3], [(-0.15, 0), (-0.02, 0)])
    assert_allclose(walls.segments[4], [(-0.02, 0), (0.02, 0)])


def test_user_polygon_has_numbered_walls_and_is_moved_to_zero():
    silo = outline_from_polygon(STEPPED, outlet=1.0, outlet_centre=3.5, name="bin")
    walls = silo.walls()
    assert walls.names == [
        "wall 1", "wall 2", "wall 3", "wall 4", "wall 5", "floor left", "door",
    ]  # fmt: skip
    assert_allclose(walls.segments[0], [(4, 0), (5, 2)])
    assert_allclose(walls.segments[-1], [(3, 0), (4, 0)])
    assert (silo.width, silo.height) == (5, 5)


@pytest.mark.parametrize(
    "silo",
    [preset("A1"), preset("D4"), preset("D4").raised(0.2), hopper(0.0, 0.3), hopper(0.4, 0.3),
     outline_from_polygon(STEPPED), OFF_CENTRE, outline_from_polygon(STEPPED, outlet=2.0)],
)  # fmt: skip
def test_every_wall_point_is_a_corner_once(silo):
    """Particle edges rest on each wall vertex once, or its contact would act twice. The door's
    ends are the lips, which the walls count already."""
    walls = silo.walls()
    counted = corner_points(walls)
    assert len(counted) == len(set(counted))
    assert set(counted) == {tuple(point) for point in walls.segments.reshape(-1, 2)}
    assert (walls.names[-1], walls.corners[-1]) == ("door", 0)
    assert set(silo.lips) <= set(counted)
    lengths = np.hypot(*(walls.segments[:, 1] - walls.segments[:, 0]).T)
    assert lengths.min() > 1e-3


def test_walls_and_door_leave_only_the_top_open():
    """The perimeter is the walls, the door and the highest edge. Tolerance: rounding."""
    silo = outline_from_polygon(STEPPED, outlet=2.0)
    edge = np.roll(silo.polygon, -1, axis=0) - silo.polygon
    walls = silo.walls().segments
    assert np.hypot(*(walls[:, 1] - walls[:, 0]).T).sum() == pytest.approx(
        np.hypot(*edge.T).sum() - 3.0
    )


def test_raised_walls_are_prolonged_straight_up():
    """Vertical walls stay one piece; a leaning wall gets a vertical one on top."""
    plain, raised = preset("C2"), preset("C2").raised(0.3)
    assert (raised.height, raised.outlet) == (0.8, plain.outlet)
    assert raised.walls().names == plain.walls().names
    assert raised.area_below(0.5) == pytest.approx(plain.area_below(0.5))
    assert raised.area_below(0.8) == pytest.approx(plain.area_below(0.5) + 0.3 * 0.3)
    funnel = outline_from_polygon([(-1, 0), (1, 0), (2, 2), (-2, 2)]).raised(1.0)
    assert funnel.walls().names == [
        "right hopper", "right wall", "left wall", "left hopper", "door",
    ]  # fmt: skip


@given(level=st.floats(-0.1, 0.7))
def test_area_below_a_level(level):
    """Trapezoid up to the knee, then 300 mm x height. Tolerance: rounding."""
    y = min(max(level, 0.0), 0.5)
    low = min(y, 0.1)  # B3's hopper: (300 - 100)/2 tan 45 deg = 100 mm
    assert preset("B3").area_below(level) == pytest.approx(
        low * (0.1 + low) + 0.3 * (y - low), abs=1e-15
    )


def test_collinear_points_and_the_position_of_the_first_do_not_matter():
    points = [(0, 0.5), (0, 0), (0.1, 0), (0.2, 0), (0.3, 0), (0.3, 0.5), (0.2, 0.5)]
    silo = outline_from_polygon(points, outlet=0.1)
    assert len(silo.polygon) == 4
    assert silo.outlet_centre == pytest.approx(0.15)
    assert silo.walls().names == preset("D3").walls().names


@pytest.mark.parametrize("outlet", [0.04, 0.06, 0.1, 0.11, 0.15])
def test_hopper_may_reach_the_top_but_not_pass_it(outlet):
    """rise = run tan(angle), whatever the last digit of the tangent."""
    steepest = math.atan2(0.5, (0.3 - outlet) / 2)
    assert hopper(steepest, outlet).walls().names == ["right hopper", "left hopper", "door"]
    with pytest.raises(
        InputError, match=r"hopper would be .* high, the silo is 500 mm; at most [78]"
    ):
        hopper(steepest + 0.01, outlet)


def test_unknown_preset_names_the_nearest():
    with pytest.raises(InputError, match=r"^preset = 'a4': unknown; did you mean 'A4'\? known: A1"):
        preset("a4")


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ({"angle": -0.1}, "angle = -5.72958 deg: must be at least 0 deg"),
        ({"angle": math.pi / 2}, "angle = 90 deg: must be .* less than 90 deg"),
        ({"angle": math.nan}, "angle = nan deg"),
        ({"outlet": 0.0}, "outlet = 0 mm: must be positive"),
        ({"outlet": 0.4}, "outlet = 400 mm: wider than the silo, 300 mm"),
        ({"width": -0.3}, "width = -300 mm: must be positive"),
        ({"height": math.inf}, "height = inf mm: must be positive"),
    ],
)
def test_impossible_hoppers_are_refused(arguments, complaint):
    with pytest.raises(InputError, match=f"^hopper: {complaint}"):
        hopper(**({"angle": 1.0, "outlet": 0.1} | arguments))


BOX = [(0, 0), (0.3, 0), (0.3, 0.5), (0, 0.5)]


@pytest.mark.parametrize(
    ("points", "outlet", "centre", "complaint"),
    [
        (BOX[::-1], None, None, "clockwise; give the vertices counter-clockwise"),
        ([BOX[0], BOX[2], BOX[1], BOX[3]], None, None, "crosses or touches itself"),
        (BOX[:2], None, None, "2 points"),
        ([(0, 0), (0.3, 0.01), *BOX[2:]], None, None, "the lowest edge is not horizontal"),
        ([*BOX[:2], (0.3, 0.49), BOX[3]], None, None, r"the highest edge \(.*\) is not horizontal"),
        ([(0, 0), (1, 0), (1, 1), (2, 1), (2, 0), (3, 0), (3, 2), (0, 2)], None, None,
         "the lowest edge is not the only one at its level"),
        (BOX, 0.0, None, "outlet = 0 mm: must be positive"),
        (BOX, math.nan, None, "outlet = nan mm: must be positive"),
        (BOX, 0.31, None, "outlet = 310 mm: wider than the lowest edge; at most 300 mm"),
        (BOX, 0.1, 0.26, "outlet_centre = 260 mm: .* from 50 mm to 250 mm would do"),
        (BOX, None, 0.1, "outlet_centre = 100 mm: .* from 150 mm to 150 mm would do"),
        (BOX, 0.1, math.nan, "outlet_centre = nan mm"),
    ],
)  # fmt: skip
def test_impossible_silos_are_refused(points, outlet, centre, complaint):
    with pytest.raises(InputError, match=f"^case.toml: outline: {complaint}") as e:
        outline_from_polygon(points, outlet, centre, field="case.toml: outline")
    assert "\n" not in str(e.value)
