"""Checkpoints: every bit comes back, and nothing damaged is believed."""

import errno
import os
from contextlib import contextmanager

import h5py
import numpy as np
import pytest
from fuzzing import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from granulab.campaign.runs import checkpoint, h5file, seal
from granulab.campaign.runs.checkpoint import (
    checkpoints,
    go_back,
    keep_checkpoint,
    load_checkpoint,
    save_checkpoint,
)
from granulab.campaign.runs.folder import SCHEMA, RunFolder
from granulab.campaign.runs.protocol import loaded, restored
from granulab.campaign.runs.trajectory import TrajectoryWriter
from granulab.errors import DamagedError, FolderError

_ANY_BITS = hnp.arrays(
    np.uint64, hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4)
).map(lambda bits: bits.view(np.float64))
_OTHER = hnp.arrays(
    st.sampled_from([np.int64, np.int32, np.uint8, np.bool_, np.float32]),
    hnp.array_shapes(min_dims=0, max_dims=2, min_side=0, max_side=4),
)
_NAMES = st.text("abcxyz_", min_size=1, max_size=6)
_META = st.dictionaries(
    st.text(max_size=5), st.integers() | st.floats(allow_nan=False) | st.text(max_size=5)
)


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("checkpoint") / "checkpoint.h5"


@settings(deadline=None, max_examples=examples(30))
@given(arrays=st.dictionaries(_NAMES, _ANY_BITS | _OTHER, max_size=4), meta=_META)
def test_every_bit_comes_back(path, arrays, meta):
    """A resumed run has the same bits only if NaN payloads, -0.0 and shapes survive."""
    save_checkpoint(path, arrays, meta)
    again, meta_again = load_checkpoint(path)
    assert meta_again == meta
    assert again.keys() == arrays.keys()
    for name, array in arrays.items():
        assert again[name].dtype == array.dtype
        assert again[name].shape == array.shape
        assert again[name].tobytes() == array.tobytes()


def test_grouped_names_and_structured_arrays_come_back(tmp_path):
    """Names may be paths in the file; a contact list may be one array of records."""
    path = tmp_path / "checkpoint.h5"
    records = np.array([(1, 2, -0.0)], dtype=[("i", np.int32), ("j", np.int32), ("slip", float)])
    arrays = {"grains/x": np.eye(2), "grains/v": np.zeros((0, 2)), "contacts": records}
    save_checkpoint(path, arrays, {"time": np.float64(0.1), "parts": np.int64(7)})
    again, meta = load_checkpoint(path)
    assert meta == {"time": 0.1, "parts": 7}
    assert again.keys() == arrays.keys()
    assert again["contacts"].dtype == records.dtype
    assert again["contacts"].tobytes() == records.tobytes()


def test_other_tools_can_open_it(tmp_path):
    """Behind its seal the file is plain HDF5."""
    path = tmp_path / "checkpoint.h5"
    save_checkpoint(path, {"x": np.arange(3.0)}, {})
    with h5py.File(path) as file:
        np.testing.assert_array_equal(file["arrays/x"][()], [0.0, 1.0, 2.0])


@pytest.fixture
def sealed(tmp_path):
    path = tmp_path / "checkpoint.h5"
    save_checkpoint(path, {"x": np.arange(50.0)}, {"time": 0.25})
    return path


def refused(path, *words):
    with pytest.raises(FolderError) as error:
        load_checkpoint(path)
    text = str(error.value)
    assert "\n" not in text
    for word in (str(path), "delete the file", "--again", *words):
        assert word in text


@pytest.mark.parametrize("kept", [0, 10, 100, 511, 512, 600, -1])
def test_truncated_checkpoint_is_refused(sealed, kept):
    sealed.write_bytes(sealed.read_bytes()[:kept])
    refused(sealed, "damaged")


@settings(deadline=None, max_examples=examples(30))
@given(place=st.integers(0, 10**6), bit=st.integers(0, 7))
def test_one_flipped_bit_is_noticed(path, place, bit):
    """SHA-256 covers all behind the seal; the padding of the seal (96 to 511) holds nothing."""
    save_checkpoint(path, {"x": np.arange(50.0)}, {"time": 0.25})
    data = bytearray(path.read_bytes())
    data[512 + place % (len(data) - 512)] ^= 1 << bit
    path.write_bytes(data)
    refused(path, "damaged")


def test_unknown_schema_is_refused(sealed):
    data = sealed.read_bytes()
    new = data.replace(b"schema %d" % SCHEMA, b"schema %d" % (SCHEMA + 1), 1)
    assert new != data
    sealed.write_bytes(new)
    refused(sealed, f"schema {SCHEMA + 1}", f"reads {SCHEMA}")


