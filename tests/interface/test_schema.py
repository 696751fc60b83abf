"""One schema a simulator: options, commented case, key tables and study keys follow from it."""

import importlib
import math
import re
import runpy
import tomllib
from pathlib import Path

import click
import pytest
from refusals import assert_refused
from small_damper import damper3d
from small_silo import DRY, silo2d

from damper3d.case import settings as damper
from granulab.contact.files.casefile import sections
from granulab.contact.files.datafile import data_file, data_root
from granulab.contact.files.keys import Keys
from granulab.contact.files.reference import keys_of
from granulab.errors import InputError
from silo2d.case import settings as silo
from silo2d.case.case import SiloCase

BOTH = pytest.mark.parametrize("simulator", [silo, damper], ids=["silo", "damper"])
ROOT = Path(__file__).parents[2]
PAGES = ["README.md", *sorted(f"{path.relative_to(ROOT)}" for path in ROOT.glob("docs/**/*.md"))]
# Flags that change a key of the case; scripts rely on them (interfaces).
OPTIONS = {
    silo: "angle outlet shapes scale spheroradius materials damping contact-end mu-particle "
    "mu-wall kn kt gamma-n gamma-n-wall gamma-t keep-ratios disorder fill-level pour-with seed "
    "engine time-step door-speed max-time wall-interval iterations pymunk-time-step cohesion "
    "mu-plates plates-ratio feed-rate refill vibration-amplitude vibration-frequency",
    damper: "diameter height particles equal-volume-radius sub-spheres tolerance mesh-unit count "
    "orientation frequency gamma ramp friction friction-wall restitution restitution-wall "
    "contact-treatment tangential contact-end wall-curvature yielding youngs-modulus density seed "
    "cycles discard steady max-cycles time-step samples frames keep fill-ratio host-mass "
    "host-frequency host-damping force base-displacement base-acceleration start-displacement "
    "start-velocity",
}


def test_generated_files_are_up_to_date():
    """The key tables, the shipped examples, the README's map, the contributor's list of modules."""
    wanted = runpy.run_path(str(ROOT / "docs" / "generate.py"))["generated"]()
    stale = [path.name for path, text in wanted.items() if path.read_text("utf-8") != text]
    assert not stale, "run: python docs/generate.py"


@pytest.mark.parametrize("page", PAGES)
def test_pages_name_files_that_exist(page):
    """Paths with a slash between backticks, and links; but those of runs, and those to write."""
    text = re.sub(r"Write `.*?`:", "", (ROOT / page).read_text("utf-8"))
    text = re.sub(r"(?s)<!-- (?:map|modules).*?<!-- end of", "", text)  # tested above
    named = re.findall(r"`([\w./]+/[\w.*]*)`", text)
    tops = {path.name for path in ROOT.iterdir()} - {"runs"}
    named = [name for name in named if name.split("/")[0] in tops and "NAME" not in name]
    linked = re.findall(r"\]\(([\w./-]+)(?:#[\w-]+)?\)", text)
    folder = (ROOT / page).parent
    missing = [name for name in named if not list(ROOT.glob(name.rstrip("/")))]
    assert missing + [name for name in linked if not (folder / name).exists()] == []


@pytest.mark.parametrize(
    ("program", "start", "use"),
    [
        (silo2d, ["--materials"], ["run", "A4", "--materials"]),
        (silo2d, ["--shapes"], ["run", "A4", "--shapes"]),
        (silo2d, ["--from", "wood"], ["run", "A4", "--materials"]),
        (silo2d, ["--from", "pentagons"], ["run", "beverloo", "--shapes"]),
        (silo2d, ["--from", "B2"], ["run"]),
        (damper3d, ["--materials"], ["run", "--material"]),
        (damper3d, ["--from", "steel"], ["run", "--restitution", "0.7", "--material"]),
        (damper3d, ["--from", "damper"], ["run"]),
    ],
)
def test_init_begins_files_that_a_run_takes(program, start, use, tmp_path):
    file = tmp_path / "mine.toml"
    written = program("init", file, *start)
    assert (written.code, written.err) == (0, "")
    assert str(file) in written.out
    done = program(*use, file, *DRY)
    assert done.code == 0, done.err


def test_init_copies_a_file_that_is_there_and_of_the_kind(tmp_path):
    file, copy = tmp_path / "mine.toml", tmp_path / "copy.toml"
    assert silo2d("init", file, "--from", "wood").code == 0
    assert silo2d("init", copy, "--from", file).code == 0
    assert copy.read_text("utf-8") == data_file("materials", "wood").read_text("utf-8")
    for words in (["--from", "wod"], ["--from", "thesis"], ["--from", "wood", "--shapes"]):
        assert_refused(silo2d("init", tmp_path / "new.toml", *words), f"--from {words[1]}")
    preset = tmp_path / "b2.toml"
    silo2d("init", preset, "--from", "B2")
    mine, b2 = SiloCase.load(preset), SiloCase.load("B2")
    assert (mine.outline.polygon == b2.outline.polygon).all()


