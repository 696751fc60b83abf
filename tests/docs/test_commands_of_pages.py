"""Commands on any page, and of its pictures: each is one that the program takes."""

import csv
import importlib
import re
import shlex
from pathlib import Path

import click
import pytest
from pages import commands_of
from picture import PICTURES, recipes

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted(ROOT.glob("docs/**/*.md"))]
PROGRAMS = {
    "silo2d": "silo2d.commands.main",
    "damper3d": "damper3d.commands.main",
    "calibrate": "calibration.commands.main",
    "granulab": "granulab.studio.main",
}


def commands():
    """The page and words of each command; of one in which something is left out, none."""
    for page in PAGES:
        for words in commands_of(page.read_text(encoding="utf-8")):
            if not re.search(r"\.\.\.|\[|<", " ".join(words)):
                yield page.relative_to(ROOT), words
    for name, recipe in recipes().items():
        for command in recipe.get("run", ()):
            if command.split()[0] in PROGRAMS:
                yield name, shlex.split(command)


def test_it_is_known_of_every_command_of_a_page_how_it_ends_and_none_failed():
    """By `make commands`, or `python tests/docs/every_command.py --only PAGE --write FILE`."""
    with (ROOT / "docs/results/commands.csv").open(encoding="utf-8", newline="") as file:
        ends = {(row["page"], row["command"]): row["end"] for row in csv.DictReader(file)}
    shown = {
        (str(page), shlex.join(words)) for page, words in commands() if (ROOT / page).is_file()
    }
    assert sorted(shown - ends.keys()) == []
    assert [key for key in shown if ends[key].startswith("failed")] == []


def test_every_picture_has_its_recipe_and_a_page_that_shows_it():
    there = {path.stem for path in PICTURES.iterdir() if path.suffix in (".png", ".svg")}
    assert recipes().keys() == there
    assert all(("run" in recipe) != ("shown" in recipe) for recipe in recipes().values())
    text = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    assert [name for name in there if f"pictures/{name}." not in text] == []


@pytest.mark.parametrize(("page", "words"), list(commands()), ids=lambda value: str(value)[:80])
def test_a_shown_command_is_one_that_there_is(page, words):
    """A reader's files are not there: click says so of the value, not of the option."""
    program, *rest = words
    name, command = program, importlib.import_module(PROGRAMS[program]).app
    try:
        while isinstance(command, click.Group) and rest:
            context = command.make_context(name, [], resilient_parsing=True)
            name, command, rest = command.resolve_command(context, rest)
        command.make_context(name, rest)
    except click.exceptions.Exit:
        pass  # --help, --version
    except click.BadParameter as error:
        if isinstance(error, click.MissingParameter) or "exist" not in error.format_message():
            raise AssertionError(f"{page}: {shlex.join(words)}: {error.format_message()}") from None
    except click.UsageError as error:
        raise AssertionError(f"{page}: {shlex.join(words)}: {error.format_message()}") from None
