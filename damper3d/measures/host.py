"""Response of a host: its motion with the damper beside the bare one, decay, energy of both.

Displacements count from static equilibrium with the bed's weight. The damping that the bed adds is
that of the viscous damper between the structure and the ground that takes as much from the same
motion, over twice the mass and angular frequency of the mode that is nearest to the excitation:

    zeta_added = W/(2 m w integral x'^2 dt),    W the enclosure's work on the bed

Under an excitation that is no sine it is the mode with the largest share of the bare response. A
mode that does not move the damper has none.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.engine.records import Samples
from damper3d.measures.counted import Cycles, harmonics, read_cycles
from damper3d.measures.efficiency import dissipated, held, stiffness_work
from granulab.campaign.output.figure import BLUE, GREY, headline
from granulab.campaign.runs.folder import RunFolder
from granulab.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DECAYS = ("0.5", "0.3", "0.2", "0.1")  # of the first root of the host's energy


def added_damping_ratio(samples: Samples, mode_mass: float, omega: float) -> float:
    """Damping ratio that the bed adds to a mode of this mass [kg] and frequency [rad/s]."""
    work = float(samples["wall_work"][-1] - samples["wall_work"][0])
    speed = samples["velocity"]
    time = np.diff(samples["time"])
    square = float((0.5 * (speed[1:] ** 2 + speed[:-1] ** 2) * time).sum())
    return work / (2.0 * mode_mass * omega * square)


def added_to_mode(cycles: Cycles, mode: int) -> dict[str, float | None]:
    """Damping ratio that the bed adds to a mode, by its number, and the mode's frequency [Hz]."""
    modes = cycles.case.modes
    assert modes is not None
    shape, omega = float(modes.shape[mode]), float(modes.omega[mode])
    ratio = added_damping_ratio(cycles.counted, shape**-2.0, omega) if shape else None
    return {"added_damping_ratio": ratio, "added_damping_mode_hz": omega / (2.0 * math.pi)}


def leading_mode(cycles: Cycles) -> int:
    """Number of the mode whose bare response alone has the largest mean square over the windows.

    On a base that moves, of the displacements relative to it.
    """
    case, time = cycles.case, cycles.samples["time"]
    assert case.modes is not None
    assert case.excitation is not None
    base = case.excitation.base_displacement(time)
    squares = [
        float(
            np.mean((replace(case, modes=case.modes.only(r)).bare_displacement(time) - base) ** 2)
        )
        for r in range(len(case.modes.omega))
    ]
    return int(np.argmax(squares))


def decay_times(time: np.ndarray, energy: np.ndarray) -> dict[str, float | None]:
    """Last time [s] that the root of the energy over its first value passes each of DECAYS.

    None where it is not reached.
    """
    root = np.sqrt(energy / energy[0])
    found: dict[str, float | None] = {}
    for key in DECAYS:
        level = float(key)
        above = np.flatnonzero(root >= level)
        last = int(above[-1])
        if last == len(root) - 1:
            found[key] = None
            continue
        part = (root[last] - level) / (root[last] - root[last + 1])
        found[key] = float(time[last] + part * (time[last + 1] - time[last]))
    return found


def closure_of(beds: Sequence[Samples], weights: Sequence[float]) -> float | None:
    """Energy of a host and the beds of its dampers that is unaccounted for, over what moved it [-].

    weights: of the beds at rest, along the motion [N], whose work on the host displacements from
    equilibrium leave out. Work of force and base = change of the host's energy + its own damping +
    what the beds dissipate + change of their energy; what moved it is that work, or the energy of
    a host that was let go.
    """

    def change(samples: Samples, name: str) -> float:
        return float(samples[name][-1] - samples[name][0])

    host = beds[0]
    left = change(host, "host_work") - change(host, "host_damping") - change(host, "host_energy")
    for samples, weight in zip(beds, weights, strict=True):
        sunk = weight * change(samples, "displacement")
        own = float(held(samples)[-1] - held(samples)[0])
        lost = float(dissipated(samples)[-1] - stiffness_work(samples)[-1])
        left = left - sunk - own - lost
    moved = max(abs(change(host, "host_work")), float(host["host_energy"][0]))
    return left / moved if moved else None


