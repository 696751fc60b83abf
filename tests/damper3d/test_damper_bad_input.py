"""What damper3d cannot run: one line on stderr, exit code 2, no traceback, nothing written."""

from typing import Any

import pytest
from refusals import assert_refused
from small_damper import damper3d, write_damper
from small_silo import DRY, contents

from granulab.contact.files.datafile import data_file


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "thesiss"], ["'thesiss'", "did you mean 'thesis'", "known: thesis, damper"]),
        (["run", "damperr"], ["did you mean 'damper'"]),
        (["run", "mine"], ["did you mean 'mine.toml'"]),
        (["run", ""], ["no such preset or file"]),
        (["run", "example"], ["unknown key 'silo'"]),
        (["show", "acrylik"], ["'acrylik'", "did you mean 'acrylic'"]),
        (["run", "--gamma", "0"], ["[motion] gamma = '0'", "greater than 0"]),
        (["run", "--gamma", "nan"], ["gamma = 'nan'", "not a quantity"]),
        (["run", "--frequency=-40"], ["frequency = '-40'", "greater than 0"]),
        (["run", "--frequency", "40 mm"], ["frequency = '40 mm'", "unit is wrong", "'40 Hz'"]),
        (["run", "--frequency", "forty"], ["frequency = 'forty'", "such as '40 Hz'"]),
        (["run", "--frequency", "20000"], ["less than a time step of 1e-06 s", "fewer samples"]),
        (["run", "--orientation", "up"], ["'up'", "'vertical', 'horizontal' or 'none'"]),
        (["run", "--particles", "sphere"], ["[particles] shape = 'sphere'", "size is missing"]),
        (["run", "--particles", "sphere:5"], ["shape = 'sphere:5'", "such as 'sphere:5mm'"]),
        (["run", "--particles", "prolate:0.5"], ["'prolate:0.5'", "aspect ratio", "from 1 to 10"]),
        (["run", "--particles", "toroid"], ["'toroid:'", "hole ratio", "not a number"]),
        (["run", "--particles", "toroid:0.9"], ["'toroid:0.9'", "from 0 to 0.8"]),
        (["run", "--particles", "shpere:5mm"], ["'shpere:5mm'", "did you mean 'sphere'"]),
        (["run", "--equal-volume-radius", "3.8 mm"], ["equal_volume_radius", "leave one of them"]),
        (["run", "--count", "0"], ["[particles] count = 0", "greater than or equal to 1"]),
        (["run", "--count", "many"], ["count = 'many'", "whole number"]),
        (["run", "--particles", "sphere:1um"], ["usual fill ratio", "at most 10000000"]),
        (["run", "--diameter", "40 m"], ["usual fill ratio", "at most 10000000"]),
        (["run", "--count", "600"], ["count = 600", "0.64", "at most 491 fit"]),
        (["run", "--diameter", "4 mm"], ["4 mm at the narrowest", "smaller than a particle, 5 mm"]),
        (["run", "--height", "4.9mm"], ["4.9 mm at the narrowest", "smaller than a particle"]),
        (["run", "--material", "acrylik"], ["acrylik", "did you mean 'acrylic'"]),
        (["run", "--material", "steel"], ["steel.toml", "restitution is missing", "--restitution"]),
        (["run", "--material", "glass"], ["no pair 'glass-glass'", "--friction"]),
        (["run", "--material", "aluminium"], ["aluminium.toml", "aluminium-aluminium"]),
        (["run", "--restitution", "1.1"], ["restitution = '1.1'", "less than or equal to 1"]),
        (["run", "--restitution-wall", "0"], ["restitution_wall = '0'", "greater than 0"]),
        (["run", "--friction=-0.1"], ["friction = '-0.1'", "greater than or equal to 0"]),
        (["run", "--cycles", "3"], ["discard = 3", "below cycles = 3"]),
        (["run", "--steady", "--max-cycles", "2"], ["discard = 3", "below max_cycles = 2"]),
        (["run", "--samples", "4"], ["samples = 4", "greater than or equal to 8"]),
        (["run", "--frames", "30"], ["frames = 30", "divide samples = 100", "give 25"]),
        (["run", "--time-step", "9 us"], ["time_step = 9e-06 s", "Rayleigh limit of 8.33e-06 s"]),
        (["run", "--time-step", "1e-300 s"], ["1e+12 steps", "nobody can wait for"]),
        (["run", "--seed", "one"], ["[run] seed = 'one'", "whole number"]),
        (["run", "--gama", "3"], ["'--gama'", "'--gamma'"]),
        (["run", "--resume", "nowhere"], ["nowhere", "not a run folder"]),
        (["run", "thesis", "--resume", "nowhere"], ["leave other options out"]),
        (["run", "--resume", "nowhere", "--gamma", "3"], ["leave other options out"]),
        (["rum"], ["'rum'", "'run'"]),
    ],
)
def test_a_bad_command_line(arguments, words, tmp_path, monkeypatch):
    """Nothing is written; mine.toml lies in the folder."""
    monkeypatch.chdir(tmp_path)
    write_damper(tmp_path, name="mine")
    assert_refused(damper3d(*arguments), *words)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.toml"]


