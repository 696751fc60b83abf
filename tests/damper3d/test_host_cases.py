"""Cases with a host: what follows from it, what is refused, and runs that go on with their bits."""

import json
import math
import random
from pathlib import Path

import numpy as np
import pytest
from refusals import assert_refused, assert_refuses, refusal
from same_run import assert_same_run
from small_damper import damper3d, write_damper
from small_silo import DRY, the_run

from damper3d.case.case import DamperCase
from damper3d.case.host.modes import read_modes
from damper3d.measures.counted import Cycles
from damper3d.run import protocol, vibration
from damper3d.run.result import too_early
from damper3d.run.steady import keeps_amplitude
from damper3d.view.scene import Scene
from granulab.campaign.runs.trajectory import Trajectory
from granulab.errors import Stopped

HOST = {"host.mass": "0.1 kg", "host.frequency": 80.0, "host.damping_ratio": 0.02}
FORCED = {**HOST, "host.force": "2 N", "motion.gamma": None, "motion.frequency": None}
TWISTED = {"host.inertia": "1e-6 kg m2", "host.frequency": 80.0, "host.damping_ratio": 0.02,
           "host.torque": "1e-3 N m", "motion.gamma": None, "motion.frequency": None}  # fmt: skip
LET_GO = {**FORCED, "host.force": None, "host.start_displacement": "1 mm"}
HEAD = "frequency [Hz],damping_ratio,shape [kg^-0.5]\n"


def load(folder: Path, changes) -> DamperCase:
    return DamperCase.load(write_damper(folder, changes))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"host.mass": "0.1 kg"}, ["[host]", "frequency is missing"]),
        ({**FORCED, "host.torque": "1 N m"}, ["torque goes with inertia"]),
        ({**TWISTED, "host.mass": "1 kg"}, ["inertia and mass are both given"]),
        ({**TWISTED, "host.inertia": "1 kg"}, ["inertia = '1 kg'", "unit is wrong"]),
        ({**TWISTED, "motion.direction": [1, 0, 0]}, ["inertia", "leave [motion] direction out"]),
        (
            {
                **TWISTED,
                "enclosure.shape": "box",
                "enclosure.diameter": None,
                "enclosure.width": "20 mm",
            },
            ["inertia", "a box would move through the bed"],
        ),
        (
            {
                **TWISTED,
                "excitation.kind": "shock",
                "excitation.amplitude": "1 N",
                "excitation.length": "1 ms",
            },
            ["leave [host] inertia out"],
        ),
        ({**HOST}, ["[host]", "nothing moves it", "start_displacement"]),
        (
            {**FORCED, "host.base_displacement": "1 mm"},
            ["force and base_displacement", "leave one"],
        ),
        ({**FORCED, "host.start_velocity": "1 m/s"}, ["force and start_velocity"]),
        ({**FORCED, "host.modes": "modes.csv"}, ["mass is given", "modes.csv"]),
        ({**FORCED, "motion.gamma": 3.0}, ["gamma = 3", "leave it out"]),
        ({**FORCED, "motion.ramp": 2}, ["ramp = 2", "leave one of them out"]),
        ({**FORCED, "host.damping_ratio": 0}, ["damping_ratio = 0", "no steady response"]),
        ({**FORCED, "host.damping_ratio": 1.0}, ["damping_ratio = 1.0", "less than 1"]),
        ({**FORCED, "host.damping_ratio": -0.1}, ["damping_ratio = -0.1"]),
        ({**FORCED, "host.frequency": "-2 Hz"}, ["frequency = '-2 Hz'", "greater than 0"]),
        ({**FORCED, "host.mass": "3"}, ["mass = '3'", "unit is missing", "kg"]),
        ({**FORCED, "host.mass": "1 mg"}, ["times the host's mass", "at least 1/100"]),
        (
            {
                **FORCED,
                "host.force": None,
                "host.start_velocity": "1 m/s",
                "motion.frequency": 40.0,
            },
            ["frequency = 40 Hz", "the host's own, 80 Hz"],
        ),
        (
            {**FORCED, "host.force": None, "host.start_velocity": "1 m/s", "run.steady": True},
            ["steady = true", "never steady"],
        ),
    ],
    ids=lambda given: given[0] if isinstance(given, list) else "",
)
def test_a_host_that_cannot_be_is_refused(changes, words, tmp_path):
    assert_refuses(words, load, tmp_path, changes)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["no modes", "shape [kg^-0.5]"]),
        ("frequency [Hz],damping_ratio,shape\n20,0.1,1\n", ["'shape'", "unit is missing"]),
        ("frequency [Hz],damping_ratio,shape [kg]\n20,0.1,1\n", ["'shape [kg]'", "'kg'"]),
        ("frequency [Hz],damping,shape [kg^-0.5]\n20,0.1,1\n", ["'damping'", "damping_ratio"]),
        ("frequency [Hz],damping_ratio\n20,0.1\n", ["column 'shape' is missing"]),
        (HEAD.replace("damping_ratio", "frequency") + "20,20,1\n", ["'frequency' stands twice"]),
        (HEAD + "\n-20,0.01,1\n", ["line 3", "frequency = -20 Hz"]),
        (HEAD + "-20,0.01,1\n", ["line 2", "frequency = -20 Hz"]),
        (HEAD + "20,1.2,1\n", ["line 2", "damping_ratio = 1.2"]),
        (HEAD + "20,0.01,much\n", ["line 2", "shape = 'much'"]),
        (HEAD + "20,0.01\n", ["line 2 has 2 values"]),
        (HEAD + "20,0.01,0\n", ["every shape is 0"]),
    ],
    ids=lambda given: given[0] if isinstance(given, list) else "",
)
def test_a_table_of_modes_that_cannot_be_is_refused(text, words, tmp_path):
    path = tmp_path / "modes.csv"
    path.write_text(text, encoding="utf-8")
    assert_refuses(words, read_modes, path)


