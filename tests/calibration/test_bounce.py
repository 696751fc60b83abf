"""Restitution from tracks of a bouncing object: exact flights, noise, the stated uncertainty."""

import numpy as np
import pytest
from fuzzing import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from made_tracks import made_track

from calibration import measure_drop
from calibration.drop.bounce import find_bounces
from calibration.tracking.track import Track
from granulab.errors import InputError


@pytest.mark.parametrize("upwards", [False, True])
@pytest.mark.parametrize("restitution", [[0.5] * 3, [0.7] * 4, [0.95] * 3, [0.6, 0.7, 0.8, 0.7]])
def test_exact_flights_give_restitution_by_all_three_ways(restitution, upwards):
    """T(k+1)/T(k), v'/v and sqrt(H1/H0) (eq. 3.5) are the same on a level plate.

    Tolerance: the release has no sharp frame and a fit ends where its steps are 1e-6 of the noise,
    here 1e-5 px on 500 px.
    """
    made = made_track(restitution, noise=1e-5, upwards=upwards)
    found = find_bounces(made.track)
    n = len(restitution)
    assert found.contacts[:, 0] == pytest.approx(made.contacts, abs=1e-4)
    assert found.velocities[:, 0] == pytest.approx(made.restitution, abs=1e-5)
    assert found.heights[:, 0] == pytest.approx(made.restitution, abs=1e-5)
    assert found.times[1 : n - 1, 0] == pytest.approx(made.restitution[1:-1], abs=1e-5)
    assert np.isnan(found.times[[0, -1], 0]).all()  # no whole flight before the first contact
    assert found.speeds[:, 0] == pytest.approx(made.speeds, rel=1e-5)
    assert abs(found.flights.acceleration[0]) == pytest.approx(made.acceleration, rel=1e-6)


def deviates(**options):
    """(value - truth)/sigma over a grid of restitution, frames per fall and noise."""
    found = {name: [] for name in ("times", "velocities", "heights", "contacts", "pooled")}
    seed = 0
    for e in (0.53, 0.7, 0.9):
        for fall_frames in (15.3, 40.3, 90.7):  # a fall of 0.3 m at 60, 160 and 370 frames/s
            for noise in (0.03, 0.3, 1.0):
                for _ in range(4):
                    seed += 1
                    at = np.random.default_rng(seed).random(2)  # contacts anywhere in a frame
                    made = made_track([e] * 4, fall_frames=fall_frames + at[0], held=12 + at[1],
                                      noise=noise, seed=seed, **options)  # fmt: skip
                    b = find_bounces(made.track)
                    n = min(len(b.contacts), 4)
                    for name in ("times", "velocities", "heights"):
                        known = getattr(b, name)[:n]
                        found[name].extend((known[:, 0] - e) / known[:, 1])
                    off = b.contacts[:n, 0] - made.contacts[:n]
                    found["contacts"].extend(off / b.contacts[:n, 1])
                    found["pooled"].append((b.pooled.value - e) / b.pooled.sigma)
    return {name: np.array(values)[np.isfinite(values)] for name, values in found.items()}


@pytest.mark.validation
def test_68_per_cent_intervals_cover_the_truth_in_60_to_76_per_cent():
    """Normal noise: a sigma that is right covers 68 %.

    The grid has 108 clips, some 430 bounces: chance alone moves a share of 430 by 2.3 % (more,
    as bounces of a clip share flights) and of 108 by 4.5 %. Bias: below 0.3 sigma, three times
    what chance gives the mean of 108.
    """
    found = deviates()
    for name, z in found.items():
        share = float(np.mean(np.abs(z) < 1))
        assert 0.60 <= share <= 0.76, (name, share, len(z))
        assert abs(np.mean(z)) < 0.3, (name, np.mean(z))


@pytest.mark.validation
def test_one_number_is_refuted_as_often_as_its_test_says():
    """p < 0.05 in 5 % of clips with one restitution; 40 clips: at most 6 (99 %)."""
    made = [made_track([0.75] * 5, seed=seed) for seed in range(40)]
    refuted = sum(find_bounces(one.track).constant_within_noise is False for one in made)
    assert refuted <= 6


