"""Motion of the camera since the first frame: corners of what stands still, followed.

Corners of the background are found in each picture by the pyramid of Lucas and Kanade (Bouguet
2001); the similarity (shift, rotation, zoom) that most of them agree on is the camera's, whatever
moves in front of it (RANSAC). Rotation and zoom are taken where corners all over the picture show
them beyond chance, else a shift alone.

In noise, corners that agree on some motion are always found. Before it is believed, the background
moved so must predict what each pixel differs by. The picture's own difference, regressed on that,
has slope 1 where the camera moved so and 0 where it stood; noise of the background, which is in
both, adds up to a half to it. Objects that move in front of the background are explained by
neither, and left out.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibration.tracking.film.reader import Picture
from calibration.tracking.track import Array

_CORNERS = 100
_APART = 24  # corners that fit side by side along the longer side of a picture
_FEWEST = 12  # corners that must agree: a similarity has four unknowns, objects that move have some
_SPREAD = 0.2  # standard deviation of corners all over a picture is 0.29 of its sides
_CHANCE = 1e-4  # p below which rotation and zoom are believed: one frame in ten thousand by mistake
_BACK = 0.5  # px by which a corner followed there and back may miss
_SMOOTH = 1.5  # px: texture is coarser than noise
_SLOPE = 0.75  # halfway between what noise of the background alone gives, and motion
_SIGMAS = 4.0  # by which the slope must be known
_QUIET = 3.0  # medians of the difference that something explains


class CameraMotion:
    """The similarity from positions in the background to positions in the last picture given."""

    def __init__(self) -> None:
        self._grey: Picture | None = None
        self._corners: Any = None
        self.now = np.eye(3)

    def look_at(self, background: Picture, objects: Picture | None = None) -> None:
        """Take corners from here on from this picture, where no object is (mask, 255)."""
        import cv2

        grey = _grey(background)
        apart = max(grey.shape) / _APART
        free = None if objects is None else cv2.bitwise_not(objects)
        self._corners = cv2.goodFeaturesToTrack(grey, _CORNERS, 0.005, apart, mask=free)
        self._grey = grey

    def follow(self, picture: Picture) -> Array:
        """(3, 3) from the background to this picture; as it was where too few corners are seen."""
        if self._corners is None or len(self._corners) < _FEWEST:
            return self.now
        there, good = self._found(_grey(picture))
        if good.sum() >= max(_FEWEST, len(good) / 4):
            found = _agreed(self._corners[good, 0], there[good, 0], picture.shape, self.now)
            self.now = self.now if found is None else found
        return self.now

    def _found(self, grey: Picture) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """Corners in a picture, and which of them lead back to where they came from."""
        import cv2

        flow: Any = {"winSize": (15, 15), "maxLevel": 2, "flags": cv2.OPTFLOW_USE_INITIAL_FLOW}
        stored: Any = self._grey
        guess = cv2.perspectiveTransform(self._corners, self.now).astype(np.float32)
        there: Any
        there, seen, _ = cv2.calcOpticalFlowPyrLK(stored, grey, self._corners, guess, **flow)
        back, seen_back, _ = cv2.calcOpticalFlowPyrLK(
            grey, stored, there, self._corners.copy(), **flow
        )
        miss = np.linalg.norm(back - self._corners, axis=2).ravel()
        return there, (seen.ravel() > 0) & (seen_back.ravel() > 0) & (miss < _BACK)


def _grey(picture: Picture) -> Picture:
    import cv2

    even = cv2.createCLAHE(clipLimit=4.0, tileGridSize=(8, 8))  # dark parts have corners, too
    return np.asarray(even.apply(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)), dtype=np.uint8)


def _agreed(
    corners: NDArray[np.float32], there: NDArray[np.float32], shape: tuple[int, ...], before: Array
) -> Array | None:
    """Motion on which most corners agree; None where too few do.

    Rotation and zoom stay as before where the corners that agree do not lie all over the picture.
    """
    import cv2

    cv2.setRNGSeed(1)
    matrix, inside = cv2.estimateAffinePartial2D(corners, there, ransacReprojThreshold=_BACK)
    if matrix is None or inside.sum() < _FEWEST:
        return None
    agreed = inside.ravel() > 0
    corners, there = corners[agreed], there[agreed]
    shift = before[:2].copy()
    shift[:, 2] = np.median(there - corners @ before[:2, :2].T, axis=0)
    spread = corners.std(axis=0) / [shape[1], shape[0]]
    if spread.min() < _SPREAD or not _better(
        corners, there, np.asarray(matrix, dtype=float), shift
    ):
        matrix = shift
    return np.vstack([matrix, [0, 0, 1]])


def _better(
    corners: NDArray[np.float32], there: NDArray[np.float32], matrix: Array, shift: Array
) -> bool:
    """True if a new rotation and zoom, two more numbers, explain more than chance (F test)."""
    from scipy.special import fdtrc

    by_both, by_shift = (
        float(np.sum((there - corners @ one[:, :2].T - one[:, 2]) ** 2)) for one in (matrix, shift)
    )
    if by_both == 0:  # the same picture again
        return by_shift > 0
    freedom = 2 * len(corners) - 4
    gain = (by_shift - by_both) / 2 / (by_both / freedom)
    return float(fdtrc(2, freedom, gain)) < _CHANCE


def shows_motion(picture: Picture, background: Picture, motion: Array) -> bool:
    """True if `motion` (3, 3), from background to picture, explains how they differ."""
    import cv2

    seen, stood = (
        cv2.GaussianBlur(cv2.cvtColor(one, cv2.COLOR_BGR2GRAY).astype(np.float32), (0, 0), _SMOOTH)
        for one in (picture, background)
    )
    size = (seen.shape[1], seen.shape[0])
    moved = cv2.warpAffine(stood, motion[:2], size, borderMode=cv2.BORDER_REPLICATE)
    still, left = np.abs(seen - stood), np.abs(seen - moved)
    explained = np.minimum(still, left)
    quiet = explained <= _QUIET * float(np.median(explained))
    by = (moved - stood)[quiet]
    power = float(by @ by)
    if power == 0:
        return False
    difference = (seen - stood)[quiet]
    slope = float(by @ difference) / power
    variance = float(np.mean((difference - slope * by) ** 2)) * 4 * np.pi * _SMOOTH**2
    return slope > _SLOPE and slope > _SIGMAS * np.sqrt(variance / power)


def largest_shift(motion: Array, width: float, height: float) -> float:
    """Largest shift of a picture's corners [px]; motion (..., 3, 3)."""
    ends = np.array([[0, 0, 1], [width, 0, 1], [0, height, 1], [width, height, 1]], dtype=float)
    moved = (motion @ ends.T)[..., :2, :] - ends.T[:2]
    return float(np.hypot(moved[..., 0, :], moved[..., 1, :]).max())


