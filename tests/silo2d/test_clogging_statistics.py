"""Statistics of clogging, on samples and numbers whose law is known."""

import math
import re

import numpy as np
import pytest

from silo2d.measures.clogging import laws, sizes, waits
from silo2d.measures.clogging.study import study


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(11)


def censored(values, largest):
    """Sizes that are cut off at a largest one, and whether they were."""
    values = np.asarray(values)
    return np.minimum(values, largest).tolist(), (values > largest).astype(int).tolist()


# The mean avalanche


def test_mean_avalanche_is_particles_over_clogs():
    """p = k/S is the maximum of p^k (1 - p)^(S - k); the ends are chi2's of a count of 4 of 200."""
    found = sizes.mean_avalanche(200, 4)
    assert found.value == 50.0
    # Poisson counts of 4: 1.0899 to 10.2416 (Garwood 1936).
    assert [found.low, found.high] == pytest.approx([200 / 10.2416, 200 / 1.0899], rel=1e-4)


def test_an_outlet_that_never_clogged_has_a_lower_bound():
    """None of S particles: S/3.689 at least, since exp(-3.689) = 0.025."""
    found = sizes.mean_avalanche(1000, 0)
    assert (found.value, found.high) == (None, None)
    assert found.low == pytest.approx(1000 / -math.log(0.025))


def test_intervals_of_cut_avalanches_hold_their_mean(rng):
    """19 of 20 at least; of 400 samples 5 % +- 3 sd of a binomial count. Half of each is cut."""
    missed = 0
    for _ in range(400):
        size, cut = censored(rng.geometric(1 / 40, 30), 28)
        found = sizes.mean_avalanche(sum(size), 30 - sum(cut))
        missed += not found.low <= 40 <= (found.high or np.inf)
    assert missed <= 400 * 0.05 + 3 * math.sqrt(400 * 0.05 * 0.95)


def test_an_avalanche_that_is_cut_off_goes_on_in_the_next_piece():
    """That from the opening too; the last one of a run may have no clog at its end."""
    whole = sizes.joined(30, True, [5, 100, 100, 20, 7], [0, 1, 1, 0, 0])
    assert whole == (30, True, [5, 220, 7], [0, 0, 0])
    opening = sizes.joined(100, False, [100, 40, 9, 100], [1, 0, 0, 1])
    assert opening == (240, True, [9, 100], [0, 1])
    assert sizes.joined(100, False, [100], [1]) == (200, False, [], [])


def test_runs_that_share_a_mean_avalanche_are_found_so_and_others_widen_it(rng):
    """Of 200 samples of one mean some 5 % +- 3 sd are refuted; means 20 and 60 always."""
    alike = [
        sizes.scatter([sizes.Run(1, True, rng.geometric(1 / 40, 30).tolist(), [0] * 30)
                       for _ in range(5)])
        for _ in range(200)
    ]  # fmt: skip
    refuted = sum(p < 0.05 for _, p in alike)
    assert refuted <= 200 * 0.05 + 3 * math.sqrt(200 * 0.05 * 0.95)
    assert {ratio for ratio, p in alike if p >= 0.05} == {1.0}
    unlike = [sizes.Run(1, True, [mean] * 30, [0] * 30) for mean in (20, 60)]
    ratio, p = sizes.scatter(unlike)
    assert p < 1e-3
    narrow, wide = sizes.mean_avalanche(2400, 60), sizes.mean_avalanche(2400, 60, ratio)
    assert wide.value == narrow.value
    assert wide.low < narrow.low < narrow.high < wide.high
    # Of so many clogs the interval is about as wide as root(scatter) times that of one mean.
    logs = [math.log(one.high / one.low) for one in (narrow, wide)]
    assert logs[1] / logs[0] == pytest.approx(math.sqrt(ratio), rel=0.15)
    assert sizes.scatter(unlike[:1]) == (1.0, None)


