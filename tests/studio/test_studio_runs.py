"""Runs on the page: who computes them, and what their folders hold."""

from types import SimpleNamespace

import pytest
from refusals import assert_refuses

from granulab.campaign.runs.folder import RunFolder
from granulab.studio.desk import Desk
from silo2d.case.case import SiloCase
from silo2d.run.sweep import SILO

CASE = {"name": "one", "silo": {"preset": "A4"}}


@pytest.fixture
def begun(tmp_path):
    """The folder of a run that was begun without figures."""
    case = SiloCase.resolve({"name": "one", "silo": {"preset": "A4"}}, "one.toml", tmp_path)
    run = SILO.run_folder(case, tmp_path / "runs")
    run.path.mkdir(parents=True)
    run.write_provenance({"command": ["silo2d", "run", "--no-figures", "one.toml"]})
    run.write_case(case.to_toml())
    return run


def test_a_run_of_another_program_is_seen_by_its_lock(tmp_path, begun):
    """Nothing is left of the look: the program that asks for the lock next has it."""
    desk, name = Desk(tmp_path), begun.path.name
    assert desk.asks["run"](name)["state"] == "unfinished"
    with begun.lock():
        assert desk.asks["run"](name)["state"] == "elsewhere"
        assert desk.orders["check"]("silo2d", CASE)["state"] == "elsewhere"
        assert desk.orders["begin"]("silo2d", CASE)["run"] == name, "it is watched"
    assert desk.processes.get(f"runs/{name}") is None
    assert desk.asks["run"](name)["state"] == "unfinished"
    with begun.lock():
        pass


def test_a_run_that_goes_on_is_watched_and_not_begun_again(tmp_path, begun, monkeypatch):
    desk = Desk(tmp_path)
    going = SimpleNamespace(code=None, command=["silo2d"], state=lambda: {"state": "running"})
    monkeypatch.setattr(desk.processes, "get", lambda name: going)
    assert desk.orders["check"]("silo2d", CASE)["state"] == "running"
    assert desk.orders["begin"]("silo2d", CASE)["run"] == begun.path.name


def test_a_run_goes_on_without_pictures_where_it_was_begun_so(tmp_path, begun, monkeypatch):
    desk, started = Desk(tmp_path), []
    monkeypatch.setattr(desk.processes, "start", lambda name, command: started.append(command))
    desk.orders["resume"](begun.path.name)
    begun.write_provenance({"command": ["silo2d", "run", "one.toml"]})
    desk.orders["resume"](begun.path.name)
    line = ["silo2d", "run", "--resume", f"runs/{begun.path.name}"]
    assert started == [[*line, "--no-figures"], line]


def test_a_run_whose_case_is_damaged_is_listed_as_such(tmp_path, begun):
    (begun.path / "case.toml").write_text("[[")
    desk = Desk(tmp_path)
    (found,) = desk.asks["runs"]()
    assert (found["run"], found["state"]) == (begun.path.name, "damaged")
    words = ["case.toml is damaged; restore it, or remove the folder"]
    assert_refuses(words, desk.asks["run"], begun.path.name)
    assert not RunFolder(begun.path).is_computed
