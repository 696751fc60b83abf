"""Displacement between pictures by correlation and by optical flow: known motions, stated sigma."""

import functools

import numpy as np
import pytest
from made_pairs import (
    MOTIONS,
    SHAPE,
    errors,
    grains,
    particles,
    shear,
    uniform,
    vortex,
)

from calibration.piv import Reason, displacement
from calibration.piv.statistics import _spread
from calibration.piv.validation import filled, outliers
from calibration.piv.windows import Grid
from granulab.errors import InputError


@functools.cache
def measured(made, name, method):
    """A pair with one of the motions, and its field."""
    pair = made(MOTIONS[name], list(MOTIONS).index(name), shape=SHAPE)
    return pair, displacement(pair.a, pair.b, window=32, overlap=0.5, method=method)


@pytest.mark.parametrize("method", ["piv", "flow"])
@pytest.mark.parametrize("made", [particles, grains])
@pytest.mark.parametrize("name", MOTIONS)
def test_known_motion_comes_back(made, name, method):
    """Bias below a twentieth of a pixel, spread below a tenth: what is usual for windows of 32
    pixels with twenty particles or ten grains (Raffel et al. 2018, Particle Image Velocimetry,
    sec. 6.1); a window that shears holds grains that each move as a whole, 0.03 x 10 px apart.
    """
    pair, field = measured(made, name, method)
    wrong, _ = errors(field, pair.motion)
    assert field.valid.mean() > 0.95
    assert np.abs(wrong.mean(axis=1)).max() < 0.05
    assert np.sqrt((wrong**2).mean(axis=1)).max() < 0.1
    assert field.x.shape == field.u.shape == (11, 11)


@pytest.mark.parametrize("method", ["piv", "flow"])
def test_stated_sigma_covers_two_thirds(method):
    """60 to 76 % of the errors lie within sigma, over motions and textures: 2900 components, of
    which those of overlapping windows are not independent (a standard error of about 2 %). By
    texture it was 67 and 77 % ('piv'), 65 and 74 % ('flow') with four seeds."""
    inside = []
    for made in (particles, grains):
        for name in MOTIONS:
            pair, field = measured(made, name, method)
            wrong, sigma = errors(field, pair.motion)
            inside.append((np.abs(wrong) < sigma).ravel())
    assert 0.60 < np.concatenate(inside).mean() < 0.76


def test_sigma_follows_the_noise():
    """More noise, a larger error, and a sigma that says so (ratio of both within a quarter)."""
    ratios = []
    for noise in (1.0, 6.0, 15.0):
        pair = particles(uniform(2.4, 1.7), 5, shape=SHAPE, noise=noise)
        wrong, sigma = errors(displacement(pair.a, pair.b), pair.motion)
        ratios.append(np.sqrt((wrong**2).mean() / (sigma**2).mean()))
    assert ratios == pytest.approx([1.0] * 3, abs=0.25)


def test_no_locking_to_whole_pixels():
    """Over a pixel of displacements the mean error stays within 0.02 px. A three-point fit without
    deformation is off by up to 0.1 px, to whole pixels, with small particles (Westerweel 1997,
    Meas. Sci. Technol. 8, 1379)."""
    means = []
    for k, part in enumerate(np.arange(0, 1, 0.25)):
        pair = particles(uniform(2 + part, 0), 20 + k, shape=(160, 160), diameter=2.2)
        means.append(np.mean(errors(displacement(pair.a, pair.b), pair.motion)[0][0]))
    assert np.abs(means).max() < 0.02


@pytest.mark.parametrize("name", ["uniform", "shear", "vortex"])
def test_outliers_are_found_and_good_vectors_are_not(name):
    """One vector in ten drawn anywhere: of those that are off by more than a pixel 99 % are found,
    and 99 % of the good ones, with a noise of 0.05 px, stay (measured: 99.7 and 99.1 %)."""
    random = np.random.default_rng(1)
    y, x = 16.0 * np.mgrid[:20, :20]
    motion = {"uniform": uniform(3, 0), "shear": shear(0.05, 0), "vortex": vortex(4, 60, 160, 160)}
    u, v = motion[name](x, y)
    counts = np.zeros(4)
    for _ in range(30):
        bad = random.random(u.shape) < 0.1
        noise, thrown = (
            random.normal(0, 0.05, (2, *u.shape)),
            random.uniform(-16, 16, (2, *u.shape)),
        )
        seen = np.where(bad, thrown, np.stack([u, v]) + noise)
        far = bad & (np.hypot(seen[0] - u, seen[1] - v) > 1)
        found = outliers(seen[0], seen[1])
        counts += [(found & far).sum(), far.sum(), (found & ~bad).sum(), (~bad).sum()]
    assert counts[0] > 0.99 * counts[1]
    assert counts[2] < 0.011 * counts[3]


