"""The ways from measurements to a simulation that the docs go, gone."""

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from calibrating import calibrate
from pages import commands_of, files_of
from refusals import assert_refused
from small_damper import damper3d
from small_silo import silo2d

from granulab.contact.files.datafile import data_file

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/laboratory/overview.md").read_text()
OWN = (ROOT / "docs/start/own-case.md").read_text()
COMMANDS = {"calibrate": calibrate, "silo2d": silo2d, "damper3d": damper3d}


@pytest.fixture
def at_the_top(tmp_path, monkeypatch):
    """A folder with the project's docs and data, and the wood.toml that the page begins with."""
    for name in ("docs", "data"):
        (tmp_path / name).symlink_to(ROOT / name)
    (tmp_path / "wood.toml").write_text(re.search(r"```toml\n(.*?)```", PAGE, re.DOTALL)[1])
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_page_goes_from_measurements_to_a_simulation(at_the_top):
    """Every command but the simulation itself; its dry run has all that it needs.

    What went in comes out within three of its sigmas (1 in 370 by chance, and the tables do not
    change): the silo paper's means, density of sec. 3.5, friction of sec. 3.1, gamma_t of sec. 3.4,
    and the restitution and modulus of docs/examples/wood/made.py.
    """
    said = ""
    for program, *words in commands_of(PAGE):
        if program == "silo2d" and "--dry-run" not in words:
            continue
        result = COMMANDS[program](*words)
        assert result.code == 0, (words, result.err)
        said = result.out
    assert "A4" in said
    assert "still needs" not in calibrate("report", "wood.toml").out
    found = tomllib.loads((at_the_top / "wood.toml").read_text())
    pair, wall = found["pair"]["wood-wood"], found["pair"]["wood-methacrylate"]
    for entry, truth in (
        (found["material"]["wood"]["density"], 0.45),
        (pair["friction"], 0.37),
        (wall["friction"], 0.443),
        (wall["restitution"], 0.53),
        (pair["linear"]["kn"], 14520),
        (pair["linear"]["gamma_t"], 3.0),
    ):
        value, sigma = (float(str(entry[key]).split()[0]) for key in ("value", "sigma"))
        assert abs(value - truth) < 3 * sigma


def test_a_run_of_ones_own_begins_in_an_empty_folder(tmp_path, monkeypatch):
    """Files and commands as the page has them, in its order; of the discharge the first 20 ms.

    The film is the shipped one, which is rendered as the page says (test_media_samples).
    """
    monkeypatch.chdir(tmp_path)
    Path("drop.mp4").write_bytes(data_file("media", "drop").read_bytes())
    for name, text in files_of(OWN).items():
        Path(name).write_text(text)
    for program, *words in commands_of(OWN):
        if words[0] == "run" and "steel.toml" in words:
            assert_refused(COMMANDS[program](*words), "[material.beech] density [g/cm3], length")
            continue
        if words == ["run", "bench.toml"]:
            words += ["--max-time", "20 ms", "--no-figures"]
        result = COMMANDS[program](*words)
        assert result.code == 0, (words, result.err)
        if words[0] == "report":
            assert "still needs" not in result.out
        if "20 ms" in words:
            assert "bench, seed 1: stopped at the time limit" in result.out


def test_the_tables_are_those_of_their_recipe(tmp_path):
    """To the last digits printed, where another machine's arithmetic may round the other way."""
    folder = ROOT / "docs" / "examples" / "wood"
    subprocess.run([sys.executable, folder / "made.py", tmp_path], check=True)
    made = sorted(path.name for path in tmp_path.glob("*.csv"))
    assert made == sorted(path.name for path in folder.glob("*.csv"))
    for name in made:
        one, other = (np.loadtxt(at / name, delimiter=",", skiprows=1) for at in (tmp_path, folder))
        np.testing.assert_allclose(one, other, rtol=2e-5)


def test_every_command_stands_on_the_page():
    from calibration.commands.main import app

    for name in app.list_commands(None):
        assert f"`calibrate {name}`" in PAGE or f"`{name}`" in PAGE, name
