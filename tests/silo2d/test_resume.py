"""No run is lost: killed, stopped or repeated, it ends with the bits of an uninterrupted one."""

import json
import random
import shlex
import shutil
import signal
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from forking import Forked, forked, killed_at
from refusals import assert_refused
from same_run import COSTS, assert_same_run
from small_silo import SLOW, DischargeStop, finish, silo2d, start, the_run, write_case

from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.trajectory import read_trajectory
from granulab.errors import Stopped
from silo2d.case.case import SiloCase
from silo2d.run import protocol


def run_quietly(case: Path, root: Path) -> RunFolder:
    result = silo2d("run", case, "-o", root, "--no-figures", "--quiet")
    assert (result.code, result.err) == (0, "")
    return the_run(root)


def wait_for(process, condition: Callable[[], object]) -> None:
    """Until the condition holds, or the process has ended."""
    while not condition() and process.poll() is None:
        time.sleep(1e-3)


def part_is_there(root: Path, number: int) -> Callable[[], object]:
    """Whether the frames up to a checkpoint are written."""
    return lambda: list(root.glob(f"*/parts/{number:05d}.h5"))


@pytest.fixture(scope="module")
def slow_reference(_finished_root, tmp_path_factory) -> RunFolder:
    """The slow run, never interrupted."""
    folder = tmp_path_factory.mktemp("slow")
    shutil.copytree(_finished_root / "runs" / "packings", folder / "runs" / "packings")
    return run_quietly(write_case(folder, SLOW), folder / "runs")


# Twice the same


def test_the_same_case_and_seed_give_the_same_bits(reference, tmp_path):
    """In another folder, filled again; another seed gives other particles."""
    case = write_case(tmp_path)
    assert_same_run(run_quietly(case, tmp_path / "runs"), reference)
    arguments = ["-o", tmp_path / "other", "--no-figures", "--json", "--quiet", "--seed", 2]
    other = silo2d("run", case, *arguments, "--max-time", "10 ms").json
    assert other["state_digest"] != reference.read_summary()["state_digest"]


@pytest.mark.parametrize(
    "output",
    [
        {"output.frame_interval": "3.3 ms"},
        {"output.checkpoint_interval": "0.3 s"},
        {"output.contact_interval": "10 ms"},
    ],
)
def test_how_often_a_run_is_looked_at_does_not_change_it(reference, runs, tmp_path, output):
    """Frames and checkpoints come between the same steps: only how many there are changes."""
    other = run_quietly(write_case(tmp_path, output), runs)
    results = [folder.read_summary() for folder in (reference, other)]
    for name in results[0].keys() - COSTS:
        if name != "energy_closure":  # a difference between the first and last frame: the same
            assert results[0][name] == results[1][name], name
    last = [read_trajectory(folder.path)["out_time"][-1] for folder in (reference, other)]
    assert last[0].tobytes() == last[1].tobytes()


def test_a_run_stopped_many_times_ends_with_the_same_bits(reference, runs, tmp_path):
    """Gone on from every third checkpoint or so: the lists are made again in the same order."""
    case = SiloCase.load(write_case(tmp_path))
    chance, stops, result = random.Random(3), 0, None
    stop = DischargeStop(lambda: chance.random() < 0.3)
    while result is None:
        try:
            result = protocol.run(case, out=runs, progress=stop.progress, stop=stop)
        except Stopped:
            stops += 1
    assert stops >= 5
    assert not result.reused
    assert_same_run(the_run(runs), reference)


# Killed


def test_a_run_killed_at_any_moment_ends_with_the_same_bits(slow_reference, tmp_path):
    """kill -9 while it fills, once it has filled, and after random checkpoints."""
    case, root = SiloCase.load(write_case(tmp_path, SLOW)), tmp_path / "runs"
    chance = random.Random(7)
    moments: list[Callable[[], object]] = [
        lambda: list(root.glob("*/case.toml")),
        lambda: list(root.glob("packings/*/packing.h5")),
        *(part_is_there(root, k) for k in sorted(chance.sample(range(1, 20), 3))),
    ]
    killed = [
        killed_at(moment, chance.uniform(0.0, 0.02), lambda: protocol.run(case, out=root))
        for moment in moments
    ]
    assert sum(killed) >= 4  # a process that was over before its moment tests nothing
    protocol.run(case, out=root)
    assert_same_run(the_run(root), slow_reference)


