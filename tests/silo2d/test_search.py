"""The lists miss no contact, and what comes out does not depend on when they were made."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import shapely
import shapely.affinity
from fuzzing import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import LEVEL, SPHERORADIUS, block, launch, simulation_of, wall

from granulab.errors import SimulationError
from silo2d.case.shapefile import load_shapes
from silo2d.engine import state
from silo2d.engine.simulation import Simulation

SHAPES = load_shapes("wood19").shapes
BAR = wall(0.3, half_length=6e-3, through=(0.0, LEVEL))  # its ends are corners among the particles
G = 9.81


def cores(simulation):
    """Corners (n, 2) [m] of the core of each body, the walls' included."""
    world = simulation.world
    found = []
    for body in range(len(world.bodies.row)):
        x, y, angle = world.bodies.row[body, [state.X, state.Y, state.ANGLE]]
        first, _, n_edges = world.bodies.layout[body]
        n = n_edges if body < simulation.n_particles else 2
        local = world.local[first : first + n, [state.VERTEX_X, state.VERTEX_Y]]
        found.append(rotated(local, angle) + np.array([x, y]))
    return found


def pairs_by_brute_force(simulation, margin=0.0):
    """(vertex's body, vertex, edge's body, edge) of all pairs whose overlap exceeds -margin [m]."""
    bodies = cores(simulation)
    radius = [SPHERORADIUS if k < simulation.n_particles else 0.0 for k in range(len(bodies))]
    found = set()
    for j, corners in enumerate(bodies):
        for i, core in enumerate(bodies):
            if i == j or min(i, j) >= simulation.n_particles:
                continue
            edges = len(core) if i < simulation.n_particles else 1
            for a, vertex in enumerate(corners):
                for b in range(edges):
                    edge = shapely.LineString([core[b], core[(b + 1) % len(core)]])
                    overlap = radius[i] + radius[j] - edge.distance(shapely.Point(vertex))
                    if overlap > -margin:
                        found.add((j, a, i, b))
    return found


def pairs_in_list(simulation, which):
    """The same for entries of the inner list."""
    outer, inner = simulation.world.outer, simulation.world.inner
    found = set()
    for n in which:
        a, b = divmod(int(outer.key[inner.outer[n]]) % state.MAX_VERTICES**2, state.MAX_VERTICES)
        found.add((int(inner.vertex_body[n]), a, int(inner.edge_body[n]), b))
    return found


def crowd(seed, size=50e-3):
    """Particles thrown into a square with a bar in its middle, each pushed until it overlaps the
    others or the walls by nearly half of the spheroradii."""
    rng = np.random.default_rng(seed)
    low, high = LEVEL - size / 2, LEVEL + size / 2
    corners = np.array([[-size / 2, low], [size / 2, low], [size / 2, high], [-size / 2, high]])
    walls = [*np.stack([corners, np.roll(corners, -1, axis=0)], axis=1), BAR]
    inside = shapely.Polygon(corners)
    obstacles = [(shapely.LineString(segment), 0.55 * SPHERORADIUS) for segment in walls]

    def clear(core):
        return inside.contains(core) and all(core.distance(o) > d for o, d in obstacles)

    shapes, poses = [], []
    for _ in range(60):
        shape = SHAPES[rng.integers(len(SHAPES))]
        x, y, angle = rng.uniform(-size / 2, size / 2), rng.uniform(low, high), rng.uniform(0, 7)
        core = shapely.Polygon(rotated(shape.core, angle) + np.array([x, y]))
        if not clear(core):
            continue
        push = 0.2e-3 * np.array([np.cos(direction := rng.uniform(0, 7)), np.sin(direction)])
        while clear(pushed := shapely.affinity.translate(core, *push)):
            core, x, y = pushed, x + push[0], y + push[1]
        obstacles.append((core, 1.1 * SPHERORADIUS))
        shapes.append(shape)
        poses.append((x, y, angle))
    return simulation_of(shapes, poses, walls=walls, time_step=1e-6)


def rotated(points, angle):
    """Points (n, 2) rotated by an angle [rad]."""
    cos, sin = np.cos(angle), np.sin(angle)
    return points @ np.array([[cos, sin], [-sin, cos]])


