"""Restitution of particles that rebound with rotation, from rendered films and from equations."""

import json
from dataclasses import replace

import numpy as np
import pytest
from calibrating import calibrate
from refusals import assert_refused

from calibration.rebound.impact import Arm, Motion, after_impact, at_contact, energy
from calibration.rebound.measure import measure_rebound
from calibration.rebound.shape import gyration, outline, touch
from calibration.rendered.camera import Camera, write_film
from calibration.rendered.particle import Prism, PrismScene, film_prism
from calibration.tracking.film.reader import open_film

PENTAGON = Prism(
    ((0, 0), (10e-3, 1e-3), (13e-3, 7e-3), (6e-3, 12e-3), (-1e-3, 6e-3)), rounding=0.5e-3
)
SCENE = PrismScene(
    PENTAGON, height=0.085, velocity=(0.05, -0.3), omega=12.0, width=220, image_height=220,
    plate=0.87, position=0.5,
)  # fmt: skip
CAMERA = Camera(rate=500, noise=2.0, moments=1)
DURATION = 0.17  # s: 40 frames before the contact, 30 after


@pytest.fixture(scope="module")
def filmed(tmp_path_factory):
    """A film of the pentagon, its truth."""
    path = tmp_path_factory.mktemp("rebound") / "pentagon.avi"
    return path, film_prism(SCENE, CAMERA, path, duration=DURATION, codec="FFV1")


@pytest.mark.parametrize("friction", [0.1, 0.5, np.inf])
def test_impulse_gives_restitution_at_the_point_and_conserves_moment_about_it(friction):
    """Angular momentum about the point of contact: the impulse has no moment there."""
    arm, k = Arm(3e-3, -6e-3), 4e-3
    before = Motion(0.4, -1.2, 20.0)
    after = after_impact(before, arm, k, 0.6, 0.2, friction)
    u, v = at_contact(before, arm), at_contact(after, arm)
    assert -v[1] / u[1] == pytest.approx(0.6)

    def about(one: Motion) -> float:
        return k**2 * one.omega - (arm.t * one.n - arm.n * one.t)

    assert about(after) == pytest.approx(about(before))
    impulse = after.t - before.t, after.n - before.n
    assert abs(impulse[0]) <= friction * impulse[1] * (1 + 1e-12)
    if friction == np.inf:
        assert -v[0] / u[0] == pytest.approx(0.2)
    assert energy(after, k).whole < energy(before, k).whole


def test_gyration_and_point_of_contact_of_a_square_that_stands_on_its_corner():
    """k^2 = a^2/6; the corner lies a/sqrt(2) below. Directions 3.75 degrees apart blunt it."""
    side, angle = 40.0, -2 * np.pi * np.arange(96) / 96
    radius = side / 2 / np.maximum(np.abs(np.cos(angle)), np.abs(np.sin(angle)))
    assert gyration(radius)[0] == pytest.approx(side / 6**0.5, rel=2e-3)
    found = touch(outline(radius), np.pi / 4, 0.0, 0.0)
    assert found.arm.n == pytest.approx(-side / 2**0.5, abs=2 * found.sigma_n)
    assert found.arm.t == pytest.approx(0.0, abs=found.sigma_t)
    flat = touch(outline(radius), 0.0, np.radians(0.5), 0.0)
    assert flat.sigma_t > 0.2 * side


def test_restitution_at_the_point_differs_from_that_of_the_centroid_and_both_are_found(filmed):
    path, truth = filmed
    found = measure_rebound(path)
    true, values = truth.contacts[0], found.contacts[0].values
    known = {
        "restitution": true.restitution, "restitution_centroid": true.apparent,
        "omega_before": true.before.omega / 500, "omega_after": true.after.omega / 500,
        "energy_lost": 1 - energy(true.after, truth.gyration).whole
        / energy(true.before, truth.gyration).whole,
    }  # fmt: skip
    for name, value in known.items():
        assert values[name].value == pytest.approx(value, abs=3 * values[name].sigma), name
    apart = values["restitution"].value - values["restitution_centroid"].value
    assert apart > 10 * values["restitution_centroid"].sigma
    shares = [values[f"{part}_before"].value for part in ("normal", "tangential", "rotational")]
    assert sum(shares) == pytest.approx(1.0)
    assert found.scale.value == pytest.approx(SCENE.scale, rel=0.02)


