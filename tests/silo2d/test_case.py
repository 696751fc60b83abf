"""A case as resolved: units, overrides, damping, time step, and what names a run and a packing."""

import math
import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_silo import write_case

from granulab.contact.files.casefile import LARGEST, SMALLEST, folder_name
from granulab.contact.laws import LinearLaw
from granulab.errors import InputError
from silo2d.case.case import SiloCase
from silo2d.case.outline import PRESETS
from silo2d.case.parameters import USUAL_TIME_STEP
from silo2d.case.settings import Settings, check_settings, to_toml
from silo2d.case.shape import ShapeSet, shape_from_outline
from silo2d.case.stability import largest_stable_step
from silo2d.run.packing import packing_digest
from silo2d.run.protocol import run_digest


def a4(**changes) -> SiloCase:
    """Silo A4 with changes such as law__kn="1e4 N/mm"."""
    return SiloCase.load("A4", {key.replace("__", "."): v for key, v in changes.items()})


def packing_of(case: SiloCase) -> str:
    return packing_digest(case, case.settings.run.seed)


# What is in a case


@pytest.mark.parametrize("name", PRESETS)
def test_presets_are_the_papers_silos_and_wood(name):
    """300 mm x 500 mm, filled to 475 mm; wood's Table 4; Granular Matter 15 (2013) 811.

    Exact: decimal numbers are converted without rounding.
    """
    case = SiloCase.load(name)
    assert case.silo_name == name
    assert (case.outline.width, case.outline.height, case.settings.fill.level) == (0.3, 0.5, 0.475)
    assert case.outline.outlet == {"1": 0.04, "2": 0.06, "3": 0.1, "4": 0.15}[name[1]]
    assert case.surface_density == pytest.approx(450.0 * 0.12, rel=1e-15)
    assert tuple(case.particle_law) == (1e7, 6.5e5, 0.38, 6085.0, 3.0, True)
    assert tuple(case.wall_law) == (1e7, 6.5e5, 0.44, 4303.0, 3.0, True)


def test_a_silo_is_known_by_its_outline_not_by_how_it_is_written(tmp_path):
    """The hopper of 60 degrees spelled out, and as a polygon, is A4: same results published.

    The polygon's corner is rounded to 0.1 nm, a tenth of the 1 nm that silo_name allows.
    """
    nothing = dict.fromkeys(["silo.angle", "silo.outlet", "silo.width", "silo.height"])
    hopper = {**nothing, "silo.angle": "60 deg", "silo.outlet": "150 mm"}
    rise = round(75 * math.tan(math.radians(60)), 7)
    points = [[75, 0], [150, rise], [150, 500], [-150, 500], [-150, rise], [-75, 0]]
    spelled = SiloCase.load(write_case(tmp_path, hopper))
    drawn = SiloCase.load(write_case(tmp_path, {**nothing, "silo.outline": points}))
    assert spelled.silo_name == drawn.silo_name == "A4"
    assert a4(silo__outlet="149 mm").silo_name is None


@pytest.mark.parametrize(
    ("key", "spellings"),
    [
        ("silo.outlet", ["150 mm", "150mm", "15 cm", "0.15 m", "1.5e5 um"]),
        ("silo.angle", ["45 deg", "45°", "0.125 turn"]),
        ("law.kn", ["1.0e4 N/mm", "10 kN/mm", "1e7 N/m", "1e7 kg/s2"]),
        ("law.gamma_n", ["6085 1/s", "6.085 1/ms", "6.085 kHz"]),
        ("run.time_step", ["5 us", "5e-6 s", "0.005 ms"]),
        ("law.mu_wall", [0.4, "0.4", "40 %"]),
    ],
)
def test_units_are_a_matter_of_spelling(key, spellings):
    """One quantity in other units is the same run, to the last bit of every number."""
    digests = {run_digest(SiloCase.load("A4", {key: text})) for text in spellings}
    assert len(digests) == 1


# The law


