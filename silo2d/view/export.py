"""A run for other programs: one VTKHDF file for ParaView, or CSV tables.

VTKHDF (see granulab.campaign.output.vtkhdf): each stored frame is a step. The cells of a step are
the walls as lines, without the door, and then the particles that are still simulated as polygons,
in ascending order. Their arrays, SI units:

    velocity (3) [m/s]   spin: angular velocity [rad/s]   kind, layer
    inside: 1 until the centroid passes y = 0
    id: of a particle from 0 on; of the walls -1, -2, ... in the order of the run folder
    stress (6: xx, yy, zz, xy, yz, xz) [N/m], see particle_stress; NaN in frames without contacts,
        left out where the run folder keeps none

A wall has kind, layer and inside -1, no velocity and stress NaN. Polygons are the outlines that
the run folder keeps: chords of m pieces to an arc of angle t and radius r lie r (1 - cos(t/2m))
inside it at most.
"""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from granulab.campaign.cli.library import write_output
from granulab.campaign.output.table import numbers_as_csv
from granulab.campaign.output.vtkhdf import PolyDataFile
from granulab.campaign.runs.ragged import Tables
from granulab.campaign.runs.trajectory import stored_tables
from granulab.contact.files.units import nearest
from granulab.errors import InputError
from silo2d.measures.basics.contacts import particle_stress
from silo2d.view.scene import Scene, read_scene

_SUFFIX = ".vtkhdf"  # by which ParaView and vtkHDFReader know the format
_MOVING = {  # columns of frames.csv that stand in the trajectory, and what is kept of each
    "x_m": "x", "y_m": "y", "angle_rad": "angle",
    "vx_m_per_s": "vx", "vy_m_per_s": "vy", "spin_rad_per_s": "spin",
}  # fmt: skip


def export(run_folder: str | Path, to: str, path: str | Path | None = None) -> list[Path]:
    """Write a run, finished or not, in a format ("vtkhdf" or "csv"); the paths of the files.

    `path` is the file (vtkhdf) or the folder for the tables (csv); export/ in the run folder
    where it is not given. What stands there is replaced, each file at once.
    Raises InputError for another format or suffix, FolderError where the run cannot be read or
    the files cannot be written.
    """
    if to not in FORMATS:
        raise InputError(f"--to {to!r}: {nearest(to, list(FORMATS))}")
    run = Run(Path(run_folder), read_scene(run_folder), stored_tables(run_folder).get("contacts"))
    return FORMATS[to](run, None if path is None else Path(path))


class Run(NamedTuple):
    """Run that is exported."""

    folder: Path
    scene: Scene
    contacts: Tables | None  # None: its folder holds none

    @property
    def target(self) -> Path:
        """Folder of the files unless a path is given."""
        return self.folder / "export"


def _to_vtkhdf(run: Run, path: Path | None) -> list[Path]:
    path = path or run.target / f"run{_SUFFIX}"
    if path.suffix != _SUFFIX:
        raise InputError(f"--output {path}: ParaView knows the format by {_SUFFIX}; add that")
    return [write_output(path, vtkhdf(run.scene, run.contacts))]


def _to_csv(run: Run, path: Path | None) -> list[Path]:
    folder, scene = path or run.target, run.scene
    tables = {"frames": _frames_csv, "grains": _particles_csv, "walls": _walls_csv}
    paths = [write_output(folder / f"{name}.csv", table(scene)) for name, table in tables.items()]
    if run.contacts is not None:
        paths.append(write_output(folder / "stress.csv", _stress_csv(scene, run.contacts)))
    return paths


FORMATS: dict[str, Callable[[Run, Path | None], list[Path]]] = {
    "vtkhdf": _to_vtkhdf,
    "csv": _to_csv,
}


def _frames_csv(scene: Scene) -> bytes:
    """One row for each frame and particle that is still simulated."""
    names = ["frame", "time_s", "id", *_MOVING, "inside"]
    shape = ["%d", "%.9g", "%d", *["%.9g"] * len(_MOVING), "%d"]
    return numbers_as_csv(names, shape, (_rows(scene, frame) for frame in range(len(scene.time))))


def _rows(scene: Scene, frame: int) -> np.ndarray:
    particles = np.flatnonzero(scene.trajectory["inside"][frame])
    moving = [scene.trajectory[key][frame][particles] for key in _MOVING.values()]
    inside = np.isnan(scene.trajectory["out_time"][frame][particles])
    same = np.ones(len(particles))
    return np.column_stack([frame * same, scene.time[frame] * same, particles, *moving, inside])


