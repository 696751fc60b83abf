"""Sizes of rooms and functions, and the first words of docstrings, as the house has them."""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("granulab", "silo2d", "damper3d", "calibration")
MOST_MODULES = 12  # in a folder
MOST_LINES = 60  # of a function
QUESTIONS = ("What", "Which", "How", "Whether", "Who", "Where", "When", "Why")
INNER = {"inner", "inlined_inner"}  # decorators of what has no machine code of its own
KERNEL = {*INNER, "njit", "uncounted", "inlined", "specialised", "substituted", "overload",
          "intrinsic"}  # fmt: skip
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


def decorated(function: ast.FunctionDef, by: set[str]) -> bool:
    """Tell whether a function is decorated by one of some names."""
    found = [one.func if isinstance(one, ast.Call) else one for one in function.decorator_list]
    return any(getattr(one, "id", getattr(one, "attr", None)) in by for one in found)


@cache
def inner_functions(path: Path) -> set[str]:
    """Names of a module's functions that only kernels call."""
    functions = [n for n in ast.parse(path.read_text()).body if isinstance(n, ast.FunctionDef)]
    return {function.name for function in functions if decorated(function, INNER)}


def known_inner(path: Path, tree: ast.Module) -> set[str]:
    """Names that stand for such functions in a module: its own, and what it imports."""
    known = inner_functions(path)
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            source = ROOT / f"{(node.module or '').replace('.', '/')}.py"
            theirs = inner_functions(source) if source.exists() else set()
            known |= {one.asname or one.name for one in node.names if one.name in theirs}
    return known


def called_by_python(node: ast.AST) -> Iterator[str]:
    """Names of functions that are called outside kernels, but for their .py_func."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.FunctionDef) and decorated(child, KERNEL):
            continue
        if isinstance(child, ast.Call) and isinstance(child.func, ast.Name):
            yield child.func.id
        yield from called_by_python(child)


def test_python_calls_nothing_that_only_kernels_call():
    """It would jump to nowhere."""
    assert "push_pairs" in inner_functions(ROOT / "damper3d/engine/forces.py")
    paths = [*modules(), *(ROOT / "tests").rglob("*.py"), *(ROOT / "benchmarks").rglob("*.py")]
    for path in paths:
        tree = ast.parse(path.read_text())
        assert not known_inner(path, tree) & set(called_by_python(tree)), path


@pytest.mark.parametrize("package", ["silo2d", "damper3d"])
def test_both_simulators_have_the_same_floors_and_the_same_files_in_their_engines(package):
    rooms = [path.name for path in (ROOT / package).iterdir() if (path / "__init__.py").exists()]
    assert set(FLOORS) <= set(rooms)
    engine = ROOT / package / "engine"
    there = [path.stem for path in engine.iterdir() if path.suffix == ".py" or path.is_dir()]
    assert {*ENGINE, "neighbours"} <= set(there)
