"""Air drag in a drop test: y'' = a - |a| v|v|/w^2, integrated here, against its first order."""

from dataclasses import replace

import numpy as np
import pytest

from calibration.drop.bounce import find_bounces
from calibration.drop.drag import slowness, with_drag
from calibration.tracking.track import Track

A, DROP, E = 0.6, 500.0, 0.8  # px/frame^2, px


def fallen(w, shutter=0.0, noise=0.05, seed=1):
    """A track that falls from rest at frame 10 and bounces four times; speed falls by E at each.

    shutter   frames by which a pixel is read later than that above it
    """
    step, y, v, places = 1e-3, 0.0, 0.0, []
    bounces = 0
    while bounces < 5:
        places.append(y)
        v += (A - A * v * abs(v) / w**2) * step
        y += v * step
        if y > DROP:
            y, v, bounces = DROP, -E * v, bounces + 1
    fine = np.arange(len(places)) * step + 10
    frame = np.arange(0, np.floor(fine[-1]))
    y = np.interp(frame, fine, places)
    for _ in range(3):  # the row in which it is seen says when
        y = np.interp(frame + shutter * y, fine, places)
    y = y + np.random.default_rng(seed).normal(0, noise, len(frame))
    return Track(frame, 0 * frame, y)


def test_drag_is_found_and_what_it_hides_is_in_the_sigma():
    """w = 120 px/frame, impacts at up to 24: (v/w)^2 = 0.04, so first order is good to a tenth."""
    found = find_bounces(fallen(120.0))
    slow, drags = slowness(found)
    assert drags
    assert slow.value == pytest.approx(120.0**-2, rel=0.1, abs=3 * slow.sigma)
    corrected = with_drag(found)
    assert "air drag shows" in corrected.warnings[-1]
    off = E - found.pooled.value
    assert off > 4 * found.pooled.sigma  # times alone would be wrong
    assert corrected.pooled.sigma == pytest.approx(off, rel=0.15)


@pytest.mark.parametrize("shutter", [0.0, 1 / 500, -1 / 500])
def test_a_vacuum_and_a_shutter_that_reads_row_by_row_have_no_drag(shutter):
    found = find_bounces(fallen(1e6, shutter))
    assert with_drag(found) is found


def test_a_track_with_y_upwards_has_the_same_drag():
    track = fallen(120.0)
    down, up = (slowness(find_bounces(one))[0] for one in (track, replace(track, y=-track.y)))
    assert up.value == pytest.approx(down.value, rel=1e-6)


def test_drag_is_not_read_out_of_flights_that_are_seen_wrong():
    """Each flight has an acceleration that drag cannot give it, and a bend of its own.

    A flight is bent by 2 px at most, as light or perspective bend it: without the scatter of the
    accelerations the bends of four flights, fitted to noise of 0.05 px, are drag.
    """
    made = fallen(1e6)
    found = find_bounces(made)
    y, drawn = made.y.copy(), (1.0, -0.8, 0.9, -0.7)
    for rows, stretched in zip(found.flights.rows[1:], drawn, strict=False):
        u = np.linspace(-1, 1, len(rows))
        y[rows] -= 8 * stretched * (1 - u**2) + 2 * (u**3 - u)
    seen = find_bounces(replace(made, y=y))
    assert seen.flights.scatter > 0
    slow, _ = slowness(seen)
    assert abs(slow.value) < 3 * slow.sigma
    assert with_drag(seen) is seen
