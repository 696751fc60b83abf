"""Estimates over seeds against closed forms, and the order of a study's combinations."""

import dataclasses
import math
from pathlib import Path

import pytest
from analytic import students_t, wilson_interval
from made_sweeps import CASE, LATE, MADE, SPEED, STUCK, TIME, A, B, compared, lost, run, seeds

from granulab.campaign.output.layout import with_half_width
from granulab.campaign.output.statistics import difference_of_shares, rank_correlation
from granulab.campaign.sweeps.report.axes import axes_of
from granulab.campaign.sweeps.report.quantities import estimate, pooled
from granulab.campaign.sweeps.report.summary import as_text, ranked_by, summary
from granulab.campaign.sweeps.report.words import ranking_as_text
from granulab.errors import InputError

# Estimates


@pytest.mark.parametrize("speeds", [[1.0, 2.0], [1.0, 2.0, 4.0]])
def test_a_mean_has_students_interval(speeds):
    """t sd/sqrt(n), t of one and two degrees of freedom in closed form; rounding."""
    n, mean = len(speeds), math.fsum(speeds) / len(speeds)
    sd = math.sqrt(math.fsum((x - mean) ** 2 for x in speeds) / (n - 1))
    half = students_t(n - 1) * sd / math.sqrt(n)
    found = estimate(SPEED, seeds(speeds))
    assert (found.n, found.of) == (n, n)
    assert found[:3] == pytest.approx((mean, mean - half, mean + half))


@pytest.mark.parametrize(("k", "n"), [(0, 3), (1, 5), (5, 5)])
def test_a_share_has_wilsons_interval_over_the_runs_that_are_done(k, n):
    rows = [run(1.0, seed, stuck=seed <= k) for seed in range(1, n + 1)]
    found = estimate(STUCK, [*rows, lost("failed"), lost("interrupted")])
    assert (found.n, found.of, found.mean) == (k, n, k / n)
    assert found[1:3] == pytest.approx(wilson_interval(k, n), abs=1e-12)


def test_a_run_without_a_value_lacks_in_the_mean_and_counts_in_the_share():
    """Of a stuck one the time does not count, though it has one."""
    rows = [*seeds([1.0, 2.0]), run(4.0, 3, stuck=True), run(None, 4, stuck=True), lost()]
    assert estimate(TIME, rows)[:1] == (0.75,)
    assert estimate(TIME, rows)[3:5] == (2, 4)
    assert estimate(SPEED, rows)[3:5] == (3, 4)
    assert estimate(STUCK, rows)[3:5] == (2, 4)


def test_one_run_has_the_interval_of_its_own_cycles_and_none_without():
    assert estimate(SPEED, [run(1.0, speed_interval=[0.9, 1.2])])[:3] == (1.0, 0.9, 1.2)
    assert estimate(SPEED, [run(1.0, speed_interval=None)])[:3] == (1.0, None, None)
    assert estimate(TIME, [run(2.0)])[:3] == (0.5, None, None)
    assert estimate(SPEED, [lost()])[:3] == (None, None, None)


def test_a_mean_over_combinations_has_the_interval_of_an_analysis_of_variance():
    """Two of two runs each, a spread of 2 between them: s^2 is the mean of both, t of two degrees,
    and the variance of the mean of means s^2 (1/2 + 1/2)/4. A group of one run has that s too."""
    groups = [seeds([1.0, 2.0]), seeds([3.0, 6.0])]
    s = math.sqrt((0.5 + 4.5) / 2)
    found = pooled(SPEED, groups)
    assert found.mean == pytest.approx(3.0)
    assert found.half_width == pytest.approx(students_t(2) * s * math.sqrt(1.0) / 2)
    three = pooled(SPEED, [*groups, [run(9.0)]])
    assert three.mean == pytest.approx(5.0)
    assert three.half_width == pytest.approx(students_t(2) * s * math.sqrt(2.0) / 3)
    assert pooled(SPEED, [[run(1.0)], [run(2.0)]]).half_width is None
    assert pooled(STUCK, groups)[3:5] == (0, 4)


@pytest.mark.parametrize(
    ("counts", "printed"),
    [((56, 70, 48, 80), (0.0524, 0.3339)), ((9, 10, 3, 10), (0.1705, 0.8090))],
)
def test_the_difference_of_shares_is_newcombes(counts, printed):
    """Statist. Med. 17 (1998) 873, Table II, method 10, four digits."""
    assert difference_of_shares(*counts) == pytest.approx(printed, abs=5e-5)


