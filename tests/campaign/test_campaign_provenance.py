"""Provenance: which sources, versions, machine and command made the numbers."""

import json
import os
import platform
import shutil
import subprocess
import sys
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from granulab.campaign.runs.folder import RunFolder, open_run
from granulab.campaign.runs.provenance import (
    Sources,
    arithmetic,
    check_arithmetic,
    check_versions,
    extend,
    in_words,
    provenance,
    source_digest,
)
from silo2d.run import protocol as silo


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
    assert known["arithmetic"] == arithmetic()
    assert known["machine"]["cpu"]
    assert known["machine"]["cores"] >= 1
    started = datetime.fromisoformat(known["started"])
    assert timedelta(0) <= datetime.now(UTC) - started < timedelta(minutes=1)
    run = open_run(tmp_path, "A4", "d")
    run.write_provenance(known)
    assert run.read_provenance() == json.loads(json.dumps(known))


def of_process(**environment):
    """The arithmetic of a process with kernels."""
    code = (
        "import json, granulab.contact.jit; "
        "from granulab.campaign.runs.provenance import arithmetic; print(json.dumps(arithmetic()))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | environment, capture_output=True, text=True,
        check=True,
    )  # fmt: skip
    return json.loads(done.stdout)


def test_arithmetic_is_what_the_environment_makes_numba_compile_for():
    """As make test-plain sets it: a processor without any feature."""
    plain = of_process(NUMBA_CPU_NAME="generic", NUMBA_CPU_FEATURES="")
    assert plain["kernels"] == {"cpu": "generic", "features": ""}
    assert plain["blas"].keys() == {"numpy", "scipy"}
    featured = of_process(NUMBA_CPU_NAME="generic", NUMBA_CPU_FEATURES="+sse4.2,-avx,+aes")
    assert featured["kernels"]["features"] == "aes sse4.2"


@pytest.mark.skipif(
    arithmetic()["core"] is None or platform.machine() not in ("x86_64", "AMD64"),
    reason="no OpenBLAS that chooses among these cores",
)
def test_arithmetic_has_the_core_that_openblas_computes_for():
    """Prescott is one of OpenBLAS's own names, and calls itself Prescott or Katmai."""
    assert of_process(OPENBLAS_CORETYPE="Nehalem")["core"] == "Nehalem"
    assert of_process(OPENBLAS_CORETYPE="Prescott")["core"] != "Nehalem"


def test_another_arithmetic_is_said_in_one_line_and_an_unknown_one_is_not():
    said, here = [], arithmetic()
    check_arithmetic("a run was begun", {}, said.append)  # of a version before the entry
    check_arithmetic("a run was begun", {"arithmetic": here}, said.append)
    assert said == []
    check_arithmetic("a run was begun", {"arithmetic": here | {"core": "Abacus"}}, said.append)
    (line,) = said
    assert line.startswith("a run was begun with another arithmetic (")
    assert "core Abacus" in line
    assert f"here {in_words(here)}" in line


def test_other_versions_of_what_computes_are_said_in_one_line():
    """Not those of what only stores, nor of what was not installed or is not kept."""
    said, here = [], {"python": platform.python_version(), "numpy": np.__version__}
    for versions in ({}, here, here | {"h5py": "0.1"}, here | {"numba": None}, {"gone": "1.0"}):
        check_versions("a run was begun", {"versions": versions}, said.append)
    check_versions("a run was begun", {}, said.append)
    assert said == []
    check_versions("a run was begun", {"versions": here | {"numpy": "1.0"}}, said.append)
    assert said == [
        f"a run was begun with numpy 1.0 (here numpy {np.__version__}), so that its bits may not "
        "come again here"
    ]


def test_a_run_begun_with_other_versions_is_gone_on_with_after_a_warning(
    reference, tmp_path, capsys
):
    folder = RunFolder(shutil.copytree(reference.path, tmp_path / reference.path.name))
    origin = folder.read_provenance()
    folder.write_provenance({**origin, "versions": origin["versions"] | {"numba": "0.1"}})
    assert silo.resume(folder.path).reused
    assert "was begun with numba 0.1 (here numba " in capsys.readouterr().err


def test_a_run_of_another_arithmetic_is_read_with_a_warning(reference, tmp_path, capsys):
    """A run of this process has none; another processor's, and one without the entry, are read."""
    folder = RunFolder(shutil.copytree(reference.path, tmp_path / reference.path.name))
    origin = folder.read_provenance()
    made = origin.pop("arithmetic")
    assert made["kernels"]["features"] or made["kernels"]["cpu"] == "generic"
    for entry, warns in (
        ({"arithmetic": made}, False),
        ({"arithmetic": made | {"core": "Abacus"}}, True),
        ({}, False),
    ):
        folder.write_provenance({**origin, **entry})
        assert silo.resume(folder.path).reused
        assert ("core Abacus" in capsys.readouterr().err) is warns
