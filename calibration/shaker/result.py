"""The result of a shaken record: tones, power, efficiency, and the diagnostic figure."""

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from calibration.shaker.phases import BedPhase
from calibration.shaker.record import Record
from calibration.statistics.uncertainty import Estimate, as_pair
from granulab.campaign.output.figure import BLUE, GREY, INK, ORANGE, VERMILION, headline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_DECADES = 8  # that a spectrum shows


class PhaseError(NamedTuple):
    """Phase of force before acceleration [rad] of an empty enclosure, and its sigma.

    limit    the largest that there may be, where it was assumed; None where it was measured
    """

    value: float
    sigma: float
    limit: float | None = None


@dataclass(frozen=True)
class Power(Estimate):
    """A power, or what is proportional to it.

    interval    holds 95 %, whatever the phase error up to the limit that was assumed
    """

    interval: tuple[float, float] = (-np.inf, np.inf)

    def times(self, factor: float) -> "Power":
        """The same times a factor above 0."""
        sigma = None if self.sigma is None else factor * self.sigma
        low, high = self.interval
        return Power(
            factor * self.value, sigma, self.trials, interval=(factor * low, factor * high)
        )


@dataclass(frozen=True)
class Tone:
    """One line of the sum: amplitudes, the phase error taken off, its power.

    phase_error_limit is the largest phase error that was assumed; None where the empty enclosure
    gave it, or the first tone's delay did.
    efficiency of a tone that is shaken: P_k/f_k over 4 V_k^2 M (eqs 7.8, 6.10); None for harmonics,
    whose motion is an accident, and without a particle mass.
    """

    frequency_hz: float
    force_n: float
    acceleration_m_s2: float
    phase_error_rad: float
    phase_error_sigma: float
    phase_error_limit: float | None
    power_w: float
    reactive_power_w: float
    sigma_w: float
    efficiency: float | None = None
    efficiency_sigma: float | None = None


@dataclass(frozen=True)
class Dissipation:
    """Power and efficiency of a shaken bed.

    gamma        A_1/g
    efficiency   None without a particle mass, or for several tones that are no harmonics
    phase        of the bed's motion; None likewise, and without a record of the empty enclosure
    record       of the enclosure with particles
    """

    frequency_hz: float
    gamma: float
    power: Power  # [W]
    energy_per_cycle: Power  # [J]
    efficiency: Power | None
    enclosure_mass_kg: float | None
    phase: BedPhase | None
    tones: tuple[Tone, ...]
    warnings: tuple[str, ...]
    record: Record

    def to_dict(self) -> dict[str, Any]:
        """The object that --json prints."""

        def known(one: Power | None) -> dict[str, float | None]:
            low, high = one.interval if one else (None, None)
            pair = as_pair(one) or {"value": None, "sigma": None}
            return {**pair, "low": low, "high": high}

        return {
            "frequency_hz": self.frequency_hz,
            "gamma": self.gamma,
            "dissipated_power_w": known(self.power),
            "energy_per_cycle_j": known(self.energy_per_cycle),
            "efficiency": known(self.efficiency),
            "enclosure_mass_kg": self.enclosure_mass_kg,
            "phase": self.phase and self.phase._asdict(),
            "tones": [asdict(tone) for tone in self.tones],
            "warnings": list(self.warnings),
        }

    def text(self) -> str:
        """The tones, and the power and efficiency that follow from them."""
        lines = [
            "tone [Hz]    force [N]    accel. [m/s2]    phase error [mrad]    power [W]"
            "                  efficiency"
        ]
        lines += [_line(tone) for tone in self.tones]
        rows = [("gamma", f"{self.gamma:.4g} g")]
        for name, one, unit in (
            ("dissipated power", self.power, " W"),
            ("energy per cycle", self.energy_per_cycle, " J"),
            ("efficiency", self.efficiency, ""),
        ):
            if one is not None:
                value = _shown(one.value, one.sigma, ".5g")
                low, high = one.interval
                rows.append((name, f"{value}{unit} ({low:.5g} to {high:.5g})"))
        if self.enclosure_mass_kg is not None:
            rows.append(("empty enclosure", f"{self.enclosure_mass_kg:.4g} kg"))
        if self.phase is not None:
            rows.append(("motional phase", self.phase.in_words()))
        lines += [f"{name:20} {value}" for name, value in rows]
        return "\n".join([*lines, *(f"warning: {words}" for words in self.warnings)])

    def figure(self) -> "Figure":
        """Spectra of force and acceleration; phase error, power, efficiency of each tone."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(11.0, 7.5), layout="constrained")
        halves = figure.add_gridspec(1, 2, width_ratios=[1.2, 1.0])
        spectra = halves[0].subgridspec(2, 1)
        force = figure.add_subplot(spectra[0])
        _spectrum(force, self.record, 0, "force [N]", [tone.force_n for tone in self.tones])
        moved = figure.add_subplot(spectra[1], sharex=force)
        heights = [tone.acceleration_m_s2 for tone in self.tones]
        _spectrum(moved, self.record, 1, "acceleration [m/s²]", heights)
        moved.set_xlabel("frequency [Hz]")
        force.legend(loc="upper right")
        rows = halves[1].subgridspec(3, 1)
        _phases(figure.add_subplot(rows[0]), self)
        _powers(figure.add_subplot(rows[1]), self)
        _efficiencies(figure.add_subplot(rows[2]), self)
        headline(figure, f"{self.record.path.name}: {_words(self)}")
        return figure


def _line(tone: "Tone") -> str:
    sigma, limit = tone.phase_error_sigma, tone.phase_error_limit
    phase = (
        f"{1e3 * tone.phase_error_rad:8.3f} ± {1e3 * sigma:.3f}" if limit is None
        else f"at most {1e3 * limit:.1f}"
    )  # fmt: skip
    line = (
        f"{tone.frequency_hz:9.3f}    {tone.force_n:9.4g}    {tone.acceleration_m_s2:13.4g}    "
        f"{phase:18}    {_shown(tone.power_w, tone.sigma_w, '.4g'):<23}"
    )
    if tone.efficiency is not None:
        line += f"    {_shown(tone.efficiency, tone.efficiency_sigma, '.4f')}"
    return line.rstrip()


def _shown(value: float, sigma: float | None, form: str) -> str:
    return f"{value:{form}}" + ("" if sigma is None else f" ± {sigma:.2g}")


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
    _marks(axes, found.tones, errors, [1e3 * t.phase_error_sigma for t in found.tones])
    axes.set_ylabel("phase taken off [mrad]")
    if found.tones[0].phase_error_limit is not None:
        axes.text(0.5, 0.6, "assumed: no empty record", transform=axes.transAxes, ha="center")


def _powers(axes: "Axes", found: Dissipation) -> None:
    powers, sigmas = [t.power_w for t in found.tones], [t.sigma_w for t in found.tones]
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
    positions = np.arange(len(tones))
    axes.axhline(0.0, color=INK, linewidth=0.6)
    axes.errorbar(positions, values, yerr=sigmas, fmt="o", color=BLUE, capsize=3)
    axes.set_xticks(positions, [f"{tone.frequency_hz:.4g}" for tone in tones])
    axes.set_xlim(-0.5, len(tones) - 0.5)
