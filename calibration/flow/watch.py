"""A discharge film as it goes by, frame by frame: what is kept of it, and what it comes to."""

from collections import deque
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibration.drop.bounce import STANDARD_GRAVITY
from calibration.flow.discharge import Crossing, Opening, Plausible
from calibration.flow.layers import Band, Lines, Profile, drawn_bands, of_bands, painted_bands
from calibration.flow.result import Curve, Flow
from calibration.flow.silo import Settings, Silo, layer_height
from calibration.flow.survey import CLEAR, Grey, Survey, Tones, clock_warnings, find_tones, to_grey
from calibration.flow.tracers import Points, Steps, Tracers, material_mask, outlet_columns, seeds
from calibration.flow.velocity import Velocities
from calibration.statistics.uncertainty import Estimate
from calibration.tracking.film.reader import Film, Picture
from granulab.errors import InputError

Floats = NDArray[np.float64]

_STILL = 0.1  # of a particle's pixels that must change for anything to have moved
# Material above an outlet that opens falls freely but for what arches hold back: at most with g,
# and with half the rate (a quarter of the acceleration) at less than a quarter of it.
_FASTEST, _SLOWEST = 1.3, 0.25  # of g; a tracer's 0.1 px and the opening's sigma are 10 to 20 %
_REST = 0.1  # s without motion at the end of the film, for what is left to be at rest


def _time_base(found: Flow) -> list[str]:
    """A line where the first fall is none that gravity draws, at this rate and scale."""
    fall, g = found.first_fall, STANDARD_GRAVITY.value
    if fall is None or _SLOWEST <= fall / g <= _FASTEST:
        return []
    free = found.rate * float(np.sqrt(g / fall))
    return [
        f"the material above the outlet begins to fall with {fall:.2g} m/s2 at {found.rate:g} "
        f"frames/s ({found.rests_on}): free fall, which arches and a slow door make less of, would "
        f"be {free:.3g} frames/s; check the camera's rate (--fps) and the scale"
    ]


class _Moment(NamedTuple):
    """A frame, where the bed is in the silo's box, and the tracers along the silo's axes."""

    number: int
    grey: Grey
    bed: NDArray[np.bool_]
    position: Floats
    variance: Floats  # px^2


