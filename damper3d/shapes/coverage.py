"""How far a surface lies outside of the spheres that stand for it: a bound, not an estimate."""

import numpy as np

_AT_ONCE = 2**22  # distances that are held at once


def deepest_gap(corners: np.ndarray, centres: np.ndarray, radii: np.ndarray) -> float:
    """The largest distance [m] from a point of the pieces to the nearest sphere's surface.

    corners (m, c, 3): of m pieces, segments or triangles [m]; centres (k, 3), radii (k,) [m].
    Balls are convex: a piece whose corners lie within R_i + e of one centre i lies there wholly.
    The answer is the least such e that does for all pieces; negative where all lie inside.
    """
    return float(gaps(corners, centres, radii).max())


def gaps(corners: np.ndarray, centres: np.ndarray, radii: np.ndarray) -> np.ndarray:
    """The same of each piece, (m,) [m]."""
    found = np.empty(len(corners))
    step = max(_AT_ONCE // (corners.shape[1] * len(centres)), 1)
    for begin in range(0, len(corners), step):
        part = corners[begin : begin + step, :, None] - centres
        apart = np.sqrt(np.einsum("mckx,mckx->mck", part, part)) - radii
        found[begin : begin + step] = apart.max(axis=1).min(axis=1)
    return found