def numbers(cycles: Cycles) -> dict[str, Any]:
    """Response of the host in the counted cycles, as a run's Result has it under `host`."""
    case, samples, counted = cycles.case, cycles.samples, cycles.counted
    assert case.modes is not None
    if case.excitation is not None:
        return _under_excitation(cycles)
    mode = case.modes.nearest(2.0 * math.pi / case.period)
    amplitude = None if case.is_decay else cycles.amplitude
    return {
        "amplitude_m": amplitude,
        "amplitude_rad": None if case.arc is None or amplitude is None else amplitude / case.arc,
        "rms_m": float(np.sqrt(np.mean(counted["displacement"][1:] ** 2))),
        "bare_amplitude_m": case.amplitude,
        "reduction": None if amplitude is None else amplitude / case.amplitude,
        **added_to_mode(cycles, mode),
        "decay_times_s": (
            decay_times(samples["time"], samples["host_energy"]) if case.is_decay else None
        ),
        "energy_closure": closure_of([samples], [case.weight]),
    }


def _under_excitation(cycles: Cycles) -> dict[str, Any]:
    """The same where no one sine moves the host: its rms over that of the bare one, and peaks.

    Displacements are relative to a base that moves.
    """
    case, samples, counted = cycles.case, cycles.samples, cycles.counted
    assert case.modes is not None
    assert case.excitation is not None
    mode = leading_mode(cycles)
    bare, whole = _both(cycles)
    own = whole[-len(counted["time"]) :]
    bare_rms = float(np.sqrt(np.mean(bare[-len(own) + 1 :] ** 2)))
    rms = float(np.sqrt(np.mean(own[1:] ** 2)))
    shocked = case.excitation.kind == "shock"
    # 4.34/sqrt(B T) dB of a resonance of B = pi zeta f, seen for a time T
    band = 0.5 * float(case.modes.damping_ratio[mode] * case.modes.omega[mode])
    seen = band * case.period * (len(own) - 1) / cycles.per_cycle
    noisy = case.excitation.kind == "random" and seen > 0
    return {
        "amplitude_m": None,
        "rms_m": rms,
        "bare_rms_m": bare_rms,
        "peak_m": float(np.abs(own).max()),
        "bare_amplitude_m": float(np.abs(bare).max()),
        "reduction": rms / bare_rms,
        "bare_scatter_db": 4.34 / math.sqrt(seen) if noisy else None,
        **added_to_mode(cycles, mode),
        "decay_times_s": _after_pulse(cycles) if shocked else None,
        "energy_closure": closure_of([samples], [case.weight]),
    }


def _after_pulse(cycles: Cycles) -> dict[str, float | None]:
    """Decay times [s] from the moment at which the host's energy is largest."""
    energy, time = cycles.samples["host_energy"], cycles.samples["time"]
    top = int(np.argmax(energy))
    return decay_times(time[top:] - time[top], energy[top:])


def measure(folder: Path) -> dict[str, Any]:
    """Response of the host of a run; FolderError as read_cycles, InputError without a host.

    The energy of several dampers is what the run has found of all together, else None.
    """
    cycles, run = _on_host(folder), RunFolder(folder)
    found = numbers(cycles)
    if cycles.case.dampers:
        summary = run.read_summary() if run.state == "finished" else {"host": {}}
        found["energy_closure"] = summary["host"].get("energy_closure")
    return found


def _on_host(folder: Path) -> Cycles:
    cycles = read_cycles(folder)
    if cycles.case.modes is None:
        raise InputError(
            f"{folder}: its enclosure has a prescribed motion; a [host] in the case has a response"
        )
    return cycles


def draw(folder: Path) -> "Figure":
    """Motion of the host with the damper and bare; envelope or amplitude of each cycle."""
    from matplotlib.figure import Figure

    cycles = _on_host(folder)
    figure = Figure(figsize=(9.6, 6.4), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True)
    chart(cycles, above)
    _sizes(cycles, below)
    below.set_xlabel("time [s]")
    at = cycles.case.settings.host.at
    where = cycles.case.name if at is None else f"{cycles.case.name}, {at}"
    headline(figure, f"{where}: {in_words(numbers(cycles))}")
    return figure


