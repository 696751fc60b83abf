"""Motions whose phase is known by construction: a bed that sticks, bounces, floats, rolls, ...

Beds of touching spheres on a square lattice in a void 8 diameters wide and as long as requested,
shaken by one sine along z. Nothing is simulated: positions and velocities are written down.
"""

import numpy as np

from damper3d.measures.phases.motion import Motion

DIAMETER, GRAVITY = 5e-3, 9.81
SAMPLES, FRAMES = 100, 20
MASS = 1190.0 * np.pi / 6.0 * DIAMETER**3


class Shaken:
    """Cycles of a sine of 40 Hz and Gamma, their sample and frame times, and what moves with it."""

    def __init__(self, gamma: float, cycles: int = 6, frequency: float = 40.0) -> None:
        self.period, self.cycles = 1.0 / frequency, cycles
        self.omega = 2.0 * np.pi * frequency
        self.amplitude = gamma * GRAVITY / self.omega**2
        self.peak_speed = gamma * GRAVITY / self.omega
        self.time = np.arange(cycles * FRAMES + 1) / FRAMES * self.period
        self.sampled = np.arange(1, cycles * SAMPLES + 1) / SAMPLES * self.period

    def u(self, time: np.ndarray) -> np.ndarray:
        """Displacement of the enclosure."""
        return self.amplitude * np.sin(self.omega * time)

    def motion(
        self,
        x: np.ndarray,
        push: np.ndarray | None = None,
        *,
        together: float = 0.0,
        horizontal: bool = False,
        length: float = 8 * DIAMETER,
        clearance: float = 2 * DIAMETER,
    ) -> Motion:
        """A motion from positions (F, N, 3) relative to the enclosure; velocities by difference.

        `push` (C, S, 2); None: nothing touches the ends. `together` of the particles are in contact
        where a cycle begins, a tenth of that in the other frames.
        """
        n = x.shape[1]
        laboratory = x.copy()
        laboratory[:, :, 2] += self.u(self.time)[:, None]
        v = np.gradient(laboratory, self.period / FRAMES, axis=0, edge_order=2)
        cut = (self.cycles, SAMPLES)
        speed = self.peak_speed * np.cos(self.omega * self.sampled)
        height = np.interp(self.sampled, self.time, x[:, :, 2].mean(axis=1))
        return Motion(
            period=self.period,
            gravity=np.array([-GRAVITY, 0.0, 0.0] if horizontal else [0.0, 0.0, -GRAVITY]),
            length=length,
            clearance=clearance,
            radius=np.full(n, 0.5 * DIAMETER),
            mass=np.full(n, MASS),
            push=np.zeros((*cut, 2)) if push is None else push,
            speed=speed.reshape(cut),
            bed_height=height.reshape(cut),
            n=FRAMES,
            x=x,
            v=v,
            touching=together * np.where(np.arange(len(x)) % FRAMES, 0.1, 1.0),
            displacement=self.u(self.time),
            frame_speed=self.peak_speed * np.cos(self.omega * self.time),
        )

    def struck(self, n: int, end: int, phase: float, strength: np.ndarray | float) -> np.ndarray:
        """Collisions of n particles with an end, strength x 2 M V each, of 3 samples (C, S, 2)."""
        push = np.zeros((self.cycles, SAMPLES, 2))
        first, force = round(phase * SAMPLES), 2.0 * n * MASS * self.peak_speed
        push[:, first : first + 3, end] = (
            np.broadcast_to(strength, self.cycles)[:, None] * force / (3 * self.period / SAMPLES)
        )
        return push


def lattice(side: int = 6, layers: int = 6, gap: float = 0.0) -> np.ndarray:
    """Positions of a bed on the floor (N, 3), `gap` diameters between neighbours."""
    pitch = (1.0 + gap) * DIAMETER
    across = (np.arange(side) - 0.5 * (side - 1)) * pitch
    up = 0.5 * DIAMETER + np.arange(layers) * pitch
    return np.stack(np.meshgrid(across, across, up, indexing="ij"), axis=-1).reshape(-1, 3)


def at_rest(shaken: Shaken, bed: np.ndarray) -> np.ndarray:
    """The bed fixed in the enclosure, in every frame (F, N, 3)."""
    return np.repeat(bed[None], len(shaken.time), axis=0)


def sticking() -> Motion:
    """A rigid bed that moves with the enclosure; the floor carries and shakes it."""
    shaken, bed = Shaken(gamma=0.8), lattice()
    force = len(bed) * MASS * (GRAVITY - shaken.omega**2 * shaken.u(shaken.sampled))
    push = np.zeros((shaken.cycles, SAMPLES, 2))
    push[:, :, 0] = force.reshape(shaken.cycles, SAMPLES)
    return shaken.motion(at_rest(shaken, bed), push, together=1.0)


