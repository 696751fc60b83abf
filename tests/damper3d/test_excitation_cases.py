"""Cases with an excitation: what is refused, what follows, runs that go on with their bits."""

import json
from pathlib import Path

import numpy as np
import pytest
from fake_damper_run import write_fake_damper_run
from refusals import assert_refuses
from same_run import assert_same_run
from small_damper import damper3d, write_damper
from small_silo import DRY, the_run

from damper3d.case.case import DamperCase
from damper3d.case.plan import warnings
from damper3d.case.settings import MOST_SAMPLES, Excitation
from damper3d.measures import host
from damper3d.measures.counted import Cycles
from damper3d.run import protocol
from damper3d.view.report import echo
from damper3d.view.scene import read_scene
from granulab.errors import Stopped

PLAIN = dict.fromkeys(
    ("motion.frequency", "motion.gamma", "run.cycles", "run.discard", "output.samples")
)
SINES = {**PLAIN, "excitation.kind": "sines", "excitation.frequencies": [80, 120],
         "excitation.amplitudes": ["6 g", "4 g"], "run.cycles": 4, "run.discard": 2}  # fmt: skip
CROSSED = {**SINES, "excitation.across": [1, 0, 0], "excitation.across_amplitudes": ["1 g", "1 g"]}
ROTATION = {**PLAIN, "excitation.kind": "rotation", "excitation.frequencies": [80],
            "excitation.amplitudes": ["20 deg"], "run.cycles": 4, "run.discard": 2}  # fmt: skip
SWEEP = {**PLAIN, "excitation.kind": "sweep", "excitation.from_frequency": 60,
         "excitation.to_frequency": 120, "excitation.amplitude": "6 g",
         "excitation.length": "0.2 s"}  # fmt: skip
RANDOM = {**PLAIN, "excitation.kind": "random", "excitation.psd": [[60, 0.1], [240, 0.1]],
          "excitation.length": "0.1 s"}  # fmt: skip
SHOCK = {**PLAIN, "excitation.kind": "shock", "excitation.amplitude": "40 g",
         "excitation.length": "5 ms"}  # fmt: skip
SIGNAL = {**PLAIN, "excitation.kind": "signal", "excitation.file": "signal.csv"}
HOST = {"host.mass": "0.1 kg", "host.frequency": 80.0, "host.damping_ratio": 0.02}
_OWN_KERNELS = pytest.mark.validation  # half a minute to compile
ON_HOST = {
    "sweep": {**SWEEP, **HOST, "excitation.amplitude": "0.5 N"},
    "random": {**RANDOM, **HOST, "excitation.on": "base"},
    "shock": {**SHOCK, **HOST, "excitation.amplitude": "60 N"},
}


