"""Assembly: contact forces of the vertex-edge pairs of the inner list, and what they dissipate.

The pass over the pairs has no branch and writes one array a quantity, so that the compiler
vectorises it: a pair that does not touch has overlap 0 and mass 0, which makes its forces exact
zeros. A second pass adds the forces to the bodies, in the order of the list.

The vertex's body is j of the law and the edge's body i: the normal points to the vertex. The
force acts at the middle of the overlap on both bodies, so that angular momentum is kept.
"""

import numpy as np

from granulab.contact.jit import inner, uncounted
from granulab.contact.laws import normal_force, tangential_damping, tangential_force
from silo2d.engine.geometry import cross, point_velocity, rotated, to_edge
from silo2d.engine.pair_law import law_of
from silo2d.engine.simd import add_loads
from silo2d.engine.state import (
    BLOCK,
    CARRIED_OUT,
    COS,
    FRICTION,
    NORMAL_DAMPING,
    OMEGA,
    PARTICLE_PARTICLE,
    PARTICLE_WALL,
    SIN,
    TANGENTIAL_DAMPING,
    UOMEGA,
    UX,
    UY,
    VX,
    VY,
    X,
    Y,
)


@inner
def apply_forces(world):
    """All contact forces of this step, added to the bodies, and what they dissipate."""
    first, account, dt = world.first_pair, world.account, world.time_step
    apply_class(world, world.particle_law, first[0], account[PARTICLE_PARTICLE:PARTICLE_WALL], dt)
    apply_class(world, world.wall_law, first[1], account[PARTICLE_WALL:CARRIED_OUT], dt)


@inner
def apply_class(world, law, first_pair, account, dt):
    """Contact forces of the pairs of one law, block by block; first_pair of its parts.

    What is dissipated is summed over all blocks of a part in the order of the list. Pairs that do
    not touch add exact zeros, so that no bit of the account depends on when the list was made.
    """
    total = 0.0, 0.0, 0.0
    for part in range(len(first_pair) - 1):
        last, sums = first_pair[part + 1], (0.0, 0.0, 0.0)
        for begin in range(first_pair[part], last, BLOCK):
            n = min(last - begin, BLOCK)
            contact_forces(world.bodies.row, world.inner, world.forces, law, begin, n, dt)
            sums = add_loads(
                world.bodies.row, None, world.inner.vertex_body, world.inner.edge_body,
                world.forces, begin, n, sums,
            )  # fmt: skip
        total = added(total, sums)
    add_to_account(account, total, dt)


@inner
def added(a, b):
    """Sums by mechanism, of two."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inner
def add_to_account(account, sums, dt):
    """Add what the pairs of a class dissipated in this step to its account."""
    account[NORMAL_DAMPING] += sums[0] * dt
    account[TANGENTIAL_DAMPING] += sums[1] * dt
    account[FRICTION] += sums[2]


@inner
def contact_forces(row, inner, forces, law, begin, n_pairs, dt):
    """Force, torques, slip and dissipation of n_pairs inner pairs from `begin` on.

    Slip grows with the displacement really taken since the last step (velocity half a step
    back); damping and its power take the velocity extrapolated to now.
    """
    for k in range(np.uintp(n_pairs)):  # unsigned: numba then need not look for negative ones
        n = np.uintp(begin) + k
        own = law_of(law, n)
        j, i = inner.vertex_body[n], inner.edge_body[n]
        between = row[j, X] - row[i, X], row[j, Y] - row[i, Y]
        arm_v = rotated(row[j, COS], row[j, SIN], (inner.vertex_x[n], inner.vertex_y[n]))
        dx, dy = edge_to_vertex(row, inner, n, between, arm_v)
        distance = np.sqrt(dx * dx + dy * dy)
        touches = 1.0 if distance < inner.cutoff[n] else 0.0
        overlap = max(inner.cutoff[n] - distance, 0.0)
        shrink = 1.0 / distance  # one division for two: they cost as much as the root
        nx, ny = shrink * dx, shrink * dy
        depth = inner.depth[n] - 0.5 * overlap
        arm_j = arm_v[0] - depth * nx, arm_v[1] - depth * ny
        arm_i = between[0] + arm_j[0], between[1] + arm_j[1]

        vxj, vyj = point_velocity(row[j, VX], row[j, VY], row[j, OMEGA], arm_j)
        vxi, vyi = point_velocity(row[i, VX], row[i, VY], row[i, OMEGA], arm_i)
        uxj, uyj = point_velocity(row[j, UX], row[j, UY], row[j, UOMEGA], arm_j)
        uxi, uyi = point_velocity(row[i, UX], row[i, UY], row[i, UOMEGA], arm_i)
        # The tangent is the normal rotated to the left.
        slip_step = touches * ((vyj - vyi) * nx - (vxj - vxi) * ny) * dt
        slip_rate = (uyj - uyi) * nx - (uxj - uxi) * ny
        overlap_rate = -((uxj - uxi) * nx + (uyj - uyi) * ny)

        m = touches * inner.mass[n]
        f_n, damping = normal_force(own, m, overlap, overlap_rate)
        (f_t,), (held,), lost = tangential_force(
            own, m, overlap, (inner.slip[n],), (slip_step,), (slip_rate,)
        )
        fx, fy = f_n * nx - f_t * ny, f_n * ny + f_t * nx
        inner.slip[n] = held
        forces.fx[k], forces.fy[k] = fx, fy
        forces.torque_j[k], forces.torque_i[k] = cross(arm_j, (fx, fy)), -cross(arm_i, (fx, fy))
        forces.normal_power[k] = damping * overlap_rate
        forces.tangential_power[k] = tangential_damping(own, m, (slip_rate,))
        forces.lost[k] = lost


@inner
def edge_to_vertex(row, inner, n, between, arm_v):
    """Vector to the vertex of pair n from the closest point of its edge [m].

    between: from the centroid of the edge's body to that of the vertex's body; arm_v: from the
    latter to the vertex [m].
    """
    i = inner.edge_body[n]
    start = rotated(row[i, COS], row[i, SIN], (inner.start_x[n], inner.start_y[n]))
    edge = rotated(row[i, COS], row[i, SIN], (inner.edge_x[n], inner.edge_y[n]))
    rx, ry = between[0] + arm_v[0] - start[0], between[1] + arm_v[1] - start[1]
    return to_edge(rx, ry, edge[0], edge[1], inner.inv_length2[n])


@inner
def overlap_now(row, inner, n):
    """Overlap of pair n [m]; negative where it does not touch."""
    j, i = inner.vertex_body[n], inner.edge_body[n]
    between = row[j, X] - row[i, X], row[j, Y] - row[i, Y]
    arm_v = rotated(row[j, COS], row[j, SIN], (inner.vertex_x[n], inner.vertex_y[n]))
    dx, dy = edge_to_vertex(row, inner, n, between, arm_v)
    return inner.cutoff[n] - np.sqrt(dx * dx + dy * dy)


@uncounted
def note_overlapping(row, inner, n_pairs, found):
    """Write which of the first n_pairs pairs touch to `found`; how many do."""
    n_found = 0
    for n in range(n_pairs):
        if overlap_now(row, inner, n) > 0.0:
            found[n_found] = n
            n_found += 1
    return n_found
