"""Particles by name, size distributions, mixtures; segregation against closed forms."""

import json
import math

import numpy as np
import pytest
from hand_built import scene_of
from refusals import assert_refuses
from scenes import ELASTIC, LEVEL, SURFACE_DENSITY, launch, simulation_of, velocity

from granulab.contact.restitution import linear_restitution
from silo2d.case.beds.forms import CLASSES
from silo2d.case.case import SiloCase
from silo2d.case.filling import LOOSE
from silo2d.case.outline import hopper
from silo2d.case.shape import corner_angles, disc
from silo2d.case.shapefile import load_shapes
from silo2d.measures import segregation
from silo2d.measures.segregation import segregation_index
from silo2d.run.packing import Packing, packing_folder, save_packing
from silo2d.run.pour import kinds_of, rain
from silo2d.run.protocol import get_packing, sources_of_both


def shapes(tmp_path, *entries, head='spheroradius = "0.5 mm"'):
    file = tmp_path / "shapes.toml"
    file.write_text("\n".join(["schema = 1", head, *(f"[[shape]]\n{e}" for e in entries)]))
    return load_shapes(file)


def entry(name="a", **keys):
    return "\n".join(f"{key} = {value!r}" for key, value in {"name": name, **keys}.items())


@pytest.mark.parametrize(
    ("form", "corners"), [("triangle", 3), ("square", 4), ("hexagon", 6), ("polygon", 7)]
)
def test_a_regular_polygon_has_the_area_of_its_side(form, corners, tmp_path):
    """n a^2/(4 tan(pi/n)), less what rounding takes of its corners: r^2 (n tan(pi/n) - pi)."""
    more = {"corners": 7} if form == "polygon" else {}
    (shape,) = shapes(tmp_path, entry(form=form, size="10 mm", **more)).shapes
    tan = math.tan(math.pi / corners)
    area = corners * 10e-3**2 / (4 * tan) - 0.5e-3**2 * (corners * tan - math.pi)
    assert shape.area == pytest.approx(area, rel=1e-12)


def test_a_disc_has_its_closed_forms(tmp_path):
    (shape,) = shapes(tmp_path, entry(form="disc", size="12 mm"), head="").shapes
    assert shape.area == pytest.approx(math.pi * 6e-3**2, rel=1e-14)
    assert shape.polar_moment == pytest.approx(math.pi * 6e-3**4 / 2, rel=1e-14)
    assert (shape.width, shape.bounding_radius) == (12e-3, 6e-3)
    # Points on the circle: as far out, and the area of the polygon of 96 of them.
    outline = shape.rounded_outline()
    np.testing.assert_allclose(np.hypot(*outline.T), 6e-3, rtol=1e-14)


def test_two_discs_touch_in_one_contact_and_bounce_by_its_restitution():
    """Head on through one contact: e = exp(-zeta pi/...) of the law in closed form.

    The step is a thousandth of the contact's duration: second order leaves less than 1e-4.
    """
    law = ELASTIC._replace(gamma_n=2000.0)
    m = SURFACE_DENSITY * math.pi * 5e-3**2 / 2
    step = 1e-3 * math.pi / math.sqrt(law.kn / m)
    sim = simulation_of(
        [disc("a", 10e-3), disc("b", 10e-3)],
        [(0.0, LEVEL, 0.3), (10e-3 + 1e-13, LEVEL, 0.0)],
        law=law, time_step=step,
    )  # fmt: skip
    launch(sim, 0, vx=0.5)
    launch(sim, 1, vx=-0.5)
    sim.run(500)
    assert len(sim.contacts()["overlap"]) == 1
    sim.run(1500)
    e = velocity(sim, 1)[0] - velocity(sim, 0)[0]
    assert e == pytest.approx(linear_restitution(law.gamma_n, law.kn, m), abs=1e-3)
    assert velocity(sim, 0)[2] == 0.0  # no arm: no rotation