def test_missing_and_foreign_files_are_refused(tmp_path):
    refused(tmp_path / "checkpoint.h5", "No such file")
    foreign = tmp_path / "trajectory.h5"
    with h5py.File(foreign, "w") as file:
        file["x"] = 1.0
    refused(foreign, "not a checkpoint")


def test_checkpoint_that_cannot_be_written_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(FolderError, match=r"Not a directory.*--out"):
        save_checkpoint(tmp_path / "file" / "checkpoint.h5", {}, {})


PASSING = [OSError(code, os.strerror(code)) for code in (errno.EMFILE, errno.EIO, errno.ESTALE)]
PASSING.append(MemoryError())


def unread(monkeypatch, names, error):
    """Have files of some names be such as the system does not give now."""

    def open_kept(path):
        if path.name in names:
            raise error
        return seal.open_kept(path)

    monkeypatch.setattr(h5file, "open_kept", open_kept)


@pytest.fixture
def begun(tmp_path):
    """A run with three parts, and the checkpoints that it keeps of them."""
    run, writer = RunFolder(tmp_path), TrajectoryWriter(tmp_path)
    for k in range(3):
        writer.append({"x": np.arange(3.0)})
        keep_checkpoint(run, writer.flush(), {"x": np.arange(3.0)}, {"parts": k + 1})
    return run


@pytest.mark.parametrize("error", PASSING, ids=lambda e: str(getattr(e, "errno", "memory")))
@pytest.mark.parametrize("file", ["checkpoint.h5", "00000.h5"])
def test_a_read_that_fails_for_now_costs_no_checkpoint(begun, monkeypatch, error, file):
    before = checkpoints(begun)
    assert len(before) > 1
    with monkeypatch.context() as patch:
        unread(patch, [file, *(path.name for path in before)], error)
        with pytest.raises(FolderError, match=r"cannot be read now \(.*\); try again") as refused:
            restored(begun, lambda arrays: None, dict, "its opening", pytest.fail)
    assert not isinstance(refused.value, DamagedError)
    assert checkpoints(begun) == before
    found = restored(begun, lambda arrays: None, dict, "its opening", pytest.fail)
    assert found == {"parts": 3}


@pytest.mark.parametrize("harm", ["damaged", "missing"])
def test_a_run_goes_on_from_before_the_damage_to_a_trajectory_beside_its_own(begun, harm):
    """Such as that of a second damper on the host: the checkpoint goes with both."""
    other = begun.path / "damper-2"
    writer = TrajectoryWriter(other)
    for _ in range(3):
        writer.append({"x": np.arange(3.0)})
        writer.flush()
    part, said = other / "parts" / "00002.h5", []
    part.unlink() if harm == "missing" else part.write_bytes(part.read_bytes()[:-1])
    found = restored(begun, lambda arrays: None, dict, "its opening", said.append, beside=[other])
    assert found == {"parts": 2}
    assert f"{part}: {harm}" in said[0]
    assert "computes 1 of its 3 parts again" in said[0]


def test_checkpoints_go_where_their_seals_are_known_to_be_wrong(begun):
    for path in checkpoints(begun):
        path.write_bytes(path.read_bytes()[:-1])
    said = []
    assert restored(begun, lambda arrays: None, dict, "its opening", said.append) is None
    assert not checkpoints(begun)
    assert "damaged" in said[0]


def test_a_packing_that_cannot_be_read_now_is_not_called_damaged(tmp_path, monkeypatch):
    save_checkpoint(tmp_path / "packing.h5", {}, {})
    unread(monkeypatch, ["packing.h5"], OSError(errno.EMFILE, os.strerror(errno.EMFILE)))
    with pytest.raises(FolderError, match="cannot be read now"):
        loaded(tmp_path, lambda arrays, meta: meta, "it is filled again")


def test_going_back_writes_the_whole_checkpoint_through_short_writes(begun, monkeypatch):
    """A disk that is nearly full takes a part of a write, and the rest in the next."""
    replacing = checkpoint.replacing

    class Short:
        def __init__(self, file):
            self.file = file

        def write(self, data):
            return self.file.write(bytes(data)[:100])

    @contextmanager
    def in_pieces(path):
        with replacing(path) as file:
            yield Short(file)

    monkeypatch.setattr(checkpoint, "replacing", in_pieces)
    earlier = checkpoints(begun)[-1]
    go_back(begun, earlier)
    assert begun.checkpoint.read_bytes() == earlier.read_bytes()
