"""Response to an excitation that is no single sine: what it was, sweeps by frequency, spectra."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.engine.records import per_cycle_change
from damper3d.measures import host
from damper3d.measures.counted import Cycles, most_energy, read_cycles
from damper3d.measures.efficiency import lost
from granulab.campaign.output.figure import BLUE, GREY, VERMILION, headline
from granulab.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def numbers(cycles: Cycles) -> dict[str, Any]:
    """Numbers of what moved the enclosure, as a run's Result has it under `excitation`.

    most_energy_j is the reference of the efficiency over the windows that count.
    """
    case, counted = cycles.case, cycles.counted
    own, most = case.excitation, most_energy(cycles)
    assert own is not None
    rim = own.rim_velocity(counted["time"])
    velocity = counted["velocity"] if rim is None else rim
    acceleration = _acceleration(velocity, counted["time"])
    place = counted["displacement"]
    if rim is not None and own.lines is not None and own.rim is not None:
        place = own.rim * own.lines.at(counted["time"])[0]
    across = own.across(counted["time"])
    if across is not None:  # of two directions the sizes of both together
        acceleration = np.hypot(acceleration, _acceleration(across[1], counted["time"]))
        place, velocity = np.hypot(place, across[0]), np.hypot(velocity, across[1])
    return {
        "kind": own.kind,
        "on": own.on,
        "window_s": own.window,
        "peak_displacement_m": float(np.abs(place).max()),
        "peak_velocity_m_s": float(np.abs(velocity).max()),
        "rms_acceleration_m_s2": float(np.sqrt(np.mean(acceleration**2))),
        "most_energy_j": float(most[-1] - most[cycles.first]),
        "band_error_db": own.band_error,
        "taken_off": None if own.taken_off is None else {
            "mean_acceleration_m_s2": own.taken_off.acceleration,
            "mean_velocity_m_s": own.taken_off.velocity,
            "start_velocity_m_s": float(own.motion.rate[0]),
        },
        "sweep": None if own.sweep is None else swept(cycles),
    }  # fmt: skip


def _acceleration(velocity: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Mean acceleration (n - 1,) of each sample [m/s2]."""
    return np.asarray(np.diff(velocity) / np.diff(time))


