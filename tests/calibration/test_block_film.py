"""Friction and tangential damping from rendered films of a block on a plate, of known truth."""

import math
import tomllib
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from bench_calls import write
from calibrating import calibrate
from refusals import assert_refused

from calibration.bench.sections import Request, filmed
from calibration.bench.slide import GRAVITY
from calibration.block.slip import first_slip
from calibration.block.way import fit_way, from_any, from_rest
from calibration.methods import measure_incline, measure_slide
from calibration.rendered.block import (
    BlockScene,
    Made,
    Tilt,
    film_block,
    slide_by_chance,
    tilt_by_chance,
)
from calibration.rendered.camera import Camera
from calibration.statistics.uncertainty import Estimate
from granulab.errors import InputError

SMALL = (300, 220)
SCENE = BlockScene(
    *SMALL, pivot=(30.3, 190.6), plate=(240, 12), block=(36, 26), at=170.0, scale=1e-3
)
CAMERA = Camera(30, moments=1)
TILT = Tilt(start=8, rate=8, lead=0.1, friction=0.3)  # slips after 1.2 s


def film(folder, made: Made, name: str, seed: int = 1):
    """The film of a scene; one in two by a codec that knows the frame before, as cameras do."""
    path = folder / f"{name}.{'mp4' if seed % 2 else 'avi'}"
    codec = "mp4v" if seed % 2 else "MJPG"
    film_block(*made[:3], path, duration=made.duration, seed=seed, codec=codec)
    return path


@pytest.fixture(scope="module")
def tilted(tmp_path_factory):
    """Four films of plates that tilt, each of another friction, and what `incline` says."""
    folder, found = tmp_path_factory.mktemp("tilted"), []
    for seed in (3, 5, 8, 13):
        made = tilt_by_chance(seed, SMALL)
        path = film(folder, made, f"tilt{seed}", seed)
        found.append((made, path, calibrate("incline", path, "--json", "--quiet").json))
    return found


@pytest.fixture(scope="module")
def slid(tmp_path_factory):
    """Three films of blocks that slide, and what `slide` says."""
    folder, found = tmp_path_factory.mktemp("slid"), []
    for seed in (3, 5, 8):
        made = slide_by_chance(seed, SMALL)
        path = film(folder, made, f"slide{seed}", seed)
        scale = f"{made.scene.scale * 1e3!r} mm/px"
        said = calibrate("slide", path, "--scale", scale, "--json", "--quiet").json
        found.append((made, path, said))
    return found


def covers(pairs: list[tuple[dict, float]]) -> np.ndarray:
    """How far values are off their truths, in their sigmas."""
    return np.array([(one["value"] - truth) / one["sigma"] for one, truth in pairs])


def test_friction_of_first_slip_comes_back_within_its_uncertainty(tilted):
    """mu = tan(alpha). Four films: none off by 4 sigma, and known to 1 %; 110 others are in
    docs/results/calibration/block-coverage.txt."""
    pairs = [(said["friction"], made.tilt.friction) for made, _, said in tilted]
    z = covers(pairs)
    assert np.abs(z).max() < 4
    assert np.sqrt(np.mean(z**2)) < 1.7  # of four: one in 50
    assert all(one["sigma"] < 0.01 * truth for one, truth in pairs)


def test_the_angle_of_repose_is_that_of_first_slip(tilted):
    for made, _, said in tilted:
        one = said["angle_of_repose_rad"]
        assert math.tan(one["value"]) == pytest.approx(said["friction"]["value"], rel=1e-12)
        off = (said["films"][0]["slip_frame"]["value"] - made.tilt.slip * made.camera.rate) / 30
        assert abs(off) < 0.1  # s


def test_sliding_comes_back_within_its_uncertainty(slid):
    """gamma_t, v0 = g (sin - mu cos)/gamma_t (eq. 3.11c), and the friction while sliding."""
    pairs = []
    for made, _, said in slid:
        tilt, angle = made.tilt, math.radians(made.tilt.start)
        v0 = GRAVITY * (math.sin(angle) - tilt.friction * math.cos(angle)) / tilt.damping
        pairs += [
            (said["gamma_t_per_s"], tilt.damping),
            (said["terminal_velocity_m_s"], v0),
            (said["friction_sliding"], tilt.friction),
        ]
    z = covers(pairs)
    assert np.abs(z).max() < 4
    assert np.sqrt(np.mean(z**2)) < 1.8
    assert all(one["sigma"] < 0.05 * truth for one, truth in pairs)


