"""Fills any closed surface with sub-spheres, to a bound on how far the two surfaces are apart.

Many spheres that touch the surface from inside are found (the largest that touches at a point and
holds no other point of the surface: a sphere about a point of the medial axis). From them few are
chosen which, grown by a length e, hold every triangle of the surface: the surface is then nowhere
deeper than e above an ungrown one. In the end all are grown by one length t, so that together they
have the volume of the shape: their surface is at most t outside of it and at most e - t inside.
Spheres are convex, so that this holds for triangles as a whole and not for some points of them.
"""

from dataclasses import dataclass

import numpy as np

from damper3d.shapes.surfaces.covering import cover, needed_growth, to_surface
from damper3d.shapes.surfaces.surface import area_of, normals_and_areas
from damper3d.shapes.surfaces.union import of_any
from granulab.errors import InputError

MOST_SUB_SPHERES = 1000  # of one particle: 90 of them are as many spheres as 250 dampers of 358
_PIECES = 4000  # of the surface, about: those of a sphere have edges of 0.085 of its radius
_SLIVERS = 10.0  # times as many pieces as their area needs are too many
_POINTS = 1500  # where spheres touch, from which to choose
_REFINEMENTS = 3  # halve the triangles where the shape is sharp
_UNEVENNESS = 0.01  # of the equal-volume radius: half of the usual tolerance
_GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0
_USUAL_SHARE = 1.5  # of the depth e over the larger of t and e - t, which is a third or so of e
_CLOSER = 0.97  # so that the next try does not miss by a rounding
_NEWTON_STEPS = 2  # from a third of e; the second leaves 1e-3 of t
_LATITUDES = 200  # for the volume while spheres grow; 5e-4 of it are left
_HALVINGS = 12  # of the range in which a length is looked for: 1/4096 of it is left


@dataclass(frozen=True)
class Filling:
    """Sub-spheres that stand for a shape."""

    centres: np.ndarray  # (k, 3) [m]
    radii: np.ndarray  # (k,) [m]
    surface_error: float  # bounds how far the two surfaces are apart [m]


