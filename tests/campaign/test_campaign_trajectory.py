"""The trajectory store: what was flushed can be read, whatever happened since."""

import random
import resource
import signal
import subprocess
import sys
import time
import tracemalloc
from pathlib import Path

import h5py
import numpy as np
import pytest
from resealed import resealed

from granulab.campaign.runs.folder import SCHEMA
from granulab.campaign.runs.trajectory import (
    TrajectoryWriter,
    read_tables,
    read_trajectory,
    stored_tables,
)
from granulab.errors import FolderError

_HERE = Path(__file__).parent
STATIC = {"radius": np.array([1.0, 2.0]), "n_corners": np.array([3, 4])}
ATTRIBUTES = {"unit": "SI", "frame_step": 0.01}


def frame(k: int) -> dict:
    """Frame number k: a time, positions of two bodies, and who is inside."""
    x = np.array([[k, 0.5 * k], [-0.0, np.nan]])
    return {"time": 0.01 * k, "x": x, "inside": np.array([k % 2 == 0, True])}


def touches(k: int) -> dict:
    """Table of frame k: of every third frame, k % 4 rows long (none at all for frame 12)."""
    rows = np.arange(2.0 * (k % 4)).reshape(-1, 2).astype(np.float32) + k
    return {"contacts": {"force": rows, "body": np.full(k % 4, k)}} if k % 3 == 0 else {}


def write(writer: TrajectoryWriter, frames: range) -> int:
    for k in frames:
        writer.append(frame(k), touches(k))
    return writer.flush()


def holds(folder: Path, n_frames: int) -> None:
    """The trajectory is the frames 0 .. n_frames - 1, to the last bit."""
    trajectory = read_trajectory(folder)
    assert set(trajectory) == {"time", "x", "inside"}
    for key, array in trajectory.items():
        expected = np.stack([frame(k)[key] for k in range(n_frames)])
        assert array.dtype == expected.dtype
        assert array.shape == expected.shape
        assert array.tobytes() == expected.tobytes()
    tables = read_tables(folder, "contacts")
    np.testing.assert_array_equal(tables.frame, np.arange(0, n_frames, 3))
    for k, number in enumerate(tables.frame):
        for column, rows in touches(int(number))["contacts"].items():
            assert tables.at(k)[column].dtype == rows.dtype
            np.testing.assert_array_equal(tables.at(k)[column], rows)


def test_finished_trajectory_is_one_compressed_file(tmp_path):
    """Layout that others read: frame axis first, gzip and shuffle, static arrays aside."""
    writer = TrajectoryWriter(tmp_path)
    assert write(writer, range(0, 4)) == 1
    assert writer.flush() == 1  # nothing new, no part
    assert write(writer, range(4, 7)) == 2
    writer.append(frame(7), touches(7))  # finish() flushes
    assert writer.finish(STATIC, ATTRIBUTES) == tmp_path / "trajectory.h5"
    assert [path.name for path in tmp_path.iterdir()] == ["trajectory.h5"]
    holds(tmp_path, 8)
    trajectory = read_trajectory(tmp_path)
    assert trajectory.attributes == ATTRIBUTES
    assert trajectory.static.keys() == STATIC.keys()
    np.testing.assert_array_equal(trajectory.static["radius"], STATIC["radius"])
    with h5py.File(tmp_path / "trajectory.h5") as file:
        x = file["frames/x"]
        assert (x.shape, x.compression, x.shuffle) == ((8, 2, 2), "gzip", True)
        assert x.chunks[1:] == (2, 2)
        assert file.attrs["schema"] == SCHEMA