def test_films_are_pooled_written_and_drawn(tilted, tmp_path):
    """Two films are two trials; each has a figure of its own, and --into takes the mean."""
    files = [path for _, path, _ in tilted[:2]]
    done = calibrate("incline", *files, "--into", tmp_path / "wood.toml", "--pair", "wood-wood",
                     "--out", tmp_path, "--json", "--quiet")  # fmt: skip
    single = [said["friction"]["value"] for _, _, said in tilted[:2]]
    assert done.json["friction"]["trials"] == 2
    assert done.json["friction"]["value"] == pytest.approx(np.mean(single), rel=1e-9)
    stored = tomllib.loads((tmp_path / "wood.toml").read_text(encoding="utf-8"))
    assert stored["pair"]["wood-wood"]["friction"]["value"] == pytest.approx(np.mean(single), 1e-4)
    for path in files:
        assert (tmp_path / f"incline-{path.stem}-film.png").stat().st_size > 20_000
    assert (tmp_path / f"incline-{files[0].stem}.png").exists()


def test_films_in_several_folders_are_groups_by_their_names(tmp_path):
    """And a constant stands in place of what a film gives."""
    files = [tmp_path / pairing / f"{k}.mp4" for pairing in ("oak", "steel") for k in range(2)]
    seen = {"angle": 0.3, "incline": 0.5}
    sections = filmed(files, lambda path: seen, Request(constants={"incline": 0.4}))
    assert [one.group for one in sections] == ["oak", "oak", "steel", "steel"]
    assert all(one.columns["incline"] == [0.4] for one in sections)
    only = filmed(files, lambda path: seen, Request(only="steel"))
    assert [one.name for one in only] == ["0.mp4", "1.mp4"]
    with pytest.raises(InputError, match="given twice"):
        filmed([files[0], files[0]], lambda path: seen, Request())


def test_a_plate_that_starts_past_the_rows_of_a_rolled_camera_tilts_from_its_start(tmp_path):
    """Level at first and rolled by -1 deg: the picture's inclination goes through 0, its own not.

    Counted by its size the first degree would be lost twice: 14.7 deg for the 16.7 that it is.
    """
    tilt = replace(TILT, start=0.0, rate=16.0)
    made = Made(replace(SCENE, roll=-1.0), tilt, CAMERA, tilt.slip + 0.4)
    path, truth = film(tmp_path, made, "rolled"), math.atan(TILT.friction)
    found = calibrate("incline", path, "--json", "--quiet", "--start-angle", "0 deg").json
    one = found["angle_of_repose_rad"]
    assert abs(one["value"] - truth) < math.radians(0.5)


def test_what_a_level_is_off_is_in_the_mean_of_all_films(tmp_path, monkeypatch):
    """0.5 deg that four films share are 0.5 deg of their mean; of a table's trial none."""
    found = iter(np.radians([20.0, 20.1, 19.9, 20.0]))

    def measured(path, options, progress):
        own = Estimate(next(found), 1e-3, 1)
        return SimpleNamespace(found=own, remarks=(), path=path, to_dict=dict)

    monkeypatch.setattr("calibration.block.measure.measure_tilt", measured)
    start = "0 deg +- 0.5 deg"
    _, angle = measure_incline(
        [tmp_path / f"{k}.mp4" for k in range(4)], start_angle=start
    ).quantities
    whole = angle.pooled.all
    assert angle.shared["--start-angle"] == pytest.approx(math.radians(0.5), rel=1e-9)
    assert math.degrees(whole.sigma) == pytest.approx(0.5, rel=0.02)


def test_a_known_incline_stands_in_place_of_the_pictures(tmp_path, monkeypatch):
    """Its sigma, too: whatever that of the picture's edge is, mu has the one that is given."""
    t = np.linspace(0, 1.5, 60)
    way = from_rest(t, 0.43, 3.0, 0.1, 0.0) + np.random.default_rng(1).normal(0, 1e-6, 60)

    def measured(sigma):
        return lambda path, options, scale, progress: SimpleNamespace(
            time=t, way=way, incline=Estimate(0.6, sigma, 1), remarks=(), path=path, to_dict=dict
        )

    sigmas = []
    for sigma in (1e-9, 0.1):
        monkeypatch.setattr("calibration.block.measure.measure_slide", measured(sigma))
        found = measure_slide(
            tmp_path / "a.mp4", scale="1 mm/px", constants={"incline": "30 deg +- 0.5 deg"}
        )
        sigmas.append(found.quantities[2].pooled.all.sigma)
    assert sigmas[0] == sigmas[1]


def test_a_rolled_camera_is_taken_off_by_the_angle_in_the_first_frame(tmp_path):
    """Rolled by 2 deg, the picture says 2 deg more; --start-angle says what a level said."""
    made = Made(replace(SCENE, roll=2.0), TILT, CAMERA, TILT.slip + 0.4)
    path, truth = film(tmp_path, made, "rolled"), math.atan(TILT.friction)
    seen, said = (
        calibrate("incline", path, "--json", "--quiet", *more).json["angle_of_repose_rad"]
        for more in ([], ["--start-angle", "8 deg +- 0.1 deg"])
    )
    assert math.degrees(seen["value"] - truth) == pytest.approx(2.0, abs=0.2)
    assert abs(said["value"] - truth) < 3 * said["sigma"]
    assert 0.1 <= math.degrees(said["sigma"]) < 0.15


