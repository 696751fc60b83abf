"""Enclosures in a case: fill ratio, walls of their own material, cells, files; what is refused."""

from pathlib import Path

import numpy as np
import pytest
from made_cavities import box_of, cavity_of, prism_of, round_rim, write_stl
from refusals import assert_refused
from small_damper import damper3d
from small_silo import DRY

from damper3d import DamperCase
from damper3d.engine.enclosures import Cavity, Cells
from damper3d.view.report import echo
from granulab.campaign.runs.folder import digest
from granulab.contact.hertz import HertzLaw
from granulab.errors import InputError

MATERIALS = """schema = 1
[material.acrylic]
density = "1190 kg/m3"
youngs_modulus = "3.3 GPa"
poisson = 0.37
yield_strength = "125 MPa"
[material.steel]
density = "7850 kg/m3"
youngs_modulus = "210 GPa"
poisson = 0.3
yield_strength = "300 MPa"
[pair.acrylic-acrylic]
friction = 0.52
restitution = 0.86
[pair.acrylic-steel]
friction = 0.3
restitution = 0.8
"""
STEEL = {"enclosure.walls": {"bottom": "steel", "side": "steel"}}
CUBE = [[x, y, z] for x in (0, 20) for y in (0, 20) for z in (0, 20)]
FACES = [[1, 0, 0, 10], [-1, 0, 0, 10], [0, 1, 0, 10], [0, -1, 0, 10], [0, 0, 1, 20], [0, 0, -1, 0]]
SHAPES = {
    "frustum": {"diameter": "40 mm", "top_diameter": "30 mm", "height": "35 mm"},
    "sphere": {"diameter": "40 mm"},
    "hexagonal_prism": {"across_flats": "40 mm", "height": "35 mm"},
    "polyhedron": {"vertices": CUBE, "unit": "mm"},
    "cylinder": {"diameter": "20 mm", "cells": [2, 3], "cell_wall": "1 mm"},
    "box": {"width": "20 mm", "cells": [2, 1], "cell_wall": "1 mm"},
}


def case(shape: str | None = None, table: dict | None = None, **changes) -> DamperCase:
    keys = {} if shape is None else {"shape": shape, **SHAPES.get(shape, {}), **(table or {})}
    named = {key.replace("__", "."): value for key, value in changes.items()}
    own = {f"enclosure.{key}": value for key, value in keys.items() if value is not None}
    return DamperCase.load("thesis", own | named)


@pytest.fixture
def materials(tmp_path) -> dict[str, str]:
    path = tmp_path / "two.toml"
    path.write_text(MATERIALS, encoding="utf-8")
    return {"particles.materials": str(path)}


@pytest.fixture
def stl(tmp_path) -> str:
    return str(write_stl(tmp_path / "box.stl", 1e3 * box_of(0.02, 0.02, 3)))


def test_a_fill_ratio_gives_the_nearest_count():
    """Eq. 6.1: 0.41 of 40 mm x 40 mm are 315 spheres of 5 mm, and the echo says so."""
    found = case(particles__fill_ratio=0.41)
    assert found.count == round(0.41 * found.enclosure.volume / found.particle.volume) == 315
    assert "315 of sphere:5mm" in echo(found, dry_run=False)
    assert case(particles__fill_ratio=0.41, particles__count=315).count == 315
    assert digest(found.identity()) == digest(case(particles__count=315).identity())


@pytest.mark.parametrize("shape", SHAPES)
def test_a_case_of_each_shape_comes_back_from_its_run_folder(shape, tmp_path):
    _comes_back(case(shape), tmp_path)


def _comes_back(first: DamperCase, folder: Path) -> DamperCase:
    for name, text in first.files.items():
        (folder / name).write_text(text, encoding="utf-8")
    path = folder / "case.toml"
    path.write_text(first.to_toml(), encoding="utf-8")
    again = DamperCase.load(path)
    assert digest(again.identity()) == digest(first.identity())
    assert again.enclosure.volume == pytest.approx(first.enclosure.volume, rel=1e-12)
    return again


def test_a_cavity_comes_back_without_its_file(stl, tmp_path):
    """The run folder has a copy; single numbers of STL make the volume right to 1e-6."""
    first = case("cavity", {"file": stl, "unit": "mm"})
    assert isinstance(first.enclosure, Cavity)
    assert first.enclosure.volume == pytest.approx(0.02**3, rel=1e-6)
    Path(stl).unlink()
    (tmp_path / "run").mkdir()
    _comes_back(first, tmp_path / "run")


