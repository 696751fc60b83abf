"""The contacts that a run folder keeps, moment by moment, as the measures need them."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from granulab.campaign.runs.trajectory import Tables, read_tables
from granulab.errors import FolderError, InputError
from silo2d.measures.basics.particles import FEWEST_OUT, leavers
from silo2d.view.scene import Scene, read_scene

Floats = NDArray[np.float64]
GRAVITY = 9.81  # [m/s2]
STATES = "before_opening", "flow", "end"


@dataclass(frozen=True, eq=False)
class Moment:
    """The c vertex-edge contacts at one frame of a run; SI.

    bodies     (c, 2) particles, then walls; ascending in each contact, so that a wall is second
    point      (c, 2) where the force acts
    force      (c, 2) on the second body, damping included; the first takes its opposite
    normal     (c, 2) unit vector towards the second body
    overlap    (c,)
    slides     (c,) whether the tangential spring is at its Coulomb limit
    """

    scene: Scene
    frame: int
    bodies: NDArray[np.int64]
    point: Floats
    force: Floats
    normal: Floats
    overlap: Floats
    slides: NDArray[np.bool_]

    @property
    def time(self) -> float:
        """Since the opening [s]."""
        return float(self.scene.time[self.frame])

    @cached_property
    def centres(self) -> Floats:
        """Centroids of all particles (n, 2) [m]."""
        return self._particles("x", "y")

    @cached_property
    def velocities(self) -> Floats:
        """Velocities of all particles (n, 2) [m/s]."""
        return self._particles("vx", "vy")

    def _particles(self, *keys: str) -> Floats:
        trajectory = self.scene.trajectory
        return np.column_stack([trajectory[key][self.frame] for key in keys]).astype(np.float64)

    @property
    def inside(self) -> NDArray[np.bool_]:
        """Particles that are simulated at this moment (n,)."""
        return self.scene.trajectory["inside"][self.frame]

    @cached_property
    def at_wall(self) -> NDArray[np.bool_]:
        """Contacts of a particle with a wall (c,)."""
        return self.bodies[:, 1] >= self.scene.n_particles

    @cached_property
    def pairs(self) -> tuple[NDArray[np.int64], Floats]:
        """Pairs of bodies that touch (p, 2), and the normal force between them (p,) [N].

        The normal force of a pair is the sum over its contacts, negative where it pulls.
        """
        if not len(self.bodies):
            return np.zeros((0, 2), np.int64), np.zeros(0)
        pairs, which = np.unique(self.bodies, axis=0, return_inverse=True)
        pressing = (self.force * self.normal).sum(axis=1)
        force = np.zeros(len(pairs))
        np.add.at(force, which.ravel(), pressing)
        return pairs, force


class Branches(NamedTuple):
    """Branches from the centroid of a particle to each of its contacts, of all particles (k); SI.

    particle         (k,)
    start, end    (k, 2) centroid and contact point
    force         (k, 2) on the particle
    """

    particle: NDArray[np.int64]
    start: Floats
    end: Floats
    force: Floats


def branches(moment: Moment) -> Branches:
    """Branches of a moment: two for a contact of two particles, one for a contact with a wall."""
    of_two = ~moment.at_wall
    particle = np.concatenate([moment.bodies[:, 0], moment.bodies[of_two, 1]])
    point = np.concatenate([moment.point, moment.point[of_two]])
    force = np.concatenate([-moment.force, moment.force[of_two]])
    return Branches(particle, moment.centres[particle], point, force)


def read_moments(folder: str | Path) -> list[Moment]:
    """All moments of a run that have contacts, the first just before the opening.

    Raises FolderError where the folder holds none.
    """
    scene = read_scene(folder)
    tables = read_tables(folder, "contacts")
    if not len(tables):
        raise FolderError(f"{folder}: no contacts yet; wait until the silo has opened")
    return [moment_at(scene, tables, k) for k in range(len(tables)) if _is_read(scene, tables, k)]


def _is_read(scene: Scene, tables: Tables, k: int) -> bool:
    """True where the frame is there too: a run that goes on may have written more meanwhile."""
    return bool(tables.frame[k] < len(scene.time))


def moment_at(scene: Scene, tables: Tables, k: int) -> Moment:
    """The k-th moment that the contacts of a run hold."""
    kept = tables.at(k)
    numbers = {key: kept[key].astype(np.float64) for key in ("point", "force", "normal", "overlap")}
    return Moment(
        scene=scene,
        frame=int(tables.frame[k]),
        bodies=kept["bodies"].astype(np.int64),
        slides=kept["slides"],
        **numbers,
    )


def flowing(scene: Scene, share: tuple[float, float] = (0.1, 0.5)) -> tuple[float, float]:
    """Times [s] between which these parts of the particles that leave had left.

    The first tenth starts the flow; after the half the silo is rather empty. Raises InputError
    where fewer than FEWEST_OUT particles left.
    """
    times, _ = leavers(scene, FEWEST_OUT, "a mean over the flow")
    first, last = (times[int(part * len(times))] for part in share)
    return float(first), float(last)


def states(
    moments: list[Moment], window: tuple[float, float] | None = None
) -> dict[str, list[Moment]]:
    """The moments of each state that a run has: "before_opening", "flow" and "end".

    There is a flow where twenty particles left, and an end worth a look where the run clogged.
    window: from and until [s], what the flow is taken from instead; InputError where it holds no
    moment.
    """
    scene = moments[0].scene
    found = {"before_opening": moments[:1]}
    if window:
        found["flow"] = within(moments, window)
    elif scene.trajectory["n_out"][-1] >= FEWEST_OUT:
        first, last = flowing(scene)
        during = [m for m in moments if first <= m.time <= last]
        flow = during or _nearest(moments[1:], (first + last) / 2)
        found |= {"flow": flow} if flow else {}
    if scene.summary.get("outcome") in ("clogged", "clogged_at_opening"):
        found["end"] = moments[-1:]
    return found


def within(moments: list[Moment], window: tuple[float, float]) -> list[Moment]:
    """The moments of a window of time [s], at least one."""
    found = [m for m in moments if window[0] <= m.time <= window[1]]
    if not found:
        times = [m.time for m in moments]
        every = f", every {np.median(np.diff(times)):.3g} s" if len(times) > 1 else ""
        raise InputError(
            f"between {window[0]:g} s and {window[1]:g} s: no contacts are kept; the run has them "
            f"from 0 to {times[-1]:.3g} s{every}"
        )
    return found


def _nearest(moments: list[Moment], time: float) -> list[Moment]:
    """The moment nearest to a time [s]; none of none."""
    return [min(moments, key=lambda m: abs(m.time - time))] if moments else []


def in_words(name: str, moments: list[Moment]) -> str:
    """A title for the moments of a state."""
    if name == "before_opening":
        return "just before the opening"
    if name == "end":
        return f"clogged, {moments[0].time:.2f} s"
    if len(moments) == 1:
        return f"flow, one moment, {moments[0].time:.2f} s"
    span = f"{moments[0].time:.2f} to {moments[-1].time:.2f} s"
    return f"flow, mean of {len(moments)} moments, {span}"


def particle_stress(scene: Scene, contacts: Tables, frame: int) -> Floats | None:
    """Mean stress in all particles (n, 2, 2), its symmetric part [N/m]; None without contacts then.

    sigma = - (1/A) sum_c f_c (x) b_c

    over the contacts of a particle of area A: f the force on it, b the branch from its centroid to
    the contact point (Christoffersen, Mehrabadi, Nemat-Nasser 1981, J. Appl. Mech. 48, 339);
    pressure is positive. Weight and acceleration act at the centroid and add nothing; what
    rotation adds is left out. Of the plane [N/m]: divide by the prisms' length for pascals.

    It is not symmetric by itself while a torque acts on the particle. The area is that of the
    outline in the run folder, some 0.04 % small.
    """
    found = np.flatnonzero(contacts.frame == frame)
    if not len(found):
        return None
    moment = moment_at(scene, contacts, int(found[0]))
    particle, start, end, force = branches(moment)
    total = np.zeros((scene.n_particles, 2, 2))
    np.add.at(total, particle, force[:, :, None] * (end - start)[:, None, :])
    stress = -total / scene.areas[:, None, None]
    return 0.5 * (stress + stress.transpose(0, 2, 1))
