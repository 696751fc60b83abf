"""A run read back as ParaView reads it and from CSV: the same particles, outlines and motion."""

import csv
import resource
from pathlib import Path

import numpy as np
import pytest
from exported_film import Film
from fake_run import write_fake_run
from refusals import assert_refused
from small_silo import contents, silo2d
from vtkmodules.util.numpy_support import vtk_to_numpy

from granulab.campaign.runs.ragged import Tables
from granulab.campaign.runs.trajectory import read_tables, read_trajectory
from silo2d.case.case import SiloCase
from silo2d.case.shape import corner_angles
from silo2d.case.shapefile import load_shapes
from silo2d.measures.basics.contacts import particle_stress
from silo2d.view.export import export, vtkhdf
from silo2d.view.scene import read_scene

AXES = ["xx", "yy", "xy"]
SINGLE = np.finfo(np.float32).eps / 2  # relative rounding of what is kept in single precision


def cell_points(mesh, index: int) -> np.ndarray:
    """Points (p, 3) of a cell, in its order."""
    return vtk_to_numpy(mesh.GetCell(index).GetPoints().GetData())


def arrays(mesh) -> dict[str, np.ndarray]:
    cells = mesh.GetCellData()
    return {
        cells.GetArrayName(k): vtk_to_numpy(cells.GetArray(k))
        for k in range(cells.GetNumberOfArrays())
    }


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> Path:
    return write_fake_run(tmp_path_factory.mktemp("run"), n_frames=31).path


@pytest.fixture(scope="module")
def film(run) -> Film:
    (path,) = export(run, "vtkhdf")
    return Film(path)


def test_each_stored_frame_is_a_time_step(run, film):
    time = read_trajectory(run)["time"]
    assert film.n_steps == len(time)
    times = []
    for k in range(film.n_steps):
        film.step(k)
        times.append(film.reader.GetTimeValue())
    np.testing.assert_array_equal(times, time)


@pytest.mark.parametrize("frame", [0, 1, 17, 30])
def test_cells_are_the_walls_and_then_the_particles_that_are_simulated(run, film, frame):
    """Points are the outlines at the frame's poses, turned and moved, to single precision."""
    scene, mesh = read_scene(run), film.step(frame)
    static, n_walls = scene.trajectory.static, len(scene.walls)
    particles = np.flatnonzero(scene.trajectory["inside"][frame])
    assert (mesh.GetNumberOfLines(), mesh.GetNumberOfPolys()) == (n_walls, len(particles))
    assert mesh.GetNumberOfCells() == n_walls + len(particles)
    for wall, ends in enumerate(scene.walls):
        np.testing.assert_allclose(cell_points(mesh, wall)[:, :2], ends, rtol=SINGLE)
    for cell, particle in enumerate(particles, start=n_walls):
        x, y, angle = (scene.trajectory[key][frame][particle] for key in ("x", "y", "angle"))
        first = static["kind"][particle]
        local = static["shape_points"][slice(*static["shape_start"][first : first + 2])]
        axes = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        points = cell_points(mesh, cell)
        # Single precision of an angle of some radians turns a point 20 mm away by some nm.
        np.testing.assert_allclose(points[:, :2], local @ axes + [x, y], atol=2e-8)
        assert (points[:, 2] == 0).all()


@pytest.mark.parametrize("frame", [0, 17, 30])
def test_each_cell_carries_what_the_run_knows_of_its_particle(run, film, frame):
    """Walls have ids below 0 and nothing of a particle."""
    trajectory, found = read_trajectory(run), arrays(film.step(frame))
    particles = np.flatnonzero(trajectory["inside"][frame])
    walls = len(trajectory.static["wall_segments"]) - 1
    expected = {
        "id": particles,
        "kind": trajectory.static["kind"][particles],
        "layer": trajectory.static["layer"][particles],
        "inside": np.isnan(trajectory["out_time"][frame][particles]),
        "spin": trajectory["spin"][frame][particles],
    }
    for name, values in expected.items():
        np.testing.assert_array_equal(found[name][walls:], values, err_msg=name)
    for axis, name in enumerate(("vx", "vy")):
        np.testing.assert_array_equal(
            found["velocity"][walls:, axis], trajectory[name][frame][particles]
        )
    np.testing.assert_array_equal(found["id"][:walls], -1 - np.arange(walls))
    for name in ("kind", "layer", "inside"):
        assert (found[name][:walls] == -1).all()
    assert (found["velocity"][:walls] == 0).all()


