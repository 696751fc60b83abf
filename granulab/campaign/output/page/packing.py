"""Numbers of a page: quantised, differences from frame to frame, deflated, base64.

    q = rint((value - low)/step)                  or, of quantities over decades,
    q = 1 + rint(log(value/low)/step), 0 for none

are 16-bit integers. What is packed are their first or second differences along time (the second of
a free fall are constant), modulo 2^16, with the sign in the last bit (0, -1, 1, -2 ... become 0, 1,
2, 3 ...), particle by particle, all low bytes before all high ones: mostly zeros, of which deflate
makes little. parts/data.js unpacks them, to the same integers.
"""

import base64
import zlib
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granulab.errors import InputError

_MOST = 2**16 - 1  # of an integer
LEVELS = 1000  # of a quantity that is read off a scale of colours
_NO_LOWER = 1e-12  # of the largest, below which a logarithm is none


class Quantised(NamedTuple):
    """An array as integers.

    integers     uint16, time or rows along the first axis
    low, step    of the values, see the module
    logarithmic  whether the step is one of the logarithm
    order        of the differences that are packed
    """

    integers: NDArray[np.uint16]
    low: float = 0.0
    step: float = 1.0
    logarithmic: bool = False
    order: int = 1

    @property
    def values(self) -> NDArray[np.float64]:
        """Values that a page reads, 0 where a logarithm has none."""
        if not self.logarithmic:
            return self.low + self.step * self.integers.astype(float)
        whole = self.low * np.exp(self.step * (self.integers - 1.0))
        return np.where(self.integers > 0, whole, 0.0)


def linear(values: ArrayLike, step: float, order: int = 1) -> Quantised:
    """Values in steps, or in larger ones where 2^16 of them do not reach."""
    values = np.asarray(values, dtype=float)
    low = float(values.min(initial=np.inf)) if values.size else 0.0
    span = float(values.max() - low) if values.size else 0.0
    step = max(step, span / _MOST)
    integers = np.rint((values - low) / step) if step else np.zeros_like(values)
    return Quantised(integers.astype(np.uint16), low, step, order=order)


def on_scale(values: ArrayLike, order: int = 1) -> Quantised:
    """Values in thousandths of their span."""
    values = np.asarray(values, dtype=float)
    return linear(values, float(np.ptp(values)) / LEVELS if values.size else 0.0, order)


def logarithmic(values: ArrayLike, decades: float, order: int = 1) -> Quantised:
    """Positive values in thousandths of some decades below their largest; others are none.

    Smaller ones count as the smallest of them.
    """
    values = np.asarray(values, dtype=float)
    largest = float(values.max(initial=0.0))
    low = largest * 10.0**-decades
    step = decades * np.log(10.0) / (LEVELS - 1)
    some = values > _NO_LOWER * largest
    integers = np.zeros(values.shape)
    integers[some] = 1.0 + np.rint(np.log(np.maximum(values[some], low) / low) / step)
    return Quantised(integers.astype(np.uint16), low, step, True, order)


def counted(integers: ArrayLike, order: int = 1) -> Quantised:
    """Integers from 0 to 65,535 as they are; InputError for more."""
    integers = np.asarray(integers)
    if integers.size and integers.max() > _MOST:
        raise InputError(f"{integers.max():,} particles and walls: a page counts to {_MOST:,}")
    return Quantised(integers.astype(np.uint16), order=order)


def packed(arrays: Mapping[str, Quantised]) -> tuple[list[dict[str, Any]], str]:
    """A page's list of arrays, and their bytes as base64."""
    heads, pieces = [], []
    for name, array in arrays.items():
        content = _bytes_of(array)
        heads.append(
            {
                "name": name,
                "shape": list(array.integers.shape),
                "bytes": len(content) // max(array.integers.size, 1),
                "order": array.order,
                "low": array.low,
                "step": array.step,
                "logarithmic": array.logarithmic,
            }
        )
        pieces.append(content)
    return heads, base64.b64encode(zlib.compress(b"".join(pieces), 9)).decode()


def _bytes_of(array: Quantised) -> bytes:
    """Low bytes of the differences of an array, then the high ones where any is not 0."""
    along = np.moveaxis(array.integers, 0, -1).astype(np.uint16)
    for _ in range(array.order):
        along = np.diff(along, axis=-1, prepend=np.uint16(0))
    signed = along.astype(np.int16).astype(np.int32)
    folded = ((signed << 1) ^ (signed >> 15)).astype(np.uint16)
    low, high = (folded & 255).astype(np.uint8), (folded >> 8).astype(np.uint8)
    return low.tobytes() + (high.tobytes() if high.any() else b"")
