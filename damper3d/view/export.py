"""A run for other programs: VTKHDF files for ParaView, CSV tables, or a shaker's record.

VTKHDF: two or three files (PolyData with time steps), of which each stored frame is a step.

    particles    a point each, in the lab [m], with arrays radius [m], velocity (3) [m/s], spin (3),
                 its angular velocity [rad/s], heat [J]: energy dissipated at it so far, power [W]
                 since the step before, id; of a mixture also kind, its number; of several spheres
                 orientation (4), a unit quaternion (w, x, y, z), and radius that of the sphere of
                 the same volume
    spheres      sub-spheres, where particles have several, likewise: radius [m], velocity (3)
                 [m/s] of the sphere's centre, power [W] of its particle, particle: its id; of a
                 mixture also kind
    enclosure    its walls as polygons where they stand, with array wall: row of wall_names

In ParaView: Glyph, sphere, scale by radius with factor 2; the enclosure at an opacity of 0.2.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from damper3d.engine.records import OWN_UNITS, UNITS
from damper3d.measures.counted import read_cycles
from damper3d.view.colouring import power
from damper3d.view.scene import Scene, read_scene
from damper3d.view.shaker import ENCLOSURE_MASS, record_csv
from granulab.campaign.cli.library import write_output
from granulab.campaign.output.table import numbers_as_csv
from granulab.contact.files.units import nearest
from granulab.errors import FolderError, InputError

_SUFFIX = ".vtkhdf"  # by which ParaView and vtkHDFReader know the format

Points = NDArray[np.float64]
_ENDS = {"1": "", "s": "s", "m": "m", "m/s": "m_per_s", "J": "j", "N": "n"}  # by the unit
_MOVING = {  # columns of particles.csv and what is kept of each
    **{f"{axis}_m": axis for axis in "xyz"},
    **{f"v{axis}_m_per_s": f"v{axis}" for axis in "xyz"},
    **{f"spin_{axis}_rad_per_s": f"spin_{axis}" for axis in "xyz"},
    "heat_j": "heat",
}
_ORIENTATION = {f"turn_{c}": f"turn_{c}" for c in "wxyz"}  # of several spheres: a unit quaternion


def export(
    run_folder: str | Path, to: str, path: str | Path | None = None,
    enclosure_mass: float | None = None,
) -> list[Path]:  # fmt: skip
    """Write a run, finished or not, as "vtkhdf", "csv" or a "shaker" record; paths of the files.

    `path` is the file of the particles (vtkhdf; the others go into its folder, with -enclosure and
    -spheres in their names), the folder for the tables (csv) or the record (shaker; that of the
    empty enclosure next to it, with -empty in its name); export/ in the run folder where it is not
    given. What stands there is replaced, each file at once. enclosure_mass [kg] of a shaker's
    record; None: shaker.ENCLOSURE_MASS. Raises InputError for another format or suffix and for a
    mass that is none, FolderError where the run has no frames, cannot be read or cannot be written.
    """
    if to not in FORMATS:
        raise InputError(f"--to {to!r}: {nearest(to, list(FORMATS))}")
    if enclosure_mass is not None and to != "shaker":
        raise InputError(f"--enclosure-mass: of --to shaker, not of {to}; leave it out")
    scene = read_scene(run_folder)
    folder = Path(run_folder) / "export"
    options = {} if enclosure_mass is None else {"mass": enclosure_mass}
    return FORMATS[to](scene, folder, None if path is None else Path(path), **options)


def _to_vtkhdf(scene: Scene, folder: Path, path: Path | None) -> list[Path]:
    path = path or folder / f"particles{_SUFFIX}"
    if path.suffix != _SUFFIX:
        raise InputError(f"--output {path}: ParaView knows the format by {_SUFFIX}; add that")
    if not len(scene.tables):
        raise FolderError(
            f"{folder.parent}: it kept no particles (output.frames = 0), nothing to show; run it "
            "with output.frames above 0"
        )
    makers = {"enclosure": enclosure_file}
    if scene.of_many_spheres:
        makers["spheres"] = spheres_file
    written = [write_output(path, particles_file(scene))]
    for name, maker in makers.items():
        other = path.with_name((name if path.parent == folder else f"{path.stem}-{name}") + _SUFFIX)
        written.append(write_output(other, maker(scene)))
    return written


def _to_csv(scene: Scene, usual: Path, path: Path | None) -> list[Path]:
    tables = {"samples": samples_csv, "bodies": bodies_csv}
    if scene.of_many_spheres:
        tables["spheres"] = spheres_csv
    if len(scene.tables):
        tables["particles"] = particles_csv
    folder = path or usual
    return [write_output(folder / f"{name}.csv", table(scene)) for name, table in tables.items()]


def _to_shaker(
    scene: Scene, folder: Path, path: Path | None, mass: float = ENCLOSURE_MASS
) -> list[Path]:
    if not 0.0 < mass < np.inf:
        raise InputError(f"--enclosure-mass = {mass:g} kg: expected more than 0")
    keys = scene.settings.excitation
    if scene.settings.host.inertia or keys.kind == "rotation" or keys.across:
        raise InputError(
            "--to shaker: a record has one acceleration and the force along it, and this enclosure "
            "turns or moves along two directions; take --to csv"
        )
    path = path or folder / "shaker.csv"
    other, cycles = path.with_stem(f"{path.stem}-empty"), read_cycles(folder.parent)
    return [
        write_output(path, record_csv(cycles, mass)),
        write_output(other, record_csv(cycles, mass, empty=True)),
    ]


FORMATS: dict[str, Callable[..., list[Path]]] = {
    "vtkhdf": _to_vtkhdf,
    "csv": _to_csv,
    "shaker": _to_shaker,
}


def particles_file(scene: Scene) -> bytes:
    """The particles as points with arrays, a step for each frame."""

    def of(frame: int) -> tuple[Points, dict[str, np.ndarray]]:
        now = scene.particles(frame)
        arrays = {
            "radius": scene.radius, "velocity": now.velocity, "spin": now.angular_velocity,
            "heat": now.dissipated, "power": power(scene, frame),
            "id": np.arange(len(scene.radius)),
        }  # fmt: skip
        if scene.of_many_spheres:
            arrays["orientation"] = scene.orientation(frame)
        if scene.kinds > 1:
            arrays["kind"] = scene.kind
        return now.position, arrays

    return _points_file(scene, of)


def spheres_file(scene: Scene) -> bytes:
    """The sub-spheres of particles as points with arrays, a step for each frame."""

    def of(frame: int) -> tuple[Points, dict[str, np.ndarray]]:
        now, (arm, radius, whose) = scene.particles(frame), scene.spheres(frame)
        return now.position[whose] + arm, {
            "radius": radius,
            "velocity": now.velocity[whose] + np.cross(now.angular_velocity[whose], arm),
            "power": power(scene, frame)[whose],
            "particle": whose,
            **({"kind": scene.kind[whose]} if scene.kinds > 1 else {}),
        }

    return _points_file(scene, of)


def _points_file(scene: Scene, of: Callable[[int], tuple[Points, dict[str, np.ndarray]]]) -> bytes:
    """Points with arrays, of which `of` gives those of a frame, in the enclosure's frame [m]."""
    from granulab.campaign.output.vtkhdf import PolyDataFile

    file = PolyDataFile()
    for frame, sample in enumerate(scene.frame_sample):
        points, arrays = of(frame)
        file.append(
            float(scene.time[sample]),
            (points + scene.shift(frame)).astype(np.float32),
            {"Vertices": np.ones(len(points), dtype=np.int64)},
            {},
            {name: _single(values) for name, values in arrays.items()},
        )
    return file.content()