def test_two_modes_of_one_frequency_and_damping_act_as_one(tmp_path):
    """On a damper at one place with the root of the sum of their squares: sqrt(3^2 + 4^2)."""
    single = dict.fromkeys(("host.mass", "host.frequency", "host.damping_ratio"))
    modal = FORCED | single | {"host.modes": "modes.csv"}
    sizes = []
    for rows in ("80,0.02,3\n80,0.02,4\n", "80,0.02,5\n"):
        (tmp_path / "modes.csv").write_text(HEAD + rows, encoding="utf-8")
        sizes.append(load(tmp_path, modal).amplitude)
    assert sizes[0] == pytest.approx(sizes[1], rel=1e-12)


def test_base_motion_of_modes_needs_their_participation(tmp_path):
    path = tmp_path / "modes.csv"
    path.write_text(HEAD + "20,0.01,1\n", encoding="utf-8")
    assert "'participation' is missing, which base motion needs" in refusal(read_modes, path, True)
    shaken = {"host.modes": "modes.csv", "excitation.kind": "shock", "excitation.on": "base",
              "excitation.amplitude": "2 g", "excitation.length": "5 ms",
              "motion.gamma": None, "motion.frequency": None}  # fmt: skip
    for changes in ({"host.modes": "modes.csv", "host.base_acceleration": "1 g"}, shaken):
        words = ["'participation' is missing, which base motion needs"]
        assert_refuses(words, load, tmp_path, changes)


