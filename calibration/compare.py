"""Comparison of a simulated discharge with a filmed one: profiles, curves, and a distance.

    D = sqrt(<(y_film - y_run)^2>)        over layers, columns and times where both have a line [m]
    C = sqrt(<(R_film - R_run)^2>)        over the time of the film; R the share that remains

R is the area of the material that is seen, and the mass of the run's particles in the silo; both
begin at the opening. The uncertainty of D follows from that of the lines to first order,
u(D) = sum |d| u/(N D), as if all of them erred together: they share particles, scale and opening.
`floor` is the root mean square of the lines' own uncertainty: what D would be for equal flows.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from calibration.flow.result import Flow, numbers
from calibration.statistics.quantity import plus_minus
from calibration.statistics.uncertainty import Estimate, as_pair
from granulab.campaign.output.figure import BLUE, GREY, INK, VERMILION, WALL, headline
from granulab.errors import InputError
from silo2d.measures.basics.particles import column_edges, leavers
from silo2d.measures.profile import measure
from silo2d.view.scene import Scene, read_scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

_PANELS = 5
_PANEL = 1.8  # inches across one

_FEWEST = 3  # positions where both have a line


@dataclass(frozen=True)
class Comparison:
    """Lines (t, l, c) [m] and curves of a film and a run at the same positions and times; a result
    (calibration.result).

    distance     D [m]; floor [m]; curve_distance C
    time_off     discharge time of the run less that of the film [s]; None where one has none
    """

    scene: Scene
    flow: Flow
    edges: Floats
    times: Floats
    film: Floats
    sigma: Floats
    run: Floats
    remaining_run: Floats
    distance: Estimate
    floor: float
    curve_distance: Estimate
    time_off: Estimate | None
    warnings: list[str]

    def to_dict(self) -> dict[str, Any]:
        """Lengths in m, times in s from the opening."""
        return {
            "distance_m": as_pair(self.distance),
            "distance_of_equal_flows_m": self.floor,
            "curve_distance": as_pair(self.curve_distance),
            "discharge_time_run_s": self.scene.summary.get("discharge_time_s"),
            "discharge_time_film_s": as_pair(self.flow.discharge),
            "discharge_time_difference_s": as_pair(self.time_off),
            "outcome_run": self.scene.summary.get("outcome"),
            "outcome_film": self.flow.outcome,
            "times_s": numbers(self.times),
            "column_edges_m": numbers(self.edges),
            "lines_film_m": numbers(self.film),
            "sigma_film_m": numbers(self.sigma),
            "lines_run_m": numbers(self.run),
            "warnings": self.warnings,
        }

    def text(self) -> str:
        """Distances of lines, curves and discharge times."""
        d, c = self.distance, self.curve_distance
        apart = plus_minus(1e3 * d.value, 1e3 * (d.sigma or 0))
        lines = [
            f"lines    {apart} mm apart (rms over {d.trials}); "
            f"equal flows would be {1e3 * self.floor:.2g} mm apart",
            f"curve    {plus_minus(c.value, c.sigma)} of the filling apart (rms)",
        ]
        if self.time_off is not None:
            off = plus_minus(self.time_off.value, self.time_off.sigma)
            lines.append(f"time     the run's discharge takes {off} s more than the film's")
        else:
            ended = self.scene.summary.get("outcome", "unfinished")
            lines.append(f"time     no difference: run {ended}, film {self.flow.outcome}")
        return "\n".join(lines + [f"warning: {warning}" for warning in self.warnings])

    def figure(self) -> "Figure":
        """Lines of film and run every interval, both curves, and the lines' differences."""
        from matplotlib.figure import Figure

        both = np.isfinite(self.film) | np.isfinite(self.run)
        shown = np.flatnonzero(both.any(axis=(1, 2)))[:_PANELS]
        _, _, bottom, top = self.scene.window
        tall = _PANEL * (top - bottom) / float(np.ptp(self.edges)) + 0.8
        figure = Figure(figsize=(11, tall + 3.4), layout="constrained")
        grid = figure.add_gridspec(2, 1, height_ratios=[tall, 2.9])
        above = grid[0].subgridspec(1, max(len(shown), 3))
        for k, t in enumerate(shown):
            _lines(figure.add_subplot(above[0, k]), self, int(t), first=k == 0)
        below = grid[1].subgridspec(1, 2)
        _curves(figure.add_subplot(below[0]), self)
        _differences(figure.add_subplot(below[1]), self)
        d = plus_minus(1e3 * self.distance.value, 1e3 * (self.distance.sigma or 0))
        first = f"{self.flow.name} and {self.scene.headline}"
        equal = f"equal flows: {1e3 * self.floor:.2g} mm"
        headline(figure, f"{first}\nlines {d} mm apart ({equal})")
        return figure


def columns_of(folder: str | Path) -> tuple[int, float]:
    """Number of columns of a run's profiles, and the silo's inner width [m]."""
    edges = column_edges(read_scene(folder))
    return len(edges) - 1, float(np.ptp(edges))


