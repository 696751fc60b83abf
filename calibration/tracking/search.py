"""Objects looked for in one picture of a film after the other, and linked; the background learned.

Large pictures are reduced by a whole number: a centroid over an object is no less exact for it.
A camera's motion is believed where the pictures show it (camera_motion.shows_motion).
"""

from dataclasses import dataclass, field

import numpy as np

from calibration.tracking.background import Background, Mask, is_ghost
from calibration.tracking.blobs import Blob, Candidate, candidates, changed, measure
from calibration.tracking.camera_motion import CameraMotion, largest_shift, shows_motion
from calibration.tracking.film.reader import Picture
from calibration.tracking.linking import Linker
from calibration.tracking.track import Array

_LONGEST = 1280  # px of a picture that objects are measured in
_SEARCHED = 640  # px of a picture that they are looked for in
_DRIFT = 0.5  # px of the picture searched, from which pictures are steadied
_NEW_VIEW = 3  # frames in a row that show something else are another view
_CORNERS_FOR = 32  # frames for which the same corners show how the camera moves
_STANDS = 16  # frames for which it has stood, from which on
_SEEN_TO = 4  # it is looked at in every such frame alone
_GHOST = 3  # frames for which an object that has left its image behind stands still
_GHOST_AGAIN = 4  # frames from one look at what stands still to the next


@dataclass
class Notes:
    """Notes on each frame that was read."""

    numbers: list[int] = field(default_factory=list)
    stamps: list[float | None] = field(default_factory=list)
    motion: list[Array] = field(default_factory=list)
    junk: list[int] = field(default_factory=list)
    views: list[int] = field(default_factory=list)


