"""Whether the optimum moves with a property: claims on made-up rows, and a law of scale."""

import math

import pytest
from made_damper_rows import done
from small_damper import CASE

from damper3d.case.case import DamperCase
from damper3d.reproduce.quantities.properties import STANDARD, VALUES, points, span
from damper3d.reproduce.quantities.sensitivity import SENSITIVITY, peaks_of
from damper3d.reproduce.sensitivity import cases, draw, report
from damper3d.run.protocol import run
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.output.figure import write_figure


def _level(name: str, value: float) -> float:
    """A factor of eta that goes as secs 6.4.1 and 8.5.1.3 say."""
    slopes = {"density": -0.02, "modulus": 0.02, "restitution": 0.2, "friction": 0.0}
    if name == "standard":
        return 1.0
    return 1 + slopes[name] * (span(name, value) - span(name, STANDARD[name]))


def _rows(optimum=lambda name, value: 5.2, level=_level) -> list[dict]:
    """Three packings of each point, that differ by +-0.01 in eta."""
    rows = []
    for labels in points():
        name, value, gamma = labels.values()
        top = optimum(name, value)
        eta = level(name, value) * (0.8 - 0.4 * math.log(gamma / top) ** 2 / (1 + gamma / 20))
        for seed, off in ((1, -0.01), (2, 0.0), (3, 0.01)):
            row = done(labels, frequency_hz=20.0, efficiency=eta + off, efficiency_interval=None)
            rows.append(row | {"seed": seed})
    return rows


def _checks(rows: list[dict]) -> list[list[bool | None]]:
    found = SENSITIVITY.judge(claims_of("damper_sensitivity"), peaks_of(rows))
    return [[check.holds for check in verdict.checks] for verdict in found]


def test_rows_as_the_thesis_says_hold_in_every_claim():
    """The noise of the packings is 0.01 about each mean, the trends are 0.1 and more of it."""
    assert _checks(_rows()) == [[True] * 4, [True] * 4, [True], [True], [True]]


def test_an_optimum_that_moves_with_the_modulus_is_seen():
    """From 5.2 to 8 at the stiffest; noise leaves an interval of some per cent."""
    rows = _rows(lambda name, value: 8.0 if (name, value) == ("modulus", 33e9) else 5.2)
    stays, *_ = _checks(rows)
    assert stays == [True, False, True, True]
    assert "moves at 3.3e+10" in report(rows)


def test_trends_that_go_the_other_way_fail_and_none_within_noise_is_not_judged():
    _, _, modulus, density, restitution = _checks(_rows(level=lambda n, v: 2 - _level(n, v)))
    assert (modulus, density, restitution) == ([False], [False], [False])
    flat = _checks(_rows(level=lambda name, value: 1.0))
    assert flat[2:] == [[None], [None], [None]]


def test_reports_and_figures_of_whole_and_of_cut_off_tables(tmp_path):
    rows = _rows()
    text = report(rows)
    assert text.startswith(f"complete: {len(points())} points, 3 packings each")
    assert "5.2" in next(line for line in text.splitlines() if line.startswith("  standard"))
    write_figure(tmp_path / "whole.png", lambda: draw(rows))
    part = [row for row in rows if row["property"] in ("standard", "friction")][:100]
    assert report(part).startswith("INCOMPLETE: ")
    write_figure(tmp_path / "part.png", lambda: draw(part))
    assert "cannot be judged yet" in report([])
    assert write_figure(tmp_path / "none.png", lambda: draw([])).exists()


def test_each_case_changes_one_property():
    found = cases([1])
    assert len(found) == len(points())
    for labels, case in found:
        law = case.settings.law
        given = {"density": law.density, "modulus": law.youngs_modulus,
                 "restitution": law.restitution, "friction": law.friction}  # fmt: skip
        changed = {name: value for name, value in given.items() if value is not None}
        name = labels["property"]
        assert changed == ({} if name == "standard" else {name: pytest.approx(labels["value"])})
    assert set(VALUES) == set(STANDARD)


def test_density_and_modulus_enter_as_their_ratio(tmp_path):
    """Forces grow with E, masses with rho and the enclosure moves as prescribed: eta keeps.

    A factor of 4 in both scales every number of the law by a power of two, so that not even the
    last bit of a motion changes.
    """
    both = {"law.density": "4760 kg/m3", "law.youngs_modulus": "0.4 GPa"}
    one, other = (
        run(DamperCase.load("thesis", CASE | changes), out=tmp_path, warn=lambda text: None)
        for changes in ({}, both)
    )
    assert other.efficiency_per_cycle == pytest.approx(one.efficiency_per_cycle, rel=1e-9)
    assert other.mass_kg == pytest.approx(4 * one.mass_kg)
    assert one.efficiency > 0.05
