"""Triangles from STL and Wavefront OBJ files, and as OBJ again; mass properties of their solid.

trimesh reads STL. Its reader of OBJ takes numbers of corners that count back from the last for
others where vertices follow the faces: OBJ is read here, to the last bit.

Mass properties are exact. Each triangle makes a tetrahedron with the origin, whose volume counts
negative where the triangle faces it; the sums are the integrals of 1, x and x x^T over the solid
(B. Mirtich, J. Graphics Tools 1 (1996) 31; D. Eberly, Polyhedral mass properties, 2002).
"""

import io
import logging
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from damper3d.shapes.surfaces.surface import area_of
from granulab.contact.files.datafile import refuse_pipe
from granulab.errors import InputError

MOST_TRIANGLES = 20_000
# It would print a traceback of what it then reads otherwise.
logging.getLogger("trimesh").addHandler(logging.NullHandler())


def read_triangles(path: Path) -> np.ndarray:
    """Corners (m, 3, 3) of the triangles of a file, in its own unit.

    Raises InputError, one line, where it cannot be read, holds no triangles or too many.
    """
    refuse_pipe(path)
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
    """Binary or text, of one solid or several; None where it is neither."""
    import trimesh

    for readable in (data, data.decode("utf-8", "replace").encode()):
        try:
            mesh = trimesh.load_mesh(io.BytesIO(readable), file_type="stl", process=False)
        except Exception:  # of many kinds, for files that are no STL
            continue
        return np.asarray(mesh.triangles)
    return None


def _obj(data: bytes) -> np.ndarray | None:
    """Faces of more than three corners are cut into fans; None where a line is none of OBJ.

    A corner of fewer than three numbers is none.
    """
    vertices: list[list[float]] = []
    triangles: list[tuple[int, int, int]] = []
    try:
        for line in data.decode("utf-8", "replace").replace("\\\n", " ").splitlines():
            key, *words = line.split("#")[0].split() or [""]
            if key == "v":
                x, y, z = words[:3]
                vertices.append([float(x), float(y), float(z)])
            elif key == "f":
                numbers = [_index(word, len(vertices)) for word in words]
                fan = pairwise(numbers[1:])
                triangles += [(numbers[0], b, c) for b, c in fan]
        return np.array(vertices, float)[np.array(triangles, int)] if triangles else None
    except (ValueError, IndexError):
        return None


def _index(word: str, so_far: int) -> int:
    """Index of a corner such as "7/2/3", counted from 1, or back from the last if negative."""
    number = int(word.partition("/")[0])
    if not (number > 0 or -so_far <= number < 0):
        raise ValueError(word)
    return number - 1 if number > 0 else so_far + number


def as_obj(corners: np.ndarray) -> str:
    """A file with these triangles, every number to its last bit."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in corners.reshape(-1, 3).tolist()]
    lines += [f"f {k} {k + 1} {k + 2}" for k in range(1, 3 * len(corners), 3)]
    return "\n".join(lines) + "\n"


class Mass(NamedTuple):
    """Mass properties over the density."""

    volume: float  # [m3], positive where the triangles face outwards
    area: float  # [m2]
    centroid: np.ndarray  # (3,) [m]
    inertia: np.ndarray  # (3, 3) tensor about the centroid [m5]


def mass_of(corners: np.ndarray) -> Mass:
    """Mass properties of closed triangles (m, 3, 3) [m] that face outwards."""
    origin = corners.reshape(-1, 3).mean(axis=0)  # near by, so that nothing cancels
    near = corners - origin
    sizes = np.linalg.det(near) / 6.0
    volume = float(sizes.sum())
    total = near.sum(axis=1)
    first = np.einsum("m,mx->x", sizes / 4.0, total)
    # over a tetrahedron with corners 0, a, b, c: V/20 (a a + b b + c c + s s), s = a + b + c
    second = np.einsum("m,mcx,mcy->xy", sizes / 20.0, near, near)
    second += np.einsum("m,mx,my->xy", sizes / 20.0, total, total)
    centroid = first / volume
    second -= volume * np.outer(centroid, centroid)
    inertia = np.trace(second) * np.eye(3) - second
    return Mass(volume, area_of(corners), origin + centroid, inertia)


def principal_axes(inertia: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Principal moments (3,), rising, and axes in columns (3, 3), right-handed.

    Of the two senses of the first two axes the one whose largest component is positive.
    """
    moments, axes = np.linalg.eigh(inertia)
    for k in (0, 1):
        axes[:, k] *= np.sign(axes[np.argmax(np.abs(axes[:, k])), k])
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    return moments, axes
