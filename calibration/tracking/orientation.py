"""Orientation of an object in every frame of its track, from the radii of its silhouette.

A silhouette that rotates by phi has the Fourier coefficients c_m = T_m exp(-i m phi) of its radius
against direction, T those of the shape. phi is where both agree best (matched filter), with all
harmonics from the second on: second moments alone see no rotation of a square, a triangle, or what
is nearly one. The first harmonic is the centroid's error. Where the shape looks alike after a part
of a turn, the rotation goes on from frame to frame with the least change of its rate.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.statistics.robust import MEDIAN_TO_SIGMA
from calibration.tracking.segments import noise as noise_about_smooth
from calibration.tracking.track import Array, Track
from granulab.errors import InputError

Complex = NDArray[np.complex128]

_UNEVEN = 0.2  # px by which shading moves one pixel of an edge: blobs._UNEVEN over its ramp
_SIGMAS = 5.0  # by which a silhouette must differ from a round one
_ALIKE = 0.9  # of the best agreement: orientations in which the shape looks the same
_GRID = 720  # orientations that are tried: half a degree apart, finer than any harmonic's period
_PASSES = 6  # of the shape and the orientations in turn
_NEARLY_ALIKE = 0.7  # of half a period of the shape in one frame: the next one is as likely
_FEWEST = 4  # silhouettes
_EXACT = 1e-6  # of the radius: what is taken as noise of silhouettes that show none
_LOST = np.pi / 8  # rad: sigma of an orientation from which it is taken as not seen


@dataclass(frozen=True)
class Orientation:
    """Rotation of one object; angles from x towards y, so clockwise in a picture.

    angle     (n,) from the first silhouette's on, followed through whole turns [rad]; NaN: not seen
    sigma     (n,) of each [rad]
    outline   (k,) radius in k directions where angle is zero, mean of all silhouettes [px]
    period    rotation after which the shape looks the same; 2 pi for one without symmetry [rad]
    changes   scatter of the silhouettes about the shape, in their scatter from frame to frame: 1
              where it rotates in the plane of the picture, more where it shows other sides
    """

    angle: Array
    sigma: Array
    outline: Array
    period: float
    changes: float

    def remarks(self, frame: Array) -> list[str]:
        """Warnings about what the frames (n,) leave open."""
        seen = np.isfinite(self.angle)
        step = np.abs(np.diff(self.angle[seen]) / np.diff(frame[seen]))
        fastest = float(np.quantile(step, 0.9)) if len(step) else 0.0
        if fastest < _NEARLY_ALIKE * self.period / 2:
            return []
        return [
            f"it rotates by {np.degrees(fastest):.0f} degrees a frame and looks the same after "
            f"{np.degrees(self.period):.0f}: it may rotate the other way; film at a higher rate"
        ]


def orientation(track: Track) -> Orientation:
    """Orientation of a followed object at each position of its track.

    Raises InputError where the track has no silhouettes, or they are round.
    """
    if track.profile is None:
        raise InputError("a table of positions shows no silhouette: give the film itself")
    profile = track.profile
    if len(profile) < _FEWEST:
        raise InputError(f"{len(profile)} silhouettes; {_FEWEST} and more show a rotation")
    harmonics = np.arange(2, profile.shape[1] // 4 + 1)  # finer ones are the pixels'
    seen = np.fft.rfft(profile, axis=1)[:, harmonics] / profile.shape[1]
    least = _UNEVEN / np.sqrt(4 * np.pi * float(np.median(profile)))
    angle = _followed(seen, harmonics, track.frame)
    noise: Array = np.full(len(harmonics), least)
    raw, still = seen, np.zeros(len(harmonics), dtype=complex)
    for _ in range(_PASSES):
        shape = _shape(seen, harmonics, angle)
        still = _still(raw, shape, harmonics, angle, noise / least)
        seen = raw - still
        angle = _refined(seen, shape / noise**2, harmonics, angle)
        left = seen * np.exp(1j * harmonics * angle[:, None]) - shape
        parts = np.concatenate([left.real, left.imag])
        noise = MEDIAN_TO_SIGMA * np.median(np.abs(parts), axis=0)
        noise = np.maximum(noise, _EXACT * float(np.median(profile)))
    _refuse_round(shape, np.maximum(noise, least))
    sigma = _sigma(left, shape, noise, harmonics)
    # Coding errs alike in all harmonics of a frame: a rotation is as smooth as any motion.
    sigma *= max(1.0, noise_about_smooth(track.frame, angle) / float(np.median(sigma)))
    known = sigma < _LOST
    if np.count_nonzero(known) < _FEWEST:
        raise InputError("its silhouettes are not of one shape: it rotates out of the picture")
    angle = np.where(known, angle - angle[known][0], np.nan)
    return Orientation(
        angle,
        sigma,
        _outline(profile, angle),
        _period(shape / noise, harmonics),
        _changes(left),
    )


def _refuse_round(shape: Complex, noise: Array) -> None:
    """InputError where the shape is a circle within its noise, or within an edge's unevenness."""
    size = float(np.sqrt(2 * np.sum(np.abs(shape) ** 2)))  # rms of the radius about its mean
    strong = float(np.sqrt(np.sum(np.abs(shape / noise) ** 2)))
    if size < _UNEVEN or strong < _SIGMAS:
        raise InputError(
            f"its silhouette is round within noise: the radius varies by {size:.2g} px about its "
            "mean, and no orientation is seen; film it nearer, or see calibrate drop for balls"
        )


