"""Spheres in triangulated cavities: seams, edges, corners, energy, histories, a run, and its cost.

The reference is the same room between planes, or the exact cylinder.
"""

import numpy as np
import pytest
from damper_beds import DENSITY, DOWN, LARGEST, NOWHERE, SHAKEN, STILL, acrylic, at_rest
from damper_runs import CASE
from made_cavities import box_of, cavity_of, ell, prism_of, round_rim, write_stl

from damper3d import DamperCase, run
from damper3d.engine.enclosures import Enclosure, box
from damper3d.engine.growth.spheres import grow
from damper3d.engine.simulation import Simulation
from damper3d.engine.world import build_world

SIZE, HEIGHT = 0.04, 0.02
WALL = "particle_wall"


def bed(room: Enclosure, places, velocity, spin=None, *, law=None, gravity=DOWN, shaker=STILL):
    """Spheres of LARGEST at places (n, 3) in a room, with velocities and spins (n, 3)."""
    law = law or acrylic()
    places = np.atleast_2d(places)
    sim = Simulation(
        build_world(
            places, np.full(len(places), LARGEST), density=DENSITY, enclosure=room, pair_law=law,
            wall_law=law, shaker=shaker, direction=np.array([0.0, 0.0, 1.0]),
            gravity=np.array(gravity), time_step=1e-6,
        )
    )  # fmt: skip
    sim.set_velocity(np.atleast_2d(velocity), None if spin is None else np.atleast_2d(spin))
    return sim


def energy(sim: Simulation) -> float:
    """Kinetic, potential and elastic [J]."""
    row = sim.sample()
    names = ("kinetic", "potential", "elastic_normal", "elastic_tangential")
    return float(sum(row[name][0] for name in names))


def in_contact(sim: Simulation) -> int:
    return len(sim.contacts()["bodies"])


def rolling(room: Enclosure, law) -> Simulation:
    """A ball that rolls without slip across the floor, aslant to its sides, for 40 ms."""
    u, w = 0.24, 0.18  # [m/s]
    start = (-0.012, -0.011, at_rest(law))
    sim = bed(room, start, (u, w, 0.0), np.array([-w, u, 0.0]) / LARGEST, law=law)
    sim.step(40_000)
    return sim


@pytest.mark.parametrize(("across", "jitter"), [(1, 0.0), (10, 0.0), (16, 0.6)])
def test_a_ball_rolls_over_the_seams_as_on_a_plane(across, jitter):
    """It crosses up to some forty seams; position, velocity and spin are those on a plane.

    Rounding alone differs: a unit in the last place of a foot per step, 4e4 of them.
    """
    law = acrylic(0.5)
    plane = rolling(box(SIZE, SIZE, HEIGHT), law).frame()
    seams = rolling(cavity_of(box_of(SIZE, HEIGHT, across, jitter)), law)
    for name in ("x", "v", "spin"):
        size = np.abs(plane[name]).max()
        np.testing.assert_allclose(seams.frame()[name], plane[name], rtol=0, atol=1e-9 * size)
    assert in_contact(seams) == 1


def test_a_ball_that_slides_keeps_its_springs_over_the_seams():
    """Pushed without spin it slides, then rolls, as on a plane: friction's work is that of one."""
    law = acrylic(0.5)
    found = []
    for room in (box(SIZE, SIZE, HEIGHT), cavity_of(box_of(SIZE, HEIGHT, 16, 0.6))):
        sim = bed(room, (-0.012, -0.011, at_rest(law)), (0.3, 0.2, 0.0), law=law)
        sim.step(20_000)
        row = sim.sample()
        found.append([row[f"friction_{WALL}"][0], row[f"tangential_damping_{WALL}"][0]])
    assert found[0][0] > 0.0
    np.testing.assert_allclose(found[1], found[0], rtol=1e-6)


def test_a_ball_in_a_concave_edge_touches_two_faces_and_three_in_a_corner():
    """Pressed there by gravity along the bisector it holds still on two, or three, contacts."""
    room = cavity_of(box_of(SIZE, HEIGHT, 4, 0.3))
    low, law = -0.5 * SIZE + LARGEST, acrylic(0.0, 0.5)
    for place, gravity, contacts in (
        ((0.0013, low, LARGEST), (0.0, -6.9, -6.9), 2),
        ((low, low, LARGEST), (-5.7, -5.7, -5.7), 3),
    ):
        sim = bed(room, np.array(place) + 2e-7, (0.0, 0.0, 0.0), law=law, gravity=gravity)
        sim.step(20_000)
        found = sim.contacts()
        assert len(found["bodies"]) == contacts
        normals = found["normal"]
        np.testing.assert_allclose(normals @ normals.T, np.eye(contacts), atol=1e-9)


