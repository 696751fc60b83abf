"""Provenance: which sources, versions, machine and command made the numbers."""

import json
import platform
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from granulab.campaign.runs.folder import open_run
from granulab.campaign.runs.provenance import Sources, extend, provenance, source_digest


@pytest.fixture
def packages(tmp_path):
    for name in ("contact", "silo2d"):
        (tmp_path / name / "inner").mkdir(parents=True)
        (tmp_path / name / "laws.py").write_text(f"# {name}\n")
        (tmp_path / name / "inner" / "forces.py").write_text("k = 1\n")
    return [tmp_path / "contact", tmp_path / "silo2d"]


def test_source_digest_sees_code_and_nothing_else(packages):
    """Same sources, same digest, wherever they lie; one changed character, another digest."""
    before = source_digest(packages)
    assert len(before) == 12
    assert source_digest(packages[::-1]) == before
    (packages[0] / "notes.txt").write_text("not code")
    assert source_digest(packages) == before
    (packages[1] / "inner" / "forces.py").write_text("k = 2\n")
    assert source_digest(packages) != before


def test_source_digest_sees_code_that_moves(packages):
    """A renamed module is another source although the bytes are the same."""
    before = source_digest(packages)
    (packages[0] / "laws.py").rename(packages[0] / "law.py")
    assert source_digest(packages) != before


def test_source_digest_does_not_depend_on_the_folder_s_path(packages, tmp_path_factory):
    elsewhere = tmp_path_factory.mktemp("site-packages")
    before = source_digest(packages)
    moved = [folder.rename(elsewhere / folder.name) for folder in packages]
    assert source_digest(moved) == before


def test_a_file_that_extends_a_folder_from_outside_counts_among_its_sources(packages, tmp_path):
    """Other rooms keep their digest; an edit of the file gives another one."""
    room, other = map(Sources, packages)
    before, others = room.digest, other.digest
    shape = tmp_path / "myshape.py"
    shape.write_text("radius = 1")
    extend(packages[0], shape, shape)
    extended = room.digest
    assert extended != before
    assert provenance(command=[], seed=1, packages=[], sources=[packages[0]])["source_digest"] == (
        extended
    )
    shape.write_text("radius = 2")
    assert room.digest not in (before, extended)
    assert room.plus(packages[1]).digest != Sources(packages[1]).digest
    assert other.digest == others


def test_provenance_says_what_made_the_numbers(packages, tmp_path):
    """Everything the promise of same bits depends on, in plain JSON."""
    command = ["silo2d", "run", "A4"]
    known = provenance(
        command=command, seed=7, packages=["numpy", "no-such-package"], sources=packages
    )
    assert known["command"] == command
    assert known["seed"] == 7
    assert known["source_digest"] == source_digest(packages)
    assert known["versions"] == {
        "python": platform.python_version(),
        "numpy": np.__version__,
        "no-such-package": None,
    }
    assert known["machine"]["cpu"]
    assert known["machine"]["cores"] >= 1
    started = datetime.fromisoformat(known["started"])
    assert timedelta(0) <= datetime.now(UTC) - started < timedelta(minutes=1)
    run = open_run(tmp_path, "A4", "d")
    run.write_provenance(known)
    assert run.read_provenance() == json.loads(json.dumps(known))