# The form of the sizes


def test_geometric_sizes_are_exponential_also_where_they_are_cut(rng):
    size, cut = censored(rng.geometric(1 / 60, 400), 100)
    found = sizes.form(size, cut)
    assert found.low < 1 < found.high
    assert found.p_value > 0.05
    assert found.n == 400 - sum(cut)


@pytest.mark.parametrize("beta", [0.6, 1.6])
def test_stretched_and_compressed_sizes_are_not_exponential(rng, beta):
    """Weibull's sizes rounded up have P(more than s) = exp(-(s/50)^beta) at whole s, exactly."""
    size, cut = censored(np.ceil(50 * rng.weibull(beta, 400)).astype(int), 150)
    found = sizes.form(size, cut)
    assert found.low < beta < found.high
    assert found.p_value < 1e-3


def test_the_tail_begins_where_most_sizes_are(rng):
    """Sizes that first wait and then end exponentially: beyond the mode they are exponential."""
    size = (30 + rng.geometric(1 / 40, 500)).tolist()
    cut = [0] * 500
    start = sizes.mode(size, cut)
    assert 30 < start < 60
    assert sizes.form(size, cut).p_value < 1e-6
    beyond = sizes.form(size, cut, start)
    assert beyond.p_value > 0.05
    assert beyond.low < 1 < beyond.high


def test_too_few_clogs_have_no_form():
    assert sizes.form([10] * 19, [0] * 19) is None
    assert sizes.form([10] * 30, [1] * 30) is None


def test_independent_sizes_are_found_so_and_linked_ones_are_not(rng):
    """Each link is half of the one before and half its own: a correlation of about a half."""
    own = rng.geometric(1 / 50, 600)
    found = sizes.independence([(own[:300], [0] * 300), (own[300:], [0] * 300)])
    assert found.low < 0 < found.high
    linked = own[1:] + own[:-1]
    assert sizes.independence([(linked, [0] * 599)]).low > 0.3


def test_pairs_with_a_cut_avalanche_tell_nothing():
    assert sizes.independence([([1, 2, 3, 4, 5, 6], [0, 1, 0, 1, 0, 1])]) is None


def test_survival_without_a_cut_is_the_share_that_is_larger():
    at, larger = sizes.survival([3, 1, 3, 8], [0, 0, 0, 0])
    assert at.tolist() == [1, 3, 8]
    assert larger == pytest.approx([0.75, 0.25, 0.0])


def test_survival_with_a_cut_is_kaplan_and_meiers():
    """Of four, one is cut at 3: at 8 half of the two that are left... one ends: 3/4 times 0."""
    at, larger = sizes.survival([1, 3, 5, 8], [0, 1, 0, 0])
    assert at.tolist() == [1, 5, 8]
    assert larger == pytest.approx([3 / 4, 3 / 4 * 1 / 2, 0.0])


def test_a_silo_empties_if_no_particle_clogs_it():
    """(1 - 1/<s>)^n, near exp(-n/<s>) for large <s>; a mean of one never lets a second pass."""
    value, low, high = sizes.empties(sizes.mean_avalanche(40_000, 100), 600)
    assert value == pytest.approx((1 - 1 / 400) ** 600)
    assert value == pytest.approx(math.exp(-600 / 400), rel=0.003)
    assert low < value < high
    assert sizes.empties(sizes.mean_avalanche(5, 5), 2)[0] == 0.0
    assert sizes.empties(sizes.mean_avalanche(100, 0), 10)[0] == 1.0


# The laws of the outlet

ACROSS = np.array([3.0, 3.5, 4.0, 4.5, 5.0])


def exact(means, clogs=200.0):
    """Outlets that show their means exactly."""
    return laws.Outlets(ACROSS, clogs * np.asarray(means), np.full(len(means), clogs))