def load(folder: Path, changes) -> DamperCase:
    return DamperCase.load(write_damper(folder, changes))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"excitation.on": "enclosure"}, ["[excitation] kind is missing", "sines"]),
        ({**SINES, "excitation.kind": "noise"}, ["kind", "'noise'"]),
        ({**SINES, "excitation.frequencies": None}, ["frequencies is missing", "sines"]),
        ({**SINES, "excitation.amplitudes": ["6 g"]}, ["amplitudes: 1 of them, and 2"]),
        ({**SINES, "excitation.amplitudes": ["6 g", "4 K"]}, ["amplitudes = '4 K'", "unit"]),
        ({**SINES, "excitation.amplitudes": ["6 g", "4 N"]}, ["'4 N'", "acts as enclosure"]),
        ({**SINES, "excitation.amplitudes": ["6 g", "-4 g"]}, ["'-4 g'", "above 0"]),
        ({**SINES, "excitation.amplitudes": ["6 g", "4"]}, ["'4'", "unit is missing"]),
        ({**SINES, "excitation.frequencies": [80, 80]}, ["stands twice"]),
        ({**SWEEP, "excitation.steps": 12}, ["steps = 12", "held for 0.0167 s", "fewer steps"]),
        (
            {**SINES, "excitation.frequencies": [80, 80.001], "run.cycles": None},
            ["0.001 Hz apart", "1000 s", "[run] cycles"],
        ),
        ({**SINES, "excitation.frequencies": [80, -1]}, ["frequencies", "greater than 0"]),
        ({**SINES, "excitation.phases": ["1 s", "0 deg"]}, ["phases = '1 s'"]),
        ({**SINES, "excitation.across_amplitudes": ["1 g", "1 g"]}, ["across is missing"]),
        ({**SINES, "excitation.across": [0, 0, 0]}, ["across", "no direction"]),
        (
            {**CROSSED, "excitation.across": [1, 0, 1]},
            ["across = [1.0, 0.0, 1.0]", "at right angles", "such as [0.707107, 0.0, 0.0]"],
        ),
        ({**CROSSED, "excitation.across": [0, 0, 2]}, ["at right angles", "give another"]),
        ({**SINES, "excitation.psd": [[1, 1], [2, 1]]}, ["psd is no key", "frequencies"]),
        ({**SINES, "motion.gamma": 3.0}, ["[motion] gamma", "stands in its place"]),
        ({**SINES, "motion.ramp": 2}, ["[motion] ramp"]),
        ({**SINES, "run.steady": True}, ["[run] steady"]),
        ({**SINES, "excitation.on": "force"}, ["on = 'force' moves a host"]),
        ({**SINES, **HOST, "excitation.on": "enclosure"}, ["on = 'enclosure'", "give 'force'"]),
        ({**SINES, **HOST}, ["'6 g'", "acts as force", "'2 N'"]),
        ({**ON_HOST["sweep"], "host.force": "1 N"}, ["[host] force", "stands in its place"]),
        ({**ROTATION, "excitation.amplitudes": ["2 mm"]}, ["amplitudes = '2 mm'", "unit"]),
        ({**ROTATION, **HOST}, ["rotation", "leave [host] out"]),
        ({**ROTATION, "motion.direction": [1, 0, 0]}, ["rotation", "leave [motion] direction"]),
        (
            {**ROTATION, "enclosure.shape": "box", "enclosure.diameter": None,
             "enclosure.width": "20 mm"},
            ["a box would move through the bed", "'cylinder'"],
        ),
        ({**SWEEP, "excitation.to_frequency": 60}, ["are the same"]),
        ({**SWEEP, "excitation.length": None}, ["octaves_per_minute or length"]),
        (
            {**SWEEP, "excitation.length": None, "excitation.octaves_per_minute": 2,
             "excitation.spacing": "linear"},
            ["spacing = 'logarithmic'"],
        ),
        ({**SWEEP, "excitation.length": "1 ms"}, ["less than a cycle"]),
        ({**SWEEP, "excitation.length": "1 Ms"}, ["cycles of the highest frequency"]),
        ({**SWEEP, "run.cycles": 7}, ["[run] cycles", "stands in its place"]),
        ({**RANDOM, **HOST}, ["on is missing", "'base' takes psd in g2/Hz", "N2/Hz"]),
        ({**RANDOM, "excitation.psd": [[60, 0.1], [240, -0.1]]}, ["density = -0.1 at 240 Hz"]),
        ({**RANDOM, "excitation.psd": [[60, 0.1], [240, 0]]}, ["density = 0 at 240 Hz"]),
        ({**RANDOM, "excitation.psd": [[-60, 0.1], [240, 1]]}, ["frequency = -60 Hz"]),
        ({**RANDOM, "excitation.psd": [[60, 0.1], [20, 1]]}, ["must rise"]),
        ({**RANDOM, "excitation.psd": [[60, 0.1]]}, ["psd"]),
        ({**RANDOM, "excitation.psd": "none.csv"}, ["none.csv", "no such file", "psd = [["]),
        ({**RANDOM, "excitation.psd": [[60, 0.1], [240]]}, ["psd"]),
        ({**RANDOM, "excitation.length": "0.3"}, ["length = '0.3'", "unit is missing"]),
        ({**SHOCK, "excitation.pulse": "triangle"}, ["pulse"]),
        ({**SHOCK, "excitation.amplitude": "40 kg"}, ["'40 kg'", "unit is wrong here"]),
        ({**SIGNAL, "excitation.file": "none.csv"}, ["none.csv", "no such file"]),
        ({**SIGNAL, "excitation.full_scale": "2 g"}, ["full_scale goes with a WAV file"]),
        ({**SIGNAL, "excitation.column": "speed"}, ["column = 'speed'"]),
    ],
)  # fmt: skip
def test_excitations_that_cannot_be_are_refused_in_a_line(changes, words, tmp_path):
    (tmp_path / "signal.csv").write_text(recording(), "utf-8")
    assert_refuses(words, load, tmp_path, changes)


