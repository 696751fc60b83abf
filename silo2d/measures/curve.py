"""Discharge curve and rate: what has left when, how fast, and where the flow is steady.

    W(t) = (N(t + w/2) - N(t - w/2))/w      over a moving window w, from the exact times of leaving
    error of W(t) = sqrt(F N_w)/w           N_w particles in the window

F, the Fano factor, is variance over mean of the numbers that leave in windows that follow each
other in the steady part: 1 for particles that leave independently of each other (Poisson), less for
a regular flow, more for an intermittent one. With fewer than four such windows it is taken as 1.

The steady part is the longest time over which W stays within 25 % of the mean rate (0.8 n over the
time between 10 % and 90 % out), by the middles of the windows. The window is a tenth of the time
between 10 % and 90 % out unless given.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from granulab.campaign.output.figure import BLUE, GREEN, GREY, INK, headline
from silo2d.measures.basics.particles import FEWEST_OUT, Series, leavers
from silo2d.run.numbers import discharge_measures
from silo2d.view.scene import read_scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TOLERANCE = 0.25  # of the mean rate
_PER_WINDOW = 4  # positions at which the moving window is set, in one window
_STEADY = [
    "steady_from_s",
    "steady_until_s",
    "steady_rate_per_s",
    "steady_rate_error_per_s",
    "steady_mass_flow_kg_per_s",
    "steady_mass_flow_error_kg_per_s",
    "fano_factor",
]
_NO_PART = "no steady part: at no time do particles leave at a rate near the mean"
_FEWEST_WINDOWS = 4  # for a Fano factor


@dataclass(frozen=True)
class Steady:
    """The part of a discharge where the flow is steady.

    start, end    [s]; n particles and mass [kg] leave between them
    fano          variance over mean of the numbers in windows (1 where there are too few)
    """

    start: float
    end: float
    n: int
    mass: float
    fano: float

    @property
    def rate(self) -> float:
        """Particles a second."""
        return self.n / (self.end - self.start)

    @property
    def relative_error(self) -> float:
        """Standard error of the rate over the rate: sqrt(F n)/n."""
        return float(np.sqrt(self.fano / self.n))

    @property
    def mass_flow(self) -> float:
        """[kg/s]."""
        return self.mass / (self.end - self.start)


def usual_window(times: Series) -> float | None:
    """A tenth of the time between 10 % and 90 % out [s]; None where too few leave for a rate."""
    if len(times) < FEWEST_OUT:
        return None
    between = float(np.quantile(times, 0.9) - np.quantile(times, 0.1))
    return between / 10 if between > 0 else None


def moving_rate(times: Series, weights: Series, window: float) -> tuple[Series, Series]:
    """Middles of the moving window (m,) [s] and what leaves in it, over it (m,) [1/s].

    times      of leaving (n,) [s], ascending; weights (n,), ones or masses
    """
    # From the opening until the last window that is full of the discharge.
    count = max(int((times[-1] - window) / (window / _PER_WINDOW)) + 1, 1)
    middles: Series = window * (0.5 + np.arange(count) / _PER_WINDOW)
    total: Series = np.concatenate([[0.0], np.cumsum(weights)])
    ends = (np.searchsorted(times, middles + side * window / 2) for side in (-1, 1))
    before, after = (total[end] for end in ends)
    return middles, (after - before) / window


def steady_part(times: Series, mass: Series, window: float | None = None) -> Steady | None:
    """The part where the flow is steady, for leavers (n,); None where there is no rate, or none
    leaves in it, as beside the burst that a gate takes along."""
    window = window or usual_window(times)
    mean = discharge_measures(times, mass)["mean_rate_per_s"]
    if window is None or mean is None:
        return None
    middles, rate = moving_rate(times, np.ones(len(times)), window)
    start, end = _longest(np.abs(rate / mean - 1) <= TOLERANCE)
    if end - start < 2:
        return None
    # Where it is steady was chosen by the scatter, which would be too small there.
    first, last = np.quantile(times, (0.1, 0.9))
    scatter = _fano(times, float(first), float(last), window)
    return part_between(times, mass, middles[start], middles[end - 1], window, scatter)


def part_between(
    times: Series, mass: Series, start: float, end: float, window: float, fano: float | None = None
) -> Steady | None:
    """The part of a discharge between two times [s]; None where nothing leaves between them.

    Its Fano factor is of windows [s] of the same part unless given.
    """
    counted = (times >= start) & (times < end)
    if not counted.any():
        return None
    fano = _fano(times, start, end, window) if fano is None else fano
    return Steady(float(start), float(end), int(counted.sum()), float(mass[counted].sum()), fano)


def _fano(times: Series, start: float, end: float, window: float) -> float:
    """Variance over mean of the numbers in windows between two times [s], about a straight line.

    1, that of independent particles, of too few windows.
    """
    edges = start + window * np.arange(int((end - start) / window + 1e-9) + 1)
    numbers = np.diff(np.searchsorted(times, edges)).astype(float)
    n = len(numbers)
    if n < _FEWEST_WINDOWS or numbers.sum() == 0:
        return 1.0
    lines = np.vander(np.arange(n) - (n - 1) / 2, 2)
    left = numbers - lines @ np.linalg.lstsq(lines, numbers, rcond=None)[0]
    return float((left**2).sum() / (n - 2) / numbers.mean())


def _longest(holds: np.ndarray) -> tuple[int, int]:
    """First index and end of the longest stretch of true."""
    steps = np.diff(np.concatenate([[0], holds.astype(int), [0]]))
    starts, ends = np.flatnonzero(steps == 1), np.flatnonzero(steps == -1)
    if len(starts) == 0:
        return 0, 0
    k = int(np.argmax(ends - starts))
    return int(starts[k]), int(ends[k])


def measure(folder: Path, window: float | None = None) -> dict[str, Any]:
    """Rates [1/s and kg/s] with errors, the steady part [s], and the curve itself.

    Raises InputError where no particle left.
    """
    times, mass = leavers(read_scene(folder), 1, "a discharge curve")
    known = discharge_measures(times, mass)
    window = window or usual_window(times)
    steady = steady_part(times, mass, window)
    numbers: dict[str, Any] = {
        "n_out": len(times),
        "window_s": window,
        "mean_rate_per_s": known["mean_rate_per_s"],
        "mean_mass_flow_kg_per_s": known["mean_mass_flow_kg_per_s"],
        **_of(steady),
    }
    if window is not None:
        middles, rate = moving_rate(times, np.ones(len(times)), window)
        fano = steady.fano if steady else 1.0
        numbers |= {
            "times_s": middles.tolist(),
            "rate_per_s": rate.tolist(),
            "rate_error_per_s": np.sqrt(fano * rate / window).tolist(),
            "mass_flow_kg_per_s": moving_rate(times, mass, window)[1].tolist(),
        }
    return {**numbers, "out_times_s": times.tolist(), "out_mass_kg": np.cumsum(mass).tolist()}


def _of(steady: Steady | None) -> dict[str, Any]:
    if steady is None:
        return dict.fromkeys(_STEADY) | {"steady_note": _NO_PART}
    rate, flow, off = steady.rate, steady.mass_flow, steady.relative_error
    values = [steady.start, steady.end, rate, off * rate, flow, off * flow, steady.fano]
    return dict(zip(_STEADY, values, strict=True)) | {"steady_note": None}


def draw(folder: Path) -> "Figure":
    """The curve above, the rates below it, the steady part shaded."""
    from matplotlib.figure import Figure

    scene, numbers = read_scene(folder), measure(folder)
    figure = Figure(figsize=(7.5, 6.4), layout="constrained")
    headline(figure, scene.headline)
    curve, rate = figure.subplots(2, 1, sharex=True)
    times = [0.0, *numbers["out_times_s"]]
    curve.step(times, range(len(times)), where="post", color=INK)
    curve.set_ylabel("particles out")
    if numbers["window_s"] is not None:
        _draw_rate(rate, numbers)
    else:
        words = f"no rate: it takes {FEWEST_OUT} particles that do not leave at once"
        rate.set_title(words, loc="left", fontsize=9)
    rate.set_ylabel("particles/s")
    rate.set_xlabel("time since the opening [s]")
    for axes in (curve, rate):
        axes.grid(axis="y")
        axes.set_ylim(bottom=0)
        axes.set_xlim(left=0)
        if numbers["steady_from_s"] is not None:
            axes.axvspan(numbers["steady_from_s"], numbers["steady_until_s"], color=GREEN,
                         alpha=0.12, lw=0)  # fmt: skip
    return figure


def _draw_rate(axes: "Axes", numbers: dict[str, Any]) -> None:
    """The moving rate with its error, in particles on the left and in kg/s on the right."""
    times, rate, error = (
        np.array(numbers[k]) for k in ("times_s", "rate_per_s", "rate_error_per_s")
    )
    axes.fill_between(times, rate - error, rate + error, color=BLUE, alpha=0.2, lw=0)
    axes.plot(times, rate, color=BLUE, label=f"over {1e3 * numbers['window_s']:.0f} ms")
    axes.axhline(numbers["mean_rate_per_s"], color=GREY, lw=0.8, ls=(0, (4, 2)),
                 label="mean, 10 to 90 % out")  # fmt: skip
    if (steady := numbers["steady_rate_per_s"]) is not None:
        off, flow = numbers["steady_rate_error_per_s"], numbers["steady_mass_flow_kg_per_s"]
        words = f"steady: {steady:.0f} \N{PLUS-MINUS SIGN} {off:.0f} particles/s, {flow:.2f} kg/s"
        axes.plot([numbers["steady_from_s"], numbers["steady_until_s"]], [steady, steady],
                  color=GREEN, lw=1.8, label=words)  # fmt: skip
    else:
        axes.plot([], [], ls="none", label="no steady part")
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, borderaxespad=0.2)
    mean_mass = numbers["out_mass_kg"][-1] / numbers["n_out"]
    right = axes.secondary_yaxis("right", functions=(lambda n: n * mean_mass,
                                                     lambda w: w / mean_mass))  # fmt: skip
    right.set_ylabel("kg/s, at the mean mass of a particle")
