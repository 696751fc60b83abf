"""The page of a damper's run shows what the run folder holds, to the steps that it is packed in."""

import shutil

import numpy as np
import pytest
from fake_damper_run import OFFSETS, RADII, write_fake_damper_run
from read_page import Page, read_page
from refusals import assert_refused
from small_damper import damper3d

from damper3d.engine.enclosures import ENCLOSURES
from damper3d.view.player.contacts import Pairs, pressure
from damper3d.view.player.page import player_page
from damper3d.view.player.walls import edges_of, to_wall
from damper3d.view.scene import Scene, read_scene


def page_of(folder) -> tuple[Scene, Page]:
    return read_scene(folder), read_page(player_page(folder, 2.5e6)[0])


@pytest.fixture(scope="module")
def fake(tmp_path_factory) -> tuple[Scene, Page]:
    """Five cycles of 40 Hz and Gamma 20, eight frames each, without contacts."""
    return page_of(write_fake_damper_run(tmp_path_factory.mktemp("vertical")).path)


@pytest.fixture(scope="module")
def real(damper_reference) -> tuple[Scene, Page]:
    """Twenty spheres that were shaken, with their contacts."""
    return page_of(damper_reference.path)


def colour(page: Page, label: str) -> dict:
    (found,) = [one for one in page.data["colours"] if one["label"] == label]
    return found


@pytest.mark.parametrize("of", ["fake", "real"])
def test_particles_and_enclosure_stand_where_the_run_has_them(of, request):
    """Places to half of 2^-14 of the enclosure, its displacement to 2^-17 of its stroke."""
    scene, page = request.getfixturevalue(of)
    frames = range(len(scene.tables))
    position = np.array([scene.particles(k).position for k in frames]).reshape(len(frames), -1)
    error = np.abs(page.arrays["position"] - position).max()
    assert error <= 0.505 * scene.size.max() / 2**14
    shift = np.array([scene.shift(k) for k in frames])
    assert np.abs(page.arrays["shift"] - shift).max() <= np.ptp(shift) / 2**16
    np.testing.assert_allclose(page.arrays["radius"], scene.radius, rtol=1e-6)
    assert page.data["space"]["moves"]
    assert page.data["period"] == pytest.approx(scene.period)


@pytest.mark.parametrize("of", ["fake", "real"])
def test_velocities_and_dissipation_come_to_a_thousandth_of_their_scale(of, request):
    scene, page = request.getfixturevalue(of)
    particles = [scene.particles(k) for k in range(len(scene.tables))]
    along = np.array([p.velocity for p in particles]) @ scene.direction
    np.testing.assert_allclose(page.arrays["along"], along, atol=0.51e-3 * np.ptp(along))
    heat = np.array([p.dissipated for p in particles])
    scale = colour(page, "energy dissipated so far")
    np.testing.assert_allclose(page.arrays["heat"], heat - heat[0], atol=0.51e-3 * scale["high"])
    assert (colour(page, "velocity along the motion")["unit"], scale["unit"]) == ("m/s", "J")


def test_layers_are_counted_from_the_bottom_a_diameter_each(fake):
    """A lattice of four spheres above each other, 1.06 diameters apart: so many layers."""
    scene, page = fake
    height = scene.particles(0).position @ scene.view.up
    levels, of_level = np.unique(np.round(height, 6), return_inverse=True)
    layer, count = page.arrays["layer"], len(levels)
    assert colour(page, "layer at the start")["numbered"] == count
    np.testing.assert_array_equal(layer, of_level)


def test_contacts_are_the_stored_ones_and_reach_to_the_walls(real, damper_reference):
    """Sum of the forces' sizes as stored, to 0.6 %; from a centre to a wall is its radius, about.

    Spheres have one contact a pair, so that nothing cancels; overlaps are some 1e-3 of a radius.
    """
    from granulab.campaign.runs.trajectory import read_tables

    scene, page = real
    tables = read_tables(damper_reference.path, "contacts")
    stored = np.linalg.norm([tables.columns[f"force_{axis}"] for axis in "xyz"], axis=0)
    assert len(page.arrays["force"]) == len(stored)
    assert page.arrays["force"].sum() == pytest.approx(stored.sum(), rel=6e-3)
    branch = np.linalg.norm(page.arrays["branch"], axis=1)
    np.testing.assert_allclose(branch, scene.radius[0], rtol=0.02)
    assert (page.arrays["first"] < page.arrays["second"]).all()


def test_pressure_of_a_sphere_between_two_plates_is_f_over_2_pi_r2(fake):
    """-(1/3V) tr(sum f (x) b) of two forces F at +-r: 2 F r/(3 V) = F/(2 pi r^2)."""
    scene, _ = fake
    n, r, force = len(scene.radius), scene.radius[0], 0.7
    up = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    squeezed = Pairs(0, np.array([[3, n], [3, n + 1]]), force * up, up, np.full(2, r))
    found = pressure(scene, squeezed)
    assert found[3] == pytest.approx(force / (2 * np.pi * r**2), rel=1e-12)
    assert np.count_nonzero(found) == 1
    # Two that press each other share the force: half of it each, as one side of the plates.
    beside = Pairs(0, np.array([[3, 4]]), force * up[1:], up[1:], np.full(1, 2 * r))
    np.testing.assert_allclose(pressure(scene, beside)[3:5], found[3] / 2, rtol=1e-12)


