"""Times of impacts from an acoustic stopwatch: rows of flights, drag, several throws, refusals."""

from pathlib import Path

import numpy as np
import pytest
from calibrating import calibrate
from refusals import assert_refused

from calibration.impacts.stopwatch import measure_stopwatch

MEDIA = Path(__file__).parents[3] / "shared" / "media"
needs_media = pytest.mark.skipif(not MEDIA.is_dir(), reason=f"no recordings in {MEDIA}")
G = 9.81


def throw(e, n, first=0.6, final_speed=None):
    """Times of n impacts [s], in air to all orders: u' = e w sqrt-law of each flight integrated."""
    times, u = [0.4], 0.5 * G * first
    for _ in range(n - 1):
        if final_speed is None:
            flight, down = 2 * u / G, u
        else:  # closed forms of a flight with drag as the square of speed
            w = final_speed
            height = w**2 / (2 * G) * np.log1p((u / w) ** 2)
            rise = w / G * np.arctan(u / w)
            fall = w / G * np.arccosh(np.exp(G * height / w**2))
            flight, down = rise + fall, w * np.sqrt(-np.expm1(-2 * G * height / w**2))
        times.append(times[-1] + flight)
        u = e * down
    return np.array(times)


def written(path, *throws, decimals=9):
    """A CSV with a column of events a throw, as phones write it."""
    longest = max(map(len, throws))
    head = ",".join(["Event time (s),Interval (s)"] * len(throws))
    lines = [head]
    for k in range(longest):
        fields = []
        for times in throws:
            there = k < len(times)
            interval = times[k + 1] - times[k] if k + 1 < len(times) else 0.0
            one = f"{times[k]:.{decimals}f},{interval:.{decimals}f}"
            fields.append(one if there else ",")
        lines.append(",".join(fields))
    path.write_text("\n".join(lines))
    return path


def test_a_throw_without_air_gives_its_restitution(tmp_path):
    """Exact but for times written to 1 ns: of flights of 0.1 s and more, 1e-7 of a ratio."""
    found = measure_stopwatch(written(tmp_path / "t.csv", throw(0.8, 8)))
    assert found.found.all.value == pytest.approx(0.8, abs=1e-7)


@pytest.mark.parametrize("encoding", ["cp1252", "utf-16", "utf-8-sig"])
def test_a_note_in_any_code_behind_the_times_changes_nothing(tmp_path, encoding):
    """Far behind the first lines, by which the file is known as a stopwatch's."""
    path = written(tmp_path / "t.csv", throw(0.8, 8))
    note = ",".join([""] * 5000) + ",Müller"
    path.write_bytes(f"{path.read_text()}\n{note}\n".encode(encoding))
    found = measure_stopwatch(path)
    assert found.found.all.value == pytest.approx(0.8, abs=1e-7)


def test_drag_is_found_and_taken_out(tmp_path):
    """A ping-pong ball (8 m/s) of 0.93. The next order of the drag term is (u/w)^4/6 = 1e-3."""
    rng = np.random.default_rng(3)
    throws = [throw(0.93, 14, 0.38, 8.0) + 5e-5 * rng.standard_normal(14) for _ in range(3)]
    found = measure_stopwatch(written(tmp_path / "t.csv", *throws))
    assert found.drag.seen
    assert found.found.all.value == pytest.approx(0.93, abs=2e-3)
    assert found.to_dict()["restitution"]["final_speed_m_s"] == pytest.approx(8.0, rel=0.1)
    assert found.plain.all.value < 0.925


def test_the_drag_test_raises_no_more_false_alarms_than_it_says(tmp_path):
    """At 1 % of 400 throws without air: 4 +- 2, at most 11 once in a thousand (binomial)."""
    rng = np.random.default_rng(11)
    seen = 0
    for k in range(400):
        times = throw(0.85, 9) + 1e-4 * rng.standard_normal(9)
        seen += measure_stopwatch(written(tmp_path / f"{k}.csv", times)).drag.p < 0.01
    assert seen <= 11


