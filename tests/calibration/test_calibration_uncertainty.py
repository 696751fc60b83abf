"""What sigma means: it covers the truth in 68 % of all measurements, and formulas carry it."""

import math

import numpy as np
import pytest

from calibration.statistics.correlated import pool
from calibration.statistics.uncertainty import Estimate, of_trials, pooled, student, through
from granulab.errors import InputError


@pytest.mark.parametrize("trials", [2, 3, 5, 12])
def test_sigma_of_a_mean_covers_the_truth_in_68_percent(trials):
    """Student: exact for normal scatter. 4000 draws: 68.3 +- 4 x 0.74 %."""
    rng = np.random.default_rng(trials)
    found = [of_trials(list(rng.normal(0.5, 0.1, trials))) for _ in range(4000)]
    covered = np.mean([abs(one.value - 0.5) <= one.sigma for one in found])
    assert covered == pytest.approx(0.683, abs=0.03)


def test_students_factor():
    """One degree of freedom is Cauchy's: tan(pi/2 x 0.6827) = 1.837; many tend to 1."""
    assert student(1) == pytest.approx(math.tan(math.pi / 2 * math.erf(1 / math.sqrt(2))))
    assert student(10**6) == pytest.approx(1, abs=1e-5)


def test_one_trial_has_no_sigma_and_none_is_refused():
    assert of_trials([0.4]) == Estimate(0.4, None, 1)
    with pytest.raises(InputError, match="at least one"):
        of_trials([])
    with pytest.raises(InputError, match="not a finite number"):
        of_trials([0.4, math.nan])


@pytest.mark.parametrize(("between", "low"), [(0.0, 0.64), (0.6, 0.56), (5.0, 0.64)])
def test_pooled_sigma_covers_the_truth_whether_groups_are_alike_or_not(between, low):
    """Exact for groups alike and for groups far apart: 68.3 +- 3 x 1.5 %, 1000 draws.

    In between, where ten trials of three samples cannot always decide, it covers 61 %: sigma is
    then too small by a sixth, which the documentation says.
    """
    rng = np.random.default_rng(3)
    covered = 0
    for _ in range(1000):
        groups = {str(k): list(rng.normal(rng.normal(0, between), 1, 10)) for k in range(3)}
        found = pooled(groups).all
        covered += abs(found.value) <= found.sigma
    assert low < covered / 1000 < 0.73


def test_equal_groups_are_called_different_in_5_percent():
    """The p of a true null hypothesis is uniform: 5 +- 3 x 0.7 %, 1000 draws."""
    rng = np.random.default_rng(4)
    different = [
        pooled({k: list(rng.normal(0, 1, 6)) for k in "abc"}).alike is False for _ in range(1000)
    ]
    assert np.mean(different) == pytest.approx(0.05, abs=0.021)


def test_groups_that_differ_count_once_each():
    found = pooled({"a": [1.0, 1.1, 0.9, 1.0, 1.05, 0.95], "b": [3.0, 3.1]})
    assert not found.alike
    assert found.all.value == pytest.approx((1.0 + 3.05) / 2)
    assert found.all.sigma == pytest.approx(student(1) * 2.05 / 2)  # s/sqrt(2) of two means
    assert found.all.trials == 8


def test_groups_whose_trials_are_alike_to_the_digit_count_once_each():
    """Three samples of four like readings are as well known as when one reading differs by 1e-4.

    Oracle: s/sqrt(3) of three means times Student's factor; the reading moves it by 1e-3 of it.
    """
    exact = pooled({"a": [0.364] * 4, "b": [0.404] * 4, "c": [0.325] * 4})
    assert exact.p == 0
    of_means = float(np.std([0.364, 0.404, 0.325], ddof=1))
    assert exact.all.sigma == pytest.approx(student(2) * of_means / math.sqrt(3))
    nearly = pooled({"a": [0.364, 0.364, 0.364, 0.3641], "b": [0.404] * 4, "c": [0.325] * 4})
    assert exact.all.sigma == pytest.approx(nearly.all.sigma, rel=1e-2)


def test_like_readings_have_neither_scatter_nor_groups_that_differ():
    """The means of 0.1 three times and seven times differ by the last bit, which says nothing."""
    found = pooled({"a": [0.1] * 3, "b": [0.1] * 7})
    assert found.p is None
    assert found.all.scatter == 0
    assert found.all.sigma is None
    assert of_trials([0.1] * 3).sigma is None


@pytest.mark.parametrize("n", [2, 3, 5])
def test_few_correlated_values_that_differ_are_as_well_known_as_trials(n):
    """Far beyond their noise of 1e-4 they are trials: s/sqrt(n) with Student's factor, to 1e-3."""
    values = np.random.default_rng(n).normal(0.6, 0.1, n)
    found, p = pool(values, 1e-8 * np.eye(n))
    assert p < 0.01
    assert found.sigma == pytest.approx(of_trials(values.tolist()).sigma, rel=1e-3)


def test_no_test_without_two_groups_or_two_trials():
    assert pooled({"a": [1.0, 2.0]}).p is None
    assert pooled({"a": [1.0], "b": [2.0]}).p is None
    assert pooled({"a": [1.0, 1.1], "b": [2.0]}).p is not None


def test_a_formula_carries_sigma_to_first_order():
    """GUM sec. 5.1: products add relative variances, sums add variances; exact for linear ones.

    A quotient by x +- 2 % is linear to (2 %)^2 of the slope: 5e-4.
    """
    a, b = Estimate(3.0, 0.3, 5), Estimate(2.0, 0.04, 7)
    assert through(lambda x, y: x - y, a, b).sigma == pytest.approx(math.hypot(0.3, 0.04))
    product = through(lambda x, y: x * y, a, b)
    assert product.sigma == pytest.approx(6 * math.hypot(0.1, 0.02))
    assert product.trials == 5
    quotient = through(lambda x, y: x / y, a, b)
    assert quotient.sigma == pytest.approx(1.5 * math.hypot(0.1, 0.02), rel=5e-4)


def test_a_formula_of_something_without_sigma_has_none():
    found = through(lambda x, y: x * y, Estimate(3.0, 0.3, 5), Estimate(2.0, None, 1))
    assert found == Estimate(6.0, None, 1)
