"""The sheet by which a person judges found impacts: signal, energy, impacts, flights."""

from typing import TYPE_CHECKING

import numpy as np

from calibration.impacts.measure import Impacts
from calibration.statistics.quantity import plus_minus
from granulab.campaign.output.figure import BLUE, GREY, INK, ORANGE, VERMILION, headline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_COLUMNS = 3000  # of a drawn signal: more than a page can show


def draw_sheet(found: Impacts) -> "Figure":
    """Signal and energy against time with the impacts, each edge enlarged, flights and ratios."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 8.5), layout="constrained")
    rows = figure.add_gridspec(3, 1, height_ratios=[1.0, 1.0, 1.1])
    whole = figure.add_subplot(rows[0])
    _signal(whole, found)
    _level(figure.add_subplot(rows[1], sharex=whole), found)
    lowest = rows[2].subgridspec(1, 3)
    _edges(figure.add_subplot(lowest[0]), found)
    _flights(figure.add_subplot(lowest[1]), found)
    _ratios(figure.add_subplot(lowest[2]), found)
    one = found.restitution
    words = "no restitution" if one.value is None else f"e = {plus_minus(one.value, one.sigma)}"
    headline(figure, f"{found.signal.path.name}: {len(found.times_s)} impacts, {words}")
    return figure


def _signal(axes: "Axes", found: Impacts) -> None:
    """The range of the samples in each column of the drawing, and the impacts."""
    signal = found.signal
    x = signal.channels[:, 0]
    per = max(1, len(x) // _MOST_COLUMNS)
    columns = x[: len(x) // per * per].reshape(-1, per)
    t = signal.start + (np.arange(len(columns)) + 0.5) * per / signal.rate
    if per == 1:
        axes.plot(t, x, color=GREY, linewidth=0.8)
    else:
        axes.fill_between(t, columns.min(axis=1), columns.max(axis=1), color=GREY, linewidth=0)
    for time in found.times_s:
        axes.axvline(time, color=VERMILION, linewidth=0.8)
    axes.set_ylabel(signal.names[0])


def _level(axes: "Axes", found: Impacts) -> None:
    """Energy over the noise's, its threshold, what was taken and what was left out."""
    signal, search = found.signal, found.search
    t = signal.start + (np.arange(len(search.level)) + 2.0) * search.block / signal.rate
    axes.plot(t, search.level, color=BLUE, linewidth=0.8)
    axes.axhline(search.threshold, color=INK, linestyle=":", linewidth=0.8, label="noise")
    for times, colour, words in (
        (found.times_s, VERMILION, "impacts"),
        (np.array(found.rejected_times_s), ORANGE, "left out"),
    ):
        if len(times):
            near = np.interp(times + 0.5 * search.window / signal.rate, t, search.level)
            axes.plot(times, near, "o", color=colour, markersize=4, label=words)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("energy over noise [dB]")
    axes.legend(loc="upper right")


def _edges(axes: "Axes", found: Impacts) -> None:
    """The beginning of every impact, one over the other, each in parts of its largest sample."""
    signal, half = found.signal, found.search.window
    for k, time in enumerate(found.times_s):
        at = round((time - signal.start) * signal.rate)
        begin, end = max(0, at - half), min(len(signal.channels), at + half)
        x = signal.channels[begin:end, 0] - np.median(signal.channels[begin : at + 1, 0])
        t = signal.start + np.arange(begin, end) / signal.rate - time
        axes.plot(1e3 * t, x / max(np.abs(x).max(), 1e-300) + 1.2 * k, color=INK, linewidth=0.7)
    axes.axvline(0.0, color=VERMILION, linewidth=0.8)
    axes.set_xlabel("time from onset [ms]")
    axes.set_ylabel("impact, upwards")
    axes.set_yticks([])


def _flights(axes: "Axes", found: Impacts) -> None:
    """Flights on a logarithmic axis, where a constant restitution is a straight line."""
    flights = np.diff(found.times_s)
    axes.semilogy(np.arange(1, len(flights) + 1), flights, "o-", color=BLUE)
    axes.set_xticks(np.arange(1, len(flights) + 1))
    axes.set_xlabel("flight")
    axes.set_ylabel("duration [s]")


def _ratios(axes: "Axes", found: Impacts) -> None:
    """Restitution against impact speed, and the pooled value."""
    one = found.restitution
    axes.errorbar(
        one.impact_speeds_m_s, one.per_pair, yerr=one.per_pair_sigma, fmt="o", color=BLUE, capsize=2
    )
    if one.value is not None and one.sigma is not None:
        axes.axhspan(one.value - one.sigma, one.value + one.sigma, color=VERMILION, alpha=0.2)
        axes.axhline(one.value, color=VERMILION)
    axes.set_xlabel("impact speed [m/s]")
    axes.set_ylabel("restitution [-]")