def swept(cycles: Cycles) -> list[dict[str, Any]]:
    """Each window of a sweep: frequency, way, amplitude with the damper and bare, power.

    An amplitude is half of largest less least displacement over the window, or over a cycle of its
    frequency where that takes longer. Of a stepped sweep the change from the frequency before is
    left out of the amplitude; the power is of the whole window.
    """
    case, samples = cycles.case, cycles.samples
    assert case.excitation is not None
    sweep = case.excitation.sweep
    assert sweep is not None
    time, window = samples["time"], case.excitation.window
    middle = window * (np.arange((len(time) - 1) // cycles.per_cycle) + 0.5)
    frequency, held = sweep.frequency(middle), sweep.is_held(time)
    bare = None if case.modes is None else case.bare_displacement(time)
    power = per_cycle_change(lost(samples), cycles.per_cycle) / window
    rows = []
    for k, (at, f) in enumerate(zip(middle.tolist(), frequency.tolist(), strict=True)):
        half = max(0.5 * window, 0.5 / f)
        near = held & (np.abs(time - at) <= half * (1 + 1e-9))
        rows.append(
            {
                "frequency_hz": f,
                "way": "there" if at < sweep.length else "back",
                "amplitude_m": _half_span(samples["displacement"][near]),
                "bare_amplitude_m": None if bare is None else _half_span(bare[near]),
                "dissipated_power_w": float(power[k]),
            }
        )
    return rows


def _half_span(values: np.ndarray) -> float:
    return 0.5 * float(values.max() - values.min())


def spectrum(cycles: Cycles, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [Hz] and density [(m/s2)^2/Hz] of an acceleration, from the velocity's rows.

    Welch's mean over parts of a quarter of the counted time, with Hann's window.
    """
    from scipy.signal import welch

    step = cycles.case.time_step * cycles.case.steps_per_sample
    part = max((len(velocity) - 1) // 4, 8)
    frequency, density = welch(np.diff(velocity) / step, 1.0 / step, nperseg=part)
    return frequency[1:], density[1:]


def measure(folder: Path) -> dict[str, Any]:
    """Numbers of a run's excitation; FolderError as read_cycles, InputError for a sine."""
    return numbers(_excited(folder))


def _excited(folder: Path) -> Cycles:
    cycles = read_cycles(folder)
    if cycles.case.excitation is None:
        raise InputError(f"{folder}: is moved by one sine; a case with [excitation] is meant")
    return cycles


def draw(folder: Path) -> "Figure":
    """A sweep by its frequency, there and back; of others time and spectrum of the motion."""
    from matplotlib.figure import Figure

    cycles = _excited(folder)
    case = cycles.case
    assert case.excitation is not None
    figure = Figure(figsize=(9.6, 6.4), layout="constrained")
    headline(
        figure, f"{case.name}: {case.excitation.words}, gamma {case.settings.motion.gamma:.3g}"
    )
    above, below = figure.subplots(2, 1)
    if case.excitation.sweep is not None:
        _draw_sweep(cycles, above, below)
    else:
        _draw_motion(cycles, above, below)
    return figure


def _draw_sweep(cycles: Cycles, above: Any, below: Any) -> None:
    rows = swept(cycles)
    for way, colour in (("there", BLUE), ("back", VERMILION)):
        own = [row for row in rows if row["way"] == way]
        if not own:
            continue
        frequency = [row["frequency_hz"] for row in own]
        size = [1e3 * row["amplitude_m"] for row in own]
        above.plot(frequency, size, color=colour, label=way)
        if own[0]["bare_amplitude_m"] is not None:
            bare = [1e3 * row["bare_amplitude_m"] for row in own]
            above.plot(frequency, bare, color=GREY, lw=0.8, ls="-" if way == "there" else ":",
                       label=f"bare, {way}")  # fmt: skip
        below.plot(frequency, [row["dissipated_power_w"] for row in own], color=colour, label=way)
    above.set(ylabel="amplitude [mm]", ylim=(0, None))
    below.set(xlabel="frequency [Hz]", ylabel="dissipated power [W]")
    above.legend()


def _draw_motion(cycles: Cycles, above: Any, below: Any) -> None:
    samples, case = cycles.samples, cycles.case
    time = samples["time"]
    if case.modes is not None:
        host.chart(cycles, above)
    else:
        above.plot(time, 1e3 * samples["displacement"], color=BLUE, lw=0.7, label="enclosure")
        above.set_ylabel("displacement [mm]")
        above.legend()
    above.set_xlabel("time [s]")
    assert case.excitation is not None
    frequency, density = spectrum(cycles, samples["velocity"])
    below.loglog(frequency, density, color=BLUE, lw=0.8, label="with the damper")
    if case.modes is not None:
        bare = np.gradient(case.bare_displacement(time), time)
        below.loglog(*spectrum(cycles, bare), color=GREY, lw=0.8, label="bare")
    high = 3.0 * case.excitation.highest
    top = max(line.get_ydata()[line.get_xdata() <= high].max() for line in below.lines)
    below.set(xlim=(frequency[0], high), ylim=(1e-5 * top, 3 * top))
    below.set(xlabel="frequency [Hz]", ylabel="PSD of its acceleration [(m/s\u00b2)\u00b2/Hz]")
    below.legend()


def in_words(found: dict[str, Any]) -> str:
    """Words on what moved the enclosure, in a line; found: its numbers."""
    text = (
        f"{found['kind']}: largest displacement {1e3 * found['peak_displacement_m']:.4g} mm, "
        f"velocity {found['peak_velocity_m_s']:.4g} m/s, rms acceleration "
        f"{found['rms_acceleration_m_s2'] / 9.81:.3g} g"
    )
    if found["sweep"]:
        top = max(found["sweep"], key=lambda row: float(row["amplitude_m"]))
        text += f"; largest amplitude at {top['frequency_hz']:.4g} Hz, {top['way']}"
    return text
