"""The annotated film and the diagnostic figure: marks stand where objects are, files play."""

import json
from unittest import mock

import calibrating
import cv2
import numpy as np
import pytest

from calibration import measure_drop
from calibration.drop.view.annotate import Marks, annotate, scale_bar, with_sigma
from calibration.tracking.film.reader import Frame, open_film
from granulab.campaign.output.figure import ORANGE, VERMILION
from granulab.campaign.output.film import rgb
from granulab.contact.files.datafile import data_file

CLIP = data_file("media", "drop")


@pytest.fixture(scope="module")
def drop():
    return measure_drop(CLIP)


@pytest.fixture(scope="module")
def sheets(tmp_path_factory):
    """Result of the command, its folder, and the stills that its sheet shows."""
    folder, stills = tmp_path_factory.mktemp("marked") / "sheets", []

    def noted(*arguments, **options):
        film, found = annotate(*arguments, **options)
        stills.extend(found)
        return film, found

    with mock.patch("calibration.drop.view.annotate.annotate", noted):
        done = calibrating.calibrate("drop", CLIP, "--json", "--quiet", "-o", folder)
    assert (done.code, done.err) == (0, "")
    return json.loads(done.out), folder, stills


def near(image, colour):
    """Rows and columns that have a colour, but for antialiasing."""
    return np.nonzero(np.abs(image.astype(int) - rgb(colour)).max(axis=-1) <= 8)


def test_the_circle_is_around_the_object_and_the_line_at_the_plate(drop):
    """On black, at twice the size: the circle's middle is the track's place, to a pixel; the line
    is at the plate's truth, 0.9 of 320 px, which the circle of equal area meets within 2 px."""
    marks = Marks(drop, 160, 320, 320, 640)
    assert marks.zoom == 2
    track = drop.bounces.track
    row = len(track.frame) // 2
    black = np.zeros((320, 160, 3), dtype=np.uint8)
    image = marks.draw(Frame(int(track.frame[row]), None, black))
    assert image.shape == (640, 320, 3)
    rows, columns = near(image, VERMILION)
    assert (columns.min() + columns.max()) / 4 == pytest.approx(track.x[row], abs=1)
    assert (rows.min() + rows.max()) / 4 == pytest.approx(track.y[row], abs=1)
    assert np.ptp(columns) / 4 == pytest.approx(track.radius[row] + 2, abs=2)
    line = image[:, -1].sum(axis=-1, dtype=float)  # nothing else reaches the picture's edge
    assert line @ np.arange(640) / line.sum() / 2 == pytest.approx(0.9 * 320, abs=2)


def test_contacts_appear_when_they_have_happened(drop):
    marks = Marks(drop, 160, 320, 320, 640)
    first = marks.contact_frames[0]
    black = np.zeros((320, 160, 3), dtype=np.uint8)
    before, after = (
        len(near(marks.draw(Frame(int(first) + k, None, black)), ORANGE)[0]) for k in (0, 1)
    )
    assert after > before


def test_stills_are_of_release_first_contact_apex_and_last_contact(drop, sheets):
    found = sheets[2]
    contacts = [drop.frame(t) for t in drop.bounces.contacts[:, 0]]
    numbers = [one.number for one in found]
    assert len(numbers) == 4
    assert numbers[1] == round(contacts[0])
    assert contacts[0] < numbers[2] < contacts[1]
    assert numbers[3] == round(contacts[-1])
    assert (found[0].width, found[0].height) == (160, 320)


def test_out_writes_a_diagnostic_figure_and_a_film_with_every_frame(sheets):
    result, folder, _ = sheets
    sheet, film = folder / "drop-drop.png", folder / "drop-drop.mp4"
    assert (result["sheet"], result["annotated_film"]) == (str(sheet), str(film))
    assert cv2.imread(str(sheet)).shape[1] == 1760
    pictures = [frame.picture for frame in open_film(film).frames()]
    assert len(pictures) == len(list(open_film(CLIP).frames()))
    height, width, _ = pictures[0].shape
    assert height % 2 == width % 2 == 0
    assert 600 < height <= 720


@pytest.mark.parametrize(
    ("longest", "expected"),
    [(0.19, (0.1, "10 cm")), (1.0, (1.0, "1 m")), (9.9e-3, (5e-3, "5 mm"))],
)
def test_scale_bars_are_round(longest, expected):
    length, words = scale_bar(longest)
    assert length == pytest.approx(expected[0])
    assert words == expected[1]


def test_values_are_written_to_the_first_digit_of_sigma():
    assert with_sigma(0.75321, 0.004) == "0.753 ± 0.004"
    assert with_sigma(0.75321, 0.00001) == "0.7532 ± 0.0001"
    assert with_sigma(0.75321, 0.2) == "0.75 ± 0.20"
    assert with_sigma(0.75321, None) == "0.75"
