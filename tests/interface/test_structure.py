"""Sizes of rooms and functions, and the first words of docstrings, as the house has them."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("granulab", "silo2d", "damper3d", "calibration")
MOST_MODULES = 12  # in a folder
MOST_LINES = 60  # of a function
QUESTIONS = ("What", "Which", "How", "Whether", "Who", "Where", "When", "Why")
FLOORS = ("case", "commands", "engine", "measures", "reproduce", "run", "view")
ENGINE = ("forces", "geometry", "integrate", "simulation", "state", "world")


def modules() -> Iterator[Path]:
    for package in PACKAGES:
        yield from sorted((ROOT / package).rglob("*.py"))


@pytest.fixture(scope="module")
def trees() -> dict[Path, ast.Module]:
    return {path.relative_to(ROOT): ast.parse(path.read_text()) for path in modules()}


def test_a_folder_holds_a_dozen_modules_at_most():
    folders = {path.parent for path in modules()}
    sizes = {
        str(folder.relative_to(ROOT)): len([p for p in folder.glob("*.py") if p.stem[0] != "_"])
        for folder in folders
    }
    assert {name: n for name, n in sizes.items() if n > MOST_MODULES} == {}


def test_a_function_fits_on_a_screen(trees):
    long = {
        f"{path}:{node.name}": node.end_lineno - node.lineno + 1
        for path, tree in trees.items()
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef) and node.end_lineno - node.lineno >= MOST_LINES
    }
    assert long == {}


def test_docstrings_begin_with_a_noun_or_a_verb(trees):
    questions = [
        f"{path}: {words.splitlines()[0]}"
        for path, tree in trees.items()
        for node in ast.walk(tree)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
        and (words := ast.get_docstring(node) or "").split(" ")[0] in QUESTIONS
    ]
    assert questions == []


@pytest.mark.parametrize("package", ["silo2d", "damper3d"])
def test_both_simulators_have_the_same_floors_and_the_same_files_in_their_engines(package):
    rooms = [path.name for path in (ROOT / package).iterdir() if (path / "__init__.py").exists()]
    assert set(FLOORS) <= set(rooms)
    engine = ROOT / package / "engine"
    there = [path.stem for path in engine.iterdir() if path.suffix == ".py" or path.is_dir()]
    assert {*ENGINE, "neighbours"} <= set(there)
