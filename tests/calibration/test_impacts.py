"""Impacts in signals: times and T(k+1)/T(k) (thesis, eq. 7.5) of made bounces and a recording."""

import json
import os
import tomllib
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from made_signals import Bounces, Room, half_sine, hertz, tone, write_csv, write_wav

from calibration import measure_impacts
from calibration.commands.main import app
from calibration.impacts.ratios import restitution
from calibration.impacts.sequence import bouncing, weakness
from granulab.contact.material import Measured
from granulab.errors import InputError

MEDIA = Path(os.environ.get("GRANULAB_MEDIA", Path(__file__).parents[3] / "shared" / "media"))
BOUNCES = Bounces(restitution=0.8, n=5)
NEAR = 2e-3  # [s] the window over which energy is taken: a false impact is further off


def wav(tmp_path, room, bounces=BOUNCES, seed=1, kind="int16"):
    return write_wav(tmp_path / "made.wav", room.record(bounces, seed), room.rate, kind)


def assert_impacts_are(found, bounces):
    assert len(found.times_s) == bounces.n, found.times_s
    assert np.abs(found.times_s - bounces.times).max() < NEAR


def test_recorded_sound_gives_its_reference():
    """Times to 2 ms and ratios to 0.005: the uncertainty of who measured the reference by hand."""
    path = MEDIA / "Audio_1.wav"
    if not path.exists():
        pytest.skip(f"{path} is not here: recordings of others are not part of the project")
    found = measure_impacts(path)
    assert found.times_s == pytest.approx([0.5474, 1.1002, 1.5456, 1.9076, 2.1994], abs=2e-3)
    assert found.restitution.per_pair == pytest.approx([0.806, 0.813, 0.806], abs=5e-3)


@pytest.mark.parametrize(
    "room",
    [
        Room(),
        Room(rate=8000.0, options={"frequency": 1000.0}),
        Room(rate=96000.0),
        Room(noise=0.03),
        Room(hum=0.1),
        Room(clip=0.4),
        Room(noise=0.0),
        Room(options={"frequency": 1800.0, "decay": 0.1}),  # rings on into the next impact
        Room(echoes=((0.006, 0.5), (0.021, 0.4), (0.05, 0.3))),  # walls at 1, 3.6 and 8.6 m
        Room(echoes=((0.01, 0.9), (0.03, 0.7), (0.07, 0.5))),  # louder with what still rings
    ],
    ids=[
        "44 kHz", "8 kHz", "96 kHz", "loud noise", "hum", "clipped", "no noise", "ringing",
        "echoes", "loud echoes",
    ],
)  # fmt: skip
def test_ringing_impacts_are_found(tmp_path, room):
    """Nothing but the impacts, and e within four of its sigmas (1 in 16 000 by chance)."""
    found = measure_impacts(wav(tmp_path, room))
    assert_impacts_are(found, BOUNCES)
    assert abs(found.restitution.value - 0.8) < 4 * found.restitution.sigma
    assert found.restitution.sigma < 1e-3


@pytest.mark.parametrize(
    ("rate", "shape", "duration"),
    [(100e3, half_sine, 1e-3), (50e3, half_sine, 1e-2), (50e3, hertz, 1e-3),
     (500.0, half_sine, 1e-2)],
)  # fmt: skip
def test_force_pulses_are_found(tmp_path, rate, shape, duration):
    bounces = Bounces(0.8, 5, first_flight=0.2, start=0.2)
    room = Room(rate=rate, shape=shape, noise=0.02, length=1.0, options={"duration": duration})
    path = write_csv(tmp_path / "force.csv", room.record(bounces, 1), rate)
    found = measure_impacts(path)
    assert_impacts_are(found, bounces)
    assert abs(found.restitution.value - 0.8) < 4 * found.restitution.sigma


@pytest.mark.parametrize("kind", ["uint8", "int16", "int32", "float32"])
def test_any_word_length_will_do(tmp_path, kind):
    found = measure_impacts(wav(tmp_path, Room(), kind=kind))
    assert_impacts_are(found, BOUNCES)