@pytest.mark.parametrize(
    ("changes", "particle", "wall"),
    [
        ({"law__mu_particle": 0.1}, {"mu": 0.1}, {}),
        ({"law__mu_wall": 0.1}, {}, {"mu": 0.1}),
        ({"law__mu_wall": 0}, {}, {"mu": 0.0}),
        ({"law__kn": "8e3 N/mm"}, {"kn": 8e6}, {"kn": 8e6}),
        ({"law__kt": "500 N/mm"}, {"kt": 5e5}, {"kt": 5e5}),
        ({"law__gamma_t": "0 1/s"}, {"gamma_t": 0.0}, {"gamma_t": 0.0}),
        ({"law__gamma_n": "0 1/s"}, {"gamma_n": 0.0}, {"gamma_n": 0.0}),
        ({"law__gamma_n": "12170 1/s"}, {"gamma_n": 12170.0}, {"gamma_n": 8606.0}),
        ({"law__gamma_n_wall": "9 1/s"}, {}, {"gamma_n": 9.0}),
        (
            {"law__gamma_n": "7 1/s", "law__gamma_n_wall": "9 1/s"},
            {"gamma_n": 7.0},
            {"gamma_n": 9.0},
        ),
        ({"law__contact_end": "force"}, {"pulls": False}, {"pulls": False}),
    ],
)
def test_an_override_changes_what_it_names_and_nothing_else(changes, particle, wall):
    """The wall's gamma_n keeps its ratio to the particles' (4303/6085); zero is a value too."""
    case, published = a4(**changes), a4()
    assert case.particle_law == published.particle_law._replace(**particle)
    assert case.wall_law == published.wall_law._replace(**wall)


@pytest.mark.parametrize("kn", [1.5e2, 3e3, 1e4, 7.7e5])
def test_keep_ratios_keeps_kt_over_kn_and_every_restitution(kn):
    """kt ~ kn and gamma_n ~ sqrt(kn) leave the damping ratio gamma_n/(2 omega_0) alone.

    The restitution is a function of that ratio. The tolerance is rounding.
    """
    case, published = a4(law__kn=f"{kn} N/mm", law__keep_ratios=True), a4()
    assert case.particle_law.kn == case.wall_law.kn == 1e3 * kn
    for law in (case.particle_law, case.wall_law):
        assert law.kt / law.kn == pytest.approx(0.065, rel=1e-14)
    for pair, values in published.restitution().items():
        assert case.restitution()[pair] == pytest.approx(values, rel=1e-12)


def test_stiffer_alone_loses_less_in_a_contact():
    """Without keep_ratios gamma_n stays: e = exp(-pi gamma/(2 omega)) rises with kn."""
    soft, stiff = a4(law__kn="5e3 N/mm").restitution(), a4(law__kn="2e4 N/mm").restitution()
    for pair in soft:
        assert soft[pair]["one_contact"] < stiff[pair]["one_contact"]


@pytest.mark.parametrize("end", ["overlap", "force"])
def test_damping_from_restitution_gives_the_restitution_of_the_file(end):
    """Wood: 0.45 between particles, 0.53 at the wall, for a contact that ends either way."""
    case = a4(law__damping="restitution", law__contact_end=end)
    found = case.restitution()
    assert found["particle_particle"]["one_contact"] == pytest.approx(0.45, rel=1e-9)
    assert found["particle_wall"]["one_contact"] == pytest.approx(0.53, rel=1e-9)
    assert case.particle_law.gamma_n > a4().particle_law.gamma_n  # published: that of 0.80


def test_damping_from_restitution_goes_with_no_gamma():
    with pytest.raises(InputError, match="gamma_n goes with damping = 'published'"):
        a4(law__damping="restitution", law__gamma_n="5 1/s")


# The time step


def test_the_usual_time_step_is_taken_where_it_is_stable():
    case = a4()
    assert case.time_step == USUAL_TIME_STEP
    assert case.time_step_reason.startswith("the usual one; stable up to")
    assert "face to face" in case.time_step_reason


@pytest.mark.parametrize("kn", [9e4, 1e6, 3.3e7])
def test_stiffer_contacts_get_a_time_step_below_the_stable_one(kn):
    """The largest stable step goes with kn^-1/2 where the damping does too; 0.8 of it is taken.

    It is rounded down to two digits, of which the first is 1 at worst: between 0.72 and 0.8 of
    the limit. A step given just below the limit is taken, one just above it is refused.
    """
    stiffness = {"law__kn": f"{kn} N/mm", "law__keep_ratios": True}
    limit = _limit_at_published_kn() * math.sqrt(1e4 / kn)
    case = a4(**stiffness)
    assert limit < USUAL_TIME_STEP
    assert 0.72 * limit < case.time_step <= 0.8 * limit
    assert case.time_step_reason.startswith("0.8 of the largest stable; stable up to")
    given_step = a4(**stiffness, run__time_step=f"{0.999 * limit!r} s")
    assert given_step.time_step == 0.999 * limit
    assert given_step.time_step_reason.startswith("as given")
    with pytest.raises(InputError, match=r"time_step = .*not stable; at most .* leave it out"):
        a4(**stiffness, run__time_step=f"{1.001 * limit!r} s")


