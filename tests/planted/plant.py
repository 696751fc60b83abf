"""Mistakes planted in the packages one at a time, and the test that catches each.

    python tests/planted/plant.py                     all of mistakes.toml, as a table
    python tests/planted/plant.py --only checkpoint   those whose name holds a word
    python tests/planted/plant.py --find              where each is planted; nothing is run
    python tests/planted/plant.py --write FILE        the table into a file, line by line

A mistake is a package, a text that stands in one file of it alone, what is written in its place,
and the test files to run. The tree is copied into a temporary folder, the mistake is planted in
the copy, and pytest runs the files until the first test fails. Without a mistake they must pass,
which is looked at first; a mistake that no test catches makes the exit code 1.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
_NOT_COPIED = shutil.ignore_patterns(".git", ".venv", "__pycache__", ".*_cache", ".hypothesis")


def not_copied(folder: str, names: list[str]) -> set[str]:
    """What a copy of the tree does without; runs and wheels lie at the top only."""
    at_the_top = {"runs", "dist"} if Path(folder) == ROOT else set()
    return _NOT_COPIED(folder, names) | at_the_top & set(names)


@dataclass(frozen=True)
class Mistake:
    """A change of one place that a test has to notice."""

    name: str
    package: str  # a folder below which the old text stands in one file, once
    old: str
    new: str
    tests: list[str]

    def file(self, root: Path) -> Path:
        """The file that holds the old text, which must stand there once and nowhere else."""
        found = [
            path
            for path in sorted((root / self.package).rglob("*.py"))
            for _ in range(path.read_text(encoding="utf-8").count(self.old))
        ]
        if len(found) != 1:
            raise SystemExit(f"{self.name}: the old text stands {len(found)} times: {self.old!r}")
        return found[0]


def read_mistakes(path: Path) -> list[Mistake]:
    """The mistakes of a TOML file."""
    return [Mistake(**entry) for entry in tomllib.loads(path.read_text())["mistake"]]


def first_failure(tree: Path, tests: list[str]) -> str | None:
    """The first test of some files that fails in a tree; None where all pass."""
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider",
         "-m", "not validation", *tests],
        cwd=tree, env=os.environ | {"PYTHONPATH": str(tree)},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    if done.returncode == 0:
        return None
    found = re.search(r"^(?:FAILED|ERROR) ([^\n]*?)(?: - .*)?$", done.stdout, re.MULTILINE)
    if found is None:
        raise SystemExit(f"pytest ended with {done.returncode}:\n{done.stdout}\n{done.stderr}")
    return found[1].removeprefix("tests/")


def table_row(mistake: Mistake, tree: Path) -> tuple[str, bool]:
    """A line of the table of a mistake that is planted, tried and taken out again."""
    place, begun = mistake.file(tree), time.monotonic()
    whole = place.read_text(encoding="utf-8")
    place.write_text(whole.replace(mistake.old, mistake.new), encoding="utf-8")
    try:
        caught = first_failure(tree, mistake.tests)
    finally:
        place.write_text(whole, encoding="utf-8")
    by = caught or "NOT CAUGHT"
    where = place.relative_to(tree).as_posix()
    took = time.monotonic() - begun
    print(f"{mistake.name}: {took:.0f} s", file=sys.stderr)
    return f"{mistake.name}\n    in         {where}\n    caught by  {by}", caught is not None


def main() -> int:
    """The table of all mistakes; 1 where one is not caught."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", default=[""], help="words of names of those to plant")
    parser.add_argument("--find", action="store_true", help="say where they are; run nothing")
    parser.add_argument("--sound", action="store_true", help="take the sound tree as tested")
    parser.add_argument("--write", type=Path, help="a file for the table")
    words = parser.parse_args()
    mistakes = read_mistakes(Path(__file__).with_name("mistakes.toml"))
    chosen = [m for m in mistakes if any(word in m.name for word in words.only)]
    if words.find:
        for mistake in chosen:
            print(f"{mistake.name}: {mistake.file(ROOT).relative_to(ROOT)}")
        return 0
    rows: list[str] = []
    missed = 0
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "tree"
        shutil.copytree(ROOT, tree, ignore=not_copied, symlinks=True)
        if not words.sound:
            every = sorted({file for mistake in chosen for file in mistake.tests})
            fails = first_failure(tree, every)
            if fails:
                raise SystemExit(f"without a mistake {fails} fails already")
        for mistake in chosen:
            row, caught = table_row(mistake, tree)
            rows.append(row)
            missed += not caught
            if words.write:
                words.write.write_text("\n".join([*rows, ""]), encoding="utf-8")
            print(row, flush=True)
    print(f"{len(rows) - missed} of {len(rows)} mistakes were caught")
    return 1 if missed else 0


if __name__ == "__main__":
    raise SystemExit(main())
