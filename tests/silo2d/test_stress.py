"""Coarse-grained stress: virial sum, balance of momentum, columns of blocks, Janssen's law."""

import math

import analytic
import numpy as np
import pytest
import scenes
from hand_built import GRAVITY, STICKY, moment_in, moment_of, scene_of, simulation_in
from hypothesis import given
from hypothesis import strategies as st
from small_silo import silo2d

from silo2d.case.outline import hopper
from silo2d.measures import janssen
from silo2d.measures.basics.coarse_graining import Grid, along_branches, grid_round
from silo2d.measures.basics.contacts import read_moments
from silo2d.measures.basics.walls import tractions
from silo2d.measures.stress import contact_stress, kinetic_stress, moving, stress_of, virial

BLOCK = scenes.block(20e-3, 10e-3)
WEIGHT = scenes.SURFACE_DENSITY * BLOCK.area * GRAVITY
N = 8  # blocks of a column


def test_what_touches_nothing_has_no_contact_stress():
    """Fields of no contacts are zero all over, of the grid's form."""
    grid = grid_round(np.zeros(2), np.full(2, 0.1), 5e-3)
    none = np.zeros((0, 2))
    found = grid.deposit(none, np.zeros((0, 2, 2)))
    assert found.shape == (2, 2, len(grid.y), len(grid.x))
    assert not found.any()


def column(width: float, law, half_gap: float = 0.0, steps: int = 30000):
    """Blocks one upon the other on a door, settled; in a gap of a width [m]."""
    silo = hopper(0.0, width, width, 0.12, "column")
    poses = [(half_gap, 5e-3 + 10e-3 * k, 0.0) for k in range(N)]
    sim = simulation_in(silo, [BLOCK] * N, poses, law, door=True)
    sim.run(steps)
    return moment_in(sim, silo, [BLOCK] * N)


@pytest.fixture(scope="module")
def pile():
    """A column that touches no wall, on its door."""
    return column(60e-3, STICKY)


@pytest.fixture(params=[0, 2])
def flow(request, reference):
    """Moments of the small silo: before the opening, and in the flow."""
    return read_moments(reference.path)[request.param]


# The kernel


@given(
    st.tuples(*[st.floats(-3, 3)] * 4),
    st.tuples(*[st.floats(-3, 3)] * 2),
)
def test_line_integral_of_the_gaussian(branch, point):
    """Gauss's quadrature against error functions, for branches up to two widths long: both ends
    of a step function would need more points, a Gaussian is smooth (error below 1e-6 of its
    peak)."""
    start, end = np.array([branch[:2]]), np.array([branch[2:]])
    length = math.hypot(*(end - start)[0])
    if length > 2 or length < 1e-3:
        return
    points, weights = along_branches(start, end)
    grid = Grid(np.array([point[0], point[0] + 1]), np.array([point[1], point[1] + 1]), 1.0)
    found = grid.deposit(points, weights)[0, 0, 0]
    offset = np.array(point) - start[0]
    expected = analytic.gaussian_on_segment(*offset, *(end - start)[0], 1.0)
    assert found == pytest.approx(expected, abs=1e-6 / (2 * math.pi))


# Exact sums


def test_integral_of_the_stress_is_the_virial_sum(flow):
    """Over the whole plane, to rounding: kernels and quadrature weights sum to one; the grid's
    sum over a Gaussian of two grid steps is off by exp(-8 pi^2), its rim by 1e-9."""
    field = stress_of([flow])
    expected = virial(flow)
    np.testing.assert_allclose(
        field.grid.integral(field.contact), expected, rtol=0, atol=1e-8 * np.abs(expected).max()
    )


def test_virial_of_two_pressed_particles():
    """Two blocks pressed face to face with F: - f (x) b adds up to F times the distance of their
    centroids, along the normal; no other component but rounding."""
    silo = hopper(0.0, 0.1, 0.1, 0.2, "wide")
    force, distance = 3.0, 0.01
    scene = scene_of([BLOCK], [0, 0], silo, np.zeros(2), np.array([0.05, 0.05 + distance]))
    points = [[x, 0.055] for x in (-8e-3, 1e-3)]
    moment = moment_of(
        scene, {"bodies": [[0, 1]] * 2, "point": points, "force": [[0.0, force / 2]] * 2}
    )
    np.testing.assert_allclose(virial(moment), [[0, 0], [0, force * distance]], atol=1e-15)