def test_polygons_miss_what_lies_between_chords_and_arcs(run, film):
    """An arc of turn t and radius r cut into m chords loses r^2/2 (t - m sin(t/m)) of area."""
    scene, mesh = read_scene(run), film.step(0)
    shapes = load_shapes("wood19").shapes
    kind, chords = scene.trajectory.static["kind"], 4
    for cell in range(len(scene.walls), mesh.GetNumberOfCells(), 5):
        shape = shapes[kind[arrays(mesh)["id"][cell]]]
        turns = corner_angles(shape.core)
        lost = 0.5 * shape.spheroradius**2 * (turns - chords * np.sin(turns / chords)).sum()
        x, y, _ = cell_points(mesh, cell).astype(float).T
        x, y = x - x.mean(), y - y.mean()
        area = 0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum()
        # Points rounded by 3e-8 m (single precision at 0.5 m) along a perimeter below 0.1 m.
        assert area == pytest.approx(shape.area - lost, abs=3e-9)
        assert lost < 6e-4 * shape.area


def test_an_unfinished_run(tmp_path):
    """What is there is written."""
    run = write_fake_run(tmp_path / "run", n_frames=7, finished=False).path
    film = Film(export(run, "vtkhdf", tmp_path / "part.vtkhdf")[0])
    assert film.n_steps == 7
    assert film.step(6).GetNumberOfPolys() > 0


def test_an_emptied_silo_is_its_walls(run, tmp_path):
    """The last steps of a discharge hold no polygon."""
    scene, path = read_scene(run), tmp_path / "empty.vtkhdf"
    scene.trajectory["inside"][-2:] = False
    path.write_bytes(vtkhdf(scene))
    film = Film(path)
    n_walls = len(scene.walls)
    for step, n_particles in ((-3, scene.trajectory["inside"][-3].sum()), (-2, 0), (-1, 0)):
        mesh = film.step(film.n_steps + step)
        assert (mesh.GetNumberOfPolys(), mesh.GetNumberOfLines()) == (n_particles, n_walls)


def read_csv(path: Path) -> dict[str, np.ndarray]:
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return {key: np.array([row[key] for row in rows]) for key in rows[0]}


def test_tables_hold_the_motion_of_every_particle_in_every_frame(run, tmp_path):
    """Each number as it was stored, one row for a particle and frame."""
    paths = export(run, "csv", tmp_path / "tables")
    assert [path.name for path in paths] == ["frames.csv", "grains.csv", "walls.csv"]
    trajectory, table = read_trajectory(run), read_csv(paths[0])
    frame, particle = np.nonzero(trajectory["inside"])
    np.testing.assert_array_equal(table["frame"].astype(int), frame)
    np.testing.assert_array_equal(table["id"].astype(int), particle)
    np.testing.assert_allclose(table["time_s"].astype(float), trajectory["time"][frame], rtol=1e-8)
    columns = {"x_m": "x", "y_m": "y", "angle_rad": "angle", "vx_m_per_s": "vx",
               "vy_m_per_s": "vy", "spin_rad_per_s": "spin"}  # fmt: skip
    for name, key in columns.items():
        stored = trajectory[key][frame, particle]
        np.testing.assert_array_equal(table[name].astype(np.float32), stored)
    is_inside = np.isnan(trajectory["out_time"][frame, particle])
    np.testing.assert_array_equal(table["inside"].astype(int), is_inside)


