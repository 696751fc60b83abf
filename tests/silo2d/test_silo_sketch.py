"""A silo drawn before it is run: outlet, fill level and shapes, to scale."""

import subprocess
import sys

import numpy as np
import pytest
from small_silo import DRY, silo2d, write_case

from granulab.campaign.sweeps.sketch import draw_sketch, panels_of
from silo2d.case.case import SiloCase
from silo2d.view.sketch import sketch


@pytest.fixture(scope="module")
def a4():
    return SiloCase.load("A4")


def area(points):
    x, y = points.T
    return 0.5 * abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def test_walls_outlet_and_level_are_those_of_the_case(a4):
    """Every piece of wall, the door as wide as the outlet, the bed up to the level."""
    silo, _ = sketch(a4)
    assert len(silo.lines) == len(a4.outline.walls().names) - 1
    door, level = silo.dashed
    assert np.ptp(door[:, 0]) == pytest.approx(0.15)
    assert level[:, 1] == pytest.approx([0.475, 0.475])
    bed = silo.filled[0].points
    assert area(bed[:-1]) == pytest.approx(a4.outline.area_below(0.475))
    assert [words for *_, words in silo.spans] == ["150 mm", "fill level 475 mm"]


def test_a_bed_of_two_hoppers_is_drawn_in_both(tmp_path):
    """An outline with a ridge in its floor, filled to below the ridge: two pieces."""
    outline = [[-40, 0], [40, 0], [60, 60], [60, 100], [-60, 100], [-60, 60]]
    ridge = [*outline[:3], [60, 100], [-60, 100], [-100, 60], [-75, 20], [-60, 50]]
    for corners, pieces in ((outline, 1), (ridge, 2)):
        changes = dict.fromkeys(["silo.angle", "silo.width", "silo.height"])
        case = SiloCase.load(write_case(tmp_path, {
            **changes, "silo.outline": corners, "silo.outlet": "40 mm", "fill.level": "40 mm",
        }))  # fmt: skip
        beds = [one for one in sketch(case)[0].filled if one.edge == "none"]
        assert len(beds) == pieces


def test_every_shape_is_drawn_with_its_area_and_size(a4):
    """Five points a corner cut off at most 0.3 % of an area."""
    _, shapes = sketch(a4)
    for drawn, shape in zip(shapes.filled, a4.shapes.shapes, strict=True):
        assert area(drawn.points) == pytest.approx(shape.area, rel=3e-3)
    assert "19 shapes" in shapes.title
    assert "equally many of each" in shapes.title
    first = a4.shapes.shapes[0]
    assert shapes.words[0][1].startswith(f"{first.name}\n{1e3 * first.width:.3g} x ")


def test_shapes_do_not_overlap(a4):
    """Each in a cell of its own."""
    _, shapes = sketch(a4)
    centres = np.array([one.points.mean(axis=0) for one in shapes.filled])
    apart = np.linalg.norm(centres[:, None] - centres, axis=-1)
    np.fill_diagonal(apart, np.inf)
    assert apart.min() > 2 * a4.shapes.bounding_radius


def test_a_study_draws_what_differs_once():
    """Two outlets and two frictions: two silos, one set of shapes."""
    cases = [
        SiloCase.load("A4", {"silo.preset": None, "silo.angle": "60 deg", "silo.width": "300 mm",
                             "silo.height": "500 mm", "silo.outlet": outlet, "law.mu_wall": mu})
        for outlet in ("100 mm", "150 mm") for mu in (0.2, 0.4)
    ]  # fmt: skip
    panels = panels_of(cases, sketch, lambda case: case.outline.outlet)
    assert [panel.title.split(",")[0] for panel in panels] == [
        "outlet 100 mm", "wood19: 19 shapes", "outlet 150 mm",
    ]  # fmt: skip
    figure = draw_sketch("study", panels)
    assert len([axes for axes in figure.axes if axes.collections]) == 3


def test_a_study_of_many_silos_draws_a_few():
    cases = range(100)
    drawn = panels_of(cases, lambda case: sketch(SiloCase.load("A4"))[:1], lambda case: case)
    assert len(drawn) == 1  # all alike
    some = panels_of(
        cases,
        lambda k: [sketch(SiloCase.load("A4"))[0]._replace(title=str(k))], lambda k: k
    )  # fmt: skip
    assert len(some) == 12


def test_a_dry_run_draws_beside_where_the_run_would_be_and_begins_nothing(tmp_path):
    """The path is printed, also in JSON; nothing else is written, and without figures nothing."""
    case = write_case(tmp_path)
    words = ["run", case, "-o", tmp_path / "runs"]
    plan = silo2d(*words, "--dry-run", "--json").json
    (picture,) = tmp_path.rglob("*.png")
    assert plan["picture"] == str(picture)
    assert [path.name for path in (tmp_path / "runs").iterdir()] == [picture.name]
    assert f"picture {picture}" in " ".join(silo2d(*words, "--dry-run").out.split())
    assert silo2d(*words, *DRY, "--json").json["picture"] is None


def test_a_picture_that_cannot_be_written_is_a_line_and_the_plan_stands(tmp_path):
    (tmp_path / "runs").write_text("no folder")
    done = silo2d("run", "A4", "--dry-run", "-o", tmp_path / "runs")
    assert done.code == 0
    assert "no picture: " in done.err
    assert "expected" in done.out


def test_help_imports_no_drawing():
    program = "import sys; from silo2d.commands.main import main\ntry: main()\n"
    program += "except SystemExit: pass\nassert 'matplotlib' not in sys.modules"
    subprocess.run(
        [sys.executable, "-c", program, "run", "--help"], check=True, capture_output=True
    )