def spectral_divergence(grid, stress):
    """d stress_ab/d x_b (2, j, i) by Fourier: exact for fields that end within the grid."""
    kx = 2j * np.pi * np.fft.fftfreq(len(grid.x), grid.x[1] - grid.x[0])
    ky = 2j * np.pi * np.fft.fftfreq(len(grid.y), grid.y[1] - grid.y[0])
    found = np.fft.fft2(stress)
    return np.fft.ifft2(found[:, 0] * kx + found[:, 1] * ky[:, None]).real


def test_balance_of_momentum_at_every_point(flow):
    """sum (contact forces on particle i) phi(r - x_i) = - div sigma + what walls push back: the
    forces and the weight are the mass times the acceleration (tests of contacts), so this is
    rho a = rho g - div sigma + walls. Spectral derivatives of a Gaussian on a grid of half its
    width are good to exp(-2 pi^2) = 3e-9 of it, the quadrature to 1e-6."""
    scene, walls = flow.scene, flow.at_wall
    low, high = flow.centres.min(axis=0), flow.centres.max(axis=0)
    grid = grid_round(low - 0.01, high + 0.01, 10e-3)
    on_particle = np.zeros((scene.n_particles, 2))
    np.add.at(on_particle, flow.bodies[:, 0], -flow.force)
    np.add.at(on_particle, flow.bodies[~walls, 1], flow.force[~walls])
    gained = grid.deposit(flow.centres, on_particle)
    push = grid.deposit(flow.point[walls], -flow.force[walls])
    divergence = spectral_divergence(grid, contact_stress(flow, grid))
    scale = max(np.abs(part).max() for part in (gained, push, divergence))
    np.testing.assert_allclose(gained, push - divergence, rtol=0, atol=2e-6 * scale)
    assert np.abs(gained).max() > 0.01 * scale


def test_kinetic_stress_of_two_streams():
    """Particles of velocities +u and -u at one place: rho u^2 in this direction and none across;
    of one common velocity: nothing, whatever it is."""
    silo = hopper(0.0, 0.1, 0.1, 0.2, "wide")
    x, y = np.zeros(2), np.full(2, 0.05)
    streams = scene_of([BLOCK], [0, 0], silo, x, y, vx=np.array([2.0, -2.0]), vy=7.0)
    grid = grid_round(np.array([-0.01, 0.04]), np.array([0.01, 0.06]), 10e-3)
    mass, place, _ = moving(streams, 0)
    density = grid.deposit(place, mass[:, None])[0]
    found = kinetic_stress(streams, 0, grid)
    np.testing.assert_allclose(found[0, 0], 4 * density, rtol=1e-9)
    for other in (found[0, 1], found[1, 0], found[1, 1]):
        np.testing.assert_allclose(other, 0, atol=1e-9 * (4 * density).max())


# Columns


def test_stress_of_a_column_of_blocks(pile):
    """The stress sigma_yy over the width is the weight above: integrated over x at each height y
    it is sum m g Phi((y_i - y)/w), the weight of the blocks above, smoothed as they are. Above
    six widths of the floor, where its push is spread. Settled to 1e-3 of the column."""
    grid = grid_round(np.array([-0.02, 0.0]), np.array([0.02, 0.08]), 3e-3)
    across = contact_stress(pile, grid).sum(axis=-1) * (grid.x[1] - grid.x[0])
    above = grid.y > 6 * grid.width
    expected = [
        sum(0.5 * WEIGHT * math.erfc((y - centre) / (math.sqrt(2) * grid.width))
            for centre in pile.centres[:, 1])
        for y in grid.y[above]
    ]  # fmt: skip
    np.testing.assert_allclose(across[1, 1, above], expected, atol=2e-3 * N * WEIGHT)
    assert expected[0] > 5 * WEIGHT
    # Nothing presses the column from its sides.
    np.testing.assert_allclose(across[0, :, above], 0, atol=2e-3 * N * WEIGHT)