def test_sines_that_beat_count_for_a_beat(tmp_path):
    """20 and 20.1 Hz have no common period within 50 cycles, and beat in 10 s, 200 cycles."""
    sines = {**SINES, "excitation.frequencies": [20.0, 20.1], "run.cycles": None,
             "run.discard": None}  # fmt: skip
    found = load(tmp_path, sines).excitation
    assert (found.windows - found.discard) * found.window == pytest.approx(10.0)
    on_host = load(tmp_path, sines | HOST | {"excitation.amplitudes": ["1 N", "2 N"]}).excitation
    assert (on_host.windows - on_host.discard) * on_host.window == pytest.approx(10.0)
    given = load(tmp_path, sines | {"run.cycles": 12, "run.discard": 2}).excitation
    assert (given.windows, given.discard) == (12, 2)


@pytest.mark.parametrize("band", [[98.0, 102.0], [100.2, 100.8]])
def test_a_narrow_band_has_ten_lines_at_least(band, tmp_path):
    """Its width over the distance of lines, whose power is that of the band, to rounding."""
    psd = [[frequency, 0.1] for frequency in band]
    changes = {**RANDOM, "excitation.psd": psd, "excitation.length": None}
    found = load(tmp_path, changes).excitation
    assert len(found.lines.omega) >= 10
    assert found.band_error == pytest.approx(0.0, abs=1e-9)


def test_a_short_shock_on_a_slow_host_is_sampled_in_parts(tmp_path):
    """Half a millisecond on 5 Hz: 16 samples of 4 kHz for 0.2 s, in more windows than cycles."""
    changes = ON_HOST["shock"] | {"host.frequency": 5.0, "excitation.length": "0.5 ms"}
    found = load(tmp_path, changes).excitation
    assert found.samples <= MOST_SAMPLES
    assert found.samples / found.window >= 16 * 4000
    left = np.log(10.0) / (0.02 * 2 * np.pi * 5.0)  # [s] until a tenth of the bare motion is left
    assert found.windows * found.window == pytest.approx(0.2 * (1 + np.ceil(left / 0.2)))


