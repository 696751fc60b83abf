"""The result of a signal with impacts: times, restitution, and the diagnostic figure."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from calibration.files.signals import Signal
from calibration.impacts.ratios import Restitution
from calibration.impacts.search import Search
from calibration.result import AsText, Parameter
from calibration.statistics.quantity import plus_minus
from calibration.statistics.uncertainty import Estimate
from granulab.campaign.output.figure import BLUE, GREY, INK, ORANGE, VERMILION, headline
from granulab.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_COLUMNS = 3000  # of a drawn signal: more than a page can show


@dataclass(frozen=True, repr=False)
class Impacts(AsText):
    """Impacts in a signal and the restitution that follows.

    times_s, sigmas_s   (n,) of the impacts, and their standard uncertainty
    rejected_times_s    events that are no impacts of the row: echoes, ringing, knocks
    first_restitution   from the drop height and the first flight; None without a height
    """

    signal: Signal
    search: Search
    times_s: NDArray[np.float64]
    sigmas_s: NDArray[np.float64]
    rejected_times_s: tuple[float, ...]
    restitution: Restitution
    first_restitution: Estimate | None
    warnings: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """The object that --json prints."""
        found, first = self.restitution, self.first_restitution
        return {
            "impact_times_s": self.times_s.tolist(),
            "impact_sigmas_s": self.sigmas_s.tolist(),
            "flights_s": np.diff(self.times_s).tolist(),
            "restitution": {
                "value": found.value,
                "sigma": found.sigma,
                "per_pair": list(found.per_pair),
                "per_pair_sigma": list(found.per_pair_sigma),
                "impact_speeds_m_s": list(found.impact_speeds_m_s),
                "constant_within_noise": found.constant_within_noise,
                "p": found.p,
            },
            "first_restitution": None if first is None else first.value,
            "first_restitution_sigma": None if first is None else first.sigma,
            "rejected_times_s": list(self.rejected_times_s),
            "rate_hz": self.signal.rate,
            "warnings": list(self.warnings),
        }

    def text(self) -> str:
        """Impacts, pairs of flights and the restitution, a line each."""
        lines = [f"impact  {'time [s]':28}flight [s]"]
        for k, (time, sigma) in enumerate(zip(self.times_s, self.sigmas_s, strict=True)):
            flight = f"{self.times_s[k + 1] - time:.6f}" if k + 1 < len(self.times_s) else "-"
            lines.append(f"{k + 1:6d}  {plus_minus(time, sigma):28}{flight}")
        one = self.restitution
        for k, (value, sigma, speed) in enumerate(
            zip(one.per_pair, one.per_pair_sigma, one.impact_speeds_m_s, strict=True), start=2
        ):
            lines.append(f"impact {k}: e = {plus_minus(value, sigma)} at {speed:.2f} m/s")
        if one.value is not None and one.sigma is not None:
            p = "" if one.p is None else f" (p = {one.p:.2g} that one number describes the pairs)"
            lines.append(f"restitution {plus_minus(one.value, one.sigma)}{p}")
        if (first := self.first_restitution) is not None:
            said = plus_minus(first.value, first.sigma)
            lines.append(f"drop height and first flight: {said}")
        return "\n".join([*lines, *(f"warning: {words}" for words in self.warnings)])

    def parameters(self) -> dict[str, Parameter]:
        """The pooled restitution; InputError where the signal gives none."""
        one = self.restitution
        if one.value is None:
            raise InputError(f"{self.signal.path}: no restitution to write: {self.warnings[0]}")
        known = Estimate(one.value, one.sigma, max(1, len(one.per_pair)))
        return {"restitution": Parameter(known, "impact times")}

    def figure(self) -> "Figure":
        """Signal and energy against time with the impacts, enlarged edges, flights, ratios."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(11.0, 8.5), layout="constrained")
        rows = figure.add_gridspec(3, 1, height_ratios=[1.0, 1.0, 1.1])
        whole = figure.add_subplot(rows[0])
        _signal(whole, self)
        _level(figure.add_subplot(rows[1], sharex=whole), self)
        lowest = rows[2].subgridspec(1, 3)
        _edges(figure.add_subplot(lowest[0]), self)
        _flights(figure.add_subplot(lowest[1]), self)
        _ratios(figure.add_subplot(lowest[2]), self)
        one = self.restitution
        words = "no restitution" if one.value is None else f"e = {plus_minus(one.value, one.sigma)}"
        headline(figure, f"{self.signal.path.name}: {len(self.times_s)} impacts, {words}")
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
