"""Steps of dissipation within the cycle, on made-up histories and on runs of a few spheres."""

import math
from pathlib import Path

import numpy as np
import pytest
from fake_damper_run import write_fake_damper_run
from hypothesis import given
from hypothesis import strategies as st
from made_damper_rows import done, failed, history, ideal_bouncing_bed

from damper3d.reproduce import cycles
from damper3d.reproduce.cycles import points
from damper3d.reproduce.panels import with_read
from damper3d.reproduce.quantities.cycle_steps import read, steps_of
from damper3d.reproduce.quantities.cycles import CYCLES, ideal_since, readings
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.output.figure import write_figure

_TENTH = 1.2816  # standard deviations from the middle of a Gaussian to its first tenth
_SAMPLE = 0.01  # cycles


def _gaussians(middles: list[float], width: float, background: float = 0.0):
    def power(part: np.ndarray) -> np.ndarray:
        away = [(part - middle + 1) % 2 - 1 for middle in middles]
        return background + sum(np.exp(-0.5 * (a / width) ** 2) for a in away)

    return power


def _energy(middles: list[float], width: float = 0.03, background: float = 0.0) -> list[float]:
    made = history(_gaussians(middles, width, background), np.zeros_like, 1.0)
    return made["cycle.dissipated"]


def test_two_collisions_a_cycle_make_two_steps_with_their_start_and_length():
    """A Gaussian has a tenth of its area beyond 1.2816 widths on either side."""
    found = steps_of(_energy([0.4, 0.9, 1.4, 1.9]))
    assert [step.half for step in found] == pytest.approx([0.4, 0.9, 1.4, 1.9], abs=_SAMPLE)
    for step in found:
        assert step.half - step.start == pytest.approx(_TENTH * 0.03, abs=_SAMPLE / 2)
        assert step.end - step.half == pytest.approx(_TENTH * 0.03, abs=_SAMPLE / 2)
        assert step.part == pytest.approx(0.5, rel=1e-6)


@pytest.mark.parametrize("middles", [[0.95, 1.95], [0.0, 1.0], [0.02, 1.02]])
def test_a_collision_at_the_end_of_the_cycle_is_one_step(middles):
    assert len(steps_of(_energy(middles))) == 2  # of two cycles


def test_a_bed_that_collides_in_every_other_cycle_has_half_a_step():
    found = steps_of(_energy([0.95]))
    assert len(found) == 1
    assert found[0].part == pytest.approx(2.0)


def test_a_weak_second_collision_is_no_step():
    """Below a tenth of a cycle's energy; the background keeps it above the mean for long."""
    strong, weak = _gaussians([0.4, 1.4], 0.02), _gaussians([0.9, 1.9], 0.02)
    made = history(lambda p: strong(p) + 0.08 * weak(p), np.zeros_like, 1.0)
    assert len(steps_of(made["cycle.dissipated"])) == 2


def test_what_is_even_or_nothing_has_no_step():
    assert steps_of(np.zeros(201)) == []
    assert steps_of(np.linspace(0.0, 1.0, 201)) == []


@given(shift=st.integers(0, 199), gap=st.floats(0.3, 0.7), width=st.floats(0.01, 0.05))
def test_steps_shift_with_the_cycle(shift, gap, width):
    power = np.diff(_energy([0.1, 0.1 + gap, 1.1, 1.1 + gap], width))
    here = steps_of(np.concatenate([[0], np.cumsum(power)]))
    there = steps_of(np.concatenate([[0], np.cumsum(np.roll(power, shift))]))
    assert len(here) == len(there) == 4
    turned = sorted((step.start + shift * _SAMPLE) % 2 for step in here)
    found = [step.start for step in there]
    away = [(a - b + 1) % 2 - 1 for a, b in zip(found, turned, strict=True)]
    if max(map(abs, away)) > 1e-9:  # one that lies at the turn may come first or last
        away = [(a - b + 1) % 2 - 1 for a, b in zip(found, np.roll(turned, 1), strict=True)]
    assert max(map(abs, away)) < 1e-6


