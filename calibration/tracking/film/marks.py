"""What a drop test measured, drawn into a frame of its film: thing, path, plate, contacts."""

from typing import NamedTuple

import numpy as np

from calibration.drop.result import Drop
from calibration.tracking.film.reader import Frame
from calibration.tracking.track import Array
from granulab.campaign.output.figure import BLUE, ORANGE, PAPER, VERMILION
from granulab.campaign.output.film import Image, rgb

_SHIFT = 4  # OpenCV takes places in sixteenths of a pixel
_TRAIL = 15  # positions of late
_RADIUS = 8.0  # px, of a circle around a thing whose size is not known


class Still(NamedTuple):
    """A frame with its marks; width and height are those of the film [px]."""

    number: int
    width: int
    height: int
    image: Image


class Marks:
    """The same for all frames: places in the film, and how much larger it is shown.

    zoom            pixels shown for one of the film
    width, height   of the pictures drawn [px]
    contact_frames  (n,) frame number of each contact
    """

    def __init__(self, drop: Drop, width: int, height: int, widest: int, highest: int) -> None:
        self.zoom = min(widest / width, highest / height)
        self.width, self.height = round(self.zoom * width), round(self.zoom * height)
        found, track = drop.bounces, drop.bounces.track
        self.frames, self.x, self.y = track.frame, track.x, track.y
        n = len(track.frame)
        self.radius = np.full(n, _RADIUS) if track.radius is None else track.radius
        self.camera = np.zeros((n, 2)) if track.camera is None else track.camera
        self.contact_frames = np.array([drop.frame(t) for t in found.contacts[:, 0]])
        self.plate = found.plate[:, 0]
        self._base = track.frame[found.base.rows], found.base.clock

    def clock(self, number: int) -> float:
        """Time of a frame on the clock of the flights; steady beyond them [frames]."""
        frames, clock = self._base
        beyond = min(number - frames[0], 0) + max(number - frames[-1], 0)
        return float(np.interp(number, frames, clock) + beyond)

    def draw(self, frame: Frame) -> Image:
        """The frame, red green blue, with the marks of what is known at it."""
        import cv2

        area = cv2.INTER_AREA if self.zoom < 1 else cv2.INTER_LINEAR
        size = (self.width, self.height)
        shown = cv2.cvtColor(cv2.resize(frame.picture, size, interpolation=area), cv2.COLOR_BGR2RGB)
        image = np.asarray(shown, dtype=np.uint8)
        moved = np.array([np.interp(frame.number, self.frames, c) for c in self.camera.T])
        self._draw_plate(image, frame.number, moved)
        self._draw_track(image, frame.number, moved)
        return image

    def _draw_track(self, image: Image, number: int, moved: Array) -> None:
        """The path of late, and a circle around the thing where it was seen in this frame."""
        import cv2

        last = int(np.searchsorted(self.frames, number, side="right"))
        late = np.arange(max(last - _TRAIL, 0), last)
        if len(late) == 0 or number - self.frames[late[-1]] > _TRAIL:
            return
        path = self._shown(self.x[late] + moved[0], self.y[late] + moved[1])
        cv2.polylines(image, [path], False, rgb(BLUE), 1, cv2.LINE_AA, _SHIFT)
        for place in path:
            cv2.circle(image, place, 1 << _SHIFT, rgb(BLUE), -1, cv2.LINE_AA, _SHIFT)
        if self.frames[late[-1]] == number:
            radius = round((self.radius[late[-1]] * self.zoom + 3) * 2**_SHIFT)
            for colour, wide in ((PAPER, 4), (VERMILION, 2)):  # seen on things of any colour
                cv2.circle(image, path[-1], radius, rgb(colour), wide, cv2.LINE_AA, _SHIFT)

    def _draw_plate(self, image: Image, number: int, moved: Array) -> None:
        """The plate's level under the thing, and a tick at each contact that has happened."""
        import cv2

        under = np.interp(self.contact_frames, self.frames, self.radius)
        level = np.interp(number, self.contact_frames, self.plate + under) + moved[1]
        ends = self._shown(np.array([0, image.shape[1] / self.zoom]), np.array([level, level]))
        cv2.line(image, ends[0], ends[1], rgb(ORANGE), 1, cv2.LINE_AA, _SHIFT)
        past = self.contact_frames <= number
        x = np.interp(self.contact_frames, self.frames, self.x)[past] + moved[0]
        y = (self.plate + under)[past] + moved[1]
        for place in self._shown(x, y):
            centre = (int(place[0]) >> _SHIFT, int(place[1]) >> _SHIFT)
            cv2.drawMarker(image, centre, rgb(ORANGE), cv2.MARKER_TRIANGLE_UP, 12, 2, cv2.LINE_AA)

    def _shown(self, x: Array, y: Array) -> np.ndarray:
        """(n, 2) places of the film in the picture drawn, in sixteenths of a pixel."""
        places = (np.stack([x, y], axis=1) + 0.5) * self.zoom - 0.5
        return np.rint(np.clip(places, -1e4, 1e4) * 2**_SHIFT).astype(np.int32)
