"""Packing of a silo at rest, from a film or one picture: its height, and its layers.

The region looked at is the silo's inside, from the floor up to where nothing lies. What its
uppermost rows show is the backing; the material has two other tones, painted and bare particles.
The surface of a column of pixels is where, from above, half of the way from the backing to the
material's own colour is reached; the packing height is the mean over all columns. A layer is a band
of one tone; its height is the mean height of its material, as silo2d has it of its particles.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from calibration.flow.layers import Band, of_bands, painted_bands
from calibration.flow.result import numbers
from calibration.flow.silo import COLUMNS, SMALLEST, Roi, Silo, scale_of
from calibration.flow.survey import CLEAR, Survey, Tones, find_tones
from calibration.statistics.quantity import plus_minus
from calibration.statistics.robust import MEDIAN_TO_SIGMA
from calibration.statistics.uncertainty import Estimate, as_pair
from calibration.tracking.film.reader import Film, Picture, Region, inside, open_film, open_picture
from granulab.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

_TOP = 0.04  # of the region's rows, in which nothing lies
_EMPTY = 0.9  # of their pixels that one tone must have
_STILL = 0.002  # of the region's pixels that may change: dust, a lamp's reflection
_MOST = 100  # frames that are averaged
_EDGE = 0.5  # px by which whoever says the region may be off, each side
_PARTS = 0.25, 0.5, 0.75  # of the way from the backing to the material
_DEEP = 4  # px under the surface in which the material's own colour is seen


@dataclass(frozen=True)
class Packing:
    """A silo at rest; a result (calibration.result). In silo.unit, heights from the floor.

    height     mean of the surface over the silo's width
    surface    (columns,) of each column of pixels
    bands      layers from below, as rows of the picture [px]
    layers     mean height of the material of each
    shares     of the material that each layer has
    """

    film: Film
    picture: Picture
    silo: Silo
    height: Estimate
    surface: Floats
    bands: list[Band]
    layers: list[Estimate]
    shares: list[float]
    warnings: tuple[str, ...]

    @property
    def name(self) -> str:
        """Name of the film in file names."""
        return self.film.path.stem.strip("*?[]") or "pictures"

    @property
    def roughness(self) -> float:
        """Standard deviation of the surface over the silo's width."""
        return float(np.nanstd(self.surface))

    def to_dict(self) -> dict[str, Any]:
        """Lengths in `length_unit`."""
        silo = self.silo
        return {
            "length_unit": silo.unit,
            "scale_m_per_px": as_pair(silo.scale) if silo.unit == "m" else None,
            "silo_px": [silo.left, silo.top, silo.width, silo.height],
            "height": as_pair(self.height),
            "surface_sd": self.roughness,
            "surface": numbers(self.surface),
            "layers": [
                {"layer": k, "painted": band.tone == 0, "height": as_pair(one), "share": share}
                for k, (band, one, share) in enumerate(
                    zip(self.bands, self.layers, self.shares, strict=True)
                )
            ],
            "warnings": list(self.warnings),
        }

    def text(self) -> str:
        """Height, roughness of the surface, and a line for each layer."""
        unit = self.silo.unit
        lines = [
            f"packing height {_of(self.height)} {unit}; the surface varies by "
            f"{self.roughness:.2g} {unit}",
        ]
        for k, (band, one, share) in enumerate(
            zip(self.bands, self.layers, self.shares, strict=True)
        ):
            tone = "dark" if band.tone == 0 else "light"
            lines.append(f"  layer {k + 1}, {tone:5}  at {_of(one)} {unit}, {share:.1%}")
        return "\n".join(lines + [f"warning: {warning}" for warning in self.warnings])

    def figure(self) -> "Figure":
        """Surface, its mean and the layers over the picture."""
        from matplotlib.figure import Figure

        from granulab.campaign.output.figure import BLUE, GREEN, PAPER, VERMILION, headline

        silo = self.silo
        figure = Figure(figsize=(6.4, 6.4), layout="constrained")
        axes = figure.subplots()
        height, width = self.picture.shape[:2]
        (x0, y1), (x1, y0) = silo.metres(np.array([[0.0, 0.0], [width, height]]))
        axes.imshow(self.picture[:, :, ::-1], extent=(x0, x1, y0, y1))
        x = (np.arange(len(self.surface)) + 0.5) * silo.scale.value
        axes.plot(x, self.surface, color=GREEN, lw=1.2, label="surface")
        side = silo.width * silo.scale.value
        axes.hlines(self.height.value, 0, side, color=VERMILION, label=f"mean {_of(self.height)}")
        for k, one in enumerate(self.layers):
            axes.hlines(one.value, 0, side, color=BLUE, ls="--", lw=1,
                        label="" if k else "mean height of a layer")  # fmt: skip
        axes.plot([0, side, side, 0, 0], [0, 0, *[silo.height * silo.scale.value] * 2, 0], ":",
                  color=GREEN, lw=0.8)  # fmt: skip
        axes.set(xlabel=f"x [{silo.unit}]", ylabel=f"height above the floor [{silo.unit}]")
        axes.legend(fontsize=8, frameon=True, facecolor=PAPER)
        headline(figure, f"{self.name}: packing height {_of(self.height)} {silo.unit}")
        return figure


