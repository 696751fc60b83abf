"""A damper's run read back as ParaView reads it, and from CSV: the same particles and walls."""

import csv
from pathlib import Path

import numpy as np
import pytest
from exported_film import Film
from fake_damper_run import OFFSETS, RADII, write_fake_damper_run
from small_damper import damper3d
from vtkmodules.util.numpy_support import vtk_to_numpy

from damper3d.view.export import export
from damper3d.view.scene import read_scene

SINGLE = np.finfo(np.float32).eps


def points(mesh) -> np.ndarray:
    return vtk_to_numpy(mesh.GetPoints().GetData())


def arrays(data) -> dict[str, np.ndarray]:
    """Of the points or the cells of a mesh, by name."""
    return {data.GetArrayName(k): vtk_to_numpy(data.GetArray(k))
            for k in range(data.GetNumberOfArrays())}  # fmt: skip


@pytest.fixture(scope="module", params=["cylinder", "box"])
def run(request, tmp_path_factory) -> Path:
    return write_fake_damper_run(
        tmp_path_factory.mktemp(request.param), shape=request.param, cycles=3
    ).path


@pytest.fixture(scope="module")
def films(run) -> list[Film]:
    paths = export(run, "vtkhdf")
    assert paths == [run / "export" / f"{name}.vtkhdf" for name in ("particles", "enclosure")]
    return [Film(path) for path in paths]


def test_steps_are_the_stored_parts_of_each_cycle(run, films):
    """Eight a cycle and the start, in both files, with their times."""
    scene = read_scene(run)
    for film in films:
        assert film.n_steps == 3 * 8 + 1
        times = []
        for k in range(film.n_steps):
            film.step(k)
            times.append(film.reader.GetTimeValue())
        np.testing.assert_array_equal(times, scene.time[scene.frame_sample])
        np.testing.assert_allclose(np.diff(times), scene.period / 8)


@pytest.mark.parametrize("frame", [0, 1, 13, 24])
def test_particles_are_points_in_the_lab(run, films, frame):
    """Position in the enclosure plus its displacement, and all that is known of each."""
    scene, mesh = read_scene(run), films[0].step(frame)
    now, n = scene.particles(frame), len(scene.radius)
    assert mesh.GetNumberOfPoints() == mesh.GetNumberOfVerts() == n
    sample = scene.frame_sample[frame]
    shift = np.array([0, 0, scene.trajectory["displacement"][sample]])
    lab = now.position + shift
    np.testing.assert_allclose(points(mesh), lab, atol=SINGLE * 0.03)
    found = arrays(mesh.GetPointData())
    assert sorted(found) == ["heat", "id", "power", "radius", "spin", "velocity"]
    for name, values in (
        ("velocity", now.velocity), ("spin", now.angular_velocity), ("heat", now.dissipated),
        ("radius", scene.radius), ("id", np.arange(n)),
    ):  # fmt: skip
        np.testing.assert_allclose(found[name], values, rtol=SINGLE, err_msg=name)


@pytest.mark.parametrize("frame", [0, 2, 6])
def test_the_enclosure_moves_with_its_displacement(run, films, frame):
    """A prism or box about the axis from u to u + 20 mm, each wall by its number."""
    scene, mesh = read_scene(run), films[1].step(frame)
    u = scene.trajectory["displacement"][scene.frame_sample[frame]]
    place = points(mesh)
    assert place[:, 2].min() == pytest.approx(u, abs=2e-9)
    assert place[:, 2].max() == pytest.approx(u + 20e-3, abs=4e-9)
    wall = arrays(mesh.GetCellData())["wall"]
    assert set(wall) == set(range(len(scene.wall_names)))
    assert mesh.GetNumberOfPolys() == len(wall)
    for cell, row in enumerate(wall):
        corners = vtk_to_numpy(mesh.GetCell(cell).GetPoints().GetData()).astype(float)
        corners -= [0, 0, u]
        name = scene.wall_names[row]
        if name == "side":
            np.testing.assert_allclose(np.hypot(*corners[:, :2].T), 10e-3, rtol=1e-6)
        else:
            # On its plane, as damper3d.engine.enclosures has it: n . r = offset.
            normal = scene.enclosure.planes[row]
            np.testing.assert_allclose(corners @ normal[:3], normal[3], atol=4e-9)