def _followed(seen: Complex, harmonics: Array, frame: Array) -> Array:
    """(n,) orientations to half a degree: each goes on from those before it."""
    grid = np.arange(_GRID) * (2 * np.pi / _GRID)
    turned = np.exp(1j * harmonics * grid[:, None])
    angle = np.zeros(len(seen))
    shape, rate = seen[0].copy(), 0.0
    for k in range(1, len(seen)):
        steps = frame[k] - frame[k - 1]
        agree = (turned @ (seen[k] * shape.conj())).real
        top = (agree >= np.roll(agree, 1)) & (agree > np.roll(agree, -1))
        top &= agree >= _ALIKE * agree.max()
        expected = angle[k - 1] + rate * steps
        off = (grid[top] - expected + np.pi) % (2 * np.pi) - np.pi
        angle[k] = expected + off[np.argmin(np.abs(off))]
        rate = (angle[k] - angle[k - 1]) / steps
        shape += (seen[k] * np.exp(1j * harmonics * angle[k]) - shape) / (k + 1)
    return angle


def _shape(seen: Complex, harmonics: Array, angle: Array) -> Complex:
    """(m,) coefficients at angle zero: the middle of all silhouettes, rotated back."""
    back = seen * np.exp(1j * harmonics * angle[:, None])
    return np.asarray(np.median(back.real, axis=0) + 1j * np.median(back.imag, axis=0))


def _still(seen: Complex, shape: Complex, harmonics: Array, angle: Array, noise: Array) -> Complex:
    """(m,) part of the coefficients that does not rotate: of light, lens and pixels.

    noise   (m,) sigma of one silhouette's in that which such a part has: where it cannot be told
            from the shape it is taken as small
    """
    wave = np.exp(-1j * harmonics * angle[:, None])
    left = seen - shape * wave
    usual = np.abs(left) <= _SIGMAS * np.median(np.abs(left), axis=0)
    wave, left, n = wave * usual, left * usual, usual.sum(axis=0)
    # least squares of left = d wave + s, d a correction of the shape, s with a prior of its own
    one = wave.sum(axis=0)
    own = n + noise**2 - np.abs(one) ** 2 / np.maximum(n, 1)
    with_shape = one * (wave.conj() * left).sum(axis=0) / np.maximum(n, 1)
    return np.asarray((left.sum(axis=0) - with_shape) / own)


def _refined(seen: Complex, weighted: Complex, harmonics: Array, angle: Array) -> Array:
    """(n,) orientations of best agreement near those given (Newton's method)."""
    for _ in range(4):
        agree = seen * weighted.conj() * np.exp(1j * harmonics * angle[:, None])
        slope = -np.sum(harmonics * agree.imag, axis=1)
        bend = -np.sum(harmonics**2 * agree.real, axis=1)
        step = np.divide(-slope, bend, out=np.zeros(len(angle)), where=bend < 0)
        angle = angle + np.clip(step, -0.05, 0.05)  # rad: within one peak of the agreement
    return np.asarray(angle)


def _sigma(left: Complex, shape: Complex, noise: Array, harmonics: Array) -> Array:
    """(n,) sigma of the matched filter, wider where a silhouette fits worse than most."""
    whole = 1 / np.sqrt(np.sum((harmonics * np.abs(shape) / noise) ** 2))
    square = np.mean((left.real / noise) ** 2 + (left.imag / noise) ** 2, axis=1) / 2
    return np.asarray(whole * np.sqrt(np.maximum(square, 1.0)))


def _outline(profile: Array, angle: Array) -> Array:
    """(k,) mean radius, each silhouette rotated back by its angle: its spectrum's phases moved."""
    known = np.isfinite(angle)
    spectrum = np.fft.rfft(profile[known], axis=1)
    order = np.arange(spectrum.shape[1])
    back = np.median(np.fft.irfft(
        spectrum * np.exp(1j * order * angle[known, None]), profile.shape[1], axis=1
    ), axis=0)  # fmt: skip
    return np.asarray(back, dtype=float)


def _period(shape: Complex, harmonics: Array) -> float:
    """Least rotation after which the shape agrees with itself."""
    power = np.abs(shape) ** 2
    parts = np.arange(2, harmonics[-1] + 1)
    agree = np.cos(2 * np.pi * harmonics / parts[:, None]) @ power / power.sum()
    alike = parts[agree >= _ALIKE]
    return 2 * np.pi / float(alike.max()) if len(alike) else 2 * np.pi


def _changes(left: Complex) -> float:
    """Scatter about the shape over that of neighbouring frames (von Neumann's ratio)."""
    whole = np.median(np.abs(left) ** 2)
    steps = np.median(np.abs(np.diff(left, axis=0)) ** 2) / 2
    return float(np.sqrt(whole / steps)) if steps > 0 else 1.0
