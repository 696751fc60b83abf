"""The commands impact and contact: what they take, print and refuse; the studies' numbers."""

import json

import pytest
from click.testing import CliRunner

from damper3d.commands.contact import contact
from damper3d.commands.impact import impact
from damper3d.studies.single_contact import STUDIES, find
from granulab.errors import InputError


def result(*arguments):
    """The JSON of an impact."""
    result = CliRunner().invoke(impact, [*arguments, "--json", "--quiet"], catch_exceptions=False)
    return json.loads(result.stdout)


def refusal(*arguments):
    """The line with which an impact is refused."""
    with pytest.raises(InputError) as error:
        CliRunner().invoke(impact, list(arguments), catch_exceptions=False)
    text = str(error.value)
    assert "\n" not in text
    return text


def test_impact_by_name_and_by_constants_are_one():
    by_name = result("--material", "glass", "--radius", "10 mm", "--speed", "20", "--against",
                     "sphere")  # fmt: skip
    by_hand = result("--youngs-modulus", "48 GPa", "--poisson", "0.2", "--density", "2800 kg/m3",
                     "--radius", "10mm", "--speed", "20 m/s", "--against", "sphere")  # fmt: skip
    for key in ("normal_restitution", "contact_time_s", "max_overlap_m", "max_force_n"):
        assert by_name[key] == pytest.approx(by_hand[key], rel=1e-12)
    assert by_name["max_overlap_m"] == pytest.approx(274.113e-6, rel=2e-5)
    assert by_name["tangential_restitution"] is None


def test_impact_takes_the_pair_of_the_materials_file():
    found = result("--material", "alumina", "--angle", "50")
    assert (found["restitution"], found["friction"]) == (0.98, 0.092)
    assert found["tangential_restitution"] == pytest.approx(0.8471, abs=1e-4)


def test_impact_says_which_constants_it_took():
    result = CliRunner().invoke(impact, ["--material", "steel", "--against", "rigid-wall"])
    assert "no restitution of steel on a rigid wall is known: 1 is taken" in result.stderr
    assert "no friction of steel on a rigid wall is known: 0 is taken" in result.stderr
    assert "normal restitution       1.0000" in result.stdout


def test_an_overlap_that_hertz_does_not_hold_for_is_said():
    """Above a twentieth of the radius: acrylic at 60 m/s; it grows as v^0.8 (eq. 5.8)."""
    deep, usual = (result("--speed", speed) for speed in ("60", "3.9"))
    assert usual["warnings"] == []
    (line,) = deep["warnings"]
    part = deep["max_overlap_m"] / 2.5e-3
    assert line.startswith(f"the overlap is {part:.2g} of the radius")
    said = CliRunner().invoke(impact, ["--speed", "60"])
    assert f"warning: {line}" in said.stderr


def test_other_material_as_the_wall():
    """A soft wall makes the contact longer than a rigid one; both bodies' compliances add."""
    rigid, steel, acrylic = (
        result("--material", "steel", "--against", wall)["contact_time_s"]
        for wall in ("rigid-wall", "wall", "acrylic")
    )
    assert rigid < steel < acrylic


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--angle", "90"], "angle = 90 deg: must be from 0 to below 90"),
        (["--speed", "0"], "speed = 0 m/s: must be above 0"),
        (["--speed", "nan"], "speed = nan"),
        (["--speed", "3 kg"], "speed = '3 kg'"),
        (["--radius", "2.5"], "radius = '2.5'"),
        (["--speed", "1e5"], "speed = 100000 m/s: an overlap of"),
        (["--restitution", "1.2"], "restitution = 1.2: must be above 0 and at most 1"),
        (["--friction", "-1"], "friction = -1: must be at least 0"),
        (["--tangential", "linear"], "tangential = 'linear': takes displacement, force"),
        (["--against", "stel"], "against = 'stel': no such table or file"),
        (["--material", "wod"], "material = 'wod': no such table or file"),
        (["--density", "1 g/cm3"], "needs --youngs-modulus, --poisson too"),
        (["--other-spin", "5"], "other_spin = 5 rad/s: against = 'wall' does not rotate"),
        (["--material", "alumina", "--yielding"], "material 'alumina' has no yield_strength"),
    ],
)
def test_bad_input_gets_one_line(arguments, line):
    assert line in refusal(*arguments)


