"""No damper run is lost: killed, stopped or repeated, it ends with an undisturbed one's bits."""

import json
import math
import os
import random
import shlex
import signal
import threading
import time
from pathlib import Path

import pytest
from damper_runs import OFTEN, OPTIONS, small
from forking import fork, forked
from same_run import assert_same_run, results
from small_damper import damper3d
from small_silo import finish, start, the_run

from damper3d.engine.simulation import Simulation
from damper3d.run import protocol, vibration
from damper3d.run.steady import BLOCK
from granulab.campaign.runs.sharing import alone
from granulab.campaign.runs.trajectory import read_tables, read_trajectory
from granulab.errors import FolderError, SimulationError, Stopped


@pytest.fixture
def runs(damper_packings) -> Path:
    """A folder for runs that has the packing of the small damper already."""
    return damper_packings


@pytest.fixture
def often(monkeypatch) -> None:
    """Checkpoints within the cycles, as in those that take long."""
    monkeypatch.setattr(vibration, "CHECKPOINT_WORK", OFTEN)


def test_the_same_case_and_seed_give_the_same_bits(damper_reference, tmp_path):
    """In another folder, filled again; another seed gives another bed."""
    protocol.run(small(), out=tmp_path)
    assert_same_run(the_run(tmp_path), damper_reference)
    other = protocol.run(small(run__seed=2, run__cycles=2), out=tmp_path / "other")
    assert other.state_digest != results(damper_reference)["state_digest"]


def test_checkpoints_and_frames_do_not_change_the_bits(damper_reference, runs, often):
    """Checkpoints every three samples, tables at every one, or none at all."""
    protocol.run(small(), out=runs)
    assert_same_run(the_run(runs), damper_reference)
    for frames in (20, 0):
        result = protocol.run(small(output__frames=frames), out=runs)
        assert result.state_digest == results(damper_reference)["state_digest"]


def test_what_a_run_keeps_has_the_rows_that_it_says(damper_reference):
    """A sample before the first cycle, 20 a cycle, and tables with every fifth."""
    samples = read_trajectory(damper_reference.path)
    assert len(samples["time"]) == 4 * 20 + 1
    assert samples["time"][0] == samples["displacement"][0] == samples["wall_work"][0] == 0.0
    assert samples["time"][20] == pytest.approx(1 / 80)
    particles, contacts = (read_tables(damper_reference.path, n) for n in ("particles", "contacts"))
    assert particles.frame.tolist() == contacts.frame.tolist() == list(range(0, 81, 5))
    assert set(particles.length) == {20}
    last = particles.at(-1)
    mean = [float(last[axis].mean()) for axis in "xyz"]
    # Written in single precision: 20 mm to 2e-9 m.
    assert mean == pytest.approx(samples["mean_position"][-1].tolist(), abs=2e-9)
    assert contacts.columns["body_2"].max() < 20 + 3


def test_the_out_of_phase_mass_takes_the_work_of_the_enclosure(damper_reference, runs):
    """E = pi V^2 m'', whatever the harmonics of the force: one from its samples, one from its work.

    With 100 samples a cycle the 99th and 101st harmonic look like the first, at a hundredth of
    their size, and impacts have them in full: some 2 %.
    """
    found = protocol.run(small(output__samples=100), out=runs)
    work = 4 * found.mass_kg * found.efficiency_wall_work
    assert math.pi * found.effective_mass["out_of_phase_kg"] == pytest.approx(work, rel=0.04)


def test_a_bed_that_rides_along_is_a_rigid_mass_whose_loss_is_its_work(damper_reference, runs):
    """Below Gamma 1: m' = M but for the contacts' springs; m'' without the half step of the forces.

    A step's half is an angle of 5e-4; m'' agrees with the work of the enclosure to a tenth of it.
    """
    finer = {"output__samples": 100, "output__frames": 0}  # harmonics look like the first less
    found = protocol.run(small(motion__gamma=0.5, run__cycles=8, run__discard=4, **finer), out=runs)
    mass = found.effective_mass
    assert mass["in_phase_kg"] == pytest.approx(found.mass_kg, rel=5e-3)
    work = 4 / math.pi * found.efficiency_wall_work
    half_step = math.pi * 80 * found.time_step_s
    assert mass["out_of_phase_kg"] / found.mass_kg == pytest.approx(work, abs=0.1 * half_step)


def test_a_run_stopped_many_times_ends_with_the_same_bits(damper_reference, runs):
    chance, stops, result = random.Random(3), 0, None
    while result is None:
        try:
            result = protocol.run(small(), out=runs, stop=lambda: chance.random() < 0.3)
        except Stopped:
            stops += 1
    assert stops >= 3
    assert not result.reused
    assert_same_run(the_run(runs), damper_reference)
    assert protocol.run(small(), out=runs).reused