L = cavity_of(prism_of(ell(SIZE, 0.5 * SIZE), HEIGHT, (0.01, 0.01)))


@pytest.mark.parametrize("angle", [30.0, 45.0, 80.0])
def test_a_ball_strikes_a_convex_edge_once(angle):
    """Elastic and without friction: it is mirrored by the line from the edge to the centre at the
    contact; speed and angular momentum about the edge are kept, to the error of the step.
    """
    way = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle)), 0.0])
    aside = np.array([-way[1], way[0], 0.0])
    offset = 0.4 * LARGEST  # of its line from the edge, which stands at the origin
    start = -2.5 * LARGEST * way + offset * aside + (0.0, 0.0, 0.5 * HEIGHT)
    sim = bed(L, start, way, law=acrylic(0.0, 1.0), gravity=NOWHERE)
    before, most = energy(sim), 0
    for _ in range(50):
        sim.step(150)
        most = max(most, in_contact(sim))
    assert most <= 1
    x, v = sim.frame()["x"][0], sim.frame()["v"][0]
    assert energy(sim) == pytest.approx(before, rel=1e-3)
    assert x[0] * v[1] - x[1] * v[0] == pytest.approx(-offset, rel=1e-3)
    normal = np.sqrt(1.0 - 0.4**2) * way[:2] - 0.4 * aside[:2]  # at first touch
    # Pressed in, the edge is nearer by some 1 % of the radius, and the normal turned by as much.
    np.testing.assert_allclose(v[:2], way[:2] - 2.0 * (way[:2] @ normal) * normal, atol=0.03)


def test_a_ball_rolls_over_a_convex_edge_and_falls():
    """Over the rim of a step: floor, edge, and then the air: its energy is kept all the way."""
    lying = prism_of(ell(SIZE, 0.5 * SIZE), HEIGHT, (0.01, 0.01))
    stands = lying[:, :, [2, 0, 1]] * (1.0, -1.0, -1.0)  # its step half way up, where y < 0
    law, step = acrylic(0.0, 1.0), 0.5 * SIZE
    start = (0.0, -0.004, step + at_rest(law))
    sim = bed(cavity_of(stands), start, (0.0, 0.25, 0.0), law=law)
    before, low = energy(sim), step + LARGEST
    contacts = set()
    for _ in range(120):
        sim.step(500)
        contacts.add(in_contact(sim))
        low = min(low, sim.frame()["x"][0, 2])
    assert low < step
    assert contacts <= {0, 1}
    assert energy(sim) == pytest.approx(before, rel=2e-3)


@pytest.mark.parametrize("sides", [8, 12, 24, 96])
def test_a_ball_in_a_prism_keeps_its_energy(sides):
    """Between faces that turn by 45 to 4 degrees: never more contacts than the two of an edge, and
    no elastic energy that vanishes with a contact. A millisecond is some ten impacts.
    """
    room = cavity_of(prism_of(round_rim(0.02, sides), HEIGHT))
    sim = bed(room, (0.003, 0.001, 0.01), (1.0, 0.7, 0.1), law=acrylic(0.0, 1.0), gravity=NOWHERE)
    before = energy(sim)
    for _ in range(40):
        sim.step(2000)
        assert in_contact(sim) <= 2
        assert energy(sim) == pytest.approx(before, rel=0.01)  # steps of 1 us leave so much


def test_the_balance_closes_with_friction_and_damping():
    """What is lost is what the mechanisms take, as in a room between planes."""
    room = cavity_of(prism_of(round_rim(0.02, 24), HEIGHT))
    sim = bed(room, (0.003, 0.001, 0.01), (1.0, 0.7, 0.1), gravity=(0.0, -9.81, 0.0))
    before = energy(sim)
    sim.step(100_000)
    row = sim.sample()
    mechanisms = ("normal_damping", "tangential_damping", "friction")
    lost = sum(float(row[f"{name}_{WALL}"][0]) for name in mechanisms)
    lost -= float(row[f"law_term_{WALL}"][0])
    assert lost > 0.5 * before
    assert energy(sim) + lost == pytest.approx(before, abs=0.005 * lost)