@pytest.mark.parametrize("distribution", ["normal", "lognormal"])
def test_classes_keep_mean_mass_and_share_of_each(distribution, tmp_path):
    """A normal cut at c = 3 has the variance s^2 (1 - 2 c phi(c)/(2 Phi(c) - 1)).

    Mean square sizes of 24,000 quantiles are exact to 1e-4.
    """
    mean, deviation, c = 12e-3, 2e-3, 3.0
    found = shapes(
        tmp_path,
        entry(form="disc", size="12 mm", size_distribution=distribution, size_deviation="2 mm"),
        head="",
    )
    assert len(found.shapes) == CLASSES
    area = np.array([shape.area for shape in found.shapes])
    mass = area * found.shares
    np.testing.assert_allclose(mass / mass.sum(), 1 / CLASSES, rtol=5e-3)
    phi = math.exp(-(c**2) / 2) / math.sqrt(2 * math.pi)
    if distribution == "normal":
        cut = deviation**2 * (1 - 2 * c * phi / math.erf(c / math.sqrt(2)))
        square = mean**2 + cut
    else:  # moments of the cut lognormal: exp(k mu + k^2 w^2/2) (Phi(c - kw) - Phi(-c - kw))
        w = math.sqrt(math.log1p((deviation / mean) ** 2))
        inside = math.erf(c / math.sqrt(2))
        between = [0.5 * (1 + math.erf((s * c - 2 * w) / math.sqrt(2))) for s in (1, -1)]
        square = mean**2 * math.exp(w**2) * (between[0] - between[1]) / inside
    assert found.mean_area == pytest.approx(math.pi / 4 * square, rel=1e-4)


def test_a_sieve_table_is_met_by_mass_and_may_be_a_file(tmp_path):
    """Between sieves mass is even over the size: the mass below 8 mm is 0.4 (8 - 5)/(10 - 5).

    Twelve classes of equal mass are sharp to one of them.
    """
    (tmp_path / "sieve.csv").write_text("opening,passing\n5 mm,0\n10 mm,0.4\n15 mm,1\n")
    found = shapes(tmp_path, entry(form="hexagon", size_distribution="sieve", sieve="sieve.csv"))
    width = np.array([shape.width for shape in found.shapes])
    mass = np.array([shape.area for shape in found.shapes]) * found.shares
    assert 5e-3 < width.min() < width.max() < 15e-3
    for size, passing in ((8e-3, 0.24), (10e-3, 0.4), (12e-3, 0.64)):
        assert mass[width < size].sum() / mass.sum() == pytest.approx(passing, abs=0.5 / CLASSES)
    # Mass even over the size: number as d^-2, whose mean square is the class's a b.
    mean_square = 1 / (0.4 / (5e-3 * 10e-3) + 0.6 / (10e-3 * 15e-3))
    hexagon = found.shapes[0].area / width[0] ** 2
    assert found.mean_area == pytest.approx(hexagon * mean_square, rel=1e-4)


def test_shares_by_mass_are_met(tmp_path):
    found = shapes(
        tmp_path,
        entry("small", form="disc", size="5 mm", mass_share=1),
        entry("large", form="disc", size="10 mm", mass_share=3),
    )
    assert found.shares == pytest.approx((4 / 7, 3 / 7), rel=1e-12)


def test_a_spheroradius_of_its_own(tmp_path):
    own = shapes(
        tmp_path,
        entry("sharp", form="square", size="10 mm", spheroradius="0.2 mm"),
        entry("usual", form="square", size="10 mm"),
    )
    assert [shape.spheroradius for shape in own.shapes] == [0.2e-3, 0.5e-3]


DISC = {"form": "disc", "size": "9 mm"}


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"form": "dsic", "size": "9 mm"}, ["form = 'dsic'", "did you mean 'disc'"]),
        ({"form": "square"}, ["size = None", "its side", "'12 mm'"]),
        ({"form": "rectangle", "size": "9 mm"}, ["its length and width", "['15 mm', '10 mm']"]),
        ({"form": "polygon", "size": "9 mm"}, ["corners", "corners = 7"]),
        ({"form": "polygon", "size": "9 mm", "corners": 2}, ["corners = 2", "from 3 to 32"]),
        ({"form": "hexagon", "size": "9 mm", "corners": 6}, ["corners", "leave it out"]),
        ({**DISC, "spheroradius": "1 mm"}, ["spheroradius", "half its size"]),
        ({**DISC, "size": "-9 mm"}, ["size = -9 mm", "above 0"]),
        ({**DISC, "size_deviation": "1 mm"}, ["size_deviation", "needs a size_distribution"]),
        ({**DISC, "size_distribution": "nromal"}, ["did you mean 'normal'"]),
        ({**DISC, "size_distribution": "normal"}, ["size_deviation: missing", "'1 mm'"]),
        (
            {**DISC, "size_distribution": "normal", "size_deviation": "4 mm"},
            ["size_deviation = 4 mm", "less than 3 mm", "lognormal"],
        ),
        ({**DISC, "size_distribution": "sieve"}, ["size: the sieve gives the sizes"]),
        ({"form": "circle", "size": "9 mm"}, ["form = 'circle'", "did you mean 'disc'"]),
        ({"form": "disc", "size_distribution": "sieve"}, ["rows of opening and share"]),
        (
            {"form": "disc", "size_distribution": "sieve", "sieve": "no.csv"},
            ["sieve = 'no.csv'", "no such file"],
        ),
        (
            {"form": "disc", "size_distribution": "sieve", "sieve": [["2 mm", 0.1], ["3 mm", 1]]},
            ["rise from 0 at the finest"],
        ),
        ({**DISC, "outline": [[0, 0], [1, 0], [0, 1]]}, ["form and outline are both given"]),
        ({"outline": [[0, 0], [9, 0], [0, 9]], "size": "9 mm"}, ["size: goes with a form"]),
        ({**DISC, "share": 1, "mass_share": 2}, ["a share, or every shape a mass_share"]),
    ],
)
def test_a_form_that_cannot_be(keys, words, tmp_path):
    head = 'spheroradius = "0.5 mm"\nunit = "mm"'
    assert_refuses(words, shapes, tmp_path, entry(**keys), head=head)


