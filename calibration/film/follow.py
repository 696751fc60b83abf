"""Things that move in a film, followed from frame to frame: a track for each.

One pass; what is kept of a frame is where things are in it. What differs from the background is a
blob (see background.py, blobs.py), blobs are linked to things (linking.py), the camera's own motion
is taken off (camera_motion.py), time comes from stamps that can be believed (stamps.py). Large
pictures are reduced by a whole number: a centroid over a thing is no less exact for it.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from calibration.film.background import Background, Mask, is_ghost
from calibration.film.blobs import Blob, Candidate, candidates, changed, measure
from calibration.film.camera_motion import CameraMotion, largest_shift
from calibration.film.linking import Linker, Path
from calibration.film.reader import Film, Picture
from calibration.film.stamps import clean_stamps
from calibration.track import Array, Track
from contact.quantity import InputError

Told = Callable[[float, str], None]  # share done, words

_LONGEST = 1280  # px of a picture that things are measured in
_SEARCHED = 640  # px of a picture that they are looked for in
_DRIFT = 0.5  # px of the picture searched, from which pictures are steadied
_MOVES = 1.0  # px of the picture measured in, from which the camera's motion is taken off
_NEW_VIEW = 3  # frames in a row that show something else are another view
_CORNERS_FOR = 32  # frames for which the same corners show how the camera moves
_STANDS = 16  # frames for which it has stood, from which on
_SEEN_TO = 4  # it is looked at in every such frame alone
_GHOST = 3  # frames for which a thing that has left its image behind stands still
_POINTED = 3  # own radii by which a hint may miss a thing
_FEWEST = 8  # positions of a track


class Region(NamedTuple):
    """Part of the picture [px]."""

    x: int
    y: int
    width: int
    height: int


class Hint(NamedTuple):
    """Where a thing is in some frame [px]."""

    frame: float
    x: float
    y: float


@dataclass
class Notes:
    """What is kept of each frame that was read."""

    numbers: list[int] = field(default_factory=list)
    stamps: list[float | None] = field(default_factory=list)
    motion: list[Array] = field(default_factory=list)
    junk: list[int] = field(default_factory=list)
    views: list[int] = field(default_factory=list)


def follow(
    film: Film,
    *,
    roi: Region | tuple[int, int, int, int] | None = None,
    hint: Hint | tuple[float, float, float] | None = None,
    progress: Told | None = None,
) -> list[Track]:
    """Tracks of all things that move as wholes, that which went farthest first.

    roi       x, y, width, height of the part of the picture to look at [px]
    hint      frame, x, y of the thing wanted: its track alone
    progress  told the share done and a few words

    x, y are in pixels of the film, y downwards, the centre of the first pixel is 0, 0; where the
    camera moves they are places in its first frame. Raises InputError where nothing moves.
    """
    region = inside(film, roi)
    notes = Notes()
    search = _Search(region.width, region.height)
    for frame in film.frames():
        picture = frame.picture[
            region.y : region.y + region.height, region.x : region.x + region.width
        ]
        search.look(frame.number, picture, notes)
        notes.numbers.append(frame.number)
        notes.stamps.append(frame.stamp)
        if progress is not None and film.count:
            progress(frame.number / film.count, f"frame {frame.number} of {film.count}")
    tracks = _tracks(film, search, notes, region)
    if not tracks:
        raise InputError(f"{film.path}: nothing moves in {len(notes.numbers)} frames")
    return [_nearest(film, tracks, Hint(*hint))] if hint is not None else tracks


def inside(film: Film, roi: Region | tuple[int, int, int, int] | None) -> Region:
    """The region, checked to lie in the picture and to have a size."""
    if roi is None:
        return Region(0, 0, film.width, film.height)
    one = Region(*roi)
    if one.x < 0 or one.y < 0 or one.width < 16 or one.height < 16 or (
        one.x + one.width > film.width or one.y + one.height > film.height
    ):  # fmt: skip
        raise InputError(
            f"--roi {','.join(map(str, one))}: x,y,width,height, 16 px and more, within "
            f"{film.width} x {film.height} px"
        )
    return one


class _Search:
    """Looks at one picture after the other."""

    def __init__(self, width: int, height: int) -> None:
        self._reduce = -(-max(width, height) // _LONGEST)
        self._size = (width // self._reduce, height // self._reduce)
        self.scale = width / self._size[0], height / self._size[1]
        self._further = -(-max(self._size) // _SEARCHED)
        self._camera = CameraMotion()
        self._moved = np.eye(3)
        self._stood = self._frames = 0
        self._background: Background | None = None
        self._before: Picture | None = None
        self._still: dict[tuple[int, int, int, int], int] = {}
        self._odd = 0
        self.linker = Linker(*self._size)

    def look(self, number: int, picture: Picture, notes: Notes) -> None:
        """Find what is in it, and learn the background."""
        import cv2

        if self._reduce > 1:
            picture = np.asarray(cv2.resize(picture, self._size, interpolation=cv2.INTER_AREA))
        motion = self._motion(picture)
        notes.motion.append(motion)
        picture = self._steadied(picture, motion)
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
        self.linker.add(number, [_moved(blob, motion) for blob in blobs])
        self._before = picture
        if self._background.due():
            things = self._mask(found)
            self._background.learn(picture, difference, things)
            if number % _CORNERS_FOR == 0:
                self._camera.look_at(self._small(self._background.picture), self._small(things))

    def _motion(self, picture: Picture) -> Array:
        """The camera's, in the picture measured in; looked for now and then while it stands."""
        self._frames += 1
        if self._stood >= _STANDS and self._frames % _SEEN_TO:
            return self._moved
        factor = np.diag([self._further, self._further, 1.0])
        small = self._camera.follow(self._small(picture))
        height, width = (length / self._further for length in picture.shape[:2])
        self._stood = self._stood + 1 if largest_shift(small, width, height) < _DRIFT else 0
        self._moved = np.asarray(factor @ small @ np.linalg.inv(factor))
        return self._moved

    def _small(self, picture: Picture) -> Picture:
        """The picture that things are looked for in."""
        import cv2

        if self._further == 1:
            return picture
        size = (self._size[0] // self._further, self._size[1] // self._further)
        return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA))

    def _steadied(self, picture: Picture, motion: Array) -> Picture:
        """The picture as the camera would have seen it in the first frame."""
        import cv2

        if largest_shift(motion, *self._size) < _DRIFT * self._further:
            return picture
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        return np.asarray(
            cv2.warpAffine(picture, motion[:2], self._size, flags=flags,
                           borderMode=cv2.BORDER_REPLICATE)
        )  # fmt: skip

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
        """Places of all candidates; ghosts are told to the background."""
        assert self._background is not None
        still, self._still = self._still, {}
        blobs = []
        for one in found:
            near = [k for k in still if np.abs(np.subtract(k, one.box)).max() <= 2 * self._further]
            lasted = 1 + max((still[k] for k in near), default=0)
            self._still[one.box] = lasted
            if lasted >= _GHOST and self._left_behind(picture, one):
                continue
            blob = measure(picture, self._background.picture, self._background.noise, one)
            if blob is None:
                continue
            new = self._before is None or changed(
                picture, self._before, self._background.noise, blob
            )
            blobs.append(blob._replace(changed=new))
        return blobs

    def _left_behind(self, picture: Picture, one: Candidate) -> bool:
        """Whether it is a ghost; the background is then put right."""
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