def test_a_run_killed_at_any_moment_ends_with_the_same_bits(damper_reference, tmp_path, often):
    """kill -9 by somebody else, some milliseconds after each start, in filling and shaking."""
    chance, killed = random.Random(7), 0
    for _ in range(15):
        child = fork()
        if not child:
            try:
                protocol.run(small(), out=tmp_path)
            finally:
                os._exit(0)
        time.sleep(chance.uniform(0.02, 0.25))
        os.kill(child, signal.SIGKILL)
        _, status = os.waitpid(child, 0)
        killed += os.waitstatus_to_exitcode(status) == -signal.SIGKILL
        if list(tmp_path.glob("*/summary.json")):
            break
    assert killed >= 2
    protocol.run(small(), out=tmp_path)
    assert_same_run(the_run(tmp_path), damper_reference)


def test_a_run_killed_while_it_writes_ends_with_the_same_bits(damper_reference, runs, often):
    """kill -9 at the first write of a process, at the second of the next, and so on to the end.

    What is written: case, samples, checkpoints, the merged trajectory, the summary.
    """
    codes = []
    for write in range(1, 60):
        codes.append(forked(lambda: protocol.run(small(), out=runs), kill_at_write=write))
        if codes[-1] == 0:
            break
    assert codes == [-signal.SIGKILL] * (len(codes) - 1) + [0]
    assert len(codes) > 5
    assert_same_run(the_run(runs), damper_reference)
    assert not list(runs.rglob(".*.tmp"))  # what the killed ones had begun is gone
    assert not list(runs.glob("*/parts"))
    assert not list(runs.glob("*/checkpoint.h5"))


def test_a_filling_that_is_killed_leaves_no_lock(damper_reference, tmp_path):
    """The packing is the first file that a process writes after the three of its run folder."""
    assert forked(lambda: protocol.run(small(), out=tmp_path), kill_at_write=4) == -signal.SIGKILL
    assert the_run(tmp_path).state == "unfinished"
    assert not list(tmp_path.glob("packings/*/packing.h5"))
    protocol.run(small(), out=tmp_path)
    assert_same_run(the_run(tmp_path), damper_reference)


def test_ctrl_c_keeps_the_state_and_says_how_to_go_on(tmp_path):
    """Exit code 130; the command in the one line on stderr goes on to the end."""
    arguments = [*OPTIONS, "--cycles", 400, "-o", tmp_path, "--no-figures", "--quiet"]
    often = f"from damper3d.run import vibration\nvibration.CHECKPOINT_WORK = {OFTEN}"
    process = start("run", *arguments, before=often, package="damper3d")
    while not list(tmp_path.glob("*/parts/00003.h5")) and process.poll() is None:
        time.sleep(5e-3)
    process.send_signal(signal.SIGINT)
    result = finish(process)
    assert (result.code, result.out, result.err.count("\n")) == (130, "", 1)
    folder = the_run(tmp_path)
    assert folder.state == "unfinished"
    assert folder.checkpoint.exists()
    command = shlex.split(result.err.partition("stopped; go on with: ")[2])
    assert command == ["damper3d", "run", "--resume", str(folder.path)]


def test_ctrl_c_while_filling_says_that_it_is_filled_again(tmp_path):
    with pytest.raises(Stopped, match="fills the enclosure again, from its seed"):
        protocol.run(small(), out=tmp_path, stop=lambda: True)
    assert not list(tmp_path.glob("packings/*/*"))


def test_resume_goes_on_in_its_folder_and_refuses_a_changed_case(damper_reference, runs):
    stops = iter([False, True])
    with pytest.raises(Stopped, match=r"^go on with: damper3d run --resume "):
        protocol.run(small(), out=runs, stop=lambda: next(stops))
    folder = the_run(runs)
    text = folder.read_case()
    (folder.path / "case.toml").write_text(text.replace("gamma = 10.0", "gamma = 11.0"))
    with pytest.raises(FolderError, match="changed since the run began"):
        protocol.resume(folder.path)
    (folder.path / "case.toml").write_text(text)
    assert not protocol.resume(folder.path).reused
    assert_same_run(folder, damper_reference)