def test_every_sphere_lies_in_the_exported_enclosure(films):
    """To the rounding of single precision, in every step."""
    for frame in range(0, films[0].n_steps, 5):
        mesh = films[0].step(frame)
        radius = arrays(mesh.GetPointData())["radius"].astype(float)
        z = points(mesh)[:, 2].astype(float)
        walls = points(films[1].step(frame))[:, 2]
        assert (z - radius).min() > walls.min() - 1e-8
        assert (z + radius).max() < walls.max() + 1e-8


@pytest.fixture(scope="module")
def clusters(tmp_path_factory) -> Path:
    return write_fake_damper_run(tmp_path_factory.mktemp("clusters"), cycles=1, clusters=True).path


@pytest.mark.parametrize("frame", [0, 5])
def test_sub_spheres_lie_where_rodrigues_rotates_them(clusters, frame):
    """r' = r cos a + (u x r) sin a + u (u . r)(1 - cos a) about u = (1, 2, 2)/3 by the angle a of
    a particle, and move as a rigid body does, v + w x r'. Single precision of 20 mm: 2e-9 m."""
    paths = export(clusters, "vtkhdf", clusters / "a.vtkhdf")
    assert [path.name for path in paths] == ["a.vtkhdf", "a-enclosure.vtkhdf", "a-spheres.vtkhdf"]
    bodies, spheres = Film(paths[0]).step(frame), Film(paths[2]).step(frame)
    of_body, found = arrays(bodies.GetPointData()), arrays(spheres.GetPointData())
    assert sorted(found) == ["particle", "power", "radius", "velocity"]
    n, whose = bodies.GetNumberOfPoints(), found["particle"]
    np.testing.assert_array_equal(whose, np.repeat(np.arange(n), 3))
    np.testing.assert_allclose(found["radius"], np.tile(RADII, n), rtol=SINGLE)
    about, angle = np.array([1.0, 2.0, 2.0]) / 3, (frame / 8 + np.arange(n))[:, None, None]
    arms = (OFFSETS * np.cos(angle) + np.cross(about, OFFSETS) * np.sin(angle)
            + (OFFSETS @ about)[:, None] * about * (1 - np.cos(angle))).reshape(-1, 3)  # fmt: skip
    place = points(bodies).astype(float)[whose] + arms
    np.testing.assert_allclose(points(spheres), place, atol=5e-9)
    moving = of_body["velocity"][whose] + np.cross(of_body["spin"][whose], arms)
    np.testing.assert_allclose(found["velocity"], moving, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(of_body["orientation"], axis=1), 1.0, rtol=1e-6)
    np.testing.assert_allclose(of_body["orientation"][:, 0], np.cos(angle / 2).ravel(), atol=1e-6)


def test_tables_of_multi_sphere_particles_have_orientations(clusters, tmp_path):
    """A quaternion for each particle and frame, and the spheres of one particle."""
    paths = export(clusters, "csv", tmp_path)
    assert [path.stem for path in paths] == ["samples", "bodies", "spheres", "particles"]
    spheres, particles = map(read_csv, paths[2:])
    np.testing.assert_allclose(spheres["radius_m"], RADII, rtol=1e-8)
    np.testing.assert_allclose(spheres["y_m"], OFFSETS[:, 1], rtol=1e-8)
    half = 0.5 * (particles["sample"] / 40 + particles["id"])
    np.testing.assert_allclose(particles["turn_w"], np.cos(half), atol=1e-6)
    np.testing.assert_allclose(particles["turn_z"], 2 * np.sin(half) / 3, atol=1e-6)


def read_csv(path: Path) -> dict[str, np.ndarray]:
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return {key: np.array([float(row[key]) for row in rows]) for key in rows[0]}


