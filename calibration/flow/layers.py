"""Layers of a filling and their displacement profile, as silo2d measures it of a run.

The line of layer k at a time t, over columns j two particles wide (silo2d.measures.profile):

    y_k(j) = <y(0)>_k + <y(t) - y(0)>_kj

with means over particles: the layer's at the start, and those in column j that have not left, two
at least. A film shows material and no list of particles. So the tracers are parted many times into
particles that might have been: what is nearest to the points of a lattice, rotated and shifted by
chance. Such a piece may lie over two particles of which one leaves before the other: it is where
the median of its tracers is, and has left when half of them have, as a particle when its centroid
has. The line is the mean over these partings. Their scatter is how far the line depends on which
particles there are, to which that of the tracers' own errors is added.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibration.flow.silo import Silo
from calibration.flow.survey import Labels
from granulab.errors import InputError

Floats = NDArray[np.float64]

_PARTINGS = 60
_FEWEST = 2  # particles that make a mean, as in silo2d
_WHOLE = 0.5  # of a particle's tracers that must be of one layer for it to count there
_PURE = 0.75  # share of one tone within a painted band


class Band(NamedTuple):
    """Rows of a layer in the first picture [px], from top to bottom; tone 0, 1, or -1 for any."""

    top: float
    bottom: float
    tone: int


class Pieces(NamedTuple):
    """A parting of the tracers into pieces of a particle's size.

    use      (n,) tracers that are in a piece, in the order of the pieces
    tracers  (m,) number of them in each piece of each piece
    start    (m,) mean height at the start
    layer    (m,)
    """

    use: NDArray[np.int64]
    tracers: NDArray[np.int64]
    start: Floats
    layer: NDArray[np.int64]

    def means(self, values: Floats) -> Floats:
        """(m,) mean of the tracers' values in each piece."""
        return np.asarray(np.bincount(self._piece, values[self.use]) / self.tracers)

    def medians(self, values: Floats) -> Floats:
        """(m,) their median."""
        ordered = values[self.use][np.lexsort((values[self.use], self._piece))]
        first = np.cumsum(self.tracers) - self.tracers
        low, high = (ordered[first + k // 2] for k in (self.tracers - 1, self.tracers))
        return np.asarray((low + high) / 2)

    @property
    def _piece(self) -> NDArray[np.int64]:
        return np.repeat(np.arange(len(self.tracers)), self.tracers)


@dataclass(frozen=True)
class Profile:
    """Lines of the layers (l, c), and how well they are known, in the silo's unit; NaN for none.

    particles    (l, c) in each column, as far as squares of a particle's area show
    """

    time: float
    lines: Floats
    sigma: Floats
    particles: Floats


def painted_bands(
    labels: Labels, silo: Silo, use: NDArray[np.bool_], particle: float
) -> list[Band]:
    """Painted layers in the first picture, the lowest first; none where tones do not alternate.

    labels, use    tones, and where material may be, of the whole picture; particle: its width [px]
    """
    rows, columns = silo.box
    inside = np.where(use[rows, columns], labels[rows, columns], 2)
    dark, light = ((inside == tone).sum(axis=1).astype(float) for tone in (0, 1))
    window = np.ones(max(round(particle), 1))
    dark, light = (np.convolve(count, window, "same") for count in (dark, light))
    both = dark + light
    filled = np.flatnonzero(both > 0.1 * both.max())
    first, end = int(filled[0]), int(filled[-1]) + 1
    share = dark[first:end] / np.maximum(both[first:end], 1.0)
    edges = [0, *_long_runs(share < 0.5, particle), end - first]
    bands = []
    for top, bottom in pairwise(edges):
        tone = 0 if share[top:bottom].mean() > 0.5 else 1
        bands.append(
            Band(silo.box[0].start + first + top, silo.box[0].start + first + bottom, tone)
        )
    purest = [max(p, 1 - p) for p in (share[a:b].mean() for a, b in pairwise(edges))]
    if len(bands) < 2 or np.mean(purest) < _PURE:
        return []
    return bands[::-1]


def _long_runs(light: NDArray[np.bool_], least: float) -> list[int]:
    """Beginnings of runs as long as `least`; shorter ones join their neighbours."""
    changes = np.flatnonzero(np.diff(light)) + 1
    kept: list[int] = []
    for k, at in enumerate(changes):
        end = changes[k + 1] if k + 1 < len(changes) else len(light)
        before = kept[-1] if kept else 0
        if (
            end - at >= least
            and at - before >= least
            and (light[at] != light[before + (at - before) // 2])
        ):
            kept.append(int(at))
    return kept


def drawn_bands(silo: Silo, height: float, top: float) -> list[Band]:
    """Bands of a height [px] from the outlet's level to `top`, where no paint shows layers."""
    count = int(np.ceil((silo.outlet - top) / height))
    if count > 200:
        raise InputError(f"--layer-height: {count} layers; take a larger height")
    return [
        Band(silo.outlet - (k + 1) * height, silo.outlet - k * height, -1) for k in range(count)
    ]


def of_bands(
    bands: list[Band], position: NDArray, tone: NDArray, particle: float
) -> NDArray[np.int64]:
    """Band of each tracer (n,): the nearest of its tone within a particle, else where it lies."""
    y = position[:, 1]
    far = np.array([np.maximum(np.maximum(b.top - y, y - b.bottom), 0.0) for b in bands])
    other = np.array([(b.tone >= 0) & (tone != b.tone) for b in bands])
    own = np.where(other, np.inf, far)
    nearest = own.argmin(axis=0)
    return np.where(own.min(axis=0) <= particle, nearest, far.argmin(axis=0))


class Lines:
    """Profiles of tracers that started at `start` (n, 2) along the silo's axes, in layers (n,)."""

    def __init__(
        self, start: Floats, layer: NDArray[np.int64], edges: Floats, share: float
    ) -> None:
        """share: of a particle's area that one tracer stands for; edges of the columns (c + 1,)."""
        self.edges = edges
        self._start, self._layer, self._share = start, layer, share
        self._count = int(layer.max()) + 1
        random = np.random.default_rng(0)
        size = (edges[1] - edges[0]) / 2
        self._partings = [self._parting(size, random) for _ in range(_PARTINGS)]

    def _parting(self, size: float, random: np.random.Generator) -> Pieces:
        """Pieces of one layer each, without those of which too little is of a layer."""
        from scipy.spatial import cKDTree

        middle, reach = self._start.mean(axis=0), np.ptp(self._start, axis=0).max() * 0.75
        row = np.arange(-reach, reach, size)
        lattice = np.stack(np.meshgrid(row, row), axis=-1).reshape(-1, 2)
        angle = random.uniform(0, np.pi / 2)
        rotation = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        # Shifted by up to half a particle, so that no row of particles reaches across the silo.
        centres = middle + lattice @ rotation + random.uniform(-size / 2, size / 2, lattice.shape)
        cell = cKDTree(centres).query(self._start)[1]
        key = np.column_stack([cell, self._layer])
        _, number, count = np.unique(key, axis=0, return_inverse=True, return_counts=True)
        number = number.ravel()
        order = np.argsort(number, kind="stable")
        whole = count * self._share >= _WHOLE
        use, first = order[whole[number[order]]], (np.cumsum(count) - count)[whole]
        layer = self._layer[order[first]]
        start = np.bincount(number, self._start[:, 1])[whole] / count[whole]
        return Pieces(use, count[whole], start, layer)

    @property
    def levels(self) -> Floats:
        """Mean height of each layer at the start (l,)."""
        return np.bincount(self._layer, self._start[:, 1]) / np.bincount(self._layer)

    def at(self, time: float, position: Floats, variance: Floats) -> Profile:
        """Profile of tracers that are now at `position` (n, 2), with the variance of each (n,)."""
        found = [self._lines(parting, position, variance) for parting in self._partings]
        lines, own, particles = (np.array(part) for part in zip(*found, strict=True))
        known = np.isfinite(lines)
        usual = known.mean(axis=0) >= 0.5
        lines, own = (np.where(known, part, 0.0) for part in (lines, own))
        n = np.maximum(known.sum(axis=0), 1)
        mean = lines.sum(axis=0) / n
        scatter = np.where(known, np.square(lines - mean), 0.0).sum(axis=0) / np.maximum(n - 1, 1)
        sigma = np.sqrt(scatter + own.sum(axis=0) / n)
        return Profile(time, np.where(usual, mean, np.nan), np.where(usual, sigma, np.nan),
                       particles.mean(axis=0))  # fmt: skip

    def _lines(
        self, parting: Pieces, position: Floats, variance: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Lines (l, c), the variance of each from that of the tracers, and the particles."""
        inside = parting.medians(position[:, 1]) > 0
        fall = parting.medians(position[:, 1] - self._start[:, 1])[inside]
        column = np.digitize(parting.medians(position[:, 0])[inside], self.edges[1:-1])
        shape = self._count, len(self.edges) - 1
        cell = np.ravel_multi_index((parting.layer[inside], column), shape)

        def sums(values: Floats | None = None) -> Floats:
            return np.bincount(cell, values, self._count * shape[1]).reshape(shape).astype(float)

        count = sums()
        particles = np.maximum(np.bincount(parting.layer, minlength=self._count), 1)
        level = np.bincount(parting.layer, parting.start, self._count) / particles
        moved, own = sums(fall), sums(parting.means(variance)[inside])
        lines = np.where(count >= _FEWEST, moved / np.maximum(count, 1), np.nan) + level[:, None]
        return lines, own / np.maximum(count, 1) ** 2, count
