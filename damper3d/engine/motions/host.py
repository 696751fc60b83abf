"""A structure that the enclosure rides on: linear modes between the bed's pushes.

    q_r'' + 2 zeta_r w_r q_r' + w_r^2 q_r = s_r f(t) - p_r b''(t) + phi_r F
    x = b + sum_r phi_r q_r

q_r are the modal coordinates for shapes of unit modal mass [m kg^0.5], phi_r and s_r the shapes at
the damper and where the force f acts [kg^-0.5], p_r the participation factors [kg^0.5] under a base
motion b, and F the bed's force on the enclosure, over that of its weight at rest. What sines of f
and b do alone is known beforehand, as a motion for each mode; the answer y_r to F is added to it,
so that an empty host moves exactly as it should. Between kicks by F, one a step like those of the
particles,

    y_r' += phi_r F dt        and then        (y_r, y_r')  <-  exp(A_r dt) (y_r, y_r'),

the modes move exactly: a symmetric splitting, of second order. The velocity that contacts see at a
step is extrapolated by half of the last kick, as the particles' is. Any other f and b are kicks
too, by s_r f dt - p_r (b'(t + dt/2) - b'(t - dt/2)); an empty host then moves as it should to
(w_r dt)^2/24.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from damper3d.engine.motions import registry
from granulab.contact.jit import inlined_inner, inner, njit, specialised, uncounted

# Entries of Host.books [J]: work of the force and of the base since the motion began, what the
# host's own dampers took.
WORK, OWN_DAMPING = range(2)
# Columns that a host adds to a sample: its energy, counted from static equilibrium, and its books.
HOST_ENERGY, HOST_WORK, HOST_DAMPING = range(3)
N_HOST_COLUMNS = 3


class Host(NamedTuple):
    """Modes of a structure, the state of each, and what excites them; r modes."""

    alone: Any  # Ringing: the modal coordinates under force and base, without the bed
    force: Any  # motion whose displacement is the force [N]
    base: Any  # motion of the base [m]
    shape: np.ndarray  # (r,) phi, at the damper [kg^-0.5]
    force_shape: np.ndarray  # (r,) s, where the force acts [kg^-0.5]
    participation: np.ndarray  # (r,) p [kg^0.5]
    omega: np.ndarray  # (r,) w [rad/s]
    damping: np.ndarray  # (r,) 2 zeta w [1/s]
    step: np.ndarray  # (r, 2, 2) exp(A dt)
    time_step: float  # dt [s]
    weight: float  # of the bed at rest, along the motion [N]
    kicked: bool  # whether force and base kick the modes, and are not in `alone`
    closes: bool  # whether it goes on with this damper's push: of several on it, with the last's
    answer: np.ndarray  # (r, 2) y and y' before the kick of now [m kg^0.5, m kg^0.5/s]
    gathered: np.ndarray  # (r,) modal forces of the dampers that pushed in this step [N kg^-0.5]
    pushed: np.ndarray  # (r,) those of all in the last step
    books: np.ndarray  # (2,) see above [J]


CHANGING = ("answer", "pushed", "books")  # arrays that the steps change: what a checkpoint holds


class Behind(NamedTuple):
    """Mobility behind walls that do not turn: all that their contacts need of what moves them."""

    mobility: float  # inverse of the mass that stands behind the walls [1/kg]


class Ringing(NamedTuple):
    """Sums of sines that may die away, one a mode: sum_k A_k exp(-s_k t) sin(w_k t + p_k)."""

    amplitude: np.ndarray  # (r, n) A
    rate: np.ndarray  # (r, n) s [1/s]
    omega: np.ndarray  # (r, n) w [rad/s]
    phase: np.ndarray  # (r, n) p [rad]


@inner
def ringing(motion, r, t):
    """Return the sum of mode r at the time t [s]."""
    total = 0.0
    for k in range(motion.amplitude.shape[1]):
        grown = motion.amplitude[r, k] * np.exp(-motion.rate[r, k] * t)
        total += grown * np.sin(motion.omega[r, k] * t + motion.phase[r, k])
    return total


@inner
def ringing_rate(motion, r, t):
    """Return its derivative in time."""
    total = 0.0
    for k in range(motion.amplitude.shape[1]):
        angle = motion.omega[r, k] * t + motion.phase[r, k]
        grown = motion.amplitude[r, k] * np.exp(-motion.rate[r, k] * t)
        total += grown * (motion.omega[r, k] * np.cos(angle) - motion.rate[r, k] * np.sin(angle))
    return total


def propagator(omega: float, damping: float, dt: float) -> np.ndarray:
    """Exponential (2, 2) of a step dt [s] of q'' + damping q' + omega^2 q = 0, for (q, q')."""
    half = 0.5 * damping
    square = omega**2 - half**2
    root = math.sqrt(abs(square))
    if square > 0:
        c, s = math.cos(root * dt), math.sin(root * dt) / root
    elif square < 0:
        c, s = math.cosh(root * dt), math.sinh(root * dt) / root
    else:
        c, s = 1.0, dt
    decay = math.exp(-half * dt)
    return decay * np.array([[c + half * s, s], [-(omega**2) * s, c - half * s]])


@uncounted
def displacement(host, t):
    """Return the displacement of the enclosure now [m]; t [s] is the time of this step."""
    total = registry.displacement(host.base, t)
    for r in range(len(host.shape)):
        own = ringing(host.alone, r, t) + host.answer[r, 0]
        total += host.shape[r] * own
    return total


@uncounted
def velocity(host, t):
    """Return its velocity now [m/s], extrapolated by half of the last kick."""
    total = registry.velocity(host.base, t)
    for r in range(len(host.shape)):
        total += host.shape[r] * mode_rate(host, r, t, host.pushed[r])
    return total


@inner
def mode_rate(host, r, t, pushed):
    """Return q' of mode r in the middle of a kick by the modal force pushed [N kg^-0.5]."""
    half = 0.5 * host.time_step * (pushed + drive_push(host, r, t))
    return ringing_rate(host.alone, r, t) + host.answer[r, 1] + half


