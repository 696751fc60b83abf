"""One ball in a box on a host, by events: the host exact between impacts, impacts at once.

    M x'' + c x' + k x = F sin(omega t + phase),    impact: (v_ball - v_box)' = -e (v_ball - v_box)

Two symmetric impacts a cycle have a steady state: half a cycle later all signs have changed (Masri
and Caughey 1966, J. Appl. Mech. 33, 586).
"""

import math
from dataclasses import dataclass, replace

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
    force: float
    omega: float
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

    def after_impact(self, v: float, u: float) -> tuple[float, float]:
        """Velocities of box and ball after an impact at v and u."""
        total, apart = self.mass + self.ball, -self.restitution * (u - v)
        mean = (self.mass * v + self.ball * u) / total
        return mean - self.ball / total * apart, mean + self.mass / total * apart

    def run(
        self, end: float, start: tuple[float, float], step: float, ball: float = 0.0
    ) -> np.ndarray:
        """Time, place of the box and number of impacts so far, each step (n, 3).

        start: place and velocity of the box; the ball begins at rest in the place given. The step
        is to be short against the time between impacts, which are looked for at its end.
        """
        t0, (x0, v0), y0, u0, hits = 0.0, start, ball, 0.0, 0
        rows = [(0.0, x0, 0)]

        def off(t: float) -> float:
            """Way that the ball is beyond a wall."""
            return abs(y0 + u0 * (t - t0) - self.box(t0, x0, v0, t)[0]) - 0.5 * self.gap

        for k in range(1, round(end / step) + 1):
            last, now = (k - 1) * step, k * step
            while off(now) > 0:
                low, high = max(last, t0), now
                for _ in range(60):
                    middle = 0.5 * (low + high)
                    low, high = (low, middle) if off(middle) > 0 else (middle, high)
                (x, v), y = self.box(t0, x0, v0, high), y0 + u0 * (high - t0)
                v0, u0 = self.after_impact(v, u0)
                # A hair within the wall, so that the next search begins there.
                t0, x0, y0 = high, x, x + math.copysign(0.5 * self.gap, y - x) * (1 - 1e-12)
                last, hits = high, hits + 1
            rows.append((now, self.box(t0, x0, v0, now)[0], hits))
        return np.array(rows)

    def two_impacts(self, amplitude: float) -> float:
        """Amplitude of x in the steady state of two symmetric impacts a cycle; begins near one.

        Just after an impact at the wall above the box is at a with the velocity v, the force at its
        phase. Half a cycle later it is at -a, meets the ball, and has -v then.
        """
        from scipy.optimize import least_squares

        half = math.pi / self.omega

        def left(p: np.ndarray) -> list[float]:
            one = replace(self, phase=p[2])
            x, before = one.box(0.0, p[0], p[1] * self.omega, half)
            ball = -(2 * p[0] + self.gap) / half
            box, flown = one.after_impact(before, ball)
            return [x + p[0], box / self.omega + p[1], (flown + ball) / self.omega]

        best = min(
            (least_squares(left, [a, v, phase], x_scale=[amplitude, amplitude, 1.0], xtol=1e-15,
                           ftol=1e-15, gtol=1e-15)
             for phase in np.linspace(0, 2 * np.pi, 8, endpoint=False)
             for a, v in ((amplitude, 0.0), (0.0, amplitude), (0.0, -amplitude))),
            key=lambda found: (found.cost > 1e-20, abs(found.x[0] - amplitude)),
        )  # fmt: skip
        a, v, phase = best.x
        one, times = replace(self, phase=phase), np.linspace(0, half, 2001)[:-1]
        x = np.array([one.box(0.0, a, v * self.omega, t)[0] for t in times])
        return float(abs(2 * np.mean(x * np.exp(-1j * self.omega * times))))


def first_harmonic(time: np.ndarray, x: np.ndarray, omega: float) -> float:
    """Amplitude of a column at omega over whole cycles, its row before them left out."""
    return float(abs(2 * np.mean(x[1:] * np.exp(-1j * omega * time[1:]))))