def test_sieves_that_are_no_text_are_refused(tmp_path):
    (tmp_path / "sieve.csv").write_bytes(b"opening,passing\n2 mm,\xff\n")
    keys = {"form": "disc", "size_distribution": "sieve", "sieve": "sieve.csv"}
    assert_refuses(["sieve.csv", "no CSV table"], shapes, tmp_path, entry(**keys))


def test_what_is_apart_has_index_one_and_what_is_even_less_than_zero():
    """Cells of four: all or nothing is 1; half and half is -sr^2/(s0^2 - sr^2) = -3/(4 * 7 - ...).

    With N particles in C cells: (C - 1)/(N - 1) is sr^2 over s0^2.
    """
    cells = np.repeat(np.array([[k, 0] for k in range(8)]), 4, axis=0)
    apart = np.repeat(np.arange(8) < 4, 4)
    assert segregation_index(cells, apart) == pytest.approx(1.0, abs=1e-15)
    ratio = 7 / 31
    even = np.tile([True, True, False, False], 8)
    assert segregation_index(cells, even) == pytest.approx(-ratio / (1 - ratio), rel=1e-12)
    assert segregation_index(cells, np.ones(32, bool)) is None


def test_what_is_dealt_at_random_has_index_zero_on_average():
    """Cells of unequal numbers; 2,000 deals: the mean is zero within four standard errors."""
    rng = np.random.default_rng(5)
    number = np.array([1, 2, 3, 5, 8, 13, 21])
    cells = np.repeat(np.column_stack([np.arange(7), np.zeros(7)]), number, axis=0).astype(int)
    member = np.arange(53) < 17
    found = [segregation_index(cells, rng.permutation(member)) for _ in range(2000)]
    assert abs(np.mean(found)) < 4 * np.std(found) / math.sqrt(len(found))


def test_parts_of_a_mixture_are_told_apart_by_name_and_by_size(tmp_path, monkeypatch):
    """Small discs left and large ones right of x = 0, which cells of a lattice end at: apart."""
    small, large = disc("small", 8e-3), disc("large", 10e-3)
    across, up = np.meshgrid(np.arange(-95, 100, 10), np.arange(5, 205, 10))
    x, y = across.ravel(), up.ravel()
    kinds = (x > 0).astype(int)
    scene = scene_of([small, large], kinds, hopper(0.0, 40e-3), 1e-3 * x, 1e-3 * y)
    scene.trajectory.static["shape_part"] = np.array([1, 0])
    scene.trajectory.attributes["part_names"] = json.dumps(["large", "small"])
    monkeypatch.setattr(segregation, "read_scene", lambda folder: scene)
    found = segregation.measure(tmp_path)
    assert [row["component"] for row in found["components"]] == ["large", "small", "fine"]
    assert found["small_at_opening"] == found["fine_at_opening"] == found["large_at_opening"]
    assert found["small_at_opening"] == pytest.approx(1.0, abs=1e-12)
    scene.trajectory.attributes["part_names"] = json.dumps(["large", "fine"])  # theirs stays
    own, by_size = segregation.components(scene)["fine"], segregation.components(scene)
    assert (own == (x <= 0)).all()
    assert list(by_size) == ["large", "fine", "below mean area"]
    scene.trajectory.static["kind"] = np.zeros_like(kinds)
    assert_refuses(["all particles are alike"], segregation.measure, tmp_path)


def test_shapes_of_a_case_may_be_scaled():
    """wood19 at 0.9: areas by 0.81, second moments by 0.6561, widths and corners by 0.9."""
    shipped = SiloCase.load("A4").shapes
    smaller = SiloCase.load("A4", {"particles.scale": 0.9}).shapes
    for one, other in zip(shipped.shapes, smaller.shapes, strict=True):
        assert other.area == pytest.approx(0.81 * one.area, rel=1e-14)
        assert other.polar_moment == pytest.approx(0.6561 * one.polar_moment, rel=1e-14)
        assert other.width == pytest.approx(0.9 * one.width, rel=1e-14)
        assert other.spheroradius == pytest.approx(0.9 * one.spheroradius, rel=1e-14)
    assert smaller.shares == shipped.shares


