"""A run for other programs: one VTKHDF file for ParaView (see vtkhdf.py), or CSV tables."""

import io
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from granulab.campaign.cli.library import write_output
from granulab.campaign.runs.ragged import Tables
from granulab.campaign.runs.trajectory import stored_tables
from granulab.contact.files.units import nearest
from granulab.errors import InputError
from silo2d.measures.from_contacts.particle_stress import grain_stress
from silo2d.view.scene import Scene, read_scene
from silo2d.view.vtkhdf import vtkhdf

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
    """What is exported."""

    folder: Path
    scene: Scene
    contacts: Tables | None  # None: its folder holds none

    @property
    def place(self) -> Path:
        """Where the files go unless told."""
        return self.folder / "export"


def _to_vtkhdf(run: Run, path: Path | None) -> list[Path]:
    path = path or run.place / f"run{_SUFFIX}"
    if path.suffix != _SUFFIX:
        raise InputError(f"--output {path}: ParaView knows the format by {_SUFFIX}; add that")
    return [write_output(path, vtkhdf(run.scene, run.contacts))]


def _to_csv(run: Run, path: Path | None) -> list[Path]:
    folder, scene = path or run.place, run.scene
    tables = {"frames": _frames_csv, "grains": _grains_csv, "walls": _walls_csv}
    paths = [write_output(folder / f"{name}.csv", table(scene)) for name, table in tables.items()]
    if run.contacts is not None:
        paths.append(write_output(folder / "stress.csv", _stress_csv(scene, run.contacts)))
    return paths


FORMATS: dict[str, Callable[[Run, Path | None], list[Path]]] = {
    "vtkhdf": _to_vtkhdf,
    "csv": _to_csv,
}


def _frames_csv(scene: Scene) -> bytes:
    """One row for each frame and grain that is still simulated."""
    names = ["frame", "time_s", "id", *_MOVING, "inside"]
    shape = ["%d", "%.9g", "%d", *["%.9g"] * len(_MOVING), "%d"]
    return _table(names, shape, (_rows(scene, frame) for frame in range(len(scene.time))))


def _rows(scene: Scene, frame: int) -> np.ndarray:
    grains = np.flatnonzero(scene.trajectory["inside"][frame])
    moving = [scene.trajectory[key][frame][grains] for key in _MOVING.values()]
    inside = np.isnan(scene.trajectory["out_time"][frame][grains])
    same = np.ones(len(grains))
    return np.column_stack([frame * same, scene.time[frame] * same, grains, *moving, inside])


def _grains_csv(scene: Scene) -> bytes:
    """What does not change of each grain; out_time_s is empty for those that have not left."""
    static = scene.trajectory.static
    out_time = scene.trajectory["out_time"][-1]
    rows = [np.arange(scene.n_grains), static["kind"], static["mass"], static["layer"], out_time]
    shape = ["%d", "%d", "%.9g", "%d", "%.9g"]
    table = _table(["id", "kind", "mass_kg", "layer", "out_time_s"], shape, [np.stack(rows, 1)])
    return table.replace(b"nan", b"")


def _walls_csv(scene: Scene) -> bytes:
    """The walls without the door, in the order of the ids -1, -2, ... of the VTKHDF file."""
    lines = ["name,x1_m,y1_m,x2_m,y2_m"]
    for name, ends in zip(scene.wall_names, scene.walls.reshape(-1, 4), strict=False):
        lines.append(",".join([name, *(f"{value:.9g}" for value in ends)]))
    return ("\n".join(lines) + "\n").encode()


def _stress_csv(scene: Scene, contacts: Tables) -> bytes:
    """One row for each grain that is still simulated in the frames that have contacts."""
    names = ["frame", "time_s", "id", *(f"stress_{axes}_n_per_m" for axes in ("xx", "yy", "xy"))]
    parts = []
    for frame in contacts.frame[contacts.frame < len(scene.time)]:
        stress = grain_stress(scene, contacts, int(frame))
        assert stress is not None  # these frames have contacts
        grains = np.flatnonzero(scene.trajectory["inside"][frame])
        same = np.ones(len(grains))
        of_plane = [stress[grains, row, column] for row, column in ((0, 0), (1, 1), (0, 1))]
        parts.append(np.column_stack([frame * same, scene.time[frame] * same, grains, *of_plane]))
    return _table(names, ["%d", "%.9g", "%d", "%.6g", "%.6g", "%.6g"], parts)


def _table(names: list[str], shape: list[str], parts: Iterator[np.ndarray] | list) -> bytes:
    text = io.BytesIO()
    text.write((",".join(names) + "\n").encode())
    for rows in parts:
        np.savetxt(text, rows, fmt=shape, delimiter=",")
    return text.getvalue()