def _tracks(film: Film, search: _Search, notes: Notes, region: Region) -> list[Track]:
    time, remarks = clean_stamps(notes.numbers, notes.stamps, film.rate)
    motion, remark = _camera(notes, search.scale, region)
    remarks += [*film_remarks(film, notes), *([remark] if remark else [])]
    moving = sorted(
        (one for one in search.linker.paths() if one.is_smooth()),
        key=lambda one: -one.length,
    )
    row = {number: k for k, number in enumerate(notes.numbers)}
    tracks: list[Track] = []
    for path in moving:
        track = _track(path, search.scale, region)
        if len(track.frame) < _FEWEST:
            continue
        at = np.array([row[int(n)] for n in track.frame], dtype=int)
        offset = _offsets(motion[at], track) if motion is not None else None
        tracks.append(
            Track(
                track.frame, track.x if offset is None else track.x - offset[:, 0],
                track.y if offset is None else track.y - offset[:, 1],
                None if time is None else time[at], track.covariance, None,
                str(len(tracks) + 1), track.radius, offset, track.repeated, tuple(remarks),
            )
        )  # fmt: skip
    return tracks


def _track(path: Path, scale: tuple[float, float], region: Region) -> Track:
    """In pixels of the film, without positions in which the thing was not whole."""
    area = np.array([one.area for one in path.blobs])
    kept = np.flatnonzero(_usual(area) & [one.whole for one in path.blobs])
    blobs = [path.blobs[k] for k in kept]
    fx, fy = scale
    x = np.array([region.x + (one.x + 0.5) * fx - 0.5 for one in blobs])
    y = np.array([region.y + (one.y + 0.5) * fy - 0.5 for one in blobs])
    covariance = np.array(
        [[[one.xx * fx**2, one.xy * fx * fy], [one.xy * fx * fy, one.yy * fy**2]] for one in blobs]
    ).reshape(-1, 2, 2)
    radius = np.sqrt(area[kept] * fx * fy / np.pi)
    frame = np.array([path.frames[k] for k in kept], dtype=float)
    repeated = tuple(float(path.frames[k]) for k in kept if not path.blobs[k].changed)
    return Track(frame, x, y, None, covariance, radius=radius, repeated=repeated)


