"""The film of a run: every frame, to scale, in what a browser plays."""

import copy
import sys
from unittest.mock import Mock

import cv2
import numpy as np
import pytest
from fake_run import write_fake_run

from granulab.campaign.output.figure import WALL
from granulab.campaign.output.film import FPS, rgb
from silo2d.case.outline import outline_from_polygon
from silo2d.view.film import _Canvas, film_frames, make_film
from silo2d.view.scene import PARTICLE_EDGE, WOOD, read_scene


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """A4, twelve frames."""
    return read_scene(write_fake_run(tmp_path_factory.mktemp("a4"), n_frames=12).path)


def near(image: np.ndarray, colour: str) -> np.ndarray:
    """Which pixels have a colour, but for rounding."""
    wanted = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)])
    return np.abs(image.astype(int) - wanted).max(axis=-1) <= 2


def test_edges_of_small_particles_leave_their_layers_to_be_seen(scene):
    """Full from 6 pixels on; of a particle of 1 pixel a thirty-sixth."""
    whole, small = _Canvas(scene), copy.copy(scene)
    small.__dict__["particle_size"] = 1.0 / whole.scale
    for seen, faint, fill in zip(whole.edges, _Canvas(small).edges, whole.colours, strict=True):
        assert np.array(seen) == pytest.approx(rgb(PARTICLE_EDGE))
        share = (np.array(faint) - fill) / (np.array(seen) - fill)
        assert share == pytest.approx(np.full(3, 1 / 36))


def decoded(path) -> list[np.ndarray]:
    """The frames of a film, red green blue."""
    film, frames = cv2.VideoCapture(str(path)), []
    while (read := film.read())[0]:
        frames.append(read[1][:, :, ::-1])
    assert film.get(cv2.CAP_PROP_FPS) == FPS
    film.release()
    return frames


def test_particles_are_drawn_at_their_positions_in_their_layers_colour(scene):
    """Scale and origin from the drawn walls, 0.3 m apart; every centroid has its layer's tone."""
    image = next(film_frames(scene))
    rows, columns = np.nonzero(near(image, WALL))
    scale = (columns.max() - columns.min() - 3) / 0.3  # the line is 3 pixels wide
    px = (columns.min() + columns.max()) / 2 + scale * scene.trajectory["x"][0]
    py = rows.min() + 1 + scale * (0.5 - scene.trajectory["y"][0])
    layer = scene.trajectory.static["layer"]
    for tone, colour in enumerate(WOOD):
        which = layer % 2 == tone
        x, y = np.rint(px[which]).astype(int), np.rint(py[which]).astype(int)
        assert which.any()
        assert near(image, colour)[y, x].all()


def test_dropped_particles_are_not_drawn(scene):
    """The silo empties: less wood at the end, and none of it once all are dropped."""
    frames = list(film_frames(scene))
    wood = [sum(near(image, colour).sum() for colour in WOOD) for image in frames]
    inside = scene.trajectory["inside"].sum(axis=1)
    assert inside[-1] < inside[0]
    assert wood[-1] < wood[0]


@pytest.mark.parametrize(("encoder", "fourcc"), [("ffmpeg", "h264"), ("OpenCV", "VP90")])
def test_film_holds_every_frame(scene, tmp_path, monkeypatch, capfd, encoder, fourcc):
    """H.264, or VP9 without imageio-ffmpeg. Colours survive within what 4:2:0 takes at edges."""
    if encoder == "OpenCV":
        monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    path = make_film(scene, tmp_path)
    assert path == tmp_path / "film.mp4"
    assert list(tmp_path.iterdir()) == [path]
    drawn, stored = list(film_frames(scene)), decoded(path)
    assert len(stored) == len(scene.time)
    for was, now in zip(drawn, stored, strict=True):
        assert was.shape == now.shape
        assert was.shape[0] % 2 == was.shape[1] % 2 == 0
        assert np.abs(was.astype(int) - now).mean() < 4  # red for blue would give 12
    film = cv2.VideoCapture(str(path))
    assert int(film.get(cv2.CAP_PROP_FOURCC)).to_bytes(4, "little").decode() == fourcc
    assert capfd.readouterr() == ("", "")


def test_film_is_a_gif_where_no_codec_is_found(scene, tmp_path, monkeypatch):
    """Bare installations still get a film."""
    from PIL import Image

    writer = Mock(**{"return_value.isOpened.return_value": False})  # no codec for that
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    monkeypatch.setattr(cv2, "VideoWriter", writer)
    path = make_film(scene, tmp_path)
    assert path == tmp_path / "film.gif"
    with Image.open(path) as film:
        assert film.n_frames == len(scene.time)
        assert film.info["duration"] == 1000 // FPS


def test_wide_silo_fits_the_picture(tmp_path):
    """No picture is wider than a laptop shows, whatever the silo."""
    wide = outline_from_polygon([(0, 0), (3, 0), (3, 0.5), (0, 0.5)], 0.2, 1.0, "wide")
    write_fake_run(tmp_path, silo=wide, n_frames=2, spacing=0.1)
    height, width, _ = next(film_frames(read_scene(tmp_path))).shape
    assert 700 < width < 900
    assert height < width