def test_cells_are_filled_alike():
    """The fill ratio counts all cells, each of which is one cylinder."""
    cells = case("cylinder")
    assert isinstance(cells.enclosure, Cells)
    one = case(enclosure__diameter="20 mm")
    assert cells.fill_ratio == pytest.approx(one.fill_ratio, abs=0.5 / one.count)
    assert abs(cells.count - 6 * one.count) <= 3


def test_walls_of_their_own_material_have_its_law(materials, tmp_path):
    usual, mixed = case(**_named(materials)), case(**_named(materials | STEEL))
    whole = case(**_named(materials | {"enclosure.material": "steel"}))
    assert isinstance(usual.laws(1)[1], HertzLaw)
    assert digest(usual.identity()) == digest(case().identity())
    table = mixed.laws(1)[1]
    assert mixed.wall_law == usual.wall_law
    rows = table.constants[table.number[0, table.walls]]
    wanted = [one.wall_law[:6] for one in (whole, usual, whole)]
    assert rows[:, :6] == pytest.approx(np.array(wanted, float), rel=0.0)
    digests = {digest(one.packing_identity()) for one in (usual, mixed, whole)}
    assert len(digests) == 3
    words = echo(mixed, dry_run=False)
    assert "1-wall of steel" in words
    assert "mu 0.3, restitution 0.8" in words
    _comes_back(mixed, tmp_path)


def test_the_yield_velocity_is_that_of_the_wall_that_yields_first(materials):
    """Eq. 5.26 against acrylic and against steel."""
    each = [
        case(**_named(materials | {"enclosure.material": name})).yield_velocity["particle_wall"]
        for name in ("acrylic", "steel")
    ]
    mixed = case(**_named(materials | STEEL)).yield_velocity
    assert mixed["particle_wall"] == min(each)


def _named(changes: dict) -> dict:
    return {key.replace(".", "__"): value for key, value in changes.items()}


REFUSED = [
    # sizes that make no enclosure
    ("frustum", {"top_diameter": "0 mm"}, ["top_diameter", "greater than 0"]),
    ("frustum", {"top_diameter": None}, ["top_diameter is missing"]),
    ("frustum", {"top_diameter": "1 mm", "height": "5.5 mm", "diameter": "8 mm"},
     ["across, within the side", "smaller than a particle, 5 mm"]),
    ("frustum", {"height": "4 mm"}, ["4 mm at the narrowest, between bottom and top"]),
    ("sphere", {"height": "40 mm"}, ["height goes with shape = 'cylinder'", "has diameter"]),
    ("sphere", {"diameter": None}, ["diameter is missing"]),
    ("sphere", {"diameter": "4 mm"}, ["4 mm at the narrowest, across"]),
    ("hexagonal_prism", {"across_flats": None}, ["across_flats is missing"]),
    ("hexagonal_prism", {"width": "4 cm"}, ["width and depth go with shape = 'box'"]),
    ("hexagonal_prism", {"across_flats": "4 mm"}, ["4 mm at the narrowest, between side"]),
    # planes that do not close, corners that are none
    ("polyhedron", {"vertices": None}, ["either vertices or faces"]),
    ("polyhedron", {"faces": FACES}, ["either vertices or faces"]),
    ("polyhedron", {"unit": None}, ["unit is missing", "of vertices"]),
    ("polyhedron", {"unit": "kg"}, ["unit is wrong"]),
    ("polyhedron", {"vertices": CUBE[:3]}, ["vertices", "at least 4"]),
    ("polyhedron", {"vertices": [[0, 0], *CUBE[1:]]}, ["number 1 has 2 numbers", "write 3"]),
    ("polyhedron", {"vertices": [[x, y, 0] for x, y, _ in CUBE]}, ["do not lie in one plane"]),
    ("polyhedron", {"vertices": [*CUBE, [10, 10, 10]]}, ["number 9 is no corner", "cavity"]),
    ("polyhedron", {"vertices": None, "faces": FACES[:5]}, ["do not close", "open"]),
    ("polyhedron", {"vertices": None, "faces": [*FACES, [0, 0, 1, 30]]}, ["number 7", "take it"]),
    ("polyhedron", {"vertices": None, "faces": [*FACES[:5], [0, 0, 0, 1]]}, ["no direction"]),
    ("polyhedron", {"vertices": None, "faces": [*FACES[:5], [0, 0, -1, -30]]}, ["no void"]),
    ("polyhedron", {"unit": "0.1 mm"}, ["2 mm at the narrowest, between face1"]),
    # cells
    ("box", {"cell_wall": None}, ["cell_wall is missing"]),
    ("box", {"cells": None}, ["cells is missing"]),
    ("box", {"cells": [2]}, ["cells", "at least 2"]),
    ("box", {"cells": [0, 2]}, ["cells", "greater than or equal to 1"]),
    ("box", {"cell_wall": "0.1 mm"}, ["cell_wall = 0.1 mm", "at least 0.25 mm"]),
    ("sphere", {"cells": [2, 2]}, ["go with shape = 'cylinder' or 'box'", "'sphere'"]),
    # walls
    ("sphere", {"walls": {"bottom": "acrylic"}}, ["'bottom'", "known: shell"]),
    ("sphere", {"walls": {"shell": "steel"}}, ["no material 'steel'"]),
    ("sphere", {"walls": {"shell": 3}}, ["walls", "must be a text"]),
    # a cavity
    ("cavity", {"unit": "mm"}, ["file is missing"]),
    ("cavity", {"file": "box.stl"}, ["unit is missing"]),
    ("cavity", {"file": "none.stl", "unit": "mm"}, ["none.stl", "cannot be read"]),
]  # fmt: skip