def test_the_ideal_bouncing_bed_is_read_back():
    """It flies at V and meets the wall at the phase of eq. 6.11's construction, all at once."""
    onset = 22.3
    for gamma in (25.0, 60.0, 100.0):  # from 5.5 onsets on the wall moves the same way
        row = ideal_bouncing_bed(gamma, onset)
        found = read(row)
        since = row_since(gamma, onset)
        assert found.steps == 2
        assert found.since == pytest.approx(since - _TENTH * 0.01, abs=_SAMPLE)
        assert found.against == pytest.approx(1.0)
        assert found.bed == pytest.approx(1.0)
        # The bed goes with the wall from the meeting on, and is alike for a while after it left.
        assert found.together > 1 - 2 * since
        assert found.unevenness == pytest.approx(0.0, abs=1e-12)


def row_since(gamma: float, onset: float) -> float:
    """phi/2 pi with phi - sin phi = pi onset/gamma, by Newton's method."""
    phi = 2.0
    for _ in range(50):
        phi -= (phi - math.sin(phi) - math.pi * onset / gamma) / max(1 - math.cos(phi), 1e-6)
    return phi / (2 * math.pi)


def test_the_ideal_meeting_is_none_below_the_onset():
    """CP of Table 6.3: 22.3 at 40 Hz for a fill ratio of 0.466."""
    assert ideal_since(22.0) is None
    assert ideal_since(22.5) == pytest.approx(0.5, abs=0.06)  # phi nears pi as a square root


def judged(rows):
    """The verdict of each claim."""
    found = CYCLES.judge(claims_of("damper_cycles"), readings(rows))
    return {one.claim.id: one.holds for one in found}


def test_claims_on_the_bouncing_bed_hold_for_the_ideal_one():
    widths = {20.0: 0.03, 30.0: 0.025, 40.0: 0.02, 60.0: 0.017, 100.0: 0.014}
    rows = [ideal_bouncing_bed(gamma, 18.0, width) for gamma, width in widths.items()]
    found = judged(rows)
    assert found["two-steps-in-the-bouncing-bed"] is True
    assert found["collisions-shorter"] is True
    assert found["collisions-earlier"] is True
    assert found["longer-together-at-100"] is True
    assert found["one-step-vertical"] is None
    swapped = [{**row, "gamma": 2000.0 / row["gamma"]} for row in rows]  # 20 <-> 100
    swapped = [row for row in swapped if row["gamma"] in widths]
    assert judged(swapped)["collisions-earlier"] is False


def test_a_report_says_first_what_is_missing(tmp_path):
    reason = "overlap beyond half a radius"
    rows = [ideal_bouncing_bed(100.0, 18.0), failed(points()[0], reason)]
    first, *rest = cycles.report(rows).splitlines()
    assert first == "INCOMPLETE: 1 of 11 points are there, with 1 of 3 packings at most"
    assert "  lacking: orientation vertical: gamma 1.5, 3, 4, 20, 30, 40, 60" in rest
    assert f"failed: orientation vertical, gamma 1.5, seed 1: {reason}" in rest
    assert write_figure(tmp_path / "some.png", lambda: cycles.draw(rows)).stat().st_size > 10_000
    assert write_figure(tmp_path / "none.png", lambda: cycles.draw(rows[1:])).exists()
    assert cycles.report([]).startswith("INCOMPLETE: 0 of 11 points")


def test_a_row_takes_its_history_from_the_run_folder(tmp_path: Path):
    """The fake bed dissipates E (p - 0.9 sin(4 pi p)/(4 pi)) of each cycle: two steps."""
    run = write_fake_damper_run(tmp_path / "run", cycles=5, discard=3, samples=40)
    labels = {"orientation": "vertical", "gamma": 20.0}
    row = with_read(done(labels, run_folder=str(run.path), frequency_hz=40.0), cycles.history)
    energy = np.array(row["cycle.dissipated"])
    part = np.arange(81) / 40
    first, second = energy[40], energy[80] - energy[40]
    expected = part % 1 - 0.9 * np.sin(4 * np.pi * part) / (4 * np.pi)
    cycle = np.minimum(np.arange(81) // 40, 1)
    grown = np.where(cycle, first + second * np.where(part == 2, 1, expected), first * expected)
    np.testing.assert_allclose(energy, grown, atol=1e-4 * energy[-1])
    assert read(row).steps == 2
    lost = with_read(done(labels, run_folder=str(tmp_path / "nowhere")), cycles.history)
    assert lost["state"] == "failed"
    assert "nowhere" in lost["reason"]
