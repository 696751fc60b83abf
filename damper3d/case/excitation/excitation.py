"""The excitation of a case: from the keys of [excitation] to a motion, windows and samples.

A run counts energies in windows of equal length, as it does in cycles of a sine: the common period
of some sines, parts of a random signal, of a sweep or of a measured one, the length of a pulse.
"""

import math
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from damper3d.case.excitation import forms
from damper3d.case.excitation.forms import Lines, Size, Sweep, quantity
from damper3d.case.excitation.recorded import (
    COPY,
    Means,
    breakpoints,
    highest_frequency,
    means_of,
    motion_of,
    read_signal,
)
from damper3d.case.parts import GRAVITY, direction_of, unit_vector
from damper3d.case.settings import MOST_SAMPLES, Settings
from damper3d.case.settings import Excitation as Keys
from damper3d.engine.enclosures.cylinder import Cylinder
from damper3d.engine.motions import Crossed, Table, Turning, displacement
from granulab.contact.files.datafile import is_file
from granulab.contact.files.units import located
from granulab.errors import InputError

STANDARD_GRAVITY = 9.80665  # [m/s2] of densities in g2/Hz, as of lengths in "g"
SAMPLES = 16  # a cycle of the highest frequency
_LEAST = 100  # samples a window, as of a sine
_FRAMES = 20  # a window, which samples are a multiple of
_PARTS = 10  # windows of what is counted of a random signal
_SHOWN = 50  # windows of a sweep, each way
_RECORDED = 20  # windows of a measured signal, and pulses after a shock
_LONGEST_BEAT = 2000  # windows that are run by themselves for a beat of sines
_RANDOM_CYCLES = 50  # of the lowest frequency, that count by themselves
_LEFT = math.exp(-3.0)  # of a bare host's transient, that is left when counting begins
_PEAKS_OF = 50  # windows of a sum of sines, among which its largest values are looked for
_ROUND = ("cylinder", "frustum", "sphere")  # enclosures that may turn about their axis
_ACROSS = 1e-6  # of a direction that may lie along the other, by rounding
_MOST_POINTS = 50_000_000
# Keys of each kind: those that it needs, then those that it may have.
_KEYS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "sines": (("frequencies", "amplitudes"),
              ("phases", "across", "across_amplitudes", "across_phases")),
    "rotation": (("frequencies", "amplitudes"), ("phases",)),
    "sweep": (("from_frequency", "to_frequency", "amplitude"),
              ("spacing", "octaves_per_minute", "length", "steps", "and_back")),
    "random": (("psd",), ("seed", "length")),
    "shock": (("amplitude", "length"), ("pulse",)),
    "signal": (("file",), ("column", "full_scale", "integration")),
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Excitation:
    """A motion, or a force, and how a run with it is divided."""

    kind: str
    on: str  # enclosure, force, base
    motion: Any  # of the engine: displacement [m] or force [N]
    window: float  # [s]
    windows: int
    discard: int  # windows that do not count
    highest: float  # frequency [Hz] that samples must show
    lines: Lines | None = None  # of one that goes on for ever: a host starts on its response
    sweep: Sweep | None = None
    rim: float | None = None  # largest distance from the axis [m], of a rotation
    band_error: float | None = None  # largest of a random signal's third octaves [dB]
    breakpoints: list[list[float]] | None = None  # of its density, as given
    taken_off: Means | None = None  # of a measured motion
    identity: tuple[Any, ...] = ()  # its numbers, for the name of a run
    files: dict[str, str] = field(default_factory=dict)  # for the run folder

    @property
    def duration(self) -> float:
        """Of the whole run [s]."""
        return self.windows * self.window

    @property
    def samples(self) -> int:
        """Samples a window."""
        return _FRAMES * math.ceil(max(SAMPLES * self.highest * self.window, _LEAST) / _FRAMES)

    def across(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """Place [m] and velocity [m/s] along a second direction at times (n,) [s]; or None."""
        if not isinstance(self.motion, Crossed):
            return None
        return Lines(*self.motion.across[:3]).at(time)

    @property
    def second(self) -> np.ndarray | None:
        """The second direction (3,), a unit vector across the first; None without one."""
        return self.motion.direction if isinstance(self.motion, Crossed) else None

    def rim_velocity(self, time: np.ndarray) -> np.ndarray | None:
        """Velocity [m/s] of the rim of an enclosure that turns, at times (n,); None of others."""
        if self.rim is None or self.lines is None:
            return None
        return self.rim * self.lines.at(time)[1]

    def base_displacement(self, time: np.ndarray) -> np.ndarray:
        """Displacement [m] of the host's base at times (n,) [s]; 0 where it stands still."""
        if self.on != "base":
            return np.zeros(len(time))
        return np.array([displacement(self.motion, t) for t in time.tolist()])

    @property
    def words(self) -> str:
        """Kind and place, for the echo of a case."""
        where = {"enclosure": "of the enclosure", "force": "as a force", "base": "of the base"}
        return f"{self.kind} {where[self.on]}"


def given(keys: Keys) -> bool:
    """True where a case has an excitation."""
    return any(value is not None for value in keys.model_dump().values())


def excitation_of(
    settings: Settings, on_host: bool, slowest: float, own: float, folder: Path, where: str
) -> Excitation | None:
    """The excitation of a case; None without one.

    slowest: rate at which the transient of a bare host dies away [1/s], own: its frequency [Hz].
    Raises InputError, one line, where keys are missing, not of its kind, or cannot be.
    """
    keys = settings.excitation
    if not given(keys):
        return None
    _check_keys(keys, on_host, where)
    _check_rest(settings, where)
    on = keys.on or ("force" if on_host else "enclosure")
    with located(f"{where}: [excitation]"):
        if keys.kind == "rotation":
            found = _rotation(keys, settings, on_host)
        elif keys.kind == "sines":
            found = _sines(keys, on, settings, slowest)
        elif keys.kind == "sweep":
            found = _sweep(keys, on)
        elif keys.kind == "random":
            found = _random(keys, on, folder, slowest)
        elif keys.kind == "shock":
            found = _shock(keys, on, slowest, own)
        else:
            found = _signal(keys, on, folder)
    if found.samples > MOST_SAMPLES:
        raise InputError(
            f"{where}: [excitation] a window of {found.window:.4g} s, {found.highest:.4g} Hz at "
            f"most, takes {found.samples:,} samples: at most {MOST_SAMPLES:,} are kept; give a "
            "shorter length, or lower frequencies"
        )
    return found


def _check_keys(keys: Keys, on_host: bool, where: str) -> None:
    if keys.kind is None:
        raise InputError(f"{where}: [excitation] kind is missing; give one of {', '.join(_KEYS)}")
    if keys.on in ("force", "base") and not on_host:
        raise InputError(
            f"{where}: [excitation] on = {keys.on!r} moves a host; give [host], or 'enclosure'"
        )
    if keys.on == "enclosure" and on_host:
        raise InputError(
            f"{where}: [excitation] on = 'enclosure': with [host] the host moves the enclosure; "
            "give 'force' or 'base', or leave [host] out"
        )
    if keys.kind == "random" and on_host and keys.on is None:
        raise InputError(
            f"{where}: [excitation] on is missing: on = 'base' takes psd in g2/Hz, on = 'force' in "
            "N2/Hz; give one of them"
        )
    needed, others = _KEYS[keys.kind]
    for name, value in keys.model_dump(exclude={"kind", "on"}).items():
        if value is None and name in needed:
            raise InputError(f"{where}: [excitation] {name} is missing; a {keys.kind} needs it")
        if value is not None and name not in (*needed, *others):
            raise InputError(
                f"{where}: [excitation] {name} is no key of kind = {keys.kind!r}, which has "
                f"{', '.join((*needed, *others))}"
            )


def _check_rest(settings: Settings, where: str) -> None:
    """Raise InputError for keys elsewhere that an excitation stands in place of."""
    host = ("force", "base_displacement", "base_acceleration", "start_displacement",
            "start_velocity")  # fmt: skip
    for section, names in {"motion": ("kind", "ramp"), "host": host, "run": ("steady",)}.items():
        table = getattr(settings, section)
        for name in names:
            if getattr(table, name) != type(table).model_fields[name].default:
                raise _stands_for(settings, section, name, where)


def _stands_for(settings: Settings, section: str, name: str, where: str) -> InputError:
    return InputError(
        f"{where}: [{section}] {name}: [excitation] kind = {settings.excitation.kind!r} stands in "
        "its place; leave one of them out"
    )


def under(settings: Settings, excitation: Excitation, peaks: "Peaks", where: str) -> Settings:
    """The settings of a run under an excitation: its windows are the cycles.

    InputError where they say something else.
    """
    found: dict[str, dict[str, Any]] = {
        "motion": {"frequency": 1.0 / float(excitation.window), "gamma": gamma_of(peaks)},
        "run": {"cycles": excitation.windows, "discard": excitation.discard},
        "output": {"samples": excitation.samples},
    }
    changed = {}
    for section, values in found.items():
        table = getattr(settings, section)
        for name, value in values.items():
            said = name in table.model_fields_set and name != "samples"
            if said and not math.isclose(getattr(table, name), value, rel_tol=1e-6):
                raise _stands_for(settings, section, name, where)
        if section == "output" and "samples" in table.model_fields_set:
            values = {}
        changed[section] = table.model_copy(update=values)
    return settings.model_copy(update=changed)


def _size(text: object, name: str, on: str) -> Size:
    """An amplitude; InputError where its unit is not one of what it acts on."""
    if on == "rotation":
        return Size(forms.angle(text, name), "rad")
    size = quantity(text, name)
    if (size.unit == "N") != (on == "force"):
        takes = "a force such as '2 N'" if on == "force" else "such as '2 g' or '0.1 mm'"
        raise InputError(f"{name} = {text!r}: acts as {on}: give {takes}")
    if not size.value > 0:
        raise InputError(f"{name} = {text!r}: must be above 0")
    return size


def _lines(keys: Keys, on: str, prefix: str = "") -> Lines:
    frequencies = keys.frequencies or []
    sizes = getattr(keys, f"{prefix}amplitudes") or []
    angles = getattr(keys, f"{prefix}phases") or ["0 deg"] * len(frequencies)
    for name, values in ((f"{prefix}amplitudes", sizes), (f"{prefix}phases", angles)):
        if len(values) != len(frequencies):
            raise InputError(
                f"{name}: {len(values)} of them, and {len(frequencies)} frequencies; give one each"
            )
    omega = 2.0 * math.pi * np.array(frequencies)
    amplitude = [
        float(_size(size, f"{prefix}amplitudes", on).as_displacement(w))
        for size, w in zip(sizes, omega, strict=True)
    ]
    phase = [forms.angle(angle, f"{prefix}phases") for angle in angles]
    return Lines(np.array(amplitude), omega, np.array(phase))


def _windows(
    frequencies: list[float], settings: Settings, slowest: float
) -> tuple[float, int, int]:
    """Window [s] of sums of sines, their number, and how many of them do not count.

    A window is their common period, or one of the slowest. By themselves they hold the slowest
    beat.
    """
    window, run = forms.common_period(frequencies) or 1.0 / min(frequencies), settings.run
    windows, discard = run.cycles, run.discard
    if "cycles" not in run.model_fields_set:
        if slowest:
            discard = math.ceil(-math.log(_LEFT) / slowest / window)
            windows = discard + _RECORDED
        windows = max(windows, discard + _of_a_beat(frequencies, window))
    return window, windows, discard


def _of_a_beat(frequencies: list[float], window: float) -> int:
    """Windows [s] that the slowest beat of sums of sines takes, which is as loud as faint in part.

    Raises InputError where it takes more than _LONGEST_BEAT of them.
    """
    ordered = sorted(frequencies)
    slowest = min((b - a for a, b in pairwise(ordered)), default=math.inf)
    takes = math.ceil(1.0 / (slowest * window) * (1.0 - 1e-9))
    if takes > _LONGEST_BEAT:
        raise InputError(
            f"frequencies {slowest:.3g} Hz apart beat in {1.0 / slowest:.4g} s, {takes:,} cycles "
            "of the slowest: give [run] cycles for a part of that, or frequencies further apart"
        )
    return takes


def _sines(keys: Keys, on: str, settings: Settings, slowest: float) -> Excitation:
    frequencies = keys.frequencies or []
    if len(set(frequencies)) < len(frequencies):
        raise InputError("frequencies: one stands twice; give one sine for each")
    lines = _lines(keys, on)
    motion: Any = lines.motion()
    if keys.across is not None:
        if on != "enclosure":
            raise InputError("across: a host moves along one direction; leave it out")
        direction = unit_vector(keys.across, "across")
        _check_across(keys.across, direction, settings)
        motion = Crossed(motion, _lines(keys, on, "across_").motion(), direction)
    elif keys.across_amplitudes is not None or keys.across_phases is not None:
        raise InputError("across is missing; give the direction of the second motion")
    across = [*motion.across, motion.direction] if isinstance(motion, Crossed) else []
    return Excitation(
        "sines", on, motion, *_windows(frequencies, settings, slowest), max(frequencies), lines,
        identity=(lines.amplitude, lines.omega, lines.phase, *across),
    )  # fmt: skip


def _check_across(given: list[float], second: np.ndarray, settings: Settings) -> None:
    """Raise InputError where a second direction is not across that of the motion."""
    first = direction_of(settings.motion, "direction")
    if abs(second @ first) > _ACROSS:
        rest = np.round(second - (second @ first) * first, 6)
        cure = f"give such as {rest.tolist()}, and" if rest.any() else "give another;"
        raise InputError(
            f"across = {given}: must be at right angles to [motion] direction; {cure} what is "
            "along that belongs to amplitudes and phases"
        )


def rim_of(settings: Settings) -> float:
    """Largest radius [m] of an enclosure that turns about its axis; InputError for others."""
    enclosure = settings.enclosure
    if settings.motion.direction is not None:
        raise InputError("it is about the axis; leave [motion] direction out")
    if enclosure.shape not in _ROUND or enclosure.cells is not None:
        raise InputError(
            f"the walls of a {enclosure.shape} would move through the bed as they turn about the "
            f"axis; give shape = {' or '.join(map(repr, _ROUND))}, no cells"
        )
    return 0.5 * max(enclosure.diameter or Cylinder.diameter, enclosure.top_diameter or 0.0)


def _rotation(keys: Keys, settings: Settings, on_host: bool) -> Excitation:
    if on_host:
        raise InputError("kind = 'rotation': a host that twists is not there; leave [host] out")
    with located("kind = 'rotation':"):
        rim = rim_of(settings)
    lines = _lines(keys, "rotation")
    frequencies = keys.frequencies or []
    return Excitation(
        "rotation", "enclosure", Turning(lines.motion(), 1.0, np.zeros(1)),
        *_windows(frequencies, settings, 0.0), max(frequencies), lines,
        identity=(lines.amplitude, lines.omega, lines.phase), rim=rim,
    )  # fmt: skip


def _sweep(keys: Keys, on: str) -> Excitation:
    first, last = keys.from_frequency or 0.0, keys.to_frequency or 0.0
    octaves = abs(math.log2(last / first))
    if octaves == 0.0:
        raise InputError("from_frequency and to_frequency are the same; a sweep needs two")
    logarithmic = keys.spacing != "linear"
    if (keys.octaves_per_minute is None) == (keys.length is None):
        raise InputError("give either octaves_per_minute or length, one of them")
    if keys.octaves_per_minute is not None and not logarithmic:
        raise InputError("octaves_per_minute goes with spacing = 'logarithmic'; give length")
    length = keys.length or 60.0 * octaves / float(keys.octaves_per_minute or 1.0)
    if length * min(first, last) < 1.0:
        raise InputError(
            f"length = {length:.4g} s: less than a cycle of {min(first, last):g} Hz; sweep slower"
        )
    _check_points(length * max(first, last))
    sweep = Sweep(first, last, length, logarithmic, keys.steps or 0, bool(keys.and_back))
    size = _size(keys.amplitude, "amplitude", on)
    highest = max(first, last)
    way = _of_steps(sweep) if sweep.steps else _parts(length, highest, _SHOWN)
    shown = way * (2 if sweep.and_back else 1)
    return Excitation(
        "sweep", on, sweep.table(size), sweep.duration / shown, shown, 0, highest,
        sweep=sweep, identity=(*vars(sweep).values(), *sweep.glides, size.value, size.unit),
    )  # fmt: skip


def _of_steps(sweep: Sweep) -> int:
    """Number of windows of a stepped sweep, one way: as many of each frequency.

    InputError where the change of frequency takes more than half of a window.
    """
    step, glide = sweep.length / sweep.steps, float(sweep.glides.max())
    wanted = min(math.ceil(_SHOWN / sweep.steps), max(int(step / (2.0 * glide)), 1))
    each = max(wanted, _parts(step, max(sweep.first, sweep.last), 1))
    if step / each < 2.0 * glide:
        raise InputError(
            f"steps = {sweep.steps}: each frequency is held for {step / each:.3g} s, and the "
            f"change to the next takes {glide:.3g} s, more than half of it; give fewer steps, a "
            "slower sweep or a narrower range of frequencies"
        )
    return sweep.steps * each


def _parts(length: float, highest: float, least: int) -> int:
    """Number of windows of a length [s]: so many, or as many as its samples take."""
    return max(least, math.ceil(length * SAMPLES * highest / (MOST_SAMPLES - _FRAMES)))


def _check_points(cycles: float) -> None:
    if not cycles * forms.PER_CYCLE < _MOST_POINTS:
        raise InputError(
            f"{cycles:.3g} cycles of the highest frequency: at most "
            f"{_MOST_POINTS // forms.PER_CYCLE:,} are taken; give a shorter length"
        )


def _random(keys: Keys, on: str, folder: Path, slowest: float) -> Excitation:
    of, unit, scale = ("N", "N", 1.0) if on == "force" else ("g", "m/s2", STANDARD_GRAVITY**2)
    given_psd = breakpoints(keys.psd, folder, of)
    psd = given_psd * [1.0, scale]
    seed = 1 if keys.seed is None else keys.seed
    low, high = float(psd[0, 0]), float(psd[-1, 0])
    length = keys.length or _RANDOM_CYCLES / low
    parts = _parts(length, high, _PARTS)
    window = length / parts
    discard = max(math.ceil(-math.log(_LEFT) / slowest / window) if slowest else 0, 2)
    duration = (parts + discard) * window
    _check_points(duration * high)
    # Long enough for LINES of its multiples in the lowest third octave, and between both ends.
    narrowest = min((2.0 ** (1 / 3) - 1.0) * low, high - low)
    period = max(duration, forms.LINES / narrowest)
    _check_points(period * high)
    lines = forms.random_lines(psd, unit, seed, period)
    errors = forms.band_errors(lines, psd, unit, period)
    return Excitation(
        "random", on, forms.random_table(lines, period, duration), window, parts + discard,
        discard, high, lines, band_error=float(np.abs(errors).max()),
        breakpoints=given_psd.tolist(), identity=(psd, seed, length),
    )  # fmt: skip


def _shock(keys: Keys, on: str, slowest: float, own: float) -> Excitation:
    size, length = _size(keys.amplitude, "amplitude", on), keys.length or 0.0
    form = keys.pulse or "half_sine"
    motion = forms.pulse(form, size, length)
    window, windows, highest = length, _RECORDED, 2.0 / length
    if own:  # of a host: until it has decayed to a tenth
        window = 1.0 / own
        left = math.log(10.0) / (slowest * window) if slowest else 1000.0
        windows = math.ceil(length / window) + min(math.ceil(left), 100_000)
        highest = max(highest, own)
        parts = _parts(window, highest, 1)
        window, windows = window / parts, windows * parts
    return Excitation(
        "shock", on, motion, window, windows, 0, highest,
        identity=(form, size.value, size.unit, length),
    )  # fmt: skip


def _signal(keys: Keys, on: str, folder: Path) -> Excitation:
    assert keys.file is not None
    path = folder / keys.file if is_file(folder / keys.file) else Path(keys.file)
    signal = read_signal(path, keys.column, keys.full_scale)
    if (signal.unit == "N") != (on == "force"):
        takes = "a force [N]" if on == "force" else "an acceleration, velocity or displacement"
        raise InputError(f"file = {keys.file!r}: acts as {on}: its column must be {takes}")
    highest = highest_frequency(signal)
    windows = _parts(signal.length, highest, _RECORDED)
    balanced = keys.integration != "as_measured"
    return Excitation(
        "signal", on, motion_of(signal, balanced), signal.length / windows, windows, 0, highest,
        identity=(signal.values, signal.spacing, signal.unit, balanced),
        taken_off=None if on == "force" else means_of(signal, balanced),
        files={COPY: signal.as_csv()},
    )  # fmt: skip


@dataclass(frozen=True)
class Peaks:
    """Largest values of a motion over a run."""

    displacement: float  # [m]
    speed: float  # [m/s]
    acceleration: float  # [m/s2]


def peaks_of(excitation: Excitation) -> Peaks:
    """Largest displacement, speed and acceleration of an excitation that is a motion."""
    motion = excitation.motion
    if isinstance(motion, Table):
        spacing, last = motion.spacing, int(excitation.duration / motion.spacing) + 1
        place, rate = motion.place[None, :last], motion.rate[None, :last]
    else:
        both = [motion.along, motion.across] if isinstance(motion, Crossed) else [motion]
        if isinstance(motion, Turning):  # of the rim
            rim = excitation.rim or 0.0
            both = [motion.arc._replace(amplitude=rim * motion.arc.amplitude)]
        spacing = 1.0 / (forms.PER_CYCLE * excitation.highest)
        n = math.ceil(min(excitation.duration, _PEAKS_OF * excitation.window) / spacing)
        rows = [Lines(*one[:3]).at(spacing * np.arange(n + 1)) for one in both]
        place, rate = (np.array(one) for one in zip(*rows, strict=True))
    change = np.diff(rate) / spacing
    return Peaks(*(float(np.linalg.norm(one, axis=0).max()) for one in (place, rate, change)))


def gamma_of(peaks: Peaks) -> float:
    """Largest acceleration over gravity [-]."""
    return peaks.acceleration / GRAVITY
