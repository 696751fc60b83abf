"""Pictures deformed by a displacement so that what is left between them is small (WIDIM).

Both are deformed by half of it, a forwards and b backwards (Scarano 2002, Meas. Sci. Technol. 13,
R1): the error is then of second order in time. Grey levels between pixels come from
B-splines of fifth order: those of third leave a bias of 0.01 to 0.02 px where particles are two to
three pixels across (Astarita and Cardone 2005, Exp. Fluids 38, 233).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibration.piv.pictures import Pixels, Texture
from calibration.piv.windows import Grid

Array = NDArray[np.float64]


class Deformable(NamedTuple):
    """A texture as coefficients of B-splines, ready to be read between its pixels."""

    splines: Pixels
    weight: Pixels
    whole: bool  # all pixels count


_ORDER = 5  # of the splines


def deformable(one: Texture) -> Deformable:
    """The same texture as coefficients."""
    from scipy.ndimage import spline_filter

    splines = spline_filter(one.grey, order=_ORDER, output=np.float32, mode="mirror")
    return Deformable(splines, one.weight, bool(one.weight.all()))


def shifted(one: Deformable, u: Pixels, v: Pixels) -> Texture:
    """The texture read at (x + u, y + v) for every pixel (x, y); weight 0 beyond the picture."""
    from scipy.ndimage import map_coordinates

    height, width = u.shape
    at = np.empty((2, height, width), dtype=np.float32)
    at[0] = v + np.arange(height, dtype=np.float32)[:, None]
    at[1] = u + np.arange(width, dtype=np.float32)
    grey = map_coordinates(one.splines, at, order=_ORDER, mode="mirror", prefilter=False,
                           output=np.float32)  # fmt: skip
    near = np.rint(at).astype(np.intp)
    inside = (near[0] >= 0) & (near[0] < height) & (near[1] >= 0) & (near[1] < width)
    if not one.whole:
        i, j = near[0].clip(0, height - 1), near[1].clip(0, width - 1)
        inside &= one.weight[i, j] > 0
    weight = inside.astype(np.float32)
    return Texture(grey * weight, weight)


def deformed(a: Deformable, b: Deformable, u: Pixels, v: Pixels) -> tuple[Texture, Texture]:
    """Both pictures as they are midway, if the displacement is u, v (height, width)."""
    half = np.float32(0.5)
    return shifted(a, -half * u, -half * v), shifted(b, half * u, half * v)


def everywhere(values: Array, where: Grid, shape: tuple[int, int]) -> Pixels:
    """Values at the middles of windows to all pixels: cubic splines, constant beyond them."""
    rows, columns = _weights(where.y, shape[0]), _weights(where.x, shape[1])
    return np.asarray(rows @ values @ columns.T, dtype=np.float32)


def _weights(nodes: Array, length: int) -> Array:
    """(length, nodes) weight of each node's value at each pixel along one axis."""
    from scipy.interpolate import make_interp_spline

    if len(nodes) == 1:
        return np.ones((length, 1))
    at = np.arange(length).clip(nodes[0], nodes[-1])
    one = make_interp_spline(nodes, np.eye(len(nodes)), k=min(3, len(nodes) - 1))
    return np.asarray(one(at))
