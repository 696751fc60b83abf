"""Surfaces that face each other: flat, made of waves, or cut out of a measured profile.

A made surface has all waves that fit on its width, from the longest to the shortest, each with the
same power and a random phase: noise cut off at a wavelength. A measured one is a stretch of a path,
from a random position and in a random direction; its form is a straight line, as in the roughness.
Lower and upper surface are two of a kind.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibration.bench.roughness import INPUTS, without_form
from calibration.bench.sections import curves, need, request_of
from granulab.contact.files.units import located
from granulab.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Waves:
    """Mean roughness Ra (thesis eq. 7.1), shortest and longest wavelength [m] (None: the width).

    one_sided: only the lower surface is rough. drawn: of a surface that varies another one, how
    many waves that one has; those that both have are alike.
    """

    ra: float
    wavelength: float
    longest: float | None = None
    one_sided: bool = False
    drawn: int | None = None

    def draw(self, x: Array, period: bool, rng: np.random.Generator) -> tuple[Array, Array]:
        """Heights z(x) [m] of the lower and the upper surface, (n,) each, about their means."""
        numbers = self.numbers(float(np.ptp(x)))
        first = self.drawn or int(numbers[-1])
        phases = rng.uniform(0, 2 * np.pi, (2, first))
        more = rng.uniform(0, 2 * np.pi, (2, max(int(numbers[-1]) - first, 0)))
        low, up = np.concatenate([phases, more], axis=1)[:, numbers - 1]
        lower = self._one(x, numbers, low)
        return lower, np.zeros_like(x) if self.one_sided else -self._one(x, numbers, up)

    def numbers(self, width: float) -> NDArray[np.int64]:
        """Numbers of waves that fit on the width."""
        rounding = 1e-9
        first = int(np.ceil(width / (self.longest or width) - rounding))
        numbers = np.arange(max(first, 1), int(width / self.wavelength + rounding) + 1)
        if len(numbers) == 0:
            raise InputError(
                f"wavelength = {self.wavelength:g} m: no whole wave from there to "
                f"{self.longest or width:g} m fits on {width:g} m; a shorter one would do"
            )
        return numbers

    def _one(self, x: Array, numbers: NDArray[np.int64], phases: Array) -> Array:
        width = float(np.ptp(x))

        def waves(at: Array) -> Array:
            turns = numbers * (at[:, None] - x[0]) / width
            summed: Array = np.cos(2 * np.pi * turns + phases).sum(axis=1)
            return summed

        fine = x[0] + width * np.linspace(0, 1, 40 * int(numbers[-1]), endpoint=False)
        return self.ra / float(np.abs(waves(fine)).mean()) * waves(x)


@dataclass(frozen=True)
class Paths:
    """Measured profiles: (x, z) [m], (n,) each, x rising and the form taken off, by name."""

    paths: tuple[tuple[str, Array, Array], ...]

    def draw(self, x: Array, period: bool, rng: np.random.Generator) -> tuple[Array, Array]:
        """Heights z(x) [m] of the lower and the upper surface, (n,) each, about their means."""
        for name, along, _ in self.paths:
            if np.ptp(along) < np.ptp(x) * (1 - 1e-9):
                raise InputError(
                    f"profile {name}: a path of {np.ptp(along):.4g} m is shorter than the blocks' "
                    f"width of {np.ptp(x):.4g} m; a smaller --width would do"
                )
        return self._stretch(x, period, rng), -self._stretch(x, period, rng)

    def _stretch(self, x: Array, period: bool, rng: np.random.Generator) -> Array:
        """Means over the columns, so that what is finer than the mesh is not sampled by chance."""
        _, along, heights = self.paths[int(rng.integers(len(self.paths)))]
        start = along[0] + rng.random() * max(float(np.ptp(along) - np.ptp(x)), 0.0)
        half = float(np.diff(x).mean()) / 2
        at = start + x - x[0]
        edges = np.clip([at - half, at + half], along[0], along[-1])
        areas = np.diff(along) * (heights[1:] + heights[:-1]) / 2
        summed = np.interp(edges, along, np.concatenate([[0.0], np.cumsum(areas)]))
        z: Array = np.diff(summed, axis=0)[0] / np.diff(edges, axis=0)[0]
        if rng.random() < 0.5:
            z = z[::-1]
        if period:  # its ends meet: by a ramp that is far flatter than the roughness
            z = z - np.linspace(0, 1, len(z)) * (z[-1] - z[0])
        centred: Array = z - z.mean()
        return centred


def read_paths(files: Sequence[str | Path], columns: Sequence[str]) -> Paths:
    """Profiles as `calibrate roughness` reads them, a line taken off; columns as "x=Way [mm]"."""
    what = request_of(INPUTS, columns)
    sections, _ = curves(files, INPUTS, what)
    found = []
    for section in sections:
        need(section, [["x", "z"]], INPUTS)
        order = np.argsort(section.columns["x"], kind="stable")
        x, z = (section.columns[name][order] for name in ("x", "z"))
        with located(f"{section.name}:"):
            found.append((section.name, x, without_form(x, z, "line")))
    return Paths(tuple(found))


def first_touch(lower: Array, upper: Array) -> Array:
    """The upper surface lowered until it touches: its lowest gap is 0."""
    lowered: Array = upper - np.min(upper - lower)
    return lowered
