"""Acts of a discharge at given times: a gate that closes and opens, a feeder, refilling.

All follow from the number of steps since the opening and from the state: a run that goes on from a
checkpoint does the same.
"""

from dataclasses import dataclass, replace

import numpy as np

from silo2d.case.case import SiloCase
from silo2d.engine import state
from silo2d.engine.simulation import Simulation
from silo2d.run.ending import LOOK, Flow
from silo2d.run.packing import Packing
from silo2d.run.refill import Surface, put_on

_DIRECTIONS = {"vertical": (0.0, 1.0), "horizontal": (1.0, 0.0)}


def equip(sim: Simulation, case: SiloCase, packing: Packing) -> None:
    """Give a silo that opens now, or is gone on with, its plates and its vibration."""
    law, flow = case.settings.law, case.settings.flow
    if law.mu_plates is not None and law.plates_ratio is not None:
        areas = np.array([shape.area for shape in case.shapes.shapes])[packing.kinds]
        sim.set_plates(law.mu_plates, law.plates_ratio, case.length, areas)
    if flow.vibration_amplitude is not None and flow.vibration_frequency is not None:
        x, y = _DIRECTIONS[flow.vibration_direction]
        amplitude = flow.vibration_amplitude
        sim.vibrate((x * amplitude, y * amplitude), flow.vibration_frequency)


def with_store(case: SiloCase, packing: Packing) -> Packing:
    """A packing with the particles in store behind it, drawn by the seed; they wait at the top."""
    n = case.settings.flow.refill
    if not n:
        return packing
    rng = np.random.default_rng([case.settings.run.seed, 0x73746F7265])  # apart from the filling
    kinds = rng.choice(len(case.shapes.shapes), size=n, p=case.shapes.shares)
    x = case.outline.polygon[case.outline.polygon[:, 1] == case.outline.height, 0].mean()
    waiting = np.column_stack(
        [np.full((n, 2), (x, case.settings.fill.level)), rng.uniform(0, 2 * np.pi, n)]
    )
    return replace(
        packing,
        kinds=np.concatenate([packing.kinds, kinds]),
        poses=np.concatenate([packing.poses, waiting]),
    )


@dataclass
class Acts:
    """Acts of one discharge; steps are since the opening."""

    case: SiloCase
    packing: Packing
    gate: list[int]  # steps at which the gate closes, opens, closes ...
    feed: float  # steps between two particles of the feeder; 0: none
    refill: int  # steps between looks at the level; 0: nothing in store
    surface: Surface | None  # of the bed, which what is in store is put on; None: nothing is

    @classmethod
    def of(cls, case: SiloCase, packing: Packing, sim: Simulation) -> "Acts":
        """The acts of a case in the time step of its simulation."""
        flow, step = case.settings.flow, sim.time_step
        gate = [max(round(time / step), 1) for time in flow.gate]
        feed = 0.0 if flow.feed_rate is None else 1 / (flow.feed_rate * step)
        if not flow.refill:
            return cls(case, packing, gate, feed, 0, None)
        radius = case.shapes.bounding_radius
        shaken = flow.vibration_amplitude or 0.0
        surface = Surface(case.outline.raised(4 * radius), radius, shaken=shaken)
        return cls(case, packing, gate, feed, round(LOOK / step), surface)

    def next(self, now: int) -> list[int]:
        """Steps after `now` at which something is to be done."""
        due = [step for step in self.gate if step > now][:1]
        if self.feed:
            k = int(now / self.feed)
            due.append(next(d for d in (round((k + j) * self.feed) for j in range(4)) if d > now))
        if self.refill:
            due.append(now - now % self.refill + self.refill)
        return due

    def closed(self, now: int) -> bool:
        """True while the gate is closed."""
        return sum(step <= now for step in self.gate) % 2 == 1

    def act(self, sim: Simulation) -> None:
        """Do what is due now."""
        now = sim.steps
        if now in self.gate:
            self._move_gate(sim, self.closed(now))
        if self.feed and round(round(now / self.feed) * self.feed) == now:
            self._feed(sim)
        if self.surface and now % self.refill == 0:
            self._refill(sim, self.surface)

    def _move_gate(self, sim: Simulation, closes: bool) -> None:
        """Close all doors, which take the particles with them that stand in them, or open them."""
        walls = self.case.outline.walls()
        for door in walls.doors:
            if closes:
                ends = walls.segments[door]
                now = sim.world.bodies.row[sim.n_particles + door, [state.X, state.Y]]
                shaken = now - ends.mean(axis=0)  # a wall that vibrates is not where it was drawn
                sim.take_out(self._standing_in(sim, ends + shaken))
                sim.put_back_wall(door)
            else:
                sim.remove_wall(door)

    def _standing_in(self, sim: Simulation, ends: np.ndarray) -> list[int]:
        along = ends[1] - ends[0]
        length = float(np.hypot(*along))
        tangent = along / length
        normal = np.array([-tangent[1], tangent[0]])
        found, poses = [], sim.poses()
        for i in sim.live.tolist():
            shape = self.case.shapes.shapes[self.packing.kinds[i]]
            x, y, angle = poses[i]
            cos, sin = np.cos(angle), np.sin(angle)
            core = shape.core @ np.array([[cos, sin], [-sin, cos]]) + (x, y) - ends[0]
            aside, at = core @ normal, core @ tangent
            r = shape.spheroradius  # whoever touches it: an overlap would come from nothing
            if aside.min() < r and aside.max() > -r and at.min() < length and at.max() > 0.0:
                found.append(i)
        return found

    def _feed(self, sim: Simulation) -> None:
        """Take the lowest particle over the outlet, if one is as near as a particle."""
        (left, _), (right, _) = self.case.outline.lips
        poses, live = sim.poses(), sim.live
        x, y = poses[live, 0], poses[live, 1]
        over = (x > left) & (x < right) & (y < 2 * self.case.shapes.bounding_radius)
        if over.any():
            sim.take_out([int(live[over][np.argmin(y[over])])])

    def _refill(self, sim: Simulation, surface: Surface) -> None:
        """Put particles of the store on the surface, as many as have left."""
        n, store = sim.n_particles, self.case.settings.flow.refill
        first = n - store + put_of_store(sim, store)
        wanted = np.arange(first, min(first + n - store - len(sim.live), n))
        if not len(wanted):
            return
        radii = np.array([shape.bounding_radius for shape in self.case.shapes.shapes])
        put_on(surface, sim, wanted, radii[self.packing.kinds], sim.poses()[wanted, 2])


def put_of_store(sim: Flow, store: int) -> int:
    """Of so many particles in store, the last ones, how many were put on top so far."""
    first = sim.n_particles - store
    used = ~np.isnan(sim.out_time[first:])
    used[sim.live[sim.live >= first] - first] = True
    return int(used.sum())