def test_a_film_with_every_picture_twice_has_the_lengths_and_rates_of_its_camera(filmed, tmp_path):
    """1000 frames/s in the file's head, 500 of the camera: at 1000 lengths are a quarter as long.

    As well known as in the film without copies: within 2 %, free fall in 70 frames.
    """
    path, truth = filmed
    pictures = [frame.picture for frame in open_film(path).frames() for _ in range(2)]
    found = measure_rebound(write_film(pictures, tmp_path / "twice.avi", 1000, "FFV1"))
    assert found.rate == pytest.approx(500)
    assert found.scale.value == pytest.approx(SCENE.scale, rel=0.02)
    spin = found.to_dict()["contacts"][0]["angular_velocity_after_rad_s"]
    assert spin["value"] == pytest.approx(truth.contacts[0].after.omega, abs=4 * spin["sigma"])


def test_sigma_covers_particles_speeds_and_codecs(tmp_path):
    """Of six films none is off by four sigma, two and more lie within (p = 0.02 for fewer)."""
    off = []
    for seed, codec in enumerate(("FFV1", "MJPG", "mp4v") * 2):
        random = np.random.default_rng(seed)
        scene = replace(
            SCENE, angle=random.uniform(0, 6), omega=random.uniform(-15, 15),
            restitution=random.uniform(0.4, 0.8), tilt=np.radians(random.normal(0, 0.5)),
        )  # fmt: skip
        path = tmp_path / f"clip{seed}.{'mp4' if codec == 'mp4v' else 'avi'}"
        truth = film_prism(scene, CAMERA, path, duration=DURATION, seed=seed, codec=codec)
        found = measure_rebound(path)
        e = found.contacts[0].values["restitution"]
        off.append((e.value - truth.contacts[0].restitution) / e.sigma)
    assert np.abs(off).max() < 4
    assert np.sum(np.abs(off) < 1) >= 2


def test_command_reports_draws_and_writes_restitution_at_the_point(filmed, tmp_path):
    path, truth = filmed
    wood = tmp_path / "wood.toml"
    wood.write_text("schema = 1\n", encoding="utf-8")
    done = calibrate(
        "rebound", path, "--json", "-o", tmp_path, "--into", wood, "--pair", "wood-steel"
    )
    assert done.code == 0, done.err
    answers = json.loads(done.out)
    assert (tmp_path / "rebound-pentagon.png").read_bytes()[:4] == b"\x89PNG"
    assert answers["restitution"]["at"] == "point of contact"
    spin = answers["contacts"][0]["angular_velocity_after_rad_s"]
    assert spin["value"] == pytest.approx(truth.contacts[0].after.omega, abs=4 * spin["sigma"])
    assert f"{answers['restitution']['value']:.3f}" in wood.read_text(encoding="utf-8")


def square() -> PrismScene:
    """A square that lands on a side, 6 degrees off: its other corner follows in half a frame."""
    side = 10e-3
    prism = Prism(((0, 0), (side, 0), (side, side), (0, side)))
    return replace(SCENE, prism=prism, angle=0.1, omega=0.0, velocity=(0.0, -0.3), restitution=0.8)


def ball() -> PrismScene:
    angle = 2 * np.pi * np.arange(40) / 40
    prism = Prism(tuple((6e-3 * np.cos(a), 6e-3 * np.sin(a)) for a in angle.tolist()))
    return replace(SCENE, prism=prism)


REFUSED = {
    "round": (ball(), DURATION, (), "round within noise"),
    "on a side": (square(), DURATION, (), "lands on a side"),
    "no contact": (SCENE, 0.08, (), "no contact is seen"),
    "steep plate": (None, 0.0, ("--plane", "80 deg"), "--plane"),
    "gyration": (None, 0.0, ("--gyration", "-1 mm"), "must be positive"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_shows_no_single_contact_is_refused_in_one_line(name, tmp_path):
    scene, duration, options, words = REFUSED[name]
    path = tmp_path / "clip.avi"
    if scene is not None:
        film_prism(scene, CAMERA, path, duration=duration, codec="FFV1")
    assert_refused(calibrate("rebound", path, "--quiet", *options), words)