def recording(rate: float = 2000.0, head: str = "time [s],acceleration [g]") -> str:
    time = np.arange(200) / rate
    values = 8.0 * np.sin(2.0 * np.pi * 80.0 * time)
    return "\n".join([head, *(f"{t:.6f},{v:.9f}" for t, v in zip(time, values, strict=True))])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("time [s],acceleration [g]\n0,1\n", ["1 values"]),
        ("t,a\n0,1\n1,2\n2,1\n", ["'time [s]' is missing"]),
        ("time [s],acceleration\n0,1\n1,2\n2,1\n", ["acceleration", "unit"]),
        ("time [s],a [g],b [g]\n0,1,1\n1,2,2\n2,1,1\n", ["2 columns", "a, b"]),
        ("time [s],a [g]\n0,1\n1,x\n2,1\n", ["line 3", "no two numbers"]),
        ("time [s],a [g]\n0,1\n1,2\n3,1\n", ["times are not even"]),
        ("time [s],a [g]\n0,1\n1,1\n2,1\n", ["nothing but one value"]),
        ("time [s],a [g]\n0,1\n1,nan\n2,1\n", ["no finite numbers"]),
        ("time [s],a [N]\n0,1\n1,2\n2,1\n", ["acts as enclosure"]),
    ],
)
def test_tables_of_signals_that_cannot_be_are_refused_in_a_line(text, words, tmp_path):
    (tmp_path / "signal.csv").write_text(text, "utf-8")
    assert_refuses(words, load, tmp_path, SIGNAL)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (b"", ["two breakpoints"]),
        (b"\xff\xfe\x80", ["no CSV table"]),
        (b"20,0.1\n60,x\n", ["line 2", "no two numbers"]),
        (b"20,0.1\n60,nan\n", ["density = nan at 60 Hz"]),
        (b"frequency [Hz],psd [N^2/Hz]\n20,0.1\n60,0.1\n", ["'N^2/Hz'", "g^2/Hz is needed"]),
        (b"frequency [rad/s],psd\n20,0.1\n60,0.1\n", ["'rad/s'", "Hz is needed"]),
    ],
)
def test_tables_of_densities_that_cannot_be_are_refused_in_a_line(text, words, tmp_path):
    (tmp_path / "psd.csv").write_bytes(text)
    assert_refuses(words, load, tmp_path, {**RANDOM, "excitation.psd": "psd.csv"})


def test_a_table_of_a_density_is_that_density(tmp_path):
    """With a head that names the units, and remarks: the power is that of the breakpoints."""
    text = "# a shaker's\nfrequency [Hz],psd [g\u00b2/Hz]\n60,0.1\n\n240,0.1\n"
    (tmp_path / "psd.csv").write_text(text, "utf-8")
    cases = [load(tmp_path, {**RANDOM, **own}) for own in ({"excitation.psd": "psd.csv"}, {})]
    assert cases[0].excitation.breakpoints == cases[1].excitation.breakpoints


def test_a_signal_of_a_wav_file_is_that_of_its_table(tmp_path):
    """To the 16 bits of the file: 10 g over 2^15, and no less than an eighth of that."""
    from scipy.io import wavfile

    time = np.arange(200) / 2000
    values = 8.0 * np.sin(2.0 * np.pi * 80.0 * time)
    wavfile.write(tmp_path / "signal.wav", 2000, np.rint(values / 10.0 * 2**15).astype(np.int16))
    (tmp_path / "signal.csv").write_text(recording(), "utf-8")
    table = load(tmp_path, SIGNAL)
    wav = load(tmp_path, {**SIGNAL, "excitation.file": "signal.wav",
                          "excitation.full_scale": "10 g"})  # fmt: skip
    assert wav.settings.motion.gamma == pytest.approx(table.settings.motion.gamma, abs=2e-3)
    assert table.settings.motion.gamma == pytest.approx(8.0 * 9.80665 / 9.81, rel=0.01)


@pytest.mark.parametrize(
    "changes", [SINES, ROTATION, SWEEP, RANDOM, SHOCK, SIGNAL, *ON_HOST.values()],
    ids=["sines", "rotation", "sweep", "random", "shock", "signal",
         *(f"{kind} on host" for kind in ON_HOST)],
)  # fmt: skip
def test_a_case_in_a_run_folder_is_the_case_itself(changes, tmp_path):
    (tmp_path / "signal.csv").write_text(recording(), "utf-8")
    case = load(tmp_path, changes)
    folder = tmp_path / "run"
    folder.mkdir()
    for name, text in {**case.files, "case.toml": case.to_toml()}.items():
        (folder / name).write_text(text, "utf-8")
    again = DamperCase.load(folder / "case.toml")
    assert protocol.run_digest(again) == protocol.run_digest(case)
    assert again.peaks == case.peaks