def test_the_channel_with_the_impacts_is_taken(tmp_path):
    room = Room()
    quiet = 0.1 * np.random.default_rng(2).standard_normal(round(room.length * room.rate))
    both = np.column_stack([quiet, room.record(BOUNCES, 1)])
    found = measure_impacts(write_wav(tmp_path / "stereo.wav", both, room.rate))
    assert_impacts_are(found, BOUNCES)


@pytest.mark.parametrize(
    ("e", "n", "flight"), [(0.3, 4, 0.4), (0.9, 12, 0.35), (0.95, 16, 0.3), (0.985, 20, 0.08)]
)
def test_few_and_many_bounces(tmp_path, e, n, flight):
    bounces = Bounces(e, n, flight)
    found = measure_impacts(wav(tmp_path, Room(length=5.0), bounces))
    assert_impacts_are(found, bounces)


def test_release_and_knocks_are_left_out(tmp_path):
    """A click before the fall and knocks after it have no place in the row of flights."""
    room = Room()
    x, t = room.record(BOUNCES, 1), np.arange(round(room.length * room.rate)) / room.rate
    x += tone(t - 0.05, 0.4) + tone(t - 2.3, 1.5) + tone(t - 2.6, 2.0)
    found = measure_impacts(write_wav(tmp_path / "knocks.wav", x, room.rate))
    assert_impacts_are(found, BOUNCES)
    assert len(found.rejected_times_s) == 3
    assert any("left out" in words for words in found.warnings)


@pytest.mark.parametrize(
    "rooms",
    [
        pytest.param(
            (Room(rate=22050.0, noise=0.01, length=1.7, options={"frequency": 1000.0}),
             Room(rate=44100.0, noise=0.02, length=1.7),
             Room(rate=50e3, noise=0.01, length=1.7, shape=half_sine)),
            marks=pytest.mark.validation,
        ),
        pytest.param(
            (Room(rate=50e3, noise=0.01, length=1.7, shape=hertz),
             Room(rate=50e3, noise=0.002, length=1.7, shape=hertz)),
            marks=pytest.mark.validation,
        ),
        (Room(rate=5e3, noise=0.01, length=1.7, shape=half_sine),  # 2.5 samples per rise
         Room(rate=8e3, length=1.7, options={"frequency": 1000.0}),  # 2
         Room(rate=1e3, noise=0.01, length=1.7, shape=half_sine, options={"duration": 3e-3})),
    ],
    ids=["linear", "Hertz", "few samples"],
)  # fmt: skip
def test_sigma_is_the_error(rooms):
    """68 % intervals hold the truth in 60 to 76 % of trials, over rates, noise and shapes.

    Of 150 trials, the share has a standard deviation of 4 %: the bounds are two of them away.
    """
    inside = [covers(rooms[trial % len(rooms)], trial) for trial in range(150)]
    assert 0.60 <= np.mean(inside) <= 0.76


def test_hertz_contacts_are_timed_as_well_as_their_noise_lets():
    """The rise grows as v^(-1/5): a half sine would begin 9 % of it too late, each time another.

    Noise alone leaves about noise/(height omega) sqrt(2/n) of an onset, n samples per rise: with
    1 %, 6e-6 s/sqrt(25) and for the last, weakest impacts four times that; e is off by 2/T of it.
    """
    from calibration.files.signals import Signal
    from calibration.impacts.measure import measure_signal

    room = Room(rate=50e3, noise=0.01, length=2.3, shape=hertz)
    x = room.record(Bounces(0.8, 5, 0.41), 1)
    found = measure_signal(Signal(Path("made"), x[:, None], ("x",), room.rate)).restitution
    assert found.sigma < 2.5e-5
    assert abs(found.value - 0.8) < 4 * found.sigma


