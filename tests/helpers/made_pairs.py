"""Pairs of pictures of known displacement: particles of light, and touching ones in layers."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Motion = Callable[[Array, Array], tuple[Array, Array]]  # x, y midway -> u, v


def uniform(u: float, v: float) -> Motion:
    return lambda x, y: (np.full_like(x, u), np.full_like(y, v))


def shear(rate: float, about: float) -> Motion:
    """u = rate (y - about)."""
    return lambda x, y: (rate * (y - about), np.zeros_like(y))


def rotation(angle: float, x0: float, y0: float) -> Motion:
    """By a small angle [rad] about a point."""
    return lambda x, y: (-angle * (y - y0), angle * (x - x0))


def vortex(peak: float, core: float, x0: float, y0: float) -> Motion:
    """Lamb and Oseen's, of largest displacement `peak` at the distance `core`."""

    def motion(x: Array, y: Array) -> tuple[Array, Array]:
        dx, dy = x - x0, y - y0
        r2 = np.maximum((dx**2 + dy**2) / core**2, 1e-12)
        swirl = peak / core * 1.398 * (1 - np.exp(-1.25643 * r2)) / r2
        return -swirl * dy, swirl * dx

    return motion


@dataclass(frozen=True)
class Pair:
    a: NDArray[np.uint8]
    b: NDArray[np.uint8]
    motion: Motion


def particles(
    motion: Motion, seed: int, *, shape=(256, 256), per_pixel=0.03, diameter=2.5, noise=2.0,
    lost=0.05,
) -> Pair:  # fmt: skip
    """Gaussian spots (diameter at exp(-2)); a share `lost` leaves and others come."""
    random = np.random.default_rng(seed)
    n = int(per_pixel * (shape[0] + 40) * (shape[1] + 40))
    x, y = random.uniform(-20, shape[1] + 20, n), random.uniform(-20, shape[0] + 20, n)
    u, v = motion(x, y)
    bright = random.uniform(40, 160, n)
    here, there = random.uniform(size=n) > lost, random.uniform(size=n) > lost
    pictures = []
    for s, seen in ((-0.5, here), (0.5, there)):
        light = _spots(x + s * u, y + s * v, bright * seen, diameter / 4, shape)
        pictures.append(_camera(light, noise, random))
    return Pair(*pictures, motion)


def _spots(x, y, bright, sigma, shape) -> Array:
    """Spots of Gaussian light, integrated over each pixel."""
    from scipy.special import erf

    light = np.zeros((shape[0] + 40, shape[1] + 40))
    half = int(np.ceil(4 * sigma)) + 1
    k = np.arange(-half, half + 1)
    ix, iy = np.rint(x).astype(int), np.rint(y).astype(int)

    def part(centre, at):
        far = (at[:, None] + k - centre[:, None]) / (np.sqrt(2) * sigma)
        edge = 0.5 / (np.sqrt(2) * sigma)
        return (erf(far + edge) - erf(far - edge)) / 2

    px, py = part(x, ix), part(y, iy)
    inside = (np.abs(ix - shape[1] / 2) < shape[1] / 2 + 20 - half) & (
        np.abs(iy - shape[0] / 2) < shape[0] / 2 + 20 - half
    )
    stamp = (2 * np.pi * sigma**2) * bright[:, None, None] * py[:, :, None] * px[:, None, :]
    rows = (iy[:, None] + k + 20)[inside]
    columns = (ix[:, None] + k + 20)[inside]
    np.add.at(light, (rows[:, :, None], columns[:, None, :]), stamp[inside])
    return light[20:-20, 20:-20]


def grains(
    motion: Motion, seed: int, *, shape=(256, 256), diameter=10.0, layer=60.0, noise=2.0,
    tones=(0.25, 0.75), specks=4, times=3,
) -> Pair:  # fmt: skip
    """Round particles that touch, in layers of two tones, each with specks; they do not rotate.

    Painted on a grid `times` as fine, so that a place is known to a small part of a pixel.
    """
    random = np.random.default_rng(seed)
    x, y = _packed(random, shape, diameter)
    u, v = motion(x, y)
    dark = np.floor(y / layer) % 2 == 0
    tone = np.where(dark, *tones) + random.uniform(-0.1, 0.1, len(x))
    size = random.uniform(0.85, 1.05, len(x)) * diameter / 2
    where = random.normal(0, 0.22 * diameter, (specks, 2, len(x)))
    depth = random.uniform(-0.2, 0.2, (specks, len(x)))
    pictures = []
    for s in (-0.5, 0.5):
        light = _discs(x + s * u, y + s * v, size, tone, where, depth, shape, times)
        pictures.append(_camera(240 * light, noise, random))
    return Pair(*pictures, motion)


def _packed(random, shape, diameter) -> tuple[Array, Array]:
    """Rows of particles, shaken out of their positions."""
    rows = np.arange(-2 * diameter, shape[0] + 2 * diameter, 0.87 * diameter)
    columns = np.arange(-2 * diameter, shape[1] + 2 * diameter, diameter)
    y, x = np.meshgrid(rows, columns, indexing="ij")
    x = x + (np.arange(len(rows)) % 2)[:, None] * diameter / 2
    shake = random.normal(0, 0.12 * diameter, (2, *x.shape))
    return (x + shake[0]).ravel(), (y + shake[1]).ravel()


def _discs(x, y, size, tone, where, depth, shape, times) -> Array:
    import cv2

    fine = np.full((shape[0] * times, shape[1] * times), 0.1, dtype=np.float32)
    bits = 8  # of the fraction of a coordinate in OpenCV's drawing

    def at(px, py, r):
        c = [round(((p + 0.5) * times - 0.5) * 2**bits) for p in (px, py)]
        return c, round(r * times * 2**bits)

    for k in range(len(x)):
        centre, r = at(x[k], y[k], size[k])
        cv2.circle(fine, centre, r, float(tone[k]), -1, cv2.LINE_8, bits)
        for (dx, dy), d in zip(where[:, :, k], depth[:, k], strict=True):
            centre, r = at(x[k] + dx, y[k] + dy, 0.13 * 2 * size[k])
            cv2.circle(fine, centre, r, float(tone[k] + d), -1, cv2.LINE_8, bits)
    fine = cv2.GaussianBlur(fine, (0, 0), 0.7 * times)
    return cv2.resize(fine, shape[::-1], interpolation=cv2.INTER_AREA).astype(float)


def _camera(light: Array, noise: float, random: np.random.Generator) -> NDArray[np.uint8]:
    grey = light + 10 + noise * random.standard_normal(light.shape)
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


SHAPE = (192, 192)
MIDDLE = (SHAPE[0] - 1) / 2
MOTIONS = {
    "uniform": uniform(3.3, -2.7),
    "whole pixels": uniform(-5.0, 2.0),
    "far": uniform(4.4, 25.6),  # with windows of 32 pixels
    "shear": shear(0.03, MIDDLE),
    "rotation": rotation(0.03, MIDDLE, MIDDLE),
    "vortex": vortex(2.0, 60.0, MIDDLE, MIDDLE),
}


def errors(field, motion):
    """Errors and sigmas of the valid vectors, both components."""
    u, v = motion(field.x, field.y)
    wrong = np.stack([field.u - u, field.v - v])[:, field.valid]
    return wrong, np.stack([field.sigma_u, field.sigma_v])[:, field.valid]