def test_a_recording_that_begins_with_a_kick_or_has_an_offset_is_warned_of(tmp_path):
    """A sine a of acceleration has a/omega = 0.156 m/s at its start; a cosine none.

    The trapezoidal rule takes (w h)^2/12 of it. An offset of 0.8 g is a tenth of 8 g.
    """

    def told(values, **more):
        rows = "\n".join(f"{k / 2000:.6f},{v:.9f}" for k, v in enumerate(values))
        (tmp_path / "signal.csv").write_text(f"time [s],acceleration [g]\n{rows}\n", "utf-8")
        case = load(tmp_path, {**SIGNAL, **more})
        about = [line for line in warnings(case) if "[excitation]" in line]
        return about, echo(case, dry_run=True)

    angle = 2.0 * np.pi * 80.0 * np.arange(201) / 2000.0  # eight cycles
    kicks, printed = told(8.0 * np.sin(angle))
    assert len(kicks) == 1
    assert "begins at 0.155 m/s, 100 % of its largest velocity" in kicks[0]
    assert "begins at -0.155 m/s" in printed
    assert told(8.0 * np.sin(angle), **{"excitation.integration": "as_measured"})[0] == []
    assert told(8.0 * np.cos(angle))[0] == []
    offset, _ = told(8.0 * np.cos(angle) + 0.8)
    assert len(offset) == 1
    assert "a mean of 7.85 m/s2 is taken off" in offset[0]
    assert "10 %" in offset[0]


def test_pictures_and_exports_move_the_enclosure_along_both_directions(tmp_path):
    """As the second motion's closed form has it, at the frames of a run that is drawn."""
    made = write_fake_damper_run(tmp_path / "run", frequency=40.0, cycles=4)
    case = load(tmp_path, CROSSED)
    made.write_case(case.to_toml())
    for name, text in case.files.items():
        (made.path / name).write_text(text, encoding="utf-8")
    scene = read_scene(made.path)
    second = sum(
        9.81 / (2 * np.pi * f) ** 2 * np.sin(2 * np.pi * f * scene.time) for f in (80, 120)
    )
    second -= second.mean()
    along = scene.trajectory["displacement"]
    moved = scene.way[:, 0] - scene.way[:, 0].mean()
    assert moved == pytest.approx(second, abs=1e-3 * np.ptp(second))
    assert np.array_equal(scene.way[:, 2], along)
    assert np.array_equal(scene.shift(3), scene.way[scene.frame_sample[3]])
    refused = damper3d("export", made.path, "--to", "shaker")
    assert refused.code == 2
    assert "turns or moves along two directions; take --to csv" in refused.err


OTHERS = {
    "frequencies": (SINES, [80, 160]), "amplitudes": (SINES, ["6 g", "5 g"]),
    "phases": (SINES, ["0 deg", "9 deg"]), "across": (CROSSED, [0, 1, 0]),
    "across_amplitudes": (CROSSED, ["1 g", "2 g"]), "across_phases": (CROSSED, ["1 deg", "0 deg"]),
    "from_frequency": (SWEEP, 50), "to_frequency": (SWEEP, 110), "amplitude": (SHOCK, "41 g"),
    "spacing": (SWEEP, "linear"), "length": (SWEEP, "0.3 s"), "steps": (SWEEP, 2),
    "and_back": (SWEEP, True), "psd": (RANDOM, [[60, 0.2], [240, 0.1]]), "seed": (RANDOM, 2),
    "pulse": (SHOCK, "terminal_peak"), "integration": (SIGNAL, "as_measured"),
    "on": (ON_HOST["random"], "force"), "kind": (None, None), "file": (None, None),
    "column": (None, None), "full_scale": (None, None), "octaves_per_minute": (None, None),
}  # fmt: skip


