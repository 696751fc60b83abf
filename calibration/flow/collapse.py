"""A column that spreads on a plate: position of its front and of its free surface against time.

The material is what differs from the first picture by more than half of how much backing and
material differ (which do is decided by Otsu's threshold, IEEE Trans. SMC 9 (1979) 62, of the last
picture): its largest patch. The front is where the patch ends on the left and on the right. Half of
its width is the radius of a heap that spreads evenly, whichever way a camera looks down on it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from calibration.flow.result import numbers, write_rows
from calibration.flow.silo import Roi, check_options
from calibration.flow.survey import CLEAR, Grey, Survey, clock_warnings, survey, to_grey
from calibration.statistics.quantity import metres_per_pixel
from calibration.statistics.robust import MEDIAN_TO_SIGMA
from calibration.statistics.uncertainty import Estimate
from calibration.tracking.film.reader import frame_rate, inside, open_film
from granulab.campaign.output.figure import BLUE, GREEN, INK, VERMILION, headline
from granulab.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure


Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_RAGGED = 0.02  # of the patch's rows, at its outermost, over which the front's position is averaged
_SMALLEST = 25  # px of a patch that counts
_JUMP = 5.0  # usual steps from frame to frame: a front that moves farther is something else's edge
_SPREAD = 0.8  # of the final half width: later jumps are no release
_AT_REST = 0.98  # of the final half width, from which on the front is taken to rest
# An edge is counted in whole pixels: a rectangular distribution of 1 px for each end (GUM 4.3.7).
_COUNTED = 1 / np.sqrt(12) / np.sqrt(2)  # px of half the difference of two


@dataclass(frozen=True)
class Collapse:
    """A spreading column; a result (calibration.result).

    Frame by frame (n,), in `unit` from the picture's left side and top; NaN where not seen:


    left, right    ends of the material
    surface        its highest point
    sigma          standard deviation of the half width, of whole pixels and from frame to frame
    begins         number of rows from the first frame on that were left out: before the release
    rests_on       where the rate comes from
    """

    path: Path
    header: float | None
    rate: float
    scale: Estimate
    unit: str
    time: Floats
    left: Floats
    right: Floats
    surface: Floats
    sigma: float
    begins: int
    rests_on: str
    warnings: list[str]

    @property
    def half_width(self) -> Floats:
        """Half of the distance between the fronts (n,)."""
        return (self.right - self.left) / 2

    def to_dict(self) -> dict[str, Any]:
        """Series in `length_unit` and s from the first frame."""
        return {
            "fps_header": self.header,
            "fps_used": self.rate,
            "time_base": {"rests_on": self.rests_on, "checked": False},
            "rows_left_out": self.begins,
            "length_unit": self.unit,
            "scale_m_per_px": self.scale.value if self.unit == "m" else None,
            "time_s": numbers(self.time),
            "front_left": numbers(self.left),
            "front_right": numbers(self.right),
            "half_width": numbers(self.half_width),
            "surface": numbers(self.surface),
            "sigma": self.sigma,
            "warnings": self.warnings,
        }

    def text(self) -> str:
        """Some twenty lines of the series, and sigma."""
        series = (self.left, self.right, self.half_width, self.surface)
        lines = [
            f"{'time [s]':>9} {'left':>10} {'right':>10} {'half width':>11} {'surface':>9} "
            f"[{self.unit}]"
        ]
        for k in range(0, len(self.time), max(len(self.time) // 20, 1)):
            cells = [f"{one[k]:.4g}" if np.isfinite(one[k]) else "-" for one in series]
            lines.append(f"{self.time[k]:9.4f} " + " ".join(f"{cell:>10}" for cell in cells))
        lines.append(f"sigma {self.sigma:.2g} {self.unit}")
        return "\n".join(lines + [f"warning: {warning}" for warning in self.warnings])

    def figure(self) -> "Figure":
        """Front and free surface against time."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(8.2, 4.6), layout="constrained")
        headline(figure, f"{self.path.stem}: front against time")
        ends, half = figure.subplots(1, 2)
        ends.plot(self.time, self.left, color=BLUE, label="left end")
        ends.plot(self.time, self.right, color=VERMILION, label="right end")
        ends.plot(self.time, self.surface, color=GREEN, lw=1, label="highest point, from the top")
        half.plot(self.time, self.half_width, ".-", color=INK, ms=3, lw=0.8)
        ends.set_ylabel(f"position in the picture [{self.unit}]")
        half.set_ylabel(f"half of the width [{self.unit}], +- {self.sigma:.2g}")
        ends.legend(fontsize=8)
        for axes in (ends, half):
            axes.set_xlabel(f"time from the first frame [s], at {self.rate:g} frames/s")
        return figure


