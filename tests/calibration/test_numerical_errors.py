"""Exceptions of numerical libraries end in one line; drawn films, a cause of one, are measured."""

import cv2
import numpy as np
import pytest
from calibrating import calibrate
from scipy.optimize import brentq

from calibration.drop.measure import measure_drop

A, FIRST, RESTITUTION = 1.8, 13.6, 0.85  # px/frame^2, frame of the first contact


def drawn_film(folder, *, release=5.4, frames=60):
    """Pictures of a square without a grey rim: its position is rounded to whole pixels."""
    fall = FIRST - release
    drop, speed = A * fall**2 / 2, A * fall
    time = np.arange(frames)
    y = A * np.clip(time - release, 0, None) ** 2 / 2
    contact = FIRST
    while contact < frames:
        speed *= RESTITUTION
        s = time - contact
        y = np.where(s >= 0, drop - speed * s + A * s**2 / 2, y)
        contact += 2 * speed / A
    folder.mkdir()
    for k, height in enumerate(np.round(y).astype(int)):
        picture = np.full((140, 100, 3), 80, np.uint8)
        cv2.rectangle(picture, (45, 20 + height), (55, 30 + height), (255, 255, 255), -1)
        cv2.imwrite(str(folder / f"im{k:03d}.png"), picture)
    return folder


def test_a_drawn_object_without_a_grey_rim_is_measured(tmp_path):
    """Its centroid's covariance was zero, and the weights of the fit were infinite."""
    found = measure_drop(drawn_film(tmp_path / "film"))
    e = found.restitution
    assert abs(e.value - RESTITUTION) < 3 * e.sigma < 0.05
    assert np.all(found.bounces.track.covariance[:, [0, 1], [0, 1]] > 0)


def _scipy():
    return brentq(lambda x: 1 + x**2, 0, 1)


def _numpy():
    return np.linalg.pinv(np.full((2, 2), np.nan))


def _opencv():
    return cv2.cvtColor(np.zeros((2, 2, 7), np.uint8), cv2.COLOR_BGR2GRAY)


def _arithmetic():
    with np.errstate(all="raise"):
        return np.ones(1) / np.zeros(1)


@pytest.mark.parametrize("fails", [_scipy, _numpy, _opencv, _arithmetic])
def test_a_numerical_library_s_exception_is_one_line(monkeypatch, fails):
    monkeypatch.setattr("calibration.drop.measure.measure_drop", lambda *_, **__: fails())
    done = calibrate("drop", "clip.csv", "--fps", 240)
    assert (done.code, done.out) == (2, "")
    (line,) = done.err.splitlines()
    assert line.startswith("calibrate: drop clip.csv: its numbers cannot be evaluated (")


def test_a_fault_of_our_own_is_not_taken_for_a_measurement_s(monkeypatch):
    def fails(*_, **__):
        raise ValueError("ours")

    monkeypatch.setattr("calibration.drop.measure.measure_drop", fails)
    done = calibrate("drop", "clip.csv")
    assert done.code == 3
    assert "ValueError: ours" in done.err
