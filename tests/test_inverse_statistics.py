"""The statistics of the inverse fit, on a model with a closed form: coverage, what is told."""

import numpy as np
import pytest
from made_models import DAMPING, FRICTION, Model, covered, discharge, prior

from calibration.inverse.data import Observed
from calibration.inverse.design import added_points, first_points
from calibration.inverse.identify import at_the_edge, correlations, directions, goodness, widths
from calibration.inverse.reduction import reduce, scatter


def random(seed: int = 1) -> np.random.Generator:
    return np.random.default_rng(seed)


def counted(model: Model, repeats: int, points: int) -> np.ndarray:
    """How many of the 68.3 % intervals hold truths drawn from the prior (p,)."""
    held = []
    for seed in range(repeats):
        own = random(seed)
        truth = model.drawn(own)
        held.append(covered(model.fit(own, model.measured(own, truth), points), truth))
    return np.sum(held, axis=0)


def test_the_interval_of_one_parameter_holds_the_truth_in_68_percent():
    """16 truths from the prior: 10.9 +- 1.9 held; 2.6 of these standard deviations either way."""
    (held,) = counted(Model(priors=(FRICTION,)), 16, 8)
    assert abs(held - 0.683 * 16) < 2.6 * np.sqrt(16 * 0.683 * 0.317)


@pytest.mark.validation
@pytest.mark.parametrize(
    ("model", "points"),
    [(Model(priors=(FRICTION,)), 10), (Model(), 20), (Model(clogs=0.5), 20)],
    ids=["one", "two", "clogging"],
)
def test_intervals_hold_the_truth_in_60_to_76_percent(model, points):
    """200 truths: their share has a standard deviation of 3.3 %, and the issue allows 8 %."""
    held = counted(model, 200, points) / 200
    print(held)
    assert ((held > 0.60) & (held < 0.76)).all()


def test_an_exact_observation_gives_the_parameter_back():
    """Nearly without noise the posterior is at the truth, as wide as the noise makes it.

    d(time)/d(mu) = 1.2 s: with sigma = 1 ms of each of a time and a curve, mu is known to better
    than 1/1.2 = 0.8e-3, and the emulator's own error must not exceed as much again, 3 of each.
    """
    model = Model(priors=(FRICTION,), chance=1e-6, noise=1e-4)
    own, truth = random(), np.array([0.37])
    found = model.fit(own, model.measured(own, truth, sigma=1e-3), 12)
    assert found.values().mean() == pytest.approx(0.37, abs=3 * 1.6e-3)


def test_a_sum_is_told_and_its_parts_are_not():
    """A time 0.6 + 1.2 mu + 0.3 gamma alone: mu and gamma cannot be told apart.

    In widths of the priors the time changes by 1.2 x 0.202 and 0.3 x 0.2, so that the direction
    that it tells is (0.970, 0.240); across it, the posterior is as wide as the prior.
    """
    mu, gamma = prior("mu", "uniform", 0.1, 0.8), prior("gamma", "normal", 1.0, 0.8)
    model = Model(priors=(mu, gamma), chance=1e-3, noise=1e-3)
    own = random()
    observed = model.measured(own, np.array([0.4, 1.2]), sigma=0.005)
    only_time = Observed(observed.values[:1], observed.sigma[:1], observed.trials[:1])

    class TimeOnly(Model):
        def trial(self, random, values):
            return super().trial(random, values)[:1]

    found = TimeOnly(priors=(mu, gamma), chance=1e-3, noise=1e-3).fit(own, only_time, 20)
    expected = np.array([1.2 * 0.7 / np.sqrt(12), 0.3 * 0.8])
    best, worst = directions(found)
    assert best.along == pytest.approx(expected / np.linalg.norm(expected), abs=0.03)
    assert best.identifiable
    assert not worst.identifiable
    assert worst.information == pytest.approx(0, abs=1)
    assert correlations(found)[0, 1] < -0.9
    assert not (widths(found) <= 0.5).all()


def test_what_no_parameter_reaches_is_said():
    """A time of 5 s is far from the 0.9 to 2 s that the priors reach."""
    own = random()
    model = Model(priors=(FRICTION,))
    observed = model.measured(own, np.array([0.4]))
    wrong = Observed(observed.values + np.array([3.0, 0, 0, 0, 0, 0]), observed.sigma,
                     observed.trials)  # fmt: skip
    assert goodness(model.fit(own, observed, 10)).reproducible
    off = goodness(model.fit(own, wrong, 10))
    assert not off.reproducible
    assert abs(off.off).argmax() == 0


