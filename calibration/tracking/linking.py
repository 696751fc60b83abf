"""Blobs of many pictures linked to objects: by where they are, their size and their colour.

An object may go on from where it was, or as it moved (straight on, or bending as in free fall);
after a bounce it lies somewhere between. Blobs of one picture are given to objects all together, at
least cost (Hungarian method). Pieces of one object's path, cut where it was hidden or out of the
picture, are joined where nothing speaks against it: same look, one after the other, within reach.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from calibration.tracking.blobs import Blob
from calibration.tracking.segments import noise

_PIECE = 4  # pictures in which a piece is seen, for it to be joined to another
_SMOOTH = 10  # ratio of the length of a path to its noise
_GAP = 6  # pictures for which an object may be out of sight and be followed
_LARGER = math.log(2.0)  # logarithm of the ratio of areas at which two blobs are not one object
_OFF_COLOUR = 0.5  # of the contrast, by which the colour of an object may change
_FIRST_STEP = 8  # own sizes that an object may go from the first picture of it to the second
_IMPOSSIBLE = 2.0  # cost, of which position and look have up to 1 each


@dataclass
class Path:
    """One object in the pictures in which it was seen."""

    frames: list[int] = field(default_factory=list)
    blobs: list[Blob] = field(default_factory=list)

    @property
    def length(self) -> float:
        """Of the diagonal of all its positions [px]."""
        positions = np.array([(one.x, one.y) for one in self.blobs])
        return float(np.hypot(*np.ptp(positions, axis=0)))

    def add(self, frame: int, blob: Blob) -> None:
        """Go on with a blob."""
        self.frames.append(frame)
        self.blobs.append(blob)

    def costs(self, frame: int, blobs: list[Blob], farthest: float) -> list[float]:
        """Cost of each blob as next of this object: below 1 in position, look; or impossible."""
        last = self.blobs[-1]
        positions, reach = self._expected(frame)
        found = []
        for blob in blobs:
            off = _off(blob, positions, reach, farthest)
            look = unlike(last, blob) if off < 1 else 1.0
            found.append(off + look if look < 1 else _IMPOSSIBLE)
        return found

    def may_become(self, piece: "Path") -> bool:
        """True if a later piece may be the same object: alike, within reach, soon enough."""
        gap = piece.frames[0] - self.frames[-1]
        if gap <= 0 or min(len(self.frames), len(piece.frames)) < _PIECE:
            return False
        if gap > max(len(self.frames), len(piece.frames)):
            return False
        first, last = piece.blobs[0], self.blobs[-1]
        away = math.hypot(first.x - last.x, first.y - last.y)
        _, reach = self._expected(piece.frames[0])
        near = reach is not None and away < math.sqrt(first.area) + reach
        return near and unlike(_typical(self), _typical(piece)) < 1

    def is_smooth(self) -> bool:
        """True if it goes along a path, rather than flickers within the noise."""
        t = np.array(self.frames, dtype=float)
        x, y = np.array([(one.x, one.y) for one in self.blobs]).T
        return self.length > _SMOOTH * float(np.hypot(noise(t, x), noise(t, y)))

    def _expected(self, frame: int) -> tuple[list[tuple[float, float]], float | None]:
        """Position it had; those it would have, straight on and bending; how far it may go by then.

        That is as far as at its fastest of late: in the frame of a bounce it hardly moves.
        """
        t = self.frames[-4:]
        p = [(one.x, one.y) for one in self.blobs[-4:]]
        if len(t) < 2:
            return p, None
        ahead = frame - t[-1]
        speeds = []
        for k in range(1, len(t)):
            step = t[k] - t[k - 1]
            speeds.append(((p[k][0] - p[k - 1][0]) / step, (p[k][1] - p[k - 1][1]) / step))
        (x, y), (u, v) = p[-1], speeds[-1]
        positions = [(x, y), (x + u * ahead, y + v * ahead)]
        if len(t) > 2:
            bent = ahead * (ahead + t[-1] - t[-2]) / (t[-1] - t[-3])
            positions.append((positions[1][0] + (u - speeds[-2][0]) * bent,
                           positions[1][1] + (v - speeds[-2][1]) * bent))  # fmt: skip
        return positions, max(math.hypot(*speed) for speed in speeds) * ahead


def _off(
    blob: Blob, positions: list[tuple[float, float]], reach: float | None, farthest: float
) -> float:
    """Distance of a blob from where an object may be; 1 and more is out of reach."""
    size = math.sqrt(blob.area)
    here = (blob.x, blob.y)
    if reach is None:
        return math.dist(here, positions[0]) / min(farthest, _FIRST_STEP * size)
    stays = math.dist(here, positions[0]) / (size + 1.5 * reach)
    goes = min(math.dist(here, position) for position in positions[1:]) / (size + 0.5 * reach)
    return min(stays, goes)


def unlike(one: Blob, other: Blob) -> float:
    """Difference between the looks of two blobs; 1 and more is another object."""
    larger = abs(math.log(one.area / other.area)) / _LARGER
    contrast = math.sqrt(one.contrast * other.contrast)
    colour = math.dist(one.colour, other.colour)
    return max(larger, colour / (_OFF_COLOUR * max(contrast, 1.0)))


class Linker:
    """Takes the blobs picture by picture; `paths` has all objects so far."""

    def __init__(self, width: float, height: float) -> None:
        self._farthest = float(np.hypot(width, height)) / 4
        self._ended: list[Path] = []
        self._alive: list[Path] = []

    def add(self, frame: int, blobs: list[Blob]) -> None:
        """All blobs of a picture."""
        from scipy.optimize import linear_sum_assignment

        keep = [one for one in self._alive if frame - one.frames[-1] <= _GAP]
        self._ended += [one for one in self._alive if frame - one.frames[-1] > _GAP
                        and len(one.frames) > 1]  # fmt: skip
        self._alive = keep
        free = set(range(len(blobs)))
        if keep and blobs:
            cost = np.array([p.costs(frame, blobs, self._farthest) for p in keep])
            for row, column in zip(*linear_sum_assignment(cost), strict=True):
                if cost[row, column] < _IMPOSSIBLE:
                    keep[row].add(frame, blobs[column])
                    free.remove(int(column))
        self._alive += [Path([frame], [blobs[k]]) for k in sorted(free)]

    def paths(self) -> list[Path]:
        """Objects seen twice or more, pieces of one joined, in order of their beginning."""
        pieces = sorted(
            (one for one in self._ended + self._alive if len(one.frames) > 1),
            key=lambda one: one.frames[0],
        )
        whole: list[Path] = []
        for piece in pieces:
            before = [one for one in whole if one.may_become(piece)]
            if before:
                best = min(before, key=lambda one: unlike(_typical(one), _typical(piece)))
                best.frames += piece.frames
                best.blobs += piece.blobs
            else:
                whole.append(piece)
        return whole


def _typical(path: Path) -> Blob:
    """The blob of middle area."""
    return sorted(path.blobs, key=lambda one: one.area)[len(path.blobs) // 2]
