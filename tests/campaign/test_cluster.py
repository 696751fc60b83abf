"""The Dask engine: the same outcomes and bits as processes; a scheduler that is lost."""

import os
import signal
import subprocess
import sys
import threading
from typing import Any

from fake_tasks import either, fussy, patient, square
from refusals import assert_refused
from small_silo import silo2d
from waiting import wait_until, when

from granulab.campaign.sweeps.cluster import DaskCluster
from granulab.campaign.sweeps.engine import run_tasks
from granulab.campaign.sweeps.task import EngineError


def test_outcomes_come_in_order_and_failures_with_their_reason(cluster):
    options = {"engine": "dask", "scheduler": cluster}
    assert [o.value for o in run_tasks(square, range(5), **options)] == [0, 1, 4, 9, 16]
    outcomes = run_tasks(fussy, [0, 1, 2, 4], needs={0: 3}, **options)
    assert [o.state for o in outcomes] == ["done", "failed", "failed", "done"]
    assert outcomes[1].reason == "one is refused; give another"
    assert outcomes[2].reason.startswith("ZeroDivisionError: ")


def test_scheduler_holds_as_many_tasks_as_there_are_threads_and_a_tenth_more(cluster, monkeypatch):
    """Of two threads, three; counted again after a while, as workers come and go."""
    with DaskCluster(cluster) as pool:
        assert pool.slots == 3
        pool._threads = 20
        assert pool.slots == 22
        monkeypatch.setattr("granulab.campaign.sweeps.cluster._REPEAT", 0.0)
        assert pool.slots == 3


def test_connection_to_the_scheduler_keeps_no_messages(cluster):
    """Dask keeps the last thousand otherwise, with the cases in them."""
    with DaskCluster(cluster) as pool:
        assert pool.submit(square, 3).result().value == 9
        assert len(pool._client.scheduler_comm.recent_message_log) == 0


def test_ctrl_c_lets_the_running_tasks_keep_their_state(cluster, tmp_path):
    thread = when(
        lambda: (tmp_path / "a").exists() and (tmp_path / "b").exists(),
        lambda: signal.pthread_kill(threading.main_thread().ident, signal.SIGINT),
    )
    tasks = [(tmp_path / name, 60.0) for name in "abc"]
    outcomes = run_tasks(patient, tasks, engine="dask", scheduler=cluster)
    thread.join()
    assert [o.state for o in outcomes] == ["interrupted"] * 3
    assert [o.reason for o in outcomes] == ["go on with: the same"] * 2 + ["not started"]


def has_a_worker(address: str) -> bool:
    try:
        (outcome,) = run_tasks(square, [3], engine="dask", scheduler=address)
        assert outcome.value == 9, outcome
        return True
    except EngineError as error:
        words = ("has no workers; start one with: dask worker", "does not respond")
        assert any(word in str(error) for word in words)  # noqa: PT017, until both are up
        return False


def test_a_scheduler_that_goes_away_ends_the_sweep_with_what_there_is(tmp_path):
    """Two commands start a cluster; once the scheduler is killed, one line says so."""
    port = 20000 + os.getpid() % 20000
    address = f"tcp://127.0.0.1:{port}"
    surroundings: dict[str, Any] = {
        "stdout": subprocess.DEVNULL,
        "stderr": subprocess.DEVNULL,
        "env": os.environ | {"PYTHONPATH": os.pathsep.join(["tests/helpers", "."])},
    }
    scheduler = subprocess.Popen(
        [sys.executable, "-m", "distributed.cli.dask_scheduler", "--port", str(port),
         "--host", "127.0.0.1", "--no-dashboard"], **surroundings,
    )  # fmt: skip
    worker = subprocess.Popen(
        [sys.executable, "-m", "distributed.cli.dask_worker", address, "--nthreads", "1",
         "--no-dashboard", "--no-nanny", "--death-timeout", "20"],
        **surroundings,
    )  # fmt: skip
    try:
        wait_until(lambda: has_a_worker(address), 60.0)
        thread = when(lambda: (tmp_path / "a").exists(), scheduler.kill)
        tasks = [4, (tmp_path / "a", 60.0)]
        outcomes = run_tasks(either, tasks, needs={1: 0}, engine="dask", scheduler=address)
        thread.join()
        assert [o.state for o in outcomes] == ["done", "interrupted"]
        assert outcomes[1].reason == f"scheduler {address} went away"
    finally:
        for process in (scheduler, worker):
            process.kill()
            process.wait()


def test_a_scheduler_that_cannot_be_reached_is_one_line(tmp_path):
    study = tmp_path / "study.toml"
    study.write_text('schema = 1\ncase = "A4"\n')
    for address in ("tcp://127.0.0.1:1", "nonsense", "foo://a:1"):
        options = ["--engine", "dask", "--scheduler", address, "-o", tmp_path / "runs"]
        result = silo2d("sweep", study, *options, "--quiet")
        assert_refused(
            result, f"scheduler {address}: does not respond; start one with: dask scheduler"
        )
