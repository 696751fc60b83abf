"""Parts of films: masks by outlines, positions before shadows, frames decoded ahead of use."""

import threading
from contextlib import closing

import cv2
import numpy as np
import pytest

from calibration.tracking.blobs import (
    Candidate,
    filled,
    largest,
    measure,
    outlines,
    pixels_within,
)
from calibration.tracking.film.reader import ahead, open_film


@pytest.mark.parametrize("seed", range(5))
def test_outlines_enclose_the_parts_that_labels_give(seed):
    """As many parts; of those without holes Pick's theorem gives the number of pixels, exactly."""
    rng = np.random.default_rng(seed)
    coarse = cv2.GaussianBlur(rng.normal(size=(60, 80)), (0, 0), 2.5)
    mask = np.where(coarse > 0.1, 255, 0).astype(np.uint8)
    n, labels, stats, _ = cv2.connectedComponentsWithStats(mask)
    around = outlines(mask)
    assert len(around) == n - 1
    whole = 0
    for outline in around:
        inside = filled(outline, (0, 0, 80, 60)) > 0
        assert len(outline) == 1 or pixels_within(outline) == inside.sum()
        label = labels[outline[0, 0, 1], outline[0, 0, 0]]
        assert np.all(inside[labels == label])
        whole += stats[label, cv2.CC_STAT_AREA] == inside.sum()
    assert whole > 0


def test_the_largest_part_has_no_holes_and_nothing_next_to_it():
    mask = np.zeros((40, 40), np.uint8)
    mask[5:25, 5:25] = 255
    mask[10:14, 10:14] = 0
    mask[30:34, 30:34] = 255
    found = largest(mask)
    assert found[5:25, 5:25].all()
    assert np.count_nonzero(found) == 400
    assert largest(np.zeros((9, 9), np.uint8)) is None


def blurred_ball_before_its_shadow(shadow):
    """Picture and background of a green ball of 40 px, blurred over 30 px about y = 100.

    Behind its upper edge lies its shadow, which leaves this share of the light.
    """
    wall, ball = np.array([190.0, 205, 220]), np.array([60.0, 105, 20])
    y, x = np.indices((200, 200))
    cover = np.mean([np.clip(20.5 - np.hypot(x - 100, y - 100 - d), 0, 1)
                     for d in np.linspace(-15, 15, 61)], axis=0)[..., None]  # fmt: skip
    dark = np.where(np.hypot(x - 100, y - 65) < 35, shadow, 1.0)[..., None]
    picture = cover * ball + (1 - cover) * wall * dark
    return np.rint(picture).astype(np.uint8), np.broadcast_to(wall, picture.shape).astype(np.uint8)


@pytest.mark.parametrize(("shadow", "misses"), [(1.0, 0.05), (0.85, 1.5)])
def test_a_shadow_behind_a_blurred_edge_is_taken_off(shadow, misses):
    """Its colour is the wall's, darker: a F + c B is solved for both shares."""
    picture, wall = blurred_ball_before_its_shadow(shadow)
    mask = np.where(np.abs(picture.astype(float) - wall).max(axis=2) > 12, 255, 0)
    blob = measure(picture, wall, 0.5, Candidate((0, 0, 200, 200), 1.0, mask.astype(np.uint8)))
    assert (abs(blob.y - 100) > misses) == (misses > 1)
    assert abs(blob.y + blob.shadow[1] - 100) < 0.5
    assert abs(blob.x + blob.shadow[0] - 100) < 0.1


@pytest.fixture(name="film")
def _film(tmp_path):
    path = tmp_path / "noise.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 30, (64, 48))
    for k in range(40):
        writer.write(np.random.default_rng(k).integers(0, 256, (48, 64, 3)).astype(np.uint8))
    writer.release()
    return open_film(path)


def decoding():
    return [one for one in threading.enumerate() if one.name == "decoding"]


def test_frames_decoded_ahead_are_those_decoded_one_by_one(film):
    """Every bit of them, their order and their stamps."""
    for one, other in zip(film.frames(), film._of_video(), strict=True):
        assert one[:2] == other[:2]
        np.testing.assert_array_equal(one.picture, other.picture)
    assert not decoding()


def test_no_thread_is_left_where_a_film_is_not_read_to_its_end(film):
    """After an error of who uses the frames, Ctrl-C among them, as after an early end."""

    def interrupted():
        with closing(film.frames()) as frames:
            next(frames)
            assert len(decoding()) == 1
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert not decoding()
    assert [frame.number for frame in film.some([2, 5])] == [2, 5]
    assert not decoding()


def test_an_error_in_decoding_is_raised_where_its_frame_would_stand():
    def failing():
        yield 0
        raise OSError("disk gone")

    found = ahead(failing())
    assert next(found) == 0
    with pytest.raises(OSError, match="disk gone"):
        next(found)
    assert not decoding()