def test_a_linear_field_has_no_outlier_not_even_at_its_border():
    """The normalised median of raw neighbours fails there: they all lie on one side."""
    y, x = 16.0 * np.mgrid[:12, :12]
    u = 0.1 * y - 0.03 * x
    assert not outliers(u, -u).any()
    u[5, 6] += 3.0
    assert np.argwhere(outliers(u, u)).tolist() == [[5, 6]]


def test_what_is_no_vector_is_replaced_by_the_median_of_its_neighbours():
    values = np.arange(25.0).reshape(5, 5)
    values[2, 2] = np.nan
    assert filled(values)[2, 2] == 12.0  # between 11 and 13
    assert (filled(np.full((3, 3), np.nan)) == 0).all()


@pytest.mark.parametrize("tones", [(0.25, 0.75), (0.02, 0.98)])
@pytest.mark.parametrize("method", ["piv", "flow"])
def test_layers_do_not_outweigh_the_particles(tones, method):
    """Dark and bright layers fall by 5.3 px: along them, where their edges say nothing, the error
    is as small as elsewhere; across them below 0.15 px for black and white ones."""
    pair = grains(uniform(0.4, 5.3), 3, shape=SHAPE, tones=tones, noise=4.0)
    field = displacement(pair.a, pair.b, method=method)
    wrong, _ = errors(field, pair.motion)
    rms = np.sqrt((wrong**2).mean(axis=1))
    assert field.valid.mean() > 0.95
    assert rms[0] < 0.1
    assert rms[1] < 0.15


def test_walls_left_out_by_the_mask_do_not_hold_back_the_particles():
    """Particles fall between still walls: masked, all windows have their displacement."""
    pair = grains(uniform(0.5, 6.3), 3, shape=(200, 192), diameter=8.0, noise=3.0)
    random = np.random.default_rng(0)
    wall = np.zeros(pair.a.shape, dtype=bool)
    wall[:, :40], wall[:, -40:] = True, True
    still = random.normal(120, 30, wall.shape)
    a, b = (np.where(wall, still, one) for one in (pair.a, pair.b))
    field = displacement(a, b, window=24, mask=~wall)
    assert (field.reason[:, 0] == Reason.MASKED).all()
    assert np.isnan(field.u[:, 0]).all()
    assert field.valid[field.reason != Reason.MASKED].mean() > 0.95
    wrong, sigma = errors(field, pair.motion)
    # five sigma: of 400 normal deviates none is beyond
    assert np.abs(wrong).max() < 5 * np.sqrt((sigma**2).mean())


def test_light_that_changes_does_not_move_the_particles():
    """Half the light in one corner, and b darker than a: the texture stays where it is."""
    pair = grains(uniform(1.6, 0.4), 4, shape=SHAPE)
    light = np.linspace(1.0, 0.5, SHAPE[1])
    field = displacement(pair.a * light, 0.7 * pair.b * light)
    wrong, _ = errors(field, pair.motion)
    assert field.valid.all()
    assert np.sqrt((wrong**2).mean()) < 0.05


@pytest.mark.parametrize("method", ["piv", "flow"])
def test_pictures_without_texture_give_no_vector(method):
    """One grey level: nothing. Noise that is another in b: chance finds less than one in ten."""
    blank = np.full((128, 128), 90, dtype=np.uint8)
    assert not displacement(blank, blank, method=method).valid.any()
    random = np.random.default_rng(6)
    a, b = random.normal(90, 4, (2, 256, 256))
    assert displacement(a, b, method=method).valid.mean() < 0.1


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"window": 4}, "window = 4 px: must be from 8"),
        ({"window": 300}, "64 x 48 pixels"),
        ({"overlap": 0.9}, "overlap = 0.9: must be from 0 to 0.75"),
        ({"method": "lucas"}, "there are piv, flow"),
        ({"mask": np.ones((3, 3))}, "mask: shape"),
        ({"mask": np.zeros((48, 64))}, "leaves nothing"),
    ],
)
def test_what_is_no_question_is_refused(given, words):
    a = np.zeros((48, 64))
    with pytest.raises(InputError, match=words):
        displacement(a, a, **given)


def test_pictures_that_are_no_pair_are_refused():
    with pytest.raises(InputError, match="b: 64 x 40 pixels, and a 64 x 48"):
        displacement(np.zeros((48, 64)), np.zeros((40, 64)))
    with pytest.raises(InputError, match="not finite"):
        displacement(np.full((48, 64), np.nan), np.zeros((48, 64)))


def test_windows_without_difference_have_no_spread_and_no_warning():
    """Next to strong texture a window's sum of squares, 0, rounds to either side of it."""
    difference = 1e6 * np.random.default_rng(1).normal(size=(64, 64))
    difference[24:, 24:] = 0
    first = np.arange(0, 56, 8)
    where = Grid(8, first, first)
    assert (where.sums(difference**2)[3:, 3:] < 0).any()
    with np.errstate(invalid="raise"):
        spread = _spread(difference, where)
    # the squares add up to 2.5e15, known to 0.5; neighbours' texture enters the smoothed factor
    assert np.isfinite(spread).all()
    assert spread[5:, 5:].max() < 1e-3 * spread[:2, :2].min()