def _single(values: np.ndarray) -> np.ndarray:
    return values.astype(np.float32 if values.dtype.kind == "f" else np.int32)


def enclosure_file(scene: Scene) -> bytes:
    """The walls as polygons where they stand, a step for each frame."""
    from granulab.campaign.output.vtkhdf import PolyDataFile

    file, polygons = PolyDataFile(), scene.enclosure.polygons
    sizes = {"Polygons": [len(points) for _, points in polygons]}
    rows = np.array([scene.wall_names.index(name) for name, _ in polygons], dtype=np.int32)
    points = np.concatenate([points for _, points in polygons])
    for frame, sample in enumerate(scene.frame_sample):
        placed = (points + scene.shift(frame)).astype(np.float32)
        file.append(float(scene.time[sample]), placed, sizes, {"wall": rows})
    return file.content()


def samples_csv(scene: Scene) -> bytes:
    """One row a sample; cycle is the number of whole cycles so far.

    Energies of mechanisms and the wall work are sums since the motion began.
    """
    per = scene.samples_per_cycle
    columns = {"cycle": np.arange(len(scene.time)) / per}
    own = {key: unit for key, unit in OWN_UNITS.items() if key in scene.trajectory}
    for key, unit in {**UNITS, **own}.items():
        for part, values in _parts(scene, key).items():
            columns["_".join(filter(None, [key, part, _ENDS[unit]]))] = values
    return numbers_as_csv(
        list(columns), ["%.9g"] * len(columns), [np.column_stack(list(columns.values()))]
    )