def test_the_bare_response_of_a_mode_is_that_of_an_oscillator(tmp_path):
    """At resonance F/(2 zeta k); the motion's frequency is by itself the host's own."""
    case = load(tmp_path, FORCED)
    omega = 2 * np.pi * 80.0
    assert case.settings.motion.frequency == 80.0
    assert case.amplitude == pytest.approx(2.0 / (2 * 0.02 * 0.1 * omega**2))
    assert case.settings.run.steady is False  # the small damper gives its cycles
    other = load(tmp_path, {**FORCED, "run.cycles": None, "run.discard": None})
    assert other.settings.run.steady is True
    again = DamperCase.load(write_toml(tmp_path, case))
    assert protocol.run_digest(again) == protocol.run_digest(case)


def write_toml(folder: Path, case: DamperCase) -> Path:
    """The case as a run folder holds it, with the files that it names."""
    for name, text in case.files.items():
        (folder / name).write_text(text, encoding="utf-8")
    path = folder / "case.toml"
    path.write_text(case.to_toml(), encoding="utf-8")
    return path


def test_a_table_of_modes_goes_into_the_run_folder(tmp_path):
    """Copied with the case; a mode of the table is one of mass, frequency and damping ratio."""
    (tmp_path / "two.csv").write_text(HEAD + "80,0.02,3.1622776601683795\n300,0.01,0.5\n",
                                      encoding="utf-8")  # fmt: skip
    modes = dict.fromkeys(HOST) | {"host.modes": "two.csv"}
    case = load(tmp_path, {**FORCED, **modes})
    folder = tmp_path / "copy"
    folder.mkdir()
    again = DamperCase.load(write_toml(folder, case))
    assert protocol.run_digest(again) == protocol.run_digest(case)
    assert case.amplitude == pytest.approx(load(tmp_path, FORCED).amplitude, rel=0.05)


def test_an_amplitude_is_steady_where_ten_cycles_change_it_by_less_than_half_a_percent():
    cycles = np.arange(60.0)
    assert not keeps_amplitude(np.ones(19))
    assert keeps_amplitude(np.ones(20))
    assert not keeps_amplitude(1 + 0.1 * np.exp(-cycles[:30] / 30))
    assert keeps_amplitude(1 + 0.01 * np.exp(-cycles / 30))


@pytest.mark.parametrize("ratio", [0.02, 0.0005])
def test_a_forced_host_is_judged_when_its_start_is_forgotten(ratio, tmp_path):
    """exp(-2 pi zeta n) = 0.01 at its own frequency, and twenty cycles more are judged.

    At zeta = 0.0005 ten cycles change what the start left by 3 %, and so pass for steady at 16 % of
    the amplitude.
    """
    left_out = {"run.cycles": None, "run.discard": None, "host.damping_ratio": ratio}
    run = load(tmp_path, {**FORCED, **left_out}).settings.run
    forgets = math.ceil(math.log(100) / (2 * math.pi * ratio))
    assert (run.steady, run.discard) == (True, forgets)
    assert run.max_cycles > forgets + 20
    of_few = load(tmp_path, {**FORCED, **left_out, "run.max_cycles": forgets + 19})
    assert f"takes {forgets} to fall to 1 %" in too_early(of_few, forgets + 19)
    assert f"--max-cycles {forgets + 20}" in too_early(of_few, forgets + 19)
    assert too_early(of_few, forgets + 20) is None
    undamped = {"host.damping_ratio": 0.0, "motion.frequency": 60.0}
    assert "no damping" in too_early(load(tmp_path, {**FORCED, **left_out, **undamped}), 1000)


@pytest.mark.parametrize("shape", ["sphere:5mm", "prolate:1.5"])
def test_a_forced_host_goes_on_until_it_is_steady_whatever_the_particles(shape, tmp_path):
    """The thesis's 18 cycles of particles that are no spheres are those of a prescribed motion."""
    usual = {"run.cycles": None, "run.discard": None, "particles.shape": shape}
    assert load(tmp_path, {**FORCED, **usual}).settings.run.steady
    shock = {"excitation.kind": "shock", "excitation.amplitude": "9 g",
             "excitation.length": "5 ms", "motion.frequency": None, "motion.gamma": None,
             "output.samples": None}  # fmt: skip
    assert load(tmp_path, {**usual, **shock}).settings.run.cycles == 20


