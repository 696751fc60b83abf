"""The host of an enclosure: what excites its modes, and the bare response in closed form."""

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from damper3d.case.excitation.excitation import (
    Excitation,
    Peaks,
    excitation_of,
    peaks_of,
    rim_of,
    under,
)
from damper3d.case.excitation.excitation import given as excitation_given
from damper3d.case.excitation.forms import PER_CYCLE, Lines
from damper3d.case.host.modes import Modes, given, modes_of
from damper3d.case.parts import GRAVITY
from damper3d.case.settings import Host as HostKeys
from damper3d.case.settings import Settings
from damper3d.engine.motions import Sines, at_rest
from damper3d.engine.motions.host import Host, Ringing, drive_push, propagator, without_bed
from granulab.contact.files.units import located
from granulab.errors import InputError

REACHED = 0.1  # of the first root of the host's energy: where a free decay ends
FORGOTTEN = 0.01  # of the difference from the steady motion with which a run starts, as forgotten
_SETTLED = 1e-3  # of a transient, that is left after the most cycles of a steady run
COUNTED = 20  # cycles of a steady forced host that count: two blocks of ten that agree
_MOST_CYCLES, _UNDAMPED_CYCLES = 100_000, 1000


@dataclass(frozen=True)
class Drive:
    """A harmonic force, or base motion, or a release: what moves a host."""

    omega: float = 0.0  # [rad/s]; 0: none
    force: float = 0.0  # amplitude [N]
    base: float = 0.0  # amplitude [m]
    start_displacement: float = 0.0  # of the damper [m]
    start_velocity: float = 0.0  # [m/s]

    @property
    def is_release(self) -> bool:
        """True for a free decay."""
        return not (self.force or self.base)


def bare_amplitude(modes: Modes, drive: Drive) -> complex:
    """Complex amplitude [m] of the bare host at the damper under x = Re(X e^(i omega t)).

    The force, or the base's displacement, is real.
    """
    return complex(drive.base + modes.shape @ _amplitudes(modes, drive))


def _amplitudes(modes: Modes, drive: Drive) -> np.ndarray:
    """Complex modal amplitudes (r,) of the bare host."""
    forced = drive.force * modes.force_shape + drive.base * drive.omega**2 * modes.participation
    return modes.receptance(drive.omega, forced)


def ride_together(host: Host, modes: Sequence[Modes], weights: Sequence[float]) -> list[Host]:
    """The host as each of several dampers at their shapes rides on it; all share its state."""
    last = len(modes) - 1
    return [
        host._replace(shape=one.shape.copy(), weight=weight, closes=k == last)
        for k, (one, weight) in enumerate(zip(modes, weights, strict=True))
    ]


def host_of(modes: Modes, drive: Drive | Excitation, time_step: float, weight: float) -> Host:
    """The engine's host; weight: of the bed at rest, along the motion [N].

    A forced host starts on its bare response, with the phase for which the (first) damper moves as
    X sin(omega t). A release lets go of what a force at it pulled off its place, and of what a
    blow there set in motion. Under an excitation it starts on the bare response to its
    sines, and from rest under one that has none.
    """
    n, kicked = len(modes.omega), isinstance(drive, Excitation)
    if isinstance(drive, Excitation):
        still = _ringing(*np.zeros((4, n)))
        alone, force, base = still, drive.motion, at_rest()
        if drive.on == "base":
            force, base = at_rest(), drive.motion
    else:
        alone, force, base = _alone(modes, drive)
    damping = 2 * modes.damping_ratio * modes.omega
    pairs = zip(modes.omega.tolist(), damping.tolist(), strict=True)
    host = Host(
        alone=alone, force=force, base=base, shape=modes.shape.copy(),
        force_shape=modes.force_shape.copy(), participation=modes.participation.copy(),
        omega=modes.omega.copy(), damping=damping,
        step=np.array([propagator(w, c, time_step) for w, c in pairs]),
        time_step=time_step, weight=weight, kicked=kicked,
        closes=True, answer=np.zeros((n, 2)), gathered=np.zeros(n), pushed=np.zeros(n),
        books=np.zeros(2),
    )  # fmt: skip
    if isinstance(drive, Excitation):
        if drive.lines is not None:
            host.answer[:] = _response_to(modes, drive.on, drive.lines)
        first = np.array([drive_push(host, r, 0.0) for r in range(n)])
        host.answer[:, 1] -= 0.5 * time_step * first  # a step's kick stands around its time
    return host