def _limit_at_published_kn() -> float:
    case = a4()
    return largest_stable_step(case.shapes, case.surface_density, case.particle_law, case.wall_law)[
        0
    ]


def test_two_squares_face_to_face_rock_against_each_other_fastest():
    """Eight springs kn, four at each end of the face, at +-c from its middle; both bodies move.

    Rocking against each other, with I = m (2c)^2/6, has the squared rate 2 (8 kn c^2)/I = 24 kn/m;
    pushing has 2 (8 kn)/m = 16 kn/m, and one square that rocks on a wall, 2 kn c^2/I = 3 kn/m.
    Undamped, the step is stable up to 2/omega. Tolerances: terms of order of the spheroradius over
    the side, and of kt over kn.
    """
    side, tiny = 20e-3, 1e-9
    square = [[0, 0], [side, 0], [side, side], [0, side]]
    shapes = ShapeSet("one", (shape_from_outline("square", square, tiny * side, "here"),))
    kn, surface_density = 1e6, 50.0
    law = LinearLaw(kn, tiny * kn, 0.4, 0.0, 0.0, False)
    limit, where = largest_stable_step(shapes, surface_density, law, law)
    mass = surface_density * side**2
    assert limit == pytest.approx(2.0 / math.sqrt(24.0 * kn / mass), rel=1e-8)
    assert where == "shape square face to face with a like one"


# What names a packing and a run

AFTER_OPENING: dict[str, Any] = {
    "law.mu_particle": 0.1,
    "law.mu_wall": 0.1,
    "law.kn": "5e3 N/mm",
    "law.kt": "500 N/mm",
    "law.gamma_n": "5 1/s",
    "law.gamma_n_wall": "5 1/s",
    "law.gamma_t": "5 1/s",
    "law.contact_end": "force",
    "law.damping": "restitution",
    "run.time_step": "4 us",
    "run.max_time": "5 s",
    "run.at_rest": 1e-3,
    "run.rest_time": "0.2 s",
    "run.opening_count": 7,
}
WHILE_FILLING: dict[str, Any] = {
    "silo.outlet": "149 mm",
    "silo.angle": "59 deg",
    "silo.width": "301 mm",
    "silo.height": "501 mm",
    "fill.level": "474 mm",
    "fill.settled": 1e-3,
    "fill.pour_with": "pymunk",
    "run.seed": 2,
}


@pytest.mark.parametrize("key", AFTER_OPENING)
def test_what_acts_after_the_opening_makes_another_run_of_the_same_packing(key):
    case = SiloCase.load("A4", {key: AFTER_OPENING[key]})
    assert packing_of(case) == packing_of(a4())
    assert run_digest(case) != run_digest(a4())


@pytest.mark.parametrize("key", WHILE_FILLING)
def test_what_acts_while_filling_makes_another_packing(key):
    case = SiloCase.load("A4", {key: WHILE_FILLING[key]})
    assert packing_of(case) != packing_of(a4())
    assert run_digest(case) != run_digest(a4())


def test_shapes_and_materials_count_by_their_numbers_not_by_their_files(tmp_path):
    """A copy of the shipped files under another name is the same case; a nudged one is not."""
    data = Path(__file__).parents[2] / "data"
    shapes = (data / "shapes" / "wood19.toml").read_text(encoding="utf-8")
    wood = (data / "materials" / "wood.toml").read_text(encoding="utf-8")
    copies = {"s.toml": shapes, "m.toml": wood, "s2.toml": shapes.replace("4.5", "4.4")}
    copies["m2.toml"] = wood.replace('"0.45 g/cm3"', '"0.46 g/cm3"')
    half = wood.replace('"0.45 g/cm3"', '"0.90 g/cm3"').replace('"120 mm"', '"60 mm"')
    copies["half as long.toml"] = half
    copies["named.toml"] = shapes.replace('name = "1"', 'name = "first"')
    for name, text in copies.items():
        (tmp_path / name).write_text(text, encoding="utf-8")

    def digests(**files: str) -> tuple[str, str]:
        case = a4(**{f"particles__{key}": str(tmp_path / name) for key, name in files.items()})
        return run_digest(case), packing_of(case)

    assert digests(shapes="s.toml", materials="m.toml") == (run_digest(a4()), packing_of(a4()))
    for other in ({"shapes": "s2.toml"}, {"materials": "m2.toml"}):
        assert not set(digests(**other)) & {run_digest(a4()), packing_of(a4())}
    # Lengths act on plates and pressures, names on results: of the run, on the same packing.
    for other in ({"materials": "half as long.toml"}, {"shapes": "named.toml"}):
        run_name, packing = digests(**other)
        assert run_name != run_digest(a4())
        assert packing == packing_of(a4())


