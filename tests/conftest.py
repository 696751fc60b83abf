"""Runs of the small silo and of small dampers that several test files look at.

Each is made once for all workers of pytest.
"""

import gc
import json
import logging
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from compiling import share_compilation
from filelock import FileLock
from fuzzing import examples
from hypothesis import HealthCheck, settings
from in_process import ThisProcess
from small_damper import damper3d, write_damper
from small_silo import silo2d, the_run, write_case

from granulab.campaign.runs.folder import RunFolder

_HERE = Path(__file__).parent

# numba makes and keeps very many objects: to look through them as often as Python does by itself
# takes an eighth of the time that kernels compile.
gc.set_threshold(500_000, 50, 50)

# How long an example takes says how busy the machine is, with another worker next to this one.
# `make fuzz` takes the other profile and the tests that draw their input alone; counts that a test
# states go by fuzzing.examples.
_SHARED = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("test", _SHARED, max_examples=examples(30))
settings.load_profile("test")


# Files that compile an engine, then those that take longest; the other worker has others meanwhile.
_FIRST = (
    "damper3d/test_cluster_contacts.py",
    "silo2d/test_conservation.py",
    "damper3d/test_damper_engine_balance.py",
    "damper3d/test_unlike_particles.py",
    "damper3d/test_extend_enclosure.py",
    "silo2d/test_disorder.py",
    "silo2d/test_sweep.py",
    "silo2d/test_extend_law.py",
    "silo2d/test_resume.py",
    "calibration/test_inverse_command.py",
    "damper3d/test_damper_cluster_run.py",
    "damper3d/test_damper_resume.py",
    "calibration/test_drop_film.py",
    "damper3d/test_damper_sweep.py",
    "silo2d/test_pymunk_baseline.py",
    "calibration/test_flow.py",
    "damper3d/test_damper_reproduce.py",
    "calibration/test_pendulum.py",
    "calibration/test_hard_films.py",
    "damper3d/test_pack.py",
    "calibration/test_impacts.py",
    "calibration/test_shaker_signals.py",
)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Bring the files of _FIRST to the front, in their order; all others stay as they are."""
    at = {name: k for k, name in enumerate(_FIRST)}
    items.sort(key=lambda item: at.get("/".join(item.path.parts[-2:]), len(at)))


@pytest.fixture(scope="session")
def _of_all_workers(tmp_path_factory) -> Path:
    """A folder that all workers of pytest share."""
    folder = tmp_path_factory.getbasetemp()
    return folder.parent if "PYTEST_XDIST_WORKER" in os.environ else folder


@pytest.fixture(scope="session", autouse=True)
def _kernels_are_compiled_once(_of_all_workers) -> None:
    """No worker compiles what another one compiles."""
    if "PYTEST_XDIST_WORKER" in os.environ:
        share_compilation(_of_all_workers / "compiling")


def _made_once(shared: Path, name: str, make: Callable[[Path], None]) -> Path:
    """The folder of that name, made by the first worker that asks; the others wait for it.

    Its path has spaces and letters of other languages, as those of other people have.
    """
    root = shared / f"{name}, größer Опыт"
    with FileLock(shared / f"{name}.lock"):
        if not (root / "finished").exists():
            shutil.rmtree(root, ignore_errors=True)  # of a worker that failed in it
            root.mkdir()
            make(root)
            (root / "finished").touch()
    return root


def _silo_run(root: Path) -> None:
    result = silo2d("run", write_case(root), "-o", root / "runs", "--no-figures", "--quiet")
    assert result.code == 0, result.err


def _damper_run(root: Path) -> None:
    result = damper3d("run", write_damper(root), "-o", root / "runs", "--no-figures", "--quiet")
    assert (result.code, result.err) == (0, ""), result.err
    (root / "said.txt").write_text(result.out, encoding="utf-8")


def _damper_of_spheres(root: Path) -> None:
    from damper_runs import small

    from damper3d.run import protocol  # loads numba, which few tests need

    protocol.run(small(), out=root / "runs")


def _damper_of_spheroids(root: Path) -> None:
    from damper_runs import small_spheroids

    from damper3d.run import protocol

    protocol.run(small_spheroids(), out=root / "runs")


@pytest.fixture(scope="session")
def _finished_root(_of_all_workers) -> Path:
    """A folder with the case of the small silo and its finished run; to be read only."""
    return _made_once(_of_all_workers, "reference", _silo_run)


@pytest.fixture(scope="session")
def reference(_finished_root) -> RunFolder:
    """The finished run of the small silo, seed 1, never interrupted; to be read only."""
    return the_run(_finished_root / "runs")


@pytest.fixture
def runs(_finished_root, tmp_path) -> Path:
    """A folder for runs that has the packing of the small silo already."""
    shutil.copytree(_finished_root / "runs" / "packings", tmp_path / "runs" / "packings")
    return tmp_path / "runs"


@pytest.fixture
def finished(_finished_root, tmp_path) -> Path:
    """A copy, to be damaged, of the folder with the finished run of the small silo."""
    shutil.copytree(_finished_root / "runs", tmp_path / "finished")
    return tmp_path / "finished"


@pytest.fixture(scope="session")
def damper_root(_of_all_workers) -> Path:
    """The small damper's case, its run by the command in runs/, what it said; to be read only."""
    return _made_once(_of_all_workers, "damper", _damper_run)


@pytest.fixture(scope="module")
def damper_folder(damper_root, tmp_path_factory) -> Path:
    """A copy of damper_root that the tests of a file may add to."""
    folder = tmp_path_factory.mktemp("damper") / "copy"
    return Path(shutil.copytree(damper_root, folder))


@pytest.fixture(scope="session")
def damper_reference(_of_all_workers) -> RunFolder:
    """The finished run of damper_runs.small, seed 1, never interrupted; to be read only."""
    return the_run(_made_once(_of_all_workers, "damper_of_spheres", _damper_of_spheres) / "runs")


@pytest.fixture
def damper_packings(damper_reference, tmp_path) -> Path:
    """A folder for runs that has the packing of damper_reference already."""
    shutil.copytree(damper_reference.path.parent / "packings", tmp_path / "runs" / "packings")
    return tmp_path / "runs"


@pytest.fixture(scope="session")
def spheroid_reference(_of_all_workers) -> RunFolder:
    """The same of damper_runs.small_spheroids, particles of several spheres; to be read only."""
    root = _made_once(_of_all_workers, "damper_of_spheroids", _damper_of_spheroids)
    return the_run(root / "runs")


def _extended_damper(root: Path) -> None:
    command = [sys.executable, _HERE / "helpers" / "extended_damper.py", _HERE / "damper3d"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    (root / "found.json").write_text(done.stdout, encoding="utf-8")


@pytest.fixture
def in_this_process(monkeypatch) -> None:
    """Sweeps without workers: each would load the kernels for a run of a tenth of a second."""
    monkeypatch.setattr("granulab.campaign.sweeps.engine._pool", ThisProcess)


@pytest.fixture(scope="session")
def extended_damper(_of_all_workers) -> dict[str, Any]:
    """What a process found that registers an enclosure and a motion from outside the package."""
    root = _made_once(_of_all_workers, "extended_damper", _extended_damper)
    return json.loads((root / "found.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")  # its threads draw random numbers, which hypothesis resents
def cluster() -> Iterator[str]:
    """A scheduler and two workers as threads of this process; the address."""
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0",
        protocol="tcp://", host="127.0.0.1", silence_logs=logging.CRITICAL,
        scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},  # any port: 8787 may be taken
    ) as local:  # fmt: skip
        yield local.scheduler_address
