"""The host of an enclosure: its modes, what excites them, and the bare response in closed form.

Single mode of a mass M (structure and empty enclosure): omega_0, zeta_0, and shapes 1/sqrt(M), so
that M x'' + c x' + k x = f + F with c = 2 zeta_0 omega_0 M, k = omega_0^2 M.
"""

import cmath
import csv
import math
from dataclasses import dataclass
from itertools import pairwise
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
from damper3d.case.parts import GRAVITY
from damper3d.case.settings import Host as HostKeys
from damper3d.case.settings import Settings
from damper3d.engine.motions import Sines, at_rest
from damper3d.engine.motions.host import Host, Ringing, drive_push, propagator, without_bed
from granulab.contact.files.datafile import is_file
from granulab.contact.files.units import located, nearest
from granulab.errors import InputError

MODES = "modes.csv"  # in a run folder
REACHED = 0.1  # of the first root of the host's energy: where a free decay ends
_SETTLED = 1e-3  # of a transient, that is left after the most cycles of a steady run
COUNTED = 20  # cycles of a steady forced host that count: two blocks of ten that agree
_MOST_CYCLES, _UNDAMPED_CYCLES = 100_000, 1000
# Columns of a table of modes, and the units that stand behind their names in brackets.
_UNITS = {
    "frequency": "Hz", "damping_ratio": "", "shape": "kg^-0.5", "force_shape": "kg^-0.5",
    "participation": "kg^0.5",
}  # fmt: skip
_REQUIRED = ("frequency", "damping_ratio", "shape")


@dataclass(frozen=True, eq=False)
class Modes:
    """Modes of a structure, of unit modal mass (r,)."""

    omega: np.ndarray  # [rad/s]
    damping_ratio: np.ndarray  # [-]
    shape: np.ndarray  # at the damper, along its motion [kg^-0.5]
    force_shape: np.ndarray  # where the force acts [kg^-0.5]
    participation: np.ndarray  # [kg^0.5]

    @classmethod
    def single(cls, mass: float, omega: float, damping_ratio: float) -> "Modes":
        """One degree of freedom."""
        shape = np.array([1 / math.sqrt(mass)])
        return cls(np.array([omega]), np.array([damping_ratio]), shape, shape, 1 / shape)

    def nearest(self, omega: float) -> int:
        """The mode whose own frequency is nearest [rad/s]."""
        return int(np.argmin(np.abs(self.omega - omega)))

    def receptance(self, omega: float, drive: np.ndarray) -> np.ndarray:
        """Modal amplitudes (r,) for a modal force drive e^(i omega t) (r,)."""
        damping = 2j * self.damping_ratio * self.omega * omega
        return np.asarray(drive / (self.omega**2 - omega**2 + damping))


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
    forced = drive.force * modes.force_shape + drive.base * drive.omega**2 * modes.participation
    q = modes.receptance(drive.omega, forced)
    return complex(drive.base + modes.shape @ q)


