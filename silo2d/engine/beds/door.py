"""A door that is drawn to the right: a wall that moves along itself and grows shorter.

The door is the floor of the outlet. It moves at a constant speed from the start of the opening on,
and passes under the right lip: what of it is still in the outlet reaches from its left end, a
corner that particles can rest on, to that lip. Its surface moves with it and drags the particles by
friction. As a wall it has no inertia; the work of whoever draws it is accounted for.
"""

from granulab.contact.jit import inner
from silo2d.engine.beds.vibration import note_loads, shake_walls
from silo2d.engine.integrate import energy_of_contacts
from silo2d.engine.state import (
    BOUNDING_RADIUS,
    CARRIED_OUT,
    DOOR,
    EDGE_X,
    EDGE_Y,
    FIRST,
    FX,
    GIVEN_TO_DOOR,
    INNER,
    INNER_LIST,
    INV_LENGTH2,
    N_CORNERS,
    N_EDGES,
    OUTER_LIST,
    PARTICLE_INNER,
    STALE,
    UX,
    VERTEX_X,
    VERTEX_Y,
    VX,
    X,
    Y,
)


@inner
def rest_of_door(world):
    """Length of the door that is still in the outlet [m]; its second vertex is the right lip."""
    door = world.counts[DOOR]
    lip = world.vertices[world.bodies.layout[door, FIRST] + 1, VERTEX_X]
    return lip - world.bodies.row[door, X]


@inner
def update_door(world):
    """Shorten the door to what is left of it, in its own frame, the silo's and the inner list."""
    bodies, local, vertices, inner = world.bodies, world.local, world.vertices, world.inner
    door, length = world.counts[DOOR], rest_of_door(world)
    v = bodies.layout[door, FIRST]
    inverse = 1.0 / (length * length)
    local[v, VERTEX_X], local[v, VERTEX_Y] = 0.0, 0.0
    local[v, EDGE_X], local[v, EDGE_Y], local[v, INV_LENGTH2] = length, 0.0, inverse
    vertices[v, VERTEX_X], vertices[v, VERTEX_Y] = bodies.row[door, X], bodies.row[door, Y]
    vertices[v, EDGE_X], vertices[v, EDGE_Y] = length, 0.0
    bodies.size[door, BOUNDING_RADIUS] = length
    for n in range(world.counts[PARTICLE_INNER], world.counts[INNER]):
        if inner.edge_body[n] == door:
            inner.edge_x[n], inner.inv_length2[n] = length, inverse


@inner
def set_door_skins(bodies, counts, dt, steps, least):
    """Skins of the door's corner in the inner and the outer list, for that many steps each.

    The list of bodies needs none: the door shrinks, and only leaves particles.
    """
    if counts[DOOR] > 0:
        door = counts[DOOR]
        for level, n_steps in ((INNER_LIST, steps[0]), (OUTER_LIST, steps[1])):
            bodies.skin[door, level] = n_steps * (dt * bodies.row[door, VX] + least)


@inner
def take_loads(world):
    """Put the forces on walls that move aside: that of this step alone does work; the door's."""
    note_loads(world, world.vibration)
    door, row = world.counts[DOOR], world.bodies.row
    load = row[door, FX]
    if door > 0:
        row[door, FX] = 0.0
    return load


@inner
def move_walls(world, load):
    """Move those walls by a step, at its end, and put the forces back; load: of the door."""
    shake_walls(world, world.vibration)
    if world.counts[DOOR] > 0:
        move_door(world, load)


@inner
def move_door(world, load):
    """Move the door by one step and account for its work; it is gone once nothing of it is left.

    load: force on the door [N] that was added up before this step, and is put back.
    """
    bodies, counts = world.bodies, world.counts
    row, door = bodies.row, counts[DOOR]
    path = row[door, VX] * world.time_step
    world.account[GIVEN_TO_DOOR] += row[door, FX] * path
    row[door, FX] += load
    row[door, X] += path
    if rest_of_door(world) > 0.0:
        update_door(world)
        if row[door, X] - bodies.listed[door, 3 * INNER_LIST] > bodies.skin[door, INNER_LIST]:
            counts[STALE] = max(counts[STALE], 1)
        return
    # Particles that lean on its end lose what its springs hold, as those lose it that leave.
    world.account[CARRIED_OUT] += energy_of_contacts(world, door)
    bodies.layout[door, N_CORNERS], bodies.layout[door, N_EDGES] = 0, 0
    row[door, VX], row[door, UX] = 0.0, 0.0
    counts[DOOR], counts[STALE] = 0, 3
