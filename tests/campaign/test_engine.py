"""Engines of sweeps: outcomes in order, killed workers, Ctrl-C, a lost scheduler; no physics."""

import os
import signal
import subprocess
import sys
import threading
import time

import pytest
from fake_tasks import deaf, fussy, killed, logged, patient, slow_to_end, square, surroundings
from waiting import is_alive, wait_until, when

from granulab.campaign.sweeps import engine
from granulab.campaign.sweeps.engine import TRIES, Tally, run_tasks
from granulab.campaign.sweeps.processes import Processes
from granulab.campaign.sweeps.task import EngineError
from granulab.campaign.sweeps.threads import Threads


def test_outcomes_come_in_the_order_of_the_tasks():
    seen: list[Tally] = []
    outcomes = run_tasks(square, range(7), workers=2, report=seen.append)
    assert [(o.state, o.value, o.reason) for o in outcomes] == [
        ("done", n * n, "") for n in range(7)
    ]
    counts = [(tally.total, tally.done, tally.running, tally.failed) for tally in seen]
    assert counts[0] == (7, 0, 2, 0)
    assert counts[-1] == (7, 7, 0, 0)
    assert sorted(seen[0].since) == [0, 1]
    assert len(seen[-1].took) == 7
    assert run_tasks(square, [], workers=2) == []


def test_reports_go_by_time_and_not_by_the_number_of_tasks():
    """Each goes over all tasks. Besides one in so many seconds there are the first and the last."""
    seen, begun = [], time.monotonic()
    run_tasks(square, range(500), engine="threads", workers=2, report=seen.append)
    assert len(seen) <= 2 + (time.monotonic() - begun) / engine._LOOK
    assert (seen[0].done, seen[-1].done) == (0, 500)


def test_outcomes_are_reported_once_each_as_soon_as_they_are_known():
    """Those also that fail with what they need."""
    known = []
    outcomes = run_tasks(
        fussy, [4, 1, 0], needs={2: 1}, workers=1, ended=lambda k, outcome: known.append(k)
    )
    assert known == [0, 1, 2]
    assert [o.state for o in outcomes] == ["done", "failed", "failed"]


def test_a_failure_is_an_outcome_with_its_reason_in_one_line():
    """Foreseen: its words. Not foreseen: its kind and place too. The others go on."""
    outcomes = run_tasks(fussy, range(5), workers=1)
    assert [o.state for o in outcomes] == ["done", "failed", "failed", "failed", "done"]
    assert outcomes[1].reason == "one is refused; give another"
    assert outcomes[2].reason.startswith("ZeroDivisionError: ")
    assert "fake_tasks.py:" in outcomes[2].reason
    assert "lambda" in outcomes[3].reason
    assert all("\n" not in o.reason for o in outcomes)