def test_exponential_law_is_found_again():
    """Without noise the parameters come back, the outlets lie on the law, and C is known to about
    1/sqrt(sum k (R^2 - mean)^2)."""
    found = laws.exponential(exact(2.0 * np.exp(0.2 * ACROSS**2)))
    a, c = found.parameters["A"], found.parameters["C"]
    assert [a.value, c.value] == pytest.approx([2.0, 0.2], rel=1e-4)
    assert found.p_value == pytest.approx(1.0, abs=1e-3)
    square = ACROSS**2
    error = 1.96 / math.sqrt(200 * ((square - square.mean()) ** 2).sum())
    assert [c.value - c.low, c.high - c.value] == pytest.approx([error] * 2, rel=0.05)
    assert a.low < 2.0 < a.high
    assert found.mean(np.array([4.0])) == pytest.approx(2.0 * math.exp(0.2 * 16), rel=1e-3)


def test_power_law_is_found_again():
    found = laws.power(exact(40.0 * (6.0 - ACROSS) ** -2.5))
    critical, g = found.parameters["critical"], found.parameters["g"]
    assert [critical.value, g.value] == pytest.approx([6.0, 2.5], rel=2e-3)
    assert critical.low < 6.0 < critical.high
    assert g.low < 2.5 < g.high
    assert found.mean(np.array([5.9, 6.1]))[1] == np.inf


def test_a_power_law_whose_critical_outlet_is_far_is_open_above():
    """Means of A exp(b R), its limit: no outlet is critical, and none is named."""
    found = laws.power(exact(0.5 * np.exp(1.2 * ACROSS)))
    critical, g = found.parameters["critical"], found.parameters["g"]
    assert (critical.high, g.high) == (None, None)
    assert critical.low > ACROSS.max()
    assert found.mean(ACROSS) == pytest.approx(0.5 * np.exp(1.2 * ACROSS), rel=1e-2)


def test_outlets_of_many_diameters_have_laws():
    """exp(C R^2) of fine particles is beyond the largest number long before C is what it is."""
    across = np.array([18.0, 20.0, 22.0])
    means = 1e-3 * np.exp(0.04 * across**2)
    seen = laws.Outlets(across, 100 * means, np.full(3, 100.0))
    assert laws.exponential(seen).parameters["C"].value == pytest.approx(0.04, rel=1e-3)
    assert laws.power(seen) is not None
    found = laws.outlet_of(1e4, laws.exponential(seen), seen)
    assert found.value == pytest.approx(math.sqrt(math.log(1e7) / 0.04))


@pytest.mark.parametrize("true", ["exponential", "power"])
def test_the_better_law_is_that_which_made_the_avalanches(rng, true):
    means = 0.5 * np.exp(0.25 * ACROSS**2) if true == "exponential" else 12 * (5.2 - ACROSS) ** -2
    samples = [rng.geometric(1 / mean, 2000) for mean in means]
    seen = laws.Outlets(ACROSS, np.array([s.sum() for s in samples]), np.full(5, 2000.0))
    found = {law.name: law for law in (laws.exponential(seen), laws.power(seen))}
    # A power law of a far critical outlet is an exponential nearly: it may only not be better.
    assert min(found.values(), key=lambda law: law.aic - 4 * (law.name == true)).name == true
    assert found[true].p_value > 0.01


def test_outlets_that_never_clogged_count():
    """Beyond the critical outlet they cost the power law nothing; they raise the exponential."""
    seen = exact(2.0 * np.exp(0.2 * ACROSS**2))
    quiet = laws.Outlets(np.append(ACROSS, 5.5), np.append(seen.exposure, 1e5),
                         np.append(seen.clogs, 0.0))  # fmt: skip
    rates = [laws.exponential(one).parameters["C"].value for one in (seen, quiet)]
    assert rates[1] > rates[0]
    assert laws.power(quiet) is not None