def _particles_csv(scene: Scene) -> bytes:
    """Table of what does not change of each particle; no out_time_s for those that stay."""
    static = scene.trajectory.static
    out_time = scene.trajectory["out_time"][-1]
    rows = [np.arange(scene.n_particles), static["kind"], static["mass"], static["layer"], out_time]
    shape = ["%d", "%d", "%.9g", "%d", "%.9g"]
    table = numbers_as_csv(
        ["id", "kind", "mass_kg", "layer", "out_time_s"], shape, [np.stack(rows, 1)]
    )
    return table.replace(b"nan", b"")


def _walls_csv(scene: Scene) -> bytes:
    """The walls without the door, in the order of the ids -1, -2, ... of the VTKHDF file."""
    lines = ["name,x1_m,y1_m,x2_m,y2_m"]
    for name, ends in zip(scene.wall_names, scene.walls.reshape(-1, 4), strict=False):
        lines.append(",".join([name, *(f"{value:.9g}" for value in ends)]))
    return ("\n".join(lines) + "\n").encode()


def _stress_csv(scene: Scene, contacts: Tables) -> bytes:
    """One row for each particle that is still simulated in the frames that have contacts."""
    names = ["frame", "time_s", "id", *(f"stress_{axes}_n_per_m" for axes in ("xx", "yy", "xy"))]
    parts = []
    for frame in contacts.frame[contacts.frame < len(scene.time)]:
        stress = particle_stress(scene, contacts, int(frame))
        assert stress is not None  # these frames have contacts
        particles = np.flatnonzero(scene.trajectory["inside"][frame])
        same = np.ones(len(particles))
        of_plane = [stress[particles, row, column] for row, column in ((0, 0), (1, 1), (0, 1))]
        parts.append(
            np.column_stack([frame * same, scene.time[frame] * same, particles, *of_plane])
        )
    return numbers_as_csv(names, ["%d", "%.9g", "%d", "%.6g", "%.6g", "%.6g"], parts)


def vtkhdf(scene: Scene, contacts: Tables | None = None) -> bytes:
    """The run as a VTKHDF file, with stresses where its contacts are given."""
    file = PolyDataFile()
    for frame, time in enumerate(scene.time):
        points, sizes, arrays = _cells(scene, frame)
        if contacts is not None:
            arrays["stress"] = _stress(scene, contacts, frame, arrays["id"])
        file.append(float(time), points, sizes, arrays)
    return file.content()


def _cells(
    scene: Scene, frame: int
) -> tuple[NDArray[np.float32], dict[str, list[int]], dict[str, np.ndarray]]:
    """Points (p, 3) of a frame, points of each cell by kind, arrays of cells."""
    walls, static = scene.walls, scene.trajectory.static
    particles = np.flatnonzero(scene.trajectory["inside"][frame])
    outlines = [np.empty((0, 2))] * scene.n_particles
    for which, around in scene.placed(frame, particles):
        for particle, outline in zip(which, around, strict=True):
            outlines[particle] = outline
    plane = np.concatenate([walls.reshape(-1, 2), *(outlines[particle] for particle in particles)])
    points = np.column_stack([plane, np.zeros(len(plane))]).astype(np.float32)
    now = {key: scene.trajectory[key][frame][particles] for key in ("vx", "vy", "spin", "out_time")}
    velocity = np.column_stack([now["vx"], now["vy"], np.zeros(len(particles))])
    still, none = np.zeros((len(walls), 3)), np.full(len(walls), -1)
    arrays: dict[str, np.ndarray] = {
        "velocity": np.concatenate([still, velocity]).astype(np.float32),
        "spin": np.concatenate([still[:, 0], now["spin"]]).astype(np.float32),
        "id": np.concatenate([none - np.arange(len(walls)), particles]).astype(np.int32),
        "kind": np.concatenate([none, static["kind"][particles]]).astype(np.int32),
        "layer": np.concatenate([none, static["layer"][particles]]).astype(np.int32),
        "inside": np.concatenate([none, np.isnan(now["out_time"])]).astype(np.int8),
    }
    polygons = [len(outlines[particle]) for particle in particles]
    return points, {"Lines": [2] * len(walls), "Polygons": polygons}, arrays


def _stress(
    scene: Scene, contacts: Tables, frame: int, ids: NDArray[np.int32]
) -> NDArray[np.float32]:
    """Stress of the cells (c, 6), in VTK's order of a symmetric tensor."""
    stress = np.full((len(ids), 6), np.nan, dtype=np.float32)
    found = particle_stress(scene, contacts, frame)
    if found is not None:
        stress[ids >= 0] = 0.0
        for component, (row, column) in ((0, (0, 0)), (1, (1, 1)), (3, (0, 1))):
            stress[ids >= 0, component] = found[ids[ids >= 0], row, column]
    return stress
