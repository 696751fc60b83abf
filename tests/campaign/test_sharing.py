"""Threads of a run: as many as are wanted, or the cores where a step takes long enough."""

import threading

import pytest

from granulab.campaign.runs import sharing

LONG, SHORT = 1e-3, 1e-6  # [s] a step on one core
_cores = sharing.cores


@pytest.fixture(autouse=True)
def four_cores(monkeypatch):
    monkeypatch.setattr(sharing, "cores", lambda: 4)


def test_a_long_step_is_shared_by_all_cores_and_a_short_one_by_none():
    assert sharing.shared_by(LONG) == 4
    assert sharing.shared_by(SHORT) == 1


def test_what_is_wanted_holds_within_and_none_changes_nothing():
    with sharing.wanted(3):
        assert sharing.shared_by(SHORT) == 3
        with sharing.wanted(None):
            assert sharing.shared_by(SHORT) == 3
        with sharing.wanted(1):
            assert sharing.shared_by(LONG) == 1
    assert sharing.shared_by(LONG) == 4


def test_a_run_in_a_thread_of_a_sweep_has_one_thread():
    found = []
    other = threading.Thread(target=lambda: found.append(sharing.shared_by(LONG)))
    other.start()
    other.join()
    assert found == [1]


def test_a_run_in_a_worker_process_has_one_thread(monkeypatch):
    monkeypatch.setattr(sharing.multiprocessing, "parent_process", lambda: object())
    assert sharing.shared_by(LONG) == 1


def test_the_echo_names_the_threads_where_there_are_several():
    assert sharing.in_words(1) == []
    assert "2 share each step" in sharing.in_words(2)[0]


@pytest.mark.parametrize(
    ("limit", "expected"),
    [("max 100000", 8), ("200000 100000", 2), ("50000 100000", 1), ("1600000 100000", 8)],
)
def test_a_container_s_quota_limits_the_cores(monkeypatch, tmp_path, limit, expected):
    monkeypatch.setattr(sharing, "_QUOTA", tmp_path / "cpu.max")
    monkeypatch.setattr(sharing.os, "sched_getaffinity", lambda _: set(range(8)), raising=False)
    (tmp_path / "cpu.max").write_text(limit + "\n")
    assert _cores() == expected


@pytest.mark.parametrize(("step_us", "expected"), [(5, 1), (39, 1), (41, 2), (130, 6), (1000, 8)])
def test_threads_have_enough_to_do(monkeypatch, step_us, expected):
    """Twenty microseconds of a step each."""
    monkeypatch.setattr(sharing, "cores", lambda: 8)
    assert sharing.shared_by(1e-6 * step_us) == expected