def covers(room, seed):
    """Whether the interval of one made signal holds its restitution."""
    from calibration.files.signals import Signal
    from calibration.impacts.measure import measure_signal

    rng = np.random.default_rng(seed)
    # Flights are no whole number of samples, or the impacts' rounding errors would be alike.
    bounces = Bounces(rng.uniform(0.6, 0.8), 4, rng.uniform(0.36, 0.44), rng.uniform(0.3, 0.4))
    x = room.record(bounces, 1000 + seed)
    found = measure_signal(Signal(Path("made"), x[:, None], ("x",), room.rate)).restitution
    return abs(found.value - bounces.restitution) < found.sigma


def test_pairs_that_differ_are_reported():
    """e falls with speed here: chi-squared sees it, and sigma becomes that of the scatter."""
    times = Bounces((0.70, 0.74, 0.78), 5).times
    found = restitution(times, np.full(5, 1e-5))
    assert found.constant_within_noise is False
    assert found.per_pair == pytest.approx([0.70, 0.74, 0.78])
    assert found.value == pytest.approx(0.74)
    assert found.sigma == pytest.approx(1.3213 * 0.04 / np.sqrt(3), rel=1e-4)  # Student's t for 2


def test_speed_of_arrival_is_half_g_times_the_flight():
    """Thesis, eq. 7.3."""
    found = restitution(np.array([0.0, 0.4, 0.72]), np.full(3, 1e-5))
    assert found.impact_speeds_m_s == pytest.approx([0.5 * 9.81 * 0.4])


def test_sigma_of_one_ratio_is_that_of_gauss():
    """e = (t3 - t2)/(t2 - t1): de = sigma sqrt(e^2 + (1 + e)^2 + 1)/T."""
    found = restitution(np.array([0.0, 0.5, 0.9]), np.full(3, 1e-3))
    assert found.sigma == pytest.approx(1e-3 * np.sqrt(0.64 + 3.24 + 1) / 0.5)


def test_a_row_of_echoes_is_not_the_impacts():
    """The same flights twice, 60 ms apart: sound does not come before the impact."""
    impacts = Bounces(0.8, 5).times
    times = np.sort(np.concatenate([impacts, impacts + 0.06]))
    levels = np.where(np.isin(times, impacts), 30.0, 31.0)
    assert times[bouncing(times, levels)] == pytest.approx(impacts)


def test_the_last_echo_is_no_impact():
    """It comes where the next flight would end, but all impacts have it: 131 ms after each."""
    impacts = Bounces(0.8, 6).times
    echoes = impacts + 0.8 * (impacts[-1] - impacts[-2])
    times = np.concatenate([impacts, echoes])
    levels = np.concatenate([np.linspace(40, 30, 6), np.linspace(34, 24, 6)])
    order = np.argsort(times)
    assert times[order][bouncing(times[order], levels[order])] == pytest.approx(impacts)


def clicks(tmp_path, times, sizes, room=None):
    """A WAV of events at these times."""
    room = room or Room()
    t = np.arange(round(room.rate * room.length)) / room.rate
    x = room.noise * np.random.default_rng(2).standard_normal(len(t))
    x += sum(tone(t - time, size) for time, size in zip(times, sizes, strict=True))
    return write_wav(tmp_path / "clicks.wav", x, room.rate)


def test_what_ticks_is_no_object_that_bounces(tmp_path):
    """Of ten even ticks, those after 4, 2 and 1 steps would make a row of e = 0.5."""
    ticks = 0.2 + 0.25 * np.arange(10)
    found = measure_impacts(clicks(tmp_path, ticks, np.ones(10)))
    assert found.restitution.value is None
    assert "are about as loud: no restitution" in found.warnings[0]


def test_three_of_many_knocks_are_no_row(tmp_path):
    """Any three events whose second interval is shorter have a ratio: 0.3 s and 0.15 s here."""
    times = [0.4, 0.75, 1.05, 1.2, 1.9, 2.2]
    found = measure_impacts(clicks(tmp_path, times, [1.0, 0.9, 0.95, 1.0, 0.9, 0.95]))
    assert found.restitution.value is None


