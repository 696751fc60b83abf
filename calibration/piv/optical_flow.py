"""Displacement by dense optical flow (DIS; Kroeger et al. 2016, ECCV), as means over windows.

Both pictures are first deformed by the coarse correlation, so that flow finds what is left, however
far the particles went. Flow is taken forwards, f from a to b, and backwards, g from b to a; midway

    displacement (f - g)/2,   residual f + g,

f and g read where the same texture is in a and in b. Errors of f and g that differ show in the
residual: sigma is half its root mean square over the window, and the statistics of the correlation
between the pictures deformed by the displacement (Wieneke 2015) for errors that they share.
"""

import numpy as np
from numpy.typing import NDArray

from calibration.piv.deformation import deformable, deformed
from calibration.piv.field import Field, Flags, Reason, Vectors, field
from calibration.piv.passes import coarse, outside
from calibration.piv.pictures import Pixels, texture
from calibration.piv.statistics import sigmas
from calibration.piv.windows import Grid, grid

Dense = NDArray[np.float32]  # (height, width, 2), u and v


def optical_flow(a: Pixels, b: Pixels, window: int, overlap: float, mask: Flags) -> Field:
    """The displacement of windows; see calibration.piv.displacement."""
    first, second = texture(a, mask, window), texture(b, mask, window)
    one, other = deformable(first), deformable(second)
    u, v = coarse(first, second, window, overlap)
    front, back = deformed(one, other, u, v)
    rest, residual = _both_ways(*_as_bytes(front.grey, back.grey))
    u, v = u + rest[..., 0], v + rest[..., 1]
    front, back = deformed(one, other, u, v)
    where = grid(a.shape, window, overlap)
    inner = _inner(where)
    weight = front.weight * back.weight
    errors = [np.sqrt(inner.weighted(residual[..., k] ** 2, weight)) / 2 for k in (0, 1)]
    reason = np.where(outside(front, back, where), np.int8(Reason.MASKED), np.int8(Reason.MEASURED))
    quality = 2 * np.hypot(*errors)
    found = Vectors(inner.weighted(u, weight), inner.weighted(v, weight), quality, reason)
    known = [np.hypot(*both) for both in zip(errors, sigmas(front, back, inner), strict=True)]
    return field(found, known[0], known[1], where, "flow")


def _inner(where: Grid) -> Grid:
    """Windows of half the side about the same middles: less of what bends within a window."""
    off = where.size // 4
    return Grid(where.size - 2 * off, where.top + off, where.left + off)


def _as_bytes(a: Pixels, b: Pixels) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Textures as grey levels about 128, the same scale for both; few bright points are cut."""
    top = max(float(np.percentile(np.abs(one), 99.9)) for one in (a, b))
    scale = 127 / top if top > 0 else 0.0
    one, other = (np.clip(np.rint(128 + scale * x), 0, 255).astype(np.uint8) for x in (a, b))
    return one, other


def _both_ways(a: NDArray[np.uint8], b: NDArray[np.uint8]) -> tuple[Dense, Dense]:
    """Displacement and residual midway between the pictures."""
    forwards, backwards = _dis(a, b), _dis(b, a)
    middle, half = forwards, np.float32(0.5)
    for _ in range(2):  # where to read them depends on what is read
        f, g = _read(forwards, -half * middle), _read(backwards, half * middle)
        middle = half * (f - g)
    return middle, f + g


def _dis(a: NDArray[np.uint8], b: NDArray[np.uint8]) -> Dense:
    import cv2

    flow = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    flow.setFinestScale(0)  # all pixels: displacements are wanted to a hundredth
    return np.asarray(flow.calc(a, b, None), dtype=np.float32)  # type: ignore[call-overload]


def _read(flow: Dense, at: Dense) -> Dense:
    """A flow read at (x, y) + at; that at the border beyond it."""
    import cv2

    height, width = flow.shape[:2]
    y, x = np.mgrid[:height, :width].astype(np.float32)
    linear = cv2.INTER_LINEAR
    return np.asarray(cv2.remap(flow, x + at[..., 0], y + at[..., 1], linear,
                                borderMode=cv2.BORDER_REPLICATE))  # fmt: skip
