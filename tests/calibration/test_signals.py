"""Readers of signals: what is written comes back, and damage is one line, never a traceback."""

import io
import warnings

import numpy as np
import pytest
from fuzzing import examples
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import wavfile

from calibration.files.signals import read_signal
from granulab.errors import InputError

SAMPLES = np.arange(-32, 32, dtype=np.int16) * 100


def small_wav():
    file = io.BytesIO()
    wavfile.write(file, 8000, SAMPLES)
    return file.getvalue()


@settings(
    deadline=None,
    max_examples=examples(40),
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(
    damage=st.lists(st.tuples(st.integers(0, 171), st.integers(0, 255)), max_size=4),
    length=st.integers(0, 172),
)
def test_a_damaged_wav_is_read_or_refused_in_one_line(tmp_path, damage, length):
    raw = bytearray(small_wav())
    for place, value in damage:
        raw[place] = value
    path = tmp_path / "damaged.wav"
    path.write_bytes(raw[:length])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        said, signal = "", None
        try:
            signal = read_signal(path)
        except InputError as error:
            said = str(error)
    assert "\n" not in said
    assert signal is None or np.isfinite(signal.channels).all()


@settings(
    deadline=None,
    max_examples=examples(40),
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(
    values=st.lists(  # no instrument writes 1e-30
        st.floats(-1e6, 1e6).map(lambda value: round(value, 12)), min_size=16, max_size=50
    ),
    separator=st.sampled_from([",", ";", "\t"]),
    unit=st.sampled_from([("s", 1.0), ("ms", 1e-3), ("us", 1e-6)]),
)
def test_a_table_comes_back_in_seconds(tmp_path, values, separator, unit):
    name, factor = unit
    rows = [f"{k}{separator}{value!r}" for k, value in enumerate(values)]
    path = tmp_path / "table.csv"
    path.write_text("\n".join([f"time [{name}]{separator}force [N]", *rows]))
    signal = read_signal(path)
    assert signal.rate == pytest.approx(1.0 / factor)
    assert signal.channels[:, 0].tolist() == values
    assert signal.names == ("force",)


def test_a_unit_behind_the_name_counts(tmp_path):
    path = tmp_path / "ms.csv"
    path.write_text("time_ms,force_N\n" + "".join(f"{k},{k % 3}\n" for k in range(50)))
    signal = read_signal(path)
    assert signal.rate == pytest.approx(1000.0)
    assert signal.names == ("force_N",)
    assert not signal.remarks


def test_full_scale_is_one(tmp_path):
    path = tmp_path / "a.wav"
    wavfile.write(path, 8000, np.array([-(2**15), 0, 2**14] * 10, dtype=np.int16))
    assert read_signal(path).channels[:3, 0].tolist() == [-1.0, 0.0, 0.5]
    wavfile.write(path, 8000, np.array([0, 128, 192] * 10, dtype=np.uint8))
    assert read_signal(path).channels[:3, 0].tolist() == [-1.0, 0.0, 0.5]


def test_times_rounded_by_who_wrote_them_are_even(tmp_path):
    """At 3 kHz written to 0.1 ms: no step is like the next, the rate is that of all."""
    path = tmp_path / "rounded.csv"
    path.write_text("t,x\n" + "".join(f"{k / 3000:.4f},{k % 3}\n" for k in range(600)))
    signal = read_signal(path)
    assert signal.rate == pytest.approx(3000.0, rel=1e-3)
    assert any("seconds" in words for words in signal.remarks)


def test_an_unknown_column_is_reported_with_the_known_ones(tmp_path):
    path = tmp_path / "two.csv"
    path.write_text("t,force,sound\n" + "".join(f"{k},{k},{k}\n" for k in range(20)))
    assert read_signal(path, column="Sound").names == ("sound",)
    with pytest.raises(InputError, match="did you mean 'force'"):
        read_signal(path, column="forse")


def test_one_lost_sample_is_a_gap(tmp_path):
    """It would shift all that follows by a whole sample, a hundred sigmas of an impact's time."""
    t = np.delete(np.arange(200) / 1e4, 90)
    path = tmp_path / "lost.csv"
    path.write_text("time [s],force [N]\n" + "".join(f"{v:.4f},1\n" for v in t))
    with pytest.raises(InputError, match=r"the longest at 0\.0089 s"):
        read_signal(path)
