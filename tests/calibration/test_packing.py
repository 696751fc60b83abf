"""Packing height and layers of a silo at rest, from pictures of bricks of known heights."""

from itertools import pairwise
from typing import NamedTuple

import cv2
import numpy as np
import pytest
from calibrating import calibrate
from refusals import assert_refused

from calibration.rendered.camera import Camera, write_film

SIDE, FLOOR, LEFT = 240, 300.4, 50.3  # px
BRICK = 20.0  # px, width and height of a brick; a column is a stack of them
TONES = ((0.16, 0.26, 0.38), (0.58, 0.72, 0.80))
SCALE = 0.5e-3  # m/px


class Bricks(NamedTuple):
    """A scene of bricks in layers, and its truth [m]."""

    light: np.ndarray
    height: float
    layers: list[float]


def bricks(seed: int, each: int = 3, layers: int = 4) -> Bricks:
    """Twelve stacks, each as much higher or lower as by half a brick, in layers of `each`."""
    random, fine = np.random.default_rng(seed), 4
    light = np.full((340 * fine, 340 * fine, 3), 0.06, np.float32)
    gap = 1.5
    tops = BRICK * each * layers + random.uniform(-BRICK / 2, BRICK / 2, 12)
    middles: list[list[float]] = [[] for _ in range(layers)]
    for k, top in enumerate(tops):
        edges = np.linspace(0, top, each * layers + 1)
        for j, (low, high) in enumerate(pairwise(edges)):
            x0, x1 = LEFT + BRICK * k, LEFT + BRICK * (k + 1)
            y0, y1 = FLOOR - high, FLOOR - low - (gap if j else 0)
            rows, columns = (
                slice(*(round(fine * v) for v in pair)) for pair in ((y0, y1), (x0, x1))
            )
            shade = random.uniform(-0.03, 0.03)
            light[rows, columns] = np.array(TONES[(j // each) % 2]) + shade
            middles[j // each].append((low + high) / 2)
    light[round(fine * FLOOR) :] = 0.35
    small = cv2.resize(light, (340, 340), interpolation=cv2.INTER_AREA)
    return Bricks(small, SCALE * tops.mean(), [SCALE * float(np.mean(m)) for m in middles])


def picture(scene: Bricks, seed: int) -> np.ndarray:
    camera = Camera(30, moments=1, noise=3.0, blur=0.9)
    return camera.picture(lambda _: scene.light, 0.0, np.random.default_rng(seed))


ROI = f"{round(LEFT)},10,{SIDE},{round(FLOOR) - 10}"
OPTIONS = ("--roi", ROI, "--scale", "0.5 mm/px", "--columns", "6", "--quiet")


def test_heights_come_back_within_their_uncertainty(tmp_path):
    """Eight pictures; the floor is 0.4 px off the whole pixels of --roi, sigma has 0.5 px.

    A brick's gap belongs to it: 0.75 px of 20, by a twentieth of a layer's height at most.
    """
    z, over = [], []
    for seed in range(8):
        scene = bricks(seed)
        path = tmp_path / f"bricks{seed}.png"
        cv2.imwrite(str(path), picture(scene, seed))
        found = calibrate("packing", path, *OPTIONS, "--layers", "4", "--json").json
        z.append((found["height"]["value"] - scene.height) / found["height"]["sigma"])
        pairs = zip(found["layers"], scene.layers, strict=True)
        over += [one["height"]["value"] - truth for one, truth in pairs]
        assert [one["painted"] for one in found["layers"]] == [True, False, True, False]
    assert np.abs(z).max() < 2.5
    assert np.sqrt(np.mean(np.square(z))) < 1.5
    assert np.abs(over).max() < 2 * SCALE


def test_a_film_at_rest_is_averaged_and_drawn(tmp_path):
    scene = bricks(1)
    film = write_film((picture(scene, k) for k in range(6)), tmp_path / "rest.avi", 30, "FFV1")
    done = calibrate("packing", film, *OPTIONS, "--out", tmp_path)
    assert done.code == 0, done.err
    assert "layer 4, light" in done.out
    assert (tmp_path / "packing-rest.png").stat().st_size > 20_000


def test_without_a_scale_lengths_are_in_pixels(tmp_path):
    scene, path = bricks(2), tmp_path / "bricks.png"
    cv2.imwrite(str(path), picture(scene, 2))
    options = [one for one in OPTIONS if one not in ("--scale", "0.5 mm/px")]
    found = calibrate("packing", path, *options, "--json").json
    assert found["length_unit"] == "px"
    assert abs(found["height"]["value"] - scene.height / SCALE) < 3 * found["height"]["sigma"]


@pytest.mark.parametrize(
    ("make", "options", "line"),
    [
        (lambda k: picture(bricks(1 + k), k), OPTIONS, "the silo is in motion"),
        (lambda k: picture(bricks(1), k), OPTIONS[2:], "--roi x,y,w,h"),
        (lambda k: picture(bricks(1), k), (*OPTIONS, "--layers", "6"), "4 painted layers are seen"),
        (lambda k: picture(bricks(1), k), ("--roi", "50,120,240,180", *OPTIONS[2:]),
         "what is behind the silo"),
        (lambda k: picture(bricks(1, 12, 1), k), (*OPTIONS, "--layers", "4"),
         "no painted layers are seen, not 4"),
        (lambda k: picture(bricks(1), k), (*OPTIONS, "--width", "120 mm"), "give one"),
    ],
)  # fmt: skip
def test_what_shows_no_packing_is_refused_in_one_line(tmp_path, make, options, line):
    film = write_film((make(k) for k in range(2)), tmp_path / "film.avi", 30, "FFV1")
    assert_refused(calibrate("packing", film, *options), line)
