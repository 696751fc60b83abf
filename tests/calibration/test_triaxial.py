"""Stiffness of an inclined contact, from rendered films of a triaxial test of known truth."""

import json
from dataclasses import replace

import numpy as np
import pytest
from calibrating import calibrate
from refusals import assert_refused

from calibration.bench.compression import Branch
from calibration.rendered.camera import Camera
from calibration.rendered.triaxial import TriaxialScene, film_triaxial
from calibration.tracking.film.reader import open_film
from calibration.triaxial.blocks import Line, relative
from calibration.triaxial.markers import Dots, follow
from calibration.triaxial.measure import measure_triaxial
from calibration.triaxial.stiffness import slopes
from granulab.contact.material import Measured

SCENE = TriaxialScene(cycles=2, width=180, height=180, scale=0.1e-3)
CAMERA = Camera(rate=8, noise=2.0, moments=1)
SCALE = Measured(SCENE.scale, 0.002 * SCENE.scale)


@pytest.fixture(scope="module")
def filmed(tmp_path_factory):
    """A film and the record of its load."""
    folder = tmp_path_factory.mktemp("triaxial")
    film, record = folder / "blocks.avi", folder / "load.csv"
    film_triaxial(SCENE, CAMERA, film, record, codec="FFV1")
    return film, record


def options(film, record, scene=SCENE):
    contact = ",".join(f"{one:.6f}" for one in scene.contact)
    return [
        "triaxial", film, "--load", record, "--contact", contact, "--scale",
        f"{1e3 * scene.scale:g} mm/px +- 0.2 %", "--load-line", f"{scene.load_line:.6f}", "--quiet",
    ]  # fmt: skip


def test_markers_are_followed_to_some_hundredths_of_a_pixel(filmed):
    """A dot of radius 4 px has 25 edge pixels, noise 2 of 90 grey levels: 0.01 px and less."""
    dots = follow(open_film(filmed[0]))
    assert dots.x.shape == (64, 8)
    scatter = relative(dots, Line(np.array(SCENE.contact).reshape(2, 2)), "").scatter
    assert scatter < 0.03


def test_rotation_of_a_block_is_no_approach_and_no_slip():
    """Rigid rotation of the upper block's markers about the contact's middle, to rounding."""
    line = Line(np.array([[0.0, 0.0], [100.0, 20.0]]))
    spots = np.array([[20, -20], [60, -15], [90, -5], [20, 30], [80, 40]], dtype=float)
    turn, slip = 0.01, np.array([0.4, -0.2])
    c, s = np.cos(turn), np.sin(turn)
    moved = spots.copy()
    moved[:3] = (spots[:3] - line.middle) @ np.array([[c, s], [-s, c]]) + line.middle + slip
    both = np.stack([spots, moved + np.array([3.0, 5.0])])  # the press moves both
    dots = Dots(np.arange(2.0), np.arange(2.0), both[:, :, 0], both[:, :, 1], np.ones(5))
    found = relative(dots, line, "")
    assert (found.x[1], found.y[1]) == pytest.approx(tuple(slip), abs=1e-9)
    assert found.rotation[1] == pytest.approx(turn)
    assert abs(found.mean_y[1] - slip[1]) > 0.05


def test_stiffness_and_contact_moment_of_a_rotating_contact_are_found(filmed):
    found = measure_triaxial(
        *filmed, contact=SCENE.contact, scale=SCALE, load_line=SCENE.load_line
    )  # fmt: skip
    known = {
        "kn": SCENE.kn, "kt": SCENE.kt, "kt_over_kn": SCENE.kt / SCENE.kn,
        "rotational_stiffness": SCENE.k_rotation, "eccentricity": SCENE.eccentricity,
    }  # fmt: skip
    for name, value in known.items():
        one = found.values[name]
        assert one.value == pytest.approx(value, abs=3 * one.sigma), name
    assert found.values["kn"].sigma < 0.02 * SCENE.kn
    assert found.moment().value == pytest.approx(SCENE.load * SCENE.eccentricity, rel=0.02)


@pytest.mark.parametrize("scatter", [0.0, 0.05, 0.2])
def test_sigma_covers_unloadings_that_differ(scatter):
    """Sigma holds the true slope in 68 %, and in more where frames' noise alone is there.

    400 tests of three unloadings each: 0.683 +- 0.023.
    """
    random, true, held = np.random.default_rng(2), 1e-6, 0
    load = np.tile(np.concatenate([np.linspace(10, 500, 30), np.linspace(500, 10, 60)]), 3)
    for _ in range(400):
        compliance = np.repeat(true * (1 + scatter * random.standard_normal(3)), 90)
        seen = compliance * load + 5e-6 * random.standard_normal(load.size)
        found = slopes(load, np.stack([seen] * 2), Branch(0.9, 0.1, 0.3), "")
        sigma = np.sqrt(max(one[0, 0] for one in found.covariances))
        held += abs(found.value[0] - true) < sigma
    assert 0.63 < held / 400 < (0.74 if scatter else 0.82)


