"""The causes of the half V: how an onset is read off a curve, the study's words on made runs."""

import math
from pathlib import Path

import numpy as np
import pytest

from damper3d.reproduce import causes
from damper3d.reproduce.causes import AT, FIRST, READINGS, VARIANTS, Rise, rise_of
from damper3d.reproduce.panels import labels_of
from damper3d.reproduce.quantities import shapes as quantities
from damper3d.reproduce.quantities.optima import pooled_scatter
from damper3d.studies.map.grid import GAMMAS
from granulab.campaign.output.results import read_results

HUMP = np.array([12.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0])


def made(onset_of, seeds=(1, 2), scatter=0.01, eta=None):
    """Runs whose eta is a hump over ln Gamma about the onset of (variant, ratio), per packing."""
    rows = []
    for labels in labels_of(causes.panels()):
        factor = (labels["frequency_hz"] / 40) ** 2
        for seed in seeds:
            top = onset_of(labels["variant"], labels["ratio"]) * factor
            top *= math.exp(scatter * (1 if seed % 2 else -1))
            value = (eta or hump)(labels["gamma"], top)
            rows.append({
                **labels, "seed": seed, "efficiency": value, "efficiency_wall_work": value,
                "efficiency_interval": [value - 1e-4, value + 1e-4], "fill_ratio": 0.411,
                "state": "done", "reason": "",
            })  # fmt: skip
    return rows


def hump(gamma, top):
    return 0.9 - math.log(gamma / top) ** 2


def step_up(gamma, top):
    """As of a bed that begins to bounce: little below the onset, a slow fall past it."""
    return 0.15 if gamma < 0.85 * top else 0.9 * (gamma / top) ** -0.7


def shipped(rise):
    return lambda variant, ratio: 22.0 * (rise if ratio > 1 else 1.0)


# Readings


@pytest.mark.parametrize("name", [
    "parabola", "thesis's, parabola", "thesis's, spline over ln Gamma",
])  # fmt: skip
def test_smooth_readings_find_the_top_of_a_parabola(name):
    """eta is a parabola in ln Gamma, which both a parabola and a cubic spline reproduce exactly."""
    eta = np.array([hump(gamma, 23.0) for gamma in HUMP])
    assert READINGS[name].of(HUMP, eta) == pytest.approx(23.0, rel=1e-9)


def test_spline_over_gamma_finds_the_top_of_a_cubic():
    """0.9 - ((Gamma - 23)/20)^2 + ((Gamma - 23)/60)^3 is flat at 23 and highest there up to 50."""
    x = HUMP - 23.0
    eta = 0.9 - (x / 20) ** 2 + (x / 60) ** 3
    assert causes.by_spline(HUMP, eta) == pytest.approx(23.0, rel=1e-9)


def test_largest_point_is_one_of_the_grid_and_the_steepest_rise_lies_before_it():
    eta = np.array([step_up(gamma, 23.0) for gamma in HUMP])
    assert causes.by_largest(HUMP, eta) == 20.0
    assert causes.by_steepest(HUMP, eta) == pytest.approx(math.sqrt(15 * 20))


def test_curves_without_a_peak_have_no_onset():
    falling = 0.3 + 0.5 * ((HUMP - 45) / 30) ** 2  # its one turn is a minimum
    assert math.isnan(causes.by_parabola(HUMP, falling))
    assert math.isnan(causes.by_spline(HUMP, falling))


def test_on_the_thesis_gammas_a_rise_of_a_quarter_reads_as_one_of_a_half():
    """Onsets of 22 and 27.5 lie between 20 and 30, the first nearer to 20 and the second to 30."""
    rows = made(shipped(1.25), scatter=0.0, eta=step_up)
    finer = [
        row | {"gamma": 27.6 if row["ratio"] > 1 else 22.1, "efficiency": 1.0}
        for row in rows
        if (row["frequency_hz"], row["orientation"], row["gamma"]) == (*AT, 20.0)
    ]
    own = causes.read_rise(rows + finer, READINGS["largest point"], AT)
    assert own.onsets == pytest.approx((22.1, 27.6))
    rise = causes.read_rise(rows + finer, READINGS["thesis's, largest point"], AT)
    assert rise.onsets == pytest.approx((20.0, 30.0))
    assert math.expm1(rise.value) == pytest.approx(0.5)
    assert {gamma for gamma in GAMMAS if 15 < gamma < 40} == {20.0, 30.0}  # Table 6.1