def test_rank_correlation_of_ranks_and_its_interval():
    """1 - 6 sum d^2/(n (n^2 - 1)); atanh r +- 1.96 sqrt((1 + r^2/2)/(n - 3)): Bonett and Wright."""
    x, y = [1.0, 2.0, 3.0, 4.0, 5.0], [10.0, 30.0, 20.0, 50.0, 40.0]
    r = 1 - 6 * 4 / (5 * 24)
    half = 1.959964 * math.sqrt((1 + r**2 / 2) / 2)
    found = rank_correlation(x, y)
    assert found.value == pytest.approx(r)
    assert (found.low, found.high) == pytest.approx(
        (math.tanh(math.atanh(r) - half), math.tanh(math.atanh(r) + half)), rel=1e-6
    )
    assert rank_correlation(x[:3], y[:3]) is None
    assert rank_correlation(x, [1.0] * 5) is None


@pytest.mark.parametrize("sign", [1, -1])
def test_a_few_pairs_in_order_leave_their_rank_correlation_open(sign):
    """Four are in order, or in reverse, once in twelve by chance; twenty are not."""
    found = rank_correlation(range(4), [sign * v**3 for v in range(4)])
    assert found.value == sign
    assert found.low < 0 < found.high
    assert sign in (found.low, found.high)
    many = rank_correlation(range(20), [sign * v for v in range(20)])
    assert min(abs(many.low), abs(many.high)) > 0.8


# Axes


def test_keys_of_one_value_are_no_axis_and_those_that_go_together_are_one():
    """Two friction keys with one value; a case that goes with the number of its particles."""
    labels = [
        {"case": case, "a.width_m": width, "b.count": count, "other": width, "same": 1}
        for case, count in (("x", 3), ("y", 7))
        for width in (0.02, 0.01)
    ]
    other, same = A._replace(column="other", label="other"), A._replace(column="same")
    axes = axes_of([CASE, A, B, other, same], labels)
    assert [axis.varied.label for axis in axes] == ["b.count", "a.width"]
    assert [one.label for one in axes[0].alike] == ["case"]
    assert axes[1].heading == "a.width [mm] (with other)"
    assert axes[1].positions == [10.0, 20.0]


@pytest.mark.parametrize(
    ("values", "is_log"),
    [([1, 2, 4, 8], True), ([1, 4, 7, 10], False), ([1, 10], False), ([0, 1, 100], False),
     ([1.0, 1.5, 2.0, 3.0, 5.0, 20.0, 60.0], True)],
)  # fmt: skip
def test_a_scale_is_logarithmic_where_ratios_are_more_even_than_steps(values, is_log):
    (axis,) = axes_of([B], [{"b.count": value} for value in values])
    assert axis.is_logarithmic == is_log


# Ranking


def rows_of_four():
    """Fast but often stuck; twice the same; slow; and one whose runs failed."""
    return [
        *(run(9.0, k, stuck=k < 3, **{"b.count": 1}) for k in (1, 2, 3)),
        *seeds([4.0, 4.2, 4.4], **{"b.count": 2}),
        *seeds([4.0, 4.2, 4.4], **{"b.count": 3}),
        *seeds([1.0, 1.1, 1.2], **{"b.count": 4}),
        *(lost("failed", k, **{"b.count": 5}) for k in (1, 2, 3)),
        *seeds([4.3, 4.4], **{"b.count": 6}), lost("interrupted", 3, **{"b.count": 6}),
    ]  # fmt: skip


def test_the_best_first_ties_alike_and_without_a_value_last():
    """First the share of stuck runs, then the speed; failures leave a combination in its place."""
    ranking = compared([B], rows_of_four()).ranking
    order = [(one.rank, one.combination.labels["b.count"]) for one in ranking]
    assert order == [(1, 6), (2, 2), (2, 3), (4, 4), (5, 1), (None, 5)]
    assert [one.combination.done for one in ranking] == [2, 3, 3, 3, 3, 0]


def test_what_cannot_be_told_from_the_best_is_said():
    """4.35 of two against 4.2 of three with a deviation of 0.2: Welch's noise is 0.4. 1.1 is far
    off; two of three stuck against none of two is not, by Newcombe, but the speed is."""
    as_good = {one.combination.labels["b.count"]: one.as_good
               for one in compared([B], rows_of_four()).ranking}  # fmt: skip
    assert as_good == {6: True, 2: True, 3: True, 4: False, 1: False, 5: None}


