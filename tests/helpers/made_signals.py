"""Made-up signals of a bouncing body, with known impact times and restitution."""

from dataclasses import dataclass, field
from functools import cache

import numpy as np
from scipy.integrate import solve_ivp
from scipy.io import wavfile


@dataclass(frozen=True)
class Bounces:
    """A body that bounces n times with the restitutions e (one, or one for each pair)."""

    restitution: float | tuple[float, ...] = 0.8
    n: int = 5
    first_flight: float = 0.4  # [s]
    start: float = 0.5  # [s]

    @property
    def times(self) -> np.ndarray:
        """Of the impacts (n,) [s]."""
        ratios = np.broadcast_to(self.restitution, self.n - 2)
        flights = self.first_flight * np.concatenate([[1.0], np.cumprod(ratios)])
        return self.start + np.concatenate([[0.0], np.cumsum(flights)])

    @property
    def speeds(self) -> np.ndarray:
        """With which it arrives (n,), over that of the first impact."""
        first = np.atleast_1d(self.restitution)[0]  # of the first impact, as of the second
        ratios = np.broadcast_to(self.restitution, self.n - 2)
        return np.concatenate([[1.0], np.cumprod([first, *ratios])])


def half_sine(t, speed, duration=1e-3):
    """The force of a linear spring, for a body that arrives at 0."""
    inside = (t > 0) & (t < duration)
    return speed * np.where(inside, np.sin(np.pi * np.clip(t / duration, 0, 1)), 0.0)


@cache
def _hertz_pulse():
    """Time over the contact's duration, force over its largest: d'' = -d^1.5, never damped."""
    fall = solve_ivp(
        lambda t, y: (y[1], -max(y[0], 0.0) ** 1.5), (0.0, 5.0), (0.0, 1.0), rtol=1e-9, atol=1e-12,
        events=[lambda t, y: y[0] + 1.0 * (t < 0.1)], dense_output=True,
    )  # fmt: skip
    t = np.linspace(0.0, fall.t_events[0][-1], 2000)
    force = np.maximum(fall.sol(t)[0], 0.0) ** 1.5
    return t / t[-1], force / force.max()


def hertz(t, speed, duration=1e-3):
    """The force of a Hertz contact, F ~ overlap^1.5: its time goes with speed^-0.2."""
    part = np.clip(t / (duration * speed**-0.2), 0.0, 1.0)
    return speed**1.2 * np.interp(part, *_hertz_pulse())


def tone(t, speed, frequency=2500.0, decay=8e-3):
    """A plate that rings after the impact."""
    after = np.maximum(t, 0.0)
    return speed * np.sin(2 * np.pi * frequency * after) * np.exp(-after / decay)


@dataclass(frozen=True)
class Room:
    """How a signal is recorded."""

    rate: float = 44100.0
    noise: float = 0.003  # standard deviation over the first impact's largest sample
    echoes: tuple[tuple[float, float], ...] = ()  # delay [s], part of the direct sound
    hum: float = 0.0  # amplitude at 50 Hz, likewise
    clip: float = np.inf  # largest sample, likewise
    length: float = 3.0  # [s]
    shape: object = tone
    options: dict = field(default_factory=dict)  # of the shape

    def record(self, bounces: Bounces, seed: int) -> np.ndarray:
        """The samples (n,) of the bounces, with a seed's noise; the first impact is about 1."""
        rng = np.random.default_rng(seed)
        t = np.arange(round(self.length * self.rate)) / self.rate
        x = self.noise * rng.standard_normal(len(t))
        x += self.hum * np.sin(2 * np.pi * 50.0 * t + rng.uniform(0, 2 * np.pi))
        for time, speed in zip(bounces.times, bounces.speeds, strict=True):
            for delay, part in ((0.0, 1.0), *self.echoes):
                x += part * self.shape(t - time - delay, speed, **self.options)
        return np.clip(x, -self.clip, self.clip)


def write_wav(path, x, rate, kind="int16"):
    """A WAV of 8, 16, 32 bit or floats, half of full scale at x = 1."""
    x = 0.5 * np.asarray(x)
    if kind == "uint8":
        samples = np.clip(np.round(128 + 128 * x), 0, 255)
    elif kind.startswith("int"):
        full = np.iinfo(kind).max
        samples = np.clip(np.round(x * full), -full, full)
    else:
        samples = x
    wavfile.write(path, round(rate), samples.astype(kind))
    return path


def write_csv(path, x, rate, head="time [s];force [N]", separator=";"):
    """A table of times and samples."""
    t = np.arange(len(x)) / rate
    np.savetxt(path, np.column_stack([t, x]), delimiter=separator, header=head, comments="")
    return path
