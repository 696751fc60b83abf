"""Inserts and further outlets: walls, weight borne, free fall through, and what is refused."""

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hand_built import scene_of
from refusals import assert_refuses
from scenes import HARD_LAW, HARD_STEP, SURFACE_DENSITY, G, launch, mass
from shapely import Point, Polygon

from silo2d.case.beds.openings import with_inserts, with_outlets
from silo2d.case.case import SiloCase
from silo2d.case.filling import Layer, rows_of_rain
from silo2d.case.outline import hopper, preset
from silo2d.case.shape import disc
from silo2d.engine.simulation import Simulation
from silo2d.engine.world import build_world
from silo2d.measures.basics.balance import part_of_wall
from silo2d.measures.basics.coarse_graining import grid_round, inside_edges
from silo2d.measures.basics.dead_zones import area_of_silo
from silo2d.measures.basics.particles import column_edges
from silo2d.measures.basics.walls import sides
from silo2d.measures.janssen import vertical_walls
from silo2d.run.ending import blocked
from silo2d.run.packing import packing_digest
from silo2d.view.scene import Scene

WEDGE = [[-40, 180], [40, 180], [0, 250]]
SIDE, FLOOR = [[-150, 200], [-150, 260]], [[60, 0], [120, 0]]


def flat(inserts=(), outlets=()):
    outline = hopper(0.0, 40e-3, name="flat")
    outline = with_outlets(outline, list(outlets), 1e-3, "silo")
    return with_inserts(outline, list(inserts), 1e-3, "silo")


@pytest.mark.parametrize("name", ["A4", "D1"])
def test_each_point_of_the_walls_counts_once_as_a_corner(name):
    """An edge that rests on a corner must feel one spring of it; doors have none of their own."""
    outline = with_outlets(preset(name), [SIDE, [[150, 300], [150, 340]]], 1e-3, "silo")
    walls = with_inserts(outline, [WEDGE, [[-5, 300], [5, 300], [5, 310]]], 1e-3, "silo").walls()
    assert walls.names[-3:] == ["door 2", "door 3", "door"]
    assert walls.doors == [len(walls.names) - k for k in (3, 2, 1)]
    assert len(set(walls.names)) == len(walls.names) == len(walls.segments) == len(walls.corners)
    points = {tuple(point) for wall in walls.segments for point in np.round(wall, 12)}
    own = [
        tuple(point)
        for wall, n in zip(walls.segments, walls.corners, strict=True)
        for point in np.round(wall[:n], 12)
    ]
    assert sorted(own) == sorted(points)


def test_what_is_outside_of_an_insert_is_on_the_left_of_its_sides():
    walls = flat([WEDGE]).walls()
    sides = [k for k, name in enumerate(walls.names) if name.startswith("insert")]
    for start, end in walls.segments[sides]:
        along = end - start
        left = (start + end) / 2 + 1e-6 * np.array([-along[1], along[0]]) / np.hypot(*along)
        assert flat([WEDGE]).inside.contains(Point(left))


def test_inserts_and_outlets_stand_where_the_outline_was_drawn():
    """A silo drawn 100 mm above or below y = 0 is that silo: all of it is moved to y = 0.

    Rounding of y - 0.1 alone.
    """
    outline = [[-75, 0], [75, 0], [150, 130], [150, 500], [-150, 500], [-150, 130]]
    window = [[150, 300], [150, 340]]

    def silo(rise):
        def up(points):
            return [[x, y + rise] for x, y in points]

        document = {"name": "drawn", "silo": {
            "outline": up(outline), "inserts": [up(WEDGE)], "outlets": [up(window)]
        }}  # fmt: skip
        return SiloCase.resolve(document, "drawn", Path()).outline.walls()

    for rise in (100, -600):
        assert np.allclose(silo(rise).segments, silo(0).segments, rtol=0, atol=1e-12)


def test_a_packing_is_not_that_of_a_silo_with_a_window():
    """Its samples of forces at walls are by wall, and a window makes two walls of one."""
    bare = SiloCase.load("A4")
    digests = [
        packing_digest(case, 1)
        for case in (
            bare, SiloCase.load("A4", {"silo.outlets": [SIDE]}),
            SiloCase.load("A4", {"silo.outlets": [[[-150, 300], [-150, 360]]]}),
        )
    ]  # fmt: skip
    assert len(set(digests)) == 3