def test_kinetic_energy_from_the_tables_is_that_of_the_energy_balance(reference, tmp_path):
    """sum of m v^2/2 + I w^2/2 over the rows of a frame, m from grains.csv, I/m from shapes."""
    frames, particles, *_ = map(read_csv, export(reference.path, "csv", tmp_path / "tables"))
    trajectory = read_trajectory(reference.path)
    shapes = SiloCase.load(reference.path / "case.toml").shapes.shapes
    gyration2 = np.array([shape.polar_moment / shape.area for shape in shapes])
    mass, kind = particles["mass_kg"].astype(float), particles["kind"].astype(int)
    for k in (3, len(trajectory["time"]) // 2):
        now = frames["frame"].astype(int) == k
        who = frames["id"][now].astype(int)
        vx, vy, spin = (
            frames[name][now].astype(float)
            for name in ("vx_m_per_s", "vy_m_per_s", "spin_rad_per_s")
        )
        kinetic = 0.5 * mass[who] @ (vx**2 + vy**2 + gyration2[kind[who]] * spin**2)
        # Squares of numbers in single precision; the masses are printed with nine digits.
        assert kinetic == pytest.approx(trajectory["kinetic"][k], rel=float(3 * SINGLE) + 1e-8)


def test_stress_of_a_particle_between_two_forces(run):
    """Two forces F that press at a distance D on each other's line: F D/A along it, else 0."""
    scene = read_scene(run)
    centre = np.array([scene.trajectory[key][5][3] for key in ("x", "y")], dtype=float)
    reach, press, wall = 4e-3, 7.0, scene.n_particles
    direction = np.array([0.6, 0.8])
    ends = np.array([1, -1])[:, None] * direction
    contacts = Tables(
        frame=np.array([5]),
        length=np.array([2]),
        columns={
            "bodies": np.array([[3, wall], [3, wall + 1]]),  # the force is that on the wall
            "point": centre + reach * ends,
            "force": press * ends,
            "normal": ends,
            "overlap": np.full(2, 1e-6),
            "slides": np.zeros(2, bool),
        },
    )
    shape = load_shapes("wood19").shapes[scene.trajectory.static["kind"][3]]
    expected = press * 2 * reach / shape.area * np.outer(direction, direction)
    stress = particle_stress(scene, contacts, 5)
    np.testing.assert_allclose(stress[3], expected, rtol=6e-4)  # the outline's area, see above
    assert (np.delete(stress, 3, axis=0) == 0).all()
    assert particle_stress(scene, contacts, 6) is None


def test_stresses_add_up_to_the_virial(reference, tmp_path):
    """sum A sigma = sum of particles of x (x) F - sum over walls of p (x) f: inner contacts cancel.

    F is the whole contact force on a particle, f that of a wall on a particle at p. At rest F is
    the weight, but a packing that hardly moves is accelerated by its vibrations as much as by
    gravity.
    """
    _, particles, _, table = map(read_csv, export(reference.path, "csv", tmp_path / "tables"))
    scene, contacts = read_scene(reference.path), read_tables(reference.path, "contacts")
    surface_density = SiloCase.load(reference.path / "case.toml").surface_density
    area = particles["mass_kg"].astype(float) / surface_density
    first = table["frame"] == "0"
    stress = np.stack([table[f"stress_{axes}_n_per_m"][first].astype(float) for axes in AXES])
    found = stress @ area[table["id"][first].astype(int)]
    now = contacts.at(0)
    of_particle, force = np.zeros((scene.n_particles, 2)), now["force"].astype(float)
    walls = now["bodies"][:, 1] >= scene.n_particles
    np.add.at(of_particle, now["bodies"][:, 0], -force)
    np.add.at(of_particle, now["bodies"][~walls, 1], force[~walls])
    centre = np.column_stack([scene.trajectory["x"][0], scene.trajectory["y"][0]]).astype(float)
    virial = centre.T @ of_particle + now["point"][walls].astype(float).T @ force[walls]
    expected = virial[0, 0], virial[1, 1], (virial[0, 1] + virial[1, 0]) / 2
    # The outline's area is at most 6e-4 small, for each particle (as above).
    np.testing.assert_allclose(found, expected, atol=1e-3 * np.abs(expected).max())
    assert found[1] > 0  # it is pressed


def test_stress_in_the_film_is_that_of_the_tables(reference, tmp_path):
    """Of the same frame; NaN where the run kept no contacts, and at the walls."""
    film = Film(export(reference.path, "vtkhdf", tmp_path / "run.vtkhdf")[0])
    table = read_csv(export(reference.path, "csv", tmp_path)[3])
    frames = sorted(set(table["frame"].astype(int)))
    assert 1 < len(frames) < film.n_steps
    for frame in range(film.n_steps):
        found = arrays(film.step(frame))
        of_walls = found["id"] < 0
        assert np.isnan(found["stress"][of_walls]).all()
        if frame not in frames:
            assert np.isnan(found["stress"]).all()
            continue
        now = table["frame"].astype(int) == frame
        np.testing.assert_array_equal(found["id"][~of_walls], table["id"][now].astype(int))
        for component, axes in ((0, "xx"), (1, "yy"), (3, "xy")):
            expected = table[f"stress_{axes}_n_per_m"][now].astype(float)
            np.testing.assert_allclose(
                found["stress"][~of_walls, component], expected, rtol=1e-5, atol=1e-12
            )
        assert (found["stress"][~of_walls][:, [2, 4, 5]] == 0).all()


def test_a_run_without_contacts_has_no_stress(run, film, tmp_path):
    assert "stress" not in arrays(film.step(0))
    assert len(export(run, "csv", tmp_path)) == 3


def test_particles_that_stay_have_no_time_of_leaving(tmp_path):
    run = write_fake_run(tmp_path / "run", outcome="clogged").path
    particles = read_csv(export(run, "csv")[1])
    out_time = read_trajectory(run)["out_time"][-1]
    assert (run / "export" / "grains.csv").is_file()
    np.testing.assert_array_equal(particles["out_time_s"] == "", np.isnan(out_time))


def test_exported_twice_it_is_the_same_file(run, tmp_path):
    first = export(run, "vtkhdf", tmp_path / "run.vtkhdf")[0].read_bytes()
    assert export(run, "vtkhdf", tmp_path / "run.vtkhdf")[0].read_bytes() == first


def test_the_command_says_which_files_it_wrote(run, tmp_path):
    result = silo2d("export", run, "--to", "csv", "-o", tmp_path)
    names = ["frames.csv", "grains.csv", "walls.csv"]
    assert result.code == 0
    assert result.out.split() == [str(tmp_path / name) for name in names]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--to", "vtk"], ["'vtk'", "did you mean 'vtkhdf'"]),
        (["--to", "vtkhdf", "-o", "run.vtk"], ["run.vtk", ".vtkhdf"]),
        (["--to", "vtkhdf", "-o", "a file/run.vtkhdf"], ["cannot be written", "--output"]),
        (["--to", "csv", "-o", "a file"], ["cannot be written", "--output"]),
        ([], ["--to"]),
    ],
)
def test_what_cannot_be_written_is_refused(run, tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    Path("a file").touch()
    result = silo2d("export", run, *arguments)
    assert_refused(result, *words)
    assert list(tmp_path.iterdir()) == [tmp_path / "a file"]


def test_a_full_disk_keeps_what_stood_there(run, tmp_path):
    """A write that breaks off, here at a file size limit, leaves the old file and no rest."""
    target = tmp_path / "run.vtkhdf"
    export(run, "vtkhdf", target)
    before = contents(tmp_path)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limits[1]))
    try:
        result = silo2d("export", run, "--to", "vtkhdf", "-o", target)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert_refused(result, "run.vtkhdf: cannot be written", "make room there")
    assert contents(tmp_path) == before
