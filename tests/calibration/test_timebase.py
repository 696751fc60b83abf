"""The time base put right from free fall: repeated frames, frames left out, uneven stamps."""

from dataclasses import replace

import numpy as np
import pytest
from made_tracks import made_track

from calibration.drop.bounce import find_bounces
from calibration.drop.measure import measure_drop
from calibration.tracking.track import Track


def replayed(made, shown):
    """The track of a file whose frames show these frames of the truth, numbered from 0."""
    shown = np.asarray(shown)
    track = made.track.chosen(shown)
    return Track(np.arange(float(len(shown))), track.x, track.y)


@pytest.fixture(name="made")
def _made():
    return made_track([0.75] * 4)


def agrees(found, made):
    z = (found.velocities[:, 0] - made.restitution) / found.velocities[:, 1]
    t = (found.times[1:-1, 0] - made.restitution[1:-1]) / found.times[1:-1, 1]
    assert np.all(np.abs(z) < 4)
    assert np.all(np.abs(t) < 4)


def test_an_even_clock_is_left_alone(made):
    found = find_bounces(made.track)
    assert found.base.duplicated_frames == found.base.dropped_frames == []
    assert found.base.clock == pytest.approx(made.track.frame)


@pytest.mark.parametrize("at", [42, 75, 97, 130])
def test_a_repeated_frame_is_found_and_its_time_taken_out(made, at):
    """A copy put in: everything after it is one frame late."""
    frames = np.arange(len(made.track.frame))
    found = find_bounces(replayed(made, np.insert(frames, at + 1, at)))
    assert found.base.duplicated_frames == [at + 1]
    agrees(found, made)


def test_a_copy_in_place_of_a_lost_frame_takes_no_time_out(made):
    shown = np.arange(len(made.track.frame))
    shown[70] = 69
    found = find_bounces(replayed(made, shown))
    assert found.base.duplicated_frames == [70]
    assert found.base.clock[-1] == made.track.frame[-1]
    agrees(found, made)


@pytest.mark.parametrize(("at", "lost"), [(45, 1), (72, 1), (98, 2)])
def test_frames_left_out_are_found_and_their_time_put_back(made, at, lost):
    """Frame numbers go on as if nothing had happened."""
    shown = np.delete(np.arange(len(made.track.frame)), np.arange(at, at + lost))
    found = find_bounces(replayed(made, shown))
    assert len(found.base.dropped_frames) == lost
    assert found.base.dropped_frames[0] == pytest.approx(at, abs=2)
    agrees(found, made)


def every_second(n):
    return np.repeat(np.arange(n), 2)


def every_fifth_put_in(n):
    """24 frames/s made to 30."""
    return np.sort(np.concatenate([np.arange(n), np.arange(3, n, 4)]))


def every_fifth_lost(n):
    """The camera ran on: a picture shown again stands for one that is missing."""
    shown = np.arange(n)
    shown[4::5] -= 1
    return shown


def put_in_here_and_there(n):
    copies = np.random.default_rng(4).choice(n, n // 12, replace=False)
    return np.sort(np.concatenate([np.arange(n), copies]))


def lost_here_and_there(n):
    shown = np.arange(n)
    for k in np.random.default_rng(4).choice(np.arange(1, n), n // 12, replace=False):
        shown[k] = k - 1
    return shown


@pytest.mark.parametrize(
    ("shown", "share", "said", "sigma"),
    [
        (every_second, 1 / 2, "the camera took 0.5 of", 1e-4),
        (every_fifth_put_in, 4 / 5, "the camera took 0.8 of", 1e-4),
        (every_fifth_lost, 1, "took the place of a lost frame", 1e-4),
        (put_in_here_and_there, 1, "took no time", 0.02),
        (lost_here_and_there, 1, "the place of a lost frame", 0.02),
    ],
)
def test_repeated_pictures_are_no_positions(made, shown, share, said, sigma):
    """Whether they took time is known from the flights; what hides in contacts is in the sigma."""
    frames = shown(len(made.track.frame))
    found = find_bounces(replayed(made, frames))
    assert abs(found.pooled.value - 0.75) < 4 * found.pooled.sigma < 4 * sigma
    assert found.base.share == share
    copies = np.flatnonzero(np.diff(frames) == 0) + 1
    assert set(found.base.duplicated_frames) <= set(copies)
    assert len(found.base.duplicated_frames) > 0.6 * len(copies)
    assert any(said in remark for remark in found.base.remarks)


def test_a_rate_is_that_of_the_pictures_that_differ(made):
    """Every picture twice in a file of 60 frames/s: 30 were taken; so times are those of 30."""
    frames = every_second(len(made.track.frame))
    track = replayed(made, frames)
    found = measure_drop(replace(track, time=track.frame / 60))
    assert found.rate.value == pytest.approx(30)
    assert found.rate_header == pytest.approx(60)
    times = found.to_dict()["contact_times_s"]
    assert times == pytest.approx(made.contacts[: len(times)] / 30, abs=1e-3)


def test_a_frame_lost_at_even_distances_is_put_back(made):
    """24 frames/s made to 20: one of six is missing, in contacts and about apexes, too."""
    n = len(made.track.frame)
    found = find_bounces(replayed(made, np.delete(np.arange(n), np.arange(2, n, 6))))
    agrees(found, made)
    assert found.base.share == 6 / 5
    assert found.base.dropped_frames[:3] == [2, 7, 12]


def test_frames_lost_from_short_flights_are_put_back():
    """Three of 60, each in a flight of some ten positions."""
    made = made_track([0.8] * 4, fall_frames=11.3, drop=300, held=6.2, noise=0.15, seed=3)
    found = find_bounces(replayed(made, np.delete(np.arange(len(made.track.frame)), [13, 31, 43])))
    agrees(found, made)
    assert sorted(found.base.dropped_frames) == pytest.approx([13, 30, 41], abs=1)


def test_frames_lost_where_nothing_shows_it_are_in_the_sigma():
    """A twentieth of all, in contacts, too: beyond three sigma is one clip of 370."""
    made = made_track([0.75] * 4, fall_frames=20.3)
    n = len(made.track.frame)
    for seed in range(6):
        kept = np.sort(np.random.default_rng(seed).choice(n, n - n // 20, replace=False))
        e = find_bounces(replayed(made, kept)).pooled
        assert abs(e.value - 0.75) < 3 * e.sigma


def test_time_stamps_are_used_where_they_are_true(made):
    """Frames at uneven times, stamped rightly."""
    rng = np.random.default_rng(5)
    keep = np.sort(rng.choice(len(made.track.frame), 170, replace=False))
    track = made.track.chosen(keep)
    stamped = Track(np.arange(170.0), track.x, track.y, time=track.frame / 100)
    found = find_bounces(stamped)
    z = (found.velocities[:, 0] - made.restitution) / found.velocities[:, 1]
    assert np.all(np.abs(z) < 4)
    assert not any("uneven" in remark for remark in found.base.remarks)


def test_uneven_stamps_of_an_even_camera_are_not_used(made):
    """Stamps of arrival, a third of a frame off: free fall shows that they are not true."""
    late = np.random.default_rng(5).normal(0, 0.3, len(made.track.frame)).clip(-0.45, 0.45)
    track = made.track
    stamped = Track(track.frame, track.x, track.y, time=(track.frame + late) / 100)
    found = find_bounces(stamped)
    assert any("uneven" in remark for remark in found.base.remarks)
    agrees(found, made)