def _usual(area: Array) -> np.ndarray:
    """Whether each area is near those around it: else two things are one blob, or one is cut."""
    from scipy.ndimage import median_filter

    off = np.abs(np.log(area / median_filter(area, size=min(31, len(area)), mode="nearest")))
    return np.asarray(off < max(np.log(1.25), 5 * float(np.median(off))))


def _camera(notes: Notes, scale: tuple[float, float], region: Region) -> tuple[Array | None, str]:
    """(n, 3, 3) the camera's motion in pixels of the region where it moves; and what is said."""
    from scipy.ndimage import median_filter

    motion = np.array(notes.motion)
    to_film = np.array([[scale[0], 0, (scale[0] - 1) / 2], [0, scale[1], (scale[1] - 1) / 2],
                        [0, 0, 1]])  # fmt: skip
    motion = to_film @ motion @ np.linalg.inv(to_film)
    lasting = median_filter(motion, size=(5, 1, 1), mode="nearest")  # not a frame's noise
    farthest = largest_shift(lasting, region.width, region.height)
    if farthest < _MOVES * scale[0]:
        return None, ""
    return motion, f"the camera moves by up to {farthest:.1f} px: taken off"


def _offsets(motion: Array, track: Track) -> Array:
    """(n, 2) how far the camera's motion moved each place from where the first frame has it."""
    there = np.stack([track.x, track.y, np.ones_like(track.x)], axis=1)
    first = np.einsum("nij,nj->ni", np.linalg.inv(motion), there)
    return np.asarray(there[:, :2] - first[:, :2])


def film_remarks(film: Film, notes: Notes) -> list[str]:
    """What was wrong with the file."""
    remarks = []
    read = len(notes.numbers)
    if film.corrupt:
        remarks.append(f"{len(film.corrupt)} frames cannot be decoded: left out")
    if notes.junk:
        remarks.append(f"{len(notes.junk)} frames show something else: left out")
    if notes.views:
        remarks.append(f"the view changes at frame {', '.join(map(str, notes.views))}")
    if film.count > read + len(film.corrupt):
        remarks.append(
            f"the header says {film.count} frames, {read} can be read: damaged or cut off"
        )
    return remarks


def _nearest(film: Film, tracks: list[Track], hint: Hint) -> Track:
    """The track that the hint points at."""

    def off(track: Track) -> float:
        """In radii; before it moves a thing is where its track begins."""
        k = int(np.argmin(np.abs(track.frame - hint.frame)))
        late = max(hint.frame - float(track.frame[k]), 0.0)
        assert track.radius is not None
        away = np.hypot(track.x[k] - hint.x, track.y[k] - hint.y)
        return float(away / track.radius[k]) + late

    best = min(tracks, key=off)
    if off(best) > _POINTED:
        raise InputError(
            f"{film.path}: nothing that moves is near x = {hint.x:g}, y = {hint.y:g} px in frame "
            f"{hint.frame:g}"
        )
    return best
