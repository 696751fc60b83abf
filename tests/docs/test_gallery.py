"""The gallery of examples: each script has its parts, and its commands print what stands there.

The build of the site runs the scripts. In a docstring "$" stands before a command, and the lines
below it are among those that it prints, as on the pages for the first ten minutes.
"""

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from pages import plain_environment
from test_pages_of_first_steps import lacking

from granulab.contact.files.datafile import data_root

pytestmark = pytest.mark.docs

ROOT = Path(__file__).parents[2]
GALLERY = ROOT / "docs" / "examples" / "gallery"
SCRIPTS = sorted(GALLERY.glob("*/plot_*.py"))
LONGEST = 70  # lines
NAMES = [f"{path.parent.name}/{path.stem}" for path in SCRIPTS]


def tree_of(path):
    return ast.parse(path.read_text(encoding="utf-8"))


def commands(docstring):
    """Each command of the docstring, and the lines that it prints."""
    _, _, literal = docstring.partition("::\n\n")
    whole = literal.replace("\\\n", " ")
    for part in re.split(r"^    \$ ", whole, flags=re.M)[1:]:
        command, _, printed = part.partition("\n")
        yield command, printed.splitlines()


def test_a_gallery_has_each_of_its_parts():
    rooms = {path.parent.name for path in SCRIPTS}
    assert rooms == {"silo", "damper", "laboratory", "contacts"}
    assert all((GALLERY / room / "GALLERY_HEADER.rst").is_file() for room in rooms)


@pytest.mark.parametrize("path", SCRIPTS, ids=NAMES)
def test_a_script_has_title_command_figure_and_assertion(path):
    tree = tree_of(path)
    title, rule, *_ = ast.get_docstring(tree).splitlines()
    assert rule == "=" * len(title)
    assert list(commands(ast.get_docstring(tree)))
    assert any(isinstance(node, ast.Assert) for node in tree.body)
    labelled = ast.unparse(tree)
    assert "xlabel" in labelled
    assert "ylabel" in labelled or "barh" in labelled
    assert len(path.read_text(encoding="utf-8").splitlines()) <= LONGEST


@pytest.mark.parametrize("path", SCRIPTS, ids=NAMES)
def test_commands_of_a_script_print_what_stands_there(path, tmp_path):
    docstring = ast.get_docstring(tree_of(path))
    environment = os.environ | plain_environment() | {"MPLBACKEND": "Agg"}

    def run(command):
        ended = subprocess.run(
            command, shell=True, cwd=tmp_path, env=environment, capture_output=True,
            text=True, check=False,
        )  # fmt: skip
        assert ended.returncode == 0, f"{command}\n{ended.stdout}{ended.stderr}"
        return ended.stdout

    if "that this script writes" in docstring:
        run(f"{sys.executable} {path}")
    for command, shown in commands(docstring):
        given = command.replace(" data/", f" {data_root()}/").replace(" docs/", f" {ROOT}/docs/")
        output = run(given)
        lost = lacking(shown, output)
        assert lost is None, f"{command}\nlacks: {lost}\n{output}"
