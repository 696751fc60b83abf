"""Triangles from STL files (binary and text) and Wavefront OBJ, and as OBJ again."""

import re
from itertools import pairwise
from pathlib import Path

import numpy as np

from granulab.errors import InputError

MOST_TRIANGLES = 20_000
_HEAD, _RECORD = 84, 50  # bytes of a binary STL before the triangles, and of each
_VERTEX = re.compile(rb"^\s*vertex\s+(\S+)\s+(\S+)\s+(\S+)\s*$", re.MULTILINE | re.IGNORECASE)


def read_triangles(path: Path) -> np.ndarray:
    """Corners (m, 3, 3) of the triangles of a file, in its own unit.

    Raises InputError, one line, where it cannot be read, holds no triangles or too many.
    """
    try:
        data = path.read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"mesh {str(path)!r}: cannot be read ({reason})") from None
    ending = path.suffix.lower()
    if ending not in (".stl", ".obj"):
        raise InputError(f"mesh {str(path)!r}: not an .stl or .obj file")
    corners = _stl(data) if ending == ".stl" else _obj(data)
    if corners is None or not len(corners):
        raise InputError(f"mesh {str(path)!r}: holds no triangles, or is no {ending[1:].upper()}")
    if len(corners) > MOST_TRIANGLES:
        raise InputError(
            f"mesh {str(path)!r}: {len(corners)} triangles, more than {MOST_TRIANGLES}; simplify "
            "it first, as MeshLab or Blender (decimate) do"
        )
    if not np.isfinite(corners).all() or not 0.0 < np.abs(corners).max() < 1e9:
        raise InputError(f"mesh {str(path)!r}: its corners are not all ordinary numbers")
    return corners


def _stl(data: bytes) -> np.ndarray | None:
    """Binary where the size is that of its number of triangles, else text; None: neither."""
    if len(data) >= _HEAD:
        number = int.from_bytes(data[_HEAD - 4 : _HEAD], "little")
        if len(data) == _HEAD + _RECORD * number:
            record = np.dtype([("floats", "<f4", 12), ("unused", "<u2")])
            floats = np.frombuffer(data, record, offset=_HEAD)["floats"]
            return floats[:, 3:].reshape(-1, 3, 3).astype(float)
    return _as_triangles(_VERTEX.findall(data))


def _as_triangles(words: list[tuple[bytes, bytes, bytes]]) -> np.ndarray | None:
    try:
        numbers = np.array([[float(word) for word in words_of] for words_of in words])
    except ValueError:
        return None
    return numbers.reshape(-1, 3, 3) if len(numbers) % 3 == 0 else None


def _obj(data: bytes) -> np.ndarray | None:
    """Faces of more than three corners are cut into fans; None where a line is none of OBJ."""
    vertices: list[list[float]] = []
    triangles: list[tuple[int, int, int]] = []
    try:
        for line in data.decode("utf-8", "replace").replace("\\\n", " ").splitlines():
            key, *words = line.split("#")[0].split() or [""]
            if key == "v":
                vertices.append([float(word) for word in words[:3]])
            elif key == "f":
                numbers = [_index(word, len(vertices)) for word in words]
                fan = pairwise(numbers[1:])
                triangles += [(numbers[0], b, c) for b, c in fan]
        return np.array(vertices, float)[np.array(triangles, int)] if triangles else None
    except (ValueError, IndexError):
        return None


def _index(word: str, so_far: int) -> int:
    """Of a corner such as "7/2/3", counted from 1, or back from the last if negative."""
    number = int(word.partition("/")[0])
    if not (number > 0 or -so_far <= number < 0):
        raise ValueError(word)
    return number - 1 if number > 0 else so_far + number


def as_obj(corners: np.ndarray) -> str:
    """A file with these triangles, every number to its last bit."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in corners.reshape(-1, 3).tolist()]
    lines += [f"f {k} {k + 1} {k + 2}" for k in range(1, 3 * len(corners), 3)]
    return "\n".join(lines) + "\n"