def step_without_motion(simulation):
    """Make the lists for where the particles are: a step too short to move them."""
    simulation.world = simulation.world._replace(time_step=1e-30)
    simulation.run(1)


@settings(deadline=None, max_examples=examples(15))
@given(seed=st.integers(0, 2**32 - 1))
def test_the_list_holds_every_touching_pair(seed):
    """Random dense crowds against all vertices of all bodies and all edges of all others, walls'
    edges and free ends included; the list has no pair twice. No tolerance: pairs within rounding
    of just touching (1e-12 m) are left out of the comparison."""
    simulation = crowd(seed)
    step_without_motion(simulation)
    n_listed = simulation.world.counts[state.INNER]
    listed = pairs_in_list(simulation, range(n_listed))
    assert len(listed) == n_listed
    touching = pairs_in_list(simulation, simulation.touching())
    surely, perhaps = (pairs_by_brute_force(simulation, m) for m in (-1e-12, 1e-12))
    assert len(surely) > 0
    assert perhaps <= listed
    assert surely <= touching <= perhaps


def test_crowds_touch_in_every_way():
    """The crowds above have particles that touch particles, walls' edges and walls' ends."""
    kinds = set()
    for seed in range(6):
        simulation = crowd(seed)
        n = simulation.n_particles
        for j, _, i, _ in pairs_by_brute_force(simulation):
            kinds.add(("grain" if j < n else "wall", "grain" if i < n else "wall"))
    assert kinds == {("grain", "grain"), ("grain", "wall"), ("wall", "grain")}


def pour() -> Simulation:
    """Particles that fall on a floor with a gap between two walls: they collide, slide, leave."""
    rng = np.random.default_rng(5)
    walls = [
        wall(0.0, 0.02, (-0.035, 0.0)),
        wall(0.0, 0.02, (0.035, 0.0)),
        wall(np.pi / 2, 0.2, (0.05, 0.2)),
        wall(-np.pi / 2, 0.2, (-0.05, 0.2)),
    ]
    shapes = [SHAPES[k] for k in rng.integers(len(SHAPES), size=16)]
    x, y = np.meshgrid([-0.036, -0.012, 0.012, 0.036], [0.02, 0.045, 0.07, 0.095])
    poses = np.column_stack([x.ravel(), y.ravel(), rng.uniform(0, 2 * np.pi, 16)])
    simulation = simulation_of(shapes, poses, walls=walls, time_step=1e-5, gravity=G)
    for particle in range(16):
        launch(simulation, particle, *rng.uniform(-1, 1, 2), rng.uniform(-20, 20))
    return simulation


STEPS = 45000


@pytest.fixture(scope="module")
def poured():
    """The pour after STEPS in one go."""
    simulation = pour()
    simulation.run(STEPS)
    return simulation


def test_the_pour_has_everything(poured):
    """Particles have left, others touch with springs held; friction has worked, lists are new."""
    assert 0 < poured.n_out < poured.n_particles
    assert len(poured.live) < poured.n_particles
    energies = poured.energies()
    assert energies["elastic_tangential"] > 0
    assert energies["friction_grain_grain"] > 0
    assert energies["friction_grain_wall"] > 0
    counts = poured.world.counts
    assert counts[state.BODY_SEARCHES] > 1
    assert counts[state.OUTER_SEARCHES] > 10
    assert counts[state.INNER_SEARCHES] > 100


def test_same_bits_again_and_in_pieces(poured):
    """Two runs, and any cut into calls of run, give the same bits."""
    simulation = pour()
    for n in (1, 2, 997, 10000, STEPS - 11000):
        simulation.run(n)
    assert simulation.state_digest() == poured.state_digest()
    assert simulation.energies() == poured.energies()


def test_same_bits_with_all_lists_made_again_at_every_step(poured):
    """No contact is missed and no slip lost or doubled while the lists age: lists made again at
    every step give the same bits. (The energy sums add up what springs of dropped particles held
    when the lists are made, so energies agree to rounding.)"""
    simulation = pour()
    for _ in range(STEPS):
        simulation.world.counts[state.STALE] = 3
        simulation.run(1)
    assert simulation.state_digest() == poured.state_digest()
    energies = simulation.energies()
    for name, value in poured.energies().items():
        assert energies[name] == pytest.approx(value, rel=1e-9, abs=1e-15), name