def _response_to(modes: Modes, on: str, lines: Lines) -> np.ndarray:
    """Modal coordinates and velocities (r, 2) at t = 0 of the steady response to sines."""
    found = np.zeros((len(modes.omega), 2))
    for size, omega, phase in zip(lines.amplitude, lines.omega, lines.phase, strict=True):
        shape = modes.force_shape if on == "force" else omega**2 * modes.participation
        with np.errstate(divide="ignore", invalid="ignore"):
            q = modes.receptance(omega, size * shape) * cmath.exp(1j * phase)
        found += np.column_stack([q.imag, (1j * omega * q).imag])
    return found


def _alone(modes: Modes, drive: Drive) -> tuple[Ringing, Sines, Sines]:
    """The modes without the bed, the force [N] and the motion of the base [m]."""
    if drive.is_release:
        return _released(modes, drive), at_rest(), at_rest()
    q = _amplitudes(modes, drive)
    turn = -cmath.phase(drive.base + modes.lead @ q)  # of e^(i omega t), sines taken
    q = q * cmath.exp(1j * turn)
    omega = np.full(len(q), drive.omega)
    force, base = (
        Sines(np.array([size]), np.array([drive.omega]), np.array([turn]), 0.0)
        for size in (drive.force, drive.base)
    )
    return _ringing(np.abs(q), omega, np.angle(q), np.zeros(len(q))), force, base


def bare_rows(
    modes: Modes, excitation: Excitation, time_step: float, n: int, every: int
) -> tuple[np.ndarray, np.ndarray]:
    """Displacement [m] and velocity [m/s] (n + 1,) of the bare host, every so many steps."""
    return without_bed(host_of(modes, excitation, time_step, 0.0), n, every)


def bare_displacement(modes: Modes, drive: Drive, time: np.ndarray) -> np.ndarray:
    """Displacement [m] of the damper's place without the bed at these times (n,) [s]."""
    alone, _, base = _alone(modes, drive)
    angle = alone.omega * time + alone.phase  # (r, n)
    own = alone.amplitude * np.exp(-alone.rate * time) * np.sin(angle)
    carried = base.amplitude[0] * np.sin(base.omega[0] * time + base.phase[0])
    return np.asarray(carried + modes.shape @ own)


def _ringing(
    amplitude: np.ndarray, omega: np.ndarray, phase: np.ndarray, rate: np.ndarray
) -> Ringing:
    """A sine for each mode, from its numbers (r,)."""
    return Ringing(amplitude[:, None], rate[:, None], omega[:, None], phase[:, None])


def _released(modes: Modes, drive: Drive) -> Ringing:
    """Free decay of each mode, from what it is let go with."""
    place, rate = _let_go(modes, drive)
    decay = modes.damping_ratio * modes.omega
    own = modes.omega * np.sqrt(1.0 - modes.damping_ratio**2)
    across = (rate + decay * place) / own
    return _ringing(np.hypot(place, across), own, np.arctan2(place, across), decay)


def _let_go(modes: Modes, drive: Drive) -> tuple[np.ndarray, np.ndarray]:
    """Modal coordinates and velocities (r,) after a static pull and a blow at the first damper."""
    pull = modes.lead / modes.omega**2
    place = drive.start_displacement * pull / (modes.lead @ pull)
    return place, drive.start_velocity * modes.lead / (modes.lead @ modes.lead)


def drive_of(keys: HostKeys, omega: float, where: str) -> Drive:
    """Drive of the host at omega [rad/s]; InputError where nothing, or two things, move it."""
    names = ("force", "base_displacement", "base_acceleration")
    driven = [name for name in names if getattr(keys, name) is not None]
    released = [name for name in ("start_displacement", "start_velocity") if getattr(keys, name)]
    if len(driven) > 1 or (driven and released):
        pair = [*driven, *released][:2]
        raise InputError(
            f"{where}: [host] {pair[0]} and {pair[1]} are both given; a host has a force, a base "
            "that moves, or a start from which it decays: leave one of them out"
        )
    if not driven and not released:
        raise InputError(
            f"{where}: [host] nothing moves it; give force, base_displacement or "
            "base_acceleration, or start_displacement or start_velocity for a free decay"
        )
    base = keys.base_displacement or (keys.base_acceleration or 0.0) / omega**2
    return Drive(
        omega, keys.force or 0.0, base, keys.start_displacement or 0.0, keys.start_velocity or 0.0
    )