def _parts(scene: Scene, key: str) -> dict[str, np.ndarray]:
    """A column of the samples as columns of single numbers, by the name of each."""
    values = scene.trajectory[key]
    if values.ndim == 1:
        return {"": values}
    if values.ndim == 2:
        return {axis: values[:, k] for k, axis in enumerate("xyz")}
    return {
        f"{wall.replace(' ', '_')}_{axis}": values[:, row, k]
        for row, wall in enumerate(scene.wall_names)
        for k, axis in enumerate("xyz")
    }


def particles_csv(scene: Scene) -> bytes:
    """One row for each frame and particle.

    Positions are relative to the enclosure, velocities those in the lab; `sample` is the row of
    samples.csv, from 0, where the enclosure's displacement stands. Particles of several
    spheres have orientations too.
    """
    moving = _MOVING | _ORIENTATION if scene.of_many_spheres else _MOVING
    names = ["sample", "time_s", "id", *moving]
    shape = ["%d", "%.9g", "%d", *["%.9g"] * len(moving)]
    rows = (_rows(scene, frame, list(moving.values())) for frame in range(len(scene.tables)))
    return numbers_as_csv(names, shape, rows)


def _rows(scene: Scene, frame: int, keys: list[str]) -> np.ndarray:
    table, sample = scene.tables.at(frame), scene.frame_sample[frame]
    same = np.ones(len(scene.radius))
    moving = [table[key] for key in keys]
    return np.column_stack(
        [sample * same, scene.time[sample] * same, np.arange(len(same)), *moving]
    )


def bodies_csv(scene: Scene) -> bytes:
    """Constants of each particle."""
    names, shape = ["id", "radius_m", "mass_kg"], ["%d", "%.9g", "%.9g"]
    columns = [np.arange(len(scene.radius)), scene.radius, scene.masses]
    if scene.kinds > 1:
        names, shape, columns = [*names, "kind"], [*shape, "%d"], [*columns, scene.kind]
    return numbers_as_csv(names, shape, [np.column_stack(columns)])


def spheres_csv(scene: Scene) -> bytes:
    """The sub-spheres of a particle about its centroid in its principal axes.

    Those of one where all are alike; else of each, by its id.
    """
    offset, radius, whose = scene.own_spheres
    first = np.searchsorted(whose, whose)
    columns = [whose, np.arange(len(whose)) - first, offset, radius]
    names, shape = ["id", "sphere", "x_m", "y_m", "z_m", "radius_m"], ["%d", "%d", *["%.9g"] * 4]
    rows = np.column_stack(columns)
    if not scene.of_unlike_spheres:
        names, shape, rows = names[1:], shape[1:], rows[whose == 0, 1:]
    return numbers_as_csv(names, shape, [rows])
