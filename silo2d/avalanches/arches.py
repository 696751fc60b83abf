"""The arch of a clog in a silo that goes on, and the rules by which it is broken."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from granulab.campaign.runs.trajectory import Trajectory
from granulab.errors import FolderError
from silo2d.avalanches.case import AvalancheCase
from silo2d.case.case import GRAVITY, SiloCase
from silo2d.engine import state
from silo2d.engine.simulation import Simulation
from silo2d.measures.arch import Arch, find_arch
from silo2d.measures.basics.contacts import Moment
from silo2d.run.discharge import frame_of
from silo2d.run.packing import Packing
from silo2d.run.refill import Surface, put_on
from silo2d.run.summary import describe
from silo2d.view.scene import Scene

_REFILLING, _SHAKING = 1, 2  # tell the random numbers of one purpose from those of another


@dataclass(frozen=True, eq=False)
class Bed:
    """A bed that is kept at its level, and its arches."""

    case: AvalancheCase
    silo: SiloCase  # with raised walls
    packing: Packing
    surface: Surface
    radii: np.ndarray  # bounding ones of the particles (n,) [m]
    areas: np.ndarray  # of the particles (n,) [m2]
    above: float  # space above the outlet, up to the level of the filling [m2]
    static: tuple[dict[str, np.ndarray], dict[str, Any]]
    wall_names: list[str]

    @classmethod
    def of(cls, case: AvalancheCase, packing: Packing) -> "Bed":
        """Bed of a packing."""
        silo, shapes = case.raised, case.silo.shapes
        return cls(
            case=case,
            silo=silo,
            packing=packing,
            surface=Surface(silo.outline, shapes.bounding_radius, case.protocol.drop),
            radii=np.array([shape.bounding_radius for shape in shapes.shapes])[packing.kinds],
            areas=np.array([shape.area for shape in shapes.shapes])[packing.kinds],
            above=silo.outline.area_above_outlet(silo.settings.fill.level),
            static=describe(silo, packing),
            wall_names=silo.outline.walls().names,
        )

    def put_on_top(self, sim: Simulation, which: np.ndarray, before: int) -> int:
        """Put particles (k,) on the bed, rotated at random; the number put.

        before: particles that were put on before, of which the random numbers follow.
        """
        if not len(which):
            return 0
        rng = np.random.default_rng([self.case.settings.run.seed, _REFILLING, before])
        angles = rng.uniform(0, 2 * np.pi, len(which))
        return put_on(self.surface, sim, which, self.radii, angles)

    def find_arch(self, sim: Simulation) -> Arch | None:
        """The arch that the bed stands on now; None where no chain of contacts is found."""
        frame = frame_of(sim, np.zeros((len(self.wall_names), 2)))
        frames = {name: np.asarray(value)[None] for name, value in frame.items()}
        scene = Scene(Trajectory(frames, *self.static, [1]), {}, self.wall_names)
        contacts = sim.contacts()
        contacts["bodies"] = contacts["bodies"].astype(np.int64)
        try:
            return find_arch(Moment(scene=scene, frame=0, **contacts))
        except FolderError:
            return None

    def near_outlet(self, sim: Simulation) -> np.ndarray:
        """Particles with centroids within an outlet's width of its middle, at least the nearest."""
        outline, rows = self.silo.outline, sim.rows[sim.live]
        far = np.hypot(rows[:, state.X] - outline.outlet_centre, rows[:, state.Y])
        return sim.live[far <= max(outline.outlet, far.min())]

    def above_outlet(self, sim: Simulation) -> float:
        """Share of the space above the outlet, up to the level of the filling, that particles take.

        By their centroids: right to a particle.
        """
        outline, level, rows = self.silo.outline, self.silo.settings.fill.level, sim.rows[sim.live]
        across = np.abs(rows[:, state.X] - outline.outlet_centre) < 0.5 * outline.outlet
        there = across & (rows[:, state.Y] > 0) & (rows[:, state.Y] < level)
        return float(self.areas[sim.live[there]].sum() / self.above)

    def shake(self, sim: Simulation, which: np.ndarray, breaks: int) -> None:
        """Throw particles (k,) in random directions at sqrt(2 g d), d their mean diameter."""
        seed = [self.case.settings.run.seed, _SHAKING, breaks]
        angle = np.random.default_rng(seed).uniform(0, 2 * np.pi, len(which))
        speed = np.sqrt(2 * GRAVITY * self.case.diameter)
        sim.push(which, speed * np.column_stack([np.cos(angle), np.sin(angle)]))