BOX: dict[str, Any] = {"enclosure.shape": "box", "enclosure.diameter": None}
BAD_CASES: list[tuple[dict[str, Any], list[str]]] = [
    # names
    ({"enclosure.diametre": "5 cm"}, ["[enclosure] unknown key 'diametre'", "mean 'diameter'?"]),
    ({"enclosur.diameter": "5 cm"}, ["unknown key 'enclosur'", "did you mean 'enclosure'?"]),
    ({"particles.material": "acryl"}, ["no material 'acryl'", "did you mean 'acrylic'?"]),
    ({"enclosure.material": "steel"}, ["no material 'steel'", "known: acrylic"]),
    ({"name": "up/down"}, ["name = 'up/down'", "run folder"]),
    ({"motion": 4, "motion.frequency": None, "motion.gamma": None}, ["[motion] expected a table"]),
    # units
    ({"motion.ramp": 1e10}, ["[motion] ramp = 1e+10 cycles", "would not be reached in"]),
    ({"law.youngs_modulus": "1 Pa"}, ["youngs_modulus is too low", "own weight"]),
    ({"law.friction": 1e12}, ["friction", "less than or equal to 1000"]),
    ({"name": "n" * 300}, ["300 bytes", "at most 200"]),
    ({"enclosure.diameter": 40}, ["[enclosure] diameter = 40", "unit is missing", "'475 mm'"]),
    ({"enclosure.height": "40 s"}, ["height = '40 s'", "unit is wrong"]),
    ({"law.density": "1.19 g/cm2"}, ["density = '1.19 g/cm2'", "unit is wrong"]),
    ({"law.youngs_modulus": "3.3"}, ["youngs_modulus = '3.3'", "unit is missing", "GPa"]),
    ({"motion.gamma": "20 m/s2"}, ["gamma = '20 m/s2'", "unit is wrong"]),
    # ranges
    ({"motion.frequency": float("nan")}, ["[motion] frequency = nan", "not a finite number"]),
    ({"motion.gamma": float("inf")}, ["[motion] gamma = inf", "not a finite number"]),
    ({"motion.gamma": -3}, ["[motion] gamma = -3", "greater than 0"]),
    ({"motion.frequency": 1e-200}, ["steps", "higher frequency"]),
    ({"motion.ramp": -1}, ["ramp = -1", "greater than or equal to 0"]),
    ({"motion.direction": [True, False, False]}, ["direction = [true, false, false]", "number"]),
    ({"run.cycles": True}, ["cycles = true", "give a number"]),
    ({"enclosure.diameter": "1e300 m"}, ["diameter = 1e+300 m", "check the unit"]),
    ({"law.density": "1e80 kg/m3"}, ["too large or too small to calculate with", "density"]),
    ({"fill.settle_time": "0 s"}, ["settle_time", "greater than 0"]),
    ({"fill.friction": -0.1}, ["[fill] friction = -0.1", "greater than or equal to 0"]),
    ({"fill.friction": "none"}, ["friction = 'none'"]),
    ({"fill.settle_time": "1 Gyr"}, ["[fill] settle_time", "a shorter one"]),
    ({"run.cycles": 0}, ["cycles = 0", "greater than or equal to 1"]),
    ({"run.cycles": 2.5}, ["cycles = 2.5", "must be a whole number"]),
    ({"particles.count": 1e9}, ["count = 1000000000.0", "without a point, exponent or unit"]),
    ({"run.discard": 4}, ["discard = 4", "below cycles = 4"]),
    ({"output.frames": 7}, ["frames = 7", "divide samples = 50", "give 5,"]),
    ({"output.keep": "some"}, ["keep = 'some'", "'all' or 'summary'"]),
    # vectors
    ({"motion.direction": [0, 0, 0]}, ["[motion] direction = [0.0, 0.0, 0.0]", "no direction"]),
    ({"motion.direction": [0, 1]}, ["direction = [0, 1]", "at least 3"]),
    ({"motion.gravity": [0, 0, float("nan")]}, ["[motion] gravity", "must be a finite number"]),
    ({"motion.gravity": "down"}, ["gravity = 'down'", "must be a list"]),
    (
        {"motion.gravity": [0, 0, 1], "motion.orientation": "none"},
        ["gravity is given", "leave one of them out"],
    ),
    (
        {"motion.gravity": [0, 0, -1], "motion.orientation": "horizontal"},
        ["orientation = 'horizontal'", "the motion is vertical", "leave orientation out"],
    ),
    (
        {"motion.direction": [1, 0, 0], "motion.orientation": "horizontal"},
        ["orientation = 'horizontal'", "the motion is vertical"],
    ),
    # enclosures
    ({"enclosure.shape": "cone"}, ["shape = 'cone'", "'cylinder' or 'box'"]),
    ({"enclosure.shape": "box"}, ["diameter goes with shape = 'cylinder'"]),
    (BOX, ["[enclosure] width is missing"]),
    ({"enclosure.width": "2 cm"}, ["width and depth go with shape = 'box'"]),
    ({**BOX, "enclosure.width": "2 cm", "enclosure.depth": "4 mm"}, ["4 mm at the narrowest"]),
    ({"particles.count": 200}, ["count = 200", "above random close packing", "at most 76 fit"]),
]


