"""Noise that neighbouring positions share: tested against white noise, and in a fit's sigma."""

import numpy as np
import pytest
from made_tracks import made_track

from calibration.drop.bounce import find_bounces
from calibration.rendered.backdrop import Backdrop
from calibration.rendered.camera import Camera
from calibration.rendered.drop import Ball, DropScene
from calibration.statistics import shared_noise
from calibration.tracking.blobs import candidates, measure

ROWS = [np.arange(40 * k, 40 * (k + 1)) for k in range(4)]
TIME = np.arange(160.0)
S = np.tile(np.arange(40) - 19.5, 4)
PLACE = 0.5 * S**2  # [px]: from the apex, 0.5 px/frame^2


def fitted(noise):
    """Coefficients of every flight's parabola and their sigma, where the truth is zero."""
    design = np.zeros((160, 12))
    for k, one in enumerate(ROWS):
        design[one, 3 * k : 3 * k + 3] = np.stack([S[one] ** 0, S[one], S[one] ** 2 / 2], axis=1)
    beta = np.linalg.lstsq(design, noise, rcond=None)[0]
    found = shared_noise.covariances(noise - design @ beta, PLACE, TIME, ROWS)
    covariance = shared_noise.of_parameters(design, found, np.empty((0, 12)))
    return beta, np.sqrt(np.diag(covariance)), found


def drawn(share, length, random):
    """Noise of variance 1 with this share common within a length, flight by flight."""
    near = np.exp(-np.abs(PLACE[:40, None] - PLACE[None, :40]) / length)
    root = np.linalg.cholesky((1 - share) * np.eye(40) + share * near)
    return np.concatenate([root @ random.standard_normal(40) for _ in ROWS])


@pytest.mark.parametrize(("share", "length"), [(0.0, 1.0), (0.8, 12.0), (0.95, 6.0)])
def test_intervals_hold_the_truth_whether_noise_is_shared_or_not(share, length):
    """68 % intervals of c0, c1, c2: 60 clips of four flights, 720 values.

    Chance moves a share of 720 by 1.7 %, c0 and c2 of a flight are correlated: 60 to 76 % allows
    three sigma about 68 %.
    """
    random = np.random.default_rng(1)
    z = [
        beta / sigma for beta, sigma, _ in (fitted(drawn(share, length, random)) for _ in range(60))
    ]
    assert 0.60 <= np.mean(np.abs(z) < 1) <= 0.76


def test_white_noise_stays_white():
    """The likelihood of q = 0 is the larger in most clips: no point shares with another there.

    Chance finds a common part in some; in a quarter of 40 clips at most.
    """
    random = np.random.default_rng(2)
    shared = [
        np.any(found[0][0, 1:]) for *_, found in (fitted(drawn(0, 1, random)) for _ in range(40))
    ]
    assert np.mean(shared) < 0.25


def test_a_last_flight_of_three_positions_is_measured():
    """A fall of six frames, as at 25 frames/s: a third flight is known by the clip's acceleration.

    Its value is as far off as sigma says, to four sigma; sigma is above that of the bounce before.
    """
    made = made_track([0.62, 0.6], fall_frames=6.3, drop=200, noise=0.1)
    found = find_bounces(made.track)
    assert len(found.flights.rows[-1]) in (3, 4)
    assert len(found.contacts) == 2
    assert np.all(np.abs(found.velocities[:, 0] - made.restitution) < 4 * found.velocities[:, 1])


def test_the_shade_of_a_rotating_ball_does_not_move_its_position():
    """Lit from one side (half the light in the shade), with stripes: 20 px radius, a sharp lens.

    With one colour for the whole ball its place is 0.17 radii too near to the lamp, and turns with
    the stripes by a tenth of that; the rim's own colour leaves less than a third.
    """
    off = []
    for angle in np.linspace(0, 3, 7):
        ball = Ball(diameter=0.04, fall=0.1, colour=(0.8, 0.75, 0.7), rotation=angle, texture=0.2)
        look = Backdrop(wall=(0.1, 0.12, 0.15), plate=(0.1, 0.1, 0.1))
        empty = DropScene((), width=160, height=320, backdrop=look)
        scene = DropScene((ball,), width=160, height=320, backdrop=look)
        camera = Camera(100, exposure=0.05, blur=1.0, noise=1.0)
        random = np.random.default_rng(1)
        behind, seen = (camera.picture(one.paint, 1.0, random) for one in (empty, scene))
        difference = np.abs(seen.astype(int) - behind).max(axis=2).astype(np.uint8)
        [one, *_] = candidates(difference, np.full_like(difference, 12), 1)
        blob = measure(seen, behind, 1.0, one)
        x, y, radius = scene.position(ball, 1.0)
        off.append(((blob.x - x) / radius, (blob.y - y) / radius))
    assert np.abs(off).max() < 0.06, off
