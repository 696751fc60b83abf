"""Track tables of other tools: any dialect, several tracks, and what cannot be read."""

import numpy as np
import pytest
from fuzzing import examples
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from made_tracks import made_track

from calibration.files.track_table import read_tracks
from granulab.errors import InputError

READER = settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
ROWS = [(3, 1.25, 10.5), (4, 1.5, 11.75), (6, 1.75, 14.0), (7, 2.0, 17.5)]


def written(tmp_path, text):
    path = tmp_path / "track.csv"
    path.write_text(text, encoding="utf-8")
    return path


def the_track(path):
    (track,) = read_tracks(path)
    return track.seen()


@pytest.mark.parametrize("head", ["frame{0}x{0}y", "Frame{0}X1{0}Y1", "t{0}pos_x{0}pos_y", ""])
@pytest.mark.parametrize(
    ("separator", "comma"),
    [(",", False), (";", False), ("\t", False), (" ", False), ("  ", False), (";", True),
     ("\t", True), (" ", True)],
)  # fmt: skip
def test_any_separator_and_decimal_mark(tmp_path, head, separator, comma):
    lines = [separator.join(f"{value:g}" for value in row) for row in ROWS]
    text = "\n".join([*([head.format(separator)] if head else []), *lines, ""])
    track = the_track(written(tmp_path, text.replace(".", ",") if comma else text))
    assert track.time is None  # whole numbers: frames
    np.testing.assert_array_equal(np.stack([track.frame, track.x, track.y], axis=1), ROWS)


@settings(READER, max_examples=examples(60))
@given(
    values=st.lists(
        st.tuples(*[st.floats(-1e4, 1e4, allow_nan=False).map(lambda v: round(v, 6))] * 2),
        min_size=2, max_size=20,
    ),
    separator=st.sampled_from([",", ";", "\t", " "]),
    comma=st.booleans(),
    quoted=st.booleans(),
)  # fmt: skip
def test_what_was_written_is_read(tmp_path, values, separator, comma, quoted):
    """Numbers in any dialect come back as they were, whatever their sign and size."""
    comma = comma and separator != ","
    quote = '"' if quoted and separator != " " else ""
    lines = [separator.join(f"{quote}{name}{quote}" for name in ("frame", "x", "y"))]
    for k, pair in enumerate(values):
        text = separator.join(f"{quote}{value!r}{quote}" for value in (k, *pair))
        lines.append(text.replace(".", ",") if comma else text)
    track = the_track(written(tmp_path, "\n".join(lines)))
    np.testing.assert_array_equal(np.stack([track.x, track.y], axis=1), values)


@settings(READER, max_examples=examples(40))
@given(st.text(alphabet='0123456789.,;\t -+eE*#xyt\n"fram', max_size=120))
def test_any_text_is_read_or_refused_in_one_line(tmp_path, text):
    path = written(tmp_path, text)
    try:
        tracks = read_tracks(path)
    except InputError:
        with pytest.raises(InputError, match=r"\A[^\n]+\Z"):
            read_tracks(path)
        return
    assert tracks
    assert all(len(track.frame) == len(track.y) == len(track.x) for track in tracks)


def test_units_and_times_of_the_head(tmp_path):
    track = the_track(written(tmp_path, "time [ms],x [mm],y [mm]\n0,1,2\n10,3,4\n20,5,6\n"))
    assert track.rate == pytest.approx(100)
    assert track.y == pytest.approx([0.002, 0.004, 0.006])
    assert track.scale == 1.0
    track = the_track(written(tmp_path, "t,x,y\n0.0,1,2\n0.04,3,4\n0.12,5,6\n0.16,5,6\n"))
    assert track.frame == pytest.approx([0, 1, 3, 4])  # a gap stays a gap
    assert track.rate == pytest.approx(25)
    assert "seconds" in track.remarks[0]
    with pytest.raises(InputError, match="unit is wrong"):
        read_tracks(written(tmp_path, "frame,x [s],y [kg]\n0,1,2\n1,3,4\n"))


