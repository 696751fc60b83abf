"""Filling: random starts without overlaps, beds that carry their weight, the same bits per seed."""

import math

import numpy as np
import pytest
from damper_runs import small
from refusals import assert_refused
from scipy.spatial.distance import pdist
from small_damper import damper3d

from damper3d.case.case import GRAVITY
from damper3d.engine.enclosures import box, cylinder
from damper3d.engine.enclosures.polyhedron import Polyhedron
from damper3d.engine.growth import spheres
from damper3d.engine.growth.spheres import cells_over, grow, push_pairs
from damper3d.run import packing as packing_module
from damper3d.run.fill import fill, random_start, resting
from damper3d.run.packing import packing_folder, packing_fraction
from damper3d.studies.pack.shaken import shake_down
from granulab.errors import InputError

RADIUS = 2.5e-3
UP = np.array([0.0, 0.0, 1.0])
SIDEWAYS = np.array([1.0, 0.0, 0.0])


def _silent(stage: str, fraction: float, text: str) -> None: ...


# The random start


@pytest.mark.parametrize(
    ("enclosure", "count"),
    [
        (cylinder(0.04, 0.04), 358),  # the thesis's 0.466
        (cylinder(0.04, 0.04), 384),  # 0.500
        (box(0.05, 0.04, 0.03), 480),  # 0.524
        (cylinder(0.04, 0.04), 3),
        (box(0.005001, 0.005001, 0.1), 15),  # a column, one above the other
    ],
)
def test_the_random_start_has_no_overlap(enclosure, count):
    """Centres at least a diameter apart, and a radius from every wall."""
    centres, reached = grow(enclosure, count, RADIUS, np.random.default_rng(1))
    assert reached == 1.0
    assert pdist(centres).min() >= 2 * RADIUS
    planes = enclosure.planes
    assert (centres @ planes[:, :3].T - planes[:, 3]).min() >= RADIUS
    if enclosure.cylinder_radius:
        assert np.hypot(centres[:, 0], centres[:, 1]).max() <= enclosure.cylinder_radius - RADIUS


def test_a_cube_of_ten_diameters_is_filled_to_0_56():
    """Walls keep order from a layer each: 0.60 is reached in a cube of twenty diameters."""
    enclosure = box(20 * RADIUS, 20 * RADIUS, 20 * RADIUS)
    count = round(0.56 * enclosure.volume / (4 / 3 * math.pi * RADIUS**3))
    centres, reached = grow(enclosure, count, RADIUS, np.random.default_rng(2))
    assert reached == 1.0
    assert pdist(centres).min() >= 2 * RADIUS


def test_cells_over_few_spheres_that_are_far_apart_are_few():
    """1 mm over 4 m are 6.4e10 cells; spheres that lie closer have cells of their size."""
    rng = np.random.default_rng(1)
    size, shape, _ = cells_over(rng.uniform(0.0, 4.0, (100, 3)), 1e-3)
    assert np.prod(shape) < 1.1e6
    assert size > 1e-3
    assert cells_over(rng.uniform(0.0, 0.04, (100, 3)), 1e-3)[0] == 1e-3


def test_the_search_in_cells_finds_all_overlaps():
    """Against all pairs, at random places, many of them overlapping."""
    rng = np.random.default_rng(4)
    centres = rng.uniform(0, 0.03, size=(80, 3))
    force = np.zeros((80, 3))
    deepest = push_pairs(centres, RADIUS, force)
    expected = np.zeros((80, 3))
    for i in range(80):
        for j in range(80):
            gap = centres[i] - centres[j]
            distance = np.linalg.norm(gap)
            if 0 < distance < 2 * RADIUS:
                expected[i] += (2 * RADIUS - distance) * gap / distance
    np.testing.assert_allclose(force, expected, atol=1e-15)
    assert deepest == pytest.approx(2 * RADIUS - pdist(centres).min())


def test_a_ball_that_hardly_fits_into_a_pointed_void_is_placed():
    """Nearly the sphere that touches all four faces of a slender tetrahedron: it grows into it."""
    void = Polyhedron(((0.0, 0.0, 0.0), (0.04, 0.0, 0.0), (0.0, 0.04, 0.0), (0.0, 0.0, 0.2)))
    radius = 0.4975 * void.narrowest
    centre, reached = grow(void, 1, radius, np.random.default_rng(1))
    assert reached == 1.0
    assert void.clearance(centre).min() > radius * (1.0 - 1e-9)


def test_the_random_start_comes_from_the_seed_alone():
    first, again, other = (random_start(small(run__seed=seed), 20)[0] for seed in (1, 1, 2))
    assert first.tobytes() == again.tobytes()
    assert abs(first - other).max() > RADIUS