@pytest.mark.parametrize(("shape", "table", "words"), REFUSED)
def test_what_is_no_enclosure_is_refused_in_one_line(shape, table, words):
    with pytest.raises(InputError) as refused:
        case(shape, table)
    for word in words:
        assert word in str(refused.value)
    assert "\n" not in str(refused.value)


BOX = 1e3 * box_of(0.02, 0.02)
HALF = BOX.copy()
HALF[:3] = HALF[:3, ::-1]
UNSOUND = {
    "open": (BOX[1:], ["it is open", "close its holes"]),
    "inside out": (BOX[:, ::-1], ["inside out", "Invert Faces"]),
    "half turned": (HALF, ["some of its triangles face inwards", "Re-Orient"]),
    "too narrow": (
        0.2 * BOX,
        ["4 mm at the narrowest, for a sphere near (", "where it is widest", "5 mm"],
    ),
}


@pytest.mark.parametrize("name", UNSOUND)
def test_triangles_that_are_no_cavity_are_refused_in_one_line(name, tmp_path):
    corners, words = UNSOUND[name]
    path = write_stl(tmp_path / "made.stl", corners)
    with pytest.raises(InputError) as refused:
        case("cavity", {"file": str(path), "unit": "mm"})
    for word in words:
        assert word in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"fill_ratio": 0.41, "count": 300}, ["count = 300", "the ratio makes 315"]),
        ({"fill_ratio": 0.7}, ["fill_ratio = 0.7: 538 particles", "0.64", "at most 491 fit"]),
        ({"fill_ratio": 0.0}, ["fill_ratio", "greater than 0"]),
        ({"fill_ratio": 1.2}, ["fill_ratio", "less than or equal to 1"]),
        ({"fill_ratio": "41 mm"}, ["fill_ratio", "unit"]),
        ({"fill_ratio": 0.5, "shape": "sphere:1um"}, ["from fill_ratio = 0.5", "at most 10000000"]),
    ],
)
def test_fill_ratios_that_cannot_be_are_refused(changes, words):
    with pytest.raises(InputError) as refused:
        case(**{f"particles__{key}": value for key, value in changes.items()})
    for word in words:
        assert word in str(refused.value)


def test_the_option_of_the_fill_ratio(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    refused = damper3d("run", "--fill-ratio", "0.41", "--count", "3", "--dry-run")
    assert_refused(refused, "count = 3", "fill_ratio = 0.41")
    shown = damper3d("run", "--fill-ratio", "0.41", *DRY)
    assert shown.code == 0
    assert "315 of sphere:5mm" in shown.out + shown.err


def test_several_contacts_as_one_do_not_go_with_a_cavity(stl):
    with pytest.raises(InputError, match="a cavity is one wall all round; give 'sum'"):
        case("cavity", {"file": stl, "unit": "mm"}, law__contact_treatment="deepest",
             particles__shape="prolate:1.5", particles__equal_volume_radius="2 mm")  # fmt: skip


def test_a_convex_edge_counts_once_and_a_flat_seam_not_at_all():
    """A box has faces only; an L has the one reflex edge with its two corners."""
    assert cavity_of(box_of(0.02, 0.02, 5, 0.5))._features[1] == 0
    assert cavity_of(prism_of(round_rim(0.02, 96), 0.02))._features[1] == 0