def test_chunks_hold_whole_frames_of_half_a_mebibyte(tmp_path):
    """A film reads frame after frame: 2^19 bytes are 13 frames of 5000 numbers."""
    writer = TrajectoryWriter(tmp_path)
    for _ in range(30):
        writer.append({"x": np.zeros(5000), "nothing": np.zeros((0, 2))})
    writer.finish({}, {})
    with h5py.File(tmp_path / "trajectory.h5") as file:
        assert file["frames/x"].chunks == (2**19 // 40000, 5000)
        assert file["frames/nothing"].shape == (30, 0, 2)


def test_frames_are_copied(tmp_path):
    """A simulation moves its arrays in place between append and flush."""
    writer = TrajectoryWriter(tmp_path)
    x = np.zeros(2)
    writer.append({"x": x})
    x += 1.0
    writer.append({"x": x})
    writer.flush()
    np.testing.assert_array_equal(read_trajectory(tmp_path)["x"], [[0, 0], [1, 1]])


def test_unfinished_run_can_be_drawn(tmp_path):
    """Static arrays are there from the start, frames as of the last flush."""
    writer = TrajectoryWriter(tmp_path)
    writer.write_static(STATIC, ATTRIBUTES)
    assert len(read_trajectory(tmp_path)) == 0
    write(writer, range(0, 3))
    writer.append(frame(3), touches(3))
    holds(tmp_path, 3)
    trajectory = read_trajectory(tmp_path)
    assert trajectory.attributes == ATTRIBUTES
    np.testing.assert_array_equal(trajectory.static["n_corners"], STATIC["n_corners"])


def test_resume_drops_what_the_checkpoint_does_not_know(tmp_path):
    """Parts after the checkpoint are computed again; a rest of a killed write is no part."""
    writer = TrajectoryWriter(tmp_path)
    for k in range(5):
        write(writer, range(2 * k, 2 * k + 2))
    (tmp_path / "parts" / ".00005.h5.0a1b2c3d.tmp").write_bytes(b"\x89HDF\r\n")
    holds(tmp_path, 10)
    writer = TrajectoryWriter(tmp_path, parts=3)
    holds(tmp_path, 6)
    assert write(writer, range(6, 9)) == 4
    writer.finish(STATIC, ATTRIBUTES)
    assert not (tmp_path / "parts").exists()
    holds(tmp_path, 9)


def test_resume_after_finish_takes_the_file_apart(tmp_path):
    """Cut off between finish() and the summary, the run goes on from its checkpoint."""
    writer = TrajectoryWriter(tmp_path)
    for k in range(4):
        write(writer, range(3 * k, 3 * k + 3))
    writer.finish(STATIC, ATTRIBUTES)
    writer = TrajectoryWriter(tmp_path, parts=2)
    holds(tmp_path, 6)
    assert read_trajectory(tmp_path).attributes == ATTRIBUTES
    assert write(writer, range(6, 12)) == 3
    writer.finish(STATIC, ATTRIBUTES)
    holds(tmp_path, 12)


def test_new_start_forgets_the_old_frames(tmp_path):
    writer = TrajectoryWriter(tmp_path)
    write(writer, range(0, 3))
    writer.finish(STATIC, ATTRIBUTES)
    writer = TrajectoryWriter(tmp_path)
    assert len(read_trajectory(tmp_path)) == 0
    write(writer, range(0, 2))
    holds(tmp_path, 2)


def test_run_without_frames_still_has_its_shapes(tmp_path):
    TrajectoryWriter(tmp_path).finish(STATIC, ATTRIBUTES)
    trajectory = read_trajectory(tmp_path)
    assert len(trajectory) == 0
    assert trajectory.static.keys() == STATIC.keys()


def test_tables_may_be_rare_and_empty(tmp_path):
    """A part may have none, a table no rows, and a run none at all, which one line says."""
    writer = TrajectoryWriter(tmp_path)
    for k in range(14):
        write(writer, range(k, k + 1))
    holds(tmp_path, 14)
    writer = TrajectoryWriter(tmp_path, parts=11)
    write(writer, range(11, 20))
    writer.finish(STATIC, ATTRIBUTES)
    holds(tmp_path, 20)
    assert len(read_tables(tmp_path, "contacts").at(-1)["body"]) == 18 % 4
    refused(lambda: read_tables(tmp_path, "walls"), str(tmp_path), "no walls", "--again")


def refused(call, *words: str) -> None:
    with pytest.raises(FolderError) as error:
        call()
    assert "\n" not in str(error.value)
    for word in words:
        assert word in str(error.value)


def test_frames_of_another_kind_are_refused(tmp_path):
    """Also after a resume, where other sources may write other frames."""
    writer = TrajectoryWriter(tmp_path)
    write(writer, range(0, 2))
    refused(lambda: writer.append({"time": 0.0}), "float64[]", "float64[2, 2]", "--again")
    resumed = TrajectoryWriter(tmp_path, parts=1)
    refused(lambda: resumed.append({**frame(2), "omega": 0.0}), "omega", "--again")
    resumed.append(frame(2))
    other = {"contacts": {**touches(3)["contacts"], "overlap": np.zeros(3)}}
    refused(lambda: resumed.append(frame(3), other), "contacts.overlap", "--again")


def test_missing_parts_are_refused(tmp_path):
    writer = TrajectoryWriter(tmp_path)
    for k in range(3):
        write(writer, range(k, k + 1))
    refused(lambda: TrajectoryWriter(tmp_path, parts=4), "3 parts", "knows 4", "--again")
    (tmp_path / "parts" / "00001.h5").unlink()
    refused(lambda: read_trajectory(tmp_path), "00001.h5", "missing")


def test_damaged_foreign_and_absent_files_are_refused(tmp_path):
    refused(lambda: read_trajectory(tmp_path), str(tmp_path), "no trajectory")
    writer = TrajectoryWriter(tmp_path)
    write(writer, range(0, 2))
    path = writer.finish(STATIC, ATTRIBUTES)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    refused(lambda: read_trajectory(tmp_path), "trajectory.h5", "damaged")
    path.write_bytes(whole)
    with resealed(path) as file:
        file.attrs["schema"] = SCHEMA + 1
    refused(lambda: read_trajectory(tmp_path), "trajectory.h5", f"schema {SCHEMA + 1}")
    for rows in (1.0, np.zeros(1)):  # where the others have two
        with resealed(path) as file:
            file.attrs["schema"] = SCHEMA
            (name, *_) = file["frames"]
            del file["frames"][name]
            file["frames"][name] = rows
        refused(lambda: read_trajectory(tmp_path), "trajectory.h5", "damaged")


def test_full_disk_loses_no_frame(tmp_path):
    """A flush that fails keeps its frames, and HDF5 does not take the process down."""
    writer = TrajectoryWriter(tmp_path)
    write(writer, range(0, 2))
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (500, limits[1]))
    try:
        refused(lambda: write(writer, range(2, 4)), "00001.h5", "make room")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    holds(tmp_path, 2)
    writer.flush()
    holds(tmp_path, 4)


