"""The arch that a clogged run stands on, found in the contacts of its last frame.

A chain is a row of particles, each in load-bearing contact with the next, from a wall left of the
outlet's middle to a wall right of it. A contact bears load where the normal force between the
two bodies, all their vertex-edge contacts together, is at least LEAST_LOAD weights of a mean
particle. The arch is found in two steps:

1. its level: the lowest y such that the particles with centroids up to y still hold a chain. So no
   chain lies wholly below the arch, and the highest particle of every chain is at least as high;
2. its particles: of all chains of these particles, that of the least sum of 1/force over its
   contacts, walls included (the path of least resistance): it follows strong contacts, and a
   particle that only hangs on two others that press each other is left out.

Limits: the criterion is of forces, not of stability (a particle whose loss would not let the arch
fall may belong to it); of two chains at one level only the stronger is given; particles of a dead
zone count where the arch stands on them; a chain that closes high above the outlet, in a silo
that jammed as a whole, is an arch too, which its height over the outlet shows.
"""

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from granulab.campaign.output.figure import GREY, INK, ORANGE, PAPER, VERMILION, headline
from granulab.errors import FolderError, InputError
from silo2d.measures.basics.contacts import GRAVITY, Moment, read_moments
from silo2d.measures.basics.walls import sides
from silo2d.measures.network import draw_network, draw_particles
from silo2d.view.scene import PARTICLE_EDGE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEAST_LOAD = 0.1  # normal force of a load-bearing contact, over the weight of a mean particle


@dataclass(frozen=True, eq=False)
class Arch:
    """A chain of k particles from left to right; SI.

    particles     (k,) from left to right
    walls      wall that each end stands on, as index in the list of walls
    line       (2 k + 1, 2) from foot to foot: contact points and centroids alternate
    forces     (k + 1,) normal forces from wall to wall [N]
    load       vertical force that bodies outside of the arch and above it press down with [N]
    """

    particles: NDArray[np.int64]
    walls: tuple[int, int]
    line: NDArray[np.float64]
    forces: NDArray[np.float64]
    load: float

    @property
    def span(self) -> float:
        """Distance of the feet [m]."""
        return float(np.hypot(*(self.line[-1] - self.line[0])))

    @property
    def rise(self) -> float:
        """Largest height of the line above the straight line between the feet [m]."""
        along = (self.line[-1] - self.line[0]) / self.span
        up = np.array([-along[1], along[0]])
        return float(((self.line - self.line[0]) @ up).max())


def measure(folder: Path) -> dict[str, Any]:
    """The arch of a clogged run.

    n_grains                     particles of the arch
    span_m, rise_m, aspect       distance of the feet; height over their straight line; rise/span
    tilt_rad                     of the line from the left to the right foot
    crown_m                      the arch's highest point over the outlet
    load_n, load_share           what other bodies press it down with; over the weight inside
    weakest_force_n, mean_...    normal forces along the arch; weakest_over_weight: over the weight
                                 of a mean particle
    grains, line_m, walls        see Arch (grains: its particles)

    Raises InputError where the run did not clog, or is not over, or its silo has inserts.
    """
    moment = last_clogged_moment(folder)
    arch = find_arch(moment)
    weight = GRAVITY * moment.scene.trajectory.static["mass"]
    left, right = arch.line[0], arch.line[-1]
    names = moment.scene.wall_names
    return {
        "n_grains": len(arch.particles),
        "span_m": arch.span,
        "rise_m": arch.rise,
        "aspect": arch.rise / arch.span,
        "tilt_rad": float(np.arctan2(right[1] - left[1], right[0] - left[0])),
        "crown_m": float(arch.line[:, 1].max()),
        "load_n": arch.load,
        "load_share": float(arch.load / weight[moment.inside].sum()),
        "weakest_force_n": float(arch.forces.min()),
        "weakest_over_weight": float(arch.forces.min() / weight.mean()),
        "mean_force_n": float(arch.forces.mean()),
        "outcome": moment.scene.summary["outcome"],
        "left_foot": names[arch.walls[0]],
        "right_foot": names[arch.walls[1]],
        "grains": arch.particles.tolist(),
        "line_m": arch.line.tolist(),
    }


