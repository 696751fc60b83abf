"""The effective field: harmonic balance against closed forms, its table, and what is refused."""

import json
import math

import numpy as np
import pytest
from refusals import assert_refused, assert_refuses
from small_damper import damper3d, write_damper

from damper3d.case.host import Drive, Modes
from damper3d.studies.field.balance import jumps, solve
from damper3d.studies.field.runs import points_of, power_of
from damper3d.studies.field.table import Field, read_field

GAMMAS, FREQUENCIES = np.geomspace(0.1, 30.0, 18), np.array([15.0, 20.0, 25.0])
HOST = Modes.single(1.0, 2 * np.pi * 20.0, 0.01)
TWO = Modes(
    2 * np.pi * np.array([20.0, 24.0]), np.array([0.01, 0.02]), np.array([1.0, 0.7]),
    np.array([0.8, -0.5]), np.array([0.9, 0.3]),
)  # fmt: skip
SWEPT = 2 * np.pi * np.linspace(17.0, 24.0, 141)


def field(mass) -> Field:
    """A field whose mass is a function of frequency [Hz] and Gamma."""
    f, g = (x.ravel() for x in np.meshgrid(FREQUENCIES, GAMMAS, indexing="ij"))
    return Field(f, g, np.asarray(mass(f, g), complex) + 0 * f)


@pytest.mark.parametrize("host", [HOST, TWO], ids=["one mode", "two modes"])
@pytest.mark.parametrize("drive", [Drive(force=0.5), Drive(base=2e-4)], ids=["force", "base"])
def test_a_mass_that_rides_along_shifts_the_modes(host, drive):
    """Of one amplitude at every level: X = X0/(1 - w^2 R m), in closed form."""
    found = solve(field(lambda f, g: 0.05), [host], [drive], SWEPT)
    assert len(found.amplitude) == len(SWEPT)
    assert found.stable.all()
    for k, w in enumerate(SWEPT):
        modal = 1 / (host.omega**2 - w**2 + 2j * host.damping_ratio * host.omega * w)
        forced = drive.force * host.force_shape + drive.base * w**2 * host.participation
        x0 = drive.base + host.shape @ (modal * forced)
        x = x0 / (1 - w**2 * (host.shape**2 @ modal) * 0.05)
        assert found.amplitude[k] == pytest.approx(abs(x), rel=1e-9)
        assert found.phase[k] == pytest.approx(np.angle(x / x0), abs=1e-6)


def test_a_dashpot_adds_its_damping():
    """m'' = c/w: the peak of one mode is F/((c0 + c) w0) at its own frequency."""
    c = 0.8
    dashpot = field(lambda f, g: -1j * c / (2 * np.pi * f))
    found = solve(dashpot, [HOST], [Drive(force=0.5)], np.array([2 * np.pi * 20.0]))
    own = 2 * 0.01 * 2 * np.pi * 20.0
    assert found.amplitude == pytest.approx(0.5 / ((own + c) * 2 * np.pi * 20.0), rel=1e-9)


def falling(f, g):
    """A mass that leaves its host as Gamma rises, and turns negative: m' = m (1 - ln Gamma)."""
    return 0.08 * (1 - np.log(g)) - 2e-4j


def test_all_solutions_are_found_and_the_middle_one_is_not_stable():
    """Against signs of the balance on a fine grid of amplitudes; m' negative beyond Gamma e."""
    bent = field(falling)
    drives = [Drive(force=level) for level in (0.1, 0.3, 0.6, 1.0)]
    light = Modes.single(1.0, 2 * np.pi * 20.0, 0.002)
    found = solve(bent, [light] * 4, drives, SWEPT)
    _, amplitude = bent.at(SWEPT)
    several = 0
    for r, drive in enumerate(drives):
        for k, w in enumerate(SWEPT):
            fine = np.geomspace(amplitude[k, 0], amplitude[k, -1], 20_001)
            m = falling(w / (2 * np.pi), fine * w**2 / 9.81)
            receptance = 1 / (light.omega[0] ** 2 - w**2 + 2j * 0.002 * light.omega[0] * w)
            level = fine * abs(1 - w**2 * receptance * m) - abs(receptance * drive.force)
            up = np.flatnonzero((level[:-1] <= 0) & (level[1:] > 0))
            down = np.flatnonzero((level[:-1] > 0) & (level[1:] <= 0))
            here = (found.response == r) & (found.frequency == k)
            inside = here & (found.amplitude >= amplitude[k, 0])
            stable = found.amplitude[inside & found.stable]
            assert stable == pytest.approx(fine[up], rel=1e-3), (r, k)
            assert found.amplitude[inside & ~found.stable] == pytest.approx(fine[down], rel=1e-3)
            several += here.sum() > 1
    assert several > 10
    ups, downs = (jumps(found, len(SWEPT), 2, upwards=way) for way in (True, False))
    assert ups
    assert downs
    assert ups != downs  # hysteresis


