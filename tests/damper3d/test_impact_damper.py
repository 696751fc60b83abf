"""One ball on a host where its motion is chaotic: statistics of the engine and of events."""

import math
from dataclasses import replace

import numpy as np
import pytest
from host_scenes import on_host
from impact_damper import ImpactDamper

from damper3d.case.host.host import Drive
from damper3d.case.host.modes import Modes

CYCLE = 1 / 0.95  # [s]
EACH = 500  # rows of the engine a cycle: 2 ms
STARTS, SKIPPED, COUNTED = 8, 60, 400  # cycles
MOST = 4  # impacts of a cycle; more are counted to these
SURE = 0.99  # of all quantities together

# 5 % below the resonance, a ball of a fifth of the mass: 0 to 4 impacts a cycle, without order.
CHAOTIC = ImpactDamper(
    1.0, 2 * np.pi, 0.01, ball=0.2, gap=20e-3, restitution=0.9,
    force=2 * 0.01 * (2 * np.pi) ** 2 * 50e-3, omega=2 * np.pi / CYCLE,
)  # fmt: skip


def statistics(x: np.ndarray, impacts: np.ndarray) -> np.ndarray:
    """Mean square displacement, mean impacts a cycle, share of cycles with 0, 1 ... MOST of them.

    x (n,) [m]; impacts (k,) of each cycle.
    """
    shares = np.bincount(np.minimum(impacts, MOST), minlength=MOST + 1) / len(impacts)
    return np.array([np.mean(x**2), impacts.mean(), *shares])


def by_events(damper: ImpactDamper, off: float) -> np.ndarray:
    """The statistics after the ball starts off the middle [m], the box on its bare response."""
    turned = replace(damper, phase=-float(np.angle(damper.bare())))
    start = 0.0, damper.omega * abs(damper.bare())
    rows = turned.run((SKIPPED + COUNTED) * CYCLE, start, CYCLE / 100, off)[SKIPPED * 100 :]
    return statistics(rows[1:, 1], np.diff(rows[::100, 2]).astype(int))


def by_engine(damper: ImpactDamper, off: float) -> np.ndarray:
    """The same from the engine; an impact is where the ball's velocity begins to change.

    Without gravity and friction it changes at walls only, in a millisecond: two impacts within
    4 ms are one here, 0.4 % of a cycle with two impacts on average.
    """
    modes = Modes.single(damper.mass, damper.omega0, damper.damping_ratio)
    dt = CYCLE / (EACH * 80)  # 26 us, a fortieth of a contact
    sim = on_host(
        modes, Drive(damper.omega, force=damper.force), mass=damper.ball, gap=damper.gap, dt=dt,
        restitution=damper.restitution, steps_per_sample=80, off=off,
    )  # fmt: skip
    sim.run(SKIPPED * EACH)
    rows = sim.run(COUNTED * EACH + 1)
    speed = rows["mean_velocity"][:, 2]
    pushed = np.abs(np.diff(speed)) > 1e-9
    begins = pushed & ~np.concatenate([[False], pushed[:-1]])
    return statistics(rows["displacement"][1:], begins.reshape(COUNTED, EACH).sum(axis=1))


def apart(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Difference of the means of two sets (n, q) over the half width of its interval (q,).

    Student's, of n - 1 degrees of freedom (the least that Welch's has), for SURE of all q together
    (Bonferroni). Starts are apart by far more than what chaos forgets in SKIPPED cycles, and each
    gives one independent value, so that nothing need be known of correlations within a run.
    """
    from scipy.stats import t

    error = np.sqrt((a.var(axis=0, ddof=1) + b.var(axis=0, ddof=1)) / len(a))
    half = t.ppf(1 - (1 - SURE) / (2 * a.shape[1]), len(a) - 1) * error
    return np.asarray(np.abs(a.mean(axis=0) - b.mean(axis=0)) / half)


@pytest.mark.validation
def test_one_ball_in_chaotic_motion_has_the_statistics_of_events():
    """Mean square motion, impacts a cycle and their distribution, over 8 starts of 400 cycles.

    The engine's contact takes a thousandth of the cycle, which is far within the intervals, some
    percent of each mean; a restitution that is off by a tenth is outside them.
    """
    offs = np.linspace(-0.35, 0.35, STARTS) * CHAOTIC.gap
    events = np.array([by_events(CHAOTIC, off) for off in offs])
    engine = np.array([by_engine(CHAOTIC, off) for off in offs])
    assert np.count_nonzero(events.mean(axis=0)[2:] > 0.02) >= 4  # it has no order
    assert (apart(engine, events) < 1).all()
    wrong = replace(CHAOTIC, restitution=1.1 * CHAOTIC.restitution)
    missed = np.array([by_events(wrong, off) for off in offs])
    assert (apart(engine, missed) > 1).any()
    assert math.sqrt(engine.mean(axis=0)[0]) < 0.7 * abs(CHAOTIC.bare()) / math.sqrt(2)