def test_too_few_outlets_have_no_law():
    two = laws.Outlets(ACROSS[:2], np.array([100.0, 200.0]), np.array([10.0, 10.0]))
    assert laws.power(two) is None
    one = laws.Outlets(ACROSS[:1], np.array([100.0]), np.array([10.0]))
    assert laws.exponential(one) is None


POWER = 0.5, 6.0, 4.0  # A, critical D/d, g


@pytest.mark.parametrize(("fit", "means", "true"), [
    (laws.exponential, 2.0 * np.exp(0.2 * ACROSS**2), math.sqrt(math.log(900 / 2.0) / 0.2)),
    (laws.power, POWER[0] * (1 - ACROSS / POWER[1]) ** -POWER[2],
     POWER[1] * (1 - (POWER[0] / 900) ** (1 / POWER[2]))),
    (laws.power, 0.5 * np.exp(1.2 * ACROSS), math.log(1800) / 1.2),  # no outlet is critical
])  # fmt: skip
def test_outlet_of_a_mean_avalanche_is_the_laws(fit, means, true):
    seen = exact(means)
    found = laws.outlet_of(900.0, fit(seen), seen)
    assert found.value == pytest.approx(true, rel=2e-3)
    assert found.low < found.value < found.high


def test_no_outlet_has_a_mean_avalanche_below_that_of_a_closed_one():
    seen = exact(2.0 * np.exp(0.2 * ACROSS**2))
    assert laws.outlet_of(1.0, laws.exponential(seen), seen) is None
    falling = exact(2.0 * np.exp(-0.2 * ACROSS**2))
    assert laws.outlet_of(900.0, laws.exponential(falling), falling) is None


# Waiting times


def test_bins_hold_their_times():
    times = [1e-5, 1e-4, 0.0999, 0.1001, 1e3]
    for time, k in zip(times[1:4], waits.bin_of(times)[1:4], strict=True):
        assert waits.EDGES[k] <= time < waits.EDGES[k + 1]
    assert waits.bin_of(times)[[0, -1]].tolist() == [0, waits.BINS - 1]


@pytest.mark.parametrize("alpha", [1.7, 3.0])
def test_power_law_tail_of_waits_is_found_again(rng, alpha):
    """Also under the longest wait, above which none are seen, and over a body of short ones."""
    tail = 0.01 * (1 - rng.random(6000)) ** (-1 / (alpha - 1))
    times = np.concatenate([tail[tail < 0.15], rng.uniform(0, 0.01, 4000)])
    counts = np.bincount(waits.bin_of(times), minlength=waits.BINS)
    found = waits.tail(counts, 0.15)
    assert found.low < alpha < found.high
    assert found.high - found.low < 0.5
    assert 0.008 < found.start < 0.05
    assert found.end <= 0.15


def test_a_power_law_is_refuted_in_one_sample_of_twenty(rng):
    """Its tail then starts later than it does: of 300 samples 15, +- 3 sd of a binomial count."""
    later = 0
    for _ in range(300):
        times = 0.01 * (1 - rng.random(800)) ** (-1 / 1.5)
        counts = np.bincount(waits.bin_of(times[times < 0.15]), minlength=waits.BINS)
        later += waits.tail(counts, 0.15).start > waits.EDGES[counts.argmax()]
    assert abs(later - 15) <= 3 * math.sqrt(300 * 0.05 * 0.95)


def test_a_tail_starts_no_earlier_than_it_may(rng):
    times = 0.005 * (1 - rng.random(4000)) ** (-1 / 2)
    counts = np.bincount(waits.bin_of(times[times < 0.15]), minlength=waits.BINS)
    found = waits.tail(counts, 0.15, start=0.02)
    assert found.start == pytest.approx(0.02, rel=0.12)  # a bin of a twentieth of a decade
    assert found.low < 3.0 < found.high


