"""Films of objects on strings that are not the plain case, rendered: what is measured of each."""

import itertools
import math
from dataclasses import replace
from functools import partial

import cv2
import numpy as np
import pytest

from calibration import measure_pendulum
from calibration.pendulum import objects
from calibration.rendered import pendulum as rendered
from calibration.rendered.camera import Camera, write_film
from calibration.rendered.pendulum import PendulumScene
from calibration.rendered.strings import Strings, swing
from granulab.errors import InputError

CAMERA = Camera(60, noise=2, moments=3)
BLOCKS = PendulumScene(
    Strings(length=0.3, restitution=0.6, mass_ratio=1.0, beta=0.02, contacts=2), width=200,
    height=120, size=0.03, pivot=-110.0,
)  # fmt: skip
BALL = PendulumScene(
    Strings(length=0.3, restitution=0.7, contacts=3), width=160, height=120, scale=2e-3, size=0.05,
    pivot=-60.0, colours=((0.2, 0.6, 0.25),),
)  # fmt: skip


class Motion:
    """Angles given by a function of time, as of calibration.rendered.strings.Swinging."""

    def __init__(self, strings, angles, contacts):
        self.strings, self.angles, self.contacts = strings, angles, np.array(contacts)

    def out_of_plane(self, time):
        return np.zeros(len(time))


def film(folder, scene, motion=None, shift=lambda k: (0, 0)):
    """The film of a scene, each picture shifted, and its contacts in frames."""
    motion = motion or swing(scene.strings)
    times = np.arange(0, motion.contacts[-1] + 0.25, 1 / CAMERA.rate)
    pictures = CAMERA.film(partial(scene.paint, motion), times, 1)
    moved = (
        cv2.warpAffine(p, np.array([[1, 0, x], [0, 1, y]], dtype=float), p.shape[1::-1],
                       borderMode=cv2.BORDER_REFLECT)
        for p, (x, y) in zip(pictures, map(shift, itertools.count()), strict=False)
    )  # fmt: skip
    return write_film(moved, folder / "film.avi", CAMERA.rate, "MJPG"), (
        motion.contacts * CAMERA.rate
    )


def agrees(found, scene, most=0.05):
    """Within three sigma of less than a twentieth or another part, or 0.004.

    Places are off by 0.05 px that differ from one place to another: of amplitudes of 50 px, 0.002
    of a speed, in each of two swings.
    """
    e = found.restitution
    off = abs(e.value - scene.strings.restitution)
    return off < max(3 * e.sigma, 0.004) and e.sigma < most


def test_several_releases_in_a_film_are_measured_together(tmp_path):
    """The hand carries both blocks back between them: no swing, though no contact ends it."""
    once, rest, carry = swing(BLOCKS.strings), 0.25, 0.8
    caught = once.contacts[-1] + rest
    start, end = (once.angles(np.array([t]))[:, 0] for t in (caught, 0.0))

    def angles(time):
        share = np.clip((time - caught) / carry, 0, 1)
        carried = start[:, None] + (end - start)[:, None] * share**2 * (3 - 2 * share)
        again = once.angles(np.maximum(time - caught - carry, 0))
        return np.where(time < caught, once.angles(np.minimum(time, caught)),
                        np.where(share < 1, carried, again))  # fmt: skip

    motion = Motion(BLOCKS.strings, angles, [*once.contacts, *(caught + carry + once.contacts)])
    path, contacts = film(tmp_path, BLOCKS, motion)
    found = measure_pendulum(path)
    assert len(found.arcs) == 2
    assert agrees(found, BLOCKS)
    assert found.times[:, 0] == pytest.approx(contacts, abs=0.2)


def test_a_camera_that_sways_is_taken_off(tmp_path):
    """By 3 px with a period of 2.6 s; the wall's texture shows it, to a part of it. What is left is
    less than all of it: of an amplitude of 50 px, and at 50 px pi/33 a frame 0.6 of a frame.
    """
    path, contacts = film(tmp_path, BALL, shift=lambda k: (3 * math.sin(k / 25), math.cos(k / 31)))
    found = measure_pendulum(path)
    assert any("the camera moves by up to" in line for line in found.warnings)
    assert agrees(found, BALL, most=0.06)
    assert found.times[:, 0] == pytest.approx(contacts, abs=0.6)


def test_one_block_that_moves_and_strings_that_are_not_seen(tmp_path, monkeypatch):
    """A second block that nothing moves is a wall."""
    monkeypatch.setattr(rendered, "_string", lambda *_: None)
    scene = replace(
        BLOCKS, strings=replace(BLOCKS.strings, mass_ratio=1e6),
        colours=((0.15, 0.2, 0.75), (0.15, 0.6, 0.2)),
    )  # fmt: skip
    path, contacts = film(tmp_path, scene)
    found = measure_pendulum(path)
    assert len(found.arcs) == 1
    assert agrees(found, scene)
    assert found.times[:, 0] == pytest.approx(contacts, abs=0.2)


def test_where_colours_say_nothing_what_moves_is_followed(tmp_path, monkeypatch):
    """The same film by the way of calibrate drop."""

    def says_nothing(*_, **__):
        raise InputError("no colour is that of something that moves through the film")

    monkeypatch.setattr(objects, "by_colour", says_nothing)
    path, contacts = film(tmp_path, BALL)
    found = measure_pendulum(path)
    assert agrees(found, BALL)
    assert found.times[:, 0] == pytest.approx(contacts, abs=0.2)


def test_a_block_that_never_meets_the_other_is_refused(tmp_path):
    """It swings to and fro on its own side: its turning points are no contacts."""

    def angles(time):
        swung = -0.24 - 0.16 * np.cos(5.7 * np.maximum(time - 0.2, 0))
        return np.stack([swung, np.zeros(len(time))])

    path, _ = film(tmp_path, BLOCKS, Motion(BLOCKS.strings, angles, [2.0]))
    with pytest.raises(InputError, match="no contact") as refused:
        measure_pendulum(path)
    assert "\n" not in str(refused.value)
