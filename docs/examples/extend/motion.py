"""A motion of one's own: parabolas end to end, whose acceleration is a square wave."""

from typing import NamedTuple

from damper3d import DamperCase, register_motion, run


class Parabolas(NamedTuple):
    """Up for half of a period, down for the other."""

    acceleration: float  # [m/s2]
    period: float  # [s]


def place_at(motion, t):
    phase, half = t % motion.period, 0.5 * motion.period
    if phase < half:
        return 0.5 * motion.acceleration * phase * (half - phase)
    return -0.5 * motion.acceleration * (phase - half) * (motion.period - phase)


def speed_at(motion, t):
    phase = t % motion.period
    if phase < 0.5 * motion.period:
        return motion.acceleration * (0.25 * motion.period - phase)
    return motion.acceleration * (phase - 0.75 * motion.period)


def of_case(gamma, frequency, gravity, ramp):
    """The motion of a case."""
    return Parabolas(gamma * gravity, 1.0 / frequency)


register_motion("parabolas", Parabolas, place_at, speed_at, of_case, {})

if __name__ == "__main__":
    result = run(DamperCase.load("thesis", {"motion.kind": "parabolas"}))
    print(result.efficiency_with_settling, result.energy_closure)
