"""What is a silo that empties and where it stands in a film, and what is none."""

from types import SimpleNamespace

import numpy as np
import pytest
from calibrating import calibrate
from refusals import assert_refused

from calibration.flow.silo import find_silo
from calibration.flow.survey import Survey
from calibration.flow.tracers import Steps
from calibration.rendered.camera import write_film
from granulab.errors import InputError

SHAPE = 200, 240
BOX = 60, 50, 120, 110  # of a silo, x, y, width, height [px]


def filled(backing, codec):
    """First and last picture of a silo before a backing, wrong by +-codec as codecs are: about
    what changes, in blocks of 8 px, twice as far as that."""
    random = np.random.default_rng(2)
    x, y, w, h = BOX
    last = np.full((*SHAPE, 3), 20.0)
    last[y - 30 : y + h, x : x + w] = backing
    first = last.copy()
    particles = np.where(
        np.arange(h)[:, None, None] < h // 2, (160.0, 90.0, 60.0), (60.0, 90.0, 150.0)
    )
    first[y : y + h, x : x + w] = particles + random.normal(0, 12, (h, w, 1))
    near = slice(y - 16, y + h + 16), slice(x - 16, x + w + 16)
    outside = np.ones(SHAPE, dtype=bool)
    outside[y : y + h, x : x + w] = False
    wrong = random.uniform(-codec, codec, (*SHAPE, 1)) * outside[..., None]
    first[near] += wrong[near]
    first, last = (np.clip(one, 0, 255).astype(np.uint8) for one in (first, last))
    return Survey(100, first, last, 1.0, 0, False)


@pytest.mark.parametrize("backing", [235.0, 20.0])
@pytest.mark.parametrize("codec", [0.0, 25.0])
def test_a_codec_s_errors_about_edges_are_no_part_of_the_silo(backing, codec):
    """They are many times what still pixels change by, and far from the particles' contrast: the
    silo's sides are right to a pixel, as whole pixels and a limit at half of the change want it."""
    film = SimpleNamespace(width=SHAPE[1], height=SHAPE[0])
    silo = find_silo(film, filled(backing, codec), None, None, None)
    found = silo.left, silo.top, silo.width, silo.height
    np.testing.assert_allclose(found, BOX, atol=1.0)


def test_the_outlet_is_where_particles_end_and_a_door_begins():
    """A plain door of 12 rows below the particles changes as they; its edge is known to a row."""
    seen = filled(20.0, 0.0)
    x, y, w, h = BOX
    seen.first[y + h : y + h + 12, x : x + w] = 120
    film = SimpleNamespace(width=SHAPE[1], height=SHAPE[0])
    assert find_silo(film, seen, None, None, None).outlet == pytest.approx(y + h, abs=1.0)


def moving(path, places, size=44, frames=60):
    """A film of a rough block whose top left corner goes along places (n, 2) [px]."""
    random = np.random.default_rng(4)
    block = random.uniform(60, 250, (size // 4, size // 4, 1)).repeat(4, 0).repeat(4, 1)
    pictures = []
    for x, y in np.rint(places).astype(int):
        picture = np.full((*SHAPE, 3), 30.0)
        picture[y : y + size, x : x + size] = block
        noisy = picture + random.normal(0, 2, picture.shape)
        pictures.append(np.clip(noisy, 0, 255).astype(np.uint8))
    return write_film(pictures, path, frames)


def swings(t):
    """Round and back again, and away in the end."""
    return np.column_stack([100 + 60 * np.cos(7 * t) * np.exp(-t), 60 + 20 * np.sin(14 * t)])


def bounces(t):
    """Falls of 0.5 s between bounces."""
    return np.column_stack([30 + 100 * t, 10 + 140 * (2 * np.mod(t, 0.5)) ** 2])


def leaves_sideways(t):
    """To the right, and out of sight."""
    return np.column_stack([20 + 170 * np.clip(t - 0.3, 0, 1), np.full(len(t), 60.0)])


@pytest.mark.parametrize("path", [swings, bounces, leaves_sideways])
def test_what_moves_otherwise_than_a_discharge_is_refused(tmp_path, path):
    """A pendulum, a ball and a block that goes are one line each, whatever part is looked at."""
    film = moving(tmp_path / "film.mp4", path(np.arange(0, 1.5, 1 / 60)))
    for options in ([], ["--roi", "0,0,240,200"], ["--roi", "15,55,60,50"]):
        result = calibrate("flow", film, "--no-velocity", "--quiet", *options)
        assert_refused(result)


@pytest.mark.parametrize("contrast", [0, 40])
def test_noise_alone_is_refused(tmp_path, contrast):
    """Of a camera that looks at a plain or a rough object that stands still, and of none."""
    random = np.random.default_rng(6)
    still = 120 + contrast * random.standard_normal((40, 50, 1)).repeat(4, 0).repeat(4, 1)
    for name, picture, noise in (("still", still, 3), ("snow", np.full((160, 200, 1), 120), 40)):
        frames = [picture + random.normal(0, noise, (160, 200, 3)) for _ in range(30)]
        film = write_film([np.clip(f, 0, 255).astype(np.uint8) for f in frames],
                          tmp_path / f"{name}.mp4", 30)  # fmt: skip
        result = calibrate("flow", film, "--no-velocity", "--quiet")
        assert_refused(result)


def test_a_part_outside_the_picture_is_refused():
    film = SimpleNamespace(width=SHAPE[1], height=SHAPE[0])
    with pytest.raises(InputError, match="within the picture of 240 x 200 px"):
        find_silo(film, filled(20.0, 0.0), (0, 0, 300, 100), None, None)


def test_tracers_in_a_window_of_a_shear_have_the_step_of_its_middle():
    """u = 2 + y/10, v = -x/20 px: linear, so that means over windows are its values at their
    middles, to rounding; an empty window has none. The variance is that of one tracer, 0.04 px^2,
    for what all share, and the scatter of (20/10)^2/12 and (20/20)^2/12 px^2 over 100 tracers in
    20 px, of either on average, for which of the flow they see."""
    x, y = np.meshgrid(np.arange(1, 60, 2.0), np.arange(1, 80, 2.0))
    place = np.column_stack([x.ravel(), y.ravel()])
    step = np.column_stack([2 + place[:, 1] / 10, -place[:, 0] / 20])
    at_x, at_y = np.array([20.0, 30.0, 40.0]), np.array([30.0, 40.0])
    steps = Steps(place, step, np.full(len(place), 0.04))
    u, v, variance = steps.means(at_x, at_y, 20.0)
    np.testing.assert_allclose(u, np.repeat(2 + at_y[:, None] / 10, 3, axis=1))
    np.testing.assert_allclose(v, np.repeat(-at_x[None] / 20, 2, axis=0))
    np.testing.assert_allclose(variance, 0.04 + (4 + 1) / 24 / 100, rtol=1e-3)
    assert np.isnan(steps.means(at_x, np.array([110.0, 120.0]), 20.0)[0]).all()