def test_of_single_runs_nothing_is_told_but_by_their_cycles():
    rows = [run(2.0, **{"b.count": 1}), run(1.0, **{"b.count": 2})]
    assert [one.as_good for one in compared([B], rows).ranking] == [True, None]
    known = [row | {"speed_interval": [row["speed"] - 0.1, row["speed"] + 0.1]} for row in rows]
    assert [one.as_good for one in compared([B], known).ranking] == [True, False]


def test_another_quantity_goes_first_where_it_is_asked_for():
    """Less time is better; without stuck runs first, the fast and often stuck one is the best."""
    found = compared([B], rows_of_four(), ranked_by(MADE, "time"))
    assert [one.combination.labels["b.count"] for one in found.ranking][:2] == [1, 6]
    with pytest.raises(InputError, match=r"--rank-by 'tim': did you mean 'time'\? known: speed,"):
        ranked_by(MADE, "tim")


def test_cost_is_the_mean_of_the_runs_that_are_done():
    rows = [run(1.0, 1, cpu_s=2.0, **{"b.count": 1}), run(1.0, 2, cpu_s=4.0, **{"b.count": 1}),
            lost("failed", 3, **{"b.count": 1})]  # fmt: skip
    assert compared([B], rows).combinations[0].cpu_s == 3.0


# Words


@pytest.mark.parametrize(
    ("mean", "half", "words"),
    [(0.3412, 0.0123, "0.341 ± 0.012"), (12.3, 4.5, "12.3 ± 4.5"), (123.4, 45.6, "123 ± 46"),
     (0.5, None, "0.5"), (1e7, 2e6, "1e+07 ± 2e+06"), (2.0, 0.0, "2 ± 0")],
)  # fmt: skip
def test_a_number_has_the_digits_that_its_interval_allows(mean, half, words):
    assert with_half_width(mean, half) == words


def wide_rows():
    labels = {"case": "a-case-whose-name-is-longer-than-a-column-of-the-terminal", "b.count": 1}
    return [
        row
        for k in range(30)
        for row in [
            *seeds([1.0 + k, 1.5 + k], **{**labels, "case": f"{k}{labels['case']}", "b.count": k}),
            lost("failed", 3, **{**labels, "case": f"{k}{labels['case']}", "b.count": k}),
        ]
    ]


def test_a_ranking_fits_the_terminal_and_leaves_nobody_out_in_silence(monkeypatch):
    """80 columns; what is not shown is counted, what failed is in its line."""
    monkeypatch.setenv("COLUMNS", "80")
    comparison = compared([CASE, A, B], [row | {"a.width_m": 0.01} for row in wide_rows()])
    text = ranking_as_text(comparison)
    assert max(map(len, text.split("\n"))) <= 80
    assert "... and 18 more" in text
    assert text.count("1 failed") == 12
    assert "made: ranked by share stuck (least first), then speed [m/s] (most" in text
    assert "30.2 ± 3.2 (2)" in text  # of 30.0 and 30.5: t(1) 0.25
    table = summary(comparison, Path("folder"))
    whole = as_text(comparison, table)
    assert max(map(len, whole.split("\n"))) <= 80
    assert "90 runs: 60 done, 30 failed, 0 interrupted" in " ".join(whole.split())
    assert "failed: 20 more; the table has their reasons" in whole


def test_endings_without_a_column_are_remarks():
    rows = [run(1.0, 1, **{"b.count": 1}), run(2.0, 2, late=True, **{"b.count": 1}),
            *seeds([1.0, 2.0], **{"b.count": 2})]  # fmt: skip
    comparison = compared([B], rows)
    assert LATE not in comparison.shown
    assert "1 late" in ranking_as_text(comparison)
    assert comparison.endings == {"late": 1}


def test_json_has_every_quantity_whether_runs_have_it_or_not():
    """Null where none has; a count and an interval for each ending."""
    row = summary(compared([B], [lost("failed", **{"b.count": 1})]), Path())["combinations"][0]
    assert row["b.count"] == 1
    assert (row["runs"], row["not_done"], row["stuck"]) == (0, 1, 0)
    for key in ("speed.mean", "speed.sd", "speed.low", "speed.high", "time.mean", "cpu_s"):
        assert row[key] is None, key


def test_without_an_order_there_is_no_ranking():
    none = dataclasses.replace(MADE, order=())
    assert ranking_as_text(compared([B], rows_of_four(), none)) == ""