def test_a_row_that_chance_may_make_is_not_believed():
    """C(n, 3) triples of n events, each further one within its miss of where the ratio puts it.

    Five impacts, the last two flights 1 ms longer than a constant ratio has them, with three events
    left out in 3 s, 1 a second: about C(8, 3) (2 x 1 ms x 1/s)^2 = 2e-4 rows by chance.
    With flights 100 ms longer, 2.
    """
    impacts = Bounces(0.8, 5, first_flight=0.4).times
    strange = np.array([0.1, 2.6, 3.1])
    levels = np.array([35.0, 40.0, 38.0, 36.0, 34.0, 32.0, 35.0, 35.0])
    for late, believed in ((1e-3, True), (0.1, False)):
        row = impacts + np.array([0.0, 0.0, 0.0, late, 2 * late])
        words = weakness([1, 2, 3, 4, 5], np.sort(np.concatenate([row, strange])), levels)
        assert (words is None) == believed, words
    assert weakness([0, 1, 2, 3, 4], row, levels[1:6]) is None  # nothing is left out


def test_an_impact_that_began_before_the_signal_is_left_out(tmp_path):
    """Its ringing is there, its onset is not: the others give e, as if it had not been."""
    x = Room().record(BOUNCES, 1)
    begin = round((BOUNCES.times[0] + 2e-3) * Room().rate)
    found = measure_impacts(write_wav(tmp_path / "late.wav", x[begin:], Room().rate))
    assert len(found.times_s) == BOUNCES.n - 1
    assert found.restitution.value == pytest.approx(0.8, abs=4 * found.restitution.sigma)
    assert any("begins within an event" in words for words in found.warnings)


def test_a_channel_without_signal_is_not_called_clipped(tmp_path):
    x = Room().record(BOUNCES, 1)
    found = measure_impacts(write_wav(tmp_path / "s.wav", np.stack([x, 0 * x], 1), Room().rate))
    assert not any("clipped" in words for words in found.warnings)


def test_drop_height_gives_the_first_restitution(tmp_path):
    """v = sqrt(2 g h) arrives, g T/2 leaves; two impacts suffice."""
    bounces = Bounces(0.8, 2, 2 * 0.8 * np.sqrt(2 * 0.5 / 9.81))
    path = wav(tmp_path, Room(), bounces)
    assert measure_impacts(path).restitution.value is None
    found = measure_impacts(path, drop_height=0.5)
    assert found.restitution.value == pytest.approx(0.8, abs=4 * found.restitution.sigma)


def test_the_drop_heights_uncertainty_is_in_the_first_restitution(tmp_path):
    """e = T sqrt(g/8h): de/e = dh/2h = 0.5 % of 5 mm in 0.5 m, dg/2g = 0.15 % over the earth."""
    bounces = Bounces(0.8, 2, 2 * 0.8 * np.sqrt(2 * 0.5 / 9.81))
    path = wav(tmp_path, Room(), bounces)
    run = CliRunner().invoke(app, ["impacts", str(path), "--drop-height", "0.5 m +- 5 mm"])
    assert "counts as exact" not in run.output
    found = measure_impacts(path, drop_height=Measured(0.5, 5e-3)).restitution
    of_both = np.hypot(0.5 * 5e-3 / 0.5, 0.5 * 0.03 / 9.81)
    assert found.sigma == pytest.approx(0.8 * of_both, rel=0.01)
    exact = measure_impacts(path, drop_height=0.5)
    assert any("0.5 m counts as exact" in said for said in exact.warnings)


def test_impacts_that_are_missing_before_the_first_are_counted(tmp_path):
    """From 1.5 m with e = 0.8, a first flight of 0.5664 s is that after the third impact."""
    bounces = Bounces(0.8, 5, 2 * 0.8**3 * np.sqrt(2 * 1.5 / 9.81))
    found = measure_impacts(wav(tmp_path, Room()), drop_height=1.5)
    assert any("impacts more came before" in words for words in found.warnings)
    found = measure_impacts(wav(tmp_path, Room(), bounces), drop_height=1.5)
    assert any("2.0 impacts more came before" in words for words in found.warnings)


