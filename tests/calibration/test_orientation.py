"""Orientation of objects followed in rendered films of known rotation."""

import numpy as np
import pytest

from calibration.rendered.camera import Camera
from calibration.rendered.drop import Ball, DropScene, film_drop
from calibration.rendered.particle import Prism, PrismScene, film_prism
from calibration.tracking.film.reader import open_film
from calibration.tracking.follow import follow
from calibration.tracking.orientation import orientation
from calibration.tracking.track import Track
from granulab.errors import InputError

SHAPES = {
    "pentagon": (((0, 0), (10, 1), (13, 7), (6, 12), (-1, 6)), 360),
    "square": (((0, 0), (10, 0), (10, 10), (0, 10)), 90),
    "plate": (((0, 0), (16, 0), (16, 8), (0, 8)), 180),
}
CAMERA = Camera(rate=500, noise=2.0)


def prism(corners) -> Prism:
    return Prism(tuple((x * 1e-3, y * 1e-3) for x, y in corners), rounding=0.5e-3)


@pytest.mark.parametrize("name", SHAPES)
def test_rotation_is_followed_through_a_rebound_whatever_the_symmetry(name, tmp_path):
    """48 % and more of 60 frames lie within sigma, of which 68 % are expected: 3.3 sigma less.

    sigma is the larger of two: of the matched filter, and of third differences; so more may lie in.
    """
    corners, period = SHAPES[name]
    scene = PrismScene(prism(corners), omega=12.0, height=0.04, width=200, image_height=200)
    film = tmp_path / "film.avi"
    truth = film_prism(scene, CAMERA, film, duration=0.14, codec="FFV1")
    track = follow(open_film(film))[0]
    found = orientation(track)
    known = -truth.angle[track.frame.astype(int)]
    off = found.angle - known
    off -= np.median(off)
    assert len(truth.contacts) >= 1
    assert np.ptp(known) > 0.8
    assert np.degrees(found.period) == pytest.approx(period)
    within = np.mean(np.abs(off) < found.sigma)
    assert 0.48 < within < 0.96
    assert np.abs(off).max() < np.radians(1.0)


def test_a_ball_has_no_orientation(tmp_path):
    film = tmp_path / "film.avi"
    scene = DropScene((Ball(fall=0.1),), width=120, height=220)
    film_drop(scene, Camera(rate=100), film, duration=0.4, codec="FFV1")
    with pytest.raises(InputError, match="round within noise"):
        orientation(follow(open_film(film))[0])


def test_a_table_shows_no_silhouette():
    t = np.arange(9.0)
    with pytest.raises(InputError, match="no silhouette"):
        orientation(Track(t, t, t))
