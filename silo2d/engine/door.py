"""A door that is drawn to the right: a wall that moves along itself and grows shorter.

The door is the floor of the outlet. It moves at a constant speed from the start of the opening on,
and passes under the right lip: what of it is still in the outlet reaches from its left end, a
corner that particles can rest on, to that lip. Its surface moves with it and drags the particles by
friction. As a wall it has no inertia; the work of whoever draws it is booked.
"""

from granulab.contact.jit import njit
from silo2d.engine.integrate import held_by_contacts
from silo2d.engine.state import (
    BOUNDING_RADIUS,
    CARRIED_OUT,
    CLOSE,
    CLOSE_LIST,
    DOOR,
    EDGE_X,
    EDGE_Y,
    FIRST,
    FX,
    GIVEN_TO_DOOR,
    INV_LENGTH2,
    N_CORNERS,
    N_EDGES,
    NEAR_LIST,
    PARTICLE_CLOSE,
    STALE,
    UX,
    VERTEX_X,
    VERTEX_Y,
    VX,
    X,
    Y,
)


@njit
def left_of_door(world):
    """How much of the door is still in the outlet [m]; its second vertex is the right lip."""
    door = world.counts[DOOR]
    lip = world.vertices[world.bodies.layout[door, FIRST] + 1, VERTEX_X]
    return lip - world.bodies.row[door, X]


@njit
def place_door(world):
    """Shorten the door to what is left of it, in its own frame, the silo's and the close list."""
    bodies, local, vertices, close = world.bodies, world.local, world.vertices, world.close
    door, length = world.counts[DOOR], left_of_door(world)
    v = bodies.layout[door, FIRST]
    inverse = 1.0 / (length * length)
    local[v, VERTEX_X], local[v, VERTEX_Y] = 0.0, 0.0
    local[v, EDGE_X], local[v, EDGE_Y], local[v, INV_LENGTH2] = length, 0.0, inverse
    vertices[v, VERTEX_X], vertices[v, VERTEX_Y] = bodies.row[door, X], bodies.row[door, Y]
    vertices[v, EDGE_X], vertices[v, EDGE_Y] = length, 0.0
    bodies.size[door, BOUNDING_RADIUS] = length
    for n in range(world.counts[PARTICLE_CLOSE], world.counts[CLOSE]):
        if close.edge_body[n] == door:
            close.edge_x[n], close.inv_length2[n] = length, inverse


@njit
def give_door_room(bodies, counts, dt, steps, least):
    """Room of the door's corner in the lists of close and near pairs, for that many steps each.

    The list of bodies needs none: the door shrinks, and only leaves particles.
    """
    if counts[DOOR] > 0:
        door = counts[DOOR]
        for level, n_steps in ((CLOSE_LIST, steps[0]), (NEAR_LIST, steps[1])):
            bodies.room[door, level] = n_steps * (dt * bodies.row[door, VX] + least)


@njit
def draw_on(world, load):
    """Move the door by one step and book its work; it is gone once nothing of it is left.

    load: force on the door [N] that was added up before this step, and is put back.
    """
    bodies, counts = world.bodies, world.counts
    row, door = bodies.row, counts[DOOR]
    path = row[door, VX] * world.time_step
    world.books[GIVEN_TO_DOOR] += row[door, FX] * path
    row[door, FX] += load
    row[door, X] += path
    if left_of_door(world) > 0.0:
        place_door(world)
        if row[door, X] - bodies.listed[door, 3 * CLOSE_LIST] > bodies.room[door, CLOSE_LIST]:
            counts[STALE] = max(counts[STALE], 1)
        return
    # Particles that lean on its end lose what its springs hold, as those lose it that leave.
    world.books[CARRIED_OUT] += held_by_contacts(world, door)
    bodies.layout[door, N_CORNERS], bodies.layout[door, N_EDGES] = 0, 0
    row[door, VX], row[door, UX] = 0.0, 0.0
    counts[DOOR], counts[STALE] = 0, 3