@BOTH
def test_the_commented_case_is_the_defaults(simulator, tmp_path):
    """Read again: the default settings, but for the name and the sizes that init spells out."""
    path = tmp_path / "mine.toml"
    path.write_text(simulator.commented_case(), encoding="utf-8")
    read = simulator.check_settings(simulator.read_settings(path), "mine")
    sizes = {"silo": {"angle": "60 deg", "outlet": "150 mm", "width": "300 mm",
                      "height": "500 mm"}}  # fmt: skip
    sizes = sizes if simulator is silo else {"enclosure": {"diameter": "40 mm"}}
    assert read == simulator.check_settings({"name": read.name, **sizes}, "defaults")


@BOTH
def test_every_key_stands_in_the_commented_case_with_an_example_that_is_taken(simulator):
    """Each line of the case that is a comment would be taken if it were none."""
    text = simulator.commented_case()
    every = tomllib.loads(re.sub(r"(?m)^# (?=\w+ = )", "", text))
    for key in keys_of(simulator.Settings):
        assert key.meaning, key.name
        value = every[key.section][key.name]
        model = sections(simulator.Settings)[key.section]
        default = model.model_fields[key.name].default
        read = getattr(model.model_validate({key.name: value}), key.name)
        if default is None:
            assert read is not None
        else:
            assert read == default, f"the example of {key.name} is not its default"


@BOTH
def test_options_are_those_that_scripts_rely_on(simulator):
    flags = [key.option for key in keys_of(simulator.Settings) if key.option]
    assert sorted(flags) == sorted(f"--{name}" for name in OPTIONS[simulator].split())


@pytest.mark.parametrize("name", ["silo2d", "damper3d"])
def test_no_command_has_an_option_twice(name):
    """A key's flag is no other option of a command; each has a word of help."""
    app = importlib.import_module(f"{name}.commands.main").app
    for command in app.commands.values():
        with click.Context(command) as context:
            options = [one for one in command.get_params(context) if isinstance(one, click.Option)]
        flags = [flag for option in options for flag in option.opts]
        assert len(flags) == len(set(flags)), command.name
        assert all(option.help for option in options), command.name


@BOTH
def test_every_option_reaches_its_key(simulator):
    """What is typed for an option, here its example, is what the case has for the key."""
    command = silo2d if simulator is silo else damper3d
    for key in keys_of(simulator.Settings):
        if key.option and key.kind != "boolean" and key.section != "particles":
            result = command(*("run", *["A4"][: simulator is silo]), "--dry-run", key.option, "-x")
            assert result.code == 2
            assert key.name in result.err or key.option in result.err


@pytest.mark.parametrize(("study", "simulator"), [("friction", silo), ("damper", damper)])
def test_the_commented_studies_name_keys_of_the_schema(study, simulator):
    """Also those that are comments, with values that the keys take."""
    text = (data_root() / "studies" / f"{study}.toml").read_text("utf-8")
    written = re.findall(r'(?m)^(?:# )?"?((?:\w+\.\w+)(?:, \w+\.\w+)*)"? = (.*)$', text)
    assert len(written) > 4
    keys = Keys(simulator.Settings)
    for names, value in written:
        value = tomllib.loads(f"value = {value}")["value"]
        values = value if isinstance(value, list) else [value]
        if isinstance(value, dict):
            values = [value[k] for k in ("start", "stop", "mean", "min") if k in value]
        for name in names.split(", "):
            for one in values:
                keys.read(study, name, one)


def test_a_study_takes_truth_and_numbers_where_a_key_does():
    keys = Keys(silo.Settings)
    assert keys.read("study", "fill.friction", True) is True
    assert keys.read("study", "disorder.friction", "10 %") == 0.1
    assert keys.read("study", "law.damping", "restitution") == "restitution"
    with pytest.raises(InputError, match=r"law\.mu_wall = True"):
        keys.read("study", "law.mu_wall", True)


def test_a_study_shows_a_key_in_the_unit_that_a_case_file_has():
    """That of its example; a pure number may have a plain one, such as Hz."""
    silos, dampers = Keys(silo.Settings), Keys(damper.Settings)
    assert silos.shown("silo.outlet") == ("mm", 1e-3)
    assert silos.shown("law.kn") == ("N/mm", 1e3)
    assert silos.shown("silo.angle")[0] == "deg"
    assert silos.shown("silo.angle")[1] == pytest.approx(math.pi / 180)
    assert silos.shown("law.mu_wall") == silos.shown("law.damping") == ("", 1.0)
    assert dampers.shown("motion.frequency") == ("Hz", 1.0)
    assert dampers.shown("law.youngs_modulus") == ("GPa", 1e9)
