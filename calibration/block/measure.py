"""Films of a block on a plate: the inclination at first slip, and the way of a block that slides.

The plate's inclination is that of its upper edge in the mean of some pictures, turned back to the
first, and how far the plate has rotated since. Texture alone knows no horizontal, and the edge in a
single picture has its noise; together no error of one picture counts. All inclinations count from
the rows of the picture: a camera that is rolled adds its roll.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from calibration.block.align import block_shifts, mean_picture
from calibration.block.body import FEWEST, Body, agreed, follow_body
from calibration.block.edge import Edge, find_edge
from calibration.block.result import Slid, Tilted
from calibration.block.slip import Slip, first_slip
from calibration.flow.survey import survey
from calibration.statistics.quantity import metres_per_pixel
from calibration.statistics.robust import robust_fit
from calibration.statistics.uncertainty import Estimate
from calibration.tracking.film.reader import Film, Progress, inside, open_film, said_rate
from calibration.tracking.track import Array
from granulab.errors import InputError

_PICTURES = 40  # that are averaged
_LAST = 12  # frames before the slip whose mean shows the plate and the block at rest
_ALIGNED = 30.0  # px of the way that are measured on the block's whole picture
_FRAMES = 200  # that are, at most
_LEFT = 3.0  # px that a corner of the block has left the plate by, twice what one at rest does
_STAYS = 1.0  # px that one of the plate is off by, as RANSAC has it
_WITH = 2.0  # px by which a corner may be off the block's way
_TOPPLED = np.radians(6.0)  # of the block against the plate: it slides no more on its face
_BEND = 0.02  # of the way: how far a slide may leave its straight line
_AROUND = 6  # frames after it whose rotations, with those before, give the plate's at the slip
_RESTS = 0.25  # px: three times what corners stray by while the block rests on the plate
_SEEN = 3  # corners whose mean is the block's place
_DEEP = 12.0  # px below the block's lowest corner in which the plate's edge is looked for, at least

Roi = tuple[int, int, int, int] | None


@dataclass(frozen=True)
class Options:
    """fps, roi x, y, width, height [px], and the inclination in the first frame [rad], if known."""

    fps: float | None = None
    roi: Roi = None
    start_angle: Estimate | None = None


def measure_tilt(path: str | Path, options: Options, progress: Progress | None = None) -> Tilted:
    """The inclination at which a block first slips; InputError, one line, where it does not."""
    film, fps = open_film(path), said_rate(options.fps)
    seen = survey(film)
    body = follow_body(film, seen, inside(film, options.roi), rotates=True, fps=fps,
                       progress=progress)  # fmt: skip
    plate, block = _parted(film, body)
    number, corners = body.scene.number, block.scene.corners
    left = block.seen_from(plate)
    way = _together(left)
    _refuse_toppling(film, _rotations(corners, left)[~(np.hypot(*way.T) > _ALIGNED)])
    rest = np.flatnonzero(np.hypot(*way.T) < _RESTS)
    if not len(rest):
        raise InputError(f"{film.path}: the block is not seen at rest on the plate before it slips")
    end = way[int(np.nanargmax(np.hypot(*way.T)))]
    # The rotation at the slip, whatever it is off by since the first frame, is in these, too.
    last = rest[-_LAST:]
    picture = _mean(film, number[last], plate.motion[last])
    edge = _edge(film, picture, corners, float(np.arctan2(end[1], end[0])), body.scene.corners)
    angle = _folded(edge.angle + plate.rotation)
    down = np.array([np.cos(edge.angle), np.sin(edge.angle)])
    down *= _downhill(edge.angle + plate.rotation[-1])
    slipped = _aligned(film, plate, picture, corners, edge, way @ down, down)
    known = np.isfinite(slipped)
    slip = first_slip(number[known], slipped[known])
    if slip is None:
        raise InputError(f"{film.path}: the block never slips down the plate: tilt it further")
    # Downhill at the slip counts as positive: the camera's roll may have it negative before.
    tilted = np.flatnonzero(np.isfinite(angle))
    angle = angle * np.sign(angle[tilted[np.argmin(np.abs(number[tilted] - slip.time))]])
    start = options.start_angle
    if start is not None:
        angle = angle - angle[0] + start.value
    found, noise = _inclination(number, angle, slip)
    by = edge.sigma if start is None else float(np.hypot(start.sigma or 0.0, noise))
    found = replace(found, sigma=float(np.hypot(found.sigma or 0.0, by)))
    return Tilted(film.path, number, fps or film.rate, angle, slipped, slip, found, edge, corners,
                  tuple(body.scene.remarks))  # fmt: skip


def measure_slide(
    path: str | Path, options: Options, scale: str | None, progress: Progress | None = None
) -> Slid:
    """The way of a block down a plate against time; InputError, one line, where none slides."""
    film = open_film(path)
    if scale is None:
        raise InputError(f"{film.path}: a film needs the scale: --scale '0.5 mm/px'")
    metres, fps = metres_per_pixel(scale), said_rate(options.fps)
    seen = survey(film)
    body = follow_body(film, seen, inside(film, options.roi), rotates=False, fps=fps,
                       progress=progress)  # fmt: skip
    scene = body.scene
    if scene.time is None:
        raise InputError(f"{film.path}: no frame rate is known; say it: --fps 100")
    seen_by = np.isfinite(scene.places[..., 0]).sum(axis=1)
    held = np.flatnonzero(np.cumprod(seen_by >= FEWEST))
    middle = scene.corners.mean(axis=0)
    shift = body.motion[:, :2, :2] @ middle + body.motion[:, :2, 2] - middle
    shift[held[-1] + 1 :] = np.nan
    _refuse_toppling(film, body.rotation[held])
    direction = _straight(film, shift[held])[2]
    still = np.array([np.eye(3)] * len(shift))
    moved = still.copy()
    moved[held, :2, 2] = shift[held]
    edge = _edge(film, _mean(film, scene.number[held], still[held]), scene.corners, direction,
                 np.concatenate([scene.corners, middle + shift[held]]))  # fmt: skip
    picture = _mean(film, scene.number[held], moved[held])
    shift = block_shifts(film, scene.number, still, shift, picture, scene.corners, edge)
    use = np.flatnonzero(np.isfinite(shift[:, 0]))
    place = middle + shift[use]
    way, aside, direction = _straight(film, place)
    incline = Estimate(float(abs(_folded(np.array(edge.angle)))), edge.sigma, 1)
    unchecked = [] if fps is not None else [_unchecked(film)]
    return Slid(film.path, fps or film.rate, "the file's head" if unchecked else "--fps",
                scene.time[use], metres * way, metres * aside, incline, edge, scene.corners, place,
                (*scene.remarks, *unchecked))  # fmt: skip


def _unchecked(film: Film) -> str:
    """A remark on a rate that nothing but the file says."""
    assert film.rate is not None  # its frames have times
    return (
        f"the rate is that of the file's head, {film.rate:g} frames/s, and nothing in a slide can "
        "check it: gamma_t and the terminal velocity are proportional to it; a film that is shown "
        "slowly was taken at another: --fps"
    )


def _parted(film: Film, body: Body) -> tuple[Body, Body]:
    """Plate and block: some corners leave the others, and those of the block go downhill."""
    left = body.left
    far = np.linalg.norm(left, axis=2)
    for least in (2 * _LEFT, _LEFT):
        for k in range(len(far)):
            gone = np.flatnonzero(far[k] > least)
            if len(gone) < FEWEST:
                continue
            corners = body.scene.corners[gone]
            _, held = agreed(corners, corners + left[k, gone], np.eye(3))
            if held.sum() < max(FEWEST, len(gone) / 2):
                continue
            leaves = np.zeros(far.shape[1], bool)
            leaves[gone[held]] = True
            way = body.motion[k, :2, :2] @ np.median(left[k, leaves], axis=0)
            # Corners that are not seen now are of neither: those of the block would drag the plate.
            stays = far[k] < _STAYS
            if stays.sum() >= FEWEST:
                plate, block = (stays, leaves) if way[1] > 0 else (leaves, stays)
                return body.part(plate), body.part(block)
    raise InputError(
        f"{film.path}: the block never slips: nothing leaves the plate that tilts by "
        f"{np.degrees(np.ptp(body.rotation)):.0f} deg; film until it slides away, or say where "
        "plate and block are: --roi x,y,w,h"
    )


def _together(left: Array) -> Array:
    """(n, 2) mean of those of (n, c, 2) that are near their median, NaN where few are."""
    seen = np.isfinite(left).all(axis=2)
    enough = seen.sum(axis=1) >= _SEEN
    middle = np.full((len(left), 2), np.nan)
    middle[enough] = np.nanmedian(left[enough], axis=1)
    near = np.linalg.norm(left - middle[:, None], axis=2) < _WITH
    count = near.sum(axis=1)
    total = np.where(near[:, :, None], left, 0.0).sum(axis=1)
    return np.where((count >= _SEEN)[:, None], total / np.maximum(count, 1)[:, None], np.nan)


def _rotations(corners: Array, left: Array) -> Array:
    """(n,) rotation of corners that have left their places by (n, c, 2) [rad], NaN where few."""
    out = np.full(len(left), np.nan)
    for k, off in enumerate(left):
        motion, held = agreed(corners, corners + off, np.eye(3))
        if held.any():
            out[k] = np.arctan2(motion[1, 0], motion[0, 0])
    return out


def _refuse_toppling(film: Film, rotation: Array) -> None:
    """InputError where the block rotates, by more than one bad frame."""
    turned = np.abs(rotation[np.isfinite(rotation)])
    if np.sum(turned > _TOPPLED) > 1:
        raise InputError(
            f"{film.path}: the block rotates by {np.degrees(turned.max()):.0f} deg against the "
            "plate: it rolls or topples, and does not slide"
        )


def _straight(film: Film, place: Array) -> tuple[Array, Array, float]:
    """Way (n,) along a straight line, aside of it (n,), and its direction, downwards [rad]."""
    middle = place - place.mean(axis=0)
    x, y = np.linalg.svd(middle, full_matrices=False)[2][0]
    x, y = (x, y) if y >= 0 else (-x, -y)
    way, aside = middle @ [x, y], middle @ [-y, x]
    if np.ptp(aside) > max(_BEND * np.ptp(way), _WITH):
        raise InputError(
            f"{film.path}: the way bends by {np.ptp(aside):.0f} px over {np.ptp(way):.0f} px: what "
            "moves does not slide down a plate; say where the block is: --roi x,y,w,h"
        )
    return way - way[0], aside, float(np.arctan2(y, x))


def _edge(film: Film, picture: Array, corners: Array, direction: float, along: Array) -> Edge:
    """The plate's, parallel to the block's way and below its corners, in a mean picture.

    along    (k, 2) points between which the plate is known to lie [px]
    """
    x = np.array([np.cos(direction), np.sin(direction)])
    y = np.array([-x[1], x[0]]) * (1.0 if x[0] >= 0 else -1.0)
    origin = corners.mean(axis=0)
    across = (corners - origin) @ y
    depth = across.max() + max(np.ptp(across), _DEEP)
    ends = (along - origin) @ x
    found = find_edge(picture, origin, direction, (float(ends.min()), float(ends.max())), depth)
    if found is None:
        raise InputError(
            f"{film.path}: no plate edge found below the block, along its way; light the plate's "
            "side, so that it differs from what is behind it"
        )
    return found


def _mean(film: Film, number: Array, motion: Array) -> Array:
    """The mean of some of these frames, evenly."""
    some = np.linspace(0, len(number) - 1, min(_PICTURES, len(number))).round().astype(int)
    return mean_picture(film, number[some], motion[some])


def _aligned(
    film: Film, body: Body, picture: Array, corners: Array, edge: Edge, way: Array, down: Array
) -> Array:  # fmt: skip
    """Way (n,) of the block down the plate, in the frames about its slip, from its whole picture.

    way     (n,) by its corners, which lag while it begins to move
    down    (2,) the plate's direction in the first picture
    """
    late = np.flatnonzero(way > _ALIGNED)
    last = int(late[0]) if len(late) else len(way) - 1
    rows = np.arange(last + 1)[-_FRAMES:]
    shift = block_shifts(film, body.scene.number[rows], body.motion[rows],
                         way[rows, None] * down, picture, corners, edge)  # fmt: skip
    out = np.full(len(way), np.nan)
    out[rows] = shift @ down
    return out


def _folded(angle: Array) -> Array:
    """Direction of a line, without its sense, in -pi/2 to pi/2."""
    return np.asarray((angle + np.pi / 2) % np.pi - np.pi / 2)


def _downhill(angle: float) -> float:
    """1 where a direction from x to y leads down in the picture, else -1."""
    return 1.0 if np.sin(angle) >= 0 else -1.0


def _inclination(number: Array, angle: Array, slip: Slip) -> tuple[Estimate, float]:
    """Inclination at the first slip, straight through the frames about it, and noise of a frame."""
    near = (number > slip.time - _LAST) & (number < slip.time + _AROUND)
    t = number[near] - slip.time
    beta, covariance, _, noise = robust_fit(np.column_stack([np.ones_like(t), t]), angle[near])
    variance = covariance[0, 0] + (beta[1] * slip.sigma) ** 2
    return Estimate(float(beta[0]), float(np.sqrt(variance)), 1), noise