def bouncing(horizontal: bool = False) -> Motion:
    """The ideal collect-and-collide: a bed that flies at the speed V and meets both ends at V."""
    clearance = 2 * DIAMETER
    # Onset (eq. 6.11): A = h / pi, and the bed moves between the ends at V.
    gamma = clearance / np.pi * (2 * np.pi * 40.0) ** 2 / GRAVITY
    shaken, bed = Shaken(gamma), lattice()
    cycle = shaken.time / shaken.period
    # The bed meets the floor at u = 0 on the way up (phase 0) and the lid at phase 1/2. Between
    # them it goes 2 A pi/2 = h relative to the laboratory.
    zigzag = shaken.peak_speed * shaken.period * (0.25 - np.abs((cycle % 1.0) - 0.5))
    height = zigzag - shaken.u(shaken.time)
    x = at_rest(shaken, bed)
    x[:, :, 2] += (height - height.min())[:, None]
    push = shaken.struck(len(bed), 0, 0.0, 1.0) + shaken.struck(len(bed), 1, 0.5, 1.0)
    return shaken.motion(x, push, together=1.0, horizontal=horizontal)


def fluidised(
    reach: float = 1.0, part: float = 1.0, strength: np.ndarray | float = 1.0, **how: bool
) -> Motion:
    """Particles of the upper `part` of a lifted bed swing out of step by `reach` A, and return."""
    shaken, bed = Shaken(gamma=3.0), lattice(gap=0.1)
    x, rng = at_rest(shaken, bed), np.random.default_rng(1)
    angle = shaken.omega * shaken.time[:, None]
    # The body leaves the floor and comes back once a cycle (thesis, sec. 6.4.3.3).
    x[:, :, 2] += 0.3 * shaken.amplitude * (1.0 - np.cos(angle))
    swings = bed[:, 2] > np.quantile(bed[:, 2], 1.0 - part)
    for axis in range(3):
        out_of_step = rng.uniform(0.0, 2.0 * np.pi, len(bed))
        x[:, swings, axis] += (reach * shaken.amplitude * np.sin(angle + out_of_step))[:, swings]
    return shaken.motion(x, shaken.struck(len(bed), 0, 0.0, strength), together=0.8, **how)


def period_two() -> Motion:
    """A bed that flies over every other floor: collisions alternate strong and weak.

    It goes up at V/2 for a cycle and back for the next, so that nobody returns within one.
    """
    shaken, bed = Shaken(gamma=4.0), lattice(gap=0.1)
    x = at_rest(shaken, bed)
    cycle = shaken.time / shaken.period
    up = 0.5 * shaken.peak_speed * shaken.period * (1.0 - np.abs(cycle % 2.0 - 1.0))
    x[:, :, 2] += up[:, None] - shaken.u(shaken.time)[:, None] + shaken.amplitude
    strength = np.where(np.arange(shaken.cycles) % 2, 0.1, 1.0)
    return shaken.motion(x, shaken.struck(len(bed), 0, 0.1, strength), together=0.8)


def drifting(shaken: Shaken, bed: np.ndarray, speed: np.ndarray) -> np.ndarray:
    """Particles that go on straight in the laboratory at `speed` (N, 3), meeting nothing."""
    x = bed + speed * shaken.time[:, None, None]
    x[:, :, 2] -= (shaken.u(shaken.time) - shaken.amplitude)[:, None]
    return x


def floating_cloud() -> Motion:
    """A slow cloud over a floor layer three times as fast: each goes on, none in a common sense."""
    shaken, bed = Shaken(gamma=30.0, frequency=125.0), lattice(gap=0.1)
    rng = np.random.default_rng(2)
    speed = 0.02 * shaken.peak_speed * rng.standard_normal((len(bed), 3))
    speed[bed[:, 2] < DIAMETER] *= 3.0
    push = shaken.struck(len(bed), 0, 0.0, np.pi / 30.0)
    return shaken.motion(drifting(shaken, bed, speed), push, together=0.2)


def rolling(kind: str, noise: float = 0.5) -> Motion:
    """A cloud that turns as one cell ("roll") or as a ring ("ring"), with noise on top."""
    shaken, bed = Shaken(gamma=60.0, frequency=125.0), lattice(gap=0.1)
    about = bed - bed.mean(axis=0)
    if kind == "roll":
        flow = np.cross([0.0, 1.0, 0.0], about)
    else:
        r = np.hypot(about[:, 0], about[:, 1])
        flow = np.column_stack([-about[:, 2:3] * about[:, :2] / r[:, None], r - r.mean()])
    flow *= 0.02 * shaken.peak_speed / np.sqrt((flow**2).sum(axis=1).mean() / 3.0)
    rng = np.random.default_rng(3)
    speed = flow + noise * 0.02 * shaken.peak_speed * rng.standard_normal(bed.shape)
    return shaken.motion(drifting(shaken, bed, speed), together=0.2)


def gas() -> Motion:
    """Independent particles in free fall that touch nothing all the time, far from each other."""
    shaken = Shaken(gamma=60.0, frequency=20.0)
    rng = np.random.default_rng(4)
    bed = lattice(side=4, layers=4, gap=9.0)
    speed = 0.3 * shaken.peak_speed * rng.standard_normal(bed.shape)
    x = drifting(shaken, bed, speed)
    x[:, :, 2] -= 0.5 * GRAVITY * (shaken.time**2)[:, None]
    return shaken.motion(x)