def host_of(modes: Modes, drive: Drive | Excitation, time_step: float, weight: float) -> Host:
    """The engine's host; weight: of the bed at rest, along the motion [N].

    A forced host starts on its bare response, with the phase for which the damper moves as
    X sin(omega t). A release lets go of what a force at the damper pulled off its place, and of
    what a blow there set in motion. Under an excitation it starts on the bare response to its
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
        answer=np.zeros((n, 2)), pushed=np.zeros(1), books=np.zeros(2),
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
    turn = -cmath.phase(bare_amplitude(modes, drive))  # of e^(i omega t), sines taken
    forced = drive.force * modes.force_shape + drive.base * drive.omega**2 * modes.participation
    q = modes.receptance(drive.omega, forced) * cmath.exp(1j * turn)
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
    """Free decay of each mode, from a static pull and a blow at the damper."""
    pull = modes.shape / modes.omega**2
    place = drive.start_displacement * pull / (modes.shape @ pull)
    rate = drive.start_velocity * modes.shape / (modes.shape @ modes.shape)
    decay = modes.damping_ratio * modes.omega
    own = modes.omega * np.sqrt(1.0 - modes.damping_ratio**2)
    across = (rate + decay * place) / own
    return _ringing(np.hypot(place, across), own, np.arctan2(place, across), decay)


def given(keys: HostKeys) -> bool:
    """True where a case has a host."""
    return any(value is not None for value in keys.model_dump().values())


def modes_of(keys: HostKeys, folder: Path, where: str) -> Modes:
    """The modes of [host]; InputError where keys or the table of modes are not right."""
    single = {name: getattr(keys, name) for name in ("mass", "frequency", "damping_ratio")}
    if keys.modes is not None:
        both = [name for name, value in single.items() if value is not None]
        if both:
            raise InputError(
                f"{where}: [host] {both[0]} is given, and modes = {keys.modes!r} has it for each "
                "mode; leave one of them out"
            )
        return read_modes(_table(keys.modes, folder), bool(base_of(keys)))
    for name, value in single.items():
        if value is None:
            raise InputError(
                f"{where}: [host] {name} is missing; a host has mass, frequency and damping_ratio, "
                "or a table of modes"
            )
    omega = 2.0 * math.pi * single["frequency"]
    return Modes.single(single["mass"], omega, single["damping_ratio"])


def _table(name: str, folder: Path) -> Path:
    """The table of modes that a case names: next to it, or where the command stands."""
    return folder / name if is_file(folder / name) else Path(name)


def modes_copy(keys: HostKeys, folder: Path) -> dict[str, str]:
    """The table of modes as a file for the run folder: its name and text; one mode has none."""
    if keys.modes is None:
        return {}
    return {MODES: _table(keys.modes, folder).read_text(encoding="utf-8-sig")}


def read_modes(path: Path, with_base: bool = False) -> Modes:
    """Modes from a CSV table, a line each; with_base: the participation factors are needed.

    Raises InputError, one line that names file, line and column.
    """
    rows = _rows(path)
    if len(rows) < 2:
        raise InputError(f"{path}: no modes; write a head, {_head()}, and a line for each mode")
    names = [_column(path, cell.strip()) for cell in rows[0]]
    needed = (*_REQUIRED, "participation") if with_base else _REQUIRED
    for name in needed:
        if name not in names:
            why = ", which base motion needs" if name == "participation" else ""
            raise InputError(f"{path}: column {name!r} is missing{why}; the head is {_head()}")
    table = np.array([_mode(path, k, names, row) for k, row in enumerate(rows[1:], 2)])
    values = dict(zip(names, table.T, strict=True))
    _check_modes(path, values)
    shape = values["shape"]
    return Modes(
        2.0 * math.pi * values["frequency"], values["damping_ratio"], shape,
        values.get("force_shape", shape), values.get("participation", np.zeros(len(shape))),
    )  # fmt: skip


def _rows(path: Path) -> list[list[str]]:
    """The lines of a CSV table that are not empty."""
    if not is_file(path):
        raise InputError(f"{path}: no such file; give the table of the host's modes")
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: no CSV table: {error}") from None
    return [row for row in csv.reader(text.splitlines()) if any(map(str.strip, row))]


def _head() -> str:
    return ", ".join(f"{name} [{unit}]" if unit else name for name, unit in _UNITS.items())


def _column(path: Path, cell: str) -> str:
    """The name of a column from its head, which has the unit that it must have."""
    name, _, rest = cell.partition("[")
    name, unit = name.strip(), rest.rstrip("] ").strip().replace("**", "^")
    if name not in _UNITS:
        raise InputError(f"{path}: column {cell!r}: {nearest(name, list(_UNITS))}")
    if unit != _UNITS[name] and (unit or "kg" in _UNITS[name]):
        said = f"the unit is {unit!r}" if unit else "the unit is missing"
        raise InputError(
            f"{path}: column {cell!r}: {said}; shapes of unit modal mass are needed: write "
            f"'{name} [{_UNITS[name]}]'" if "kg" in _UNITS[name] else
            f"{path}: column {cell!r}: {said}; write '{name} [{_UNITS[name]}]'"
        )  # fmt: skip
    return name


def _mode(path: Path, line: int, names: list[str], row: list[str]) -> list[float]:
    if len(row) != len(names):
        raise InputError(f"{path}: line {line} has {len(row)} values, its head {len(names)}")
    found = []
    for name, cell in zip(names, row, strict=True):
        try:
            value = float(cell)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise InputError(f"{path}: line {line}: {name} = {cell.strip()!r}: no number")
        found.append(value)
    return found


def _check_modes(path: Path, values: dict[str, np.ndarray]) -> None:
    for k, (frequency, ratio) in enumerate(
        zip(values["frequency"], values["damping_ratio"], strict=True), 2
    ):
        if not frequency > 0:
            raise InputError(f"{path}: line {k}: frequency = {frequency:g} Hz: must be above 0")
        if not 0 <= ratio < 1:
            raise InputError(
                f"{path}: line {k}: damping_ratio = {ratio:g}: must be 0 or more and below 1"
            )
    if len(set(values["frequency"])) < len(values["frequency"]):
        repeated = sorted(values["frequency"])
        twice = next(a for a, b in pairwise(repeated) if a == b)
        raise InputError(
            f"{path}: frequency = {twice:g} Hz stands twice; two modes of one frequency act as "
            "one, whose shape is the root of the sum of their squares"
        )
    if not np.any(values["shape"]):
        raise InputError(f"{path}: every shape is 0: no mode moves the damper")


def base_of(keys: HostKeys) -> float | None:
    """The amplitude of the base as a length [m] or acceleration [m/s2]; None: it does not move."""
    return keys.base_displacement or keys.base_acceleration


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


def with_motion(settings: Settings, folder: Path, where: str) -> Shaken:
    """The settings with what follows from [host] and [excitation], and what these are.

    The frequency of the motion is by itself that of the bare host (of several modes, the lowest);
    its gamma is the bare response's. A forced host runs until it is steady, unless cycles are
    given, and a release until REACHED.
    """
    keys, arc = in_arcs(settings, where)
    modes = modes_of(keys, folder, where) if given(keys) else None
    slowest, own = 0.0, 0.0
    if modes is not None:
        slowest = float((modes.damping_ratio * modes.omega).min())
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
        size = math.hypot(omega * drive.start_displacement, drive.start_velocity) / omega
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


def _lengths(given_keys: set[str], modes: Modes, drive: Drive) -> dict[str, Any]:
    """Keys of [run] that follow from a host, where the case does not give them."""
    slowest = float((modes.damping_ratio * modes.omega).min())
    per_cycle = 2.0 * math.pi * slowest / drive.omega  # of the logarithm of an amplitude

    def until(left: float) -> int:
        if not per_cycle:
            return _UNDAMPED_CYCLES
        return min(math.ceil(-math.log(left) / per_cycle), _MOST_CYCLES - 2 * COUNTED)

    found: dict[str, Any] = {}
    if drive.is_release:
        found = {"cycles": until(REACHED) + 1, "discard": 0}
    elif "cycles" not in given_keys:
        found = {"steady": True, "cycles": COUNTED, "max_cycles": until(_SETTLED) + 2 * COUNTED}
    return {name: value for name, value in found.items() if name not in given_keys}
