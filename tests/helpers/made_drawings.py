"""Drawings and photographs of known truth: SVG and DXF texts, particles on an even background."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

Corners = Sequence[tuple[float, float]]

# The paper's silo A4 in mm, x = 0 at its left wall, y upwards: 60 deg hopper, outlet 150 mm.
RISE = 75 * math.tan(math.radians(60))
A4 = [(75, 0), (225, 0), (300, RISE), (300, 500), (0, 500), (0, RISE)]
# Turned upside down, as SVG has its y: the picture is 500 mm high.
A4_DOWN = [(x, 500 - y) for x, y in A4]


def svg(inner: str, width: str = "300mm", box: str = "0 0 300 500") -> str:
    """An SVG document around some elements."""
    return (
        f'<?xml version="1.0"?>\n<svg xmlns="http://www.w3.org/2000/svg" width="{width}" '
        f'viewBox="{box}">{inner}</svg>\n'
    )


def svg_path(corners: Corners) -> str:
    """A closed path through corners."""
    steps = " L ".join(f"{x!r} {y!r}" for x, y in corners)
    return f'<path d="M {steps} Z"/>'


def dxf(entities: str, units: int | None = 4) -> str:
    """An ASCII DXF of some entities; units: $INSUNITS, 4 are millimetres."""
    header = "" if units is None else f"9\n$INSUNITS\n70\n{units}\n"
    return (
        f"0\nSECTION\n2\nHEADER\n{header}0\nENDSEC\n0\nSECTION\n2\nENTITIES\n{entities}"
        "0\nENDSEC\n0\nEOF\n"
    )


def dxf_line(start: Sequence[float], end: Sequence[float], layer: str = "0") -> str:
    """A LINE."""
    return (
        f"0\nLINE\n8\n{layer}\n10\n{start[0]!r}\n20\n{start[1]!r}\n11\n{end[0]!r}\n21\n{end[1]!r}\n"
    )


def dxf_arc(centre: Sequence[float], radius: float, start: float, end: float) -> str:
    """An ARC, counter-clockwise, angles in degrees."""
    x, y = centre
    return f"0\nARC\n8\n0\n10\n{x}\n20\n{y}\n40\n{radius}\n50\n{start}\n51\n{end}\n"


def dxf_polyline(vertices: Sequence[Sequence[float]], closed: bool = True, layer: str = "0") -> str:
    """An LWPOLYLINE of x, y and, where there is one, bulge."""
    text = f"0\nLWPOLYLINE\n8\n{layer}\n90\n{len(vertices)}\n70\n{int(closed)}\n"
    for x, y, *bulge in vertices:
        text += f"10\n{x!r}\n20\n{y!r}\n" + (f"42\n{bulge[0]!r}\n" if bulge else "")
    return text


def regular(n: int, radius: float, centre: Sequence[float], turned: float = 0.0) -> np.ndarray:
    """Corners (n, 2) of a regular polygon."""
    angle = turned + 2 * math.pi * np.arange(n) / n
    return np.array(centre) + radius * np.column_stack([np.cos(angle), np.sin(angle)])


def area_of(corners: np.ndarray) -> float:
    """Area of a polygon (n, 2), positive where it is counter-clockwise."""
    x, y = np.asarray(corners).T
    return 0.5 * float(x @ np.roll(y, -1) - np.roll(x, -1) @ y)


def photograph(
    path: Path, particles: Sequence[np.ndarray], bar: tuple[float, float, float, float] | None,
    size: tuple[int, int] = (900, 600), noise: float = 4.0,
) -> Path:  # fmt: skip
    """Write a picture of dark polygons [px, y down] on a bright background; its path.

    bar: left, top, right, bottom of a scale bar [px]. Pixels at borders have their share of both
    (each is the mean of eight by eight), as a sharp lens has them.
    """
    import cv2

    fine = 8
    picture = np.full((size[1] * fine, size[0] * fine), 230, np.uint8)
    for corners in particles:
        # fillPoly takes in the pixels on the border: their centres lie half a pixel inside
        cv2.fillPoly(picture, [np.round(corners * fine - 0.5).astype(np.int32)], 60)
    if bar is not None:
        left, top, right, bottom = (round(fine * x) for x in bar)
        picture[top:bottom, left:right] = 20
    seen = cv2.resize(picture, size, interpolation=cv2.INTER_AREA).astype(float)
    seen += np.random.default_rng(1).normal(0, noise, seen.shape)
    done, content = cv2.imencode(".png", np.clip(seen, 0, 255).astype(np.uint8))
    assert done
    path.write_bytes(content.tobytes())
    return path
