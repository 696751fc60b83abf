"""The digests of a run and the cache of its kernels follow the rooms that matter, and no others."""

import importlib
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from granulab.campaign.runs.provenance import source_digest
from granulab.contact import jit

ROOT = Path(__file__).parents[2]
COMPILE = """
from silo2d.engine.geometry import to_edge
to_edge(1.0, 0.0, 1.0, 0.0, 1.0)
print(sum(to_edge.stats.cache_misses.values()))
"""
NOTHING, MEASURES, PHYSICS, KERNELS = "nothing", "measures", "physics", "kernels"
# What an edit of a file changes: the kernels' cache and the physics' digest, one or none.
EDITS = {
    "silo2d/view/__init__.py": NOTHING,
    "silo2d/commands/run.py": NOTHING,
    "silo2d/reproduce/__init__.py": NOTHING,
    "silo2d/baseline/discharge.py": NOTHING,
    "granulab/campaign/output/figure.py": NOTHING,
    "granulab/contact/files/units.py": PHYSICS,
    "silo2d/measures/curve.py": MEASURES,
    "silo2d/case/case.py": PHYSICS,
    "silo2d/run/protocol.py": PHYSICS,
    "silo2d/engine/geometry.py": KERNELS,
    "silo2d/engine/state.py": KERNELS,
    "granulab/contact/vectors.py": KERNELS,
    "damper3d/view/report.py": NOTHING,
    "damper3d/commands/run.py": NOTHING,
    "damper3d/reproduce/__init__.py": NOTHING,
    "damper3d/studies/map/peaks.py": NOTHING,
    "damper3d/measures/efficiency.py": MEASURES,
    "damper3d/shapes/prolate.py": PHYSICS,
    "damper3d/engine/geometry.py": KERNELS,
    "damper3d/engine/state.py": KERNELS,
}


@pytest.fixture(scope="module")
def copy(tmp_path_factory) -> Path:
    """A copy of the packages, to be edited."""
    place = tmp_path_factory.mktemp("copy")
    for package in ("granulab", "silo2d", "damper3d"):
        shutil.copytree(
            ROOT / package, place / package, ignore=shutil.ignore_patterns("__pycache__")
        )
    return place


def state(copy: Path, package: str, monkeypatch) -> list[str]:
    """Cache folder of the engine's kernels, digest of the physics, digest of the measures."""
    rooms = importlib.import_module(f"{package}.run.sources")
    monkeypatch.setattr(jit, "_LAWS", copy / "granulab" / "contact")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(copy / "cache"))
    digests = [
        source_digest([copy / folder.relative_to(ROOT) for folder in sources.folders])
        for sources in (rooms.SOURCES, rooms.MEASURES)
    ]
    return [jit.cache_folder.__wrapped__(copy / package / "engine"), *digests]


@pytest.mark.parametrize(("file", "changes"), EDITS.items())
def test_an_edit_changes_what_follows_from_it_and_nothing_else(copy, monkeypatch, file, changes):
    package = "damper3d" if file.startswith("damper3d") else "silo2d"
    before = state(copy, package, monkeypatch)
    with edited(copy / file):
        kernels, physics, measures = state(copy, package, monkeypatch)
    assert (kernels != before[0]) == (changes == KERNELS)
    assert (physics != before[1]) == (changes in (KERNELS, PHYSICS))
    assert (measures != before[2]) == (changes == MEASURES)


def test_only_an_edit_in_the_engine_compiles_its_kernels_again(copy):
    """state.py is a helper: numba itself looks at the kernel's own file alone."""
    assert compiled(copy) == 1
    with edited(copy / "silo2d/view/__init__.py"), edited(copy / "silo2d/case/case.py"):
        assert compiled(copy) == 0
    with edited(copy / "silo2d/engine/state.py"):
        assert compiled(copy) == 1


@contextmanager
def edited(path: Path) -> Iterator[None]:
    """A file with another comment at its end, for a while."""
    text = path.read_text()
    path.write_text(text + "# edited\n")
    yield
    path.write_text(text)


def compiled(copy: Path) -> int:
    """How many kernels a new process compiles that asks for one of the silo's."""
    done = subprocess.run(
        [sys.executable, "-c", COMPILE],
        cwd=copy,
        env={**os.environ, "PYTHONPATH": str(copy), "NUMBA_CACHE_DIR": str(copy / "cache")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return int(done.stdout)
