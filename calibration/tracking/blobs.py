"""Positions of objects in one picture, to a fraction of a pixel, from how it differs from the rest.

A pixel that shows a share a of an object and 1 - a of the background has the colour
a F + (1 - a) B. a = (I - B).(F - B)/|F - B|^2 (Smith and Blinn 1996, doi 10.1145/237170.237263), F
the object's own colour, is 1 inside, falls to 0 over the edge, or over the blur of motion, alike on
either side: its centroid is the position of the object at the middle of the exposure. Shadows and
reflections have small a and are cut off below a quarter. Where the object's own shadow lies behind
its rim, a pixel shows a F + c B, c less than 1 - a: solved for both where F is no darker B, or a
rim blurred by motion counts for more on the side of the shadow. Shade on the object itself makes a
less, too, but not at its rim alone: a counts against the most that is seen within a few pixels.
Connected parts are found by their outlines, which cost far less than a label for each pixel.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibration.tracking.background import Mask
from calibration.tracking.film.reader import Picture

Outline = NDArray[np.int32]  # (n, 1, 2) x, y of pixels
_LOW, _HIGH = 0.25, 0.75  # share of an object from and to which a pixel counts in part
_NEW = 1.13  # mean difference of two normal deviates, in their sigma
_UNEVEN = 0.1  # sigma of an edge pixel's share from shading and what lies behind the edge
_AROUND = (7, 7)  # px that show an object's colour next to a pixel: the rim and three within
_WHOLLY = 8  # power of the share: a pixel of half the object counts 1 in 256
# Of |B|, from which F differs in hue from B: a shadow that leaves half of the light, tinted by a
# twentieth, then shows as no more than 0.025/0.1 = _LOW of an object.
_HUE = 0.1
_DARK = 0.1  # of the light, that a shadow takes at least; of what is around, that it covers
_OTHER = 0.2  # of the contrast, by which a mixture of two colours may miss a pixel's
_SHADED = 0.6  # share to which shade may bring the inside of an object: shadows have less
CUT = 0.4  # share of a picture that differs: another view, or a frame that is no picture
LARGEST = 0.2  # share of the picture: an object and the position it left are half of CUT
_FEWEST = 3  # pixels of the difference that make an object
_MOST = 6  # objects in one picture: the strongest
_ACROSS = 80  # px of an object's window; larger ones are reduced, their position is no less known
_THIN = 0.5  # of the half thickness of an object: what is thinner hangs on it (strings, fingers)
_LONG = 1.1  # widths of its base that a corner of an object may be long
_NEXT_TO: Mask = np.ones((3, 3), np.uint8)  # a pixel and those around it
_NEXT = 1.5  # px to the next pixel, straight on or across
_DIRECTIONS = 96  # in which a silhouette's radius is measured: every 2.6 px of the largest window
Channels = NDArray[np.float32]
_SUM: Channels = np.ones((1, 3), np.float32)


def outlines(mask: Mask) -> list[Outline]:
    """Outer outlines of all connected parts."""
    import cv2

    found: Any = cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    around, tree = found
    return [one for k, one in enumerate(around) if tree[0, k, 3] < 0]  # the rest are holes


def pixels_within(outline: Outline) -> float:
    """Number of pixels that an outline of two and more encloses with its own (Pick's theorem)."""
    import cv2

    return cv2.contourArea(outline) + len(outline) / 2 + 1


def filled(outline: Outline, box: tuple[int, int, int, int]) -> Mask:
    """(height, width) of the box x, y, width, height; 255 within the outline."""
    import cv2

    x, y, w, h = box
    mask = np.zeros((h, w), np.uint8)
    return np.asarray(cv2.drawContours(mask, [outline], -1, 255, cv2.FILLED, offset=(-x, -y)))


def largest(mask: Mask) -> Mask | None:
    """The largest connected part, filled; None where there is nothing."""
    around = outlines(mask)
    if not around:
        return None
    height, width = mask.shape
    return filled(max(around, key=pixels_within), (0, 0, width, height))


class Blob(NamedTuple):
    """An object in one picture; lengths in pixels of that picture.

    x, y       centroid
    xx, xy, yy covariance of the centroid from the noise of the pixels and the edge's shading
    area       sum of the shares
    colour     (3,) of its core, blue, green, red
    behind     (3,) colour of the background there
    contrast   difference of the two [grey levels]
    whole      False where it touches the edge of the picture
    box        x, y, width, height
    changed    whether the picture there is another than that of the frame before
    grain      standard deviation of the share within it: shade, stripes, marks
    profile    (_DIRECTIONS,) radius of the silhouette about the centroid, from x towards y [px]
    shadow     what is added to x, y where a shadow of the object lies behind its rim
    """

    x: float
    y: float
    xx: float
    xy: float
    yy: float
    area: float
    colour: NDArray[np.float64]
    behind: NDArray[np.float64]
    contrast: float
    whole: bool
    box: tuple[int, int, int, int]
    changed: bool = True
    grain: float = 0.0
    profile: Channels | None = None
    shadow: tuple[float, float] = (0.0, 0.0)


class Candidate(NamedTuple):
    """Connected pixels that differ from the background.

    box    x, y, width, height in the picture
    strength   sum of the difference
    mask   (height, width) of the box
    """

    box: tuple[int, int, int, int]
    strength: float
    mask: Mask


def candidates(difference: Picture, limit: Picture, reduce: int) -> list[Candidate] | None:
    """Objects that differ, the strongest first; None where the picture shows something else.

    They are looked for in the picture reduced by a whole number, in which noise is less.
    """
    import cv2

    height, width = difference.shape
    size = (width // reduce, height // reduce)
    if reduce > 1:
        difference, limit = (
            np.asarray(cv2.resize(one, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
            for one in (difference, limit)
        )
    mask: Mask = np.asarray(cv2.compare(difference, limit, cv2.CMP_GT), dtype=np.uint8)
    if cv2.countNonZero(mask) > CUT * mask.size:
        return None
    closed = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    mask = np.asarray(closed, dtype=np.uint8)
    around = [one for one in outlines(mask) if len(one) >= _FEWEST]
    around.sort(key=pixels_within, reverse=True)
    parts = [_part_of(difference, mask, outline) for outline in around[: 2 * _MOST]]
    parts.sort(key=lambda one: -one.strength)
    return [_enlarged(one, reduce) for one in parts[:_MOST]]


def _part_of(difference: Picture, mask: Mask, outline: Outline) -> Candidate:
    """The part of a mask that has this outline."""
    import cv2

    x, y, w, h = cv2.boundingRect(outline)
    cut = np.s_[y : y + h, x : x + w]
    inside = mask[cut] & filled(outline, (x, y, w, h))
    strength = cv2.sumElems(difference[cut] & inside)[0]
    return Candidate((x, y, w, h), strength, inside)


def _enlarged(one: Candidate, factor: int) -> Candidate:
    """In the picture that is larger by a whole number."""
    import cv2

    if factor == 1:
        return one
    x, y, w, h = (factor * value for value in one.box)
    mask = cv2.resize(one.mask, (w, h), interpolation=cv2.INTER_NEAREST)
    return Candidate((x, y, w, h), one.strength, np.asarray(mask, dtype=np.uint8))


def measure(
    picture: Picture, background: Picture, noise: float, one: Candidate, overlapping: bool = False
) -> Blob | None:
    """A candidate's position; None where it has no core, or is too large to be one object.

    overlapping   the background is known behind all of it: it may be as large as what differs, and
                  its grain, next to nothing else that could be taken for it, is no shadow
    """
    import cv2

    height, width = picture.shape[:2]
    largest_share = CUT if overlapping else LARGEST
    if cv2.countNonZero(one.mask) > largest_share * width * height:
        return None
    (left, top), reduce, seen, behind, mask = _window(picture, background, one)
    noise = noise / reduce
    share, (colour, beneath), contrast, square = _shares(seen, behind, mask, noise)
    if share is None:
        return None
    lit = _out_of_shadow(share, seen, behind, colour, noise, contrast)
    share = _of_what_is_near(share)
    body = _body(share, mask)
    if body is None:
        return None
    box = _box(body, left, top, reduce)
    if reduce > 1 and 2 * max(box[2:]) < max(one.box[2:]):  # what hung on it made the window large
        part = _part(one, box)
        return None if part is None else measure(picture, background, noise, part, overlapping)
    within = share[cv2.erode(body, _NEXT_TO, iterations=2) > 0]
    grain = float(within.std()) if len(within) else _UNEVEN
    if overlapping:
        share = _of_local_colour(seen, behind, share, body, noise)
    weight = _weight(share, body)
    area, cx, cy = _centroid(weight)
    if area < 1:
        return None
    shadow = _shadow(lit, mask, (area, cx, cy))
    ys, xs = np.nonzero((weight > 0) & (weight < 1))
    edge = np.hypot(noise / np.sqrt(square[ys, xs]), _UNEVEN) / (_HIGH - _LOW)
    lever = np.stack([xs - cx, ys - cy]) * edge / area
    (xx, xy), (_, yy) = (lever @ lever.T * reduce**2).tolist()
    # Edges that show no pixel in between (drawn pictures) leave a position that is rounded to whole
    # pixels: evenly likely within one.
    xx, yy = (value or reduce**2 / 12 for value in (xx, yy))
    inside = box[0] > 0 and box[1] > 0 and box[0] + box[2] < width and box[1] + box[3] < height
    return Blob(
        left + (cx + 0.5) * reduce - 0.5, top + (cy + 0.5) * reduce - 0.5, xx, xy, yy,
        area * reduce**2, colour, beneath, contrast, inside, box, grain=grain,
        shadow=(reduce * shadow[0], reduce * shadow[1]),
        profile=_profile(weight, cx, cy) * np.float32(reduce),
    )  # fmt: skip


def _window(
    picture: Picture, background: Picture, one: Candidate
) -> tuple[tuple[int, int], int, Picture, Picture, Mask]:
    """First column and row about a candidate, its reduction; picture, background, mask there."""
    import cv2

    height, width = picture.shape[:2]
    x, y, w, h = one.box
    margin = 3 + max(w, h) // 8
    left, top = max(x - margin, 0), max(y - margin, 0)
    right, bottom = min(x + w + margin, width), min(y + h + margin, height)
    cut = np.s_[top:bottom, left:right]
    reduce = -(-max(right - left, bottom - top) // _ACROSS)
    mask = np.zeros((bottom - top, right - left), np.uint8)
    mask[y - top : y - top + h, x - left : x - left + w] = one.mask[: bottom - y, : right - x]
    seen, behind = (
        _reduced(part, reduce, cv2.INTER_AREA) for part in (picture[cut], background[cut])
    )
    return (left, top), reduce, seen, behind, _reduced(mask, reduce, cv2.INTER_NEAREST)


def _shadow(
    lit: Channels | None, mask: Mask, as_seen: tuple[float, float, float]
) -> tuple[float, float]:
    """Way of the centroid where a shadow behind the rim is taken off; none where there is none."""
    if lit is None:
        return 0.0, 0.0
    lit = _of_what_is_near(lit)
    own = _body(lit, mask)
    if own is None:
        return 0.0, 0.0
    area, x, y = _centroid(_weight(lit, own))
    return (x - as_seen[1], y - as_seen[2]) if area > as_seen[0] / 2 else (0.0, 0.0)


def _profile(weight: Channels, x: float, y: float) -> Channels:
    """(_DIRECTIONS,) radius about x, y of as much of the shares as lies in each direction.

    Half its square is the integral of share times radius: it needs no limit of what is object, and
    where the shape is seen from x, y as a whole it is the outline's.
    """
    import cv2

    height, width = weight.shape
    reach = np.hypot(max(x, width - 1 - x), max(y, height - 1 - y))
    samples = int(2 * reach)
    flags = cv2.WARP_POLAR_LINEAR | cv2.WARP_FILL_OUTLIERS | cv2.INTER_LINEAR
    rays = cv2.warpPolar(weight, (samples, _DIRECTIONS), (x, y), reach, flags)
    step = reach / samples
    radii = np.arange(samples, dtype=np.float32) * np.float32(step)
    return np.asarray(np.sqrt(2 * step * (rays @ radii)), dtype=np.float32)


def _weight(share: Channels, body: Mask) -> Channels:
    """Of each pixel in the position: from 0 outside an object to 1 within."""
    import cv2

    kernel = np.ones((3, 3), np.uint8)
    weight = np.clip((share - _LOW) / (_HIGH - _LOW), 0, 1)
    weight[cv2.dilate(body, kernel, iterations=2) == 0] = 0.0
    weight[cv2.erode(body, kernel, iterations=2) > 0] = 1.0  # marks and highlights
    return weight


def _centroid(weight: Channels) -> tuple[float, float, float]:
    """Sum of the weights, and x, y of their centroid."""
    import cv2

    sums = cv2.moments(weight)
    area = max(sums["m00"], 1e-9)
    return sums["m00"], sums["m10"] / area, sums["m01"] / area


def changed(picture: Picture, before: Picture, noise: float, blob: Blob) -> bool:
    """True if an object's picture is another than in the frame before, by more than noise.

    Half of the object's rim is new where it moves: a repeated picture, coded again, differs less.
    """
    import cv2

    x, y, w, h = (max(value, 0) for value in blob.box)
    cut = np.s_[y : y + h, x : x + w]
    here = picture[cut]
    return cv2.norm(here, before[cut], cv2.NORM_L1) > _NEW * noise * here.size


def _part(one: Candidate, box: tuple[int, int, int, int]) -> Candidate | None:
    """The part of a candidate that lies in a box; None where none does."""
    left, top = (max(box[i], one.box[i]) for i in (0, 1))
    right, bottom = (min(k[i] + k[i + 2] for k in (box, one.box)) for i in (0, 1))
    if right <= left or bottom <= top:
        return None
    x, y = left - one.box[0], top - one.box[1]
    mask = one.mask[y : y + bottom - top, x : x + right - left]
    return Candidate((left, top, right - left, bottom - top), one.strength, mask)


def _reduced(part: Picture, reduce: int, how: int) -> Picture:
    import cv2

    if reduce == 1:
        return part
    height, width = (length // reduce for length in part.shape[:2])
    whole = part[: height * reduce, : width * reduce]
    return np.asarray(cv2.resize(whole, (width, height), interpolation=how), dtype=np.uint8)


def _shares(
    seen: Picture, behind: Picture, mask: Mask, noise: float
) -> tuple[
    Channels | None, tuple[NDArray[np.float64], NDArray[np.float64]], float, Channels
]:  # fmt: skip
    """Share of the object in each pixel, colours of it and behind it, contrast, square of that.

    The colour is that of the pixels that differ nearly as much as any: a shadow differs less.
    Of an object of several colours other parts count by how much they differ. Where the background
    has nearly the object's colour the share is not known, and taken as zero.
    """
    behind_it = behind.astype(np.float32)
    away = seen - behind_it
    size = np.sqrt(_dot(away, away))
    inside = mask > 127
    nothing = np.zeros(3)
    if np.count_nonzero(inside) < 2:
        return None, (nothing, nothing), 0.0, size
    core = np.flatnonzero(inside & (size >= 0.6 * _near_largest(size[inside])))
    colour, beneath = (_median(one.reshape(-1, 3)[core]).astype(float) for one in (seen, behind))
    towards = colour.astype(np.float32) - behind_it
    square = _dot(towards, towards)
    contrast = float(np.sqrt(_median(square.ravel()[core])))
    least = (4 * noise) ** 2
    known = square > least
    np.maximum(square, least, out=square)
    share = _dot(away, towards) / square * known
    np.maximum(share, size / max(contrast, np.sqrt(least)), out=share)  # objects of several colours
    return share, (colour, beneath), contrast, square


def _out_of_shadow(
    share: Channels, seen: Picture, behind_it: Picture, its: NDArray[np.float64], noise: float,
    contrast: float,
) -> Channels | None:  # fmt: skip
    """Shares where a shadow lies around the object: I = a F + c B solved for a and c; else None.

    a is what I shows across B, over what F does. It replaces a larger share where that is known
    beyond noise and tints, and where no third colour is in the pixel.
    """
    between = np.count_nonzero((share > _DARK / 2) & (share < _HIGH))  # a shadow's are there
    if between <= _DARK * np.count_nonzero(share < _LOW):
        return None
    here, behind, colour = (one.astype(np.float32) for one in (seen, behind_it, its))
    own, both, lit = float(colour @ colour), _times(behind, colour), _dot(behind, behind)
    determinant = own * lit - both * both
    least = max(_HUE**2, (noise / _UNEVEN) ** 2 / max(float(lit.mean()), 1.0))
    hue = determinant > least * lit * lit
    if not hue.any():
        return None
    by_colour, by_behind = _times(here, colour), _dot(here, behind)
    np.maximum(determinant, 1, out=determinant)
    a = (by_colour * lit - by_behind * both) / determinant
    c = (by_behind * own - by_colour * both) / determinant
    missed = _dot(here, here) - a * by_colour - c * by_behind
    mixed = hue & (missed < (_OTHER * contrast) ** 2)
    beside = mixed & (a < _LOW)
    dark = beside & (c < 1 - max(_DARK, 3 * noise / max(float(lit.mean()), 1.0) ** 0.5))
    if np.count_nonzero(dark) <= _DARK * np.count_nonzero(beside):
        return None
    return np.asarray(np.where(mixed, np.minimum(share, a), share), dtype=np.float32)


def _of_what_is_near(share: Channels) -> Channels:
    """Shares of the most that a pixel shows within three: shade ends inside an object, not its rim.

    Without that the dark side of a lit object counts less, and its position rotates with its marks.
    """
    import cv2

    smooth = cv2.blur(np.clip(share, 0, 1), (3, 3))
    most = cv2.dilate(smooth, np.ones(_AROUND, np.uint8))
    return np.asarray(share / np.maximum(most, np.float32(_SHADED)), dtype=np.float32)


def _of_local_colour(
    seen: Picture, behind: Picture, share: Channels, body: Mask, noise: float
) -> Channels:
    """Shares of the colour that the object has next to a pixel: grain ends at its rim as it may.

    That is the mean over the pixels around, each as it is wholly of the object. Where there are
    none, or they have the background's colour, shares stay as they were.
    """
    import cv2

    whole = np.clip(share, 0, 1) ** _WHOLLY * (body > 0)
    near = cv2.blur(whole, _AROUND)
    light: Channels = seen.astype(np.float32)
    own = cv2.blur(light * whole[:, :, None], _AROUND) / np.maximum(near, 1e-6)[:, :, None]
    behind_it = behind.astype(np.float32)
    towards = np.asarray(own - behind_it, dtype=np.float32)
    square = _dot(towards, towards)
    known = (near > 1 / (_AROUND[0] * _AROUND[1])) & (square > (4 * noise) ** 2)
    found = _dot(light - behind_it, towards) / np.maximum(square, 1)
    return np.asarray(np.where(known, found, share), dtype=np.float32)


def _median(values: NDArray[Any]) -> NDArray[Any]:
    """The upper median along the first axis; numpy's own costs more than all else of a window."""
    middle = len(values) // 2
    return np.asarray(np.partition(values, middle, axis=0)[middle])


def _near_largest(values: Channels) -> float:
    """The size that three in a hundred exceed: highlights do not count."""
    k = int(0.97 * (len(values) - 1))
    return float(np.partition(values, k)[k])


def _dot(a: Channels, b: Channels) -> Channels:
    """(h, w) product of the colours of pixels."""
    import cv2

    return np.asarray(cv2.transform(cv2.multiply(a, b), _SUM), dtype=np.float32)


def _times(a: Channels, colour: NDArray[np.float32]) -> Channels:
    """(h, w) product of the colours of pixels with one colour."""
    import cv2

    return np.asarray(cv2.transform(a, colour[None]), dtype=np.float32)


def _body(share: Channels, mask: Mask) -> Mask | None:
    """The largest connected part that is half the object or more, without what is thin."""
    import cv2

    more = np.where(share > (_LOW + _HIGH) / 2, np.uint8(255), np.uint8(0))
    more[cv2.dilate(mask, np.ones((5, 5), np.uint8)) == 0] = 0
    half = largest(more)  # without holes: highlights and marks on an object
    if half is None:
        return None
    edged = cv2.copyMakeBorder(half, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0)
    radius = int(_THIN * float(cv2.distanceTransform(edged, cv2.DIST_L2, 3).max()))
    if radius < 1:
        return half
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1))
    thick = largest(np.asarray(cv2.morphologyEx(half, cv2.MORPH_OPEN, kernel), dtype=np.uint8))
    return None if thick is None else _with_corners(half, thick, share)


def _with_corners(half: Mask, thick: Mask, share: Channels) -> Mask:
    """The thick part of an object and its corners, but for what hangs on it.

    A string is far longer than wide where it begins. A corner of 30 degrees that an arc of radius r
    has cut off is r (1/sin 15 - 1) long, and the arc 5 pi/6 r: its length 1.1 times that. Shadows
    and blurred rims are only in part as the object is.
    """
    import cv2

    away = cv2.distanceTransform(cv2.bitwise_not(thick), cv2.DIST_L2, 3)
    count, labels = cv2.connectedComponents(cv2.subtract(half, thick))
    found = thick.copy()
    for k in range(1, count):
        far = away[labels == k]
        broad = float(far.max()) <= _LONG * np.count_nonzero(far < _NEXT)
        if broad and np.median(share[labels == k]) > _HIGH:
            found[labels == k] = 255
    return found


def _box(body: Mask, left: int, top: int, reduce: int) -> tuple[int, int, int, int]:
    import cv2

    x, y, w, h = cv2.boundingRect(body)
    return left + x * reduce, top + y * reduce, w * reduce, h * reduce