def test_a_run_on_a_host_stopped_many_times_ends_with_the_same_bits(tmp_path, monkeypatch):
    """Checkpoints hold the modes' state; the amplitudes so far decide when it is steady."""
    monkeypatch.setattr(vibration, "CHECKPOINT_WORK", 10 * 20 * 50 + 1)  # every ten samples
    length = {"run.cycles": None, "run.discard": None, "run.max_cycles": 30}
    case = load(tmp_path, {**FORCED, **length})
    protocol.run(case, out=tmp_path / "whole")
    chance, stops, result = random.Random(5), 0, None
    while result is None:
        try:
            result = protocol.run(case, out=tmp_path / "parts", stop=lambda: chance.random() < 0.03)
        except Stopped:
            stops += 1
    assert stops > 3
    assert_same_run(the_run(tmp_path / "parts"), the_run(tmp_path / "whole"))
    assert result.host["reduction"] < 1
    # 30 of the 57 cycles that it takes: None where the last ten keep the amplitude, which hangs on
    # how the processor rounds.
    assert not result.steady
    assert abs(result.host["energy_closure"]) < 2e-2  # steps of 5 us on soft spheres
    # Gamma of what the enclosure does, not of the bare host.
    gamma = (2 * np.pi * 80.0) ** 2 * result.host["amplitude_m"] / 9.81
    assert result.gamma == pytest.approx(gamma, rel=1e-9)


def test_a_forced_host_whose_start_counts_says_so(tmp_path):
    """Damping of 2 %: ln 100/(2 pi 0.02) = 37 cycles until its start is down to a hundredth."""
    few = protocol.run(load(tmp_path, {**FORCED, "run.cycles": 4}), out=tmp_path / "few")
    assert "takes 37 to fall to 1 %" in few.steady_note
    case = load(tmp_path, {**FORCED, "run.cycles": 41, "run.discard": 37})
    assert protocol.run(case, out=tmp_path / "many").steady_note is None


def test_pictures_have_the_amplitude_of_the_results(tmp_path):
    """Made cycles, whose size and phase differ: the two that are discarded are in neither."""
    case = load(tmp_path, {**FORCED, "run.cycles": 5})
    sizes = np.repeat([9.0, 7.0, 2.0, 1.0 + 1.0j, 1.0j], case.settings.output.samples)
    time = case.period / case.settings.output.samples * np.arange(len(sizes) + 1)
    turned = np.concatenate([sizes[:1], sizes]) * np.exp(2j * np.pi * time / case.period)
    samples = {"time": time, "displacement": turned.real, "host_energy": time}
    summary = {"cycles": 5, "discarded": 2}
    scene = Scene(Trajectory(samples, {}, {}, []), None, case.settings, summary)
    found = Cycles(case, samples, 2)
    assert found.amplitude == pytest.approx(abs(3 + 2j) / 3, rel=1e-9)
    assert scene.peak_speed == pytest.approx(found.peak_speed, rel=1e-12)


def test_a_free_decay_ends_when_it_is_over_and_is_drawn(tmp_path):
    """From the command: JSON of the host, its picture, columns in the tables."""
    path = write_damper(tmp_path, {**LET_GO, "run.cycles": None, "run.discard": None})
    done = damper3d("run", path, "--out", tmp_path / "runs", "--json", "--quiet", "--no-figures")
    assert done.code == 0, done.err
    host = json.loads(done.out)["host"]
    assert host["amplitude_m"] is None
    assert 0 < host["decay_times_s"]["0.5"] < host["decay_times_s"]["0.2"]
    assert host["added_damping_ratio"] > 0
    folder = the_run(tmp_path / "runs").path
    assert damper3d("observe", folder, "host").code == 0
    assert damper3d("render", folder, "--no-film").code == 0
    assert (folder / "figures" / "host.png").stat().st_size > 10_000
    assert damper3d("export", folder, "--to", "csv", "-o", tmp_path / "csv").code == 0
    assert "host_energy" in (tmp_path / "csv" / "samples.csv").read_text(encoding="utf-8")