def test_waits_without_a_power_law_have_no_tail(rng):
    """A few; and those of an exponential, which falls by far more at its end."""
    counts = [0] * waits.BINS
    counts[45] = 40
    assert waits.tail(counts, 0.15) is None
    many = np.bincount(waits.bin_of(rng.exponential(0.01, 100_000)), minlength=waits.BINS)
    found = waits.tail(many, 0.15)
    assert found is None or found.start > 0.05


# All of it


def made_row(outlet, seed, mean, rng):
    size, cut = censored(rng.geometric(1 / mean, 50), 400)
    return {
        "state": "done", "reason": "", "outlet_m": outlet, "outlet_mm": 1e3 * outlet, "seed": seed,
        "outcome": "whole", "diameter_m": 0.01, "n_particles": 300, "sizes": size, "cut": cut,
        "first_size": size[0], "first_clogged": True, "arch_particles": [3, 5, 5],
        "arch_span_m": [0.05] * 3, "arch_aspect": [0.3] * 3, "arches_not_found": 0, "breaks": 50,
        "waits": [3] * waits.BINS, "cpu_s": 1.0, "run_folder": "here",
    }  # fmt: skip


def test_a_study_gathers_seeds_and_locates_the_outlet_that_clogs_half(rng):
    """Half of n particles' silos clog where (1 - 1/<s>)^n = 1/2, on the law that made the sizes."""
    rows = [
        made_row(outlet, seed, 2 * math.exp(0.2 * (100 * outlet) ** 2), rng)
        for seed in (1, 2)
        for outlet in (0.05, 0.03, 0.04)
    ]
    rows.append({"state": "failed", "reason": "why", "outlet_m": None})
    found = study(rows, 0.15)
    assert [one["outlet_m"] for one in found["outlets"]] == [0.03, 0.04, 0.05]
    assert [one["avalanches"] for one in found["outlets"]][:2] == [100, 100]
    assert found["outlets"][2]["avalanches"] < 100  # some are whole in two pieces
    first = found["outlets"][0]
    assert (first["runs"], first["clogged"], first["share"]) == (2, 2, 1.0)
    assert first["arch_particles"] == [0, 0, 0, 2, 0, 4]
    mean = 1 / (1 - 0.5 ** (1 / 300))
    true = 0.01 * math.sqrt(math.log(mean / 2) / 0.2)
    by_law = {
        name: [one for one in found["outlets_by_probability"] if one["law"] == name]
        for name in ("exponential", "power")
    }
    for half, *rarer in by_law.values():
        assert half["interval_m"][0] < true < half["interval_m"][1]
        assert [one["probability"] for one in rarer] == [0.05, 0.01]
        assert half["outlet_m"] < rarer[0]["outlet_m"] < rarer[1]["outlet_m"]
    assert rarer[1]["extrapolated"]
    assert found["independence"]["low"] < 0 < found["independence"]["high"]


def test_sizes_of_unlike_forms_at_unlike_outlets_are_no_succession(rng):
    """Independent sizes, equal at one outlet but for a few large ones, geometric at the other: over
    their means those of one rank low together, and 0.2 of correlation came of that alone."""
    rows = [made_row(0.03, 1, 20, rng), made_row(0.05, 1, 20, rng)]
    for row, own in zip(rows, (rng.geometric(1 / 40, 300),
                               rng.permutation([5] * 270 + [800] * 30)), strict=True):  # fmt: skip
        row |= {"sizes": own.tolist(), "cut": [0] * 300}
    over_means = [([s / np.mean(row["sizes"]) for s in row["sizes"]], row["cut"]) for row in rows]
    assert sizes.independence(over_means).low > 0.1
    found = study(rows, 0.15)["independence"]
    assert found["low"] < 0 < found["high"]