class Filler:
    """Finds fillings of one surface; what they share is computed once.

    corners (m, 3, 3) [m]: of the triangles of a closed surface that face outwards; volume [m3]: of
    the shape; flatness [m]: how far its true surface rises above the triangles.
    """

    def __init__(self, corners: np.ndarray, volume: float, flatness: float = 0.0) -> None:
        self._volume = volume
        self._size = (0.75 * volume / np.pi) ** (1 / 3)
        self._flatness = flatness
        self._pieces = fine(corners)
        self._centres, self._radii = self._balls(np.arange(len(self._pieces)))
        self._growth = self._growths()

    def by_tolerance(self, tolerance: float) -> Filling:
        """As few sub-spheres as are found for a bound on the surface error [m].

        Raises InputError where that takes more than MOST_SUB_SPHERES.
        """
        limit = _USUAL_SHARE * tolerance
        self._refine(limit)
        while True:
            chosen = self._chosen(limit - self._flatness, MOST_SUB_SPHERES)
            if chosen is None:
                raise InputError(
                    f"tolerance = {tolerance / self._size:.3g}: takes more than {MOST_SUB_SPHERES} "
                    "sub-spheres; give a larger one (--tolerance 0.05), a number (--sub-spheres), "
                    "or a shape with rounder edges"
                )
            found = self._grown(chosen)
            if found.surface_error <= tolerance:
                return found
            limit *= _CLOSER * tolerance / found.surface_error

    def by_number(self, number: int) -> Filling:
        """Filling of at most so many sub-spheres (1 or more) with the least depth e found."""
        self._refine(self._least_depth(number)[0])
        return self._grown(self._least_depth(number)[1])

    def _least_depth(self, number: int) -> tuple[float, np.ndarray]:
        """The depth e [m] that so many spheres leave at least, as it is found, and the spheres."""
        low, high = 0.0, float(self._growth.max(axis=0).min())  # one sphere alone does
        found = self._chosen(high, number)
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            chosen = self._chosen(middle, number)
            if chosen is None:
                low = middle
            else:
                high, found = middle, chosen
        assert found is not None
        return high, found

    def _refine(self, depth: float) -> None:
        """Split the triangles that no sphere holds at half a depth [m], and add spheres there."""
        for _ in range(_REFINEMENTS):
            rough = self._growth.min(axis=1) > 0.5 * depth
            if not rough.any():
                return
            parts = _split(self._pieces[rough], 2)
            self._pieces = np.concatenate([self._pieces[~rough], parts])
            new = np.arange(len(self._pieces) - len(parts), len(self._pieces))
            centres, radii = self._balls(new)
            self._centres = np.concatenate([self._centres, centres])
            self._radii = np.concatenate([self._radii, radii])
            self._growth = self._growths()

    def _growths(self) -> np.ndarray:
        found = np.empty((len(self._pieces), len(self._centres)), np.float32)
        needed_growth(self._pieces, self._centres, self._radii, found)
        return found

    def _balls(self, pieces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Centres (n, 3) and radii (n,) [m] of spheres that touch some pieces from inside."""
        middles = self._pieces.mean(axis=1)
        widths = np.linalg.norm(self._pieces - middles[:, None], axis=2).max(axis=1)
        at = pieces[_spread(len(pieces), _POINTS)]
        normals, _ = normals_and_areas(self._pieces[at])
        # Spheres that touch the triangles, and larger ones that pass over small unevenness.
        depths = (self._flatness, self._flatness + _UNEVENNESS * self._size)
        parts = [_touching_balls(middles, at, normals, depth) for depth in depths]
        centres = np.concatenate(parts)
        return centres, to_surface(centres, self._pieces, middles, widths)

    def _chosen(self, limit: float, most: int) -> np.ndarray | None:
        """Numbers of spheres, at most so many, that hold all when grown by the limit, or None."""
        chosen = np.empty(2 * most, np.int64)  # capacity for those that turn out superfluous
        number = cover(self._growth, normals_and_areas(self._pieces)[1], limit, chosen)
        if number < 0:
            return None
        kept = _needed(self._growth[:, chosen[:number]] <= limit)
        return chosen[:number][kept] if len(kept) <= most else None

    def _grown(self, chosen: np.ndarray) -> Filling:
        """Spheres grown to the volume of the shape by Newton's method, as dV/dt is the surface."""
        centres, radii = self._centres[chosen], self._radii[chosen]
        deepest = float(self._growth[:, chosen].min(axis=1).max()) + self._flatness
        growth = deepest / 3.0
        for _ in range(_NEWTON_STEPS):
            volume, area = of_any(centres, radii + growth, _LATITUDES)
            growth += (self._volume - volume) / area
        return Filling(centres, radii + growth, max(abs(growth), deepest - growth))


def fine(corners: np.ndarray, pieces: int = _PIECES) -> np.ndarray:
    """The same surface in about so many triangles, or more, whose edges are of one size [m]."""
    area = area_of(corners)
    edge = np.sqrt(4.0 / np.sqrt(3.0) * area / pieces)  # of equal regular triangles
    parts = _parts(corners, edge)
    if (parts**2).sum() > _SLIVERS * pieces:
        corners = _without_slivers(corners, edge)
        parts = _parts(corners, edge)
    split = np.concatenate([_split(corners[parts == n], n) for n in np.unique(parts)])
    sides = split - np.roll(split, 1, axis=1)
    flat = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) <= 1e-12 * area
    return split[~flat]  # a triangle without area is part of its neighbours' edges


def _parts(corners: np.ndarray, edge: float) -> np.ndarray:
    """In how many parts of an edge [m] each triangle's longest edge is cut (m,)."""
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    return np.maximum(np.rint(longest / edge).astype(int), 1)