def shaken(room: Enclosure) -> Simulation:
    """Two dozen spheres in a room that is shaken at 0.78 m/s."""
    rng = np.random.default_rng(7)
    centres, reached = grow(room, 24, LARGEST, rng)
    assert reached == 1.0
    gravity = (0.0, 0.0, -490.0)  # they are at the walls soon
    return bed(room, centres, 0.3 * rng.normal(size=(24, 3)), shaker=SHAKEN, gravity=gravity)


ROUND = cavity_of(prism_of(round_rim(0.02, 48), HEIGHT))


@pytest.mark.parametrize("room", [ROUND, L], ids=["prism", "L"])
def test_a_random_start_has_no_overlap_and_is_inside(room):
    centres, reached = grow(room, 30, LARGEST, np.random.default_rng(1))
    assert reached == 1.0
    assert room.clearance(centres).min() >= (1.0 - 1e-9) * LARGEST
    apart = np.linalg.norm(centres[:, None] - centres, axis=2)[np.triu_indices(30, 1)]
    assert apart.min() >= 2.0 * (1.0 - 1e-9) * LARGEST


@pytest.mark.parametrize("room", [ROUND, L], ids=["prism", "L"])
def test_no_bit_depends_on_when_lists_are_made_or_the_state_is_kept(room):
    """Saved and restored into a new world, looked at and searched at odd times: the same bits."""
    undisturbed, other = shaken(room), shaken(room)
    undisturbed.step(12_000)
    for _ in range(5):
        other.step(1199)
        other.contacts()
        other.sample()
        other.world.counts[[4, 5]] = 1  # STALE_INNER, STALE_WALL
    saved = other.save()
    resumed = shaken(room)
    resumed.restore(saved)
    resumed.step(12_000 - 5 * 1199)
    assert len(saved["wall_pairs"]) > 0
    assert resumed.state_digest() == undisturbed.state_digest()


def test_spheres_stay_inside():
    sim = shaken(L)
    for _ in range(20):
        sim.step(1000)
        assert L.clearance(sim.frame()["x"]).min() > 0.97 * LARGEST


def stl_case(tmp_path, sides: int, **changes) -> DamperCase:
    """The small case of twenty spheres with a prism of its cylinder's volume, from a file."""
    path = write_stl(tmp_path / f"{sides}.stl", 1e3 * prism_of(round_rim(0.02, sides), 0.02))
    keys = {key: value for key, value in CASE.items() if not key.startswith("enclosure.")}
    own = {"enclosure.shape": "cavity", "enclosure.file": str(path), "enclosure.unit": "mm"}
    return DamperCase.load("thesis", keys | own | changes)


def test_a_cavity_runs_from_its_file_and_is_drawn(tmp_path):
    """With its frames exported and drawn; the bed is as high as in the exact cylinder."""
    from damper3d.view.export import export
    from damper3d.view.picture import make_figures

    case = stl_case(tmp_path, 48, **{"run.cycles": 2})
    result = run(case, out=tmp_path / "runs")
    assert abs(result.energy_closure) < 0.01
    assert result.efficiency_with_settling > 0.0
    folder = result.run_folder
    assert [path.name for path in make_figures(folder, film=False)] == [
        "cycle.png", "energy.png", "motion.png",
    ]  # fmt: skip
    assert [path.name for path in export(folder, "vtkhdf")] == [
        "particles.vtkhdf",
        "enclosure.vtkhdf",
    ]


@pytest.mark.validation
@pytest.mark.parametrize("orientation", ["vertical", "none"])
def test_a_full_cylinder_from_triangles_damps_as_the_exact_one(orientation, tmp_path):
    """Means of eight packings; their difference within three standard errors of it."""
    means, variances = [], []
    for make in (lambda **c: DamperCase.load("thesis", CASE | c),
                 lambda **c: stl_case(tmp_path, 96, **c)):  # fmt: skip
        found = []
        for seed in range(1, 9):
            changes = {"run.seed": seed, "run.cycles": 12, "run.discard": 2,
                       "motion.orientation": orientation,
                       # Without gravity nothing meets the ends below A = h/pi (eq. 6.11).
                       "motion.gamma": 10 if orientation == "vertical" else 100}  # fmt: skip
            result = run(make(**changes), out=tmp_path / "runs")
            found.append(result.efficiency_with_settling)
        means.append(np.mean(found))
        variances.append(np.var(found, ddof=1) / len(found))
    assert abs(means[1] - means[0]) < 3.0 * np.sqrt(sum(variances))
    assert np.sqrt(sum(variances)) < 0.1 * means[0]
