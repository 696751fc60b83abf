"""Studies of disorder and filling: their cases, and how a variant is judged against the first."""

import math
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pytest
from scipy.stats import fisher_exact, ttest_rel

from silo2d.reproduce import disorder, filling, find
from silo2d.reproduce.variants import findings, fisher_p, paired
from silo2d.run.packing import packing_digest
from silo2d.run.protocol import run_digest

OPENING = "clogged_at_opening"


def row(seed: int, time: float | None, outcome: str = "empty", **labels: str) -> dict[str, Any]:
    t90 = None if time is None else 0.9 * time
    return {
        "silo": "A3", "seed": seed, "state": "done", "reason": "", "outcome": outcome,
        "discharge_time_s": time, "t90_s": t90, "packing_fraction": 0.88 + 1e-3 * seed, **labels,
    }  # fmt: skip


def variant(
    shift: float, clogged: int = 0, at_opening: int = 0, noise: int = 2, **labels: str
) -> list[dict[str, Any]]:
    """Twenty seeds whose times scatter alike in each variant; the first ones clog."""
    times = 1.9 + 0.1 * np.random.default_rng(1).standard_normal(20)
    own = 1e-3 * np.random.default_rng(noise).standard_normal(20)
    ends = [OPENING] * at_opening + ["clogged"] * clogged
    return [
        row(k + 1, None if k < len(ends) else float(times[k] + shift + own[k]),
            ends[k] if k < len(ends) else "empty", **labels)
        for k in range(20)
    ]  # fmt: skip


def cases_of(study, seeds=(1, 2)) -> list:
    """The labelled cases that a study would run."""
    with mock.patch("silo2d.run.sweep.run_cases", lambda cases, **how: cases):
        return study.run(out=Path("nowhere"), seeds=seeds, workers=None, quiet=True)


def test_the_variants_of_disorder_share_packings_and_steps():
    cases = cases_of(disorder)
    assert len(cases) == 2 * 3 * 2
    assert len({run_digest(case) for _, case in cases}) == len(cases)
    assert len({packing_digest(case, case.settings.run.seed) for _, case in cases}) == 4
    assert {case.time_step for _, case in cases} == {3.5e-6}
    for labels, case in cases:
        assert case.settings.disorder.per == labels["disorder"]
        assert case.settings.run.seed == labels["seed"]
        assert case.silo_name == labels["silo"]


def test_the_fillings_have_a_packing_each_for_both_doors():
    cases = cases_of(filling)
    assert len(cases) == 2 * 3 * 2 * 2
    assert len({run_digest(case) for _, case in cases}) == len(cases)
    assert len({packing_digest(case, case.settings.run.seed) for _, case in cases}) == 2 * 3 * 2
    for labels, case in cases:
        assert (case.settings.run.door_speed is not None) == (labels["door"] == "drawn")
        assert bool(case.settings.fill.friction) == (labels["filling"] == "friction")
        assert (case.settings.fill.layer is not None) == (labels["filling"] == "layers")


def test_times_are_compared_seed_by_seed():
    """Student's paired t: the interval just excludes zero where p is 0.05."""
    first, other = variant(0.0, disorder="none"), variant(0.002, noise=3, disorder="pair")
    sample, half = paired(other, first, "discharge_time_s")
    assert half is not None
    assert sample.mean is not None
    t = [[r["discharge_time_s"] for r in rows] for rows in (other, first)]
    low, high = ttest_rel(*t).confidence_interval(0.95)
    assert (sample.mean - half, sample.mean + half) == pytest.approx((low, high), rel=1e-9)
    # The seeds' own scatter, fifty times the shift, has cancelled.
    assert abs(sample.mean - 0.002) < 1e-3
    assert "longer by 0.1 %" in findings(other, first)[0]


def test_only_seeds_that_emptied_in_both_variants_are_paired():
    first, other = (
        variant(0.0, clogged=3, disorder="none"),
        variant(0.0, clogged=5, disorder="pair"),
    )
    assert paired(other, first, "t90_s")[0].n == 15


def test_counts_are_compared_by_fishers_test():
    assert fisher_p(9, 20, 1, 20) == pytest.approx(fisher_exact([[9, 11], [1, 19]]).pvalue)
    assert fisher_p(0, 0, 1, 20) is None
    first, other = (
        variant(0.0, clogged=1, disorder="none"),
        variant(0.0, clogged=9, disorder="pair"),
    )
    words = findings(other, first)
    assert words[2] == "clogs more often (p 0.0084)"
    assert words[3] == "at the opening as often within noise"
    assert math.isclose(fisher_p(2, 20, 3, 20) or 0, 1.0)


def study_rows() -> list[dict[str, Any]]:
    kinds = {"none": (0.0, 1), "particle": (0.0, 2), "pair": (0.05, 9)}
    return [
        r
        for noise, (per, (shift, k)) in enumerate(kinds.items())
        for r in variant(shift, clogged=k, noise=noise, disorder=per)
    ]  # fmt: skip


def test_the_report_has_numbers_and_verdicts():
    text = disorder.report(study_rows())
    assert "all alike" in text
    assert "A3, per pair: time longer by" in text
    assert "9 of 20 [0.26, 0.66]" in text
    rows = [
        {**r, "filling": f, "door": d}
        for f in ("frictionless", "friction", "layers")
        for d in ("at once", "drawn")
        for r in variant(0.0, at_opening=2)
    ]
    text = filling.report(rows)
    assert "A3, layers, door drawn" in text
    assert "packing fraction" in text
    failed = [*study_rows(), {"silo": "A3", "seed": 21, "state": "failed", "disorder": "pair",
                              "reason": "no room", "outcome": None}]  # fmt: skip
    assert "failed: silo A3, seed 21: no room" in disorder.report(failed)


def test_the_figures_can_be_drawn(tmp_path):
    from granulab.campaign.output.figure import write_figure

    picture = write_figure(tmp_path / "disorder.png", lambda: disorder.draw(study_rows()))
    assert picture.stat().st_size > 10_000
    assert find("disorder") is disorder
    assert find("filling") is filling