def _without_slivers(corners: np.ndarray, edge: float) -> np.ndarray:
    """The same surface, triangles much longer than wide cut across in strips of triangles.

    Cut in triangles of their own form they would be many times the pieces that their area needs.
    """
    area = normals_and_areas(corners)[1]
    sliver = _parts(corners, edge) ** 2 > _SLIVERS * np.maximum(area / edge**2, 1.0)
    long = corners[sliver]
    first = np.linalg.norm(np.roll(long, -1, axis=1) - long, axis=2).argmax(axis=1)
    turned = np.take_along_axis(long, (first[:, None] + np.arange(3))[..., None] % 3, axis=1)
    a, b, c = np.moveaxis(turned, 1, 0)  # the longest edge is from a to b
    share = np.sum((c - a) * (b - a), axis=1) / np.sum((b - a) ** 2, axis=1)
    foot = a + share[:, None] * (b - a)  # of the height from c
    # Two right triangles, their sharp ends first.
    halves = np.concatenate([np.stack([a, foot, c], 1), np.stack([b, c, foot], 1)])
    length = np.linalg.norm(0.5 * (halves[:, 1] + halves[:, 2]) - halves[:, 0], axis=1)
    width = np.linalg.norm(halves[:, 1] - halves[:, 2], axis=1)
    strips = np.maximum(np.rint(length / np.maximum(width, edge)).astype(int), 1)
    cut = [_strips(halves[strips == n], n) for n in np.unique(strips)]
    return np.concatenate([corners[~sliver], *cut])


def _strips(corners: np.ndarray, n: int) -> np.ndarray:
    """Each triangle in n strips parallel to the edge opposite its first corner, as triangles."""
    part = np.arange(n + 1)[:, None] / n
    sharp, one, other = corners[:, :1], corners[:, 1:2], corners[:, 2:]
    q, r = sharp + part * (one - sharp), sharp + part * (other - sharp)  # (m, n + 1, 3)
    lower = np.stack([q[:, :-1], q[:, 1:], r[:, 1:]], axis=2)
    upper = np.stack([q[:, 1:-1], r[:, 2:], r[:, 1:-1]], axis=2)
    return np.concatenate([lower, upper], axis=1).reshape(-1, 3, 3)


def _split(corners: np.ndarray, n: int) -> np.ndarray:
    """Each triangle in n^2 of its own form."""
    a, ab, ac = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    upright = [((i, j), (i + 1, j), (i, j + 1)) for i in range(n) for j in range(n - i)]
    inverted = [
        ((i + 1, j), (i + 1, j + 1), (i, j + 1)) for i in range(n - 1) for j in range(n - 1 - i)
    ]
    steps = np.array([*upright, *inverted], float) / n  # (n^2, 3, 2)
    split = a[:, None, None] + steps[..., 0, None] * ab[:, None, None]
    split = split + steps[..., 1, None] * ac[:, None, None]
    return split.reshape(-1, 3, 3)


def _touching_balls(
    points: np.ndarray, at: np.ndarray, normals: np.ndarray, depth: float
) -> np.ndarray:
    """Centres (n, 3) [m] of the largest spheres that touch at some points and hold no other one.

    points (m, 3) [m]; at (n,): the numbers of those where spheres touch; normals (n, 3) there.

    The sphere shrinks until it does (Ma, Bae and Choi, The Visual Computer 28 (2012) 7): one that
    touches at p and goes through q has the radius |p - q|^2/(2 (p - q) . n). depth [m]: of points
    in a sphere that count as on it, as those of a curved surface lie that far from its triangles.
    """
    from scipy.spatial import cKDTree

    p, n = points[at], normals
    tree = cKDTree(points)
    radius = np.full(len(at), 0.5 * float(np.ptp(points, axis=0).max()))
    active = np.arange(len(at))
    while len(active):
        distance, nearest = tree.query(p[active] - radius[active, None] * n[active])
        apart = p[active] - points[nearest]
        above = 2.0 * np.einsum("nx,nx->n", apart, n[active])
        through = np.einsum("nx,nx->n", apart, apart) / np.where(above > 0.0, above, np.nan)
        smaller = (through < radius[active]) & (distance < radius[active] * (1 - 1e-6) - depth)
        active = active[smaller]
        radius[active] = through[smaller]
    return p - radius[:, None] * n


def _spread(number: int, wanted: int) -> np.ndarray:
    """Some of `number` items, about `wanted`, without a pattern and always the same."""
    position = np.arange(1, number + 1) * _GOLDEN % 1.0
    return np.flatnonzero(position < wanted / number)


def _needed(holds: np.ndarray) -> np.ndarray:
    """Columns (m, k) of spheres that hold a piece which no other one that is kept holds."""
    times = holds.sum(axis=1)
    kept = []
    for k in range(holds.shape[1]):
        if (times[holds[:, k]] > 1).all():
            times -= holds[:, k]
        else:
            kept.append(k)
    return np.array(kept)