def test_a_frictionless_column_is_hydrostatic():
    """Blocks that press both walls (0.5 um too wide for the gap) without friction: the walls bear
    nothing, the stress is the weight above in every slab, and Janssen's law is the straight line.
    Settled to 1e-3 of the column."""
    frictionless = STICKY._replace(mu=0.0)
    moment = column(20e-3 - 0.5e-6, frictionless)
    found = janssen.column([moment])
    total = N * WEIGHT / found.width
    np.testing.assert_allclose(found.vertical, found.weight, rtol=0, atol=2e-3 * total)
    # Slabs that end at half a block hold half of its mass: centroids, as they come.
    assert found.stress_ratio > 0.1
    np.testing.assert_allclose(found.shear, 0, atol=1e-3 * total)
    np.testing.assert_allclose(found.janssen(), found.weight, rtol=1e-2)


def test_friction_of_the_walls_carries_what_is_missing():
    """With friction, in a slab from its top down: weight above less what the walls bear above,
    both walls together, is the stress. An identity of static equilibrium, settled to 1e-3."""
    moment = column(20e-3 - 2e-6, STICKY)
    found = janssen.column([moment])
    thick = found.height[0] - found.height[1]
    borne = 2 * np.cumsum(found.shear) * thick / found.width
    total = N * WEIGHT / found.width
    missing = found.weight - found.vertical
    between = np.concatenate([[0.0], borne])
    assert (missing > between[:-1] - 3e-3 * total).all()
    assert (missing < between[1:] + 3e-3 * total).all()
    assert missing[-1] > 0.2 * total


@pytest.mark.parametrize(("share", "words"), [(1.62, "62 % more"), (0.85, "15 % less")])
def test_what_the_lowest_slab_carries_in_words(share, words):
    """In a flow it may carry more than rests on it: of an excess it is not said to be less."""
    weight = np.array([50.0, 100.0])
    found = janssen.Column(np.array([0.2, 0.1]), share * weight, weight, weight, 0.3 * weight,
                           500.0, 0.3, weight[None], (0.25, 0.25))  # fmt: skip
    assert janssen._in_words(found) == f"lowest slab carries {words} than the weight above"


def slices(mu: float, ratio: float, n: int = 420, top: float = 0.42):
    """Slabs across a gap 100 mm wide, each resting on the next, that press both walls with ratio
    times what presses them and hang on them with mu times that: Janssen's assumptions."""
    silo = hopper(0.0, 0.1, 0.1, 0.45, "slices")
    thick = 1e-3
    slab = scenes.block(0.1 - 1e-9, 4e-3)
    y = top - thick * np.arange(n)
    scene = scene_of([slab], np.zeros(n, int), silo, np.zeros(n), y)
    weight = GRAVITY * scene.trajectory.static["mass"][0]
    bodies, points, forces, below = [], [], [], 0.0
    for k in range(n):
        # Half of a slab's own weight presses its walls, the mean of top and bottom.
        pressing = ratio * (below + weight / 2) / 0.1 * thick
        for wall, side in ((n, 1), (n + 1, -1)):
            bodies.append([k, wall])
            points.append([0.05 * side, y[k]])
            forces.append([side * pressing, -mu * pressing])
        below += weight - 2 * mu * pressing
        other = k + 1 if k + 1 < n else n + 2  # the last lies on the door
        bodies.append([k, other])
        points.append([0.0, y[k] - thick / 2 if k + 1 < n else 0.0])
        forces.append([0.0, -below])
    return moment_of(scene, {"bodies": bodies, "point": points, "force": forces})


