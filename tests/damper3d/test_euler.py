"""Euler's scheme of the thesis (eqs 3.29, 3.30) and the engine's leapfrog in one contact.

An acrylic sphere of 5 mm hits a wall of its own material head-on at 1 m/s.
"""

import math
from itertools import pairwise

import pytest
from analytic import hertz_impact

from damper3d.studies.single_contact.spheres.impact import Impact, run
from granulab.contact import load_table
from granulab.contact.hertz import hertz_force

ACRYLIC = load_table("acrylic").material("acrylic")
ELASTIC = Impact(ACRYLIC, ACRYLIC, speed=1.0)
DAMPED = Impact(ACRYLIC, ACRYLIC, speed=1.0, restitution=0.86)
STIFFNESS = ELASTIC.law.hertz * math.sqrt(ELASTIC.radius)  # F = K d^1.5 [N/m^1.5]
OVERLAP, _, TIME = hertz_impact(
    0.75 * ELASTIC.law.hertz, ELASTIC.radius, ELASTIC.mass, ELASTIC.speed
)
THESIS = round(TIME / 1e-6)  # steps of a contact in the thesis's runs, 1 us each: 42
STEPS = (50, 100, 200, 400, 800)  # of the elastic contact time


def by_euler(impact, steps, implicit=False):
    """Rebound over impact speed, and deepest overlap [m], by eqs 3.29 and 3.30 as printed: position
    and velocity both go on with the rates of the step's beginning. implicit: the position with
    the velocity of the step's end."""
    dt, overlap, rate, deepest = TIME / steps, 0.0, impact.speed, 0.0
    while overlap > 0.0 or rate > 0.0:
        force = hertz_force(
            impact.law, STIFFNESS, impact.mass, impact.law.damping, max(overlap, 0.0), rate
        )[2]
        later = rate - force / impact.mass * dt
        overlap, rate = overlap + (later if implicit else rate) * dt, later
        deepest = max(deepest, overlap)
    return -rate / impact.speed, deepest


def by_leapfrog(impact, steps):
    """The same by the engine's scheme."""
    out = run(impact, steps)
    return out.normal_restitution, out.max_overlap_m


def orders(errors):
    """Observed orders of errors at successively halved steps."""
    return [math.log2(a / b) for a, b in pairwise(errors)]


def test_euler_gains_energy_in_proportion_to_the_step():
    """With m a = -F(d) and k = dF/dd a step of Euler's adds (dt^2/2)(m a^2 + k v^2) to the energy,
    to second order, and never takes any. By parts the sums of both terms over a contact are
    equal, so that the rebound is faster by the share

        (dt/(m v0^2)) int k v^2 dt = 3 (dt/(m v0)) K D^1.5 int_0^1 sqrt(x (1 - x^2.5)) dx,

    D the deepest overlap and the last integral B(3/5, 3/2)/2.5: 5.57 steps over the contact time.
    Tolerance: the next order, of the same size times dt/T."""
    beta = math.gamma(0.6) * math.gamma(1.5) / math.gamma(2.1) / 2.5
    share = 3 * TIME * STIFFNESS * OVERLAP**1.5 * beta / (ELASTIC.mass * ELASTIC.speed)
    assert share == pytest.approx(5.57, abs=0.01)
    gained = [by_euler(ELASTIC, n)[0] - 1.0 for n in STEPS]
    assert gained == pytest.approx([share / n for n in STEPS], rel=share / STEPS[0])
    assert gained[-1] == pytest.approx(share / STEPS[-1], rel=share / STEPS[-1])
    assert orders(gained)[-1] == pytest.approx(1.0, abs=0.05)


def test_deepest_overlap_by_both_schemes():
    """Of first order by Euler, of second by the leapfrog, whose steps miss the deepest point by
    half of one at most, a loss of the second order. Tolerance: 0.1 and 0.2 of the order, as where
    the deepest point lies between two steps changes with the step."""
    euler = [by_euler(ELASTIC, n)[1] / OVERLAP - 1.0 for n in STEPS]
    leapfrog = [abs(by_leapfrog(ELASTIC, n)[1] / OVERLAP - 1.0) for n in STEPS]
    assert min(orders(euler)) > 0.9
    assert (STEPS[-1] / STEPS[0]) ** 1.8 < leapfrog[0] / leapfrog[-1]
    assert leapfrog[-1] < 1e-3 * euler[-1]


def test_restitution_at_the_thesis_s_step():
    """42 steps a contact. As printed Euler's scheme makes 1.14 of an elastic impact and 0.98 of
    one with e = 0.86: what the dashpot takes the scheme gives back. With the position by the
    step's new velocity it is a leapfrog: an elastic impact is 1 to rounding of the same as the
    engine's, which is 1 to 1e-5. With the dashpot both are within 2e-3 of 0.86; their error falls
    with an order between one and two, as the dashpot's force vanishes only as the fourth root of
    the overlap, so that a sum over steps misses a part of the last one."""
    assert THESIS == 42
    assert by_euler(ELASTIC, THESIS)[0] == pytest.approx(1.144, abs=1e-3)
    assert by_euler(DAMPED, THESIS)[0] == pytest.approx(0.983, abs=1e-3)
    late, engine = by_euler(ELASTIC, THESIS, implicit=True)[0], by_leapfrog(ELASTIC, THESIS)[0]
    assert late == pytest.approx(engine, rel=1e-12)
    assert engine == pytest.approx(1.0, abs=1e-5)
    assert by_euler(DAMPED, THESIS, implicit=True)[0] == pytest.approx(0.86, abs=2e-3)
    assert by_leapfrog(DAMPED, THESIS)[0] == pytest.approx(0.86, abs=2e-3)
    off = [by_leapfrog(DAMPED, n)[0] - 0.86 for n in (50, 800)]
    assert 16**1.0 < off[0] / off[1] < 16**2.0
