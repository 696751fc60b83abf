"""The film of a damper: every stored frame, spheres and enclosure where they are."""

from itertools import pairwise

import cv2
import numpy as np
import pytest
from fake_damper_run import write_fake_damper_run

from damper3d.view.film import film_frames, make_film
from damper3d.view.scene import read_scene
from damper3d.view.spheres import cut_open
from granulab.campaign.output.figure import PAPER, WALL
from granulab.campaign.output.film import FPS, played_by, rgb, write_film


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """Three cycles of eight frames, and the frame before the first."""
    return read_scene(write_fake_damper_run(tmp_path_factory.mktemp("film"), cycles=3).path)


@pytest.fixture(scope="module")
def frames(scene) -> list[np.ndarray]:
    return list(film_frames(scene))


def near(image: np.ndarray, colour: str, by: int = 3) -> np.ndarray:
    """Which pixels have a colour, but for so many steps."""
    return np.abs(image.astype(int) - rgb(colour)).max(axis=-1) <= by


def test_film_has_a_picture_for_every_frame(scene, frames):
    """Of one even size that a laptop shows."""
    assert len(frames) == len(scene.tables) == 3 * 8 + 1
    (height, width, _), *others = {image.shape for image in frames}
    assert not others
    assert height % 2 == width % 2 == 0
    assert max(height, width) < 900


def test_a_film_of_the_last_cycle_alone(scene, frames):
    """From its first moment to its last: eight frames and the one before."""
    last = list(film_frames(scene, cycles=1))
    assert len(last) == 9
    assert all((one == other).all() for one, other in zip(last, frames[-9:], strict=True))


def test_a_film_that_not_everything_plays_says_so(frames, tmp_path, monkeypatch):
    monkeypatch.setattr("granulab.campaign.output.film._h264", lambda path, frames: False)
    path = write_film(tmp_path, lambda: iter(frames[:2]))
    assert "H.264 comes with" in played_by(path)
    (tmp_path / "other.mp4").write_bytes(b"....avc1....")
    assert played_by(tmp_path / "other.mp4") == ""


def test_enclosure_and_spheres_move_together_in_the_film(scene, frames):
    """The floor moves by u; every sphere that is drawn stands at its place."""
    rows = {}
    for frame in (0, 2, 6):  # at rest, highest and lowest
        walls = near(frames[frame][72:-120], WALL)
        columns = np.flatnonzero(walls.sum(axis=0) > 100)
        full = np.flatnonzero(walls.sum(axis=1) > 0.8 * (columns[-1] - columns[0]))
        rows[frame] = full[0] + 72.5, full[-1] + 71.5, columns[0] + 1, columns[-1]
    scale = (rows[0][1] - rows[0][0]) / 20e-3  # the enclosure is 20 mm high
    for frame, (top, bottom, left, right) in rows.items():
        moved = scene.trajectory["displacement"][scene.frame_sample[frame]]
        assert rows[0][1] - bottom == pytest.approx(scale * moved, abs=1.5)
        assert bottom - top == pytest.approx(20e-3 * scale, abs=1.5)
        centre, kept = cut_open(scene, frame)
        x = (left + right) / 2 + scale * centre[kept, 0]
        y = rows[0][1] - scale * centre[kept, 1]
        at = np.rint(y).astype(int), np.rint(x).astype(int)
        assert not near(frames[frame], PAPER)[at].any()


def test_words_and_dots_show_the_time(frames):
    """The heading and the velocities change from frame to frame, the title does not."""
    for image, later in pairwise(frames):
        assert (image[:36] == later[:36]).all()
        assert (image[40:66] != later[40:66]).any()
        assert (image[-106:] != later[-106:]).any()


def test_film_decodes_to_every_frame(scene, frames, tmp_path, capfd):
    """Colours survive within what 4:2:0 takes at edges."""
    path = make_film(scene, tmp_path)
    assert path == tmp_path / "film.mp4"
    film, stored = cv2.VideoCapture(str(path)), []
    while (read := film.read())[0]:
        stored.append(read[1][:, :, ::-1])
    assert film.get(cv2.CAP_PROP_FPS) == FPS
    assert len(stored) == len(frames)
    for was, now in zip(frames, stored, strict=True):
        assert np.abs(was.astype(int) - now).mean() < 4
    assert capfd.readouterr() == ("", "")


def test_dissipation_is_another_film(scene, frames):
    """Of the same shape, in other colours."""
    other = next(film_frames(scene, "dissipation"))
    assert other.shape == frames[0].shape
    assert (other != frames[0]).any()