def _of(known: Estimate) -> str:
    return plus_minus(known.value, known.sigma)


def measure_packing(
    path: str | Path, *, roi: Roi, scale: str | None = None, width: str | None = None,
    layers: int | None = None, columns: int = COLUMNS,
) -> Packing:  # fmt: skip
    """The packing in a film of a silo at rest, or in one picture.

    roi        the silo's inside from the floor up, x, y, width, height [px]
    layers     number that are painted; any if None
    columns    across the silo, two particles wide each
    Raises InputError, one line, for one that moves, shows no surface, or has other layers.
    """
    film = open_picture(path) or open_film(path)
    if roi is None:
        raise InputError(
            f"{film.path}: at rest nothing shows where the silo is; say where its inside is, from "
            "the floor up to where nothing lies: --roi x,y,w,h"
        )
    if columns < 1:
        raise InputError(
            f"--columns {columns}: how many, two particles wide each, lie side by side"
        )
    if scale is not None and width is not None:
        raise InputError("--scale and --width: give one; each gives the scale by itself")
    box = inside(film, roi, SMALLEST)
    known, unit = scale_of(scale, width, box.width, _EDGE)
    silo = Silo(float(box.x), float(box.y), float(box.width), float(box.height), _EDGE, known, unit)
    particle = silo.width / columns / 2
    picture = _at_rest(film, box)
    tones = _tones(film, picture, silo)
    labels = _without_lines(tones.labels(picture), silo, particle)
    low, surface, high = (_surface(picture, labels, tones, silo, part) for part in _PARTS)
    if np.isfinite(surface).mean() < 0.5:
        raise InputError(f"{film.path}: no surface of a packing is seen in --roi")
    bands = _bands(labels, silo, particle)
    if layers is not None and len(bands) != layers:
        raise InputError(f"{film.path}: {len(bands) or 'no'} painted layers are seen, not {layers}")
    warnings = () if bands else ("no painted layers were found",)
    levels, shares = _levels(labels, silo, bands, particle)
    # Blur fills gaps between particles, and rounds their corners: within its own width.
    blurred = abs(float(np.nanmean(low) - np.nanmean(high))) / np.sqrt(12)
    height = _estimate(float(np.nanmean(surface)), silo, blurred)
    return Packing(film, picture, silo, height, surface * known.value, bands,
                   [_estimate(one, silo, 0.0) for one in levels], shares, warnings)  # fmt: skip


def _at_rest(film: Film, box: Region) -> Picture:
    """The mean of a film's pictures; InputError where something moves in the region."""
    cut = np.s_[box.y : box.y + box.height, box.x : box.x + box.width]
    total, first, count, noise = np.zeros((film.height, film.width, 3)), None, 0, 1.0
    for frame in film.frames():
        seen = frame.picture.astype(np.float32)
        if first is None:
            first = seen
        apart = np.abs(seen - first).max(axis=2)[cut]
        noise = max(noise, MEDIAN_TO_SIGMA * float(np.median(apart)))
        moved = float((_smooth(apart) > CLEAR * noise).mean())
        if moved > _STILL:
            raise InputError(
                f"{film.path}: {moved:.1%} of --roi differs in frame {frame.number} from the first "
                "frame: the silo is in motion; film it at rest"
            )
        if count < _MOST:
            total += seen
            count += 1
    return np.rint(total / max(count, 1)).astype(np.uint8)


def _smooth(values: NDArray[np.float32]) -> NDArray[np.float32]:
    import cv2

    return np.asarray(cv2.blur(values, (3, 3)), np.float32)