def arrays_in(path: Path) -> dict[str, np.ndarray]:
    """What moves in a file of a trajectory, by name, as other programs read it."""
    found: dict[str, np.ndarray] = {}

    def collect(name: str, item: h5py.Dataset | h5py.Group) -> None:
        if isinstance(item, h5py.Dataset) and not name.startswith("static/"):
            found[name] = item[()]

    with h5py.File(path) as file:
        file.visititems(collect)
    return found


def many_frames(folder: Path, n_parts: int) -> TrajectoryWriter:
    """Parts of ten frames of 2000 numbers, and a table each that is longer in every part."""
    writer, random_numbers = TrajectoryWriter(folder), np.random.default_rng(1)
    for k in range(n_parts):
        for _ in range(10):
            writer.append({"x": random_numbers.standard_normal(2000), "time": 0.1 * k})
        forces = {"contacts": {"force": random_numbers.standard_normal((50 * k, 2))}}
        writer.append({"x": np.zeros(2000), "time": 0.1 * k}, forces)
        writer.flush()
    return writer


def test_the_merged_file_holds_what_the_parts_held(tmp_path):
    """Every array end to end, to the bit, over several chunks of half a mebibyte."""
    writer = many_frames(tmp_path, 12)
    parts = [arrays_in(tmp_path / "parts" / f"{k:05d}.h5") for k in range(12)]
    merged = arrays_in(writer.finish(STATIC, ATTRIBUTES))
    assert merged.keys() == parts[0].keys()
    for name, array in merged.items():
        expected = np.concatenate([part[name] for part in parts if name in part])
        assert (array.dtype, array.shape) == (expected.dtype, expected.shape)
        assert array.tobytes() == expected.tobytes()


def peak_of_merging(folder: Path, n_parts: int) -> int:
    writer = many_frames(folder, n_parts)
    tracemalloc.start()
    try:
        writer.finish(STATIC, ATTRIBUTES)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_merging_takes_no_more_memory_for_more_parts(tmp_path):
    """An array of a part is in memory at a time, with a frame's numbers and the hash's 2^18 bytes.

    Five times as many parts may take one such array more, as the last may not be freed yet.
    """
    an_array = 11 * 2000 * 8
    few, many = (peak_of_merging(tmp_path / str(n), n) for n in (4, 20))
    assert few < 2 * an_array + 2**18 + 2**16
    assert many < few + an_array  # all of them: 20