# The rise and its interval


def test_rise_is_the_ratio_of_geometric_means_with_the_scatter_of_a_difference():
    """s over n packings each: t s sqrt(1/n1 + 1/n2), here by hand of two and two, t(2) = 4.303."""
    rise = rise_of([[math.log(20.0), math.log(21.0)], [math.log(30.0), math.log(30.0)]])
    assert math.exp(rise.value) == pytest.approx(30 / math.sqrt(20 * 21))
    sd = math.sqrt((math.log(21 / 20) ** 2 / 2 + 0.0) / 2)  # both samples pooled
    assert rise.half_width() == pytest.approx(4.302653 * sd, rel=1e-6)
    assert rise.freedom == 2


def test_one_packing_each_leaves_the_interval_open():
    rise = rise_of([[math.log(20.0)], [math.log(31.0)]])
    assert rise.half_width() == math.inf
    assert rise.words == "+55 %"
    assert rise.reaches
    assert not rise_of([[math.log(20.0)], [math.log(29.0)]]).reaches


def test_variants_of_one_packing_have_the_scatter_of_the_table_of_shapes():
    """Its optima at 40 Hz, of three packings each, pooled: kept to two digits."""
    found = causes.rises(causes.optima(made(shipped(1.24), seeds=(1,))))
    assert {rise.freedom for rise in found.values()} == {causes.SCATTER[1]}
    path = Path(__file__).parents[2] / "docs/results/damper3d/reproduce-shapes.csv"
    optima = [one for line, one in quantities.optima(read_results(path)[1]).items()
              if line.frequency == 40.0]  # fmt: skip
    sd, freedom = pooled_scatter(optima)
    assert (round(sd, 3), freedom) == causes.SCATTER


@pytest.mark.parametrize(("rise", "error", "reaches"), [
    (0.24, 0.02, False), (0.45, 0.02, True), (0.6, 0.001, True), (0.45, 0.001, False),
])  # fmt: skip
def test_a_rise_reaches_the_printed_one_within_its_interval_or_above(rise, error, reaches):
    assert Rise(math.log1p(rise), error, 20, (22.0, 22.0 * (1 + rise))).reaches is reaches


# The study


def test_every_variant_changes_one_setting_of_both_shapes():
    """All but the first; the first is what `shapes` runs, at all its places."""
    panels = {(p.labels["variant"], p.labels["ratio"], p.labels["orientation"]): p
              for p in causes.panels()}  # fmt: skip
    for (variant, ratio, orientation), panel in panels.items():
        changed = dict(panel.changes.items() - panels[FIRST, ratio, orientation].changes.items())
        assert changed == VARIANTS[variant]
    assert [len(changes) for changes in VARIANTS.values()].count(0) == 1
    places = {(f, o) for (v, _, o), p in panels.items() if v == FIRST for f, _ in p.points}
    assert places == {(f, o) for f in (20.0, 40.0) for o in ("vertical", "horizontal")}


def test_all_cases_of_the_study_are_dampers_that_can_run():
    for panel in causes.panels():
        ((_, case),) = panel.cases([1], panel.points[:1])
        assert case.count == 90


def test_report_names_the_variants_that_reach_it_and_those_that_differ():
    def onset(variant, ratio):
        rise = {"friction 0.1": 1.5, "friction 0.3": 1.35}.get(variant, 1.24)
        return 22.0 * (rise if ratio > 1 else 1.0)

    text = causes.report(made(onset))
    assert "reach the printed +50 %: friction 0.1\n" in text
    assert f"differ from {FIRST}: friction 0.1, friction 0.3\n" in text
    assert "as shipped                  40 Hz vertical" in text
    causes.draw(made(onset))


def test_nothing_differs_where_all_variants_rise_alike():
    text = causes.report(made(shipped(1.24)))
    assert "reach the printed +50 %: none" in text
    assert f"differ from {FIRST}: none" in text


def test_a_study_without_runs_says_so_and_is_drawn():
    text = causes.report([])
    assert text.startswith("INCOMPLETE: 0 of ")
    assert "reach" not in text.split("onset: as in")[0]
    causes.draw([])
