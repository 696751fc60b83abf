"""A step of a bed of spheres in plain numpy, all pairs and all walls, from the equations alone.

Granular-damper thesis, eqs 5.6, 5.7, 5.15, 5.16, 5.22, 5.24, 5.32, 5.33, with errata. Shares the
engine's conventions (arms that add up to the distance, displacement by the mean of the velocities
at both ends of a step, the spring's energy by contact/hertz.py) and none of its code:
no lists, no blocks, no lanes.
"""

from dataclasses import dataclass

import numpy as np


def plane_of(vectors, normal):
    """Vectors (k, 3) without what they have along the normals."""
    return vectors - (vectors * normal).sum(axis=1)[:, None] * normal


@dataclass
class Springs:
    """The histories of k possible contacts."""

    held: np.ndarray  # displacement (k, 3) [m], or force [N]
    moved: np.ndarray  # half of the displacement in the last step (k, 3) [m]
    stiffness: np.ndarray  # (k,) [N/m]

    @classmethod
    def none(cls, k):
        return cls(np.zeros((k, 3)), np.zeros((k, 3)), np.zeros(k))

    def forces(self, law, K, mass, overlap, normal, velocity, dt):
        """Force (k, 3) on the second of each pair, and the five sums of energy [J] of the step.

        K (k,) = (4/3) E sqrt(R); velocity (k, 3) of the second's surface against the first's.
        """
        touches = overlap > 0.0
        kn = K * np.sqrt(overlap)
        dashpot = law.damping * np.sqrt(kn * mass)
        rate = -(velocity * normal).sum(axis=1)
        slip = plane_of(velocity, normal)
        f_n = kn * overlap + np.sqrt(5.0) * dashpot * rate
        if not law.pulls:
            f_n = np.maximum(f_n, 0.0)
        kt, kt_before = law.tangential * kn, self.stiffness
        held, ahead = plane_of(self.held, normal), plane_of(self.moved, normal)
        half = 0.5 * dt * slip
        if law.stored_force:
            trial = held + kt_before[:, None] * ahead + kt[:, None] * half
            spring = trial
        else:
            trial = held + ahead + half
            spring = kt[:, None] * trial
        c_t = law.tangential_damping * dashpot
        wanted = spring + c_t[:, None] * slip
        size, limit = np.linalg.norm(wanted, axis=1), law.mu * np.maximum(f_n, 0.0)
        slides = size > limit
        capped = wanted * (limit / np.where(slides, size, 1.0))[:, None]
        f_t = -np.where(slides[:, None], capped, wanted)
        unit = np.ones_like(kt) if law.stored_force else np.where(touches, kt, 1.0)
        now = np.where(slides[:, None], capped / unit[:, None], trial)
        books = [
            ((f_n - kn * overlap) * rate)[touches].sum() * dt,
            (c_t * (slip**2).sum(axis=1))[~slides].sum() * dt,
            *self._spring_work(law, kt, held, trial, now, touches),
            -(f_t * slip).sum(axis=1)[slides].sum() * dt,
        ]
        self.held = np.where(touches[:, None], now, 0.0)
        self.moved = np.where(touches[:, None], half, 0.0)
        self.stiffness = np.where(touches, kt, 0.0)
        return f_t + f_n[:, None] * normal, np.array(books)

    def _spring_work(self, law, kt, before, trial, now, touches):
        """Lost to friction, and gained by the spring as its stiffness changes [J]."""
        b, n, slip = before[touches], now[touches], (trial - now)[touches]
        k_b, k_n = self.stiffness[touches], kt[touches]
        if not law.stored_force:
            friction = 0.5 * ((k_b[:, None] * b + k_n[:, None] * n) * slip).sum()
            return friction, 0.5 * ((k_n - k_b) * (b * n).sum(axis=1)).sum()
        k = 0.5 * (k_b + k_n)
        friction = (0.5 * ((b + n) * slip).sum(axis=1) / k).sum()
        old = np.where(k_b > 0.0, 1.0 / np.where(k_b > 0.0, k_b, 1.0) - 1.0 / k, 0.0)
        gained = 0.5 * (n**2).sum(axis=1) * (1 / k_n - 1 / k) - 0.5 * (b**2).sum(axis=1) * old
        return friction, gained.sum()