def test_workers_have_one_thread_each_and_leave_the_environment_as_it_was(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("NUMBA_NUM_THREADS", raising=False)
    outcomes = run_tasks(surroundings, range(6), workers=2)
    assert {o.value[:2] for o in outcomes} == {("1", "1")}
    assert 1 <= len({o.value[2] for o in outcomes}) <= 2
    assert os.environ["OMP_NUM_THREADS"] == "7"
    assert "NUMBA_NUM_THREADS" not in os.environ


def test_a_task_starts_after_the_one_it_needs(tmp_path):
    """Others go before it meanwhile; where that one fails, it fails with the same reason."""
    log = tmp_path / "log"
    tasks = [(log, "needy"), (log, "first"), (log, "free")]
    run_tasks(logged, tasks, needs={0: 2}, workers=1)
    assert log.read_text().split() == ["first", "free", "needy"]
    outcomes = run_tasks(fussy, [4, 1], needs={0: 1}, workers=1)
    assert [o.state for o in outcomes] == ["failed", "failed"]
    assert outcomes[0].reason == outcomes[1].reason == "one is refused; give another"


def test_a_killed_worker_loses_its_own_task_only_which_is_tried_again(tmp_path):
    """kill -9 once: done at the second try. The other worker's task goes on undisturbed."""
    tasks = [(tmp_path / "once", 1), (tmp_path / "never", 0), (tmp_path / "always", 99)]
    outcomes = run_tasks(killed, tasks, workers=2)
    assert [(o.state, o.value) for o in outcomes] == [("done", 1), ("done", 0), ("failed", None)]
    assert "signal 9" in outcomes[2].reason
    assert f"{TRIES} times" in outcomes[2].reason
    assert [int(file.read_text()) for file, _ in tasks] == [2, 1, TRIES]


def test_a_sweep_that_is_to_stop_says_so_while_its_tasks_still_run(tmp_path):
    """What takes long to end (a packing that grows) is waited for; the user knows at once."""
    tallies = []

    def report(tally):
        tallies.append(tally)
        if len(tallies) == 1:
            signal.raise_signal(signal.SIGINT)

    (outcome,) = run_tasks(patient, [(tmp_path / "a", 60.0)], workers=1, report=report)
    assert outcome.state == "interrupted"
    assert [tally.stopping for tally in tallies[:2]] == [False, True]
    assert tallies[1].running == 1


def test_a_worker_killed_from_outside_leaves_the_other_one_alone(tmp_path):
    tasks = [(tmp_path / "a", 2.0), (tmp_path / "b", 2.0)]
    pids: list[int] = []

    def kill() -> None:
        pids.extend(int(file.read_text()) for file, _ in tasks)
        os.kill(pids[0], signal.SIGKILL)

    thread = when(lambda: all(f.exists() and f.read_text() for f, _ in tasks), kill)
    outcomes = run_tasks(patient, tasks, workers=2)
    thread.join()
    assert [o.value for o in outcomes] == ["waited", "waited"]
    assert int(tasks[0][0].read_text()) != pids[0]
    assert int(tasks[1][0].read_text()) == pids[1]


def test_a_worker_killed_while_it_has_nothing_to_do_is_replaced():
    with Processes(1) as pool:
        pid = pool.submit(surroundings, None).result().value[2]
        wait_until(lambda: len(pool._idle) == 1, 5.0)
        os.kill(pid, signal.SIGKILL)
        broken = pool._idle[0]
        wait_until(lambda: bool(broken._broken), 10.0)
        again = pool.submit(surroundings, None).result()
    assert again.state == "done"
    assert again.value[2] != pid


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_lets_the_running_tasks_keep_their_state(tmp_path, number):
    tasks = [(tmp_path / name, 60.0) for name in "abc"]
    thread = when(
        lambda: (tmp_path / "a").exists() and (tmp_path / "b").exists(),
        lambda: signal.pthread_kill(threading.main_thread().ident, number),
    )
    outcomes = run_tasks(patient, tasks, workers=2)
    thread.join()
    assert [o.state for o in outcomes] == ["interrupted"] * 3
    assert [o.reason for o in outcomes] == ["go on with: the same"] * 2 + ["not started"]
    assert sorted(path.name for path in tmp_path.glob("*.kept")) == ["a.kept", "b.kept"]


def test_a_large_bed_has_the_time_that_its_checkpoint_takes(tmp_path):
    """Two seconds; the user knows within one that the sweep heard."""
    asked, heard = [], []

    def report(tally):
        if tally.stopping:
            heard.append(time.monotonic())
        elif (tmp_path / "a").exists() and not asked:
            asked.append(time.monotonic())
            signal.raise_signal(signal.SIGTERM)

    (outcome,) = run_tasks(slow_to_end, [(tmp_path / "a", 60.0)], workers=1, report=report)
    assert (outcome.state, outcome.reason) == ("interrupted", "go on with: the same")
    assert (tmp_path / "a.kept").exists()
    assert heard[0] - asked[0] < 1.0


def test_what_does_not_end_is_killed_after_a_while(tmp_path, monkeypatch):
    monkeypatch.setattr(engine, "_GRACE", 0.5)
    when((tmp_path / "a").exists, lambda: os.kill(os.getpid(), signal.SIGINT))
    (outcome,) = run_tasks(deaf, [(tmp_path / "a", 60.0)], workers=1)
    assert outcome.reason == "stopped between two checkpoints"
    wait_until(lambda: not is_alive(int((tmp_path / "a").read_text())), 5.0)


PROGRAM = """
import sys
from pathlib import Path
sys.path.insert(0, "tests/helpers")
import fake_tasks
from granulab.campaign.sweeps.engine import run_tasks
if __name__ == "__main__":
    tasks = [(Path(sys.argv[1]) / name, 60.0) for name in "ab"]
    run_tasks(getattr(fake_tasks, sys.argv[2]), tasks, workers=2)
"""


@pytest.fixture
def sweep(tmp_path, request):
    """A process of its own that runs two patient tasks, and the process numbers of its workers."""
    task = getattr(request, "param", "patient")
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, str(tmp_path), task],
        stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    files = [tmp_path / name for name in "ab"]
    wait_until(lambda: all(file.exists() and file.read_text() for file in files))
    yield process, [int(file.read_text()) for file in files]
    process.kill()
    process.communicate()


def test_workers_end_with_a_sweep_that_is_killed(sweep):
    """kill -9 of the sweep alone: no orphan goes on."""
    process, workers = sweep
    assert all(map(is_alive, workers))
    process.kill()
    process.wait()
    wait_until(lambda: not any(map(is_alive, workers)), 5.0)


def test_ctrl_c_at_a_terminal_reaches_all_processes_and_only_the_sweep_heeds_it(sweep, tmp_path):
    """The signal goes to the whole group; the workers hear of it by the sweep."""
    process, workers = sweep
    os.killpg(process.pid, signal.SIGINT)
    assert process.wait(20) == 0
    assert process.stderr.read() == ""
    assert len(list(tmp_path.glob("*.kept"))) == 2
    assert not any(map(is_alive, workers))


@pytest.mark.parametrize("sweep", ["deaf"], indirect=True)
def test_a_second_ctrl_c_ends_everything_at_once(sweep):
    """Also tasks that do not listen."""
    process, workers = sweep
    process.send_signal(signal.SIGINT)
    time.sleep(0.5)
    assert all(map(is_alive, workers))
    process.send_signal(signal.SIGINT)
    assert process.wait(20) == -signal.SIGINT  # KeyboardInterrupt, which nobody catches here
    assert not any(map(is_alive, workers))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"engine": "cores"}, "known: processes, threads, dask"),
        ({"workers": 0}, "workers = 0: must be at least 1"),
        ({"scheduler": "tcp://127.0.0.1:8786"}, "goes with engine dask"),
        ({"engine": "dask"}, "needs the address of its scheduler"),
        ({"engine": "dask", "scheduler": "tcp://a:1", "workers": 2}, "has its own"),
    ],
)
def test_options_that_do_not_go_together(options, words):
    with pytest.raises(EngineError, match=words):
        run_tasks(square, [1], **options)


def test_threads_work_at_once_and_hear_that_they_are_to_stop():
    """As many as there are workers wait for each other: fewer would wait for ever."""
    meet = threading.Barrier(3, timeout=10)

    def met(task, stop):
        meet.wait()
        return task

    outcomes = run_tasks(met, [1, 2, 3], engine="threads", workers=3)
    assert [outcome.value for outcome in outcomes] == [1, 2, 3]
    with Threads(1) as pool:
        pool.ask_to_stop()
        assert pool.submit(met, 4).result().state == "interrupted"
        assert not pool.give_up()