def measure_collapse(
    path: str | Path, *, fps: float | None = None, scale: str | None = None,
    roi: Roi = None, report: Callable[[float], None] = lambda part: None,
) -> Collapse:  # fmt: skip
    """The front in every frame of a film; InputError, one line, where nothing spreads."""
    import cv2

    film = open_film(path)
    rate = frame_rate(film, fps)
    check_options(film, roi, scale, None)
    seen = survey(film, lambda part: report(0.3 * part))
    x, y, w, h = inside(film, roi)
    part = slice(y, y + h), slice(x, x + w)
    limit = _limit(path, seen, part)
    known = Estimate(1.0, 0.0, 1)
    if scale is not None:
        known = Estimate(metres_per_pixel(scale), 0.0, 1)
    rows = []
    first = to_grey(seen.first)[part]
    for frame in film.frames():
        apart = np.asarray(cv2.absdiff(to_grey(frame.picture)[part], first), np.uint8)
        rows.append((frame.number / rate, *_ends(apart, limit)))
        report(0.3 + 0.7 * frame.number / seen.count)
    time, left, right, top = np.array(rows).T
    k = known.value
    warnings = clock_warnings(film, seen)
    begins = _release((right - left) / 2, left, right)
    left[:begins] = right[:begins] = top[:begins] = np.nan
    if begins:
        warnings.append(
            f"the first {begins} frames are left out: until {time[begins]:.4g} s an edge jumps by "
            f"more than {_JUMP:g} usual steps, as that of a gate, a tube or a hand does"
        )
    if film.rate is not None and fps is None:
        warnings.append(
            f"the rate is that of the file's head, {film.rate:g} frames/s, and nothing in a "
            "collapse can check it: grains that lean on each other fall slower than free ones, by "
            "an unknown share; a film that is shown slowly was taken at another: --fps"
        )
    return Collapse(
        Path(path), film.rate, rate, known, "px" if scale is None else "m", time,
        k * (left + x), k * (right + x), k * (top + y),
        k * _noise(left, right), begins, "the file's head" if fps is None else "--fps", warnings,
    )  # fmt: skip


def _limit(path: str | Path, seen: Survey, part: tuple[slice, slice]) -> float:
    """Half of the step from backing to material [grey levels]."""
    import cv2

    apart = cv2.absdiff(to_grey(seen.last)[part], to_grey(seen.first)[part])
    threshold, _ = cv2.threshold(apart, 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    changed = apart[apart > threshold]
    if changed.size < _SMALLEST or np.median(changed) < CLEAR * seen.noise * np.sqrt(2):
        raise InputError(f"{path}: the first and the last frame show the same: nothing spreads")
    return float(np.median(changed)) / 2


def _ends(apart: Grey, limit: float) -> tuple[float, float, float]:
    """Left end, right end and top of the largest patch that changed [px]; NaN for none."""
    import cv2

    kernel = np.ones((3, 3), np.uint8)
    changed = cv2.morphologyEx((apart > limit).astype(np.uint8), cv2.MORPH_OPEN, kernel)
    _, label, stats, _ = cv2.connectedComponentsWithStats(changed)
    if len(stats) < 2 or stats[1:, cv2.CC_STAT_AREA].max() < _SMALLEST:
        return np.nan, np.nan, np.nan
    x, y, w, h, _ = (int(v) for v in stats[1 + int(stats[1:, cv2.CC_STAT_AREA].argmax())])
    patch = label[y : y + h, x : x + w] == 1 + int(stats[1:, cv2.CC_STAT_AREA].argmax())
    filled = patch.any(axis=1)
    first = patch[filled].argmax(axis=1)
    last = w - patch[filled][:, ::-1].argmax(axis=1)
    count = max(round(_RAGGED * filled.sum()), 1)
    left, right = np.sort(first)[:count].mean(), np.sort(last)[-count:].mean()
    top = float(y) if y > 0 else np.nan  # it goes on beyond the picture
    return float(x + left), float(x + right), top


def _release(half: Floats, left: Floats, right: Floats) -> int:
    """The first row from which on the ends of the patch move as a front does: in no jumps.

    half   half of the width [px], as `left` and `right` by row; NaN where nothing is seen
    """
    final = np.nanmedian(half[-max(len(half) // 10, 1) :]) if np.isfinite(half[-1]) else np.nan
    early = np.flatnonzero(half < _SPREAD * final)
    if not len(early):
        return 0
    steps = np.abs(np.diff([left, right], axis=1)).max(axis=0)
    moving = steps[steps > 0]  # an edge at rest stays in its pixel
    jumps = np.flatnonzero(~(steps[: early[-1]] <= _JUMP * np.median(moving)))  # also to NaN
    return int(jumps[-1]) + 1 if len(jumps) else 0


def _noise(left: Floats, right: Floats) -> float:
    """Standard deviation of the half width [px]: of whole pixels, and by third differences.

    Of the rows in which the front moves: an edge at rest stays in its pixel, and shows no noise.
    """
    half = (right - left) / 2
    moves = half < _AT_REST * np.nanmax(half, initial=0.0)
    third = np.diff(np.where(moves, half, np.nan), n=3)
    known = np.abs(third[np.isfinite(third)])
    # Third differences of independent values have 20 times their variance; frames in which the
    # front is hidden are few, and left to the median.
    scatter = MEDIAN_TO_SIGMA * np.median(known) / np.sqrt(20) if len(known) else 0.0
    return float(np.hypot(scatter, _COUNTED))


def write_table(seen: Collapse, folder: Path) -> Path:
    """Write collapse-NAME.csv in a folder; its path."""
    series = {
        "left": seen.left, "right": seen.right, "half_width": seen.half_width,
        "surface": seen.surface,
    }  # fmt: skip
    columns = {"time_s": seen.time} | {f"{k}_{seen.unit}": one for k, one in series.items()}
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    return write_rows(folder / f"collapse-{seen.path.stem}.csv", rows)