def test_restitution_that_falls_with_speed_is_found():
    """e = c v^n, n = -0.1: the exponent comes back, and one number is refuted."""
    e, speed = [], 25.0
    for _ in range(5):
        e.append(0.75 * (speed / 25) ** -0.1)
        speed *= e[-1]
    found = find_bounces(made_track(e, noise=0.05).track)
    assert found.constant_within_noise is False
    assert found.exponent is not None
    # to four sigma; the scatter of e beyond noise widens the pooled interval to hold all values
    assert abs(found.exponent.value + 0.1) < 4 * found.exponent.sigma < 0.1
    assert min(e[1:-1]) < found.pooled.value < max(e[1:-1])


@pytest.mark.validation
def test_bounces_that_share_a_flight_are_anticorrelated_and_the_pooled_value_knows():
    """T2 is in T2/T1 and in T3/T2: errors of a long flight cancel in the pooled value.

    The scatter of the pooled value over clips is its sigma, within 30 % (30 clips: 13 % sigma).
    """
    pooled = [find_bounces(made_track([0.8] * 6, seed=s).track).pooled for s in range(30)]
    scatter = np.std([one.value for one in pooled])
    assert scatter == pytest.approx(np.median([one.sigma for one in pooled]), rel=0.3)


def test_bad_positions_do_not_move_the_result():
    """One position in twelve lies anywhere within 100 px: they are left out and counted."""
    made = made_track([0.7] * 4)
    rng = np.random.default_rng(3)
    y = made.track.y.copy()
    bad = rng.choice(len(y), len(y) // 12, replace=False)
    y[bad] += rng.uniform(-100, 100, len(bad))
    clean = find_bounces(made.track)
    found = find_bounces(Track(made.track.frame, made.track.x, y))
    assert len(found.contacts) == 4
    off = found.velocities[:, 0] - made.restitution
    assert np.all(np.abs(off) < 4 * found.velocities[:, 1])
    assert found.pooled.sigma < 2 * clean.pooled.sigma
    assert any("fit no parabola" in line for line in found.warnings)


def test_gaps_at_apex_and_at_the_plate_are_bridged():
    """The object leaves the picture above, and is hidden behind something at the plate."""
    made = made_track([0.8] * 4)
    y, low = made.track.y, made.track.y > 470
    high = (made.track.frame > made.contacts[0]) & (y < y[made.track.frame > 70].min() + 40)
    for hidden in (low, high):
        track = made.track.chosen(np.flatnonzero(~hidden))
        found = find_bounces(track)
        n = len(found.contacts)
        assert n >= 3
        z = (found.velocities[:, 0] - made.restitution[:n]) / found.velocities[:, 1]
        assert np.all(np.abs(z) < 4)


def test_a_plate_that_drifts_is_reported_and_is_in_the_sigma():
    """4 px over the clip; times and velocities then disagree by more than their noise."""
    made = made_track([0.8] * 4, noise=0.02, drift=4.0)
    found = find_bounces(made.track)
    share = np.ptp(made.contacts[[0, -1]]) / made.track.frame[-1]
    assert found.drift.value == pytest.approx(4 * share, abs=0.2)
    assert any("plate" in line for line in found.warnings)
    assert abs(found.pooled.value - 0.8) < 3 * found.pooled.sigma


def test_known_covariance_weighs_positions():
    """Half of the positions are ten times as noisy and said to be so: the rest decide."""
    made = made_track([0.7] * 4, noise=0.05)
    noisy = np.arange(len(made.track.y)) % 2 == 1
    y = made.track.y + np.where(noisy, np.random.default_rng(1).normal(0, 0.5, len(noisy)), 0)
    covariance = np.where(noisy, 0.25, 0.0025)[:, None, None] * np.eye(2)
    plain = find_bounces(Track(made.track.frame, made.track.x, y))
    found = find_bounces(Track(made.track.frame, made.track.x, y, covariance=covariance))
    assert found.pooled.sigma < 0.7 * plain.pooled.sigma
    assert abs(found.pooled.value - 0.7) < 4 * found.pooled.sigma


def test_free_fall_gives_scale_or_rate_and_checks_both():
    """g = a s f^2: 0.1 % of what was put in; g's own variation over the earth is 0.3 %."""
    made = made_track([0.7] * 4, noise=0.05)
    fps, g = 240.0, 9.80665
    scale = g / (made.acceleration * fps**2)
    by_rate = measure_drop(made.track, fps=fps)
    assert by_rate.scale.value == pytest.approx(scale, rel=1e-3)
    assert 0.003 * scale < by_rate.scale.sigma < 0.005 * scale
    by_scale = measure_drop(made.track, scale=f"{1e3 * scale} mm/px")
    assert by_scale.rate.value == pytest.approx(fps, rel=1e-3)
    both = measure_drop(made.track, scale=scale, fps=fps)
    assert both.gravity.value == pytest.approx(g, rel=1e-3)
    assert both.speed(0).value == pytest.approx(made.speeds[0] * scale * fps, rel=1e-3)
    assert not any("free fall" in line for line in both.warnings)
    slow = measure_drop(made.track, scale=scale, fps=120)  # a header that says half the rate
    assert any("240" in line for line in slow.warnings)
    neither = measure_drop(made.track)
    assert neither.to_dict()["contact_times_s"] is None
    assert neither.speed(0) is None


def test_what_does_not_bounce_is_refused_with_the_reason():
    """No fall, no bounce, one bounce, too few positions: one line each."""
    rng = np.random.default_rng(1)
    frame = np.arange(200.0)
    still = Track(frame, frame, 300 + rng.normal(0, 0.1, 200))
    with pytest.raises(InputError, match="nothing falls"):
        find_bounces(still)
    falls = made_track([0.7]).track
    falls = falls.chosen(np.flatnonzero(falls.frame < 50))
    with pytest.raises(InputError, match="nothing falls"):
        find_bounces(falls)
    with pytest.raises(InputError, match="positions"):
        find_bounces(falls.chosen(np.arange(5)))
    once = made_track([0.7]).track
    with pytest.raises(InputError, match=r"one bounce, at frame 52\.\d+ .*0\.70") as refused:
        find_bounces(once)
    assert "\n" not in str(refused.value)
    e = find_bounces(once, one_is_enough=True).pooled
    assert abs(e.value - 0.7) < 4 * e.sigma


@settings(max_examples=examples(20), deadline=None)
@given(
    pieces=st.lists(
        st.tuples(
            st.integers(1, 30), st.floats(-30, 30), st.floats(-2, 2), st.sampled_from([0, 0.1, 3])
        ),
        min_size=1, max_size=8,
    ),
    size=st.sampled_from([0.0, 1e-6, 1.0, 1e6]),
)  # fmt: skip
def test_any_path_is_measured_or_refused(pieces, size):
    """Stretches of any speed and acceleration, with and without noise, at any scale."""
    rng = np.random.default_rng(1)
    y = [0.0]
    for n, speed, acceleration, noise in pieces:
        s = np.arange(1.0, n + 1)
        y.extend(y[-1] + speed * s + acceleration * s**2 / 2 + rng.normal(0, noise, n))
    frame = np.arange(float(len(y)))
    try:
        found = find_bounces(Track(frame, frame, size * np.array(y)), one_is_enough=True)
    except InputError:
        return
    assert np.all(np.isfinite(found.velocities))
    assert np.all(found.velocities[:, 0] > 0)
    assert np.isfinite(found.pooled.value)


def few_positions(shown, noise):
    """A track of `shown` positions of a fall, a contact, and the whole flight of 0.85 behind it.

    At 30 frames/s and 1.2 mm/px; noise [px]. At most four make no parabola of their own.
    """
    g, e = 9.80665 / 30**2 / 1.2e-3, 0.85  # px/frame2
    speed = np.sqrt(2 * g * 500)
    s = np.arange(-shown, int(2 * e * speed / g) - 1) + 0.7  # from the contact
    y = np.where(s < 0, 500 + speed * s + g * s**2 / 2, 500 - e * speed * s + g * s**2 / 2)
    y = y + np.random.default_rng(shown).normal(0, noise, len(s))
    return Track(np.arange(len(s), dtype=float), np.full(len(s), 50.0), y, name="ball")


def test_a_fall_of_three_positions_is_named_and_drawn(tmp_path):
    """It is not thrown, and does not fall out of the picture."""
    words = r"its fall shows too few positions \(3\).*drop-ball.png shows what was seen"
    with pytest.raises(InputError, match=words):
        measure_drop(few_positions(3, 1.0), fps=30, one_bounce=True, out=tmp_path)
    assert (tmp_path / "drop-ball.png").stat().st_size > 10_000


def test_a_fall_of_four_positions_before_a_whole_flight_is_one():
    """It has the acceleration of the flight, and meets it in a contact."""
    found = measure_drop(few_positions(4, 0.3), fps=30, one_bounce=True).restitution
    assert abs(found.value - 0.85) < 3 * found.sigma < 0.1