def spin_on_the_spot(made_again):
    """A long block that rotates next to a wall and to another block until it has hit both."""
    long, other = block(30e-3, 6e-3), block(10e-3, 10e-3)
    poses = [(0.0, LEVEL, 0.0), (0.0, LEVEL + 16e-3, 0.0)]
    simulation = simulation_of(
        [long, other], poses, walls=[wall(through=(0.0, LEVEL - 10e-3))], time_step=2e-6
    )
    launch(simulation, 0, spin=100.0)
    for _ in range(10000):
        if made_again:
            simulation.world.counts[state.STALE] = 3
        simulation.run(1)
    return simulation


def test_lists_follow_a_particle_that_only_rotates():
    """A tip can come near while the centroid rests; the same bits as with lists made again."""
    simulation = spin_on_the_spot(made_again=False)
    energies = simulation.energies()
    assert energies["normal_damping_grain_wall"] > 0
    assert energies["normal_damping_grain_grain"] > 0
    assert simulation.state_digest() == spin_on_the_spot(made_again=True).state_digest()


@pytest.mark.parametrize("cut", [1, 2500, 17003])
def test_restored_run_goes_on_with_the_same_bits(poured, cut):
    """What `save` keeps is all there is: state, slips, energy sums, who has left."""
    first = pour()
    first.run(cut)
    saved = first.save()
    first.run(100)  # what was saved must not change with it
    second = pour()
    second.run(3)
    second.restore(saved)
    second.run(STEPS - cut)
    assert second.state_digest() == poured.state_digest()
    assert second.energies() == poured.energies()
    assert second.n_out == poured.n_out
    np.testing.assert_array_equal(second.live, poured.live)


def test_lists_that_turn_out_too_short_are_made_longer(poured):
    """A world with room for hardly any pairs ends with the same bits."""
    simulation = pour()
    world = simulation.world
    capacity, short = len(world.outer.key), 8
    simulation.world = world._replace(
        cells=world.cells._replace(pairs=world.cells.pairs[:2].copy()),
        outer=type(world.outer)(*(a[: len(a) - capacity + short].copy() for a in world.outer)),
    )
    simulation.run(STEPS)
    assert simulation.state_digest() == poured.state_digest()


def test_too_deep_an_overlap_is_an_error():
    """A particle that is pressed through a wall is not let through in silence."""
    simulation = crowd(3)
    launch(simulation, 0, vx=0.0, vy=-3000.0)
    with pytest.raises(
        SimulationError, match=r"failed at t = .* s, in steps of .*: .*; try a smaller time step"
    ):
        simulation.run(1000)


def test_uncompiled_kernels_give_the_same_bits():
    """The kernels as plain Python (NUMBA_DISABLE_JIT) take the same steps: nothing rests on what
    a compiler does. A short fall of three particles that collide."""
    repository = Path(__file__).resolve().parents[2]
    paths = os.pathsep.join(
        [str(repository), str(repository / "tests" / "helpers"), str(Path(__file__).parent)]
    )
    code = "from test_search import short_fall; print(short_fall())"
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": paths}
    result = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        env=environment,
        cwd=repository,
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    assert result.stdout.strip() == short_fall()


def short_fall() -> str:
    """Digest of a few particles after 600 steps in which they collide, slide and turn."""
    poses = [(0.0, LEVEL + 15e-3, 0.4), (8e-3, LEVEL + 42e-3, 1.0), (-28e-3, LEVEL + 16e-3, 2.0)]
    simulation = simulation_of(
        [SHAPES[k] for k in (0, 5, 12)], poses, walls=[wall()], time_step=5e-6, gravity=G
    )
    launch(simulation, 1, vx=-2.0, vy=-3.0, spin=30.0)
    launch(simulation, 2, vx=4.0, vy=-2.0)
    simulation.run(600)
    friction = simulation.energies()["friction_grain_grain"]
    assert friction > 0
    return f"{simulation.state_digest()} {friction!r}"
