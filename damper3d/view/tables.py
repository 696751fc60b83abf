"""A run as CSV tables: its samples, its particles frame by frame, and what does not change."""

import io
from collections.abc import Iterable

import numpy as np

from damper3d.engine.records import UNITS
from damper3d.view.pictures.scene import Scene

_ENDS = {"1": "", "s": "s", "m": "m", "m/s": "m_per_s", "J": "j", "N": "n"}  # by the unit
_MOVING = {  # columns of particles.csv and what is kept of each
    **{f"{axis}_m": axis for axis in "xyz"},
    **{f"v{axis}_m_per_s": f"v{axis}" for axis in "xyz"},
    **{f"spin_{axis}_rad_per_s": f"spin_{axis}" for axis in "xyz"},
    "heat_j": "heat",
}
_TURNING = {f"turn_{c}": f"turn_{c}" for c in "wxyz"}  # of clusters: a unit quaternion


def samples_csv(scene: Scene) -> bytes:
    """One row a sample; cycle is the number of whole cycles so far.

    Energies of mechanisms and the wall work are sums since the motion began.
    """
    per = scene.samples_per_cycle
    columns = {"cycle": np.arange(len(scene.time)) / per}
    for key, unit in UNITS.items():
        for part, values in _parts(scene, key).items():
            columns["_".join(filter(None, [key, part, _ENDS[unit]]))] = values
    return _table(list(columns), ["%.9g"] * len(columns), [np.column_stack(list(columns.values()))])


def _parts(scene: Scene, key: str) -> dict[str, np.ndarray]:
    """A column of the samples as columns of single numbers, by what tells them apart."""
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
    samples.csv, from 0, where the enclosure's displacement stands. Clusters have orientations too.
    """
    moving = _MOVING | _TURNING if scene.of_clusters else _MOVING
    names = ["sample", "time_s", "id", *moving]
    shape = ["%d", "%.9g", "%d", *["%.9g"] * len(moving)]
    rows = (_rows(scene, frame, list(moving.values())) for frame in range(len(scene.tables)))
    return _table(names, shape, rows)


def _rows(scene: Scene, frame: int, keys: list[str]) -> np.ndarray:
    table, sample = scene.tables.at(frame), scene.frame_sample[frame]
    same = np.ones(len(scene.radius))
    moving = [table[key] for key in keys]
    return np.column_stack(
        [sample * same, scene.time[sample] * same, np.arange(len(same)), *moving]
    )


def bodies_csv(scene: Scene) -> bytes:
    """What does not change of each particle."""
    rows = np.column_stack([np.arange(len(scene.radius)), scene.radius, scene.masses])
    return _table(["id", "radius_m", "mass_kg"], ["%d", "%.9g", "%.9g"], [rows])


def spheres_csv(scene: Scene) -> bytes:
    """The sub-spheres of a cluster, alike in all, about its centroid in its principal axes."""
    static = scene.trajectory.static
    offset, radius = static["sphere_offset"], static["sphere_radius"]
    rows = np.column_stack([np.arange(len(radius)), offset, radius])
    names = ["sphere", "x_m", "y_m", "z_m", "radius_m"]
    return _table(names, ["%d", *["%.9g"] * 4], [rows])


def _table(names: list[str], shape: list[str], parts: Iterable[np.ndarray]) -> bytes:
    text = io.BytesIO()
    text.write((",".join(names) + "\n").encode())
    for rows in parts:
        np.savetxt(text, rows, fmt=shape, delimiter=",")
    return text.getvalue()
