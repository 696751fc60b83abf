"""Runs of a case: results that stay true when a process is cut off, or another one is at it."""

import dataclasses
import shutil
from contextlib import ExitStack

import pytest
from fake_simulator import FAKE, fake
from same_run import assert_same_run
from small_silo import the_run

from damper3d.case.case import DamperCase
from damper3d.run import protocol, vibration
from granulab.campaign.runs.folder import BusyError, RunFolder, find_run
from granulab.campaign.sweeps.sweep import Task, run_labelled, run_or_pack
from granulab.errors import FolderError, Stopped
from silo2d.case.case import SiloCase
from silo2d.run.protocol import RUNS

CASE = SiloCase.load("A4")
TWO_DAMPERS = {
    "enclosure": {"diameter": "20 mm", "height": "25 mm"},
    "particles": {"shape": "sphere:5mm", "count": 5},
    "law": {"youngs_modulus": "0.1 GPa"},
    "fill": {"settle_time": "20 ms"},
    "run": {"cycles": 2, "discard": 0, "time_step": "5 us"},
    "output": {"samples": 50, "frames": 10},
    "host": {"mass": "0.1 kg", "frequency": 80.0, "damping_ratio": 0.02, "force": "2 N"},
    "damper": [{"seed": 1}, {"seed": 2}],
}


class Read:
    """A result that is the folder itself."""

    @classmethod
    def read(cls, folder, *, reused):
        return folder


@pytest.mark.parametrize("file", ["summary", "provenance"])
def test_results_that_a_kill_left_half_measured_are_measured_again(tmp_path, monkeypatch, file):
    """Cut off as it is about to write a file, another version's numbers never pass for today's."""
    runs = dataclasses.replace(
        RUNS, result=Read, compute=lambda *_: {"answer": 1}, measured=lambda *_: {"answer": 2}
    )
    folder = runs.run(CASE, out=tmp_path)
    folder.write_provenance({**folder.read_provenance(), "measures_digest": "of another version"})

    def cut_off(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(RunFolder, f"write_{file}", cut_off)
        with pytest.raises(KeyboardInterrupt):
            runs.run(CASE, out=tmp_path)
    assert runs.run(CASE, out=tmp_path).read_summary()["answer"] == 2
    assert folder.read_provenance()["measures_digest"] == RUNS.measures.digest


@pytest.fixture
def shared(tmp_path):
    """A run that another process computes, what ends that, and calls of this one's `compute`."""
    computed = []
    runs = dataclasses.replace(RUNS, result=Read, compute=lambda *_: computed.append(1) or {})
    folder = find_run(tmp_path, f"{CASE.name}-seed1", RUNS.digest(CASE))
    folder.path.mkdir(parents=True)
    with ExitStack() as other:
        other.enter_context(folder.lock())
        yield runs, folder, other, computed


def worked(runs, folder, stop):
    """The result of a task of a sweep."""
    task = Task(CASE, folder.path.parent, packing_only=False)
    return run_or_pack(task, stop, run=runs.run, get_packing=None)


@pytest.mark.parametrize("ends", ["finished", "killed"])
def test_a_sweep_waits_for_a_run_that_another_process_computes(shared, ends):
    """Finished there, it is read; where the other one was killed, it is computed here."""
    runs, folder, other, computed = shared

    def stop():
        other.close()
        if ends == "finished":
            runs.run(CASE, out=folder.path.parent)
        return False

    assert worked(runs, folder, stop) == folder
    assert folder.state == "finished"
    assert len(computed) == 1


def test_a_sweep_that_waits_for_another_process_stops_when_told(shared):
    runs, folder, _, computed = shared
    with pytest.raises(Stopped, match="the same command goes on"):
        worked(runs, folder, lambda: True)
    assert not computed


def test_a_single_run_is_refused_where_another_process_computes_it(shared):
    runs, folder, _, _ = shared
    with pytest.raises(FolderError, match=r"another process computes this run now.*--again"):
        runs.run(CASE, out=folder.path.parent)


def test_a_finished_run_that_another_process_measures_again_is_no_failure(tmp_path):
    """A row of such a run comes from a worker, which waits."""

    def busy(folder):
        raise BusyError(f"{folder.path}: another process computes this run now")

    for read in (FAKE.read, busy):
        simulator = dataclasses.replace(FAKE, read=read)
        (row,) = run_labelled(simulator, [({}, fake(2))], out=tmp_path, workers=1, quiet=True)
        assert (row["state"], row["square"]) == ("done", 4)


@pytest.mark.parametrize("parts", [["00003.h5"], [f"{k:05d}.h5" for k in range(9)]])
def test_lost_parts_of_a_second_damper_are_computed_again_to_the_same_bits(
    tmp_path, monkeypatch, parts
):
    """Some of them, or all: then the motion begins again."""
    monkeypatch.setattr(vibration, "CHECKPOINT_WORK", 10 * 10 * 50 + 1)  # every ten samples
    case = DamperCase.resolve({"name": "two", **TWO_DAMPERS}, "two", tmp_path)
    protocol.run(case, out=tmp_path / "whole")
    shutil.copytree(tmp_path / "whole" / "packings", tmp_path / "cut" / "packings")
    looks = iter([False] * 8)
    with pytest.raises(Stopped):
        protocol.run(case, out=tmp_path / "cut", stop=lambda: next(looks, True))
    run, said = the_run(tmp_path / "cut"), []
    for name in parts:
        (run.path / "damper-2" / "parts" / name).unlink(missing_ok=True)
    protocol.run(case, out=tmp_path / "cut", warn=said.append)
    assert f"damper-2/parts/{parts[0]}: missing" in said[0]
    whole = the_run(tmp_path / "whole")
    assert_same_run(run, whole)
    assert_same_run(RunFolder(run.path / "damper-2"), RunFolder(whole.path / "damper-2"))
