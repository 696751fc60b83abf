"""Forms of excitations as motions of the engine: sums of sines, sweeps, random signals, pulses.

Each has a displacement [m], or is a force [N], over time from 0 on. An amplitude has the unit that
the case gave it; as a displacement it is a/omega^2 of an acceleration a and v/omega of a velocity.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from damper3d.engine.motions import Sines, Table
from granulab.contact.files.units import to_si
from granulab.errors import InputError

_AMPLITUDES = ("m", "m/s", "m/s2", "N")
PER_CYCLE = 40  # points of a table a cycle of the highest frequency: a sine to 1.6e-6
LINES = 10  # sines of a random signal in a third of an octave
# Cycles of the lower frequency in which a stepped sweep goes from one to the next: at least two,
# and so many for a factor e. The acceleration then exceeds its level by 2 w'/w^2 and w''/w^3 only,
# some 3 % (measured over 2 to 40 steps of 20 to 200 Hz).
_GLIDE, _GLIDE_PER_E = 2.0, 4.0
_ORDER = {
    "m": 0,
    "m/s": 1,
    "m/s2": 2,
    "N": 0,
    "rad": 0,
}  # derivatives that an amplitude's unit stands for


@dataclass(frozen=True)
class Size:
    """An amplitude in the unit that the case gave it."""

    value: float
    unit: str  # m, m/s, m/s2 or N

    def as_displacement(self, omega: np.ndarray | float) -> np.ndarray:
        """Amplitude [m] at omega [rad/s]; of a force itself [N]."""
        return np.asarray(self.value / np.asarray(omega) ** _ORDER[self.unit])


def quantity(text: object, field: str) -> Size:
    """An amplitude as a case gives it, such as "2 g", "0.1 mm" or "3 N"; InputError for others."""
    for unit in _AMPLITUDES:
        try:
            value = to_si(text, unit, field)
        except InputError as error:
            if "the unit is wrong here" not in str(error):
                raise
        else:
            return Size(value, unit)
    raise InputError(
        f"{field} = {text!r}: the unit is wrong here; give an acceleration such as '2 g', a "
        "velocity, a displacement or a force"
    )


def angle(text: object, field: str) -> float:
    """A phase [rad] as a case gives it; InputError for others."""
    return to_si(text, "rad", field)


@dataclass(frozen=True, eq=False)
class Lines:
    """Sines that a signal is made of, A sin(omega t + phase), each (n,)."""

    amplitude: np.ndarray  # [m] or [N]
    omega: np.ndarray  # [rad/s]
    phase: np.ndarray  # [rad]

    def motion(self) -> Sines:
        """They themselves as a motion."""
        return Sines(self.amplitude, self.omega, self.phase, 0.0)

    def at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Displacement and velocity at times (t,) [s]."""
        angle = self.omega * time[:, None] + self.phase
        return np.sin(angle) @ self.amplitude, np.cos(angle) @ (self.omega * self.amplitude)


def _points(highest: float, length: float) -> tuple[float, int]:
    """Spacing [s] and number of a table's points; one more, so that the end is inside."""
    spacing = 1.0 / (PER_CYCLE * highest)
    return spacing, math.ceil(length / spacing) + 2


def common_period(frequencies: list[float], most: int = 50) -> float | None:
    """Shortest time [s] of whole cycles of all frequencies [Hz], of at most so many of the slowest.

    None where there is none to one part in 1e9.
    """
    slowest = min(frequencies)
    for n in range(1, most + 1):
        cycles = np.array(frequencies) * n / slowest
        if np.all(np.abs(cycles - np.rint(cycles)) < 1e-9 * cycles):
            return n / slowest
    return None


