"""Motional phase from force and acceleration alone, on motions whose phase is known.

The bed's centre of mass moves as written, and its force on the enclosure follows from that.
"""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from fake_damper_run import write_fake_damper_run

from calibration.commands.main import app
from calibration.shaker.against import against
from calibration.shaker.measure import dissipation
from calibration.shaker.phases import BOUNCING, FLUIDISED, SOLID, bed_phase
from calibration.shaker.record import read_record
from damper3d.view.export import export
from granulab.campaign.runs.folder import RunFolder

ENCLOSURE, BED, FREQUENCY, RATE, CYCLES = 0.2, 0.03, 40.0, 4000.0, 16
OMEGA = 2 * np.pi * FREQUENCY
SPEED = 100.0 / OMEGA  # V [m/s], of 10.2 g
PER = round(RATE / FREQUENCY)
T = np.arange(CYCLES * PER) / RATE


def record(path, bed, sign=1.0, noise=0.0, delay=0.0):
    """A table for a bed whose centre of mass moves at `bed` [m/s] (n,), in the laboratory."""
    rng, moved = np.random.default_rng(4), -SPEED * OMEGA * np.sin(OMEGA * T)
    lines = np.fft.rfft(ENCLOSURE * moved + BED * np.gradient(bed, 1 / RATE))
    lines *= np.exp(1j * delay * (np.arange(len(lines)) > 0))
    force = np.fft.irfft(lines, len(T)) + noise * 20.0 * rng.standard_normal(len(T))
    moved = moved + noise * 100.0 * rng.standard_normal(len(T))
    np.savetxt(path, np.column_stack([T, sign * force, moved]), delimiter=",", comments="",
               header="time [s],force [N],acceleration [m/s2]")  # fmt: skip
    return read_record(path)


def riding(share=1.0):
    """A part of the bed rides along, the rest hovers."""
    return share * SPEED * np.cos(OMEGA * T)


def thrown(back=1.0):
    """From end to end: up with `back` V in half of the cycle, down as fast, in bursts of T/20."""
    square = np.sign(np.sin(OMEGA * T + 1e-9))
    box = np.ones(PER // 20) / (PER // 20)
    smooth = np.convolve(np.tile(square, 3), box, "same")[len(T) : 2 * len(T)]
    return back * SPEED * smooth


@pytest.mark.parametrize(
    ("bed", "name", "measures"),
    [
        # w = s V cos: slip (1 - s)^2, energy s^2, either end 2 s M V - or so, as the other's
        (riding(), SOLID, {"slip": (0.0, 1e-3), "energy": (1.0, 1e-2)}),
        (riding(0.91), SOLID, {"slip": (0.0081, 1e-3)}),
        (riding(0.89), BOUNCING, {"slip": (0.0121, 1e-3)}),
        (riding(0.0), FLUIDISED, {"slip": (1.0, 1e-3), "energy": (0.0, 1e-6)}),
        # w = +-b V: energy 2 b^2 but for a third of that in the bursts, each end gives 2 b M V
        (thrown(), BOUNCING, {"energy": (1.867, 0.01), "high_impulse": (1.0, 0.03)}),
        (thrown(0.6), BOUNCING, {"energy": (0.672, 0.01), "high_impulse": (0.6, 0.03)}),
        (thrown(0.4), FLUIDISED, {"energy": (0.299, 0.01), "high_impulse": (0.4, 0.03)}),
    ],
)  # fmt: skip
@pytest.mark.parametrize("chain", [{}, {"sign": -1.0}, {"noise": 0.005}, {"delay": 0.017}])
def test_a_known_motion_has_its_phase(tmp_path, bed, name, measures, chain):
    """With the transducer the other way round, with noise, and with 1 deg of phase error."""
    full = record(tmp_path / "full.csv", bed, **chain)
    empty = record(tmp_path / "empty.csv", np.zeros(len(T)), **chain)
    found = dissipation(full, [empty], BED).phase
    assert found.name == name
    for key, (value, within) in measures.items():
        assert getattr(found, key) == pytest.approx(value, abs=within + 3 * chain.get("noise", 0))


def test_the_weight_is_on_the_lower_end(tmp_path):
    """A bed that hovers is carried: M g over a cycle is pi/Gamma of 2 M V, all from below."""
    hovering = record(tmp_path / "full.csv", riding(0.0))
    found = bed_phase(hovering, ENCLOSURE, BED)
    assert found.low_impulse == pytest.approx(np.pi * 9.81 / 100, rel=1e-3)
    assert found.high_impulse == pytest.approx(0.0, abs=1e-3)
    across = bed_phase(hovering, ENCLOSURE, BED, gravity=0.0)
    assert across.low_impulse == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("missing", ["empty", "mass"])
def test_without_the_empty_enclosure_or_the_bed_s_mass_there_is_no_phase(tmp_path, missing):
    full = record(tmp_path / "full.csv", riding())
    empty = () if missing == "empty" else (record(tmp_path / "empty.csv", np.zeros(len(T))),)
    found = dissipation(full, empty, None if missing == "mass" else BED)
    assert found.phase is None
    assert found.to_dict()["phase"] is None


@pytest.fixture
def runs(tmp_path):
    """Made-up runs, all alike, that say of themselves that they are of three phases."""
    folders = []
    for name in ("solid_like", "bouncing_bed", "leidenfrost", None):
        run = write_fake_damper_run(tmp_path / str(name), cycles=12, discard=4)
        run.write_summary({**run.read_summary(), "phase": name, "particle_mass_kg": 1.68e-5})
        export(run.path, "shaker")
        folders.append(run.path)
    return folders


def test_confusion_counts_each_run_by_both_phases(runs):
    """All alike: one column; of three runs one is named as it is. The fourth has no phase."""
    found = against(runs)
    name = found.runs[0].signals.name
    assert [found.count(counted, name) for counted in (SOLID, FLUIDISED, BOUNCING)] == [1, 1, 1]
    assert found.agreement == pytest.approx((1 / 3, np.sqrt(2 / 27)))
    assert len(found.left_out) == 1
    assert "alike in 33 ± 27 % of 3 runs" in found.text()


def test_the_command_compares_run_folders(runs, tmp_path):
    arguments = ["shaker", "--against", *map(str, runs)]
    done = CliRunner().invoke(app, [*arguments, "--json", "-o", str(tmp_path / "sheets")])
    assert done.exit_code == 0, done.output
    result = json.loads(done.stdout)
    assert sum(sum(row.values()) for row in result["confusion"].values()) == 3
    assert {"counted", "signals", "efficiency", "efficiency_of_run"} <= set(result["runs"][0])
    assert (tmp_path / "sheets" / "against-shaker.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda run: (run / "summary.json").unlink(), "no finished run"),
        (lambda run: (run / "summary.json").write_text("{"), "damaged"),
        (lambda run: RunFolder(run).write_summary({"test": "shear"}), "damper that was shaken"),
        (lambda run: (run / "export" / "shaker.csv").unlink(), "export {run} --to shaker"),
    ],
)
def test_a_folder_that_cannot_be_compared_is_refused_in_one_line(runs, spoil, words):
    spoil(runs[0])
    done = CliRunner().invoke(app, ["shaker", "--against", str(runs[0])])
    assert done.exit_code != 0
    message = str(done.exception or done.output)
    assert words.format(run=runs[0]) in message
    assert "\n" not in message.strip()


def test_one_record_at_a_time(tmp_path):
    done = CliRunner().invoke(app, ["shaker", "a.csv", "b.csv"])
    assert "one FILE at a time" in str(done.exception or done.output)
