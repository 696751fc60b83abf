"""Shares of friction and of particle-particle contacts: the thesis's claims on made-up rows."""

import math
from typing import Any

import pytest
from made_damper_rows import done, shares, two_peaks

from damper3d.reproduce.quantities.shares import SHARES, Readings, landmarks
from damper3d.reproduce.shares import cases, draw, points, report
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.output.figure import write_figure

ONSET, OPTIMUM = 20.0, 3.0


def _as_the_thesis_says(size: int, gamma: float, counted: float = 0.0) -> tuple[float, float]:
    """Particle-particle and friction shares that agree with all of sec. 6.5."""
    fall = 0.04 * math.log(gamma)
    pair = 0.95 - fall if gamma < ONSET else 0.93
    friction = 0.85 - 0.05 * math.log(gamma) if gamma < ONSET else 0.80
    smaller = 0.02 * (size - 3)
    return pair - smaller, friction - smaller + counted


def _rows(shape=_as_the_thesis_says, **changed: Any) -> list[dict]:
    """All points; `changed` goes over each row. Friction is 3 points more as the thesis counts."""
    rows = []
    for labels in points():
        size, frequency, gamma = labels.values()
        here = shape(size, gamma)
        if frequency == 160.0 and gamma >= ONSET:  # no bouncing bed: the fall goes on
            here = shape(size, 0.999 * ONSET)
            here = here[0] - 1e-3 * gamma, here[1] - 1e-3 * gamma
        second = ONSET if frequency == 40.0 else None
        results = {
            "efficiency": two_peaks(gamma, OPTIMUM, second),
            "efficiency_interval": None,
            **shares(*here),
            # 3 points more, with the dashpot in it
            **shares(here[0], here[1] - 0.02, "shares_contact_count"),
        }
        rows.append(done(labels, **results | changed))
    return rows


def _checks(rows: list[dict]) -> dict[str, dict[str, bool | None]]:
    return {s.words: {check.of: check.holds for check in s.checks} for s in _verdicts(rows)}


def _verdicts(rows: list[dict]) -> list[Any]:
    return SHARES.judge(claims_of("damper_shares"), Readings(rows, landmarks(rows)))


def test_peaks_of_the_runs_themselves_part_the_curves():
    """Parabolas in ln Gamma: the vertex of the three best points is the peak itself."""
    found = landmarks(_rows())
    assert set(found.fluidisation) == {(d, f) for d in (3, 4, 5, 6) for f in (40.0, 160.0)}
    assert found.fluidisation[5, 160.0] == pytest.approx(OPTIMUM, rel=0.02)
    assert set(found.bouncing_bed) == {(d, 40.0) for d in (3, 4, 5, 6)}
    assert found.bouncing_bed[3, 40.0] == pytest.approx(ONSET, rel=0.02)


def test_rows_as_the_thesis_says_hold_in_every_claim():
    checks = _checks(_rows())
    assert len(checks) == 11
    assert all(holds for by_count in checks.values() for holds in by_count.values())


def test_a_point_below_sixty_per_cent_is_found_and_named():
    rows = _rows()
    low = next(r for r in rows if r["diameter_mm"] == 6 and r["gamma"] == 7.0)
    low |= shares(0.55, 0.7)
    words = "Particle-particle contacts dissipate more than 60 % everywhere."
    found = next(one for one in _verdicts(rows) if one.words == words)
    budget, counted = found.checks
    assert (budget.holds, counted.holds) == (False, True)
    assert "least 55 % (6 mm, 40 Hz, Gamma 7)" in budget.found
    assert "1 not above 60 %" in budget.found


@pytest.mark.parametrize(
    ("shape", "words"),
    [
        (lambda size, gamma: (0.9, 0.3), "Friction is the dominant source everywhere"),
        (lambda size, gamma: (0.9, 0.6), "... is about 80 % in the bouncing bed"),
        (lambda size, gamma: (0.7 + 0.02 * size, 0.8), "... the less the larger the particles"),
        (lambda size, gamma: (0.9, 0.7 + 0.05 * math.log(gamma)), "... falls from low amplitudes"),
        (lambda size, gamma: (0.3, 0.8), "... mainly between particles"),
    ],
)
def test_a_claim_fails_on_rows_that_say_otherwise(shape, words):
    checks = _checks(_rows(shape))
    own = next(holds for text, holds in checks.items() if text.startswith(words))
    assert own["budget"] is False


def test_counts_that_a_run_of_an_earlier_version_lacks_are_not_judged():
    rows = [{k: v for k, v in row.items() if "contact_count" not in k} for row in _rows()]
    assert {by_count["thesis's count"] for by_count in _checks(rows).values()} == {None}
    assert all(by_count["budget"] for by_count in _checks(rows).values())
    assert "93 / -" in report(rows) or "91 / -" in report(rows)


def test_reports_and_figures_of_whole_and_of_cut_off_tables(tmp_path):
    rows = _rows()
    text = report([row | {"seed": seed} for row in rows for seed in (1, 2, 3)])
    assert text.startswith("complete: 152 points, 3 packings each")
    assert "fluidisation optimum at Gamma 3 (3 mm), 3 (4 mm)" in text
    write_figure(tmp_path / "whole.png", lambda: draw(rows))
    part = [row for row in rows if row["diameter_mm"] == 5 and row["gamma"] < 10]
    first, *rest = report(part).splitlines()
    assert first == "INCOMPLETE: 18 of 152 points are there, with 1 of 3 packings at most"
    assert any(
        line.startswith("  lacking: diameter_mm 4, frequency_hz 40: gamma 1, 1.5") for line in rest
    )
    assert "----  budget          no run there" in "\n".join(rest)
    write_figure(tmp_path / "part.png", lambda: draw(part))
    assert report([]).startswith("INCOMPLETE: 0 of 152 points")
    assert write_figure(tmp_path / "none.png", lambda: draw([])).exists()


def test_the_cases_are_the_thesiss():
    """Table 6.1: equal volumes, fill ratio 0.466, whatever the size."""
    found = cases([1], {"run.cycles": 4})
    assert len(found) == 152
    for labels, case in found[::19]:
        assert case.fill_ratio == pytest.approx(0.466, abs=1e-3)  # of whole particles
        assert case.count == {3: 1659, 4: 700, 5: 358, 6: 207}[labels["diameter_mm"]]
        assert case.settings.motion.orientation == "vertical"
        assert case.settings.motion.gamma == labels["gamma"]
