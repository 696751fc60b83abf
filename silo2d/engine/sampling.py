"""State of a moment: contacts with the forces that the next step applies, energies; samples."""

from dataclasses import dataclass, field

import numpy as np

from granulab.contact.jit import inner, njit, uncounted
from granulab.contact.laws import normal_energy, slip_limit, tangential_energy
from silo2d.engine.forces import contact_forces, edge_to_vertex, overlap_now
from silo2d.engine.geometry import rotated
from silo2d.engine.integrate import kinetic_energy
from silo2d.engine.pair_law import law_of
from silo2d.engine.state import BLOCK, COS, INNER, INV_MASS, LIVE, PARTICLE_INNER, SIN, X, Y

# Columns of the numbers of list_contacts.
POINT_X, POINT_Y, FORCE_X, FORCE_Y, NORMAL_X, NORMAL_Y, OVERLAP, SLIDES = range(8)


@njit
def list_contacts(row, inner, forces, counts, laws, dt, bodies, numbers):
    """Write the contacts in the order of the inner list, which is not stale; their number.

    bodies (n, 2) and numbers (n, 8), n at least the length of the inner list, are written: the
    bodies of a contact, ascending, the point [m], the force on the second body [N], the normal
    towards it, the overlap [m], and 1 where the tangential spring is at its Coulomb limit.
    """
    found = np.int64(0)
    first, middle, last = np.int64(0), counts[PARTICLE_INNER], counts[INNER]
    found = list_class(row, inner, forces, laws[0], first, middle, dt, bodies, numbers, found)
    return list_class(row, inner, forces, laws[1], middle, last, dt, bodies, numbers, found)


@njit
def list_class(row, inner, forces, law, first, last, dt, bodies, numbers, found):
    """Append the contacts of the pairs first ... last - 1, which are of one class."""
    for begin in range(first, last, BLOCK):
        n_pairs = min(last - begin, BLOCK)
        before = inner.slip[begin : begin + n_pairs].copy()
        contact_forces(row, inner, forces, law, begin, n_pairs, dt)
        for k in range(n_pairs):
            n = begin + k
            overlap = overlap_now(row, inner, n)
            if overlap > 0.0:
                list_contact(row, inner, n, overlap, bodies[found], numbers[found])
                own = law_of(law, n)
                limit = slip_limit(own, overlap)
                slides = abs(inner.slip[n]) >= (1.0 - 1e-9) * limit  # but for rounding
                sign = 1.0 if inner.edge_body[n] < inner.vertex_body[n] else -1.0
                numbers[found, FORCE_X] = sign * forces.fx[k]
                numbers[found, FORCE_Y] = sign * forces.fy[k]
                numbers[found, SLIDES] = 1.0 if slides else 0.0
                found += 1
        for k in range(n_pairs):  # one by one: a slice takes numba 4 s to compile
            inner.slip[begin + k] = before[k]
    return found


@inner
def list_contact(row, inner, n, overlap, pair, numbers):
    """Write bodies, point, normal and overlap of pair n."""
    j, i = inner.vertex_body[n], inner.edge_body[n]
    between = row[j, X] - row[i, X], row[j, Y] - row[i, Y]
    arm_v = rotated(row[j, COS], row[j, SIN], (inner.vertex_x[n], inner.vertex_y[n]))
    dx, dy = edge_to_vertex(row, inner, n, between, arm_v)
    distance = np.sqrt(dx * dx + dy * dy)
    nx, ny = dx / distance, dy / distance
    depth = inner.depth[n] - 0.5 * overlap
    sign = 1.0 if i < j else -1.0  # the law's normal points to the vertex's body
    pair[0], pair[1] = min(i, j), max(i, j)
    numbers[POINT_X] = row[j, X] + arm_v[0] - depth * nx
    numbers[POINT_Y] = row[j, Y] + arm_v[1] - depth * ny
    numbers[NORMAL_X], numbers[NORMAL_Y] = sign * nx, sign * ny
    numbers[OVERLAP] = overlap


@uncounted
def energies(bodies, inner, counts, particle_law, wall_law, gravity):
    """Kinetic, potential, elastic normal, elastic tangential energy [J] of the live particles.

    The overlaps are those of now, the tangential springs those of the last step.
    """
    kinetic, potential, normal, tangential = 0.0, 0.0, 0.0, 0.0
    for k in range(counts[LIVE]):
        row = bodies.row[bodies.live[k]]
        kinetic += kinetic_energy(row)
        potential += gravity * row[Y] / row[INV_MASS]
    for n in range(counts[INNER]):
        law = law_of(particle_law if n < counts[PARTICLE_INNER] else wall_law, n)
        normal += normal_energy(law, max(overlap_now(bodies.row, inner, n), 0.0))
        tangential += tangential_energy(law, (inner.slip[n],))
    return kinetic, potential, normal, tangential


@dataclass
class WallSamples:
    """Samples of the contacts at the walls, one after the other."""

    taken: list[dict[str, np.ndarray]] = field(default_factory=list)

    def take(self, world, time: float, most: int | None) -> None:
        """Add the contacts of now, whose lists are not stale; keep the last `most`, if given."""
        n_particles = len(world.bodies.live)
        first, last = int(world.counts[PARTICLE_INNER]), int(world.counts[INNER])
        size = max(last - first, 1)
        bodies, numbers = np.zeros((size, 2), np.uint32), np.zeros((size, 8))
        n = list_class(
            world.bodies.row, world.inner, world.forces, world.wall_law, first, last,
            world.time_step, bodies, numbers, np.int64(0),
        )  # fmt: skip
        n = max(n, 1)  # one row without force where nothing touches: it was looked at
        wall = np.maximum(bodies[:n, 1].astype(np.int64) - n_particles, 0)
        self.taken.append(
            {
                "time": np.full(n, time),
                "wall": wall.astype(np.uint16),
                "point": numbers[:n, [POINT_X, POINT_Y]].astype(np.float32),
                "force": numbers[:n, [FORCE_X, FORCE_Y]].astype(np.float32),
            }
        )
        if most is not None:
            del self.taken[:-most]

    def table(self) -> dict[str, np.ndarray]:
        """All samples, a row for each contact; nothing of none.

        time         (n,) of the sample, since the phase began [s]
        wall         (n,) index of the wall
        point        (n, 2) where the force acts [m]
        force        (n, 2) on the wall, damping included [N]

        A sample without contacts has one row without force.
        """
        if not self.taken:
            return {}
        return {name: np.concatenate([one[name] for one in self.taken]) for name in self.taken[0]}