def test_tables_hold_samples_and_particles_as_stored(run, tmp_path):
    """Names carry the unit; numbers are those of the trajectory, with nine digits."""
    paths = export(run, "csv", tmp_path)
    assert [path.name for path in paths] == ["samples.csv", "bodies.csv", "particles.csv"]
    samples, bodies, particles = map(read_csv, paths)
    scene = read_scene(run)
    assert len(samples["time_s"]) == 3 * 40 + 1
    np.testing.assert_allclose(samples["cycle"], np.arange(121) / 40, rtol=1e-8)
    for name, values in (
        ("wall_work_j", scene.trajectory["wall_work"]),
        ("friction_particle_wall_j", scene.trajectory["friction_particle_wall"]),
        ("displacement_m", scene.trajectory["displacement"]),
        ("impact_speed_particle_particle_m_per_s",
         scene.trajectory["impact_speed_particle_particle"]),
        ("contacts_particle_wall", scene.trajectory["contacts_particle_wall"]),
        ("mean_velocity_z_m_per_s", scene.trajectory["mean_velocity"][:, 2]),
        ("wall_force_top_z_n", scene.trajectory["wall_force"][:, 1, 2]),
    ):  # fmt: skip
        np.testing.assert_allclose(samples[name], values, rtol=1e-8, atol=1e-30, err_msg=name)
    np.testing.assert_allclose(bodies["mass_kg"], scene.masses, rtol=1e-8)
    n = len(scene.radius)
    assert len(particles["id"]) == n * len(scene.tables)
    last = particles["sample"] == 120
    np.testing.assert_array_equal(particles["id"][last], np.arange(n))
    for name, key in (("z_m", "z"), ("vx_m_per_s", "vx"), ("heat_j", "heat")):
        stored = scene.tables.at(24)[key]
        np.testing.assert_array_equal(particles[name][last].astype(np.float32), stored)


def test_kinetic_energy_of_the_translation_from_the_tables(run, tmp_path):
    """sum m v^2/2 over the rows of a frame: all move as one, but for the circles across."""
    _, bodies, particles = map(read_csv, export(run, "csv", tmp_path))
    scene = read_scene(run)
    now = particles["sample"] == 45
    speed2 = sum(particles[f"v{axis}_m_per_s"][now] ** 2 for axis in "xyz")
    circle = bodies["mass_kg"].sum() * (0.2e-3 * 2 * np.pi * 40) ** 2 / 2
    expected = scene.trajectory["kinetic"][45] + circle
    # Squares of numbers in single precision.
    assert bodies["mass_kg"] @ speed2 / 2 == pytest.approx(expected, rel=4 * float(SINGLE))


def test_names_of_the_files(run, tmp_path):
    """The enclosure's file goes next to the one that was requested."""
    result = damper3d("export", run, "--to", "vtkhdf", "-o", tmp_path / "new" / "a.vtkhdf")
    assert (result.code, result.err) == (0, "")
    paths = [tmp_path / "new" / f"{name}.vtkhdf" for name in ("a", "a-enclosure")]
    assert result.out.splitlines() == [str(path) for path in paths]
    assert all(path.is_file() for path in paths)


@pytest.mark.parametrize(
    ("made", "arguments", "words"),
    [
        ({}, ["--to", "vtk"], "--to 'vtk': did you mean 'vtkhdf'?"),
        ({}, ["--to", "vtkhdf", "-o", "a.vtu"], "ParaView knows the format by .vtkhdf; add that"),
        ({}, ["--to", "csv", "-o", "/dev/null/x"], "choose another place with --output"),
        ({"frames": 0}, ["--to", "vtkhdf"], "it kept no particles (output.frames = 0)"),
        ({"keep": "summary"}, ["--to", "csv"], "only its summary was kept"),
    ],
)
def test_what_cannot_be_exported_is_refused_in_one_line(tmp_path, made, arguments, words):
    write_fake_damper_run(tmp_path, cycles=1, **made)
    result = damper3d("export", tmp_path, *arguments)
    assert result.code == 2
    assert words in result.err
    assert len(result.err.splitlines()) == 1


def test_an_unfinished_run_without_frames_has_tables(tmp_path):
    """What is there is written."""
    write_fake_damper_run(tmp_path, finished=False, frames=0, cycles=2)
    assert [path.name for path in export(tmp_path, "csv")] == ["samples.csv", "bodies.csv"]
