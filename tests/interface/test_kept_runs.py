"""Run folders that an earlier version wrote (tests/data/kept, made by make_kept.py) are read."""

import csv
import shutil
from pathlib import Path

import pytest
from refusals import assert_refused
from small_damper import damper3d
from small_silo import silo2d

from damper3d.case.case import DamperCase
from damper3d.run import protocol as damper
from granulab.campaign.runs.folder import RunFolder
from silo2d.case.case import SiloCase
from silo2d.run import protocol as silo

KEPT = Path(__file__).parents[1] / "data" / "kept"
COMMANDS = {"silo": silo2d, "damper": damper3d}


@pytest.fixture(scope="module")
def kept(tmp_path_factory) -> Path:
    """A copy: results that other measures made are written again where they stand."""
    return Path(shutil.copytree(KEPT, tmp_path_factory.mktemp("kept") / "copy"))


def the(kept: Path, pattern: str) -> Path:
    (found,) = [path for path in kept.glob(pattern) if (path / "case.toml").exists()]
    return found


@pytest.mark.parametrize("kind", COMMANDS)
def test_kept_folders_are_listed_and_whole(kept, kind):
    listed = COMMANDS[kind]("list", "-o", kept / kind)
    assert listed.code == 0
    assert "damaged" not in listed.out
    assert "unfinished" in listed.out
    checked = COMMANDS[kind]("list", "--verify", "-o", kept / kind)
    assert (checked.code, checked.err) == (0, "")
    assert " 0 damaged, 0 without a seal" in checked.out


@pytest.mark.parametrize(
    ("kind", "pattern", "what"),
    [
        ("silo", "finished-*", ["curve", "network"]),
        ("silo", "pymunk-*", ["curve"]),
        ("damper", "spheroids-*", ["efficiency"]),
        ("damper", "spheres-*f2c032c051bd", ["efficiency", "phases"]),
    ],
)
def test_kept_runs_are_shown_and_measured(kept, kind, pattern, what):
    """Finished runs: silo, impulse engine, spheres, particles of several spheres."""
    run = the(kept / kind, pattern)
    command = COMMANDS[kind]
    assert command("show", run).code == 0
    for one in what:
        result = command("observe", run, one, "--no-figures")
        assert result.code == 0, result.err


def test_tables_of_a_kept_study_and_map_are_there(kept):
    for table, rows in (("silo/studies/walls-*/table.csv", 1), ("damper/maps/*/table.csv", 4)):
        (path,) = kept.glob(table)
        with path.open(encoding="utf-8", newline="") as file:
            assert len(list(csv.DictReader(file))) == rows


@pytest.mark.parametrize("kind", COMMANDS)
def test_a_kept_unfinished_run_is_gone_on_with(kept, kind):
    """From its checkpoint and its parts, unless this version makes another run of its case.

    Then it is refused with the version that can; a case that resolves to the same run goes on.
    """
    run = the(kept / kind, "begun-*")
    case, digest = {"silo": (SiloCase, silo.run_digest), "damper": (DamperCase, damper.run_digest)}[
        kind
    ]
    same = digest(case.load(run / "case.toml")) == RunFolder(run).read_provenance()["run_digest"]
    result = COMMANDS[kind]("run", "--resume", run, "--no-figures", "--quiet", "--json")
    if not same:
        assert_refused(result, str(run), "begun by another version", "go on with that version")
        return
    assert result.code == 0, result.err
    assert result.json["reused"] is False
    assert (run / "trajectory.h5").exists()
    assert "damaged" not in result.err
