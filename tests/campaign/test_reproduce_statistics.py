"""Intervals and comparisons against closed forms and printed values."""

import math
import statistics as python
from math import comb

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import fisher_exact

from granulab.campaign.output.statistics import (
    Counts,
    Sample,
    chance_of_few,
    chance_of_shares,
    mean_sd,
    noise_of_difference,
    noise_of_one_more,
    pooled_sd,
    quantile,
    slope,
    wilson,
)
from silo2d.reproduce.quantities.published import sensitivity, trials

Z2 = 3.841458820694124  # 0.95 quantile of chi-squared with one degree of freedom, z^2


@pytest.mark.parametrize("n", [1, 3, 5, 20, 100])
def test_wilson_of_none_and_all(n):
    """Wilson (1927): k = 0 gives [0, z^2/(n + z^2)], and k = n its mirror image."""
    assert wilson(0, n) == pytest.approx((0.0, Z2 / (n + Z2)), abs=1e-12)
    assert wilson(n, n) == pytest.approx((n / (n + Z2), 1.0), abs=1e-12)


@given(st.integers(1, 200), st.data())
def test_wilson_ends_are_where_the_score_is_z(n, data):
    """Both ends p solve |k/n - p| = z sqrt(p (1 - p)/n); 1e-9: the root near 0 is a difference."""
    k = data.draw(st.integers(0, n))
    for p in wilson(k, n):
        assert (k / n - p) ** 2 == pytest.approx(Z2 * p * (1 - p) / n, abs=1e-9)


def test_wilson_of_81_in_263():
    """Newcombe, Statist. Med. 17 (1998) 857, Table I: 81 of 263 gives 0.2553 to 0.3662."""
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)


def test_no_trial_excludes_nothing():
    assert wilson(0, 0) == (0.0, 1.0)


@given(st.lists(st.floats(0.1, 10), min_size=2, max_size=20))
def test_mean_and_sd_are_the_usual_ones(values):
    """Oracle: Python's statistics; rounding of the squares of 10."""
    found = mean_sd(values)
    assert found.n == len(values)
    assert found.mean == pytest.approx(python.mean(values))
    assert found.sd == pytest.approx(python.stdev(values), abs=1e-9)


def test_one_value_has_no_spread_and_none_no_mean():
    assert mean_sd([2.5]) == Sample(1, 2.5, None)
    assert mean_sd([]) == Sample(0, None, None)


@pytest.mark.parametrize(("freedom", "t"), [(1, 12.706), (4, 2.776), (10, 2.228)])
def test_students_quantile(freedom, t):
    """Any table of Student's t, two-sided 95 %."""
    assert quantile(freedom) == pytest.approx(t, abs=5e-4)


def test_welch_with_like_samples_is_students():
    """Equal n and s: the degrees of freedom are 2 (n - 1), and the error is s sqrt(2/n)."""
    alike = Sample(5, 1.0, 0.1)
    expected = quantile(8) * 0.1 * math.sqrt(2 / 5)
    assert noise_of_difference(alike, alike) == pytest.approx(expected)


def test_welch_with_one_exact_sample_has_the_freedom_of_the_other():
    """s2 = 0: what remains is Student's interval of the first mean."""
    found = noise_of_difference(Sample(3, 1.0, 0.2), Sample(9, 1.0, 0.0))
    assert found == pytest.approx(quantile(2) * 0.2 / math.sqrt(3))


def test_no_noise_without_a_spread():
    assert noise_of_difference(Sample(1, 1.0, None), Sample(3, 1.0, 0.1)) is None


def test_pooled_spread_weighs_by_degrees_of_freedom():
    """s^2 = (2 * 1 + 4 * 4)/6 = 3, six degrees of freedom; a single value adds nothing."""
    pooled = pooled_sd([Sample(3, 0.0, 1.0), Sample(5, 9.0, 2.0), Sample(1, 5.0, None)])
    assert pooled == (pytest.approx(math.sqrt(3)), 6)
    assert pooled_sd([Sample(1, 5.0, None)]) is None


def test_one_more_value_lies_within_its_interval_95_times_in_100():
    """t s sqrt(1 + 1/n), drawn 4000 times: the share scatters by sqrt(.95 .05/4000) = 0.0034."""
    import numpy as np

    rng, n = np.random.default_rng(3), 4
    drawn = rng.normal(2.0, 0.3, (4000, n + 1))
    inside = [
        abs(row[n] - row[:n].mean()) <= noise_of_one_more(n, row[:n].std(ddof=1), n - 1)
        for row in drawn
    ]
    assert np.mean(inside) == pytest.approx(0.95, abs=4 * 0.0034)


def test_slope_of_a_line_is_exact_but_for_the_rounding_of_its_points():
    """y = 3 - 2 x: no scatter. Printed to 0.1, the error is 0.1/sqrt(12)/sqrt(sum (x - mean)^2)."""
    x = [0.0, 1.0, 2.0, 3.0]
    y = [3 - 2 * a for a in x]
    exact, printed = slope(x, y), slope(x, y, rounding=0.1)
    assert exact is not None
    assert printed is not None
    assert (exact.value, exact.freedom) == (pytest.approx(-2), 2)
    assert exact.error == pytest.approx(0, abs=1e-12)
    assert printed.error == pytest.approx(0.1 / math.sqrt(12) / math.sqrt(5))


