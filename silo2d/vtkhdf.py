"""A run as one VTKHDF file (PolyData with time steps, format 2.0), which ParaView opens.

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

import io

import h5py
import numpy as np
from numpy.typing import NDArray

from campaign.ragged import Tables
from silo2d.grain_stress import grain_stress
from silo2d.scene import Scene

_CHUNK_BYTES = 2**18
_KINDS_OF_CELLS = ["Vertices", "Lines", "Polygons", "Strips"]
_LINES = 1


def vtkhdf(scene: Scene, contacts: Tables | None = None) -> bytes:
    """The run as a VTKHDF file, with stresses where its contacts are given.

    The file is made in memory, compressed frame by frame: HDF5 that meets a full disk itself
    ends the process.
    """
    image = io.BytesIO()
    with h5py.File(image, "w") as file:
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = np.array([2, 0], dtype=np.int64)
        root.attrs["Type"] = np.bytes_("PolyData")  # the format asks for ASCII of fixed length
        writer = _StepWriter(root)
        for frame, time in enumerate(scene.time):
            points, n_lines, sizes, arrays = _cells(scene, frame)
            if contacts is not None:
                arrays["stress"] = _stress(scene, contacts, frame, arrays["id"])
            writer.append(float(time), points, n_lines, sizes, arrays)
        writer.finish()
    return image.getvalue()


def _cells(
    scene: Scene, frame: int
) -> tuple[NDArray[np.float32], int, NDArray[np.int64], dict[str, np.ndarray]]:
    """Points (p, 3) of a frame, the number of lines, points of each polygon, arrays of cells."""
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
    sizes = np.array([len(outlines[grain]) for grain in grains], dtype=np.int64)
    return points, len(walls), sizes, arrays


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


class _StepWriter:
    """Appends time steps of one part each to a VTKHDF group.

    No two cells share a point, so the connectivity of any step is 0, 1, 2, ...: it is kept once,
    as long as the longest step needs, and all steps read it from its start.
    """

    def __init__(self, root: h5py.Group) -> None:
        self._root = root
        # Kept open: HDF5 compresses what it holds of a dataset each time that this is closed.
        self._open: dict[str, h5py.Dataset] = {}
        self._times: list[float] = []
        self._points: list[int] = []
        self._cells: list[NDArray[np.int64]] = []
        self._ids: list[NDArray[np.int64]] = []

    def append(
        self,
        time: float,
        points: NDArray[np.float32],
        n_lines: int,
        sizes: NDArray[np.int64],
        arrays: dict[str, np.ndarray],
    ) -> None:
        """Take one step: points (p, 3), of which each line has 2 and polygon k sizes[k]."""
        self._extend("Points", points)
        for key, values in arrays.items():
            self._extend(f"CellData/{key}", values)
        empty = np.zeros(1, dtype=np.int64)
        starts = [empty, 2 * np.arange(n_lines + 1), np.cumsum([0, *sizes]), empty]
        for name, offsets in zip(_KINDS_OF_CELLS, starts, strict=True):
            self._extend(f"{name}/Offsets", offsets.astype(np.int64))
        self._times.append(time)
        self._points.append(len(points))
        self._cells.append(np.array([len(offsets) - 1 for offsets in starts]))
        self._ids.append(np.array([offsets[-1] for offsets in starts]))

    def finish(self) -> None:
        """Write what tells the steps apart."""
        root, n_steps = self._root, len(self._times)
        points, cells, ids = map(np.array, (self._points, self._cells, self._ids))
        root["NumberOfPoints"] = points
        first_point = [0, 0, ids[0, _LINES], 0]  # those of the walls come first, in every step
        for index, name in enumerate(_KINDS_OF_CELLS):
            root[f"{name}/NumberOfCells"] = cells[:, index]
            root[f"{name}/NumberOfConnectivityIds"] = ids[:, index]
            longest = np.arange(ids[:, index].max(), dtype=np.int64)
            self._extend(f"{name}/Connectivity", first_point[index] + longest)
        steps = root.create_group("Steps")
        steps.attrs["NSteps"] = n_steps
        steps["Values"] = np.array(self._times)
        steps["PartOffsets"], steps["NumberOfParts"] = np.arange(n_steps), np.ones(n_steps, int)
        steps["PointOffsets"], steps["CellOffsets"] = _before(points), _before(cells)
        steps["ConnectivityIdOffsets"] = np.zeros((n_steps, len(_KINDS_OF_CELLS)), dtype=np.int64)
        for key in root["CellData"]:
            steps[f"CellDataOffsets/{key}"] = _before(cells.sum(axis=1))

    def _extend(self, name: str, rows: np.ndarray) -> None:
        """Append rows to a compressed dataset, which is made the first time."""
        if name not in self._open:
            one_row = rows.dtype.itemsize * int(np.prod(rows.shape[1:]))
            self._open[name] = self._root.create_dataset(
                name,
                shape=(0, *rows.shape[1:]),
                maxshape=(None, *rows.shape[1:]),
                dtype=rows.dtype,
                chunks=(_CHUNK_BYTES // one_row, *rows.shape[1:]),
                compression="gzip",
                shuffle=True,
            )
        dataset = self._open[name]
        dataset.resize(len(dataset) + len(rows), axis=0)
        dataset[len(dataset) - len(rows) :] = rows


def _before(counts: NDArray[np.int64]) -> NDArray[np.int64]:
    """How many there were in all earlier steps."""
    return np.cumsum(counts, axis=0) - counts
