"""Drops of stones, rendered apart from calibration.rendered: other shapes, motion, light and noise.

A stone is a smooth outline of its own; its motion is integrated with a spring and a dashpot where
it touches the plate, so that contacts take time. It is lit from one side whichever way it lies,
with a soft shadow; light becomes grey levels by a power of it, noise is that of counted light, and
pictures are squeezed as JPEG or H.264 does.
"""

import io
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numba import njit
from PIL import Image, ImageDraw, ImageFilter

G = 9.80665  # m/s2
STEP = 5e-6  # s
FINE = 4  # rows and columns that a pixel is drawn in


class Motion(NamedTuple):
    """State of a stone every STEP: x, height [m], angle [rad], whether it touches."""

    x: np.ndarray
    height: np.ndarray
    angle: np.ndarray
    touches: np.ndarray


class Stone(NamedTuple):
    """A drop of a stone, and how it is filmed.

    outline     (n, 2) about its centroid [m]
    rate        frames/s
    scale       m/px
    """

    outline: np.ndarray
    motion: Motion
    release: float
    fall: float
    rate: float
    scale: float
    exposure: float
    light: float  # of the wall
    shade: float  # of the stone
    gamma: float
    counts: float  # of light in the brightest pixel
    quality: int  # of JPEG
    blur: float
    seed: int


@njit
def _moves(outline, gyration, height, angle, spin, stiffness, damping, friction, n):
    """Integrate (symplectic Euler) the free and the touching motion of unit mass."""
    x, vx, vy = 0.0, 0.0, 0.0
    state = np.empty((3, n))
    touches = np.zeros(n, dtype=np.bool_)
    for k in range(n):
        c, s = math.cos(angle), math.sin(angle)
        fx, fy, torque = 0.0, -G, 0.0
        for i in range(len(outline)):
            px = c * outline[i, 0] - s * outline[i, 1]
            py = s * outline[i, 0] + c * outline[i, 1]
            deep = -(height + py)
            if deep > 0:
                up = stiffness * deep - damping * (vy + spin * px)
                if up > 0:
                    slip = vx - spin * py
                    across = -friction * up * min(max(slip / 0.01, -1.0), 1.0)
                    fx += across
                    fy += up
                    torque += px * up - py * across
                    touches[k] = True
        vx += fx * STEP
        vy += fy * STEP
        spin += torque / gyration * STEP
        x += vx * STEP
        height += vy * STEP
        angle += spin * STEP
        state[0, k], state[1, k], state[2, k] = x, height, angle
    return state, touches


def outline_of(random: np.random.Generator, radius: float) -> np.ndarray:
    """A convex stone about its centroid [m]; or an ellipse, or a nut of six sides."""
    kind = random.integers(3)
    phi = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    if kind == 0:
        r = 1 + sum(
            random.uniform(0, 0.2) / k**2 * 2 * np.cos(k * (phi - random.uniform(0, 7)))
            for k in (2, 3, 4)
        )
    elif kind == 1:
        a = random.uniform(1.2, 1.8)
        r = 1 / np.hypot(np.cos(phi) / a, np.sin(phi))
    else:
        off = (phi + np.pi / 6) % (np.pi / 3) - np.pi / 6
        r = np.minimum(1 / np.cos(off), 1.1)
    points = np.stack([r * np.cos(phi), r * np.sin(phi)], axis=1)
    area, centre, _ = moments(points)
    return (points - centre) * radius / math.sqrt(area / np.pi)


def moments(points: np.ndarray) -> tuple[float, np.ndarray, float]:
    """Area, centroid and polar second moment about the origin, from triangles to the origin."""
    a, b = points, np.roll(points, -1, axis=0)
    twice = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    centre = ((a + b) / 3 * twice[:, None]).sum(axis=0) / twice.sum()
    polar = (twice / 12 * (a * a + a * b + b * b).sum(axis=1)).sum()
    return float(twice.sum() / 2), centre, float(polar)


def stone(random: np.random.Generator, rate: float, size: float) -> Stone:
    """A drop by chance, filmed at a rate [frames/s], of so many px (root of the area)."""
    radius = random.uniform(6e-3, 12e-3)
    outline = outline_of(random, radius)
    area, _, polar = moments(outline)
    fall, angle, spin = random.uniform(19e-3, 45e-3), random.uniform(0, 7), random.normal(0, 1)
    release = random.uniform(0.06, 0.2)
    time = math.sqrt(2 * fall / G)
    at = angle + spin * time
    low = float((outline @ np.array([math.sin(at), math.cos(at)])).min())
    stiffness = 4e8  # 1/s2: touches for 0.16 ms
    damping = 2 * math.sqrt(stiffness) * random.uniform(0.02, 0.35)
    state, touches = _moves(
        outline, polar / area, fall - low, angle, spin, stiffness, damping,
        random.uniform(0.1, 0.5), int((time + 0.45) / STEP),
    )  # fmt: skip
    bright, dark = random.uniform(0.5, 0.9), random.uniform(0.08, 0.3)
    light, shade = (bright, dark) if random.random() < 0.5 else (dark, bright)
    return Stone(
        outline, Motion(*state, touches), release, fall, rate, math.sqrt(area) / size,
        random.uniform(0.1, 0.6), light, shade, random.uniform(0.45, 1.0),
        10 ** random.uniform(3.0, 4.3), int(random.integers(60, 95)), random.uniform(0.4, 1.2),
        int(random.integers(1 << 30)),
    )  # fmt: skip