@pytest.mark.parametrize("radius", ["0.5 mm", "2 mm"])
def test_other_corners_leave_the_faces_where_they_are(radius):
    """A corner of turning angle a loses r^2 (tan(a/2) - a/2); faces and widths stay, a rectangle's
    too; of the shape file's own radius all stays as it is, to rounding.
    """
    shipped = SiloCase.load("A4").shapes
    own = SiloCase.load("A4", {"particles.spheroradius": "1 mm"}).shapes
    other = SiloCase.load("A4", {"particles.spheroradius": radius}).shapes
    r = float(radius.split()[0]) * 1e-3
    for one, same, changed in zip(shipped.shapes, own.shapes, other.shapes, strict=True):
        assert same.area == pytest.approx(one.area, rel=1e-12)
        angle = corner_angles(one.core)
        lost = (r**2 - 1e-6) * (np.tan(angle / 2) - angle / 2).sum()
        assert changed.area == pytest.approx(one.area - lost, rel=1e-10)
        assert changed.spheroradius == r
        if one.name in ("12", "13"):  # between parallel faces
            assert changed.width == pytest.approx(one.width, rel=1e-12)


@pytest.mark.parametrize("radius", [0.2e-3, 1e-3])
@pytest.mark.parametrize(
    "form",
    [{"form": "hexagon"}, {"form": "triangle"}, {"form": "rectangle", "size": ["9 mm", "6 mm"]}],
)
def test_the_spheroradius_of_a_sieve_is_that_of_its_mean_mass(form, radius, tmp_path):
    """Scaled copies: each as round for its width, and as given at the root of the mean square.

    Twelve classes keep number and mass, so that mean to rounding.
    """
    found = shapes(
        tmp_path,
        entry(**form, size_distribution="sieve", sieve=[["6 mm", 0.0], ["12 mm", 1.0]]),
        head=f'spheroradius = "{1e3 * radius:g} mm"',
    )
    width = np.array([shape.width for shape in found.shapes])
    usual = math.sqrt(float(np.asarray(found.shares) @ width**2))
    radii = [shape.spheroradius for shape in found.shapes]
    assert radii == pytest.approx(radius * width / usual, rel=1e-9)


FLAT = {
    "silo.angle": "0 deg", "silo.outlet": "60 mm", "silo.width": "120 mm", "silo.height": "250 mm",
    "fill.level": "200 mm",
}  # fmt: skip


def test_a_mixture_of_very_different_sizes_is_poured_to_the_level_whatever_the_seed(tmp_path):
    """Its area is what is wanted, less one of the largest: a few large ones are half of it."""
    large, small = (entry(name, form="disc", size=size, mass_share=1) for name, size in
                    (("large", "30 mm"), ("small", "6 mm")))  # fmt: skip
    shapes(tmp_path, large, small, head="")
    case = SiloCase.load("A4", {**FLAT, "particles.shapes": str(tmp_path / "shapes.toml")})
    areas = np.array([shape.area for shape in case.shapes.shapes])
    wanted = LOOSE * case.outline.area_below(0.2) - areas.max()
    for seed in range(20):
        kinds = rain(case, np.random.default_rng(seed))[0]
        assert areas[kinds].sum() > wanted
        assert (areas * np.bincount(kinds)).min() > wanted / 2 - areas.max()


def test_a_bed_of_nearly_equal_areas_is_drawn_by_chance():
    """As ever: the paper's beds keep their bits, down to 16 particles."""
    shares = SiloCase.load("A4").shapes
    by_chance = np.random.default_rng(1).choice(19, size=20, p=shares.shares)
    np.testing.assert_array_equal(kinds_of(shares, 20, np.random.default_rng(1)), by_chance)


def test_a_bed_that_ends_below_its_level_is_reported(tmp_path):
    case, said = SiloCase.load("A4", FLAT), []
    for top, words in ((0.19, []), (0.163, ["the bed ends at 163 mm, more than", "= 200 mm"])):
        bed = np.array([[0.0, 0.01, 0.0], [0.0, top, 0.0]])
        digest = sources_of_both(case)[1].digest
        packing = Packing(np.zeros(2, np.int64), bed, None, 1.0, "dem", 0.0, sources=digest)
        folder = packing_folder(case, tmp_path)
        folder.mkdir(parents=True, exist_ok=True)
        save_packing(packing, folder)
        get_packing(case, tmp_path, lambda *_: None, warn=said.append)
        assert len(said) == bool(words)
        assert all(word in said[0] for word in words)