def test_clipping_is_said(tmp_path):
    assert any(
        "clipped" in words for words in measure_impacts(wav(tmp_path, Room(clip=0.4))).warnings
    )


def test_command_prints_the_keys_and_draws_the_diagnostic_figure(tmp_path):
    path = wav(tmp_path, Room())
    run = CliRunner().invoke(
        app, ["impacts", str(path), "--json", "--out", str(tmp_path / "sheets")]
    )
    assert run.exit_code == 0, run.output
    result = json.loads(run.stdout)
    assert {"impact_times_s", "restitution", "warnings"} <= set(result)
    assert {"value", "sigma", "per_pair", "constant_within_noise"} <= set(result["restitution"])
    assert Path(result["sheet"]).stat().st_size > 10_000
    text = CliRunner().invoke(app, ["impacts", str(path)])
    assert "restitution 0.80" in text.output


def test_the_restitution_goes_into_the_parameter_file(tmp_path):
    path, table = wav(tmp_path, Room()), tmp_path / "pairs.toml"
    pair = ["--into", str(table), "--pair", "steel-glass"]
    run = CliRunner().invoke(app, ["impacts", str(path), *pair])
    assert run.exit_code == 0, run.output
    entry = tomllib.loads(table.read_text())["pair"]["steel-glass"]["restitution"]
    assert float(entry["value"]) == pytest.approx(0.8, abs=1e-3)
    assert entry["trials"] == 3


def bad_text(path, words):
    path.write_text(words)
    return path


def truncated(path):
    write_wav(path, Room().record(BOUNCES, 1), 44100.0)
    path.write_bytes(path.read_bytes()[:100_000])
    return path


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda d: d / "none.wav", "cannot be read"),
        (lambda d: bad_text(d / "a.wav", "not a sound at all"), "not a WAV"),
        (lambda d: bad_text(d / "b.wav", ""), "not a WAV"),
        (lambda d: truncated(d / "c.wav"), "truncated"),
        (lambda d: write_wav(d / "d.wav", np.zeros(44100), 44100), "no impact"),
        (lambda d: wav(d, Room(), Bounces(0.8, 2, 9.0)), "one impact alone"),
        (lambda d: bad_text(d / "e.csv", "time;force\na;b\n"), "number"),
        (lambda d: bad_text(d / "f.csv", "force\n" + "1.0\n" * 50), "--rate"),
        (lambda d: bad_text(d / "g.csv", "time,x\n" + "0.1,2\n" * 50), "does not grow"),
        (lambda d: bad_text(d / "h.csv", "time,x\n0,1\n1,2\n"), "2 samples"),
        (lambda d: bad_text(d / "i.csv", "time,x\n" + "".join(f"{k**2},1\n" for k in range(50))),
         "uneven"),
        (lambda d: bad_text(d / "j.csv", "time [N],x\n" + "".join(f"{k},1\n" for k in range(50))),
         "unit"),
        (lambda d: bad_text(d / "k.csv", "time,x\n" + "".join(f"{k},\n" for k in range(50))),
         "not finite"),
    ],
    ids=["missing", "text", "empty", "truncated", "silence", "one impact", "no numbers", "no rate",
         "standing time", "short", "gaps", "unit", "empty field"],
)  # fmt: skip
def test_bad_input_is_one_line(tmp_path, make, match):
    with pytest.raises(InputError, match=match) as raised:
        measure_impacts(make(tmp_path))
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"window": 1.0}, "--window"),
        ({"drop_height": -1.0}, "--drop-height"),
        ({"rate": 1e3}, "own rate"),
    ],
)
def test_bad_options_are_one_line(tmp_path, options, match):
    with pytest.raises(InputError, match=match):
        measure_impacts(wav(tmp_path, Room()), **options)


def test_a_table_without_times_takes_a_rate(tmp_path):
    room = Room(rate=10e3, shape=half_sine)
    path = bad_text(tmp_path / "x.csv", "\n".join(map(str, room.record(BOUNCES, 1))))
    assert_impacts_are(measure_impacts(path, rate=10e3), BOUNCES)