class Search:
    """Looks at one picture after the other.

    clean   (height, width, 3) the background without objects, where it is known beforehand
    """

    def __init__(self, width: int, height: int, clean: Picture | None = None) -> None:
        self._reduce = -(-max(width, height) // _LONGEST)
        self._size = (width // self._reduce, height // self._reduce)
        self.scale = width / self._size[0], height / self._size[1]
        self._further = -(-max(self._size) // _SEARCHED)
        self._camera = CameraMotion()
        self._moved = np.eye(3)
        self._stood = self._frames = 0
        self._background = None if clean is None else Background(self._reduced(clean))
        self._overlapping = clean is not None
        self._before: Picture | None = None
        self._still: dict[tuple[int, int, int, int], int] = {}
        self._odd = 0
        self.linker = Linker(*self._size)

    def look(self, number: int, picture: Picture, notes: Notes) -> None:
        """Find what is in it, and learn the background."""
        picture = self._reduced(picture)
        if self._background is not None:
            picture = self._background.lit_alike(picture)
        motion = self._motion(picture)
        notes.motion.append(motion)
        picture, taken_off = self._steadied(picture, motion)
        if self._background is None:
            self._background = Background(picture)
            self._camera.look_at(self._small(picture))
            return
        difference = self._background.difference(picture)
        limit = self._background.limit()
        found = candidates(difference, limit, self._further)
        if found is None:
            self._odd_one(number, picture, notes)
            return
        self._odd = 0
        blobs = self._measured(picture, found)
        self.linker.add(number, [_moved(blob, taken_off) for blob in blobs])
        self._before = picture
        if self._background.due():
            objects = self._mask(found)
            self._background.learn(picture, difference, objects)
            if number % _CORNERS_FOR == 0:
                self._camera.look_at(self._small(self._background.picture), self._small(objects))

    def _reduced(self, picture: Picture) -> Picture:
        """The picture that objects are measured in."""
        import cv2

        if self._reduce == 1:
            return picture
        return np.asarray(cv2.resize(picture, self._size, interpolation=cv2.INTER_AREA))

    def _motion(self, picture: Picture) -> Array:
        """The camera's, in the picture measured in; looked for now and then while it stands."""
        self._frames += 1
        if self._stood >= _STANDS and self._frames % _SEEN_TO:
            return self._moved
        factor = np.diag([self._further, self._further, 1.0])
        seen = self._small(picture)
        small = self._camera.follow(seen)
        height, width = seen.shape[:2]
        moves = largest_shift(small, width, height) >= _DRIFT
        if moves and self._background is not None:
            moves = shows_motion(seen, self._small(self._background.picture), small)
        small = small if moves else np.eye(3)
        self._stood = 0 if moves else self._stood + 1
        self._moved = np.asarray(factor @ small @ np.linalg.inv(factor))
        return self._moved

    def _small(self, picture: Picture) -> Picture:
        """The picture that objects are looked for in."""
        import cv2

        if self._further == 1:
            return picture
        size = (self._size[0] // self._further, self._size[1] // self._further)
        return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA))

    def _steadied(self, picture: Picture, motion: Array) -> tuple[Picture, Array]:
        """The picture as the camera would have seen it in the first frame, and what was undone.

        What is no more than the error of the camera's motion is left in.
        """
        import cv2

        if largest_shift(motion, *self._size) < _DRIFT * self._further:
            return picture, np.eye(3)
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        steady = cv2.warpAffine(picture, motion[:2], self._size, flags=flags,
                                borderMode=cv2.BORDER_REPLICATE)  # fmt: skip
        return np.asarray(steady), motion

    def _odd_one(self, number: int, picture: Picture, notes: Notes) -> None:
        """A frame that shows something else: left out, or another view if it lasts."""
        self._odd += 1
        notes.junk.append(number)
        if self._odd >= _NEW_VIEW:
            self._background = Background(picture)
            self._camera.look_at(self._small(picture))
            notes.views.append(number)
            del notes.junk[-self._odd :]
            self._odd = 0

    def _mask(self, found: list[Candidate]) -> Mask:
        """All candidates, and what is next to them."""
        import cv2

        mask = np.zeros(self._size[::-1], np.uint8)
        for one in found:
            x, y, w, h = one.box
            mask[y : y + h, x : x + w] |= one.mask
        return np.asarray(cv2.dilate(mask, np.ones((9, 9), np.uint8)), dtype=np.uint8)

    def _measured(self, picture: Picture, found: list[Candidate]) -> list[Blob]:
        """Positions of all candidates; ghosts are passed to the background."""
        assert self._background is not None
        still, self._still = self._still, {}
        blobs = []
        for one in found:
            near = [k for k in still if np.abs(np.subtract(k, one.box)).max() <= 2 * self._further]
            lasted = 1 + max((still[k] for k in near), default=0)
            self._still[one.box] = lasted
            looked = lasted >= _GHOST and (lasted - _GHOST) % _GHOST_AGAIN == 0
            if looked and self._left_behind(picture, one):
                continue
            blob = measure(picture, self._background.picture, self._background.noise, one,
                           self._overlapping)  # fmt: skip
            if blob is None:
                continue
            new = self._before is None or changed(
                picture, self._before, self._background.noise, blob
            )
            blobs.append(blob._replace(changed=new))
        return blobs

    def _left_behind(self, picture: Picture, one: Candidate) -> bool:
        """True if it is a ghost; the background is then put right."""
        import cv2

        assert self._background is not None
        x, y, w, h = one.box
        left, top = max(x - 4, 0), max(y - 4, 0)
        cut = np.s_[top : y + h + 4, left : x + w + 4]
        here = picture[cut]
        mask = np.zeros(here.shape[:2], np.uint8)
        mask[y - top : y - top + h, x - left : x - left + w] = one.mask
        if not is_ghost(here, self._background.picture[cut], mask):
            return False
        whole = np.zeros(picture.shape[:2], np.uint8)
        whole[cut] = cv2.dilate(mask, np.ones((7, 7), np.uint8))
        self._background.replace(picture, whole)
        return True


def _moved(blob: Blob, motion: Array) -> Blob:
    """A blob of the steadied picture, where it is in the picture itself."""
    x, y, _ = motion @ [blob.x, blob.y, 1.0]
    return blob._replace(x=float(x), y=float(y))