def test_the_power_of_a_falling_mass_is_found():
    """m' = m/(1 + Gamma^2) falls as Gamma^-2 at last; fitted from 0.9 m to 0.01 m."""
    gamma = np.geomspace(3.0, 30.0, 12)
    found = power_of(gamma, 0.05 / (1 + gamma**2), 0.05)
    assert found.exponent == pytest.approx(-2.0, abs=0.15)
    assert power_of(gamma, np.full(12, 0.05), 0.05) is None
    again = 0.05 * np.where(gamma < 10, gamma**-1.0, 0.5)  # it rides along once more
    assert power_of(gamma, again, 0.05).exponent == pytest.approx(-1.0, abs=1e-9)


def test_points_have_intervals_over_packings():
    rows = [
        {"state": "done", "frequency_hz": 20.0, "gamma": 2.0, "effective_mass.in_phase_kg": m,
         "effective_mass.out_of_phase_kg": 0.01}
        for m in (0.02, 0.03, 0.04)
    ]  # fmt: skip
    found = points_of(rows)
    assert found.mass[0] == pytest.approx(0.03 - 0.01j)
    assert found.half_width[0].real == pytest.approx(4.303 * 0.01 / math.sqrt(3), rel=1e-3)
    assert found.half_width[0].imag == pytest.approx(0.0, abs=1e-15)


HEAD = "frequency_hz,gamma,m_in_phase_kg,m_out_of_phase_kg\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["holds no points"]),
        ("frequency_hz,gamma\n20,1\n", ["'m_in_phase_kg' is missing"]),
        (HEAD + "20,1,much,0\n", ["point 1", "m_in_phase_kg = 'much'"]),
        (HEAD + "20,-1,0.1,0\n20,2,0.1,0\n", ["gamma = -1"]),
        (HEAD + "20,1,0.1,0\n", ["two Gammas at least"]),
        (HEAD + "20,1,0.1,0\n20,1,0.1,0\n", ["each frequency and Gamma once"]),
    ],
    ids=lambda given: given[0] if isinstance(given, list) else "",
)
def test_a_table_that_is_no_field_is_refused(text, words, tmp_path):
    path = tmp_path / "table.csv"
    path.write_text(text, encoding="utf-8")
    assert_refuses(words, read_field, path)


def test_a_field_is_measured_and_answers_for_a_host(tmp_path):
    """Three Gammas of a small bed, then a response of a host at 80 Hz; and what is refused."""
    small = {"run.cycles": 4, "run.max_cycles": 20, "motion.frequency": None, "motion.gamma": None}
    path = write_damper(tmp_path, small)
    out = ("--out", tmp_path / "runs")
    done = damper3d("field", path, "--frequencies", "70,90", "--gammas", "2,5,12", "--packings", 2,
                    *out, "--json", "--quiet")  # fmt: skip
    assert done.code == 0, done.err
    found = json.loads(done.out)
    assert len(found["points"]) == 6
    assert all(row["packings"] == 2 for row in found["points"])
    assert all(row["m_out_of_phase_kg"] > 0 for row in found["points"])
    assert (tmp_path / "runs" / "fields").rglob("field.png")
    host = {"host.mass": "0.1 kg", "host.frequency": 80.0, "host.damping_ratio": 0.01,
            "host.force": "1 N"}  # fmt: skip
    case = write_damper(tmp_path, {**small, **host}, "hosted")
    to = ("-o", tmp_path / "answer")
    asked = ("--field", found["table"], "--span", "0.9,1.1", *to)
    answer = damper3d("response", case, *asked, "--json")
    assert answer.code == 0, answer.err
    levels = json.loads(answer.out)["levels"]
    assert [one["excitation"] for one in levels] == ["0.5 N", "1 N", "2 N"]
    assert all(0 < one["reduction"] < 1 for one in levels)
    assert (tmp_path / "answer" / "response.csv").read_text(encoding="utf-8").count("\n") > 600
    wide = damper3d("response", case, "--field", found["table"], *to)
    assert_refused(wide, "the field is known from 70 to 90 Hz")
    assert_refused(damper3d("response", path, *asked), "[host]", "force, base_displacement")