def test_sigma_covers_loads_scales_and_codecs(tmp_path):
    """Of twelve values of six films none is off by four sigma, five lie within (p = 0.03)."""
    off = []
    for seed, codec in enumerate(("FFV1", "MJPG", "mp4v") * 2):
        random = np.random.default_rng(seed)
        scene = replace(
            SCENE, seed=seed, kn=SCENE.kn * random.uniform(0.7, 1.5), dots=2 + seed % 3,
            inclination=np.radians(random.uniform(8, 20)),
        )  # fmt: skip
        film = tmp_path / f"clip{seed}.{'mp4' if codec == 'mp4v' else 'avi'}"
        record = tmp_path / f"clip{seed}.csv"
        film_triaxial(scene, CAMERA, film, record, late=0.3, seed=seed, codec=codec)
        contact = np.array(scene.contact) + random.normal(0, 0.5, 4)
        found = measure_triaxial(film, record, contact=contact, scale=SCALE, offset=0.3)
        off += [
            (found.values[name].value - value) / found.values[name].sigma
            for name, value in (("kn", scene.kn), ("kt", scene.kt))
        ]
    assert np.abs(off).max() < 4
    assert np.sum(np.abs(off) < 1) >= 5


def test_command_reports_draws_and_writes_both(filmed, tmp_path):
    wood = tmp_path / "wood.toml"
    wood.write_text("schema = 1\n", encoding="utf-8")
    done = calibrate(
        *options(*filmed), "--json", "-o", tmp_path, "--into", wood, "--pair", "wood-wood"
    )
    assert done.code == 0, done.err
    answers = json.loads(done.out)
    assert (tmp_path / "triaxial-blocks.png").read_bytes()[:4] == b"\x89PNG"
    moment = answers["contact_moment"]
    lever = moment["eccentricity_m"]["value"]
    assert moment["moment_n_m"]["value"] == pytest.approx(moment["at_load_n"] * lever)
    written = wood.read_text(encoding="utf-8")
    assert "kn = " in written
    assert "kt = " in written


REFUSED = {
    "no markers": (replace(SCENE, dots=0), "", (), "no markers"),
    "one side": (SCENE, "", ("--contact", "30,175,150,178"), "0 markers on the lower block"),
    "no overlap": (SCENE, "", ("--offset", "100 s"), "do not overlap"),
    "no unloading": (SCENE, "time [s],load [N]\n0,0\n10,1000\n", (), "no unloading"),
    "no load": (SCENE, "time [s],weight [N]\n0,0\n10,1000\n", (), "no column 'load'"),
    "level": (SCENE, "", ("--contact", "30,90,150,90"), "nothing is sheared"),
    **{
        f"load line {x}": (SCENE, "", ("--load-line", x), f"--load-line {x}: ")
        for x in ("nan", "inf", "5000", "-5")
    },
    "scale": (SCENE, "", ("--scale", "0.1 mm"), "length per pixel"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_gives_no_stiffness_is_refused_in_one_line(name, filmed, tmp_path):
    scene, load, more, words = REFUSED[name]
    film, record = filmed
    if scene is not SCENE:
        film = tmp_path / "clip.avi"
        film_triaxial(replace(scene, period=1.0), CAMERA, film, tmp_path / "r.csv", codec="FFV1")
    if load:
        record = tmp_path / "load.csv"
        record.write_text(load, encoding="utf-8")
    assert_refused(calibrate(*options(film, record), *more), words)


def test_a_record_that_is_no_load_is_refused_before_the_film_is_followed(tmp_path, monkeypatch):
    def followed(*_):
        raise AssertionError("the film is followed")

    film, record = tmp_path / "blocks.avi", tmp_path / "load.csv"
    film_triaxial(replace(SCENE, period=1.0), CAMERA, film, record, codec="FFV1")
    record.write_text("time [s],weight [N]\n0,0\n10,1000\n", encoding="utf-8")
    monkeypatch.setattr("calibration.triaxial.measure.follow", followed)
    assert_refused(calibrate(*options(film, record)), "no column 'load'")