class PlainBed:
    """The bed of a simulation that has not begun; its laws, motion and step are the same."""

    def __init__(self, sim):
        world = self.world = sim.world
        n = sim.n_particles
        self.x, self.radius = world.spheres.position[:n, :3].copy(), world.spheres.position[:n, 3]
        self.u = world.spheres.velocity[:n, :3].copy()
        self.w_now = world.spheres.angular_velocity[:n, :3].copy()
        self.v = world.particles.velocity[:, :3].copy()
        self.w = world.particles.angular_velocity[:, :3].copy()
        self.mass = 1.0 / world.particles.inverse_mass
        self.i, self.j = np.triu_indices(n, 1)
        n_walls = len(world.walls.force)
        self.pair_springs = Springs.none(len(self.i))
        self.wall_springs = [Springs.none(n) for _ in range(n_walls)]
        self.books, self.wall_force, self.steps = np.zeros(11), np.zeros((n_walls, 3)), 0

    def step(self):
        shaker, d, dt = self.world.shaker, self.world.direction[:3], self.world.time_step
        angle = shaker.omega * self.steps * dt + shaker.phase
        shift = (shaker.amplitude * np.sin(angle)).sum() * d
        speed = (shaker.amplitude * shaker.omega * np.cos(angle)).sum() * d
        force, torque = np.zeros_like(self.x), np.zeros_like(self.x)
        self._pairs(force, torque, dt)
        for w in range(len(self.wall_springs)):
            self._wall(w, shift, speed, force, torque, dt)
        dv = dt * (force / self.mass[:, None] + self.world.gravity[:3])
        dw = dt * torque / (0.4 * self.mass * self.radius**2)[:, None]
        self.v, self.w = self.v + dv, self.w + dw
        self.u, self.w_now = self.v + 0.5 * dv, self.w + 0.5 * dw
        self.x = self.x + dt * self.v
        self.steps += 1

    def _pairs(self, force, torque, dt):
        i, j, r, law = self.i, self.j, self.radius, self.world.pair_law
        apart = self.x[j] - self.x[i]
        distance = np.linalg.norm(apart, axis=1)
        normal = apart / distance[:, None]
        overlap = np.maximum(r[i] + r[j] - distance, 0.0)
        arm_i, arm_j = (r[i] - overlap / 2)[:, None], (r[j] - overlap / 2)[:, None]
        turning = np.cross(arm_i * self.w_now[i] + arm_j * self.w_now[j], normal)
        mass = 1.0 / (1.0 / self.mass[i] + 1.0 / self.mass[j])
        push, books = self.pair_springs.forces(
            law, law.hertz * np.sqrt(r[i] * r[j] / (r[i] + r[j])), mass, overlap, normal,
            self.u[j] - self.u[i] - turning, dt,
        )  # fmt: skip
        np.add.at(force, j, push)
        np.add.at(force, i, -push)
        couple = np.cross(normal, push)
        np.add.at(torque, i, -arm_i * couple)
        np.add.at(torque, j, -arm_j * couple)
        self.books[:5] += books

    def _wall(self, w, shift, speed, force, torque, dt):
        planes, law, inside = self.world.walls.planes, self.world.wall_law, self.x - shift
        if w < len(planes):
            normal = np.tile(-planes[w, :3], (len(inside), 1))
            distance = inside @ planes[w, :3] - planes[w, 3]
        else:
            off_axis = np.hypot(inside[:, 0], inside[:, 1])
            normal = inside * [1.0, 1.0, 0.0] / off_axis[:, None]
            distance = self.world.walls.surface.radius - off_axis
        overlap = np.maximum(self.radius - distance, 0.0)
        arm = distance[:, None]
        passing = speed - self.u - np.cross(self.w_now, arm * normal)
        push, books = self.wall_springs[w].forces(
            law, law.hertz * np.sqrt(self.radius), self.mass, overlap, normal, passing, dt
        )
        force -= push
        torque -= arm * np.cross(normal, push)
        self.wall_force[w] += push.sum(axis=0)
        self.books[5:10] += books
        self.books[10] -= dt * push.sum(axis=0) @ speed
