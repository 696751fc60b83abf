"""How the walls of a slow test move: at a constant velocity, or held to a force by the servo.

The servo's wall has no mass: it hangs on a dashpot and carries the target F,

    v = (P - F)/c,   |v| <= v_max,

with P the upward force of the particles on it and c the viscosity. A dashpot and a dead load give
back no energy, so that the servo is stable on any bed, as long as its steps are: c is far above the
stiffness of the bed times the time step (quasistatic.rig). It approaches its target in c over that
stiffness, and where the bed gives way at a velocity v it lacks c v.
"""

from damper3d.engine.shells import FASTEST, ON, TARGET, VISCOSITY, WALL
from damper3d.engine.state import STALE_WALL, WALL_SKIN
from granulab.contact.jit import inlined_inner


@inlined_inner
def drive(world):
    """One step of the walls; marks the list of contacts where one has come too far for it."""
    walls, counts, dt = world.walls, world.counts, world.time_step
    keep_to_force(walls)
    leeway = 0.5 * world.lengths[WALL_SKIN]
    for w in range(len(walls.force)):
        way = 0.0
        for c in range(3):
            walls.place[w, c] += dt * walls.speed[w, c]
            way += (walls.place[w, c] - walls.listed[w, c]) ** 2
        counts[STALE_WALL] |= not way <= leeway * leeway


@inlined_inner
def keep_to_force(walls):
    """Let the servo choose the vertical velocity of its wall, from the force of this step."""
    servo = walls.servo
    if servo[ON] > 0.0:
        w = int(servo[WALL])
        pushed = walls.force[w, 2] - walls.before[w]
        wanted = (pushed - servo[TARGET]) / servo[VISCOSITY]
        walls.speed[w, 2] = min(max(wanted, -servo[FASTEST]), servo[FASTEST])