def test_shipped_cases_are_named_as_they_were():
    """Folders of earlier versions are found again."""
    for name, digest in (("A4", "96c901ed5322"), ("beverloo", "e5082fd25b3f")):
        assert run_digest(SiloCase.load(name)) == digest


# The case as a file


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"law.damping": "restitution", "run.time_step": "2 us", "run.seed": 12},
        {"silo.angle": "0 deg", "run.time_step": None, "law.contact_end": "force"},
        {"name": "a name of its own, Zürich"},
    ],
)
def test_a_case_written_to_its_folder_is_the_same_run(tmp_path, changes):
    """to_toml and the copies of the files it names give back every number: resuming needs it."""
    case = SiloCase.load(write_case(tmp_path, changes))
    folder = tmp_path / "run"
    folder.mkdir()
    for name, text in {**case.files, "case.toml": case.to_toml()}.items():
        (folder / name).write_text(text, encoding="utf-8")
    again = SiloCase.load(folder / "case.toml")
    assert again.name == case.name
    assert again.identity()["settings"] == case.identity()["settings"]
    assert run_digest(again) == run_digest(case)
    assert packing_of(again) == packing_of(case)
    assert again.to_toml() == case.to_toml()


def sizes():
    return st.floats(min_value=0, exclude_min=True, allow_infinity=False)


def numbers():
    return st.floats(min_value=0, allow_infinity=False)


def lengths() -> st.SearchStrategy[float]:
    return st.floats(SMALLEST, LARGEST)


def any_settings() -> st.SearchStrategy[Settings]:
    """Settings of any values that their ranges allow, whether or not a silo can have them."""
    finite = st.floats(allow_nan=False, allow_infinity=False)
    words = st.text(st.characters(exclude_categories=["Cs"]), max_size=8)
    names = words.filter(_names_a_folder)
    tables = {
        "silo": {
            "preset": st.none() | words,
            "angle": st.none() | finite,
            "outlet": st.none() | lengths(),
            "outline": st.none() | st.lists(st.lists(finite, max_size=3), max_size=3),
            "outline_unit": words,
            "outlet_centre": st.none() | lengths(),
        },
        "particles": {"shapes": words, "materials": words, "material": words, "wall": words},
        "law": {
            "damping": st.sampled_from(["published", "restitution"]),
            "mu_wall": st.none() | st.floats(0, 1000),
            "kn": st.none() | sizes(),
            "gamma_t": st.none() | numbers(),
            "keep_ratios": st.booleans(),
        },
        "fill": {"level": lengths(), "settled": st.floats(0, 1, exclude_min=True)},
        "run": {"seed": st.integers(0, 2**63 - 1), "time_step": st.none() | sizes()},
        "output": {"frame_interval": sizes()},
    }
    documents = {name: st.fixed_dictionaries(table) for name, table in tables.items()}
    # Numbers in SI, as the classes hold them: no unit is read on this way in.
    built = st.fixed_dictionaries({"name": names, **documents})
    return built.map(_constructed)


def _names_a_folder(name: str) -> bool:
    try:
        return folder_name(name) == name
    except ValueError:
        return False


def _constructed(document: dict) -> Settings:
    fields = Settings.model_fields
    parts = {
        name: table if name == "name" else fields[name].annotation.model_construct(**table)
        for name, table in document.items()
    }
    return Settings.model_construct(**parts)


@given(any_settings())
@settings(deadline=None)  # the first one loads the table of units
def test_settings_survive_the_file_to_the_last_bit(given_settings):
    """Any text is escaped, any float written with all its digits and its unit."""
    document = tomllib.loads(to_toml(given_settings))
    assert document.pop("schema") == 1
    assert check_settings(document, "case.toml").model_dump() == given_settings.model_dump()
