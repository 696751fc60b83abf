"""The time base put right from free fall: repeated frames, frames left out, uneven stamps."""

import numpy as np
import pytest
from made_tracks import made_track

from calibration.drop.bounce import find_bounces
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


def test_every_fifth_frame_repeated_as_by_a_converter(made):
    """24 to 30 frames/s: all copies in fast flight are found; restitution is not moved."""
    shown = np.sort(np.concatenate([np.arange(len(made.track.frame)), np.arange(0, 230, 4)]))
    shown = shown[shown < len(made.track.frame)]
    found = find_bounces(replayed(made, shown))
    assert len(found.base.duplicated_frames) > 20
    assert abs(found.pooled.value - 0.75) < max(4 * found.pooled.sigma, 0.01)


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