def test_multi_sphere_particles_have_orientations_a_surface_and_no_stress(tmp_path):
    """Quaternions to half of 2^-12, or their opposites, which turn alike; no normals are kept."""
    folder = write_fake_damper_run(tmp_path / "clusters", clusters=True).path
    scene, page = page_of(folder)
    turns = page.arrays["turn"].reshape(len(scene.tables), -1, 4)
    jumps = np.abs(np.diff(turns, axis=0)).max()
    for frame in range(len(scene.tables)):
        same = (turns[frame] * scene.orientation(frame)).sum(axis=1)
        np.testing.assert_allclose(np.abs(same), 1.0, atol=3e-4)
    assert jumps < 0.5, "no quaternion jumps to its opposite"
    spheres = np.column_stack([OFFSETS, RADII])
    np.testing.assert_allclose(page.arrays["sphere"], spheres, atol=1e-7)
    corners = page.arrays["surface_corner"]
    away = (np.linalg.norm(corners[:, None] - OFFSETS, axis=2) - RADII).min(axis=1)
    assert np.abs(away).max() < 2e-6
    assert page.arrays["surface_triangle"].max() == len(corners) - 1
    assert "stress" not in page.arrays


def test_kinds_of_a_mixture_have_surfaces_of_their_own_at_the_scale_of_each(tmp_path):
    """Three spheres, and two in two sizes: corners lie on the spheres of their kind alone."""
    folder = write_fake_damper_run(tmp_path / "mixture", clusters=True, unlike=True).path
    scene, page = page_of(folder)
    arrays = page.arrays
    assert arrays["form"].tolist() == scene.kind.tolist()
    arm, radius, whose = scene.own_spheres
    begun = corner = triangle = 0
    for kind, (spheres, triangles) in enumerate(
        zip(arrays["sphere_end"].astype(int), arrays["surface_end"].astype(int), strict=True)
    ):
        rows = arrays["sphere"][begun:spheres]
        for one in np.flatnonzero(scene.kind == kind):
            own = np.column_stack([arm, radius])[whose == one]
            np.testing.assert_allclose(arrays["scale"][one] * rows, own, atol=1e-7)
        last = int(arrays["surface_triangle"][3 * triangle : 3 * triangles].max()) + 1
        corners = arrays["surface_corner"][corner:last]
        away = np.linalg.norm(corners[:, None] - rows[:, :3], axis=2) - rows[:, 3]
        assert np.abs(away.min(axis=1)).max() < 2e-6
        begun, corner, triangle = spheres, last, triangles
    assert corner == len(arrays["surface_corner"])


@pytest.mark.parametrize(
    ("shape", "keys", "sharp", "round_"),
    [
        ("cylinder", {}, 96, 48),  # two rings of 48, and the edges of the side between facets
        ("box", {"width": 0.04, "depth": 0.03, "height": 0.02}, 12, 0),
        ("sphere", {"diameter": 0.04}, 0, None),
    ],
)
def test_edges_are_sharp_or_between_faces_of_a_round_wall(shape, keys, sharp, round_):
    """Of a round wall the faces beside an edge look nearly the same way."""
    enclosure = ENCLOSURES[shape](**keys)
    ends, normals = edges_of([points for _, points in enclosure.polygons])
    always = ~normals.any(axis=(1, 2))
    assert always.sum() == sharp
    assert (~always).sum() == (len(ends) if round_ is None else round_)
    assert ((normals[:, 0] * normals[:, 1]).sum(axis=1)[~always] > 0.8).all()


@pytest.mark.parametrize("shape", ["cylinder", "box", "frustum", "sphere", "hexagonal_prism"])
def test_the_way_to_a_wall_ends_on_it_and_none_is_shorter_than_the_nearest(shape):
    """From a point off the middle: to planes by their distance, to curved walls as the engine."""
    keys = {"box": {"width": 0.04, "height": 0.04}, "sphere": {"diameter": 0.04},
            "frustum": {"diameter": 0.04, "top_diameter": 0.03, "height": 0.04},
            "hexagonal_prism": {"across_flats": 0.04, "height": 0.04}}.get(shape, {})  # fmt: skip
    enclosure = ENCLOSURES[shape](**keys)
    point = enclosure.middle + np.array([3e-3, -2e-3, 5e-3])
    for wall in range(len(enclosure.wall_names)):
        way = to_wall(enclosure, wall, point)
        again = to_wall(enclosure, wall, point + 0.5 * way)
        np.testing.assert_allclose(again, 0.5 * way, atol=1e-12)
        end = to_wall(enclosure, wall, point + (1 - 1e-9) * way)
        assert np.linalg.norm(end) < 1e-10


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"frames": 0}, "kept no particles (output.frames = 0)"),
        ({"keep": "summary"}, 'only its summary was kept (output.keep = "summary")'),
        ({"finished": False}, "unfinished; wait for it, or go on with it: damper3d run --resume"),
    ],
)
def test_a_run_that_kept_nothing_to_play_is_refused_with_the_cure(tmp_path, options, words):
    folder = write_fake_damper_run(tmp_path / "run", **options).path
    assert_refused(damper3d("view", folder), str(folder), words)


def test_run_page_is_refused_before_anything_is_computed(tmp_path):
    for keys in (["--keep", "summary"], ["--frames", 0]):
        done = damper3d("run", "--page", *keys, "-o", tmp_path)
        assert_refused(done, "--page: nothing is kept to play")
    assert not list(tmp_path.iterdir())


def test_a_damaged_run_is_refused(damper_reference, tmp_path):
    folder = tmp_path / "copy"
    shutil.copytree(damper_reference.path, folder)
    whole = (folder / "trajectory.h5").read_bytes()
    (folder / "trajectory.h5").write_bytes(whole[:-100] + bytes(100))
    assert_refused(damper3d("view", folder), "use --again to compute the run again")
