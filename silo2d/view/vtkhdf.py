"""A run as one VTKHDF file for ParaView; see granulab.campaign.output.vtkhdf.

Each stored frame is a step. The cells of a step are the walls as lines, without the door, and then
the grains that are still simulated as polygons, in ascending order. Their arrays, SI units:

    velocity (3) [m/s]   spin [rad/s]   kind, layer   inside: 1 until the centroid passes y = 0
    id: of a grain from 0 on; of the walls -1, -2, ... in the order of the run folder
    stress (6: xx, yy, zz, xy, yz, xz) [N/m], see grain_stress.py; NaN in frames without contacts,
        left out where the run folder keeps none

A wall has kind, layer and inside -1, no velocity and stress NaN. Polygons are the outlines that
the run folder keeps: chords of m pieces to an arc of turn t and radius r lie r (1 - cos(t/2m))
inside it at most.
"""

import numpy as np
from numpy.typing import NDArray

from granulab.campaign.output.vtkhdf import PolyDataFile
from granulab.campaign.runs.ragged import Tables
from silo2d.measures.from_contacts.particle_stress import grain_stress
from silo2d.view.scene import Scene


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
    grains = np.flatnonzero(scene.trajectory["inside"][frame])
    outlines = [np.empty((0, 2))] * scene.n_grains
    for which, around in scene.placed(frame, grains):
        for grain, outline in zip(which, around, strict=True):
            outlines[grain] = outline
    plane = np.concatenate([walls.reshape(-1, 2), *(outlines[grain] for grain in grains)])
    points = np.column_stack([plane, np.zeros(len(plane))]).astype(np.float32)
    now = {key: scene.trajectory[key][frame][grains] for key in ("vx", "vy", "spin", "out_time")}
    velocity = np.column_stack([now["vx"], now["vy"], np.zeros(len(grains))])
    still, none = np.zeros((len(walls), 3)), np.full(len(walls), -1)
    arrays: dict[str, np.ndarray] = {
        "velocity": np.concatenate([still, velocity]).astype(np.float32),
        "spin": np.concatenate([still[:, 0], now["spin"]]).astype(np.float32),
        "id": np.concatenate([none - np.arange(len(walls)), grains]).astype(np.int32),
        "kind": np.concatenate([none, static["kind"][grains]]).astype(np.int32),
        "layer": np.concatenate([none, static["layer"][grains]]).astype(np.int32),
        "inside": np.concatenate([none, np.isnan(now["out_time"])]).astype(np.int8),
    }
    polygons = [len(outlines[grain]) for grain in grains]
    return points, {"Lines": [2] * len(walls), "Polygons": polygons}, arrays


def _stress(
    scene: Scene, contacts: Tables, frame: int, ids: NDArray[np.int32]
) -> NDArray[np.float32]:
    """Of the cells (c, 6), in VTK's order of a symmetric tensor."""
    stress = np.full((len(ids), 6), np.nan, dtype=np.float32)
    found = grain_stress(scene, contacts, frame)
    if found is not None:
        stress[ids >= 0] = 0.0
        for component, (row, column) in ((0, (0, 0)), (1, (1, 1)), (3, (0, 1))):
            stress[ids >= 0, component] = found[ids[ids >= 0], row, column]
    return stress