def _tones(film: Film, picture: Picture, silo: Silo) -> Tones:
    """Dark and light material and the backing, which the region's uppermost rows show."""
    rows, columns = silo.box
    found = find_tones(Survey(1, picture, picture, 1.0, 0, False), silo.box)
    top = slice(rows.start, rows.start + max(round(_TOP * silo.height), 3))
    share = np.bincount(found.labels(picture)[top, columns].ravel(), minlength=3)
    backing = int(share.argmax())
    if share[backing] < _EMPTY * share.sum():
        raise InputError(
            f"{film.path}: the upper rows of --roi are not of one tone: they must show what is "
            "behind the silo, above the packing"
        )
    material = sorted({0, 1, 2} - {backing}, key=lambda k: float(found.colours[k].sum()))
    return replace(found, colours=found.colours[[*material, backing]], backing=2)


def _without_lines(labels: NDArray, silo: Silo, particle: float) -> NDArray:
    """Labels (h, w), backing where something is thinner than a particle: a line along a wall."""
    import cv2

    rows, columns = silo.box
    reach = max(round(particle / 4), 1)
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
    material = np.pad((labels[rows, columns] != 2).astype(np.uint8), 2 * reach)
    near = np.asarray(cv2.dilate(cv2.morphologyEx(material, cv2.MORPH_OPEN, kernel), kernel))
    out = np.full_like(labels, 2)
    kept = near[2 * reach : -2 * reach, 2 * reach : -2 * reach] > 0
    out[rows, columns] = np.where(kept, labels[rows, columns], 2)
    return out


def _surface(picture: Picture, labels: NDArray, tones: Tones, silo: Silo, part: float) -> Floats:
    """(columns,) height [px] at which a part of the way to the material's colour is reached.

    NaN where no material is seen.
    """
    rows, columns = silo.box
    filled = labels[rows, columns] != 2
    for k in range(1, _DEEP):  # a speck is no material
        filled[:-k] &= labels[rows, columns][k:] != 2
    away = np.linalg.norm(picture[rows, columns] - tones.colours[2], axis=2)
    surface = np.full(filled.shape[1], np.nan)
    for x in np.flatnonzero(filled.any(axis=0)):
        top = int(filled[:, x].argmax())
        level = part * float(np.median(away[top : top + 2 * _DEEP, x]))
        above = np.flatnonzero(away[: top + _DEEP, x] < level)
        if len(above):  # the last row that shows more of the backing
            k = int(above[-1])
            on = np.clip((level - away[k, x]) / max(away[k + 1, x] - away[k, x], 1e-9), 0, 1)
            # A row's value stands at its middle.
            surface[x] = filled.shape[0] - (k + 0.5 + on)
    return surface


def _bands(labels: NDArray, silo: Silo, particle: float) -> list[Band]:
    """Painted layers from below, as calibrate flow has them."""
    return painted_bands(labels, silo, np.ones(labels.shape, bool), particle)


def _levels(
    labels: NDArray, silo: Silo, bands: list[Band], particle: float
) -> tuple[list[float], list[float]]:
    """Mean height over the floor [px] and share of the material of each layer."""
    if not bands:
        return [], []
    rows, columns = silo.box
    tones = _cleared(labels[rows, columns], particle)
    y, x = np.nonzero(tones != 2)
    tone = tones[y, x]
    place = np.column_stack([x + columns.start, y + rows.start]).astype(float) + 0.5
    layer = of_bands(bands, place, tone, particle)
    count = np.bincount(layer, minlength=len(bands))
    height = np.bincount(layer, silo.outlet - place[:, 1], len(bands)) / np.maximum(count, 1)
    return height.tolist(), (count / count.sum()).tolist()


def _cleared(labels: NDArray, particle: float) -> NDArray[np.int64]:
    """Tones 0 and 1 of the material, 2 elsewhere; each that of the nearest inside of a particle.

    The rim of a light particle before a dark backing is blurred to the tone of dark ones.
    """
    import cv2
    from scipy.ndimage import distance_transform_edt

    reach = max(round(particle / 8), 1)
    kernel, plain = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8), labels.astype(np.uint8)
    inside = (cv2.erode(plain, kernel) == cv2.dilate(plain, kernel)) & (labels != 2)
    y, x = distance_transform_edt(~inside, return_distances=False, return_indices=True)
    return np.where(labels == 2, 2, labels[y, x])


def _estimate(pixels: float, silo: Silo, own: float) -> Estimate:
    """A height over the floor, with what floor and scale, and it by itself, are uncertain by."""
    scale = silo.scale
    sigma = np.hypot(np.hypot(silo.edge, own) * scale.value, pixels * (scale.sigma or 0.0))
    return Estimate(pixels * scale.value, float(sigma), 1)