@pytest.mark.parametrize(("changes", "words"), BAD_CASES)
def test_a_bad_case_file(changes, words, tmp_path):
    """The line names the file, the section and key, the value, and what would do."""
    case = write_damper(tmp_path, changes)
    before = contents(tmp_path)
    assert_refused(damper3d("run", case, "-o", tmp_path / "runs", "--quiet"), *words)
    assert contents(tmp_path) == before
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize(
    ("cut", "words"),
    [
        ("[pair.acrylic-acrylic]", ["no pair 'acrylic-acrylic'"]),
        ("restitution", ["[pair.acrylic-acrylic] restitution is missing"]),
        ("poisson", ["[material.acrylic] poisson is missing"]),
        ("youngs_modulus", ["[material.acrylic] youngs_modulus is missing"]),
        ("density", ["[material.acrylic] density is missing"]),
        ("yield_strength", ["'acrylic' has no yield_strength"]),
    ],
)
def test_a_materials_file_without_what_is_needed(cut, words, tmp_path):
    """Acrylic's file without a table, or without the line of a key."""
    acrylic = data_file("materials", "acrylic")
    assert acrylic is not None
    lines = acrylic.read_text(encoding="utf-8").splitlines()
    if cut.startswith("["):
        lines = lines[: lines.index(cut)]
    lines = [line for line in lines if not line.startswith(f"{cut} = ")]
    (tmp_path / "mine.toml").write_text("\n".join(lines), encoding="utf-8")
    changes = {"particles.materials": "mine.toml", "law.youngs_modulus": None}
    case = write_damper(tmp_path, changes | {"law.yielding": cut == "yield_strength"})
    step = ["--time-step", "1 us"]
    assert_refused(damper3d("run", case, "--dry-run", *step), "mine.toml", *words)


def test_stiffness_of_prisms_says_no_modulus(tmp_path):
    """kn goes with shapes and load: the silo, which knows them, says which E and nu it stands for.

    Nothing is said of it where the file has E and nu.
    """
    text = data_file("materials", "acrylic").read_text(encoding="utf-8")
    prisms = f'{text}\n[pair.acrylic-acrylic.linear]\nkn = "1e4 N/mm"\nkt = "9e3 N/mm"\n'
    case = write_damper(tmp_path, {"particles.materials": "mine.toml", "law.youngs_modulus": None})
    (tmp_path / "mine.toml").write_text(prisms, encoding="utf-8")
    assert damper3d("run", case, *DRY, "--time-step", "1 us").code == 0
    lines = [line for line in prisms.splitlines() if not line.startswith(("youngs", "poisson"))]
    (tmp_path / "mine.toml").write_text("\n".join(lines), encoding="utf-8")
    words = "[material.acrylic] youngs_modulus [GPa], poisson", "of prisms", "silo2d elastic CASE"
    assert_refused(damper3d("run", case, *DRY), "mine.toml", *words)


def test_without_a_yield_strength_the_yield_velocity_is_not_known(tmp_path):
    """It is only reported, so that a case without it runs."""
    acrylic = data_file("materials", "acrylic")
    assert acrylic is not None
    lines = acrylic.read_text(encoding="utf-8").splitlines()
    kept = [line for line in lines if not line.startswith("yield_strength")]
    (tmp_path / "mine.toml").write_text("\n".join(kept), encoding="utf-8")
    plan = damper3d(
        "run", write_damper(tmp_path, {"particles.materials": "mine.toml"}), *DRY, "--json"
    ).json
    assert plan["yield_velocity_m_s"] == {"particle_particle": None, "particle_wall": None}


def test_a_single_particle_may_fill_its_enclosure(tmp_path):
    """A ball in a tight cylinder has a fill ratio of 2/3, above that of random packings."""
    changes = {"enclosure.diameter": "5.01 mm", "enclosure.height": "5.01 mm"}
    one = write_damper(tmp_path, {**changes, "particles.count": 1})
    assert damper3d("run", one, *DRY, "--json").json["n_particles"] == 1
    two = write_damper(tmp_path, {**changes, "particles.count": 2})
    assert_refused(damper3d("run", two, "--dry-run"), "at most 1 fit")


def test_init_overwrites_nothing(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("mine", encoding="utf-8")
    assert_refused(damper3d("init", path), str(path), "exists")
    assert_refused(damper3d("init", tmp_path / "none" / "mine.toml"), "cannot be written")
    assert path.read_text(encoding="utf-8") == "mine"