@uncounted
def drive_push(host, r, t):
    """Return the modal force of mode r by a force and base that kick it; else 0."""
    if not host.kicked:
        return 0.0
    half = 0.5 * host.time_step
    ahead = registry.velocity(host.base, t + half)
    behind = registry.velocity(host.base, max(t - half, 0.0))
    gained = (ahead - behind) / (half + min(t, half))
    push = registry.displacement(host.force, t) * host.force_shape[r]
    return push - host.participation[r] * gained


@inner
def kick(host, t, force):
    """Take the bed's force [N] of the step at t [s] to the modes, and go on by a step.

    Of several dampers on the host the last one's call goes on. The powers of this moment are added
    to the books: of the force, of the base, which moves what the modes hold and, where they are
    not all modes, a part of the bed by itself, and of the host's dampers.
    """
    pushed, direct = force - host.weight, 1.0
    for r in range(len(host.shape)):
        direct -= host.shape[r] * host.participation[r]
        host.gathered[r] += host.shape[r] * pushed
    host.books[WORK] -= host.time_step * direct * pushed * registry.velocity(host.base, t)
    if host.closes:
        go_on(host, t)


@uncounted
def go_on(host, t):
    """Kick the modes by what was gathered in the step at t [s], and let them move to the next."""
    power, own, rate_of_base = 0.0, 0.0, registry.velocity(host.base, t)
    drive = registry.displacement(host.force, t)
    for r in range(len(host.shape)):
        pushed, host.gathered[r] = host.gathered[r], 0.0
        q = ringing(host.alone, r, t) + host.answer[r, 0]
        rate = mode_rate(host, r, t, pushed)
        own += host.damping[r] * rate * rate
        held = host.damping[r] * rate + host.omega[r] ** 2 * q
        power += drive * host.force_shape[r] * rate - rate_of_base * host.participation[r] * held
        y = host.answer[r, 0]
        v = host.answer[r, 1] + host.time_step * (pushed + drive_push(host, r, t))
        host.answer[r, 0] = host.step[r, 0, 0] * y + host.step[r, 0, 1] * v
        host.answer[r, 1] = host.step[r, 1, 0] * y + host.step[r, 1, 1] * v
        host.pushed[r] = pushed
    host.books[WORK] += host.time_step * power
    host.books[OWN_DAMPING] += host.time_step * own


@uncounted
def energy(host, t):
    """Return the energy of the modes [J]: from static equilibrium, in the laboratory's frame."""
    total, rate_of_base = 0.0, registry.velocity(host.base, t)
    for r in range(len(host.shape)):
        q = ringing(host.alone, r, t) + host.answer[r, 0]
        rate = mode_rate(host, r, t, host.pushed[r]) + host.participation[r] * rate_of_base
        total += 0.5 * (rate * rate + (host.omega[r] * q) ** 2)
    return total


@njit
def without_bed(host, n, every):
    """Return displacement [m] and velocity [m/s] (n + 1,) of an empty host, every so many steps.

    It moves the host.
    """
    place, rate = np.zeros(n + 1), np.zeros(n + 1)
    for k in range(n + 1):
        for m in range(every if k else 0):
            kick(host, ((k - 1) * every + m) * host.time_step, host.weight)
        now = k * every * host.time_step
        place[k], rate[k] = displacement(host, now), velocity(host, now)
    return place, rate


def rides(world):
    """Return whether the enclosure of a type of world, as numba has it, rides on a host."""
    shaker = world[world.fields.index("shaker")]
    return getattr(shaker, "instance_class", None) is Host


def mobility(shaker):
    """Return the inverse of the mass that stands behind the walls [1/kg]: 0 without a host."""
    return _of_modes.py_func(shaker.shape) if isinstance(shaker, Host) else 0.0


@specialised(mobility)
def _mobility(shaker):
    if getattr(shaker, "instance_class", None) is Host:
        return lambda shaker: _of_modes(shaker.shape)
    if getattr(shaker, "instance_class", None) is Behind:
        return lambda shaker: shaker.mobility
    return lambda shaker: 0.0


@inlined_inner
def _of_modes(shape):
    total = 0.0
    for r in range(len(shape)):
        total += shape[r] * shape[r]
    return total