def in_arcs(settings: Settings, where: str) -> tuple[HostKeys, float | None]:
    """The keys of [host] of a structure that moves along, and None; or those of one that twists.

    Its mass, force and displacements are then those of the rim, I/R^2, T/R and R theta, and R [m]
    is given too. InputError where keys or enclosure do not go with a twist.
    """
    keys, own = settings.host, ("inertia", "torque", "start_angle")
    if not any(getattr(keys, name) is not None for name in own):
        return keys, None
    if keys.inertia is None:
        name = next(name for name in own if getattr(keys, name) is not None)
        raise InputError(f"{where}: [host] {name} goes with inertia, of a structure that twists")
    others = ("mass", "modes", "force", "base_displacement", "base_acceleration",
              "start_displacement", "start_velocity")  # fmt: skip
    for name in others:
        if getattr(keys, name) is not None:
            raise InputError(
                f"{where}: [host] inertia and {name} are both given; a structure that twists has "
                "inertia, frequency, damping_ratio, and torque or start_angle"
            )
    if excitation_given(settings.excitation):
        raise InputError(f"{where}: [excitation] moves a structure along; leave [host] inertia out")
    with located(f"{where}: [host] inertia:"):
        radius = rim_of(settings)
    changes = {
        "mass": keys.inertia / radius**2,
        "force": keys.torque and keys.torque / radius,
        "start_displacement": keys.start_angle and keys.start_angle * radius,
        **dict.fromkeys(own),
    }
    return keys.model_copy(update=changes), radius


class Shaken(NamedTuple):
    """Settings, and what moves the enclosure: host, its drive, excitation and its peaks."""

    settings: Settings
    modes: Modes | None = None
    drive: Drive | None = None
    excitation: Excitation | None = None
    peaks: Peaks | None = None  # of the enclosure, on a host of the bare one; of an excitation
    arc: float | None = None  # radius [m] at which a host that twists has its displacements


def with_motion(
    settings: Settings, folder: Path, where: str, first: np.ndarray | None = None
) -> Shaken:
    """The settings with what follows from [host] and [excitation], and what these are.

    The frequency of the motion is by itself that of the bare host (of several modes, the lowest);
    its gamma is the bare response's. A forced host runs until it is steady, unless cycles are
    given, and is not judged before its start is forgotten; a release runs until REACHED. first:
    shape at the first damper, see Modes.
    """
    keys, arc = in_arcs(settings, where)
    base_moves = settings.excitation.on == "base"
    modes = modes_of(keys, folder, where, base_moves) if given(keys) else None
    if modes is not None:
        modes = replace(modes, first=first)
    slowest, own = 0.0, 0.0
    if modes is not None:
        slowest = modes.slowest
        own = float(modes.omega.min()) / (2.0 * math.pi)
    excitation = excitation_of(settings, modes is not None, slowest, own, folder, where)
    if excitation is not None:
        return _excited(settings, modes, excitation, where)
    if modes is None:
        return Shaken(settings)
    motion, run = settings.motion, settings.run
    frequency = motion.frequency if "frequency" in motion.model_fields_set else own
    drive = drive_of(keys, 2.0 * math.pi * frequency, where)
    _check_motion(settings, drive, own, where)
    gamma = _bare_gamma(modes, drive, where)
    said = motion.gamma
    if "gamma" in motion.model_fields_set and not math.isclose(said, gamma, rel_tol=1e-6):
        raise InputError(
            f"{where}: [motion] gamma = {said:g}: with a host the motion is found; leave it out, "
            f"or choose the excitation for it (this one gives the bare host {gamma:.4g})"
        )
    lengths = _lengths(run.model_fields_set, modes, drive)
    changes: dict[str, Any] = {
        "motion": motion.model_copy(update={"frequency": frequency, "gamma": gamma}),
        "run": run.model_copy(update=lengths),
    }
    return Shaken(settings.model_copy(update=changes), modes, drive, arc=arc)


