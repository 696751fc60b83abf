"""A page taken apart: its data, and its arrays unpacked as parts/data.js does it."""

import base64
import json
import re
import zlib
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray


class Page(NamedTuple):
    """Data of a page, and the values of its arrays by name."""

    data: dict[str, Any]
    arrays: dict[str, NDArray[np.float64]]


def read_page(text: str) -> Page:
    """The data and arrays of a page that plays a run."""
    data = json.loads(element(text, "data"))
    return Page(data, unpacked(data["arrays"], element(text, "arrays")))


def element(text: str, name: str) -> str:
    """Content of the script element of an id."""
    found = re.findall(rf'<script type="[^"]*" id="{name}">(.*?)</script>', text, re.DOTALL)
    assert len(found) == 1
    return found[0]


def unpacked(heads: list[dict[str, Any]], binary: str) -> dict[str, NDArray[np.float64]]:
    """Values of packed arrays by name."""
    raw = zlib.decompress(base64.b64decode(binary))
    arrays, start = {}, 0
    for head in heads:
        size = int(np.prod(head["shape"]))
        end = start + size * head["bytes"]
        arrays[head["name"]] = _values(head, _integers(raw[start:end], head, size))
        start = end
    assert start == len(raw)
    return arrays


def _integers(raw: bytes, head: dict[str, Any], size: int) -> NDArray[np.int64]:
    planes = np.frombuffer(raw, np.uint8).astype(np.int64)
    folded = planes[:size] + (planes[size:] << 8 if head["bytes"] == 2 else 0)
    differences = (folded >> 1) ^ -(folded & 1)
    shape = head["shape"]
    along = differences.reshape(*shape[1:], shape[0])
    for _ in range(head["order"]):
        along = np.cumsum(along, axis=-1)
    return np.moveaxis(along % 2**16, -1, 0)


def _values(head: dict[str, Any], integers: NDArray[np.int64]) -> NDArray[np.float64]:
    if head["logarithmic"]:
        return np.where(integers, head["low"] * np.exp(head["step"] * (integers - 1.0)), 0.0)
    return head["low"] + head["step"] * integers
