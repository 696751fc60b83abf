"""One ball in a box on a host, by events: the host exact between impacts, impacts at once.

    M x'' + c x' + k x = F sin(omega t + phase),    impact: (v_ball - v_box)' = -e (v_ball - v_box)

Two symmetric impacts a cycle have a steady state in closed form (Masri and Caughey 1966, J. Appl.
Mech. 33, 586): every half cycle all signs change, and with them the state.
"""

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class ImpactDamper:
    """A host with a ball that flies between two walls; SI."""

    mass: float
    omega0: float
    damping_ratio: float
    ball: float  # mass
    gap: float  # that the ball has between the walls
    restitution: float
    force: float = 0.0
    omega: float = 1.0
    phase: float = 0.0

    def bare(self) -> complex:
        """X of x = Im(X e^(i omega t)) of the box without a ball."""
        square = self.omega0**2 - self.omega**2 + 2j * self.damping_ratio * self.omega0 * self.omega
        return self.force / self.mass * complex(np.exp(1j * self.phase)) / square

    def _free(self, t: float, x: float, v: float) -> tuple[float, float]:
        """Free decay after t of (x, v)."""
        decay = self.damping_ratio * self.omega0
        w = self.omega0 * math.sqrt(1 - self.damping_ratio**2)
        c, s, fall = math.cos(w * t), math.sin(w * t) / w, math.exp(-decay * t)
        return (
            fall * ((c + decay * s) * x + s * v),
            fall * ((c - decay * s) * v - self.omega0**2 * s * x),
        )

    def box(self, t0: float, x: float, v: float, t: float) -> tuple[float, float]:
        """Place and velocity of the box at t, from (x, v) at t0."""
        bare = self.bare()
        own0, own = bare * np.exp(1j * self.omega * t0), bare * np.exp(1j * self.omega * t)
        left = self._free(t - t0, x - own0.imag, v - (1j * self.omega * own0).imag)
        return left[0] + own.imag, left[1] + (1j * self.omega * own).imag

    def run(self, end: float, start: tuple[float, float], looks: float) -> np.ndarray:
        """Place of the box at looks (n, 2): t and x; the ball begins at rest in the middle.

        start: place and velocity of the box; looks [s] is also the step in which impacts are
        looked for, which is to be short against the time between two.
        """
        t0, (x0, v0), y0, u0 = 0.0, start, 0.0, 0.0
        rows = [(0.0, x0)]

        def off(t: float) -> float:
            """Way that the ball is beyond a wall."""
            return abs(y0 + u0 * (t - t0) - self.box(t0, x0, v0, t)[0]) - 0.5 * self.gap

        for k in range(1, round(end / looks) + 1):
            last, now = (k - 1) * looks, k * looks
            while off(now) > 0:
                low, high = max(last, t0), now
                for _ in range(60):
                    middle = 0.5 * (low + high)
                    low, high = (low, middle) if off(middle) > 0 else (middle, high)
                x, v = self.box(t0, x0, v0, high)
                y, total = y0 + u0 * (high - t0), self.mass + self.ball
                mean = (self.mass * v + self.ball * u0) / total
                apart = -self.restitution * (u0 - v)
                side = math.copysign(0.5 * self.gap, y - x)
                v0, u0 = mean - self.ball / total * apart, mean + self.mass / total * apart
                t0, x0, y0 = high, x, x + side * (1 - 1e-12)
                last = high
            rows.append((now, self.box(t0, x0, v0, now)[0]))
        return np.array(rows)

    def two_impacts(self) -> float:
        """Amplitude of the first harmonic of x in the steady state of two impacts a cycle.

        Unknown are the place a of the box at an impact, its velocity v after it, and the phase of
        the force: after half a cycle T/2 the box is at -a with the velocity -v before the jump
        that follows. The ball goes from wall to wall, 2 a + gap, in that time.
        """
        from scipy.optimize import fsolve

        half = math.pi / self.omega

        def left(p: np.ndarray) -> list[float]:
            a, v, phase = p
            one = ImpactDamper(**{**vars(self), "phase": phase})
            x1, v1 = one.box(0.0, a, v, half)  # just before the impact on the other side
            u = -(2 * a + self.gap) / half  # the ball hits the wall at +gap/2 at t = 0, flies back
            mean = (self.mass * v1 + self.ball * u) / (self.mass + self.ball)
            apart = -self.restitution * (u - v1)
            after = mean - self.ball / (self.mass + self.ball) * apart
            flown = mean + self.mass / (self.mass + self.ball) * apart
            return [x1 + a, after + v, flown + u]

        raise NotImplementedError