@pytest.mark.parametrize("head", ["height [m]", "z_m", "H (m)", "H\u00f6he [m]"])
def test_a_height_is_y_where_there_is_none(tmp_path, head):
    track = the_track(written(tmp_path, f"time [s],{head}\n0,1\n0.01,3\n0.02,5\n"))
    assert track.y.tolist() == [1, 3, 5]
    assert track.scale == 1.0
    both = the_track(written(tmp_path, f"time [s],y [m],{head}\n0,1,9\n0.01,3,9\n0.02,5,9\n"))
    assert both.y.tolist() == [1, 3, 5]


def test_several_tracks_side_by_side_with_short_lines(tmp_path):
    """A second line of words, empty fields, lines that end early."""
    text = "Frame,X1,Y1,X2,Y2\nTracks 1 to 2\n1,1,2,,\n2,1.5,2.5,7,8\n3,,,7.5,8.5\n4,2,3\n"
    first, second = (track.seen() for track in read_tracks(written(tmp_path, text)))
    assert first.frame.tolist() == [1, 2, 4]
    assert second.y.tolist() == [8, 8.5]
    assert (first.name, second.name) == ("1", "2")


def test_several_tracks_one_under_another(tmp_path):
    """One line per frame and particle, columns in another order, a column of no use."""
    text = "y,x,mass,frame,particle\n2,1,9,0,5\n8,7,9,0,6\n3,1,9,1,5\n9,7,9,1,6\n"
    tracks = read_tracks(written(tmp_path, text))
    assert [track.name for track in tracks] == ["5", "6"]
    assert tracks[1].y.tolist() == [8, 9]


def test_a_name_above_the_head(tmp_path):
    track = the_track(written(tmp_path, "mass_A,,\nt,x,y\n0.0,1,2\n0.1,2,3\n"))
    assert track.y.tolist() == [2, 3]


def test_numbers_that_do_not_stand_below_their_names_are_linked_by_position(tmp_path):
    """Left-packed pairs of two objects whose order changes, marks of doubt, a table at the end."""
    lines = ["Frame X1 Y1 Flag1 X2 Y2 Flag2", "Tracks 1 to 2  "]
    for k in range(20):
        ball, spot = f"{100 + k}.5 {10 + 2 * k}.25", f"400.5 300.{k}"
        lines.append(f"{k} {ball} {spot}  " if k % 3 else f"{k} {spot} {ball} * ")
        if k == 10:
            lines[-1] = f"{k} {ball}    "
    text = "\n".join([*lines, "Track Length Frames", "1 46.5 20", " * 3.5 4.5 *"])
    tracks = read_tracks(written(tmp_path, text))
    assert sorted(len(track.frame) for track in tracks) == [19, 20]
    ball = max(tracks, key=lambda track: np.ptp(track.y))
    assert ball.y.tolist() == [10.25 + 2 * k for k in range(20)]
    assert any("left out" in remark for remark in ball.remarks)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "empty"),
        ("hello\nworld\n", "no line of numbers"),
        ("frame,x,w\n1,2,3\n", "no column 'y'"),
        ("1,2,3,4\n2,3,4,5\n", "without names"),
        ("frame,x,y\n1,2,3\n2,oops,4\n3,4,5\n", "line 3: 'oops' is no number"),
        ("t [s],x,y\n1,2,3\n1,2,3\n", "does not go on"),
    ],
)
def test_what_is_no_track_is_refused_in_one_line(tmp_path, text, words):
    with pytest.raises(InputError) as refused:
        read_tracks(written(tmp_path, text))
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_frame_that_stands_twice_is_refused():
    track = made_track([0.7]).track
    with pytest.raises(InputError, match="stands twice"):
        track.chosen(np.array([0, 1, 1, 2])).seen()


def test_no_table_at_all_is_refused(tmp_path):
    (tmp_path / "film.mp4").write_bytes(bytes(range(256)) * 10)
    for path, words in ((tmp_path / "film.mp4", "not a text file"), (tmp_path, "directory"),
                        (tmp_path / "none.csv", "No such file")):  # fmt: skip
        with pytest.raises(InputError, match=words):
            read_tracks(path)