def test_the_interval_covers_the_truth_as_often_as_it_says(tmp_path):
    """60 to 76 % of 200 files of four throws whose restitution scatters by 0.01 a bounce."""
    rng = np.random.default_rng(5)
    covered = 0
    for k in range(200):
        throws = [_scattered(0.85, 8, rng) for _ in range(4)]
        one = measure_stopwatch(written(tmp_path / f"{k}.csv", *throws)).plain.all
        covered += abs(one.value - 0.85) < one.sigma
    assert 120 <= covered <= 152


def _scattered(e, n, rng):
    flights = 0.6 * np.cumprod([1.0, *(e + 0.01 * rng.standard_normal(n - 2))])
    return np.cumsum([0.4, *flights])


def test_events_that_are_no_bounces_are_left_out_with_the_reason(tmp_path):
    times = throw(0.85, 9)
    knocked = np.sort([0.1, *times, times[3] + 0.21 * (times[4] - times[3]), times[-1] + 0.9])
    found = measure_stopwatch(written(tmp_path / "t.csv", knocked))
    (one,) = found.throws
    np.testing.assert_allclose(one.times_s, times, atol=1e-8)
    reasons = [why for _, why in one.rejected]
    assert [reason.split()[0] for reason in reasons] == ["before", "between", "its"]


def test_an_interval_behind_the_last_event_is_one_more_impact(tmp_path):
    times = throw(0.8, 6)
    path = tmp_path / "t.csv"
    lines = ["Event time (s);Interval (s)"]
    lines += [f"{t:.9f};{d:.9f}" for t, d in zip(times, np.diff(times), strict=False)]
    path.write_text("\n".join(lines))
    np.testing.assert_allclose(measure_stopwatch(path).throws[0].times_s, times, atol=2e-9)


@needs_media
@pytest.mark.parametrize(
    ("name", "ratios"),
    [
        ("stopwatch_blue_1_55cm.xls", [0.873, 0.874, 0.891, 0.902, 0.890, 0.902, 0.886]),
        ("stopwatch_blue_2_55cm.xls", [0.880, 0.876, 0.882, 0.879, 0.886, 0.873]),
        ("stopwatch_pingpong_1_18cm.xlsx",
         [0.931, 0.940, 0.940, 0.943, 0.943, 0.945, 0.945, 0.941]),
    ],
)  # fmt: skip
def test_recordings_of_others_give_their_ratios(name, ratios):
    (one,) = measure_stopwatch(MEDIA / name).throws
    np.testing.assert_allclose(one.ratios[: len(ratios)], ratios, atol=6e-4)


@needs_media
def test_sheets_with_several_throws_are_pooled_by_sheet(tmp_path):
    """First ratios at 80 cm 0.889, 0.896, 0.895, 0.897."""
    path = MEDIA / "golf_intervals.xlsx"
    found = calibrate("impacts", path, "--json", "--out", tmp_path).json
    assert len(found["throws"]) == 16
    first = [one["per_pair"][0] for one in found["throws"][:4]]
    np.testing.assert_allclose(first, [0.889, 0.896, 0.895, 0.897], atol=6e-4)
    assert set(found["restitution"]["groups"]) == {"80 cm", "90 cm", "100 cm", "110 cm"}
    assert Path(found["sheet"]).is_file()


def test_options_of_a_signal_do_not_go_with_a_stopwatch(tmp_path):
    path = written(tmp_path / "t.csv", throw(0.8, 6))
    assert_refused(calibrate("impacts", path, "--rate", "1000"), "--rate", "times of events")
    assert_refused(calibrate("impacts", path, "--unit", "time=ms"), "--unit", "times of events")
    short = written(tmp_path / "s.csv", throw(0.8, 3))
    assert_refused(calibrate("impacts", short), "no throw", "shrink")
    mixed = tmp_path / "m.csv"
    mixed.write_text("Event time (s)\n1\n3\n2\n4\n")
    assert_refused(calibrate("impacts", mixed), "times do not rise")


def test_a_signal_is_no_stopwatch(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("time,force\n0,1\n1,2\n")
    assert measure_stopwatch(path) is None