@pytest.mark.parametrize(
    ("command", "change", "line"),
    [
        ("incline", {"rate": 0.0, "lead": 9.0}, "nothing that tilts is seen"),
        ("incline", {"friction": 0.9}, "the block never slips"),
        ("incline", {"topple": 60.0}, "it rolls or topples"),
        ("slide", {"rate": 0.0, "lead": 9.0}, "nothing that slides is seen"),
        ("slide", {"rate": 0.0, "start": 30.0, "topple": 60.0}, "it rolls or topples"),
    ],
)
def test_what_is_no_test_of_friction_is_refused_in_one_line(tmp_path, command, change, line):
    tilt = replace(TILT, **change)
    path = film(tmp_path, Made(SCENE, tilt, CAMERA, 1.6), "bad")
    more = ["--scale", "1 mm/px"] if command == "slide" else []
    assert_refused(calibrate(command, path, "--quiet", *more), line, "bad.mp4")


def test_a_film_of_a_slide_needs_its_scale(slid):
    assert_refused(calibrate("slide", slid[0][1], "--quiet"), "--scale '0.5 mm/px'")


def test_gamma_t_goes_with_the_rate_that_nothing_checks(slid):
    """1/s: at twice the rate twice the damping, and the terminal velocity, too; it is said."""
    path = slid[0][1]
    own, twice = (
        calibrate("slide", path, "--scale", "1 mm/px", "--fps", rate, "--json", "--quiet").json
        for rate in (CAMERA.rate, 2 * CAMERA.rate)
    )
    assert twice["gamma_t_per_s"]["value"] == pytest.approx(2 * own["gamma_t_per_s"]["value"], 1e-4)
    said = "the rate is that of the file's head"
    assert not any(said in words for words in own["gamma_t_per_s"]["remarks"])
    unsaid = calibrate("slide", path, "--scale", "1 mm/px", "--json", "--quiet").json
    assert any(said in words for words in unsaid["gamma_t_per_s"]["remarks"])
    assert unsaid["films"][0]["time_base"] == {"rests_on": "the file's head", "checked": False}


def test_positions_of_a_table_give_back_what_made_them(tmp_path):
    """The integral of eq. 3.11b, released at 0.2 s: by floats only, from rest and at any speed."""
    t = np.linspace(0, 1.5, 60)
    p, _ = fit_way(t, from_rest(t, 0.43, 3.0, 0.2, 0.01), "rest")
    assert p == pytest.approx([0.43, 3.0, 0.2, 0.01], rel=1e-6)
    p, _ = fit_way(t, from_any(t, 0.43, 3.0, 0.1, 0.01), "any")
    assert p == pytest.approx([0.43, 3.0, 0.1, 0.01], rel=1e-6)
    x = from_rest(t, 0.43, 3.0, 0.2, 0.5) + np.random.default_rng(1).normal(0, 1e-4, 60)
    for way in (1, -1):  # counted upwards it is the same
        table = write(tmp_path / f"x{way}.csv", "time_s;position_m", [t, way * x])
        found = calibrate("slide", table, "--json").json["gamma_t_per_s"]
        assert abs(found["value"] - 3.0) < 3 * found["sigma"] < 0.1


def test_sigma_of_positions_covers_the_truth_in_68_percent():
    """White noise of 0.1 mm: of 60 curves 68 +- 3 x 6 %; bias below sigma/2."""
    rng, t = np.random.default_rng(2), np.linspace(0, 1.5, 50)
    clean = from_rest(t, 0.43, 3.0, 0.2, 0.0)
    fits = [fit_way(t, clean + rng.normal(0, 1e-4, 50), "rest") for _ in range(60)]
    z = np.array([(p[1] - 3.0) / math.sqrt(covariance[1, 1]) for p, covariance in fits])
    assert 0.50 < np.mean(np.abs(z) < 1) < 0.86
    assert abs(z.mean()) < 0.5


@pytest.mark.parametrize(("start", "jerk"), [(0.3, 0.02), (0.05, 0.05)])
def test_the_first_slip_is_found_between_frames(start, jerk):
    """a (t - t0)^2/2 + j (t - t0)^3/6 with 0.05 px of noise; j of 4 deg/s and 1 mm/px is 0.02.

    68 +- 3 x 6 % of 60 are covered, the bias is below sigma/2.
    """
    rng, frames = np.random.default_rng(3), np.arange(60.0)
    z = np.empty(60)
    for k in range(60):
        t0 = rng.uniform(40, 41)
        late = np.maximum(frames - t0, 0)
        way = start * late**2 / 2 + jerk * late**3 / 6 + rng.normal(0, 0.05, 60)
        slip = first_slip(frames, way)
        z[k] = (slip.time - t0) / slip.sigma
    assert 0.50 < np.mean(np.abs(z) < 1) < 0.86
    assert abs(np.mean(z)) < 0.5