def test_a_run_killed_while_it_writes_ends_with_the_same_bits(runs, tmp_path):
    """kill -9 at the first write, at a later one of the next process, and so on to the end.

    What is written: case, frames, checkpoints, the merged trajectory, the table, the summary.
    The last process is not killed.
    """
    brief = {
        "run.max_time": "20 ms",
        "output.checkpoint_interval": "10 ms",
        "output.contact_interval": "10 ms",
    }
    case = SiloCase.load(write_case(tmp_path, brief))
    codes = []
    for write in (1, 3, *range(5, 20)):
        codes.append(forked(lambda: protocol.run(case, out=runs), kill_at_write=write))
        if codes[-1] == 0:
            break
    assert codes == [-signal.SIGKILL] * (len(codes) - 1) + [0]
    assert len(codes) > 5
    shutil.copytree(runs / "packings", tmp_path / "other" / "packings")
    protocol.run(case, out=tmp_path / "other")
    assert_same_run(the_run(runs), the_run(tmp_path / "other"))
    assert not list(runs.rglob(".*.tmp"))  # what the killed ones had begun is gone


# Stopped


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_keeps_the_state_and_says_how_to_go_on(slow_reference, runs, tmp_path, number):
    """Exit code 130; the command in the one line on stderr ends with the same bits."""
    case = write_case(tmp_path, SLOW)
    arguments = ["run", case, "-o", runs, "--no-figures", "--quiet"]
    process = start(*arguments) if number == signal.SIGINT else Forked(silo2d, *arguments)
    wait_for(process, part_is_there(runs, 3))
    process.send_signal(number)
    result = finish(process) if number == signal.SIGINT else process.finish()
    assert (result.code, result.out) == (130, "")
    assert result.err.count("\n") == 1
    folder = the_run(runs)
    assert folder.state == "unfinished"
    shown = " ".join(silo2d("show", folder.path).out.split())
    assert f"{folder.path}: unfinished; go on with: " in shown
    command = shlex.split(result.err.partition("stopped; go on with: ")[2])
    assert command == ["silo2d", "run", "--resume", str(folder.path)]
    resumed = silo2d(*command[1:], "--no-figures", "--json", "--quiet").json
    assert not resumed["reused"]
    assert_same_run(folder, slow_reference)


def test_ctrl_c_while_filling_says_that_the_silo_is_filled_again(reference, tmp_path):
    """Nothing of the filling is kept: the same command begins with it."""
    case, root = write_case(tmp_path), tmp_path / "runs"
    arguments = ["run", case, "-o", root, "--no-figures", "--quiet"]
    process = Forked(silo2d, *arguments)
    wait_for(process, lambda: list(root.glob("*/case.toml")))
    process.send_signal(signal.SIGINT)
    result = process.finish()
    assert (result.code, result.out) == (130, "")
    assert result.err == "silo2d: stopped; the same command fills the silo again, from its seed\n"
    assert not list(root.glob("packings/*/*"))
    assert_same_run(run_quietly(case, root), reference)


def test_resume_works_inside_the_folder_and_finds_the_packing(runs, tmp_path, monkeypatch):
    """`--resume .`: the packings are next to the folder, whatever it is called from within."""
    case = SiloCase.load(write_case(tmp_path))
    stop = DischargeStop(lambda: True)
    with pytest.raises(Stopped, match="go on with: silo2d run --resume"):
        protocol.run(case, out=runs, progress=stop.progress, stop=stop)
    monkeypatch.setattr("silo2d.run.protocol.pour", None)
    monkeypatch.chdir(the_run(runs).path)
    assert silo2d("run", "--resume", ".", "--no-figures", "--json", "--quiet").json["n_out"] > 60


# Two at once


def test_a_second_process_is_kept_off_a_run(runs, tmp_path):
    """It ends with one line; the first one goes on and finishes."""
    case = write_case(tmp_path, SLOW)
    arguments = ["run", case, "-o", runs, "--no-figures", "--json", "--quiet"]
    process = Forked(silo2d, *arguments)
    wait_for(process, part_is_there(runs, 1))
    process.send_signal(signal.SIGSTOP)
    second = silo2d(*arguments)
    process.send_signal(signal.SIGCONT)
    assert_refused(second, "another process computes this run now")
    first = process.finish()
    assert first.code == 0
    assert json.loads(first.out)["outcome"] == "empty"


def test_a_case_changed_under_an_unfinished_run_is_refused(finished):
    """The bits promised for a run are those of the case that it began with."""
    folder = the_run(finished)
    (folder.path / "summary.json").unlink()  # unfinished again
    case = folder.path / "case.toml"
    case.write_text(case.read_text().replace("mu_wall = 0.2", "mu_wall = 0.3"))
    result = silo2d("run", "--resume", folder.path, "--quiet")
    assert result.code == 2
    assert "changed since the run began" in result.err
    assert result.err.count("\n") == 1
