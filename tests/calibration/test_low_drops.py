"""The paper's own drop test: blocks that fall by centimetres and rotate as they bounce."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from calibrating import calibrate
from made_tracks import made_track
from refusals import assert_refused

from calibration.drop.measure import measure_drop
from calibration.rendered.backdrop import Backdrop
from calibration.rendered.camera import Camera
from calibration.rendered.low_drop import Block, LowDrop, film_low_drop
from calibration.statistics.mixed import mixed
from calibration.statistics.uncertainty import Estimate, of_trials, student
from calibration.tracking.clean import clean_background
from calibration.tracking.film.reader import Region, open_film
from calibration.tracking.follow import follow
from granulab.errors import InputError

G = 9.80665
BLOCK = np.array([[0, 0], [0.012, 0], [0.015, 0.004], [0.015, 0.015], [0, 0.015]])
FALLS = {
    "100 frames/s, e 0.7": (Block(BLOCK, 0.03, angle=0.78), Camera(100.0)),
    "240 frames/s, e 0.4": (Block(BLOCK, 0.019, angle=0.6, restitution=0.5), Camera(240.0)),
    "150 frames/s, much blur": (Block(BLOCK, 0.045, angle=0.85), Camera(150.0, exposure=0.8)),
}
CAMERA = Camera(150.0)


def scene(block, **changes) -> LowDrop:
    return replace(LowDrop(block, scale=6e-4), **changes)


def filmed(path, block, camera, after=0.22, **changes):
    duration = float(block.contact_times[0]) + after
    codec = "mp4v" if path.suffix == ".mp4" else "FFV1"
    return film_low_drop(scene(block, **changes), camera, path, duration=duration, codec=codec)


def test_a_corner_leaves_the_plate_with_its_restitution_and_energy_does_not_grow():
    """v' = -e v of the corner (Newton's law), and no impulse adds energy for e <= 1."""
    block = Block(BLOCK, 0.04, angle=0.4, restitution=0.6, friction=0.3)
    fall, after = block.flights[1:3]
    time = float(block.contact_times[0])
    centre, angle = fall.pose(time)
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    arm = min((turn @ corner for corner in block.corners), key=lambda one: one[1])
    assert centre[1] + arm[1] == pytest.approx(0, abs=1e-12)
    sink = -math.sqrt(2 * G * 0.04)
    assert after.velocity[1] + after.spin * arm[0] == pytest.approx(-0.6 * sink, rel=1e-12)
    energy = after.velocity @ after.velocity + block.gyration * after.spin**2
    assert energy < sink**2


def test_a_square_that_falls_on_a_corner_rebounds_as_a_point_does():
    square = Block(np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * 0.01, angle=math.pi / 4)
    assert square.rebound == pytest.approx(square.restitution, rel=1e-9)
    assert square.gyration == pytest.approx(0.01**2 / 6, rel=1e-12)


@pytest.mark.parametrize("name", FALLS)
def test_one_bounce_from_rest_gives_both_heights_and_restitution(tmp_path, name):
    """Within four sigma, which is some tenths of a pixel: 3 % of the least rise, 7 px."""
    block, camera = FALLS[name]
    shown = scene(block)
    drop = measure_drop(filmed(tmp_path / "drop.avi", block, camera))
    first = drop.first
    assert first.held
    for one, truth in (
        (first.restitution, block.rebound),
        (first.fall, block.fall / shown.scale),
        (first.rise, block.fall * block.rebound**2 / shown.scale),
    ):
        assert abs(one.value - truth) < 4 * one.sigma
        assert one.sigma < 0.03 * truth
    assert drop.restitution == first.restitution  # a block's other bounces are other experiments
    spin = -block.flights[2].spin  # angles count clockwise in a picture
    assert first.rotation.after.value * camera.rate == pytest.approx(spin, rel=0.1, abs=0.5)
    h0 = drop.heights()[0]
    assert abs(h0.value - block.fall) < 4 * h0.sigma


def test_the_background_is_found_behind_what_moves_by_half_its_size(tmp_path):
    """What is never uncovered is as the wall is beside it: like that, and not like the block."""
    block = Block(BLOCK, 0.006, angle=0.78, restitution=0.3)
    shown = scene(block, grain=0.0)
    film = open_film(filmed(tmp_path / "film.mp4", block, CAMERA))
    found = clean_background(film, Region(0, 0, film.width, film.height))
    width, height = shown.size
    wall = CAMERA.picture(
        lambda _: Backdrop().paint(width, height, height - shown.below, 0.0, (0.0, 0.0)), 0.0,
        np.random.default_rng(1),
    )  # fmt: skip
    x, y, _ = shown.place(0.0)
    about = np.s_[int(y) - 5 : int(y) + 15, int(x) - 12 : int(x) + 12]
    wood = 255 * np.array(shown.colour)
    of_wall = np.linalg.norm(found[about] - wall[about].astype(float), axis=2)
    assert np.mean(of_wall > np.linalg.norm(found[about] - wood, axis=2)) < 0.1
    track = follow(film, overlapping=True)[0]
    truth = np.array([shown.place(k / CAMERA.rate)[1] for k in track.frame])
    assert np.median(np.abs(track.y - truth)) < 0.15


def test_one_bounce_of_a_thing_that_was_thrown_is_refused_unless_it_is_asked_for():
    """Nothing then checks the bounce: neither a second one, nor rest before the fall.

    Nothing bounds drag but the shape of two flights of 0.01 px of noise: to a thousandth.
    """
    whole = made_track([0.6], noise=0.01).track
    track = whole.chosen(np.flatnonzero(whole.frame > 25))
    with pytest.raises(InputError, match="--one-bounce"):
        measure_drop(track)
    found = measure_drop(track, one_bounce=True)
    assert not found.first.held
    assert found.restitution.sigma < 1e-3
    assert found.restitution.value == pytest.approx(0.6, abs=found.restitution.sigma)


def test_a_folder_of_films_is_pooled_by_particle_and_height(tmp_path):
    """Four films of two particles: the mean, and the scatter of trials within a height."""
    truth = {}
    for particle, restitution in (("A", 0.8), ("B", 0.6)):
        for height in (20, 40):
            block = Block(BLOCK, height * 1e-3, angle=0.78, restitution=restitution)
            path = tmp_path / "drops" / particle / f"{height}mm" / "1.mp4"
            path.parent.mkdir(parents=True)
            filmed(path, block, CAMERA)
            truth[f"{particle}, {height}mm"] = block.rebound
    (tmp_path / "drops" / "B" / "notes.csv").write_text("nothing,here\n", encoding="utf-8")
    into = tmp_path / "wood.toml"
    run = calibrate("drop", tmp_path / "drops", "--into", into, "--pair", "wood-plate", "--json")
    found = json.loads(run.stdout) if not isinstance(run.json, dict) else run.json
    for name, one in found["restitution"]["groups"].items():
        assert one["value"] == pytest.approx(truth[name], abs=0.01)
    assert found["restitution"]["value"] == pytest.approx(np.mean(list(truth.values())), abs=0.01)
    assert found["levels"]["particle"] > 0.05
    assert [one["from_rest"] for one in found["trials"]] == [True] * 4
    assert "notes.csv" in found["films_left_out"][0]
    assert "trials = 4" in into.read_text(encoding="utf-8")


def test_a_folder_without_a_drop_is_refused(tmp_path):
    (tmp_path / "films").mkdir()
    (tmp_path / "films" / "a.mp4").write_bytes(b"nothing")
    assert_refused(
        calibrate("drop", tmp_path / "films"), "none of 1 films can be measured", "a.mp4"
    )


def test_the_mixed_model_of_balanced_trials_is_the_analysis_of_variance():
    """sigma of the mean is that of the particles' means, one degree of freedom less than those."""
    random = np.random.default_rng(4)
    cells, particle_of, means = {}, {}, []
    for particle, base in (("A", 0.7), ("B", 0.45), ("C", 0.5)):
        ones = []
        for height in range(4):
            trials = base + random.normal(0, 0.02) + random.normal(0, 0.03, 10)
            cells[f"{particle}{height}"] = of_trials(trials.tolist())
            particle_of[f"{particle}{height}"] = particle
            ones.append(trials.mean())
        means.append(np.mean(ones))
    found = mixed(cells, particle_of)
    assert found.mean.value == pytest.approx(np.mean(means), rel=1e-9)
    assert found.freedom == pytest.approx(2, rel=1e-2)
    wanted = student(2) * np.std(means, ddof=1) / math.sqrt(3)
    assert found.mean.sigma == pytest.approx(wanted, rel=0.02)
    within = math.sqrt(np.mean([one.scatter**2 for one in cells.values()]))
    assert found.trial == pytest.approx(within, rel=1e-9)


def test_a_part_that_scatters_nothing_is_none():
    cells = {name: Estimate(0.5, 0.01, 10, 0.03) for name in ("A1", "A2", "B1", "B2")}
    found = mixed(cells, {name: name[0] for name in cells})
    assert (found.height, found.particle) == (0.0, 0.0)
    assert found.mean.sigma > 0