def _both(cycles: Cycles) -> tuple[np.ndarray, np.ndarray]:
    """Displacement (n,) [m] bare and with the damper, under an excitation relative to its base."""
    case, time = cycles.case, cycles.samples["time"]
    bare, own = case.bare_displacement(time), cycles.samples["displacement"]
    if case.excitation is None:
        return bare, own
    base = case.excitation.base_displacement(time)
    return bare - base, own - base


def chart(cycles: Cycles, axes: Any) -> None:
    """Displacement against time, with and without the damper."""
    samples = cycles.samples
    time = samples["time"]
    bare = cycles.case.bare_displacement(time)
    axes.plot(time, 1e3 * bare, color=GREY, lw=0.6, label="bare")
    axes.plot(time, 1e3 * samples["displacement"], color=BLUE, lw=0.8, label="with the damper")
    axes.set_ylabel("displacement [mm]")
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.0)


def _sizes(cycles: Cycles, axes: Any) -> None:
    """First harmonic of each cycle; of a decay the root of the host's energy, and its envelope."""
    samples, case = cycles.samples, cycles.case
    if case.is_decay:
        root = np.sqrt(samples["host_energy"] / samples["host_energy"][0])
        axes.semilogy(samples["time"], root, color=BLUE, label="with the damper")
        assert case.modes is not None
        slowest = float((case.modes.damping_ratio * case.modes.omega).min())
        axes.semilogy(samples["time"], np.exp(-slowest * samples["time"]), color=GREY, label="bare")
        axes.set(ylabel="root of the energy over its first [-]", ylim=(0.03, 1.3))
    elif case.excitation is not None:
        bare, own = _both(cycles)
        for name, values, colour in (("bare", bare, GREY), ("with the damper", own, BLUE)):
            square = values[1:].reshape(-1, cycles.per_cycle) ** 2
            end = samples["time"][cycles.per_cycle :: cycles.per_cycle]
            rms = 1e3 * np.sqrt(square.mean(axis=1))
            axes.plot(end, rms, "o-", color=colour, ms=3, lw=0.8, label=name)
        axes.set(ylabel="rms of a window [mm]", ylim=(0, None))
    else:
        each = np.abs(harmonics(samples["displacement"], cycles.per_cycle))
        end = samples["time"][cycles.per_cycle :: cycles.per_cycle]
        axes.plot(end, 1e3 * each, "o-", color=BLUE, ms=3, lw=0.8, label="with the damper")
        axes.axhline(1e3 * case.amplitude, color=GREY, label="bare")
        axes.axvspan(end[cycles.first] - case.period, end[-1], color=BLUE, alpha=0.08)
        axes.set(ylabel="first harmonic of a cycle [mm]", ylim=(0, None))
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.0)


def in_words(found: dict[str, Any]) -> str:
    """The response of a host in a line; found: its numbers."""
    if found["amplitude_m"] is None and "bare_rms_m" in found:
        spread = found["bare_scatter_db"]
        scatter = "" if spread is None else f" (which chance moves by {spread:.2g} dB)"
        return (
            f"rms {1e3 * found['rms_m']:.4g} mm, {found['reduction']:.3g} of the bare "
            f"{1e3 * found['bare_rms_m']:.4g} mm{scatter}; largest {1e3 * found['peak_m']:.4g} mm, "
            f"bare {1e3 * found['bare_amplitude_m']:.4g} mm; {_added_in_words(found)}"
        )
    if found["decay_times_s"] is None:
        return (
            f"amplitude {1e3 * found['amplitude_m']:.4g} mm, {found['reduction']:.3g} of the bare "
            f"{1e3 * found['bare_amplitude_m']:.4g} mm; {_added_in_words(found)}"
        )
    times = [
        f"{key} after {time:.4g} s" for key, time in found["decay_times_s"].items()
        if time is not None
    ]  # fmt: skip
    start, reached = 1e3 * found["bare_amplitude_m"], ", ".join(times) or "nothing yet"
    return f"decay from {start:.4g} mm to {reached}; {_added_in_words(found)}"


def _added_in_words(found: dict[str, Any]) -> str:
    added, own = found["added_damping_ratio"], found.get("added_damping_mode_hz")
    mode = "the mode" if own is None else f"the mode at {own:.4g} Hz"
    if added is None:
        return f"no damping ratio, as {mode} does not move the damper"
    return f"damping ratio {added:.3g} added to {mode}"