def world(outline, shape, pose):
    return Simulation(
        build_world(
            [shape], np.zeros(1, int), np.array([pose]), outline.walls(),
            surface_density=SURFACE_DENSITY, particle_law=HARD_LAW, wall_law=HARD_LAW, gravity=G,
            time_step=HARD_STEP,
        )
    )  # fmt: skip


def test_an_insert_bears_the_weight_of_what_lies_on_it():
    """A disc on a level side: its weight, once springs have come to rest, to rounding."""
    table = [[-40, 180], [40, 180], [40, 200], [-40, 200]]
    outline = flat([table])
    sim = world(outline, disc("a", 10e-3), (0.0, 0.205 - 1e-9, 0.0))
    sim.run(20_000)
    sim.wall_forces()
    sim.run(1000)
    names = outline.walls().names
    borne = sim.wall_forces()
    top = [k for k, name in enumerate(names) if borne[k].any()]
    assert [names[k].startswith("insert 1 side") for k in top] == [True]
    assert borne[top[0]] == pytest.approx([0.0, -mass(sim) * G], rel=1e-6, abs=1e-9)


@pytest.mark.parametrize(
    ("outlet", "x", "vx"), [(FLOOR, 0.09, 0.0), (SIDE, -0.1, -1.0)], ids=["floor", "side"]
)
def test_a_disc_falls_freely_through_a_further_outlet(outlet, x, vx):
    """It passes y = 0 after sqrt(2 h/g), and touches nothing; sharp to a step.

    Through the side it flies at 1 m/s: 0.05 m to the wall, where it has sunk by 12 mm.
    """
    outline, height = flat(outlets=[outlet]), 0.245
    shape = disc("a", 10e-3)
    for opened in (False, True):
        sim = world(outline, shape, (x, height, 0.0))
        launch(sim, vx=vx)
        if opened:
            for door in outline.walls().doors:
                sim.remove_wall(door)
        # Half a step back it was slower by g dt/2: the leapfrog is exact for a parabola.
        sim.rows[0, 5] = 0.5 * G * HARD_STEP
        sim.run(60_000)
        assert sim.n_out == opened
    out = sim.world.bodies.out_time[0]
    assert out == pytest.approx(math.sqrt(2 * height / G), abs=HARD_STEP)


def test_nothing_is_poured_into_an_insert():
    case = SiloCase.load("A4", {"silo.inserts": [WEDGE]})
    positions, _ = rows_of_rain(case.outline, case.shapes, Layer(0.0, 0.475, 0.0))
    wedge = np.array(WEDGE) * 1e-3
    assert len(positions) > 400
    assert min(Polygon(wedge).distance(Point(p)) for p in positions) > case.shapes.bounding_radius
    whole = SiloCase.load("A4").outline.area_below(0.475)
    area = 0.5 * (wedge[1, 0] - wedge[0, 0]) * (wedge[2, 1] - wedge[0, 1])
    assert case.outline.area_below(0.475) == pytest.approx(whole - area, rel=1e-12)
    assert case.silo_name is None


def test_a_silo_without_inserts_keeps_its_names():
    """The identity of a run holds no key of what it does not have."""
    assert not {"inserts", "outlets"} & set(SiloCase.load("A4").identity()["settings"]["silo"])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"inserts": [[[-400, 180], [40, 180], [0, 250]]]}, ["insert 1", "not inside the silo"]),
        ({"inserts": [[[-150, 300], [40, 300], [0, 350]]]}, ["insert 1", "touches a wall"]),
        ({"inserts": [WEDGE[::-1]]}, ["insert 1", "clockwise"]),
        ({"inserts": [WEDGE[:2]]}, ["insert 1", "2 points"]),
        ({"inserts": [WEDGE, WEDGE]}, ["insert 2", "touches insert 1"]),
        (
            {"inserts": [[[-145, 300], [145, 300], [145, 310], [-145, 310]]]},
            ["no way from the top to the outlet", "narrowest"],
        ),
        ({"outlets": [[[-150, 200], [-140, 260]]]}, ["outlet 2", "not on one wall"]),
        ({"outlets": [[[-150, 200]]]}, ["outlet 2", "both its ends"]),
        ({"outlets": [SIDE, SIDE]}, ["outlet 3", "not on one wall", "other outlets"]),
        ({"outlets": [[[-150, 200], [-150, 205]]]}, ["outlet 2 is 5 mm wide", "narrowest"]),
    ],
)
def test_an_opening_that_cannot_be(changes, words):
    changes = {f"silo.{key}": value for key, value in changes.items()}
    assert_refuses(["A4: [silo]", *words], SiloCase.load, "A4", changes)