def test_a_disk_that_fills_up_while_parts_are_merged_loses_no_frame(tmp_path):
    """Wherever in the file it happens; HDF5 does not take the process down."""
    writer = many_frames(tmp_path, 8)
    size = sum(path.stat().st_size for path in (tmp_path / "parts").iterdir())
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    for limit in (100, 513, 3000, size // 8, size // 2):
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limits[1]))
        try:
            refused(lambda: writer.finish(STATIC, ATTRIBUTES), "cannot be written", "make room")
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        assert not list(tmp_path.rglob(".*.tmp"))
    writer.finish(STATIC, ATTRIBUTES)
    assert len(read_trajectory(tmp_path)["time"]) == 8 * 11


def test_what_is_not_chosen_is_not_read(tmp_path):
    """Some rows of some arrays, of each file; columns of tables likewise."""
    write(writer := TrajectoryWriter(tmp_path), range(0, 4))
    write(writer, range(4, 7))

    def last_of_x(name: str, stored: h5py.Dataset) -> slice | None:
        return slice(-1, None) if name == "x" else None

    for merged, rows in ((False, [frame(3)["x"], frame(6)["x"]]), (True, [frame(6)["x"]])):
        if merged:
            writer.finish(STATIC, ATTRIBUTES)
        chosen = read_trajectory(tmp_path, last_of_x)
        assert set(chosen) == {"x"}
        np.testing.assert_array_equal(chosen["x"], np.stack(rows))
        tables = stored_tables(tmp_path, {"contacts": ["body"]})["contacts"]
        assert set(tables.columns) == {"body"}
        assert tables.at(-1)["body"].tolist() == [6, 6]
        assert stored_tables(tmp_path, {"walls": ["force"]}) == {}


_FLUSHING = """
writer = TrajectoryWriter(folder, parts)
k = 3 * parts
while True:
    for _ in range(3):
        writer.append(frame(k), touches(k))
        k += 1
    print(writer.flush(), flush=True)
"""
_FINISHING = """
while True:
    writer = TrajectoryWriter(folder, parts)
    writer.finish(STATIC, ATTRIBUTES)
    print(parts, flush=True)
"""


def kill_while(folder: Path, loop: str, parts: int, rounds: int, delay: float) -> int:
    """SIGKILL a process in its loop after some rounds and a little; the parts it promised."""
    script = (
        "import sys\nfrom pathlib import Path\n"
        f"sys.path[:0] = [{str(_HERE)!r}, {str(_HERE.parent / 'helpers')!r}]\n"
        "from test_campaign_trajectory import *\n"
        f"folder, parts = Path({str(folder)!r}), {parts}\n{loop}"
    )
    with subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, cwd=Path(__file__).parents[2]
    ) as process:
        for _ in range(rounds):
            promised = int(process.stdout.readline())
        time.sleep(delay)
        process.send_signal(signal.SIGKILL)
        later = process.stdout.read().split()
    assert process.returncode == -signal.SIGKILL
    return int(later[-1]) if later else promised


def test_kill_while_flushing_loses_no_flushed_frame(tmp_path):
    """kill -9 at any moment: what flush() promised is there, and a resume goes on from it."""
    moments = random.Random(1)
    parts = 0
    for _ in range(4):
        parts = kill_while(tmp_path, _FLUSHING, parts, 5, moments.uniform(0.0, 0.01))
        found = len(read_trajectory(tmp_path)["time"])
        assert found in (3 * parts, 3 * parts + 3)  # one more may stand, not yet promised
        holds(tmp_path, found)
    writer = TrajectoryWriter(tmp_path, parts)
    writer.finish(STATIC, ATTRIBUTES)
    holds(tmp_path, 3 * parts)


def test_kill_while_finishing_keeps_every_frame(tmp_path):
    """kill -9 between merging, removing parts and taking the file apart again."""
    moments = random.Random(2)
    writer = TrajectoryWriter(tmp_path)
    for k in range(8):
        parts = write(writer, range(3 * k, 3 * k + 3))
    for _ in range(4):
        kill_while(tmp_path, _FINISHING, parts, 2, moments.uniform(0.0, 0.05))
        holds(tmp_path, 24)
