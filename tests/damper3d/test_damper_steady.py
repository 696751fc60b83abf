"""When cycles count as steady, and how well a mean is known: made-up efficiencies."""

import numpy as np
import pytest

from damper3d.run.steady import (
    Course,
    block_interval,
    block_means,
    interval,
    is_steady,
    judged,
    verdict,
)

RNG = np.random.default_rng


def _alternating(n: int, noise: float = 0.0, seed: int = 1) -> np.ndarray:
    """Cycles of 0.04 and 0.40 in turn, as at 40 Hz and Gamma 5."""
    return 0.22 + 0.18 * (-1.0) ** np.arange(n) + noise * RNG(seed).normal(size=n)


def test_period_two_is_steady():
    """Blocks hold whole alternations; single cycles differ tenfold."""
    assert is_steady(_alternating(16))
    assert is_steady(_alternating(16, noise=0.01))


def test_a_trend_is_not_steady_until_it_has_died_out():
    """0.5 + 0.3 exp(-t/20): steady once half the run no longer sees it."""
    cycles = np.arange(200)
    values = 0.5 + 0.3 * np.exp(-cycles / 20)
    steady = [is_steady(values[:n]) for n in range(16, 200, 4)]
    assert not any(steady[:4])
    assert steady[-1]
    # Where it is called steady the judged mean is within the limit of the final value.
    n = 16 + 4 * steady.index(True)
    assert values[n - judged(n) : n].mean() == pytest.approx(0.5, rel=0.05)


def test_a_slow_trend_below_the_limit_is_let_pass():
    """A noiseless drift of 1e-3 of the mean is a trend to any test; nobody would wait for it."""
    assert is_steady(np.linspace(0.500, 0.5005, 16))


def test_noise_is_steady_once_its_mean_is_known():
    """Scatter of 40 %: 16 cycles leave the mean at +-20 %, some hundreds at +-5 %."""
    values = 0.3 * (1 + 0.4 * RNG(3).normal(size=800))
    steady = [is_steady(values[:n]) for n in range(16, 801, 4)]
    assert not any(steady[:5])
    n = 16 + 4 * steady.index(True)
    assert n > 200
    # Twice the limit: the interval that was judged is one of 95 %, and was judged many times.
    assert values[n - judged(n) : n].mean() == pytest.approx(0.3, rel=0.1)


def test_a_collapse_among_the_judged_cycles_is_not_steady():
    """Metastable: 0.83 for some cycles, then 0.15 (40 Hz, Gamma 15)."""
    rng = RNG(5)
    for good in range(3, 14):
        values = np.r_[np.full(good, 0.83), np.full(16 - good, 0.15)] + 0.01 * rng.normal(size=16)
        assert not is_steady(values), good
    # When half the run is past it, it is.
    values = np.r_[np.full(18, 0.83), np.full(30, 0.15)] + 0.002 * rng.normal(size=48)
    assert is_steady(values)


def test_too_few_cycles_are_never_steady_and_nothing_at_all_is():
    assert not is_steady(np.full(15, 0.3))
    assert is_steady(np.full(16, 0.3))
    assert is_steady(np.zeros(16))


def test_false_alarms_of_the_trend_are_as_rare_as_the_confidence_says():
    """White noise of 2 %: its drift over 16 cycles stays far below the 5 % that may pass.

    At a limit of 3 % the mean is known nearly always, and the trend may object in 5 % of runs.
    """
    values = 0.3 * (1 + 0.02 * RNG(11).normal(size=(400, 16)))
    assert all(is_steady(row) for row in values)
    refused = sum(not is_steady(row, relative=0.03, absolute=0.0) for row in values)
    assert refused < 400 * 0.10


def test_judged_cycles_are_the_last_half_in_whole_blocks():
    assert [judged(n) for n in (16, 20, 32, 40, 43, 60)] == [16, 16, 16, 20, 20, 28]
    assert block_means(np.arange(11), 4).tolist() == [4.5, 8.5]


# The few cycles of a run that did not go on until they were steady


