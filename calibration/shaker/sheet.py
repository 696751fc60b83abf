"""The sheet by which a person judges a shaken record: spectra, the tones, and what they give."""

from typing import TYPE_CHECKING

import numpy as np

from calibration.shaker.measure import Dissipation, Tone
from calibration.shaker.shaken import Record
from granulab.campaign.output.figure import BLUE, GREY, INK, ORANGE, VERMILION, headline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_DECADES = 8  # that a spectrum shows


def draw_sheet(found: Dissipation, loaded: Record) -> "Figure":
    """Spectra of force and acceleration with the tones; phase error, power, efficiency of each."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 7.5), layout="constrained")
    halves = figure.add_gridspec(1, 2, width_ratios=[1.2, 1.0])
    spectra = halves[0].subgridspec(2, 1)
    force = figure.add_subplot(spectra[0])
    _spectrum(force, loaded, 0, "force [N]", [tone.force_n for tone in found.tones])
    moved = figure.add_subplot(spectra[1], sharex=force)
    heights = [tone.acceleration_m_s2 for tone in found.tones]
    _spectrum(moved, loaded, 1, "acceleration [m/s²]", heights)
    moved.set_xlabel("frequency [Hz]")
    force.legend(loc="upper right")
    rows = halves[1].subgridspec(3, 1)
    _phases(figure.add_subplot(rows[0]), found)
    _powers(figure.add_subplot(rows[1]), found)
    _efficiencies(figure.add_subplot(rows[2]), found)
    headline(figure, f"{loaded.path.name}: {_words(found)}")
    return figure


def _words(found: Dissipation) -> str:
    def known(sigma: float | None) -> str:
        return "" if sigma is None else f" ± {sigma:.2g}"

    words = f"P = {found.power.value:.4g}{known(found.power.sigma)} W"
    if found.efficiency is None:
        return words
    return f"{words}, efficiency {found.efficiency.value:.4f}{known(found.efficiency.sigma)}"


def _spectrum(axes: "Axes", record: Record, row: int, label: str, heights: list[float]) -> None:
    """Amplitudes of the whole record, and those that were fitted to the tones."""
    from scipy.signal import periodogram

    line, power = periodogram(record.samples[row], record.rate, "hann", scaling="spectrum")
    shown = (line > 0.0) & (line <= record.frequencies.max() + record.frequencies.min())
    size = np.sqrt(2.0 * power[shown])
    axes.semilogy(line[shown], np.maximum(size, 1e-300), color=GREY, linewidth=0.7)
    given = record.shaken
    for part, colour, words in ((given, VERMILION, "shaken"), (~given, ORANGE, "harmonics")):
        axes.plot(record.frequencies[part], np.array(heights)[part], "o", color=colour,
                  markersize=5, markerfacecolor="none", label=words)  # fmt: skip
    axes.set_ylim(max(size.min(), size.max() * 10.0**-_DECADES), 3.0 * max(*heights, size.max()))
    axes.set_ylabel(label)


def _phases(axes: "Axes", found: Dissipation) -> None:
    errors = [1e3 * tone.phase_error_rad for tone in found.tones]
    _marks(axes, found.tones, errors, [1e3 * (t.phase_error_sigma or 0.0) for t in found.tones])
    axes.set_ylabel("phase taken off [mrad]")
    if found.tones[0].phase_error_sigma is None:
        axes.text(0.5, 0.6, "not known: no empty record", transform=axes.transAxes, ha="center")


def _powers(axes: "Axes", found: Dissipation) -> None:
    powers, sigmas = [t.power_w for t in found.tones], [t.sigma_w or 0.0 for t in found.tones]
    _marks(axes, found.tones, powers, sigmas)
    axes.set_ylabel("power [W]")


def _efficiencies(axes: "Axes", found: Dissipation) -> None:
    """Of the tones that are shaken; those of harmonics are not defined."""
    known = [(t.efficiency, t.efficiency_sigma) for t in found.tones]
    values = [np.nan if value is None else value for value, _ in known]
    _marks(axes, found.tones, values, [0.0 if sigma is None else sigma for _, sigma in known])
    axes.set_ylabel("efficiency [-]")
    axes.set_xlabel("tone [Hz]")
    if np.isnan(values).all():
        axes.text(0.5, 0.6, "give --particle-mass", transform=axes.transAxes, ha="center")


def _marks(axes: "Axes", tones: tuple[Tone, ...], values: list[float], sigmas: list[float]) -> None:
    """A value and its sigma for each tone, side by side, with the frequencies under them."""
    places = np.arange(len(tones))
    axes.axhline(0.0, color=INK, linewidth=0.6)
    axes.errorbar(places, values, yerr=sigmas, fmt="o", color=BLUE, capsize=3)
    axes.set_xticks(places, [f"{tone.frequency_hz:.4g}" for tone in tones])
    axes.set_xlim(-0.5, len(tones) - 0.5)
