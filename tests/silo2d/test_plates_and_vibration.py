"""Friction of front and back plate, and vibrating walls, against closed forms."""

import math

import numpy as np
import pytest
from scenes import ELASTIC as LAW
from scenes import (
    HAIR,
    LEVEL,
    G,
    launch,
    mass,
    position,
    simulation_of,
    velocity,
    wall,
)

from silo2d.case.shape import disc

R, OVERLAP, LENGTH = 5e-3, 1e-5, 0.12
AREA = np.array([math.pi * R**2])
SMOOTH = LAW._replace(kn=1e6, kt=1e6)
STEP = 2e-6


def squeezed(angle=0.0, gravity=0.0, squeeze=OVERLAP):
    """A disc between two smooth parallel walls; f = kn d each, at R - d/2 from its middle."""
    normal = np.array([-math.sin(angle), math.cos(angle)])
    centre = np.array([0.0, LEVEL + 0.1])
    reach = (R - squeeze) * normal
    walls = [wall(angle, through=centre - reach), wall(angle + math.pi, through=centre + reach)]
    return simulation_of(
        [disc("a", 2 * R)], [(*centre, 0.0)], walls=walls, law=SMOOTH, time_step=STEP,
        gravity=gravity,
    )  # fmt: skip


def friction_of(mu, ratio):
    """F = mu K sum f l/L."""
    return mu * ratio * 2 * SMOOTH.kn * OVERLAP * (R - OVERLAP / 2) / LENGTH


def test_plates_stop_a_particle_after_the_path_of_coulomb():
    """v^2/(2 a) with a = F/m; velocities half a step back leave v dt/2 of it, and a step v dt."""
    sim, speed = squeezed(), 0.02
    sim.set_plates(0.5, 0.4, LENGTH, AREA)
    launch(sim, vx=speed)
    before = sim.energies()
    sim.run(20_000)
    a = friction_of(0.5, 0.4) / mass(sim)
    assert position(sim)[0] == pytest.approx(speed**2 / (2 * a), abs=speed * STEP)
    assert velocity(sim)[0] == 0.0
    after = sim.energies()
    assert after["friction_grain_wall"] == pytest.approx(before["kinetic"], rel=1e-3)


def test_plates_stop_a_rotation_after_the_angle_of_coulomb():
    """omega^2 I/(2 M), M = (2/3) R F of a disc, whose I is m R^2/2."""
    sim, spin = squeezed(), 5.0
    sim.set_plates(0.5, 0.4, LENGTH, AREA)
    launch(sim, spin=spin)
    sim.run(20_000)
    moment = 2 / 3 * R * friction_of(0.5, 0.4)
    angle = spin**2 * 0.5 * mass(sim) * R**2 / (2 * moment)
    assert position(sim)[2] == pytest.approx(angle, abs=spin * STEP)
    assert velocity(sim)[2] == 0.0


@pytest.mark.parametrize("holds", [True, False])
def test_plates_hold_a_weight_up_to_their_friction(holds):
    """Between upright smooth walls the weight hangs on the plates alone: it rests, or falls with
    g - F/m."""
    sim = squeezed(math.pi / 2, gravity=G)
    limit = mass(sim) * G / friction_of(1.0, 0.4)  # the mu that just holds
    mu = limit * (1.01 if holds else 0.5)
    sim.set_plates(mu, 0.4, LENGTH, AREA)
    start = position(sim)[1]
    sim.run(5000)
    if holds:
        assert position(sim)[1] == start
    else:
        assert velocity(sim)[1] == pytest.approx(-0.5 * G * 5000 * STEP, rel=1e-3)


def test_plates_without_pressure_do_nothing():
    sim = simulation_of([disc("a", 2 * R)], [(0, 0.3, 0)], time_step=STEP, gravity=G)
    sim.set_plates(0.5, 0.4, LENGTH, AREA)
    sim.run(1000)
    assert velocity(sim)[1] == pytest.approx(-G * 1000 * STEP, rel=2e-3)


def test_a_particle_between_vibrating_walls_moves_as_a_driven_oscillator():
    """Two springs, no damping: x = A w0^2/(w0^2 - w^2) (sin w t - (w/w0) sin w0 t), m w0^2 = 2 kn.

    Overlaps change by less than what they are, so both springs hold. Leapfrog at w0 dt = 0.04:
    phases are off by (w0 dt)^2/24 of the angle, 90 rad here: 7e-3 of the free oscillation, which is
    w/w0 = 0.06 of the driven one.
    """
    amplitude, frequency = 2e-6, 200.0
    sim = squeezed(math.pi / 2)
    sim.vibrate((amplitude, 0.0), frequency)
    natural, omega = math.sqrt(2 * SMOOTH.kn / mass(sim)), 2 * math.pi * frequency
    for _ in range(40):
        sim.run(50)
        t = sim.time
        driven = amplitude * natural**2 / (natural**2 - omega**2)
        x = driven * (math.sin(omega * t) - omega / natural * math.sin(natural * t))
        assert position(sim)[0] == pytest.approx(x, abs=1e-3 * driven)


def test_what_vibrating_walls_give_is_what_the_particle_has():
    """The work is summed from the left, as all dissipation is: off by half a step of it, bounded.

    So half the step leaves half the gap, at any time; terms of second order change that by 5 %.
    """
    gaps = []
    for parts in (1, 2):
        sim = squeezed(math.pi / 2)
        sim.time_step = STEP / parts
        sim.vibrate((2e-6, 0.0), 200.0)
        before = sum(sim.energies().values())
        sim.run(1200 * parts)
        gaps.append(sum(sim.energies().values()) - before)
        assert abs(gaps[-1]) < 0.1 * sim.energies()["kinetic"]
    assert gaps[0] / gaps[1] == pytest.approx(2.0, rel=0.1)


def test_a_floor_that_vibrates_throws_what_lies_on_it_off_at_one_g():
    """Below an acceleration of 1 g a disc stays on the floor; above it flies.

    The first throw is that of the start, at once at full speed: it is over after 0.1 s.
    """
    damped = SMOOTH._replace(gamma_n=2000.0)
    for part, flies in ((0.8, False), (1.5, True)):
        sim = simulation_of(
            [disc("a", 2 * R)], [(0.0, LEVEL + R - HAIR, 0.0)], walls=[wall()], law=damped,
            time_step=STEP, gravity=G,
        )  # fmt: skip
        sim.run(20_000)
        sim.begin_phase(damped, damped, STEP)
        frequency = 30.0
        sim.vibrate((0.0, part * G / (2 * math.pi * frequency) ** 2), frequency)
        sim.run(50_000)
        apart = 0
        for _ in range(100):
            sim.run(400)
            apart += len(sim.contacts()["overlap"]) == 0
        assert (apart > 5) == flies


def test_a_wall_that_vibrates_meets_what_is_near_it():
    """A disc as far from it as it comes is hit in time, whatever else moves: no faster than the
    elastic rebound of a wall at its largest speed, 2 A omega, and by what the wall gave.

    The list of bodies once had the disc's own skin alone, and the wall came upon it unseen.
    """
    amplitude, frequency = 2e-3, 20.0
    sim = simulation_of(
        [disc("a", 2 * R)], [(0.0, LEVEL + R + 1.6e-3, 0.0)], walls=[wall()], time_step=STEP,
    )  # fmt: skip
    sim.vibrate((0.0, amplitude), frequency)
    sim.run(int(0.5 / frequency / STEP))
    speed = velocity(sim)[1]
    assert 0 < speed <= 2 * 2 * math.pi * frequency * amplitude
