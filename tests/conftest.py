"""Runs of the small silo that several test files look at, made once for all workers of pytest."""

import logging
import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from filelock import FileLock
from fuzzing import examples
from hypothesis import HealthCheck, settings
from small_silo import silo2d, the_run, write_case

from granulab.campaign.runs.folder import RunFolder

# How long an example takes says how busy the machine is, with another worker beside this one.
# `make fuzz` takes the other profile and the tests that draw their input alone; counts that a test
# states go by fuzzing.examples.
_SHARED = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("test", _SHARED, max_examples=examples(30))
settings.load_profile("test")


@pytest.fixture(scope="session")
def _finished_root(tmp_path_factory) -> Path:
    """Made by the first worker that asks for it; the others wait, and find the kernels compiled."""
    of_all = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        of_all = of_all.parent
    root = of_all / "reference"
    with FileLock(of_all / "reference.lock"):
        if not (root / "finished").exists():
            shutil.rmtree(root, ignore_errors=True)  # of a worker that failed in it
            root.mkdir()
            answer = silo2d("run", write_case(root), "-o", root / "runs", "--no-figures", "--quiet")
            assert answer.code == 0, answer.err
            (root / "finished").touch()
    return root


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
