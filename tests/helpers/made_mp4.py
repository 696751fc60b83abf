"""The header of an mp4 rewritten: how long each picture is shown, and how a player turns it.

ISO/IEC 14496-12: stts (8.6.1.2) has the durations of samples, tkhd (8.3.2) a matrix.
"""

import struct
from pathlib import Path

import numpy as np

_WITHIN = (b"moov", b"trak", b"mdia", b"minf", b"stbl")  # boxes that hold boxes
# a, b, c, d of the matrix in 16.16: what turns pictures by so many degrees, clockwise
_TURNS = {90: (0, 1, -1, 0), 180: (-1, 0, 0, -1), 270: (0, -1, 1, 0)}


def with_durations(path: Path, seconds: np.ndarray) -> None:
    """Let picture k be shown for seconds[k], to a tick of the file's clock."""
    data = bytearray(path.read_bytes())
    start, _ = _box(data, b"mdhd")
    ticks = struct.unpack_from(">I", data, start + 12)[0]
    lengths = np.diff(np.rint(np.concatenate([[0], np.cumsum(seconds)]) * ticks)).astype(int)
    table = b"".join(struct.pack(">II", 1, int(n)) for n in lengths)
    content = struct.pack(">II", 0, len(lengths)) + table
    first = _found(data, b"edts")[-1]
    data[first + 4 : first + 8] = b"free"  # it would end the film where it ended before
    path.write_bytes(_replaced(data, b"stts", content))


def turned_by(path: Path, degrees: int) -> None:
    """Let players turn the pictures clockwise."""
    data = bytearray(path.read_bytes())
    start, _ = _box(data, b"tkhd")
    a, b, c, d = (value << 16 for value in _TURNS[degrees])
    struct.pack_into(">iiiiiiiii", data, start + 40, a, b, 0, c, d, 0, 0, 0, 1 << 30)
    path.write_bytes(bytes(data))


def _found(data: bytes, kind: bytes) -> list[int]:
    """Where each box begins on the way to the first of this kind."""

    def within(first: int, last: int) -> list[int] | None:
        while first + 8 <= last:
            size, name = struct.unpack_from(">I4s", data, first)
            if name == kind:
                return [first]
            if name in _WITHIN:
                inner = within(first + 8, first + size)
                if inner is not None:
                    return [first, *inner]
            first += size
        return None

    way = within(0, len(data))
    assert way is not None, kind
    return way


def _box(data: bytes, kind: bytes) -> tuple[int, int]:
    """First and last byte of a box's content."""
    first = _found(data, kind)[-1]
    return first + 8, first + struct.unpack_from(">I", data, first)[0]


def _replaced(data: bytearray, kind: bytes, content: bytes) -> bytes:
    """The file with another content of a box; moov stands behind the pictures' own data."""
    way = _found(data, kind)
    start, end = _box(data, kind)
    assert data.find(b"mdat") < way[0]
    more = len(content) - (end - start)
    for first in way:
        size = struct.unpack_from(">I", data, first)[0]
        struct.pack_into(">I", data, first, size + more)
    return bytes(data[:start] + content + data[end:])