def test_every_key_that_acts_names_another_run(tmp_path):
    """Those without a case act by the numbers that come of them, in the tests above."""
    (tmp_path / "signal.csv").write_text(recording(), "utf-8")
    assert OTHERS.keys() == Excitation.model_fields.keys()
    for key, (case, value) in OTHERS.items():
        if case is None:
            continue
        changed = {**case, f"excitation.{key}": value}
        if key == "on":
            changed["excitation.psd"] = [[60, 0.1], [240, 0.1]]
        digests = {protocol.run_digest(load(tmp_path, one)) for one in (case, changed)}
        assert len(digests) == 2, key


@pytest.mark.validation  # compiles kernels of its own
def test_a_random_run_that_is_cut_off_goes_on_with_its_bits(tmp_path):
    file = write_damper(tmp_path, RANDOM)
    protocol.run(DamperCase.load(file), out=tmp_path / "whole")
    seen = iter([False] * 5 + [True] * 10_000)
    with pytest.raises(Stopped):
        protocol.run(DamperCase.load(file), out=tmp_path / "cut", stop=lambda: next(seen))
    protocol.resume(the_run(tmp_path / "cut").path)
    assert_same_run(the_run(tmp_path / "whole"), the_run(tmp_path / "cut"))


def test_efficiency_under_one_sine_is_that_of_the_thesis(tmp_path):
    """A sum of one sine is the prescribed motion: reference and energies are the same.

    Its samples are as many; the sine has its extremes at samples, but for the parabolas.
    """
    sine = {"motion.gamma": 10.0, "motion.frequency": 80.0, "output.samples": 100}
    one = {**PLAIN, "excitation.kind": "sines", "excitation.frequencies": [80],
           "excitation.amplitudes": [f"{10.0 * 9.81!r} m/s2"],
           "run.cycles": 4, "run.discard": 2}  # fmt: skip
    prescribed, summed = (
        protocol.run(load(tmp_path, changes), out=tmp_path / "runs") for changes in (sine, one)
    )
    assert summed.state_digest == prescribed.state_digest
    assert summed.efficiency_with_settling == pytest.approx(
        prescribed.efficiency_with_settling, rel=1e-9
    )
    assert summed.loss_factor is None
    assert summed.phase is None


@pytest.mark.validation  # compiles kernels of its own
def test_energy_is_kept_where_two_motions_cross(tmp_path):
    """The balance closes as along one direction, below 1 %: work is force times both velocities."""
    crossed = {**SINES, "excitation.across": [1, 0, 0],
               "excitation.across_amplitudes": ["6 g", "4 g"]}  # fmt: skip
    both = protocol.run(load(tmp_path, crossed), out=tmp_path / "runs")
    assert abs(both.energy_closure) < 0.01
    one = protocol.run(load(tmp_path, SINES), out=tmp_path / "runs")
    assert both.excitation["most_energy_j"] == pytest.approx(
        2.0 * one.excitation["most_energy_j"], rel=1e-9
    )
    for size in ("peak_displacement_m", "peak_velocity_m_s", "rms_acceleration_m_s2"):
        assert both.excitation[size] == pytest.approx(2**0.5 * one.excitation[size], rel=1e-9)


def test_an_enclosure_that_turns_gives_the_energy_that_the_bed_takes(tmp_path):
    """The balance closes below 1 %; the bed is stirred, and has no efficiency."""
    turned = protocol.run(load(tmp_path, ROTATION), out=tmp_path / "runs")
    assert abs(turned.energy_closure) < 0.01
    assert turned.efficiency is None
    assert "rotation" in turned.efficiency_note
    assert turned.dissipated_power_w > 0
    rim = 0.01 * np.deg2rad(20.0) * 2.0 * np.pi * 80.0
    assert turned.excitation["peak_velocity_m_s"] == pytest.approx(rim, rel=1e-6)


