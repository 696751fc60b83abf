"""Checks that a mesh encloses a solid: closed, of one piece, orientable, not cutting itself."""

from typing import TYPE_CHECKING

import numpy as np

from damper3d.shapes.surfaces.surface import Surface, normals_and_areas
from granulab.errors import InputError

if TYPE_CHECKING:
    import trimesh

_SAME = 1e-6  # of the diagonal of the box: corners nearer than this are one; STL has single numbers
_SHARED = 1e-3  # of the area of a triangle on another: less is rounding at its rim


def sound(corners: np.ndarray, name: str) -> Surface:
    """The closed surface of triangles (m, 3, 3), facing outwards; name: of the file, for messages.

    Raises InputError, one line, where the triangles are not the surface of one solid.
    """
    import trimesh

    vertices, triangles = _welded(corners)
    mesh = trimesh.Trimesh(vertices, triangles, process=False)
    _check_edges(mesh, name)
    trimesh.repair.fix_winding(mesh)
    if not mesh.is_winding_consistent:
        raise InputError(
            f"mesh {name!r}: has one side only, as a Klein bottle; it encloses nothing"
        )
    surface = Surface(vertices, np.array(mesh.faces))
    volume = float(np.linalg.det(surface.corners - vertices.mean(axis=0)).sum())
    if volume < 0.0:
        surface = Surface(vertices, surface.triangles[:, ::-1])
    size = float(np.ptp(vertices, axis=0).max())
    if abs(volume) / 6.0 <= 1e-9 * size**3:
        raise InputError(f"mesh {name!r}: encloses no volume; it is flat")
    _check_heights(surface, name)
    for look, what in ((crossing, "cuts itself"), (covering, "has faces that lie on each other")):
        pair = look(surface)
        if pair is not None:
            x, y, z = surface.corners[pair[0]].mean(axis=0)
            raise InputError(
                f"mesh {name!r}: {what}, near ({x:.4g}, {y:.4g}, {z:.4g}); unite its parts first "
                "(MeshLab, Blender: boolean union)"
            )
    return surface


def outward(corners: np.ndarray, name: str) -> Surface:
    """The closed surface of triangles (m, 3, 3) that face outwards already; name: of the file.

    Raises InputError, one line, where they do not, or as `sound` does.
    """
    surface = sound(corners, name)
    volumes = [float(np.linalg.det(c - surface.vertices.mean(axis=0)).sum())
               for c in (corners, surface.corners)]  # fmt: skip
    if abs(volumes[0] + volumes[1]) <= _SHARED * volumes[1]:
        raise InputError(
            f"mesh {name!r}: is inside out, its triangles face inwards; turn them round first "
            "(MeshLab: Invert Faces Orientation)"
        )
    if abs(volumes[0] - volumes[1]) > _SHARED * volumes[1]:
        raise InputError(
            f"mesh {name!r}: some of its triangles face inwards; turn them round first (MeshLab: "
            "Re-Orient all faces coherently)"
        )
    return surface


