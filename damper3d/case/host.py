"""The host of an enclosure: modes, what excites them, and the bare response in closed form.

Single mode of a mass M (structure and empty enclosure): omega_0, zeta_0, and shapes 1/sqrt(M), so
that M x'' + c x' + k x = f + F with c = 2 zeta_0 omega_0 M, k = omega_0^2 M.
"""

import cmath
import math
from dataclasses import dataclass

import numpy as np

from damper3d.engine.motions import Sines, at_rest
from damper3d.engine.motions.host import Host, Ringing, propagator


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


def host_of(modes: Modes, drive: Drive, time_step: float, weight: float) -> Host:
    """The engine's host; weight: of the bed at rest, along the motion [N].

    A forced host starts on its bare response, with the phase for which the damper moves as
    X sin(omega t). A release lets go of what a force at the damper pulled off its place, and of
    what a blow there set in motion.
    """
    n = len(modes.omega)
    if drive.is_release:
        alone, force, base = _released(modes, drive), at_rest(), at_rest()
    else:
        turn = -cmath.phase(bare_amplitude(modes, drive))  # of e^(i omega t), sines taken
        forced = drive.force * modes.force_shape + drive.base * drive.omega**2 * modes.participation
        q = modes.receptance(drive.omega, forced) * cmath.exp(1j * turn)
        alone = tuple(_sine(abs(one), drive.omega, cmath.phase(one)) for one in q.tolist())
        force, base = (
            Sines(np.array([size]), np.array([drive.omega]), np.array([turn]), 0.0)
            for size in (drive.force, drive.base)
        )
    damping = 2 * modes.damping_ratio * modes.omega
    pairs = zip(modes.omega.tolist(), damping.tolist(), strict=True)
    return Host(
        alone=alone, force=force, base=base, shape=modes.shape.copy(),
        force_shape=modes.force_shape.copy(), participation=modes.participation.copy(),
        omega=modes.omega.copy(), damping=damping,
        step=np.array([propagator(w, c, time_step) for w, c in pairs]),
        time_step=time_step, weight=weight,
        answer=np.zeros((n, 2)), pushed=np.zeros(1), books=np.zeros(2),
    )  # fmt: skip


def _sine(amplitude: float, omega: float, phase: float, rate: float = 0.0) -> Ringing:
    return Ringing(*(np.array([x]) for x in (amplitude, rate, omega, phase)))


def _released(modes: Modes, drive: Drive) -> tuple[Ringing, ...]:
    """Free decay of each mode, from a static pull and a blow at the damper."""
    pull = modes.shape / modes.omega**2
    place = drive.start_displacement * pull / (modes.shape @ pull)
    rate = drive.start_velocity * modes.shape / (modes.shape @ modes.shape)
    found = []
    for q, v, w, zeta in zip(place, rate, modes.omega, modes.damping_ratio, strict=True):
        decay, ringing = zeta * w, w * math.sqrt(1 - zeta**2)
        across = (v + decay * q) / ringing
        size, phase = math.hypot(q, across), math.atan2(q, across)
        found.append(_sine(size, float(ringing), phase, float(decay)))
    return tuple(found)