def test_the_random_start_is_spread_over_the_enclosure():
    """Mean of n uniform centres: within four standard errors, L/sqrt(12 n), of the middle."""
    count, enclosure = 150, box(0.05, 0.04, 0.03)
    centres, _ = grow(enclosure, count, RADIUS, np.random.default_rng(3))
    room = np.array([0.05, 0.04, 0.03]) - 2 * RADIUS
    error = np.abs(centres.mean(axis=0) - [0, 0, 0.015]) / (room / math.sqrt(12 * count))
    assert error.max() < 4


def test_spheres_of_a_large_start_are_numbered_by_where_they_are(monkeypatch):
    """From the same points of the seed, column by column: neighbours in number are near."""
    columns = {}
    for most in (10, 1000):
        monkeypatch.setattr(spheres, "_MANY", most)
        enclosure = box(0.1, 0.1, 0.03)
        centres, _ = grow(enclosure, 500, RADIUS, np.random.default_rng(3))
        assert pdist(centres).min() >= 2 * RADIUS
        columns[most] = np.linalg.norm(np.diff(centres[:, :2], axis=0), axis=1).mean()
    assert columns[10] < 0.25 * columns[1000]
    points = np.random.default_rng(1).uniform(-0.05, 0.05, size=(300, 3))
    numbered = spheres.in_columns(points, 0.01)
    assert sorted(map(tuple, numbered)) == sorted(map(tuple, points))
    places = np.column_stack([np.floor(numbered[:, :2] / 0.01), numbered[:, 2]])
    assert np.array_equal(np.lexsort(places[:, ::-1].T), np.arange(300))


def test_too_many_particles_are_refused_with_the_number_that_fits(tmp_path):
    """Below random close packing of an endless bed, but not with these walls: one line, code 2."""
    with pytest.raises(InputError, match=r"count = 58: fill ratio 0\.604; .* about \d\d; give"):
        fill(small(particles__count=58), _silent)
    result = damper3d("run", "--diameter", "20 mm", "--height", "20 mm", "--count", 58,
                      "-o", tmp_path, "--quiet")  # fmt: skip
    assert_refused(result, "count = 58")


# The settled bed


@pytest.fixture(scope="module")
def bed():
    """The small damper's bed."""
    return fill(small(), _silent)


def _again(case, bed):
    """A simulation that goes on from a packing, under the gravity that it settled under."""
    sim = resting(case, bed.state["position"][:, :3])
    sim.restore(bed.state)
    return sim


@pytest.mark.parametrize(
    ("orientation", "down"), [("vertical", -UP), ("horizontal", -SIDEWAYS), ("none", -UP)]
)
def test_the_settled_bed_presses_with_its_weight(orientation, down):
    """Forces on all walls add up to m (g - dv/dt) over 6 ms, v the mean velocity of the bed.

    The bed in the upright enclosure is at rest, but for a sphere that may roll about on the floor,
    which nothing brakes; in the lying one several do, along its lowest line.
    """
    case = small(motion__orientation=orientation)
    bed = fill(case, _silent)
    sim = _again(case, bed)
    before, begun = sim.sample()["mean_velocity"][0], sim.time
    sim.steps_per_sample = 1000  # of 2 us
    samples = sim.run(3)
    force = samples["wall_force"].mean(axis=0).sum(axis=0)
    slowing = (samples["mean_velocity"][-1] - before) / (sim.time - begun)
    weight = case.mass * GRAVITY
    # Velocities are extrapolated by half a step of 3000: an impact of 10 g at an end is 1.7e-3.
    np.testing.assert_allclose(force, weight * down - case.mass * slowing, atol=2e-3 * weight)
    if orientation != "horizontal":
        speeds = np.linalg.norm(bed.state["velocity_now"][:, :3], axis=1)
        assert np.median(speeds) < 1e-3
    lower = bed.state["position"][:, :3] @ -down - case.enclosure.lowest(-down)
    assert RADIUS * 0.999 < lower.min() < RADIUS * 1.02
    assert lower.max() + RADIUS == pytest.approx(bed.height)


def test_no_overlap_of_the_settled_bed_is_deeper_than_its_weight_explains(bed):
    """The whole weight on one contact presses K d^1.5 = M g, K = (4/3) E sqrt(R) (eq. 5.5)."""
    case = small()
    contacts = _again(case, bed).contacts()
    hertz = case.pair_law.hertz * math.sqrt(RADIUS / 2)
    deepest = (case.mass * GRAVITY / hertz) ** (2 / 3)
    assert 0 < contacts["overlap"].max() < deepest


def test_the_bed_is_counted_as_a_packing(bed):
    """Loose, small and with walls all round: between loose and close, and held on all sides.

    A particle at rest under friction needs at least two contacts; kissing spheres have twelve.
    """
    assert 0.35 < bed.fraction < 0.64
    assert 2.0 < bed.coordination < 7.0
    assert 4 * RADIUS < bed.height < 0.015


