"""A damper drawn before it is run: the level of its bed against closed forms, its particles."""

import math
import os
import subprocess
import sys

import numpy as np
import pytest
from made_cavities import cavity_of, ell, prism_of
from small_damper import damper3d
from small_silo import DRY

from damper3d.case.case import DamperCase
from damper3d.case.level import level_of, volume_below, walls_along
from damper3d.engine.enclosures import Cells, Frustum, HexagonalPrism, Sphere, box, cylinder
from damper3d.view.sketch import sketch

UP = np.array([0.0, 0.0, 1.0])
OBLIQUE = np.array([1.0, 2.0, 3.0]) / math.sqrt(14.0)


def cap(radius, depth):
    """Volume [m3] of a spherical cap; any textbook."""
    return math.pi * depth**2 * (3 * radius - depth) / 3


def cone(bottom, top, height, depth):
    """Volume [m3] of a cone's frustum up to a depth, radii at its ends [m]."""
    at = bottom + (top - bottom) * depth / height
    return math.pi * depth * (bottom**2 + bottom * at + at**2) / 3


@pytest.mark.parametrize(
    ("enclosure", "below", "off"),
    [
        (cylinder(0.04, 0.05), lambda z: math.pi * 0.02**2 * z, 0.0),
        (box(0.04, 0.03, 0.05), lambda z: 0.04 * 0.03 * z, 0.0),
        (HexagonalPrism(0.04, 0.05), lambda z: math.sqrt(0.75) * 0.04**2 * z, 0.0),
        (Cells(box(0.01, 0.01, 0.05), 3, 2, 0.002), lambda z: 6e-4 * z, 0.0),
        (cavity_of(prism_of(ell(0.04, 0.016), 0.05)), lambda z: 0.016 * 0.064 * z, 0.0),
        (Frustum(0.03, 0.05, 0.05), lambda z: cone(0.015, 0.025, 0.05, z), 2e-4),
        (Sphere(0.05), lambda z: cap(0.025, z), 2e-4),
    ],
    ids=lambda one: type(one).__name__,
)
@pytest.mark.parametrize("depth", [0.01, 0.031])
def test_the_level_of_a_volume_is_where_the_void_below_has_it(enclosure, below, off, depth):
    """Polygons of 48 sides stand for circles, whose volume is scaled to the void's: exact where the
    section is the same at all heights, else to some 1e-4 m."""
    assert level_of(enclosure, UP, below(depth)) == pytest.approx(depth, abs=max(off, 1e-9))


@pytest.mark.parametrize("enclosure", [box(0.04, 0.03, 0.05), cylinder(0.04, 0.05)])
def test_half_of_a_void_lies_below_its_middle_along_any_direction(enclosure):
    middle = float(OBLIQUE @ enclosure.middle)
    assert level_of(enclosure, OBLIQUE, enclosure.volume / 2) == pytest.approx(middle, abs=1e-9)
    over, area = walls_along(enclosure, OBLIQUE)
    assert volume_below(over, area, over.min()) == 0.0


def test_the_bed_is_drawn_between_loose_and_close_packing():
    """Of spheres in a cylinder: N V/(0.64 A) to N V/(0.55 A); up to the upper one it is filled."""
    case = DamperCase.load("thesis")
    panel, shapes = sketch(case)
    volume = case.count * 4 / 3 * math.pi * 0.0025**3
    low, high = (volume / (part * math.pi * 0.02**2) for part in (0.64, 0.55))
    levels = sorted(line[:, 1].mean() for line in panel.dashed)
    assert levels == pytest.approx([low, high], rel=1e-6)
    bed = panel.filled[0].points
    assert (bed[:, 1].min(), bed[:, 1].max()) == pytest.approx((0.0, high), abs=1e-8)
    assert np.ptp(bed[:, 0]) == pytest.approx(0.04, rel=1e-3)  # a chord beside the corner
    assert "bed expected to 29.1 to 33.9 mm" in panel.title
    drawn = np.concatenate([one.points for one in shapes.filled])
    assert np.ptp(drawn, axis=0) == pytest.approx([0.005, 0.005], rel=1e-3)
    assert [words for _, words in shapes.words] == ["5 x 5 x 5 mm"]


def test_a_particle_stands_beside_the_enclosure_at_its_scale():
    case = DamperCase.load("thesis", {"particles.shape": "prolate:2"})
    panel = sketch(case)[0]
    beside = np.concatenate([one.points for one in panel.filled[1:]])
    size = case.particle.surface.vertices
    assert np.ptp(beside[:, 0]) <= 2 * np.linalg.norm(size, axis=1).max() * (1 + 1e-9)
    assert beside[:, 0].min() > 0.02


def test_without_gravity_there_is_no_level():
    panel = sketch(DamperCase.load("thesis", {"motion.orientation": "none"}))[0]
    assert not panel.dashed
    assert "no level" in panel.title


def test_gravity_across_the_axis_lays_the_enclosure_down():
    """A cylinder on its side: the section through its axis is as high as its diameter."""
    sizes = {"enclosure.height": "60 mm", "particles.count": 200}
    panel = sketch(DamperCase.load("thesis", {"motion.orientation": "horizontal", **sizes}))[0]
    size = np.ptp(np.concatenate(panel.lines), axis=0)
    assert size == pytest.approx([0.06, 0.04], rel=1e-3)


def test_each_kind_of_a_mixed_bed_is_drawn_with_its_number(tmp_path):
    file = tmp_path / "mix.toml"
    file.write_text('schema = 1\n[[particles.kind]]\nshape = "sphere:5mm"\ncount = 30\n'
                    '[[particles.kind]]\nshape = "sphere:3mm"\ncount = 60\n')  # fmt: skip
    panel, shapes = sketch(DamperCase.load(file))
    assert [words for _, words in shapes.words] == ["30 of acrylic\n5 mm", "60 of acrylic\n3 mm"]
    assert "as of spheres" in panel.title


def test_a_dry_run_draws_beside_where_the_run_would_be_and_compiles_nothing(tmp_path):
    """In a process of its own, with an empty cache of kernels: it stays empty."""
    cache = tmp_path / "cache"
    words = ["run", "--dry-run", "--particles", "toroid:0.2", "-o", "runs"]
    done = subprocess.run(
        [sys.executable, "-m", "damper3d", *words], capture_output=True, text=True, check=True,
        cwd=tmp_path, env=os.environ | {"NUMBA_CACHE_DIR": str(cache)},
    )  # fmt: skip
    (picture,) = tmp_path.rglob("*.png")
    assert picture.parent == tmp_path / "runs"
    assert f"picture     {picture.relative_to(tmp_path)}" in done.stdout
    assert not picture.with_suffix("").exists()
    assert not list(cache.rglob("*.nbi"))


def test_a_map_is_drawn_before_it_is_run(tmp_path):
    words = ["map", "--frequencies", "40", "--gammas", "1,3", "-o", tmp_path]
    assert "picture" not in damper3d(*words, *DRY, "--json").json
    assert not list(tmp_path.iterdir())
    planned = damper3d(*words, "--dry-run", "--json").json
    assert list(tmp_path.rglob("*.png")) == [tmp_path / "maps" / planned["picture"].split("/")[-1]]
    assert "runs" in planned