@dataclass(frozen=True)
class Sweep:
    """A sine whose frequency goes from one to another, or in steps, and maybe back."""

    first: float  # [Hz]
    last: float  # [Hz]
    length: float  # of one way [s]
    logarithmic: bool
    steps: int  # 0: continuous
    and_back: bool

    @property
    def duration(self) -> float:
        """Of all of it [s]."""
        return self.length * (2.0 if self.and_back else 1.0)

    def frequency(self, time: np.ndarray) -> np.ndarray:
        """Frequency [Hz] at times (n,)."""
        if self.steps:
            return self._stepped(time)
        way = time / self.length
        return self._along(np.where(way > 1.0, 2.0 - way, way).clip(0.0, 1.0))

    def _along(self, way: np.ndarray) -> np.ndarray:
        """Frequency [Hz] at parts of the way from first to last, 0 to 1."""
        if self.logarithmic:
            return np.asarray(self.first * (self.last / self.first) ** way)
        return np.asarray(self.first + (self.last - self.first) * way)

    @property
    def held(self) -> np.ndarray:
        """Frequencies [Hz] that are held one after the other, there and back; none: continuous."""
        there = self._along(np.linspace(0.0, 1.0, self.steps))
        return np.concatenate([there, there[::-1]]) if self.and_back else there

    @property
    def glides(self) -> np.ndarray:
        """Time [s] at the beginning of each held frequency in which it comes from the last one."""
        before, after = self.held[:-1], self.held[1:]
        apart = np.abs(np.log(after / before))
        cycles = np.where(apart > 0.0, np.maximum(_GLIDE, _GLIDE_PER_E * apart), 0.0)
        return np.concatenate([[0.0][: self.steps], cycles / np.minimum(before, after)])

    def is_held(self, time: np.ndarray) -> np.ndarray:
        """True at times (n,) when the frequency is held; of a continuous sweep at all times."""
        return np.ones(len(time), bool) if not self.steps else self._into_step(time)[1] == 1.0

    def _into_step(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Number of the held frequency at times (n,), and the part of its glide that is done."""
        step, glides = self.length / self.steps, self.glides
        k = np.floor(time / step).astype(int).clip(0, len(glides) - 1)
        since = time - k * step
        return k, np.where(since < glides[k], since / np.maximum(glides[k], 1e-300), 1.0)

    def _stepped(self, time: np.ndarray) -> np.ndarray:
        """Frequency (n,) whose logarithm glides with a continuous rate from one to the next.

        Were it to jump, the displacement a/omega^2 sin would jump with it, or its velocity: no
        enclosure does either.
        """
        k, part = self._into_step(time)
        gone = part * part * (3.0 - 2.0 * part)
        held = self.held
        return np.asarray(held[np.maximum(k - 1, 0)] ** (1.0 - gone) * held[k] ** gone)

    def table(self, size: Size) -> Table:
        """The motion; its phase is the integral of the frequency, by the trapezoidal rule."""
        spacing, n = _points(max(self.first, self.last), self.duration)
        time = spacing * np.arange(n)
        omega = 2.0 * math.pi * self.frequency(time)
        phase = spacing * np.concatenate([[0.0], np.cumsum(0.5 * (omega[1:] + omega[:-1]))])
        amplitude = size.as_displacement(omega)
        growth = np.gradient(amplitude, spacing)
        rate = growth * np.sin(phase) + amplitude * omega * np.cos(phase)
        return Table(amplitude * np.sin(phase), rate, spacing)


def density(psd: np.ndarray, frequency: np.ndarray) -> np.ndarray:
    """Power spectral density at frequencies (n,) [Hz], from breakpoints (k, 2): log-log lines."""
    return np.exp(np.interp(np.log(frequency), np.log(psd[:, 0]), np.log(psd[:, 1])))


def power_between(psd: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Integral of the density over each of the intervals between edges (n+1,) [Hz], exactly.

    Between breakpoints S = S_1 (f/f_1)^p: its integral is S_1 f_1/(p+1) ((f/f_1)^(p+1) - 1), or
    S_1 f_1 ln(f/f_1) where p = -1.
    """
    at = np.unique(np.concatenate([edges, psd[:, 0]]))
    at = at[(at >= psd[0, 0]) & (at <= psd[-1, 0])]
    height = density(psd, at)
    ratio = at[1:] / at[:-1]
    slope = np.log(height[1:] / height[:-1]) / np.log(ratio) + 1.0
    whole = height[:-1] * at[:-1] * np.where(
        np.abs(slope) < 1e-9, np.log(ratio), np.expm1(slope * np.log(ratio)) / _not_zero(slope)
    )  # fmt: skip
    upto = np.concatenate([[0.0], np.cumsum(whole)])
    return np.diff(np.interp(edges, at, upto))


def _not_zero(x: np.ndarray) -> np.ndarray:
    return np.where(np.abs(x) < 1e-9, 1.0, x)


def third_octaves(psd: np.ndarray, period: float) -> np.ndarray:
    """Edges [Hz] of the third octaves about 1000 x 2^(k/3) Hz that a density covers.

    Those at its ends are cut off there, and taken with their neighbours where they hold fewer than
    LINES multiples of 1/period [Hz].
    """
    low, high = psd[0, 0], psd[-1, 0]
    first, last = (math.floor(3.0 * math.log2(f / 1000.0) + 0.5) for f in (low, high))
    edges = 1000.0 * 2.0 ** ((np.arange(first, last + 2) - 0.5) / 3.0)
    width = LINES / period
    inside = edges[(edges > low + width) & (edges < high - width)]
    return np.concatenate([[low], inside, [high]])


def random_lines(psd: np.ndarray, unit: str, seed: int, period: float) -> Lines:
    """Sines with the power of a density and seeded phases, at whole multiples of 1/period [Hz].

    psd (k, 2): frequencies [Hz] and density [unit^2/Hz]. Each third octave has just the power of
    the density.
    """
    first, last = math.ceil(psd[0, 0] * period), math.floor(psd[-1, 0] * period)
    frequency = np.arange(first, last + 1) / period
    bands = third_octaves(psd, period)
    power = density(psd, frequency.clip(psd[0, 0], psd[-1, 0])) / period
    which = np.clip(np.searchsorted(bands, frequency, "right") - 1, 0, len(bands) - 2)
    there = np.bincount(which, power, len(bands) - 1)
    power *= (power_between(psd, bands) / there)[which]
    omega = 2.0 * math.pi * frequency
    phase = np.random.default_rng(seed).uniform(0.0, 2.0 * math.pi, len(omega))
    return Lines(Size(1.0, unit).as_displacement(omega) * np.sqrt(2.0 * power), omega, phase)


def random_table(lines: Lines, period: float, length: float) -> Table:
    """The motion of such sines, from their Fourier series, over a length [s]."""
    at = np.rint(lines.omega * period / (2.0 * math.pi)).astype(int)
    n = PER_CYCLE * int(at[-1] + 1)
    series = np.zeros(n // 2 + 1, complex)
    series[at] = -0.5j * n * lines.amplitude * np.exp(1j * lines.phase)
    place = np.fft.irfft(series, n)
    series[at] *= 1j * lines.omega
    kept = np.arange(min(math.ceil(length * n / period) + 2, n + 1)) % n
    return Table(place[kept], np.fft.irfft(series, n)[kept], period / n)


def band_errors(lines: Lines, psd: np.ndarray, unit: str, period: float) -> np.ndarray:
    """Power of each third octave of the lines over that of the density [dB]."""
    bands = third_octaves(psd, period)
    size = lines.amplitude / Size(1.0, unit).as_displacement(lines.omega)
    frequency = lines.omega / (2.0 * math.pi)
    power = np.histogram(frequency, bands, weights=0.5 * size**2)[0]
    return np.asarray(10.0 * np.log10(power / power_between(psd, bands)))


def pulse(form: str, size: Size, length: float) -> Table:
    """A shock from rest: half a sine, or a saw-tooth that ends at its peak; length [s].

    Of an acceleration the velocity that it gave stays. A force or a displacement is itself the
    pulse, and nothing afterwards.
    """
    n = 20 * PER_CYCLE
    spacing = length / n
    way = np.arange(n + 1) / n
    shapes: dict[str, tuple[Callable[[np.ndarray], np.ndarray], ...]] = {
        "half_sine": (
            lambda s: math.pi * np.cos(math.pi * s),
            lambda s: np.sin(math.pi * s),
            lambda s: (1.0 - np.cos(math.pi * s)) / math.pi,
            lambda s: (s - np.sin(math.pi * s) / math.pi) / math.pi,
        ),
        "terminal_peak": (
            np.ones_like, lambda s: s, lambda s: s**2 / 2.0, lambda s: s**3 / 6.0,
        ),
    }  # fmt: skip
    derivatives, order = shapes[form], _ORDER[size.unit]
    place = size.value * length**order * derivatives[1 + order](way)
    rate = size.value * length ** (order - 1) * derivatives[order](way)
    if order == 0:
        place, rate = np.append(place, [0.0, 0.0]), np.append(rate, [0.0, 0.0])
    return Table(place, rate, spacing)