def lasting_motion(
    motion: Array, width: float, height: float, least: float, shown: NDArray[np.bool_] | None = None
) -> tuple[Array | None, str]:
    """The motion (n, 3, 3) of a camera that moves by `least` px, else None; what is said of it.

    shown: (n,) the frames that show their motion; None: all
    """
    from scipy.ndimage import median_filter

    seen = motion if shown is None else np.where(shown[:, None, None], motion, np.eye(3))
    lasting = median_filter(seen, size=(5, 1, 1), mode="nearest")  # not a frame's noise
    farthest = largest_shift(lasting, width, height)
    if farthest < least:
        return None, ""
    return motion, f"the camera moves by up to {farthest:.1f} px: taken off"


def offsets(motion: Array, x: Array, y: Array) -> Array:
    """(n, 2) how far motion (n, 3, 3) took positions (n,) from where the first frame has them."""
    there = np.stack([x, y, np.ones_like(x)], axis=1)
    first = np.einsum("nij,nj->ni", np.linalg.inv(motion), there)
    return np.asarray(there[:, :2] - first[:, :2])


def scaled(motion: Array, across: float, down: float) -> Array:
    """The motion (n, 3, 3) of a picture in one whose pixels are so many times as small."""
    larger = np.array([[across, 0, (across - 1) / 2], [0, down, (down - 1) / 2], [0, 0, 1]])
    return larger @ motion @ np.linalg.inv(larger)