@pytest.mark.parametrize(("cycles", "steady", "words"), [
    # As seen at 40 Hz and Gamma 5: five hold three small ones and two large, or the other way.
    ([0.06, 0.40, 0.03, 0.41, 0.05], None, "their odd number, 5, holds 0.036 of it"),
    ([0.49, 0.06, 0.40, 0.03, 0.41], None, "alternate"),
    # An even number holds whole alternations: nothing to warn of.
    ([0.06, 0.40, 0.03, 0.41, 0.05, 0.40], None, None),
    ([0.90, 0.75, 0.62, 0.50, 0.41], False, "drift by -0.49"),
    ([0.90, 0.70, 0.65, 0.50, 0.42, 0.28], False, "--steady"),
    ([0.50, 0.52, 0.49, 0.51, 0.50], None, None),
    ([0.5] * 31, None, None),
    ([0.5] * 32, True, None),
    ([0.1, 0.9, 0.2, 0.8, 0.9, 0.7, 0.3, 0.1] + [0.1] * 8 + [0.9] * 8 + [0.2] * 8, False,
     "too unlike"),
    ([0.2, 0.3, 0.4], None, None),
])  # fmt: skip
def test_few_cycles_that_alternate_or_drift_say_so_and_name_the_cure(cycles, steady, words):
    found, note = verdict(cycles)
    assert found is steady
    assert (note is None) == (words is None)
    assert words is None or words in note


@pytest.mark.parametrize("n", [5, 6, 12])
def test_a_drift_and_an_alternation_are_found_in_size_side_by_side(n):
    """0.4 + 0.1 k/(n - 1) + 0.2 (-1)^k, exact: what least squares must give back. Of an even
    number the alternation does not count, as it is not in the mean."""
    k = np.arange(n)
    course = Course.of(0.4 + 0.1 * k / (n - 1) + 0.2 * (-1.0) ** k + 1e-9 * RNG(n).normal(size=n))
    assert course.drift == pytest.approx(0.1, abs=1e-6)
    assert course.alternation == pytest.approx(0.2 if n == 5 else 0.0, abs=1e-6)


def test_steady_noise_is_said_to_drift_as_rarely_as_the_confidence_says():
    """A thousand times five steady cycles that scatter by 10 %: 5 % of them, and never more than
    the 3.7 % above it that luck has in one of a million (five standard errors)."""
    draws = 0.3 * (1 + 0.1 * RNG(4).normal(size=(1000, 5)))
    drifting = sum(verdict(row)[0] is False for row in draws)
    assert drifting < 1000 * (0.05 + 5 * np.sqrt(0.05 * 0.95 / 1000))


# Intervals


@pytest.mark.parametrize("n", [4, 5, 15])
@pytest.mark.parametrize("alternation", [0.0, 0.18])
def test_the_interval_holds_the_mean_as_often_as_it_says(n, alternation):
    """2000 draws: 95 % of intervals cover the true mean, with three standard errors for luck.

    With an odd number of alternating cycles it is wider, and covers more.
    """
    rng = RNG(n)
    covered = 0
    for _ in range(2000):
        sign = rng.choice([-1.0, 1.0])
        x = 0.3 + sign * alternation * (-1.0) ** np.arange(n) + 0.02 * rng.normal(size=n)
        low, high = interval(x)
        assert low <= x.mean() <= high
        covered += low <= 0.3 <= high
    error = 3 * np.sqrt(0.95 * 0.05 / 2000)
    assert covered / 2000 > 0.95 - error
    if alternation == 0.0 and n % 2 == 0:
        assert covered / 2000 < 0.95 + error


def test_pure_alternation_leaves_no_scatter():
    """An even window knows its mean; an odd one misses it by a/n."""
    assert interval(_alternating(6)) == pytest.approx((0.22, 0.22))
    five = _alternating(5)
    low, high = interval(five)
    assert 0.5 * (high - low) == pytest.approx(0.18 / 5)
    assert low == pytest.approx(0.22) or high == pytest.approx(0.22)


def test_two_cycles_have_no_interval():
    assert interval([0.1, 0.4]) is None


def test_blocks_see_noise_that_lasts_longer_than_a_cycle():
    """Noise with a memory of four cycles: an interval from single cycles would be too narrow."""
    rng = RNG(2)
    x = np.zeros(400)
    for k in range(1, 400):
        x[k] = 0.8 * x[k - 1] + rng.normal()
    narrow, wide = interval(x), block_interval(x, block=20)
    assert wide[1] - wide[0] > 1.5 * (narrow[1] - narrow[0])