@pytest.mark.parametrize(("mu", "ratio"), [(0.44, 0.6), (0.2, 0.4), (0.0, 0.7)])
def test_slices_that_obey_janssen_are_measured_so(mu, ratio):
    """K and mobilised friction fall out as they were put in, and the stress is the closed form,
    but for slices of 1 mm where it takes thin ones: 1 % of the stress at the bottom."""
    found = janssen.column([slices(mu, ratio)])
    assert found.friction == pytest.approx(mu, abs=1e-9)
    assert found.stress_ratio == pytest.approx(ratio, rel=0.02)
    depth = found.weight / found.density
    expected = analytic.janssen(depth, found.density, mu, ratio, 0.1)
    np.testing.assert_allclose(found.vertical, expected, atol=0.01 * expected.max())
    np.testing.assert_allclose(found.janssen(), expected, atol=0.02 * expected.max())


def test_law_sinks_with_the_fill():
    """Two moments, filled to 0.42 m and to 0.22 m: the law is the mean of both laws at the depths
    of each, which the mean of the stresses follows; at the mean depth it would be too large."""
    moments = [slices(0.44, 0.6), slices(0.44, 0.6, 220, 0.22)]
    found = janssen.column(moments)
    assert found.fill == pytest.approx((0.42, 0.22), abs=2e-3)
    depths = np.maximum(np.array([[0.42], [0.22]]) - found.height, 0.0)
    laws = analytic.janssen(depths, found.density, 0.44, 0.6, 0.1)
    low = found.height < 0.2
    np.testing.assert_allclose(found.janssen()[low], laws.mean(axis=0)[low], rtol=0.02)
    np.testing.assert_allclose(found.vertical[low], laws.mean(axis=0)[low], rtol=0.02)
    at_mean = analytic.janssen(depths.mean(axis=0), found.density, 0.44, 0.6, 0.1)
    assert (at_mean / found.janssen() - 1)[low].max() > 0.05


@given(st.floats(0.01, 1), st.floats(0.1, 1), st.floats(0.01, 1))
def test_janssen_stress_is_the_closed_form(mu, ratio, width):
    """And its slope obeys d sigma/dz = rho g - 2 mu K sigma/W."""
    depth = np.linspace(0, 2, 401)
    found = janssen.janssen_stress(depth, 460.0, mu * ratio, width)
    expected = analytic.janssen(depth, 460.0, mu, ratio, width)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)
    middle = (found[1:] + found[:-1]) / 2
    step = depth[1]
    slope = 460.0 - 2 * mu * ratio / width * middle
    # The trapezium is off by step^2/12 times the third derivative, 460 (2 mu K/W)^2.
    error = step**2 / 12 * 460.0 * (2 * mu * ratio / width) ** 2
    np.testing.assert_allclose(np.diff(found) / step, slope, atol=2 * error + 1e-6)


def test_tractions_add_up_to_the_forces_on_the_walls(flow):
    """Pressure and shear times the lengths of the stretches: the wall's force, to rounding."""
    scene, walls = flow.scene, flow.scene.walls
    total = np.zeros((len(walls) + 1, 2))
    np.add.at(total, flow.bodies[flow.at_wall, 1] - scene.n_particles, flow.force[flow.at_wall])
    for k, found in enumerate(tractions([flow])):
        along = (walls[k, 1] - walls[k, 0]) / np.hypot(*(walls[k, 1] - walls[k, 0]))
        out = np.array([along[1], -along[0]])
        assert found.normal.sum() * found.length == pytest.approx(total[k] @ out, abs=1e-9)
        shear = found.shear.sum() * found.length
        assert abs(shear) == pytest.approx(abs(total[k] @ along), abs=1e-9)


@pytest.mark.parametrize("what", ["stress", "janssen", "network"])
def test_measures_give_results_and_figures(reference, tmp_path, what):
    """On a whole run: numbers for the opening and the flow, in N/m and in pascals."""
    import shutil

    folder = shutil.copytree(reference.path, tmp_path / "run")
    result = silo2d("observe", folder, what)
    assert result.code == 0, result.err
    assert "before_opening" in result.out
    assert (folder / "figures" / f"{what}.png").stat().st_size > 20_000