def last_clogged_moment(folder: Path) -> Moment:
    """The last moment of a clogged run; InputError with one line where it is none."""
    moment = read_moments(folder)[-1]
    outcome = moment.scene.summary.get("outcome")
    if outcome is None:
        raise InputError(f"{folder}: the run is not over; an arch is looked for at its end")
    if outcome not in ("clogged", "clogged_at_opening"):
        raise InputError(
            f"{folder}: the run did not clog (outcome {outcome}), so there is no arch; "
            "give a run that clogged"
        )
    if any(name.startswith("insert") for name in moment.scene.wall_names):
        raise InputError(
            f"{folder}: the silo has inserts; an arch is looked for between its walls alone"
        )
    return moment


def find_arch(moment: Moment) -> Arch:
    """The arch of a moment, see the module.

    Raises FolderError where no chain joins the two sides.
    """
    pairs, force = moment.pairs
    weight = GRAVITY * moment.scene.trajectory.static["mass"].mean()
    bears = force >= LEAST_LOAD * weight
    ends = _walls_as_sides(moment, pairs[bears])
    level = _level(moment.centres[:, 1], ends)
    kept = _reaches_up_to(moment.centres[:, 1], level)[ends].all(axis=1)
    chain = _least_resistance(ends[kept], force[bears][kept], moment.scene.n_particles)
    return _arch(moment, chain)


def _walls_as_sides(moment: Moment, pairs: NDArray[np.int64]) -> NDArray[np.int64]:
    """The pairs with all walls of a side as one body: n left, n + 1 right, n + 2 the door."""
    n = moment.scene.n_particles
    body = {-1: n, 1: n + 1, 0: n + 2}
    of_wall = np.array([body[int(side)] for side in sides(moment.scene)])
    at_wall = pairs >= n
    return np.where(at_wall, of_wall[np.where(at_wall, pairs - n, 0)], pairs)


def _reaches_up_to(y: NDArray[np.float64], level: float) -> NDArray[np.bool_]:
    """Bodies that a chain up to a level may use: low particles and both sides, not the door."""
    return np.append(y <= level, [True, True, False])


def _level(y: NDArray[np.float64], pairs: NDArray[np.int64]) -> float:
    """The lowest centroid up to which a chain joins the sides, by bisection."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    def joined(level: float) -> bool:
        kept = pairs[_reaches_up_to(y, level)[pairs].all(axis=1)]
        n = len(y)
        graph = coo_array((np.ones(len(kept)), (kept[:, 0], kept[:, 1])), shape=(n + 3, n + 3))
        label = connected_components(graph, directed=False)[1]
        return bool(label[n] == label[n + 1])

    levels = np.unique(y)
    if not len(levels) or not joined(levels[-1]):
        raise FolderError("no chain of load-bearing contacts joins the walls left and right")
    low, high = -1, len(levels) - 1  # never joined; joined
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if joined(levels[middle]) else (middle, high)
    return float(levels[high])


def _least_resistance(
    pairs: NDArray[np.int64], force: NDArray[np.float64], n: int
) -> NDArray[np.int64]:
    """Particles of the path of least sum of 1/force from the left side, n, to the right, n + 1."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    # A particle may touch several walls of a side: the strongest contact counts.
    joins, which = np.unique(pairs, axis=0, return_inverse=True)
    strongest = np.zeros(len(joins))
    np.maximum.at(strongest, which.ravel(), force)
    graph = coo_array((1 / strongest, (joins[:, 0], joins[:, 1])), shape=(n + 2, n + 2)).tocsr()
    before = dijkstra(graph, directed=False, indices=n, return_predecessors=True)[1]
    chain = [n + 1]
    while chain[-1] != n:
        chain.append(int(before[chain[-1]]))
    return np.array(chain[-2:0:-1], dtype=np.int64)


def _arch(moment: Moment, particles: NDArray[np.int64]) -> Arch:
    """The arch of a chain: its line, forces and load."""
    side = sides(moment.scene)
    left = _foot(moment, particles[0], side == -1)
    right = _foot(moment, particles[-1], side == 1)
    links = [left, *pairwise(particles), right]
    points, forces = zip(*(_between(moment, *link) for link in links), strict=True)
    line = np.empty((2 * len(particles) + 1, 2))
    line[::2], line[1::2] = points, moment.centres[particles]
    n = moment.scene.n_particles
    return Arch(
        particles, (left[1] - n, right[1] - n), line, np.array(forces), _load(moment, particles)
    )