def test_impulses_know_no_window():
    """What falls out of one would count as lost; of a further outlet in the floor it is out."""
    changes = {"silo.outlets": [SIDE], "run.engine": "pymunk"}
    assert_refuses(["[silo] outlets", "in the side", "dem"], SiloCase.load, "A4", changes)
    assert SiloCase.load("D1", changes | {"silo.outlets": [FLOOR]}).impulses


def test_a_door_that_is_drawn_has_no_further_outlets():
    changes = {"silo.outlets": [SIDE], "run.door_speed": "0.5 m/s"}
    assert_refuses(["[run] door_speed", "leave it out"], SiloCase.load, "A4", changes)


def test_measures_know_doors_and_inserts_from_walls():
    """Doors are no walls, and inserts of no side; the vertical walls of Janssen are the silo's."""
    outline = with_outlets(preset("A4"), [SIDE], 1e-3, "silo")
    walls = with_inserts(
        outline, [[[-5, 300], [5, 300], [5, 400], [-5, 400]]], 1e-3, "silo"
    ).walls()
    trajectory = SimpleNamespace(
        static={"wall_segments": walls.segments}, attributes={"lips": outline.lips}
    )
    scene = Scene(trajectory, {}, walls.names)
    assert len(scene.walls) == len(walls.names) - 2
    side = sides(scene)
    assert all(
        (side[k] == 0) == name.startswith(("door", "insert")) for k, name in enumerate(walls.names)
    )
    parts = part_of_wall(scene)
    assert parts[-2:] == ["door", "door"]
    assert "door" not in parts[:-2]
    assert parts[-6:-2] == ["inserts"] * 4
    assert "inserts" not in parts[:-6]
    assert [walls.names[k] for k in vertical_walls(scene)] == ["left wall a", "right wall"]


def test_the_inside_has_no_inserts_and_no_room_beside_a_window():
    """Area below the fill level as of polygons, to the cells of its edge; the width is the silo's
    own, however far what leaves through a side flies."""
    case = SiloCase.load("A4", {"silo.inserts": [WEDGE]})
    scene = scene_of([disc("a", 10e-3)], [0], case.outline, 0.1, 0.3)
    scene.trajectory.attributes["level"] = 0.475
    edges = inside_edges(scene)
    grid = grid_round(edges.min(axis=(0, 1)), edges.max(axis=(0, 1)), 4e-3)
    around = 2 * (0.3 + 0.475) * grid.width / 2
    assert area_of_silo(scene, grid) == pytest.approx(case.outline.area_below(0.475), abs=around)
    one = scene_of([disc("a", 10e-3)], [0], flat(outlets=[SIDE]), -0.3, 0.05)
    assert one.window[0] < -0.15
    assert one.across == (-0.15, 0.15)
    assert column_edges(one)[[0, -1]].tolist() == [-0.15, 0.15]


BAR = [[-11, 60], [11, 60], [11, 64], [-11, 64]]


@pytest.mark.parametrize(
    ("inserts", "x", "y", "stays"),
    [
        ([], 0.0, 0.30, True),
        ([], 0.03, 0.05, False),
        ([BAR], 0.0, 0.07, False),  # a heap on the bar
        ([BAR], 0.0, 0.03, True),  # below it
        ([BAR], 0.08, 0.07, True),  # between its end and the wall
        ([BAR], 0.08, 0.02, False),  # what stays on the floor
    ],
)
def test_what_lies_on_an_insert_blocks_no_outlet(inserts, x, y, stays):
    case = SiloCase.load("D2", {"silo.inserts": inserts, "particles.shapes": "disc"})
    sim = SimpleNamespace(poses=lambda: np.array([[x, y, 0.0]]), live=np.array([0]))
    packing = SimpleNamespace(kinds=np.array([0]))
    assert blocked(sim, case, packing) == stays
