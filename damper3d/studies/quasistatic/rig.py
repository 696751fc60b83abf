"""The two half containers and the loading table: their walls, and the world with particles in it.

The bottom half stands fixed and open upwards, base at z = 0; the top half hangs a gap above its
rim, open downwards, and moves along x; the table is a disc in the top half that moves with it, and
vertically by itself. The top half has no lid: the table is what presses.
"""

import math
from dataclasses import dataclass

import numpy as np

from damper3d.engine import state
from damper3d.engine.enclosures import Enclosure, cylinder
from damper3d.engine.enclosures.lines import Lines
from damper3d.engine.simulation import Simulation
from damper3d.engine.walls import N_SERVO, ON, Drive

WALLS = ("base", "bottom_side", "top_side", "table")
BASE, BOTTOM_SIDE, TOP_SIDE, TABLE = range(4)
TABLE_CLEARANCE = 0.1e-3  # between table and top half: radii of 19.9 and 20 mm (errata)


@dataclass(frozen=True)
class Halves:
    """Two equal cylinders, open towards each other; inner sizes [m]."""

    diameter: float = 0.04
    height: float = 0.02  # of each
    gap: float = 0.5e-3  # between their rims

    @property
    def enclosure(self) -> Enclosure:
        """The room within both, with the table at its top."""
        return cylinder(self.diameter, 2.0 * self.height + self.gap)

    @property
    def rim(self) -> float:
        """Height of the lower edge of the top half [m]."""
        return self.height + self.gap

    @property
    def area(self) -> float:
        """Area of the cross section [m2]."""
        return 0.25 * math.pi * self.diameter**2

    @property
    def lines(self) -> np.ndarray:
        """Lines of the walls in the order of WALLS (4, 4); see enclosures.lines.Lines."""
        radius, top = 0.5 * self.diameter, 2.0 * self.height + self.gap
        return np.array([
            (0.0, radius, 0.0, 0.0),
            (radius, radius, 0.0, self.height),
            (radius, radius, self.rim, top),
            (0.0, radius - TABLE_CLEARANCE, top, top),
        ])  # fmt: skip


def walls_of(lines: np.ndarray, n_spheres: int) -> state.Walls:
    """Walls at rest, without a servo; lines (n, 4) as in enclosures.lines.Lines."""
    n = len(lines)
    drive = Drive(
        place=state.zeros(n, 4),
        speed=state.zeros(n, 4),
        listed=state.zeros(n, 4),
        servo=np.zeros(N_SERVO),
        before=np.zeros(n),
    )
    return state.Walls(
        planes=np.zeros((0, 4)),
        surface=Lines(state.zeros(n, 4) + lines),
        drive=drive,
        curved=False,
        first=np.zeros(n + 1, np.int64),
        force=np.zeros((n, 3)),
        history=state.no_history(n, n_spheres),
        rolling=None,
    )


class RigSimulation(Simulation):
    """Particles between walls that move each by itself; positions are in the laboratory."""

    _OF_WALLS = ("place", "speed", "servo")

    @classmethod
    def between(cls, lines: np.ndarray, built: state.World) -> "RigSimulation":
        """The particles of a world, in other walls; lines (n, 4) as in enclosures.lines.Lines."""
        return cls(built._replace(walls=walls_of(lines, len(built.spheres.inverse_mass))))

    @property
    def place(self) -> np.ndarray:
        """Displacements of the walls (n, 3) [m]."""
        return self.world.walls.drive.place[:, :3].copy()

    def put(self, wall: int, place: np.ndarray) -> None:
        """Displace a wall to `place` (3,) [m] at once."""
        self.world.walls.drive.place[wall, :3] = place
        self._walls_changed()

    def drive(self, velocity: dict[int, np.ndarray]) -> None:
        """Let walls move at velocities (3,) [m/s] from now on, the others rest."""
        self.world.walls.drive.speed[:] = 0.0
        for wall, along in velocity.items():
            self.world.walls.drive.speed[wall, :3] = along
        self._walls_changed()

    def hold(self, wall: int, force: float, viscosity: float, fastest: float) -> None:
        """Let the servo move a wall vertically, to a downward force [N]; see drive."""
        self.world.walls.drive.servo[:] = [wall, 1.0, force, viscosity, fastest]

    def let_go(self) -> None:
        """Switch the servo off."""
        self.world.walls.drive.servo[ON] = 0.0

    def _walls_changed(self) -> None:
        self.world.counts[[state.STALE_INNER, state.STALE_WALL]] = 1

    def _save_particles(self) -> dict[str, np.ndarray]:
        drive = self.world.walls.drive
        own = {f"wall_{name}": getattr(drive, name).copy() for name in self._OF_WALLS}
        return {**super()._save_particles(), **own}

    def _restore_particles(self, saved: dict[str, np.ndarray]) -> None:
        super()._restore_particles(saved)
        for name in self._OF_WALLS:
            getattr(self.world.walls.drive, name)[:] = saved[f"wall_{name}"]

    def _moved(self) -> list[str]:
        return [*super()._moved(), "wall_place", "wall_speed"]