class Watch:
    """Tracers, a few frames and series of numbers, kept while a film goes by."""

    def __init__(
        self, film: Film, rate: float, interval: float, seen: Survey, silo: Silo, settings: Settings
    ) -> None:
        self.film, self.rate, self.interval = film, rate, interval
        self.seen, self.silo, self.settings = seen, silo, settings
        self.particle = silo.width / settings.columns / 2  # px: columns are two particles wide
        self.tones: Tones = find_tones(seen, silo.box)
        labels = self.tones.labels(seen.first)
        self.mask = material_mask(seen, silo, self.tones, labels, self.particle)
        start, tone = seeds(self.mask, labels, silo, self.particle)
        if len(start) < 100:
            raise InputError(f"{film.path}: no material is seen in the silo; check --roi")
        self.left = self._without_edges()
        self.tracers = Tracers(start, self.particle)
        self.outlet = outlet_columns(self.mask, silo, self.particle)
        row = round(silo.outlet)
        self._lip = slice(max(row - 1, 0), row + 2), slice(*self.outlet)
        self.bands = self._bands(labels, start)
        self.lines = self._lines(start, tone)
        self._lowest = self._above_outlet(start)
        strip = (self.outlet[1] - self.outlet[0]) * self.particle
        wanted = strip / self.tracers_step() ** 2
        self._plausible = Plausible(film.path, int(self._lowest.sum()), wanted)
        self.opening, self.crossing = Opening(self.particle), Crossing(self.particle)
        self.velocities = Velocities(silo, self.particle)
        self._series: list[tuple[float, float, float, float]] = []
        self._waiting: deque[_Moment] = deque()
        self._before: _Moment | None = None
        self._bed = self.mask[silo.box]
        self._grey: Grey | None = None
        self._moved = 0  # number of the last frame in which something did
        self._last = 0
        self.profiles: list[Profile] = []
        self._area = 0.0

    def _without_edges(self) -> NDArray[np.bool_]:
        """Material left in the last picture (rows, columns); lines along walls leave the mask."""
        import cv2

        box = self.silo.box
        material = (self.tones.labels(self.seen.last)[box] != 2) & self.mask[box]
        size = (max(round(self.particle / 2), 3),) * 2
        kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, size)
        opened = cv2.morphologyEx(material.astype(np.uint8), cv2.MORPH_OPEN, kernel).astype(bool)
        self.area = self.mask[box] & ~(material & ~opened)
        return opened

    def _bands(self, labels: NDArray[np.int64], start: NDArray) -> list[Band]:
        bands = painted_bands(labels, self.silo, self.mask, self.particle)
        if (height := layer_height(self.settings)) is not None:
            bands = drawn_bands(self.silo, height / self.silo.scale.value, start[:, 1].min())
        return bands or [Band(self.silo.top, self.silo.outlet, -1)]

    def _lines(self, start: NDArray, tone: NDArray[np.int64]) -> Lines:
        scale = self.silo.scale.value
        edges = np.linspace(0.0, self.silo.width, self.settings.columns + 1) * scale
        layer = of_bands(self.bands, start, tone, self.particle)
        share = (self.tracers_step() / self.particle) ** 2
        return Lines(self.silo.metres(start.astype(float)), layer, edges, share)

    def tracers_step(self) -> float:
        """Distance of tracers [px]."""
        return float(np.min(np.diff(np.unique(self.tracers.start[:, 0]))))

    def _above_outlet(self, start: NDArray) -> NDArray[np.bool_]:
        """A particle above the outlet, where no window sees the door or what is below it."""
        particles = (self.silo.outlet - start[:, 1]) / self.particle
        near = (particles > 1) & (particles < 2)
        return near & (start[:, 0] > self.outlet[0]) & (start[:, 0] < self.outlet[1])

    def see(self, number: int, picture: Picture) -> None:
        """Take the next frame."""
        grey = to_grey(picture)
        height = self.tracers.position[:, 1].copy()
        if self._grey is not None and self._differs(self._grey, grey):
            self.tracers.follow(self._grey, grey)
            self.tracers.drop(self.tracers.position[:, 1] > self.silo.outlet + 2 * self.particle)
            self._grey, self._moved = grey, number
        elif self._grey is None:
            self._grey = grey
        self._last = number
        self._cross(number, picture, height)
        area, surface = self._seen_area(picture)
        share = self._share()
        self._series.append((float(number), area, surface, share))
        falls = (self.tracers.position[:, 1] - self.tracers.start[:, 1]).astype(float)
        self.opening.see(number, float(falls[self._lowest].mean()))
        self._plausible.see(area, share, falls)
        self._keep(number, grey)

    def _differs(self, before: Grey, grey: Grey) -> bool:
        import cv2

        rows, columns = self.silo.box
        wider = slice(rows.start, rows.stop + round(2 * self.particle)), columns
        apart = cv2.blur(cv2.absdiff(grey[wider], before[wider]), (3, 3))
        changed = np.count_nonzero(apart > CLEAR * self.seen.noise)
        return bool(changed > _STILL * self.particle**2)

    def _cross(self, number: int, picture: Picture, before: Points) -> None:
        """See what stands in the outlet's row, and how fast tracers that began above it pass."""
        seen, lip = self.seen, self._lip
        crossed = self.tones.stands(picture[lip], seen.last[lip], seen.noise)
        now = self.tracers.position[:, 1]
        passing = (before < self.silo.outlet) & (now >= self.silo.outlet)
        steps = (now - before)[passing].astype(float)
        self.crossing.see(number, crossed, steps)

    def _seen_area(self, picture: Picture) -> tuple[float, float]:
        """Pixels of material in the silo, and the mean height of its free surface."""
        if self.tones.backing is None:
            return np.nan, np.nan
        rows, columns = self.silo.box
        material = (self.tones.labels(picture[rows, columns]) != 2) & self.area
        self._bed = self._closed(material)
        wide = self.particle * 2
        edges = np.arange(0, material.shape[1] + 1e-9, wide).astype(int)
        tops = []
        for a, b in pairwise(edges.tolist()):
            filled = np.flatnonzero(material[:, a:b].mean(axis=1) > 0.5)
            if len(filled):
                tops.append(material.shape[0] - filled[0])
        height = float(np.mean(tops)) * self.silo.scale.value if tops else 0.0
        return float(material.sum()), height

    def _closed(self, material: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Material with the gaps between its particles."""
        import cv2

        size = max(round(self.particle / 2), 3)
        kernel = np.ones((size, size), np.uint8)
        return cv2.morphologyEx(material.astype(np.uint8), cv2.MORPH_CLOSE, kernel).astype(bool)

    def _share(self) -> float:
        return float((self.tracers.position[:, 1] < self.silo.outlet).mean())

    def _keep(self, number: int, grey: Grey) -> None:
        """Hold frames back until the opening is known, then measure in turn what they show."""
        here = self.silo.metres(self.tracers.position.astype(float))
        self._waiting.append(_Moment(number, grey, self._bed, here, self.tracers.variance.copy()))
        if self.opening.clock is None:
            while not self.opening.moving and len(self._waiting) > 3:
                self._waiting.popleft()
            return
        while self._waiting:
            self._take(self._waiting.popleft())

    def _take(self, now: _Moment) -> None:
        before, self._before = self._before, now
        if before is None or self.opening.clock is None:
            return
        start = self.opening.clock.value
        first, last = (max(one.number - start, 0.0) / self.rate for one in (before, now))
        scale = self.silo.scale.value
        while (wanted := len(self.profiles) * self.interval) <= last:
            part = np.clip((wanted - first) / max(last - first, 1e-12), 0.0, 1.0)
            position = before.position + part * (now.position - before.position)
            variance = before.variance + part * (now.variance - before.variance)
            self.profiles.append(self.lines.at(wanted, position, variance * scale**2))
        middle = (first + last) / 2
        if self.settings.velocity and self.velocities.wants(middle, self.interval):
            step = (now.number - before.number) / self.rate
            self.velocities.add(
                int(middle / self.interval), (before.grey, now.grey), (before.bed, now.bed),
                self._steps(before, now), step,
            )  # fmt: skip

    def _steps(self, before: _Moment, now: _Moment) -> Steps:
        first, last = (self.silo.pixels(one.position) for one in (before, now))
        off = np.sqrt(now.variance) - np.sqrt(before.variance)  # errors along a way add up
        return Steps((first + last) / 2, last - first, np.square(off))

    def flow(self) -> Flow:
        """Result of the film."""
        opening = self.opening.clock
        if opening is None:
            raise InputError(
                f"{self.film.path}: no material falls at the outlet; does the film show the "
                "opening, is --roi the silo's inside from the outlet up, or is it --collapse?"
            )
        position = self.tracers.position[self.tracers.position[:, 1] > self.silo.outlet].astype(
            float
        )
        ends = self.outlet[0] - self.particle, self.outlet[1] + self.particle
        self._plausible.end(position[:, 0], ends)
        frame, area, surface, share = np.array(self._series).T
        time = (frame - opening.value) / self.rate
        still = time <= 0
        whole = float(np.mean(area[still])) if still.any() else float(area[0])
        curve = Curve(time, area / whole, share, surface)
        outcome = self._outcome()
        discharge = None
        late = (opening.sigma or 0.0) / self.rate
        last = self.crossing.last()
        if last is not None and outcome in ("empty", "dead_zones"):
            sigma = np.hypot((last.sigma or 0.0) / self.rate, late)
            discharge = Estimate((last.value - opening.value) / self.rate, float(sigma), 1)
        found = Flow(
            self.film, self.rate, self.silo, self._outlet_ends(), opening, outcome, discharge,
            curve, self.bands, self.lines.edges, self.interval, self._with_shared(opening),
            self.velocities.fields(self.interval, late), self.seen, self._warnings(curve),
            "the file's head" if self.settings.fps is None else "--fps", self.opening.pull,
        )  # fmt: skip
        return replace(found, warnings=[*found.warnings, *_time_base(found)])

    def _outlet_ends(self) -> tuple[float, float]:
        scale = self.silo.scale.value
        left, right = ((column - self.silo.left) * scale for column in self.outlet)
        return left, right

    def _outcome(self) -> str:
        """Outcome of the discharge, by what the last picture shows (spec: clogged, dead zones)."""
        columns, left = self.silo.box[1], self.left
        gone = self.tones.backing is not None and left.sum() < self.particle**2
        if gone and self.crossing.over(self._last):
            return "empty"  # whatever still moves, shadows and dust, is none of it
        if (self._last - self._moved) / self.rate < _REST:
            return "unfinished"
        if self.tones.backing is None:
            return "clogged"
        if gone:
            return "empty"
        middle = round(sum(self.outlet) / 2) - columns.start
        strip = left[:, max(middle - 1, 0) : middle + 2]
        return "clogged" if strip.all(axis=1).sum() > self.particle / 2 else "dead_zones"

    def _with_shared(self, start: Estimate) -> list[Profile]:
        """Profiles with the uncertainty of scale, outlet level and opening, which all share."""
        scale = self.silo.scale
        relative = (scale.sigma or 0.0) / scale.value
        late = (start.sigma or 0.0) / self.rate
        level = self.silo.edge * scale.value
        out = []
        for k, p in enumerate(self.profiles):
            near = self.profiles[max(k - 1, 0)], self.profiles[min(k + 1, len(self.profiles) - 1)]
            step = max(near[1].time - near[0].time, self.interval)
            speed = np.nan_to_num((near[1].lines - near[0].lines) / step)
            shared = np.square(relative * p.lines) + np.square(late * speed) + level**2
            out.append(replace(p, sigma=np.sqrt(p.sigma**2 + shared)))
        return out

    def _warnings(self, curve: Curve) -> list[str]:
        found = clock_warnings(self.film, self.seen)
        if self.tones.backing is None:
            found.append("the backing is not seen: what remains follows from the tracers alone")
        if len(self.bands) == 1:
            found.append("no painted layers were found: one line for all; see --layer-height")
        if self._outcome() == "unfinished":
            found.append(
                f"something still moves within {_REST:g} s of the film's end: no discharge time; "
                "film on until it is at rest, or take what moves out of it with --roi"
            )
        if self.opening.moving and self._series and curve.time[0] > -1 / self.rate:
            found.append("the film begins with the opening or after it: times count from there")
        return found