def compared(folder: str | Path, flow: Flow) -> Comparison:
    """A run compared with a film; InputError where they have no line in common."""
    scene = read_scene(folder)
    if flow.silo.unit != "m":
        raise InputError("compare: the film has no scale; give --scale or --width")
    profile = measure(Path(folder), flow.interval)
    known = [_array(layer["lines_m"]) for layer in profile["layers"]]
    run = np.stack(known, axis=1)  # (t, l, c)
    film = np.array([p.lines for p in flow.profiles])
    sigma = np.array([p.sigma for p in flow.profiles])
    if film.shape[2] != run.shape[2]:
        raise InputError(f"compare: {film.shape[2]} columns of the film, {run.shape[2]} of the run")
    warnings = list(flow.warnings)
    if film.shape[1] != run.shape[1]:
        warnings.append(f"{film.shape[1]} layers in the film, {run.shape[1]} in the run: "
                        "the lowest are compared")  # fmt: skip
    times, layers = (min(a, b) for a, b in zip(film.shape[:2], run.shape[:2], strict=True))
    film, sigma, run = (part[:times, :layers] for part in (film, sigma, run))
    both = np.isfinite(film) & np.isfinite(run)
    if both.sum() < _FEWEST:
        raise InputError(
            "compare: the film and the run have no lines at the same position and time"
        )
    distance, floor = _distance(film[both] - run[both], sigma[both])
    remaining = _remaining(scene, flow.curve.time)
    return Comparison(
        scene, flow, flow.edges, np.array(profile["times_s"][:times]), film, sigma, run, remaining,
        distance, floor, _curve_distance(flow, remaining), _time_off(scene, flow), warnings,
    )  # fmt: skip


def _array(lines: list[Any]) -> Floats:
    return np.array([[np.nan if v is None else v for v in row] for row in lines], dtype=float)


def _distance(off: Floats, sigma: Floats) -> tuple[Estimate, float]:
    value = float(np.sqrt(np.mean(off**2)))
    floor = float(np.sqrt(np.mean(sigma**2)))
    # Lines of neighbouring columns share particles and scale: as if all errors went together.
    slope = float(np.mean(np.abs(off) * sigma)) / value if value > 0 else floor
    return Estimate(value, slope, len(off)), floor


def _remaining(scene: Scene, time: Floats) -> Floats:
    """Share of the run's mass that is in the silo at times from the opening (n,)."""
    left, mass = leavers(scene)
    whole = float(scene.trajectory.static["mass"].sum())
    gone = np.concatenate([[0.0], np.cumsum(mass)])[np.searchsorted(left, time, side="right")]
    return np.asarray(1 - gone / whole)


def _curve_distance(flow: Flow, remaining: Floats) -> Estimate:
    off = flow.curve.remaining - remaining
    return Estimate(float(np.sqrt(np.mean(off**2))), flow.curve.sigma, len(off))


def _time_off(scene: Scene, flow: Flow) -> Estimate | None:
    ended = scene.summary.get("discharge_time_s")
    if ended is None or flow.discharge is None:
        return None
    return Estimate(float(ended) - flow.discharge.value, flow.discharge.sigma, 1)


def _lines(axes: "Axes", found: Comparison, t: int, first: bool) -> None:
    left = found.scene.window[0]
    for wall in found.scene.walls:
        axes.plot(wall[:, 0] - left, wall[:, 1], color=WALL, lw=1.5)
    x = (found.edges[:-1] + found.edges[1:]) / 2
    for layer in range(found.film.shape[1]):
        axes.plot(x, found.run[t, layer], color=BLUE, lw=1.2)
        axes.errorbar(x, found.film[t, layer], found.sigma[t, layer], fmt="o", ms=2, lw=0.8,
                      color=VERMILION)  # fmt: skip
    axes.set(aspect="equal", xlabel="x [m]")
    axes.set_title(f"{found.times[t]:.3g} s", fontsize=9)
    if first:
        axes.set_ylabel("height above the outlet [m]")
    else:
        axes.tick_params(labelleft=False)


def _curves(axes: "Axes", found: Comparison) -> None:
    curve = found.flow.curve
    axes.plot(curve.time, found.remaining_run, color=BLUE, label="run, by mass")
    axes.plot(curve.time, curve.remaining, color=VERMILION, label="film, by area")
    if curve.sigma is not None:
        low, high = curve.remaining - curve.sigma, curve.remaining + curve.sigma
        axes.fill_between(curve.time, low, high, color=VERMILION, alpha=0.2, lw=0)
    axes.set_xlabel("time since the opening [s]")
    axes.set_ylabel("share that remains in the silo")
    axes.legend()


def _differences(axes: "Axes", found: Comparison) -> None:
    off = 1e3 * (found.film - found.run)
    for t, time in enumerate(found.times):
        known = np.isfinite(off[t])
        spread = np.linspace(-0.2, 0.2, max(int(known.sum()), 1)) * found.flow.interval
        axes.plot(time + spread[: known.sum()], off[t][known], ".", color=INK, ms=2)
    axes.axhline(0, color=GREY, lw=0.8)
    axes.set_xlabel("time since the opening [s]")
    axes.set_ylabel("line of the film less that of the run [mm]")