def test_a_first_flow_that_ended_too_early_leaves_their_share_unknown(rng):
    """One of two went on for fewer particles than the silo holds and then out of a rathole."""
    rows = [made_row(0.05, seed, 20, rng) for seed in (1, 2)]
    rows[0] |= {"outcome": "rathole", "first_size": 100, "first_clogged": False, "sizes": [50],
                "cut": [1]}  # fmt: skip
    (one,) = study(rows, 0.15)["outlets"]
    assert (one["runs"], one["share"]) == (0, None)
    rows[0]["sizes"] = [250]  # with those before more than the 300 of the silo
    (one,) = study(rows, 0.15)["outlets"]
    assert (one["clogged"], one["runs"]) == (1, 2)


def test_an_outlet_that_does_not_clog_bounds_its_mean(rng):
    """Two runs of which nothing clogged: 800 and 400 left after their first cut, none of them in a
    clog, so that fewer than 3.69 are expected (97.5 %): <s> above 1200/3.69."""
    from silo2d.view.clogging.figure import draw
    from silo2d.view.clogging.words import in_words

    rows = [made_row(0.05, seed, 20, rng) for seed in (1, 2, 3)]
    for row, n in zip(rows, (4, 2), strict=False):
        row |= {"outlet_m": 0.06, "first_size": 200, "first_clogged": False, "sizes": [200] * n,
                "cut": [1] * n}  # fmt: skip
    found = study(rows, 0.15)
    clogging, free = found["outlets"]
    assert clogging["unclogged"] == 0
    assert (free["mean_avalanche"], free["unclogged"]) == (None, 1200)
    assert free["mean_avalanche_interval"] == [pytest.approx(1200 / 3.6889, rel=1e-4), None]
    assert "nothing clogged at 60 mm: the bound is of 1,200 particles" in in_words(found)
    arrows = [line for axes in draw(found, rows, "Clogging").axes for line in axes.lines
              if line.get_marker() == "^"]  # fmt: skip
    assert [line.get_ydata()[0] for line in arrows] == [pytest.approx(1200 / 3.6889, rel=1e-4)]


def test_outlets_that_refute_the_law_are_not_extrapolated(rng):
    from silo2d.view.clogging.words import in_words

    rows = [made_row(0.01 * r, 1, mean, rng) for r, mean in ((3, 20), (4, 80), (4.5, 20), (5, 90))]
    found = study(rows, 0.15)
    assert found["laws"]["exponential"]["p_value"] < 0.05
    assert not any(one["extrapolated"] for one in found["outlets_by_probability"])
    assert "it gives none beyond them" in in_words(found)


def test_report_and_picture_say_what_was_found(rng, tmp_path):
    from granulab.campaign.output.figure import write_figure
    from silo2d.view.clogging.figure import draw
    from silo2d.view.clogging.words import in_words

    rows = [made_row(o, 1, 2 * math.exp(0.2 * (100 * o) ** 2), rng) for o in (0.03, 0.04, 0.05)]
    found = study(rows, 0.15)
    text = in_words(found)
    assert "A exp(C (D/d)^2)" in text
    assert "of the silos of 300  clog at (exponential law)" in text
    assert re.search(r"\n5 % .* mm, D/d [\d.]+, extrapolated *\n1 % ", text)
    assert re.search(r"50 mm +5\.00 +\d+ +0 ", text)
    path = write_figure(tmp_path / "clog.png", lambda: draw(found, rows, "Clogging"))
    assert path.stat().st_size > 20_000


@pytest.mark.parametrize(
    ("outcome", "words"),
    [
        ("rathole", "in a rathole"),
        ("stuck", "early, as no break"),
        ("dead_zones", "early, at rest"),
        ("time_limit", "early, as nothing came out"),
    ],
)
def test_runs_that_end_before_their_avalanches_are_reported(rng, outcome, words):
    from silo2d.view.clogging.words import in_words

    rows = [made_row(0.05, seed, 20, rng) for seed in (1, 2)]
    assert "ended" not in in_words(study(rows, 0.15))
    rows[1]["outcome"] = outcome
    assert f"1 of the runs at 50 mm ended {words}" in in_words(study(rows, 0.15))
