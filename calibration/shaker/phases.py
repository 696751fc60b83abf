"""Motional phase of a shaken bed from force and acceleration alone (thesis, sec. 7.6).

    F_bed = m a - F         of the bed on the enclosure of mass m, phase error taken off
    M dw/dt = -F_bed - M g  with w the velocity of the bed's centre of mass, M the bed's mass

No transducer holds a constant force: that of F_bed is the bed's weight, since over a cycle its
momentum returns. All is taken from the mean cycle, which keeps noise out, acceleration positive
upwards; V is the enclosure's largest speed. The first line that holds names the phase:

    solid-like      slip < 1/100: mean square of w against the enclosure, over the enclosure's own
    bouncing bed    impulses >= 1/4: either end gives the bed a quarter of 2 M V a cycle, and
                    energy >= 1/2: mean square of w over the enclosure's own
    fluidised       the rest

Riding along is asked first: beyond 1 g a bed that fills its enclosure pushes on both ends, too.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibration.shaker.record import Record, whole_cycles

GRAVITY = 9.81  # [m/s2]
SOLID, BOUNCING, FLUIDISED = "solid-like", "bouncing bed", "fluidised"
# A bed is solid where all but an unseen tenth of it rides along. A tenth that moves against the
# enclosure as fast as that itself moves the centre of mass with a tenth of the velocity.
RIDES = 0.1**2
# An end is struck by the bed where it reverses a quarter of the ideal collision's 2 M V (eq. 6.10),
# as for a bed that arrives at rest and leaves with V/2: docs/damper/phases.md has the same.
STRUCK = 0.25
# The bed moves as one where its mean motion has most of the energy of riding along. That of its
# particles about it, which docs/damper/phases.md compares with, shows in no force.
AS_ONE = 0.5
_PARTS = 100  # of a cycle: impacts take a few hundredths


class BedPhase(NamedTuple):
    """Name of the phase, and the measures that it is named from, without dimension."""

    name: str
    slip: float
    low_impulse: float  # of the lower end
    high_impulse: float
    energy: float

    def in_words(self) -> str:
        """Name and measures in a line."""
        return (
            f"{self.name} (slip {self.slip:.2g}, impulses {self.low_impulse:.2f} and "
            f"{self.high_impulse:.2f} of 2 M V, energy {self.energy:.2g})"
        )


def bed_phase(
    record: Record, enclosure_mass: float, particle_mass: float, phase_error: float = 0.0,
    gravity: float = GRAVITY,
) -> BedPhase:  # fmt: skip
    """The phase of the bed in a record that is shaken at its first tone.

    Masses [kg]; phase_error [rad] of the force at that tone; gravity [m/s2] along the motion,
    downwards (0 across it).
    """
    force, moved = (mean_cycle(x, record.rate, record.frequencies[0]) for x in record.samples)
    force *= record.sense
    lines = np.fft.rfft(force)
    lines[1] *= np.exp(-1j * phase_error)
    on_enclosure = enclosure_mass * moved - np.fft.irfft(lines, len(force))
    on_enclosure -= on_enclosure.mean()
    omega = 2.0 * np.pi * float(record.frequencies[0])
    velocity = _integral(moved, omega)
    bed = _integral(-on_enclosure / particle_mass, omega)
    own = float((velocity**2).mean())
    push = particle_mass * gravity - on_enclosure  # of the ends on the bed, upwards
    most = 2.0 * particle_mass * np.sqrt(2.0 * own) * omega / (2.0 * np.pi)  # [N] in the mean
    return _named(
        float(((bed - velocity) ** 2).mean()) / own,
        float(np.maximum(push, 0.0).mean() / most),
        float(np.maximum(-push, 0.0).mean() / most),
        float((bed**2).mean()) / own,
    )


def _named(slip: float, low: float, high: float, energy: float) -> BedPhase:
    name = FLUIDISED
    if slip < RIDES:
        name = SOLID
    elif min(low, high) >= STRUCK and energy >= AS_ONE:
        name = BOUNCING
    return BedPhase(name, slip, low, high, energy)


def mean_cycle(x: NDArray[np.float64], rate: float, frequency: float) -> NDArray[np.float64]:
    """Means of samples (n,) over parts of the cycle of a tone [Hz], a hundred or one a sample."""
    cycles, parts = whole_cycles(len(x), rate, frequency), min(_PARTS, int(rate / frequency + 0.01))
    edges = np.round(np.arange(cycles * parts + 1) * rate / (frequency * parts)).astype(int)
    sums = np.diff(np.concatenate([[0.0], np.cumsum(x)])[np.minimum(edges, len(x))])
    return np.asarray((sums / np.diff(edges)).reshape(cycles, parts).mean(axis=0))


def _integral(x: NDArray[np.float64], omega: float) -> NDArray[np.float64]:
    """Integral over time of a cycle (n,) at omega [rad/s], without a mean."""
    lines = np.fft.rfft(x)
    orders = np.maximum(np.arange(len(lines)), 1)
    lines = lines / (1j * orders * omega)
    lines[0] = 0.0
    return np.fft.irfft(lines, len(x))