def _foot(moment: Moment, particle: int, of_side: NDArray[np.bool_]) -> tuple[int, int]:
    """The particle and the wall of a side that presses it most."""
    n = moment.scene.n_particles
    pairs, force = moment.pairs
    here = (pairs[:, 0] == particle) & (pairs[:, 1] >= n)
    here[here] = of_side[pairs[here, 1] - n]
    strongest = np.flatnonzero(here)[force[here].argmax()]
    return int(particle), int(pairs[strongest, 1])


def _between(moment: Moment, one: int, other: int) -> tuple[NDArray[np.float64], float]:
    """Mean contact point of two bodies, weighted by the forces, and their normal force [N]."""
    here = (moment.bodies == sorted((one, other))).all(axis=1)
    force = (moment.force[here] * moment.normal[here]).sum(axis=1)
    weight = np.maximum(force, 0.0)
    return weight @ moment.point[here] / weight.sum(), float(force.sum())


def _load(moment: Moment, particles: NDArray[np.int64]) -> float:
    """Sum of the downward forces of other particles on those of an arch [N]."""
    belongs = np.zeros(moment.bodies.max() + 1, dtype=bool)
    belongs[particles] = True
    first, second = belongs[moment.bodies].T
    particle = ~moment.at_wall
    on_second = moment.force[second & ~first & particle, 1]
    on_first = -moment.force[first & ~second & particle, 1]
    return float(-np.minimum(np.concatenate([on_second, on_first]), 0.0).sum())


def draw(folder: Path) -> "Figure":
    """The arch over the particles: the whole silo, and the arch near by."""
    from matplotlib.figure import Figure

    moment = last_clogged_moment(folder)
    arch, scene = find_arch(moment), moment.scene
    figure = Figure(figsize=(10.5, 5.6), layout="constrained")
    headline(figure, scene.headline)
    whole, near = figure.subplots(1, 2, width_ratios=[1, 1.6])
    pressing = moment.pairs[1]
    unit = float(pressing[pressing > 0].mean())
    for panel in (whole, near):
        draw_particles(panel, scene, moment.frame)
        _paint(panel, moment, arch)
    draw_network(near, moment, unit)
    near.plot(*arch.line.T, color=INK, lw=1.6)
    near.plot(*arch.line[[0, -1]].T, color=GREY, lw=0.9, ls=(0, (4, 3)))
    for number, particle in enumerate(arch.particles, start=1):
        near.annotate(f"{number}", moment.centres[particle], ha="center", va="center",
                      fontsize=8, fontweight="bold", color=VERMILION,
                      bbox={"boxstyle": "circle,pad=0.2", "fc": PAPER, "ec": "none"})  # fmt: skip
    _zoom(near, arch)
    near.set_title(
        f"{len(arch.particles)} particles, span {1e3 * arch.span:.0f} mm, "
        f"rise {1e3 * arch.rise:.0f} mm, others press with {arch.load:.1f} N", fontsize=10,
    )  # fmt: skip
    return figure


def _paint(axes: "Axes", moment: Moment, arch: Arch) -> None:
    """The particles of the arch in a colour of their own."""
    from matplotlib.collections import PolyCollection

    for which, outlines in moment.scene.outlines(moment.frame):
        mine = list(outlines[np.isin(which, arch.particles)])
        axes.add_collection(
            PolyCollection(mine, facecolors=ORANGE, edgecolors=PARTICLE_EDGE, linewidths=0.8)
        )


def _zoom(axes: "Axes", arch: Arch) -> None:
    low, high = arch.line.min(axis=0), arch.line.max(axis=0)
    middle, half = (low + high) / 2, 0.75 * max(high - low)
    axes.set(xlim=(middle[0] - half, middle[0] + half),
             ylim=(middle[1] - 0.8 * half, middle[1] + 0.8 * half))  # fmt: skip
