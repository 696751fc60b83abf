"""A bed of clusters in motion."""

from typing import Any

import numpy as np

from damper3d.engine import state
from damper3d.engine.multisphere import world as building
from damper3d.engine.simulation import Simulation


class ClusterSimulation(Simulation):
    """A world of clusters, and what one may ask of it; see Simulation.

    Contacts are those of spheres: two particles may have several.
    """

    _MOTION: tuple[str, ...] = ("position", "orientation", "velocity", "momentum")

    @property
    def n_spheres(self) -> int:
        """Of each particle."""
        return len(self.world.shape.offset)

    def frame(self) -> dict[str, np.ndarray]:
        """As of balls; and the orientations (n, 4), unit quaternions (w, x, y, z)."""
        bodies, n = self.world.bodies, self.n_bodies
        return {
            "x": bodies.position[:, :3] - np.array(self._shift()),
            "v": bodies.velocity_now[:, :3].copy(),
            "spin": bodies.spin_now[:, :3].copy(),
            "orientation": bodies.orientation.copy(),
            "heat": bodies.heat[:-1].reshape(n, self.n_spheres).sum(axis=1),
        }

    def contacts(self) -> dict[str, np.ndarray]:
        """As of balls; and which spheres (n, 2) of the particles touch, 0 of a wall."""
        found = super().contacts()
        spheres, m = found["bodies"].astype(np.int64), self.n_bodies * self.n_spheres
        of_wall = spheres >= m
        found["spheres"] = np.where(of_wall, 0, spheres % self.n_spheres).astype(np.uint32)
        bodies = np.where(of_wall, spheres - m + self.n_bodies, spheres // self.n_spheres)
        return {**found, "bodies": bodies.astype(np.uint32)}

    def top(self, up: np.ndarray) -> float:
        """The largest up . x of any particle's surface, in the enclosure [m]; up (3,) is a unit."""
        bodies, offset = self.world.bodies, self.world.shape.offset
        axes = bodies.axes.reshape(-1, 3, 4)[:, :, :3]
        reach = np.einsum("nkc,c,sk->ns", axes, up, offset[:, :3]) + offset[:, 3]
        return float((self.frame()["x"] @ up + reach.max(axis=1)).max())

    def set_velocity(self, velocity: np.ndarray, spin: np.ndarray | None = None) -> None:
        """Give the particles velocities (n, 3) [m/s], and spins (n, 3) [rad/s], both of now."""
        bodies = self.world.bodies
        bodies.velocity[:, :3] = bodies.velocity_now[:, :3] = velocity
        if spin is not None:
            axes = bodies.axes.reshape(-1, 3, 4)[:, :, :3]
            along = np.einsum("nkc,nc->nk", axes, spin) / self.world.shape.inverse_inertia
            bodies.momentum[:, :3] = np.einsum("nkc,nk->nc", axes, along)
            bodies.momentum_now[:] = bodies.momentum
            bodies.spin_now[:, :3] = spin
        self.world.counts[[state.STALE_CLOSE, state.STALE_WALL]] = 1  # spheres have velocities too

    def _save_bodies(self) -> dict[str, np.ndarray]:
        names = ("position", "orientation", "velocity", "momentum", "velocity_now",
                 "momentum_now")  # fmt: skip
        return {name: getattr(self.world.bodies, name).copy() for name in names}

    def _restore_bodies(self, saved: dict[str, np.ndarray]) -> None:
        for name, array in saved.items():
            if name in ("position", "orientation", *self._MOTION) or name.endswith("_now"):
                getattr(self.world.bodies, name)[:] = array
        building.note_all_axes(self.world)

    def _restore_pairs(self, pairs: np.ndarray, histories: np.ndarray) -> None:
        """Give the next list the pairs in contact (n, 2) and their histories.

        Their keys are those of pairs.key_of, which only kernels can call.
        """
        while len(self.world.kept.key) < len(pairs):
            self.world = self._roomier("close")
        kept, n, k = self.world.kept, len(pairs), self.n_spheres
        spheres = pairs.astype(np.int64)
        (i, j), (a, b) = spheres.T, (spheres // k).T
        kept.key[:n] = ((a * self.n_bodies + b) * k + (i - a * k)) * k + (j - b * k)
        kept.history[:n] = histories
        kept.number[0] = n

    def _roomier(self, lists: str) -> Any:
        return building.roomier(self.world, lists)