def test_material_file_is_one_of_the_user(tmp_path):
    """Its only material; what it lacks is named, and options can fill it in."""
    file = tmp_path / "mine.toml"
    file.write_text('schema = 1\n[material.rubber]\ndensity = "1.1 g/cm3"\npoisson = 0.49\n')
    assert "material 'rubber' has no youngs_modulus" in refusal("--material", str(file))
    found = result("--material", str(file), "--youngs-modulus", "5 MPa", "--restitution", "0.5")
    assert found["material"] == "rubber"
    assert found["normal_restitution"] == pytest.approx(0.5, abs=1e-4)


def test_an_impact_repeats_its_angular_velocities_and_its_damping():
    words = ["--against", "sphere", "--spin", "3", "--other-spin", "-4", "--damping", "restitution"]
    found = CliRunner().invoke(impact, [*words, "--json"])
    used = json.loads(found.stdout)
    assert (used["spin_before_rad_s"], used["other_spin_before_rad_s"]) == (3.0, -4.0)
    assert used["damping"] == "restitution"
    assert "angular velocity 3 and -4 rad/s" in found.stderr
    assert "damping restitution" in found.stderr


def test_contact_lists_its_studies():
    listed = CliRunner().invoke(contact, []).output
    assert [line.split()[0] for line in listed.splitlines()] == list(STUDIES)


def test_unknown_study_is_refused():
    with pytest.raises(InputError, match="contact 'yeild': no such study"):
        find("yeild")


def test_study_leaves_picture_curves_and_report(tmp_path):
    result = CliRunner().invoke(contact, ["force", "--out", str(tmp_path), "--json"])
    found = json.loads(result.stdout)
    kinds = ("csv", "parquet", "txt", "png")
    assert {p.name for p in tmp_path.iterdir()} == {f"force.{kind}" for kind in kinds}
    assert found["files"] == [str(tmp_path / f"force.{kind}") for kind in kinds]
    surface = found["particle-surface"]
    assert surface["tangential_over_normal_stiffness"] == pytest.approx(2 * 0.7 / 1.7)
    # The simplified law slides where the exact force is mu N (1 - 3^(-3/2)).
    assert surface["largest_overestimate_of_limit"] == pytest.approx(3**-1.5, abs=0.01)


def test_coded_laws_follow_theory():
    """Fig. 5.4: the engine's normal force is Hertz's, the exact law its closed curves, through a
    loop. Tolerance: of the springs, 1/400^2, and of their slip within a step."""
    found = find("force").compute()
    largest = max(row["theory_n"] for row in found.rows)
    for row in found.rows:
        coded = row["law_n"] if row["direction"] == "normal" else row["exact_n"]
        assert coded == pytest.approx(row["theory_n"], abs=1e-4 * largest)


def test_steel_ball():
    """Fig. 5.20: 8.1 yield velocities; 0.51 J to zero overlap, 0.48 J to zero force."""
    found = find("steel-ball").compute().numbers
    assert found["speed_over_yield_velocity"] == [pytest.approx(8.1, abs=0.06)]
    assert found["2.4 m/s, to zero overlap"]["dissipated_j"] == pytest.approx(0.512, abs=1e-3)
    assert found["2.4 m/s, to zero force"]["dissipated_j"] == pytest.approx(0.479, abs=1e-3)


def test_aluminium_ball():
    """Table 5.2: 12.2 and 122 yield velocities of 0.0016 m/s."""
    found = find("aluminium-ball").compute().numbers
    assert found["yield_velocity_m_s"] == pytest.approx(0.0016, abs=5e-5)
    assert found["speed_over_yield_velocity"] == pytest.approx([12.2, 122], abs=0.5)


def test_yield_study():
    """Eq. 5.26 as printed, 0.3 m/s measured for 12.7 mm of steel, and the fall as v^(-1/4)."""
    found = find("yield").compute().numbers
    assert found["acrylic, 5 mm"]["on_its_like_m_s"] == pytest.approx(3.5, abs=0.05)
    assert found["steel, 5 mm"]["on_its_like_m_s"] == pytest.approx(0.15, abs=0.005)
    assert found["steel, 12.7 mm"]["on_a_wall_of_it_m_s"] == pytest.approx(0.3, abs=0.005)
    assert found["exponent_above"] == pytest.approx(-0.25, abs=1e-3)


@pytest.mark.parametrize("name", ["damping", "oblique"])
def test_study_draws(name):
    """Every panel has curves and named axes."""
    module = find(name)
    figure = module.draw(module.compute())
    assert all(axes.lines and axes.get_xlabel() and axes.get_ylabel() for axes in figure.axes)