@pytest.mark.parametrize(("factor", "words"), [(2.0, "came from nowhere"), (0.0, "went nowhere")])
def test_energy_that_is_not_accounted_for_ends_the_run(runs, monkeypatch, factor, words):
    """Friction that is booked twice, or not at all; the run can be looked into."""
    honest = Simulation.run

    def cooked(sim, n_samples):
        rows = honest(sim, n_samples)
        return rows | {k: factor * v for k, v in rows.items() if k.startswith("friction")}

    monkeypatch.setattr(Simulation, "run", cooked)
    with pytest.raises(SimulationError, match=rf"t = 0\.0125.* J of energy {words}; try"):
        protocol.run(small(), out=runs)
    assert the_run(runs).state == "unfinished"


def test_spheres_too_soft_for_their_load_end_the_run(runs):
    """Of 1 kPa under the weight of a bed and 10 g: Hertz's law is long past its small overlaps."""
    with pytest.raises(SimulationError, match=r"half a radius; try .* a higher --youngs-modulus"):
        protocol.run(small(law__youngs_modulus="1 kPa"), out=runs)


# What runs share, and what they keep


def test_runs_of_other_frequencies_and_strengths_share_a_packing(runs, monkeypatch):
    """Nothing is filled a second time."""
    monkeypatch.setattr(protocol, "fill", None)
    quick = {"run__cycles": 1, "run__discard": 0}
    for gamma, frequency in ((2, 80), (5, 200)):
        changes = {"motion__gamma": gamma, "motion__frequency": frequency}
        protocol.run(small(**quick, **changes), out=runs)
    assert len(list(runs.glob("packings/*/packing.h5"))) == 1
    assert len(list(runs.glob("*/summary.json"))) == 2


def test_who_waits_for_a_packing_can_be_stopped(tmp_path):
    """The second of two takes its turn once the first is done, or gives up when it is stopped."""
    holds, release = threading.Event(), threading.Event()

    def first() -> None:
        with alone(tmp_path / "packing", lambda: False, Stopped("")):
            holds.set()
            release.wait(10)

    thread = threading.Thread(target=first)
    thread.start()
    holds.wait(10)
    with (
        pytest.raises(Stopped, match="stopped"),
        alone(tmp_path / "packing", lambda: True, Stopped("stopped")),
    ):
        raise AssertionError("both at once")
    release.set()
    with alone(tmp_path / "packing", lambda: False, Stopped("")):
        pass
    thread.join()


def test_a_damaged_packing_is_named_and_not_used(runs):
    (file,) = runs.glob("packings/*/packing.h5")
    file.write_bytes(file.read_bytes()[:-100])
    with pytest.raises(FolderError, match=r"packing\.h5: damaged.*; delete it and the enclosure"):
        protocol.run(small(), out=runs)


def test_a_run_that_keeps_its_summary_has_the_same_results_and_no_trajectory(
    damper_reference, runs
):
    """Killed or not, nothing but the results stays."""
    case = small(output__keep="summary")
    codes = [forked(lambda: protocol.run(case, out=runs), kill_at_write=k) for k in range(4, 12)]
    assert -signal.SIGKILL in codes
    assert codes[-1] == 0
    folder = the_run(runs)
    kept = {"case.toml", "materials.toml", "provenance.json", "summary.json", ".lock"}
    assert {path.name for path in folder.path.iterdir()} == kept
    (folder.path / "parts").mkdir()  # as if killed after its summary stood
    assert protocol.run(case, out=runs).reused
    assert {path.name for path in folder.path.iterdir()} == kept
    assert results(folder) == results(damper_reference)


def test_a_steady_run_ends_when_it_is_steady_or_at_the_most_cycles(runs):
    """Even numbers of cycles beyond the start-up; the results are those of the judged cycles."""
    result = protocol.run(small(run__steady=True, run__max_cycles=25, run__discard=3), out=runs)
    assert result.steady is False  # twenty spheres scatter far more than 5 %
    assert result.cycles == 25
    assert result.cycles - result.discarded == 4 * BLOCK
    judged = result.efficiency_per_cycle[result.discarded :]
    assert result.efficiency == pytest.approx(sum(judged) / len(judged))
    low, high = result.efficiency_interval
    assert low < result.efficiency < high
    # At 0.9 g the bed lies still on the floor and dissipates next to nothing, in every cycle.
    still = protocol.run(
        small(run__steady=True, run__max_cycles=40, run__discard=3, motion__gamma=0.5), out=runs
    )
    assert still.steady is True
    assert (still.cycles - 3) % BLOCK == 0
    assert still.efficiency_with_settling < 0.02


def test_the_command_prints_what_the_run_found(tmp_path):
    """The JSON of the command is the summary; a second time it is read."""
    arguments = ["run", *OPTIONS, "-o", tmp_path, "--no-figures", "--json", "--quiet"]
    first, second = (json.loads(damper3d(*arguments).out) for _ in range(2))
    assert (first.pop("reused"), second.pop("reused")) == (False, True)
    assert first == second