@pytest.mark.parametrize(("shapes", "wanted"), [((0.05, 3.0), 1), ((3.0, 0.05), 0), ((0, 3), 1)])
def test_the_added_damping_is_that_of_the_mode_with_most_of_the_bare_response(
    shapes, wanted, tmp_path
):
    """A sweep over both modes: their responses go as the square of the shape, here over 3600."""
    rows = [f"{f},0.02,{shape}" for f, shape in zip((70, 110), shapes, strict=True)]
    head = "frequency [Hz],damping_ratio,shape [kg^-0.5]"
    (tmp_path / "modes.csv").write_text("\n".join([head, *rows]) + "\n", "utf-8")
    case = load(tmp_path, {**SWEEP, "host.modes": "modes.csv", "excitation.amplitude": "0.5 N"})
    per_cycle = case.settings.output.samples
    spacing = case.time_step * case.steps_per_sample
    time = spacing * np.arange(per_cycle * case.excitation.windows + 1)
    samples = {"time": time, "velocity": np.sin(time), "wall_work": 0.1 * time}
    cycles = Cycles(case, samples, 0)
    assert host.leading_mode(cycles) == wanted
    own = host.added_to_mode(cycles, wanted)
    assert own["added_damping_mode_hz"] == pytest.approx((70.0, 110.0)[wanted])
    assert own["added_damping_ratio"] > 0
    other = host.added_to_mode(cycles, 1 - wanted)["added_damping_ratio"]
    assert (other is None) == (shapes[1 - wanted] == 0)


@pytest.mark.parametrize("kind", ["sweep", "shock", pytest.param("random", marks=_OWN_KERNELS)])
def test_a_host_under_an_excitation_closes_its_energy(kind, tmp_path):
    """Of host and bed below 1e-3 of what moved them, as structure.md asks."""
    result = protocol.run(load(tmp_path, ON_HOST[kind]), out=tmp_path / "runs")
    assert abs(result.host["energy_closure"]) < 1e-3
    assert result.host["rms_m"] > 0
    assert (result.excitation["sweep"] is not None) == (kind == "sweep")
    assert (result.host["decay_times_s"] is not None) == (kind == "shock")


@pytest.mark.parametrize("and_back", [False, True])
def test_windows_of_a_stepped_sweep_hold_one_frequency(and_back, tmp_path):
    """Each of twelve has as many; their middles lie behind the change from the frequency before."""
    stepped = {**SWEEP, "excitation.length": "6 s", "excitation.steps": 12,
               "excitation.and_back": and_back}  # fmt: skip
    own = load(tmp_path, stepped).excitation
    ways = 2 if and_back else 1
    each = own.windows // (12 * ways)
    assert own.windows == 12 * ways * each
    middle = own.window * (np.arange(own.windows) + 0.5)
    assert own.sweep.is_held(middle).all()
    there = np.geomspace(60.0, 120.0, 12)
    held = np.concatenate([there, there[::-1]]) if and_back else there
    assert np.allclose(own.sweep.frequency(middle), np.repeat(held, each), rtol=1e-12)


@pytest.mark.parametrize("kind", ["sines", "sweep", "random", "shock"])
def test_init_writes_cases_with_excitations_that_a_run_takes(kind, tmp_path):
    file = tmp_path / "mine.toml"
    assert damper3d("init", file, f"--{kind}").code == 0
    done = damper3d("run", file, *DRY, "--json")
    assert done.code == 0, done.err
    assert json.loads(done.out)["amplitude_m"] > 0


def test_a_run_under_an_excitation_is_told_drawn_and_measured(tmp_path):
    file = write_damper(tmp_path, SWEEP)
    done = damper3d("run", file, "--out", tmp_path / "runs", "--quiet")
    assert done.code == 0, done.err
    assert "sweep: largest displacement" in done.out
    folder = the_run(tmp_path / "runs")
    assert (folder.figures / "excitation.png").exists()
    seen = damper3d("observe", folder.path, "excitation", "--json")
    assert json.loads(seen.out)["kind"] == "sweep"