def test_a_free_decay_that_is_soon_over_goes_on_until_a_cycle_counts(tmp_path):
    """At zeta = 0.5 it is over after a cycle or two, and six do not count."""
    case = load(tmp_path, {**LET_GO, "host.damping_ratio": 0.5, "run.cycles": 20, "run.discard": 6})
    result = protocol.run(case, out=tmp_path / "runs")
    assert (result.cycles, result.discarded) == (7, 6)


def test_a_run_without_a_host_has_no_response(damper_reference, tmp_path):
    assert_refused(damper3d("observe", damper_reference.path, "host"), "prescribed", "[host]")


def test_init_writes_a_host_that_runs(tmp_path):
    path = tmp_path / "mine.toml"
    assert damper3d("init", path, "--host").code == 0
    shown = damper3d("run", path, *DRY, "--json")
    assert json.loads(shown.out)["frequency_hz"] == 20.0


@pytest.mark.validation  # compiles kernels of its own
def test_a_host_that_twists_is_the_bare_one_where_nothing_rubs(tmp_path):
    """Without friction the walls turn past the bed: amplitude T/(2 zeta I w^2) R at resonance.

    To the 1e-6 that the bed's normal forces, which have no torque on round walls, leave of it.
    """
    smooth = {**TWISTED, "law.friction": 0.0, "law.friction_wall": 0.0, "run.max_cycles": 25}
    result = protocol.run(load(tmp_path, smooth), out=tmp_path / "runs")
    omega = 2.0 * np.pi * 80.0
    angle = 1e-3 / (2 * 0.02 * 1e-6 * omega**2)
    assert result.host["bare_amplitude_m"] == pytest.approx(0.01 * angle, rel=1e-9)
    assert result.host["reduction"] == pytest.approx(1.0, abs=1e-6)
    assert result.host["amplitude_rad"] == pytest.approx(angle, rel=1e-6)


@pytest.mark.validation  # compiles kernels of its own
def test_a_host_that_twists_gives_the_bed_what_it_loses(tmp_path):
    """Friction carries the bed along: the energy of both is closed, and the response falls.

    By what the damping ratio that the bed adds makes of a resonance, zeta/(zeta + zeta_added), but
    for the inertia that it adds, whose detuning is of second order: to 2 %.
    """
    settled = {**TWISTED, "run.cycles": 80, "run.discard": 60}  # the host forgets in some eight
    result = protocol.run(load(tmp_path, settled), out=tmp_path / "runs")
    added = result.host["added_damping_ratio"]
    assert added > 2e-4
    assert result.host["reduction"] == pytest.approx(0.02 / (0.02 + added), rel=0.02)
    assert abs(result.host["energy_closure"]) < 1e-3
    assert result.efficiency is None
    assert "rotation" in result.efficiency_note
    assert result.phase is None
    again = DamperCase.load(the_run(tmp_path / "runs").case_file)
    assert protocol.run_digest(again) == protocol.run_digest(load(tmp_path, settled))


@pytest.mark.validation  # compiles kernels of its own
def test_a_twist_that_is_cut_off_goes_on_with_its_bits(tmp_path):
    case = load(tmp_path, {**TWISTED, "run.cycles": 6})
    protocol.run(case, out=tmp_path / "whole")
    seen = iter([False] * 5 + [True] * 10_000)
    with pytest.raises(Stopped):
        protocol.run(case, out=tmp_path / "cut", stop=lambda: next(seen))
    protocol.resume(the_run(tmp_path / "cut").path)
    assert_same_run(the_run(tmp_path / "whole"), the_run(tmp_path / "cut"))
