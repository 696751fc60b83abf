"""Errors of sub-spheres (thesis, eqs 4.16-4.34, figs 4.7, 4.11), and the command for shapes."""

import json
import math

import numpy as np
import pytest
from refusals import assert_refused
from shapely import unary_union
from shapely.geometry import Point
from small_damper import damper3d

from damper3d.shapes import prolate, toroid
from damper3d.shapes.errors import curve, errors_of, prolate_exact, prolate_spheres, toroid_spheres
from damper3d.shapes.particle import Particle, parse_particle

ROUND = 2000  # corners in a quarter of a circle, which lack 1e-7 of area and perimeter


@pytest.mark.parametrize("ratio", [1.05, 1.5, 3.0])
@pytest.mark.parametrize("number", [9, 51])
def test_section_of_a_prolate_row_is_that_of_its_circles(ratio, number):
    """Eqs 4.16-4.23 against the union of polygons with 8000 corners: 3e-7, a quarter each."""
    x, radii = prolate.centres(ratio, number)
    found = prolate_spheres(x, radii)
    circles = [
        Point(s * at, 0.0).buffer(r, quad_segs=ROUND)
        for at, r in zip(x, radii, strict=True) for s in (-1.0, 1.0)
    ]  # fmt: skip
    union = unary_union(circles)
    assert found.area == pytest.approx(union.area / 4.0, rel=1e-6)
    assert found.perimeter == pytest.approx(union.length / 4.0, rel=1e-6)


@pytest.mark.parametrize("hole", [0.05, 0.33])
def test_section_of_a_toroid_ring_is_that_of_its_circles(hole):
    """Eqs 4.30-4.32, likewise; inside and outside of the ring."""
    a, b = toroid.radii_of(hole)
    found = toroid_spheres(a, b, 20)
    turns = [2.0 * math.pi * k / 20 for k in range(20)]
    circles = [Point(a * math.cos(t), a * math.sin(t)).buffer(b, quad_segs=ROUND) for t in turns]
    union = unary_union(circles)
    assert found.area == pytest.approx(union.area, rel=1e-6)
    assert found.perimeter == pytest.approx(union.length, rel=1e-6)


@pytest.mark.parametrize("ratio", [1.05, 1.5, 2.0, 3.0, 6.0])
def test_perimeter_of_an_ellipse(ratio):
    """Against 100 000 chords, which lack less than 1e-8; eq. 4.25 (Ramanujan) is close."""
    a, b = prolate.axes(ratio)
    t = np.linspace(0.0, 0.5 * math.pi, 100_001)
    chords = np.hypot(np.diff(a * np.cos(t)), np.diff(b * np.sin(t))).sum()
    found = prolate_exact(a, b).perimeter
    assert found == pytest.approx(chords, rel=1e-8)
    printed = math.pi / 4 * (3 * (a + b) - math.sqrt((3 * a + b) * (a + 3 * b)))
    assert printed == pytest.approx(found, rel=1e-6 if ratio < 2 else 1e-3)


@pytest.mark.parametrize("shape", ["prolate:3", "toroid:0.33"])
def test_errors_fall_with_the_square_of_the_number_of_sub_spheres(shape):
    """Grooves of depth d^2/(8 R) and distances d = L/n: from 51 to 201 a slope of -2 within 0.1.

    Those of a toroid count n, those of a prolate spheroid n - 1 or so: 0.03 of the slope.

    Area and volume are too small, as figs 4.7a and 4.11a show, the perimeter too large.
    """
    found = {e.sub_spheres: e for e in curve(Particle(shape), 0)}
    for key in ("surface", "volume", "area", "section_area", "section_perimeter"):
        few, many = getattr(found[51], key), getattr(found[201], key)
        assert math.log(many / few) / math.log(201 / 51) == pytest.approx(-2.0, abs=0.1)
    for errors in found.values():
        assert errors.volume < 0.0
        assert errors.section_area < 0.0
    assert found[51].section_perimeter > 0.0


def test_a_sphere_has_no_errors():
    errors = errors_of(parse_particle("sphere:5mm"))
    assert errors.surface == 0.0
    assert abs(errors.volume) < 1e-12
    assert abs(errors.area) < 1e-12


def test_the_command_describes_and_draws_a_shape(tmp_path):
    result = damper3d("shape", "--toroid", "0.2", "--json", "-o", str(tmp_path / "out"))
    found = json.loads(result.out)
    assert found["sub_spheres"] == 50
    assert found["particles"] == "toroid:0.2"
    particle = parse_particle("toroid:0.2")
    assert found["volume_m3"] == pytest.approx(4.0 / 3.0 * math.pi * 3.5e-3**3, rel=1e-9)
    assert found["mass_kg"] == pytest.approx(1190.0 * found["volume_m3"])
    assert found["inertia_over_density_m5"] == pytest.approx(particle.inertia)
    assert np.array(found["size_m"]) == pytest.approx(
        [9.119e-3, 9.119e-3, 3.647e-3], rel=1e-3
    )  # 2 (a + b), 2 b with b = 3.5 mm (1.5 pi 1.5)^(-1/3), a = 1.5 b
    assert found["n_particles"] == 110
    # 18 cycles of 40 Hz in steps of 1 us; 44 us of CPU a step by `make bench`.
    assert (found["cycles"], found["steps"]) == (18, 450_000)
    assert 20.0 < found["expected_cpu_us_per_step"] < 90.0
    motion = 1e-6 * found["expected_cpu_us_per_step"] * found["steps"] / 60
    assert motion < found["expected_min"] < 3 * motion  # with growing and settling
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["toroid-0.2-50.png"]
    words = damper3d("shape", "--prolate", "2", "--sub-spheres", "25", "--no-figures").out
    for part in ("25, in a row along x", "sphericity               0.9287", "surface error"):
        assert part in words


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ([], ["give one shape", "--toroid"]),
        (["--prolate", "2", "--oblate", "0.7"], ["give one shape"]),
        (["--prolate", "20"], ["aspect ratio", "from 1 to 10"]),
        (["--prolate", "2", "--sub-spheres", "4"], ["must be odd"]),
        (["--toroid", "0.2", "--tolerance", "small"], ["tolerance = 'small'"]),
        (["--mesh", "none.stl"], ["none.stl", "cannot be read"]),
        (["--mesh", "none.stl", "--mesh-unit", "5 kg"], ["mesh_unit"]),
    ],
)
def test_a_shape_that_the_command_refuses(options, words):
    assert_refused(damper3d("shape", *options), *words)