def test_a_shape_that_no_run_has_is_said():
    """The time is right, and the curve has a wiggle that no parameter makes."""
    own = random()
    model = Model(priors=(FRICTION,))
    observed = model.measured(own, np.array([0.4]))
    wiggle = 0.08 * np.array([0, 1, -1, 1, -1, 1])
    bent = Observed(observed.values + wiggle, observed.sigma, observed.trials)
    assert not goodness(model.fit(own, bent, 10)).reproducible


def test_a_parameter_beyond_its_prior_runs_against_the_end():
    own = random()
    beyond = Model(priors=(prior("mu", "uniform", 0.1, 0.4),), chance=0.005)
    found = beyond.fit(own, beyond.measured(own, np.array([0.405])), 10)
    assert at_the_edge(found) == [(0, "upper")]


def test_clogged_runs_tell_of_the_friction():
    """Above mu = 0.5 half of the trials clog: ten that all passed are unlikely there (1/1024)."""
    model = Model(priors=(FRICTION,), clogs=0.5)
    nothing = np.zeros(0)
    found = model.fit(random(), Observed(nothing, nothing, nothing, passed=10, blocked=0), 20)
    share = (found.values() > 0.55).mean()
    assert share < 0.1  # of 0.36 in the prior
    many = model.fit(random(), Observed(nothing, nothing, nothing, passed=5, blocked=5), 20)
    assert (many.values() > 0.45).mean() > 0.9


def test_failed_runs_are_left_out_and_clogged_points_are_not_emulated():
    own = random()
    model = Model(priors=(FRICTION,), clogs=0.3)
    found = model.fit(own, model.measured(own, np.array([0.25])), 12)
    assert abs(found.values().mean() - 0.25) < 0.1


def test_combinations_keep_the_scatter_of_single_trials():
    """Linear statistics: the covariance of z is W S W^T, whatever was kept."""
    own = random()
    points = np.repeat(np.arange(12), 4)
    mu = np.linspace(0.1, 0.8, 12)[points]
    values = np.array([Model().trial(own, np.array([m, 1.0])) for m in mu])
    observed = Model().measured(own, np.array([0.4, 1.0]))
    reduction = reduce(observed, points, values)
    single, freedom = scatter(points, values)
    assert freedom == 36
    of_z, _ = scatter(points, reduction.of(values))
    assert of_z == pytest.approx(reduction.weights @ single @ reduction.weights.T)
    assert reduction.of(reduction.back(np.eye(len(of_z)))) == pytest.approx(np.eye(len(of_z)))


def test_priors_have_unit_width_and_end_where_they_say():
    for one in (FRICTION, DAMPING, prior("a", "normal", 5.0, 2.0)):
        x = one.quantile(np.linspace(0, 1, 20001))
        assert x.std() == pytest.approx(one.sd, rel=1e-3)
        assert one.share(x) == pytest.approx(np.linspace(0, 1, 20001), abs=1e-9)
    assert FRICTION.ends == pytest.approx((0.1, 0.8))
    assert DAMPING.ends == pytest.approx((0.4, 1.6))  # three standard deviations


def test_points_do_not_depend_on_what_else_runs_and_added_ones_are_where_the_posterior_is():
    first = first_points((FRICTION, DAMPING), 12, 1)
    assert np.array_equal(first, first_points((FRICTION, DAMPING), 12, 1))
    # a Latin hypercube: one point in each twelfth of each prior, within the rounding
    share = FRICTION.share(first[:, 0])
    assert sorted(np.floor(12 * share + 0.02).astype(int)) == pytest.approx(range(12), abs=1)
    model = Model(priors=(FRICTION,))
    own = random()
    found = model.fit(own, model.measured(own, np.array([0.4])), 10)
    added = added_points(found, found.model.processes.points, 4)
    low, high = found.samples.min(), found.samples.max()
    assert ((added > low - 1e-3) & (added < high + 1e-3)).all()
    assert len(np.unique(added)) == 4


def test_the_same_seed_gives_the_same_samples():
    model = Model(priors=(FRICTION,))
    observed = model.measured(random(5), np.array([0.4]))
    first, second = (model.fit(random(7), observed, 10).samples for _ in range(2))
    assert np.array_equal(first, second)


def test_the_closed_form_is_what_it_says():
    assert discharge(0.5, 1.0)[0] == pytest.approx(1.5)