def _sideways(sim):
    """Largest tangential part of a contact's force over its size, to the digits of a normal."""
    contacts = sim.contacts()
    along = np.einsum("nx,nx->n", contacts["force"], contacts["normal"])
    across = np.linalg.norm(contacts["force"] - along[:, None] * contacts["normal"], axis=1)
    return round(float((across / np.abs(along)).max()), 6)


@pytest.mark.parametrize("changes", [
    {}, {"particles__shape": "prolate:1.5", "particles__equal_volume_radius": "2.5 mm"},
])  # fmt: skip
def test_without_friction_nothing_holds_sideways_and_the_bed_lies_closer(changes):
    """Coulomb's limit, mu times the normal force, is zero meanwhile, and the case's afterwards."""
    slippery = small(fill__friction=False, **changes)
    loose, close = (fill(case, _silent) for case in (small(**changes), slippery))
    assert close.fraction > loose.fraction
    assert _sideways(_again(slippery.settling, close)) == 0.0
    assert _sideways(_again(small(**changes), loose)) > 1e-3
    assert slippery.pair_law.mu == small(**changes).pair_law.mu > 0.0
    assert slippery.settling.pair_law.mu == slippery.settling.wall_law.mu == 0.0


def test_the_same_seed_settles_to_the_same_bits(bed):
    again = fill(small(), _silent)
    for name, array in bed.state.items():
        assert array.tobytes() == again.state[name].tobytes(), name


def test_a_packing_is_named_by_what_acts_before_the_motion_alone(tmp_path):
    """All points of a map share it; so do vertical and weightless beds, which settle alike."""
    own = packing_folder(small(), tmp_path)
    for same in (
        {"motion__frequency": 33}, {"motion__gamma": 1.5}, {"motion__orientation": "none"},
        {"run__cycles": 50}, {"output__frames": 0}, {"motion__ramp": 2},
    ):  # fmt: skip
        assert packing_folder(small(**same), tmp_path) == own, same
    for other in (
        {"run__seed": 2}, {"particles__count": 21}, {"law__friction": 0.3},
        {"motion__orientation": "horizontal"}, {"enclosure__height": "21 mm"},
        {"fill__settle_time": "151 ms"}, {"run__time_step": "1 us"},
    ):  # fmt: skip
        assert packing_folder(small(**other), tmp_path) != own, other


# Its measures


@pytest.mark.parametrize("level", [3e-3, 20e-3, 31e-3])
def test_volume_below_a_level_is_the_closed_form(level):
    """Upright pi R^2 h; lying, a segment R^2 (acos t - t sqrt(1 - t^2)), t = 1 - h/R, times L.

    Of the 64 cells a side those that the round wall cuts count by a part, as if it were flat.
    """
    own, r = cylinder(0.04, 0.05), 0.02
    assert own.volume_below(UP, level) == pytest.approx(math.pi * r**2 * level, rel=5e-4)
    t = 1 - level / r
    segment = r**2 * (math.acos(t) - t * math.sqrt(1 - t * t)) * 0.05
    assert own.volume_below(SIDEWAYS, level - r) == pytest.approx(segment, rel=3e-3)
    assert box(0.04, 0.03, 0.05).volume_below(UP, level) == pytest.approx(1.2e-3 * level, rel=1e-12)


def test_lowest_point_of_an_enclosure_in_any_orientation():
    tilted = np.array([0.6, 0.0, 0.8])
    assert cylinder(0.04, 0.05).lowest(UP) == 0.0
    assert cylinder(0.04, 0.05).lowest(-UP) == -0.05
    assert cylinder(0.04, 0.05).lowest(SIDEWAYS) == -0.02
    assert cylinder(0.04, 0.05).lowest(tilted) == pytest.approx(-0.012)
    assert box(0.04, 0.06, 0.05).lowest(np.array([0.0, 1.0, 0.0])) == -0.03


def test_a_cubic_lattice_has_a_packing_fraction_of_pi_over_six(monkeypatch):
    """8 x 8 x 8 spheres that fill a box; the level lies between two layers."""
    monkeypatch.setattr(packing_module, "_INNER", 0.75)
    side = 8 * 2 * RADIUS
    line = (np.arange(8) + 0.5) * 2 * RADIUS
    grid = np.stack(np.meshgrid(line - side / 2, line - side / 2, line), axis=-1).reshape(-1, 3)
    own = box(side, side, side)
    found = packing_fraction(grid, 4 / 3 * math.pi * RADIUS**3, own, UP)
    assert found == pytest.approx(math.pi / 6, rel=1e-12)


def test_a_bed_shaken_down_is_denser_and_at_rest():
    """Sustained vibration packs a poured bed (thesis [206, 207]); 30 spheres, two layers deep."""
    case = small(particles__count=30, law__youngs_modulus="0.1 GPa", run__time_step="8 us")
    bed = shake_down(case)
    assert bed.loose < bed.close < 0.74  # no packing of spheres is denser than the face-centred
    assert bed.rms_speed < 0.01
