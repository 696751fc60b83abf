"""A track: where one object was seen, frame by frame; what every way of tracking hands on."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from granulab.errors import InputError

Array = NDArray[np.float64]
Rows = NDArray[np.intp]


class Look(NamedTuple):
    """Colour of an object, and of what is behind it: blue, green, red, (3,) each [grey levels].

    grain   standard deviation of its own colour, of the difference of the two [share]
    """

    colour: Array
    behind: Array
    grain: float = 0.0


@dataclass(frozen=True)
class Track:
    """Positions of one object against time.

    frame        (n,) frame numbers, increasing; not whole where only times were written
    x, y         (n,) position [px, or m where scale is 1]
    time         (n,) time stamps [s]; None where the rate is not known
    covariance   (n, 2, 2) of x, y [the same, squared]; None where it is not known
    scale        metres per unit of x, y; None where it is not known
    name         which of several tracks of a file
    radius       (n,) of a circle of the object's area [px]; None where only positions are known
    profile      (n, k) radius of its silhouette in k directions from x to y [px]; None as radius
    look         its colour and that of its background; None where only positions are known
    camera       (n, 2) what the camera's motion added to x, y in the picture, and was taken off
    repeated     frame numbers whose picture of the object is that of the frame before
    remarks      what its reader had to assume or leave out
    """

    frame: Array
    x: Array
    y: Array
    time: Array | None = None
    covariance: Array | None = None
    scale: float | None = None
    name: str = ""
    radius: Array | None = None
    profile: Array | None = None
    look: Look | None = None
    camera: Array | None = None
    repeated: tuple[float, ...] = ()
    remarks: tuple[str, ...] = ()

    @property
    def rate(self) -> float | None:
        """Frames per second that the time stamps say; None without them."""
        if self.time is None or len(self.frame) < 2:
            return None
        return float(1 / np.median(np.diff(self.time) / np.diff(self.frame)))

    @property
    def clock(self) -> Array:
        """Time in units of one frame: stamps times their rate, else frame numbers."""
        rate = self.rate
        if rate is None or self.time is None:
            return self.frame
        return self.frame[0] + (self.time - self.time[0]) * rate

    def seen(self) -> "Track":
        """The track without the frames in which the object was not seen (NaN), in order of time.

        Raises InputError where two positions belong to one frame.
        """
        kept = np.flatnonzero(np.isfinite(self.y) & np.isfinite(self.frame))
        kept = kept[np.argsort(self.frame[kept], kind="stable")]
        twice = np.flatnonzero(np.diff(self.frame[kept]) <= 0)
        if len(twice):
            raise InputError(
                f"track {self.name!r}: frame {self.frame[kept][twice[0]]:g} stands twice; a file "
                "with several tracks needs a column that separates them, such as 'particle'"
            )
        return self.chosen(kept)

    def chosen(self, rows: Rows) -> "Track":
        """The track of these rows alone."""

        def of(values: Array | None) -> Array | None:
            return None if values is None else values[rows]

        return replace(
            self, frame=self.frame[rows], x=self.x[rows], y=self.y[rows], time=of(self.time),
            covariance=of(self.covariance), radius=of(self.radius),
            profile=of(self.profile), camera=of(self.camera),
        )  # fmt: skip


def link(frame: Array, points: list[Array]) -> list[Track]:
    """Tracks from positions that carry no name: (k, 2) points of each frame, k may change.

    A point goes on with the track whose last position, or last position moved on, is nearest, all
    pairs of a frame together. A step of more than a quarter of the picture begins another track.
    """
    from scipy.optimize import linear_sum_assignment

    everything = np.concatenate(points)
    farthest = np.hypot(*np.ptp(everything, axis=0)) / 4
    tracks: list[list[tuple[float, float, float]]] = []
    for number, found in zip(frame, points, strict=True):
        rows: list[int] = []
        free = set(range(len(found)))
        if tracks and len(found):
            cost = np.array([[_step(track, number, p) for p in found] for track in tracks])
            rows, columns = linear_sum_assignment(cost)
            for row, column in zip(rows, columns, strict=True):
                if cost[row, column] <= farthest:
                    tracks[row].append((number, *found[column]))
                    free.remove(column)
        tracks.extend([(number, *found[k])] for k in sorted(free))
    columns = [np.array(track).T for track in tracks]
    return [Track(f, x, y, name=str(k + 1)) for k, (f, x, y) in enumerate(columns)]


def _step(track: list[tuple[float, float, float]], number: float, point: Array) -> float:
    """Distance of a point from where a track was, or from where it would have moved to."""
    last = np.array(track[-1])
    positions = [last[1:]]
    if len(track) > 1:
        before = np.array(track[-2])
        positions.append(
            last[1:] + (last - before)[1:] * (number - last[0]) / (last[0] - before[0])
        )
    return float(min(np.hypot(*(point - position)) for position in positions))
