"""Small scenes of the plane: a disc, a block, walls, and how to set them in motion."""

import numpy as np

from granulab.contact.laws import LinearLaw
from silo2d.case.outline import Walls
from silo2d.case.shape import Shape, mass_integrals, shape_from_outline
from silo2d.engine import state
from silo2d.engine.simulation import Simulation
from silo2d.engine.world import build_world

SURFACE_DENSITY = 54.0  # the wood prisms of the silo paper [kg/m2]
SPHERORADIUS = 1e-3  # of blocks [m]
G = 9.81  # [m/s2]
KN = 1e7  # [N/m]
# The wood-silo paper's Table 4, between particles.
WOOD = LinearLaw(kn=KN, kt=0.065 * KN, mu=0.38, gamma_n=6085.0, gamma_t=3.0, pulls=True)
# Hard enough that a body sinks in by 1e-5 of its size, damped enough that its springs come to
# rest in a few milliseconds; and the time step [s] that goes with it.
HARD_LAW = WOOD._replace(kn=1e6, kt=1e6, gamma_n=3000.0, gamma_t=0.0)
HARD_STEP = 4e-6
ELASTIC = LinearLaw(kn=KN, kt=0.065 * KN, mu=0.0, gamma_n=0.0, gamma_t=0.0, pulls=True)

# All scenes lie around this height [m]: a particle below y = 0 would count as discharged.
LEVEL = 0.1
# A gap [m] that rounding does not close: the first step that touches is one whole step deep.
HAIR = 1e-13

# A disc is a spheropolygon with a core much smaller than any overlap. All three corners touch a
# wall at once, each with its own spring: DISC_CONTACTS contacts in parallel, whose overlaps add
# up to three times that of the disc (the corners of a regular polygon average to its middle).
DISC_CONTACTS = 3
_CORE = 1e-10  # [m]


def disc(radius: float) -> Shape:
    """A disc [m] but for 1e-10 m; on a wall it makes DISC_CONTACTS contacts."""
    angles = 2 * np.pi * np.arange(DISC_CONTACTS) / DISC_CONTACTS
    core = _CORE * np.column_stack([np.cos(angles), np.sin(angles)])
    area, centroid, polar = mass_integrals(core, radius - _CORE)
    return Shape("disc", core - centroid, radius - _CORE, area, polar)


def block(width: float, height: float) -> Shape:
    """A rectangle [m], its corners rounded with SPHERORADIUS."""
    corners = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
    return shape_from_outline("block", corners, SPHERORADIUS, "scenes")


def wall(angle: float = 0.0, half_length: float = 0.5, through=(0.0, LEVEL)) -> np.ndarray:
    """A segment (2, 2) [m] about a point, rotated by an angle [rad]; the inside is on its left."""
    along = half_length * np.array([np.cos(angle), np.sin(angle)])
    return np.array([through - along, through + along])


def simulation_of(
    shapes,
    poses,
    *,
    time_step: float,
    walls=(),
    law: LinearLaw = WOOD,
    wall_law: LinearLaw | None = None,
    gravity: float = 0.0,
    surface_density: float = SURFACE_DENSITY,
) -> Simulation:
    """Particles of these shapes at poses (x, y [m], angle [rad]); one law for all unless given."""
    n_walls = len(walls)
    world = build_world(
        list(shapes),
        np.arange(len(shapes)),
        np.array(poses, dtype=np.float64),
        Walls(
            np.array(walls).reshape(n_walls, 2, 2),
            [f"wall {k}" for k in range(n_walls)],
            np.full(n_walls, 2),
        ),
        surface_density=surface_density,
        particle_law=law,
        wall_law=law if wall_law is None else wall_law,
        gravity=gravity,
        time_step=time_step,
    )
    return Simulation(world)


def launch(simulation, particle=0, vx=0.0, vy=0.0, spin=0.0) -> None:
    """Set a particle's velocity [m/s, rad/s], now and half a step back alike."""
    simulation.rows[particle, [state.VX, state.VY, state.OMEGA]] = vx, vy, spin
    simulation.rows[particle, [state.UX, state.UY, state.UOMEGA]] = vx, vy, spin


def position(simulation, particle=0) -> np.ndarray:
    """x, y [m] and angle [rad] of a particle."""
    return simulation.rows[particle, [state.X, state.Y, state.ANGLE]]


def velocity(simulation, particle=0) -> np.ndarray:
    """vx, vy [m/s] and spin [rad/s] of a particle, now."""
    return simulation.rows[particle, [state.UX, state.UY, state.UOMEGA]]


def mass(simulation, particle=0) -> float:
    """Mass [kg] of a particle."""
    return 1.0 / simulation.rows[particle, state.INV_MASS]


def inertia(simulation, particle=0) -> float:
    """Moment of inertia [kg m2] of a particle."""
    return 1.0 / simulation.rows[particle, state.INV_INERTIA]


def disc_on_wall(radius, law, time_step, *, angle=0.0, overlap=-HAIR, **settings) -> Simulation:
    """A disc that touches an inclined wall with an overlap [m]; negative is a gap."""
    height = radius - overlap
    pose = (-height * np.sin(angle), LEVEL + height * np.cos(angle), 0.0)
    return simulation_of(
        [disc(radius)], [pose], walls=[wall(angle)], law=law, time_step=time_step, **settings
    )


def block_on_wall(shape, law, time_step, *, angle=0.0, overlap=-HAIR, **settings) -> Simulation:
    """A block that lies with a face on an inclined wall."""
    height = SPHERORADIUS - shape.core[:, 1].min() - overlap
    pose = (-height * np.sin(angle), LEVEL + height * np.cos(angle), angle)
    return simulation_of(
        [shape], [pose], walls=[wall(angle)], law=law, time_step=time_step, **settings
    )


def corner_on_wall(law, time_step) -> Simulation:
    """A square block that stands on one corner above a floor: one vertex-edge pair."""
    shape = block(10e-3, 10e-3)
    height = SPHERORADIUS + np.hypot(*shape.core[0]) + HAIR
    return simulation_of(
        [shape], [(0.0, LEVEL + height, np.pi / 4)], walls=[wall()], law=law, time_step=time_step
    )


def corner_on_face(law, time_step) -> Simulation:
    """A square block whose corner points down at the face of a wider one: one pair."""
    upper, lower = block(10e-3, 10e-3), block(20e-3, 10e-3)
    height = 2 * SPHERORADIUS + np.hypot(*upper.core[0]) + lower.core[:, 1].max() + HAIR
    poses = [(0.0, LEVEL + height, np.pi / 4), (0.0, LEVEL, 0.0)]
    return simulation_of([upper, lower], poses, law=law, time_step=time_step)


def face_to_face(law, time_step) -> Simulation:
    """Two 10 mm x 20 mm blocks one above the other, their corners aligned: eight pairs."""
    shape = block(20e-3, 10e-3)
    height = 2 * (shape.core[:, 1].max() + SPHERORADIUS) + HAIR
    poses = [(0.0, LEVEL + height, 0.0), (0.0, LEVEL, 0.0)]
    return simulation_of([shape, shape], poses, law=law, time_step=time_step)


def squeezed(shape, half_height, overlap, law, time_step) -> Simulation:
    """A particle between two parallel walls, `overlap` [m] deep in both and in equilibrium."""
    reach = half_height - overlap
    walls = [wall(0.0, through=(0.0, LEVEL - reach)), wall(np.pi, through=(0.0, LEVEL + reach))]
    return simulation_of([shape], [(0.0, LEVEL, 0.0)], walls=walls, law=law, time_step=time_step)
