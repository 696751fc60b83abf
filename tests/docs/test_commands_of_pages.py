"""Commands on any page, and of its pictures: each is one that the program takes.

What a page shows of their output is printed by one that is run (test_pages_of_first_steps.py), or
stands in a committed result.
"""

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
# Ends of a command that every_command.py does not run to its end.
NOT_WHOLE = ("longer", "planned", "left out")
COST = re.compile(r"#.*(?:\d (?:s|min|h) of CPU|Ctrl-C ends it)")
SHOWN = re.compile(rf" {{4,}}(?:{'|'.join(PROGRAMS)}|dask|export|make|pip|python) ")
TEXT = re.compile(r"^([^\n]*)\n+```text\n(.*?)```", re.MULTILINE | re.DOTALL)


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


def ends():
    """How each command ended in `make commands`, by page and command."""
    with (ROOT / "docs/results/commands.csv").open(encoding="utf-8", newline="") as file:
        return {(row["page"], row["command"]): row["end"] for row in csv.DictReader(file)}


def lines_of(page):
    """The lines of a page, those that a backslash ends with the next one."""
    return re.sub(r"\s*\\\n\s*", " ", page.read_text(encoding="utf-8")).split("\n")


def test_it_is_known_of_every_command_of_a_page_how_it_ends_and_none_failed():
    """By `make commands`, or `python tests/docs/every_command.py --only PAGE --write FILE`."""
    end = ends()
    shown = {
        (str(page), shlex.join(words)) for page, words in commands() if (ROOT / page).is_file()
    }
    assert sorted(shown - end.keys()) == []
    assert [key for key in shown if end[key].startswith("failed")] == []


def test_a_command_that_takes_long_says_how_long():
    """Behind it, `# 20 min of CPU`; or its --dry-run, which says so, is on the page; or it serves.

    What stands behind "$" is run by test_pages_of_first_steps.py, however long it takes.
    """
    end, unmarked = ends(), []
    for page in PAGES:
        lines = lines_of(page)
        for line in (line for line in lines if line.startswith("    ")):
            for words in commands_of(line):
                long = end.get((str(page.relative_to(ROOT)), shlex.join(words))) in NOT_WHOLE
                planned = any(f"{shlex.join(words[:3])} --dry-run" in other for other in lines)
                if long and not planned and not COST.search(line):
                    unmarked.append(f"{page.name}: {line.strip()}")
    assert unmarked == []


def test_no_output_stands_behind_a_command_that_is_not_run():
    """Indented, a command has commands beside it; what they print is behind one with "$"."""
    beside = []
    for page in PAGES:
        for block in re.split(r"\n(?! {4}|$)", "\n".join(lines_of(page)), flags=re.MULTILINE):
            lines = [line for line in block.split("\n") if line.startswith("    ")]
            if any(map(commands_of, lines)):
                beside += [f"{page.name}: {line}" for line in lines if not SHOWN.match(line)]
    assert beside == []


def test_output_that_is_not_run_stands_in_a_committed_result():
    """A block of text with numbers is a file, behind "`NAME`:", or behind "From [NAME](RESULT)".

    Then it holds lines of that result, in their order; "..." stands for what is left out.
    """
    for page in PAGES:
        for before, block in TEXT.findall(page.read_text(encoding="utf-8")):
            if re.search(r"`[^`]+`:$", before) or not re.search(r"\d", block):
                continue
            result = re.search(r"From \[[^]]+\]\(([^)]+)\)", before)
            assert result, f"{page.name}: of what run? {before}"
            there = iter((page.parent / result.group(1)).read_text(encoding="utf-8").splitlines())
            for line in block.splitlines():
                head, cut, _ = line.partition("...")
                found = any(one.startswith(head) if cut else one == line for one in there)
                assert found or not head.strip(), f"{page.name}: {line}"


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