def truth(one: Stone) -> tuple[float, float]:
    """sqrt(H1/H0) of the centroid at the first contact, and frames until the next.

    Where the parabolas before and after it meet: a contact takes time here.
    """
    touching = np.flatnonzero(one.motion.touches)
    ends = touching[np.flatnonzero(np.diff(touching) > 1)]
    if not len(ends):
        return 0.0, 0.0
    first, last = int(touching[0]) - 1, int(ends[0]) + 1
    again = int(touching[np.searchsorted(touching, last)])
    state = []
    for k, side in ((first, -1), (last, 1)):
        # the height two steps apart without the fall in between, and the speed at time zero
        rise = one.motion.height[k + side] - one.motion.height[k]
        speed = side * rise / STEP + side * G * STEP / 2 + G * k * STEP
        state.append((one.motion.height[k] + G * (k * STEP) ** 2 / 2 - speed * k * STEP, speed))
    (y0, v0), (y1, v1) = state
    meet = -(y1 - y0) / (v1 - v0)
    return max(-(v1 - G * meet) / (v0 - G * meet), 0.0), (again - last) * STEP * one.rate


def film(one: Stone, path: Path) -> Path:
    """Write the film: mp4 of H.264, or avi of JPEG, as the path ends."""
    import imageio_ffmpeg

    pictures = list(_pictures(one))
    size = pictures[0].size
    codec = {".mp4": "libx264", ".avi": "mjpeg"}[path.suffix]
    writer = imageio_ffmpeg.write_frames(
        str(path), size, fps=one.rate, codec=codec, pix_fmt_in="rgb24", macro_block_size=2,
        quality=None, output_params=["-crf", "20"] if codec == "libx264" else ["-q:v", "3"],
    )  # fmt: skip
    writer.send(None)
    for picture in pictures:
        writer.send(np.ascontiguousarray(np.asarray(picture)))
    writer.close()
    return path


def _pictures(one: Stone):
    random = np.random.default_rng(one.seed)
    reach = float(np.hypot(*one.outline.T).max()) / one.scale
    top = float(one.motion.height[0]) / one.scale + reach
    width, height = int(6 * reach + 40) // 2 * 2, int(top + 40) // 2 * 2
    wall = _wall(random, width, height, one.light)
    total = int((one.release + len(one.motion.x) * STEP) * one.rate) - 2
    for k in range(total):
        light = np.zeros((height, width, 3))
        for s in (-0.4, -0.2, 0.0, 0.2, 0.4):
            light += _seen(one, wall, k / one.rate + s * one.exposure / one.rate, reach) / 5
        counted = random.poisson(np.clip(light, 0, 1) * one.counts) / one.counts
        grey = np.uint8(np.clip(255 * counted**one.gamma, 0, 255))
        squeezed = io.BytesIO()
        Image.fromarray(grey).save(squeezed, format="JPEG", quality=one.quality)
        yield Image.open(squeezed).convert("RGB")


def _wall(random: np.random.Generator, width: int, height: int, light: float) -> np.ndarray:
    """Plaster, brighter towards a corner, and a glossy plate below."""
    spots = Image.fromarray(np.uint8(random.integers(0, 256, (height, width))))
    rough = np.asarray(spots.filter(ImageFilter.GaussianBlur(2)), dtype=float) / 255 - 0.5
    x, y = np.meshgrid(np.linspace(0, 1, width), np.linspace(0, 1, height))
    wall = light * (1 + 0.25 * (0.5 - x) + 0.15 * (0.5 - y) + 0.3 * rough)
    wall[height - 14 :] *= 0.75
    return np.clip(wall[:, :, None] * np.array([1.0, 0.97, 0.9]), 0, 1)


def _seen(one: Stone, wall: np.ndarray, time: float, reach: float) -> np.ndarray:
    height, width = wall.shape[:2]
    k = min(max(int((time - one.release) / STEP), 0), len(one.motion.x) - 1)
    angle = one.motion.angle[k]
    x = width / 2 + one.motion.x[k] / one.scale
    y = height - 14 - one.motion.height[k] / one.scale
    c, s = math.cos(angle), math.sin(angle)
    points = one.outline @ np.array([[c, s], [-s, c]]) / one.scale * [1, -1] + [x, y]
    low, high = (
        np.floor(points.min(axis=0)).astype(int) - 4,
        np.ceil(points.max(axis=0)).astype(int) + 5,
    )
    box = tuple(int(v) for v in high - low)
    cover = Image.new("L", (box[0] * FINE, box[1] * FINE))
    drawn = (points - low + 0.5) * FINE - 0.5
    ImageDraw.Draw(cover).polygon([tuple(p) for p in drawn], fill=255)
    small = cover.resize(box, Image.Resampling.BOX).filter(ImageFilter.GaussianBlur(one.blur))
    whole = Image.new("L", (width, height))
    whole.paste(small, tuple(int(v) for v in low))
    alpha = np.asarray(whole, dtype=np.float32) / 255
    u = (np.arange(width) - x) / reach
    lit = one.shade * (1 - 0.25 * np.clip(u, -1, 1))[None, :, None] * np.array([0.9, 0.95, 1.0])
    far = max((height - 14 - y) / reach - 0.5, 0.0)
    shadow = 0.3 / (1 + far) * np.exp(-((np.arange(width) - x) ** 2) / (reach * (1 + far)) ** 2)
    ground = wall.copy()
    ground[height - 14 :] *= 1 - shadow[None, :, None]
    return ground + alpha[:, :, None] * (lit - ground)
