"""Walls of their own material, and curved walls, in the engine: rebounds, energy, fillings."""

import math

import numpy as np
import pytest
from damper_beds import DENSITY, LARGEST, NOWHERE, STILL, acrylic
from damper_runs import CASE

from damper3d import DamperCase, run
from damper3d.engine.enclosures import Enclosure, Frustum
from damper3d.engine.laws.table import Contact, law_table
from damper3d.engine.simulation import Simulation
from damper3d.engine.world import build_world

FRUSTUM = Frustum(0.03, 0.016, 0.025)
BOTTOM, TOP, SIDE = acrylic(0.0, 0.9), acrylic(0.0, 0.5), acrylic(0.0, 1.0)


def ball(room: Enclosure, place, velocity) -> Simulation:
    """One sphere of LARGEST without gravity; walls have the laws of BOTTOM, TOP and SIDE."""
    each = [Contact(law) for law in (acrylic(), BOTTOM, TOP, SIDE)]
    number = np.maximum.outer(np.arange(4), np.arange(4))
    laws = law_table(each, number, np.zeros(1, int), np.array([LARGEST]), walls=np.array([1, 2, 3]))
    sim = Simulation(
        build_world(
            np.array([place]), np.array([LARGEST]), density=DENSITY, enclosure=room,
            pair_law=laws, wall_law=laws, shaker=STILL,
            direction=np.array([0.0, 0.0, 1.0]), gravity=np.array(NOWHERE), time_step=1e-6,
        )
    )  # fmt: skip
    sim.set_velocity(np.array([velocity], float))
    return sim


@pytest.mark.parametrize(("way", "restitution"), [(-1.0, 0.9), (1.0, 0.5)])
def test_each_wall_gives_back_by_its_own_material(way, restitution):
    """Along the axis, onto bottom or top; steps of 1 us, of which a contact has some twenty, leave
    0.6 % of a restitution of 0.5.
    """
    sim = ball(FRUSTUM, (0.0, 0.0, 0.0125), (0.0, 0.0, way))
    sim.step(14_000)
    assert sim.frame()["v"][0, 2] == pytest.approx(-way * restitution, rel=1e-2)
    row = sim.sample()
    lost = float(row["normal_damping_particle_wall"][0])
    kinetic = 0.5 * DENSITY * 4 / 3 * math.pi * LARGEST**3
    assert lost == pytest.approx((1.0 - restitution**2) * kinetic, rel=1e-2)


def test_a_ball_strikes_the_conical_side_along_its_normal():
    """From the axis, against the side's normal there, it comes back the way it went."""
    slope = math.atan2(0.5 * (0.03 - 0.016), 0.025)
    normal = np.array([math.cos(slope), 0.0, math.sin(slope)])
    sim = ball(FRUSTUM, (0.0, 0.0, 0.009), 0.5 * normal)
    sim.step(40_000)
    v = sim.frame()["v"][0]
    np.testing.assert_allclose(v, -0.5 * normal, atol=1e-3)


def shape_case(shape: str, **sizes) -> DamperCase:
    """The small case of twenty spheres in another enclosure."""
    keys = {key: value for key, value in CASE.items() if not key.startswith("enclosure.")}
    own = {f"enclosure.{key}": value for key, value in sizes.items()}
    return DamperCase.load("thesis", keys | {"enclosure.shape": shape, "run.cycles": 5} | own)


SHAPES = {
    "hexagonal_prism": {"across_flats": "19 mm", "height": "20 mm"},
    "polyhedron": {"vertices": [[0, 0, 0], [36, 0, 0], [0, 36, 0], [0, 0, 36]], "unit": "mm"},
    "frustum": {"diameter": "16 mm", "top_diameter": "24 mm", "height": "20 mm"},
    "sphere": {"diameter": "23 mm"},
    "cylinder": {"diameter": "12 mm", "height": "14 mm", "cells": [2, 2], "cell_wall": "1 mm"},
    "box": {"width": "11 mm", "height": "14 mm", "cells": [2, 2], "cell_wall": "1 mm"},
}
FLAT = ("hexagonal_prism", "polyhedron")  # of the kernels of a box; others compile their own


@pytest.mark.parametrize(
    "shape",
    [pytest.param(s, marks=[] if s in FLAT else [pytest.mark.validation]) for s in SHAPES],
)
def test_a_damper_of_each_shape_fills_runs_and_is_drawn(shape, tmp_path):
    """The balance closes, no sphere leaves its void, and the film and the export are there."""
    from damper3d.view.export import export
    from damper3d.view.film import film_frames
    from damper3d.view.picture import make_figures
    from damper3d.view.scene import read_scene

    case = shape_case(shape, **SHAPES[shape])
    result = run(case, out=tmp_path / "runs")
    assert abs(result.energy_closure) < 0.01
    scene = read_scene(result.run_folder)
    planes = case.enclosure.planes
    for frame in range(len(scene.tables)):
        x = scene.particles(frame).position
        assert (x @ planes[:, :3].T - planes[:, 3]).min(initial=1.0) > 0.95 * LARGEST
        assert case.enclosure.clearance(x).min() > 0.95 * LARGEST
    assert len(make_figures(result.run_folder, film=False)) == 3
    assert len(list(film_frames(scene))) == len(scene.tables)
    assert len(export(result.run_folder, "vtkhdf")) == 2
    assert result.bed_height_m > 0.0