def _welded(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices once each, in the order in which they come, and triangles of three different."""
    from scipy.spatial import cKDTree
    from trimesh.graph import connected_component_labels

    points = corners.reshape(-1, 3)
    exact, which = np.unique(points, axis=0, return_inverse=True)
    pairs = cKDTree(exact).query_pairs(_same_within(corners), output_type="ndarray")
    triangles = connected_component_labels(pairs, len(exact))[which.ravel()].reshape(-1, 3)
    different = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    used = triangles[different].ravel()
    _, first, number = np.unique(used, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty(len(order), int)
    rank[order] = np.arange(len(order))
    vertices = points.reshape(-1, 3, 3)[different].reshape(-1, 3)[first[order]]
    return vertices, rank[number.ravel()].reshape(-1, 3)


def _check_edges(mesh: "trimesh.Trimesh", name: str) -> None:
    """Raise InputError unless each edge has two triangles, and all hang together."""
    from trimesh.graph import connected_component_labels

    times = np.bincount(mesh.edges_unique_inverse)
    for wrong, what, cure in (
        ((times == 1).sum(), "of one triangle only: it is open", "close its holes"),
        ((times > 2).sum(), "of three triangles or more: not manifold", "take out inner walls"),
    ):
        if wrong:
            raise InputError(f"mesh {name!r}: {wrong} edges are {what}; {cure} first")
    n = len(mesh.faces)
    piece = connected_component_labels(mesh.face_adjacency, n)
    first = int((piece == piece[0]).sum())
    if first < n:
        raise InputError(
            f"mesh {name!r}: more than one piece, of {first} triangles and others; a particle "
            "or a cavity is one closed surface without inner voids"
        )


def _check_heights(surface: Surface, name: str) -> None:
    """Raise InputError where a triangle has all corners in a line, and so no direction."""
    corners = surface.corners
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    areas = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    thin = np.flatnonzero(2.0 * areas <= _same_within(corners) * longest)
    if len(thin):
        x, y, z = corners[thin[0]].mean(axis=0)
        raise InputError(
            f"mesh {name!r}: {len(thin)} triangles have their corners in a line, near ({x:.4g}, "
            f"{y:.4g}, {z:.4g}); take them out first (MeshLab: remove T-vertices)"
        )


def _same_within(corners: np.ndarray) -> float:
    """Distance below which corners are one, in the unit of the file."""
    points = corners.reshape(-1, 3)
    return _SAME * float(np.linalg.norm(np.ptp(points, axis=0)))


def crossing(surface: Surface) -> tuple[int, int] | None:
    """Two triangles of which an edge of one goes through the other, or None.

    Triangles that share corners count where an edge without a shared corner goes through.
    """
    corners = surface.corners
    first, second = _near_pairs(corners)
    for one, other in ((first, second), (second, first)):
        for k in range(3):
            ends = surface.triangles[one][:, [k, (k + 1) % 3]]
            apart = ~(ends[:, :, None] == surface.triangles[other][:, None, :]).any(axis=(1, 2))
            start, end = surface.vertices[ends[apart]].transpose(1, 0, 2)
            hit = np.flatnonzero(_through(start, end, corners[other[apart]]))
            if len(hit):
                at = np.flatnonzero(apart)[hit[0]]
                return int(one[at]), int(other[at])
    return None


def covering(surface: Surface) -> tuple[int, int] | None:
    """Two triangles of one plane that lie on each other with a part of their area, or None.

    Neighbours with a common edge do where the surface is folded back there; others are cut with
    each other in the plane.
    """
    from shapely import area, intersection, polygons

    corners = surface.corners
    i, j = _near_pairs(corners)
    normals, areas = normals_and_areas(corners)
    height = np.einsum("nkx,nx->nk", corners[j] - corners[i, :1], normals[i])
    flat = np.abs(height).max(axis=1) <= _same_within(corners)
    i, j = i[flat], j[flat]
    common = (surface.triangles[i][:, :, None] == surface.triangles[j][:, None, :]).sum((1, 2))
    facing = np.einsum("nx,nx->n", normals[i], normals[j])
    doubtful = (common < 2) | (facing < 0.0)
    i, j = i[doubtful], j[doubtful]
    across = np.linalg.svd(normals[i][:, None, :])[2][:, 1:]  # two directions in each plane
    first, second = (
        polygons(np.einsum("nkx,nax->nka", corners[k] - corners[i, :1], across)) for k in (i, j)
    )
    shared = area(intersection(first, second)) > _SHARED * np.minimum(areas[i], areas[j])
    hit = np.flatnonzero(shared)
    return (int(i[hit[0]]), int(j[hit[0]])) if len(hit) else None


def _near_pairs(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangles i < j whose boxes overlap."""
    from shapely import STRtree, box

    low, high = corners.min(axis=1), corners.max(axis=1)
    flat = box(low[:, 0], low[:, 1], high[:, 0], high[:, 1])
    i, j = STRtree(flat).query(flat)
    overlap = (i < j) & (low[i, 2] <= high[j, 2]) & (low[j, 2] <= high[i, 2])
    return i[overlap], j[overlap]


def _through(start: np.ndarray, end: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """True where a segment (n, 3) meets its triangle (n, 3, 3) (Moeller and Trumbore 1997)."""
    along = end - start
    ab, ac = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    from_a = start - corners[:, 0]
    p, q = np.cross(along, ac), np.cross(from_a, ab)
    size = np.einsum("nx,nx->n", ab, p)
    scale = np.linalg.norm(along, axis=1) * np.linalg.norm(np.cross(ab, ac), axis=1)
    steep = np.abs(size) > 1e-12 * scale  # not in the plane of the triangle
    size = np.where(steep, size, 1.0)
    u = np.einsum("nx,nx->n", from_a, p) / size
    v = np.einsum("nx,nx->n", along, q) / size
    t = np.einsum("nx,nx->n", ac, q) / size
    return steep & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t >= 0.0) & (t <= 1.0)
