"""Active spheres: those that stand in a list, the only ones that are kept up to date."""

from damper3d.engine.multisphere.motion import place_active
from damper3d.engine.state import CLOSE, WALL
from granulab.contact.jit import inner


@inner
def list_active(world):
    """Name the spheres of both lists, body by body, and bring them up to date."""
    counts, listed, size = world.counts, world.scratch.listed, len(world.shape.offset)
    listed[:] = 0
    for n in range(counts[CLOSE]):
        listed[world.close.i[n]] = listed[world.close.j[n]] = 1
    for n in range(counts[WALL]):
        listed[world.wall.i[n]] = 1
    found = 0
    for b in range(len(world.bodies.inverse_mass)):
        world.active_first[b] = found
        for i in range(b * size, (b + 1) * size):
            world.active[found] = i
            found += listed[i]
        world.active_first[b + 1] = found
        place_active(world, b)