def _excited(settings: Settings, modes: Modes | None, excitation: Excitation, where: str) -> Shaken:
    """The settings under an excitation: a window is their cycle."""
    highest = excitation.highest
    if modes is not None:
        highest = max(highest, float(modes.omega.max()) / (2.0 * math.pi))
    if modes is None:
        peaks = peaks_of(excitation)
    else:
        step = 1.0 / (PER_CYCLE * highest)
        n = math.ceil(excitation.duration / step)
        place, rate = bare_rows(modes, excitation, step, n, 1)
        size = float(np.abs(np.diff(rate)).max()) / step
        peaks = Peaks(float(np.abs(place).max()), float(np.abs(rate).max()), size)
    if not (0 < peaks.speed < math.inf and 0 < peaks.acceleration < math.inf):
        raise InputError(
            f"{where}: [excitation] the enclosure does not move, or without end: look at shapes, "
            "damping ratio and amplitudes"
        )
    return Shaken(under(settings, excitation, peaks, where), modes, None, excitation, peaks)


def _check_motion(settings: Settings, drive: Drive, own: float, where: str) -> None:
    motion, run = settings.motion, settings.run
    if motion.kind != "sines" or motion.ramp:
        name = "ramp" if motion.ramp else "kind"
        raise InputError(
            f"{where}: [motion] {name} = {getattr(motion, name)!r}: of a prescribed motion, and "
            "[host] makes the host's; leave one of them out"
        )
    said = "frequency" in motion.model_fields_set
    if drive.is_release and said and not math.isclose(motion.frequency, own, rel_tol=1e-6):
        raise InputError(
            f"{where}: [motion] frequency = {motion.frequency:g} Hz: a free decay has the "
            f"host's own, {own:g} Hz; leave it out"
        )
    if drive.is_release and run.steady:
        raise InputError(
            f"{where}: [run] steady = true: a free decay is never steady; leave it out"
        )


def _bare_gamma(modes: Modes, drive: Drive, where: str) -> float:
    """Largest acceleration of the bare host at the damper over g; of a release, at its start."""
    omega = drive.omega
    if drive.is_release:
        place, rate = _let_go(modes, drive)
        size = math.hypot(omega * float(modes.shape @ place), float(modes.shape @ rate)) / omega
    else:
        with np.errstate(divide="ignore", invalid="ignore"):
            size = abs(bare_amplitude(modes, drive))
    if not math.isfinite(size):
        raise InputError(
            f"{where}: [host] damping_ratio = 0: at its own frequency the bare host has no steady "
            "response; give a damping ratio above 0, or another [motion] frequency"
        )
    if size == 0.0:
        raise InputError(f"{where}: [host] the excitation does not move the damper's place")
    return size * omega**2 / GRAVITY


def cycles_until(left: float, slowest: float, frequency: float) -> int | None:
    """Cycles at a frequency [Hz] until a free decay of a rate [1/s] is so far down; None: never.

    What differs from the steady motion at the start dies away so, off the resonance with a beat.
    """
    return math.ceil(-math.log(left) * frequency / slowest) if slowest else None


def _lengths(given_keys: set[str], modes: Modes, drive: Drive) -> dict[str, Any]:
    """Keys of [run] that follow from a host, where the case does not give them."""

    def until(left: float) -> int:
        cycles = cycles_until(left, modes.slowest, drive.omega / (2.0 * math.pi))
        return _UNDAMPED_CYCLES if cycles is None else min(cycles, _MOST_CYCLES - 2 * COUNTED)

    found: dict[str, Any] = {}
    if drive.is_release:
        found = {"cycles": until(REACHED) + 1, "discard": 0}
    elif "cycles" not in given_keys:
        found = {"steady": True, "cycles": COUNTED, "max_cycles": until(_SETTLED) + 2 * COUNTED}
        if modes.slowest:
            found["discard"] = until(FORGOTTEN)
    return {name: value for name, value in found.items() if name not in given_keys}