@pytest.mark.parametrize("y", [[0.3, 0.3, 0.3], [0.3, 0.1 + 0.2, 0.3]])
def test_slope_of_like_values_is_none_within_rounding(y):
    flat = slope([0.0, 1.0, 2.0], y)
    assert flat is not None
    assert abs(flat.value) < flat.half_width < 1e-11


def test_intervals_that_hold_together_are_wider():
    """Bonferroni: ten at 99.5 % each; t(8) of 0.9975 is 3.833, of 0.975 2.306 (any table)."""
    one = slope([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0], [0, 1, 0, 1, 0, 1, 0, 1, 0, 1])
    assert one is not None
    assert one.half_width_among(10) / one.half_width == pytest.approx(3.833 / 2.306, rel=1e-3)


def test_no_slope_of_two_points_or_of_one_abscissa():
    assert slope([1.0, 2.0], [1.0, 2.0]) is None
    assert slope([1.0, 1.0, 1.0], [1.0, 2.0, 3.0]) is None


# The published tables


def test_a3_has_the_erratum_of_trial_5():
    """Table 5 prints 207 for 2.07 s; with it the mean is 2.0925 s, as printed (2.09)."""
    known = trials("A3")
    assert (known.n, known.clogged, known.time.n) == (5, 1, 4)
    assert known.time.mean == pytest.approx(2.0925)
    assert known.spoly_s is None
    assert known.spoly_clogged is None


@pytest.mark.parametrize(
    ("silo", "mean", "sd_percent"),
    [("A4", 0.99, 3.0), ("B3", 2.59, 7.3), ("B4", 1.21, 5.0), ("C3", 3.06, 7.8), ("C4", 1.49, 4.0),
     ("D3", 2.61, 8.0), ("D4", 1.92, 12.6)],
)  # fmt: skip
def test_means_and_spreads_are_those_that_table_5_prints(silo, mean, sd_percent):
    """Of times printed to 0.01 s, the sd moves by 0.005 sqrt(n/(n - 1)) at most; it is in %."""
    known = trials(silo).time
    assert known.mean == pytest.approx(mean, abs=0.0051)
    assert known.sd is not None
    rounding = 0.005 * math.sqrt(known.n / (known.n - 1)) / mean
    assert known.sd / known.mean == pytest.approx(sd_percent / 100, abs=rounding + 5e-4)


def test_a_silo_that_clogged_in_its_only_trial():
    known = trials("D2")
    assert (known.n, known.clogged, known.time) == (1, 1, Sample(0, None, None))
    assert known.spoly_clogged is True


def test_tables_7_to_11_are_whole_and_the_first_kn_is_625():
    """gamma_n/sqrt(kn) = 40 in all rows of Table 7 makes it 6.25e2, not 6.25e3."""
    points = sensitivity()
    counts = {p: sum(q.parameter == p for q in points) for p in ("kn", "kt", "mu", "gamma_n")}
    assert counts == {"kn": 4, "kt": 6, "mu": 5, "gamma_n": 5}
    assert len(points) == 24
    assert [p.value for p in points if p.parameter == "kn"] == [625, 2500, 1e4, 4e4]
    assert next(p for p in points if p.value == 0.10).time_s == 0.70
    assert next(p for p in points if p.value == 16000).restitution == 0.022


@pytest.mark.parametrize("table", [(2, 15, 38, 80), (0, 6, 23, 40), (3, 3, 0, 20), (5, 9, 11, 20)])
def test_one_stratum_of_shares_is_fishers_exact_test(table):
    """Compared with scipy's, whose tables hold successes and failures."""
    k, n, other_k, other_n = table
    fisher = fisher_exact([[k, n - k], [other_k, other_n - other_k]]).pvalue
    assert chance_of_shares([Counts(*table)]) == pytest.approx(fisher, rel=1e-9)


def test_strata_of_shares_are_the_sum_over_all_their_tables():
    """Two strata, all pairs of tables with their sums counted one by one."""
    strata = [Counts(1, 4, 6, 20), Counts(0, 3, 11, 20)]
    chance = [
        [comb(one.n, k) * comb(one.other_n, one.k + one.other_k - k) for k in range(one.n + 1)]
        for one in strata
    ]
    ways = [0] * 8
    for i, first in enumerate(chance[0]):
        for j, second in enumerate(chance[1]):
            ways[i + j] += first * second
    expected = sum(way for way in ways if way <= ways[1]) / sum(ways)
    assert chance_of_shares(strata) == pytest.approx(expected, rel=1e-9)


def test_trials_repeated_until_some_fail_have_the_moments_of_a_beta():
    """No k before 3 failures: the mean of (1 - p)^3 over Beta(12.5, 8.5), a product."""
    expected = (8.5 * 9.5 * 10.5) / (21 * 22 * 23)
    assert chance_of_few([Counts(0, 3, 12, 20)]) == pytest.approx(expected, rel=1e-9)


def test_trials_of_which_none_failed_end_before_the_first():
    """None is repeated there: their successes are 0, and those of another stratum decide."""
    assert chance_of_few([Counts(3, 3, 12, 20)]) == 1.0
    both = chance_of_few([Counts(2, 2, 12, 20), Counts(1, 4, 12, 20)])
    assert both == pytest.approx(chance_of_few([Counts(3, 6, 12, 20)]), rel=1e-12)
