"""The container VTKHDF (PolyData with time steps, format 2.0), which ParaView opens.

A step has cells of four kinds, in this order: vertices, lines, polygons, strips. Each cell has
points of its own, which stand in the order of the cells; arrays go with the cells or the points.
"""

import io
from collections.abc import Mapping, Sequence

import h5py
import numpy as np
from numpy.typing import NDArray

KINDS = "Vertices", "Lines", "Polygons", "Strips"
_CHUNK_BYTES = 2**18


class PolyDataFile:
    """Takes the time steps of a VTKHDF file and gives its content as bytes.

    The file is made in memory, compressed step by step: HDF5 that meets a full disk itself ends
    the process. No two cells share a point, so the connectivity of any step is 0, 1, 2, ...: that
    of each kind is kept once, as long as the longest step needs, and all steps read it from its
    start. So all kinds but the last that is used must have as many points in every step. And each
    kind must be there in the first step: VTK 9.7 reads one that comes later as empty.
    """

    def __init__(self) -> None:
        self._image = io.BytesIO()
        self._file = h5py.File(self._image, "w")
        self._root = self._file.create_group("VTKHDF")
        self._root.attrs["Version"] = np.array([2, 0], dtype=np.int64)
        self._root.attrs["Type"] = np.bytes_("PolyData")  # the format requires ASCII, fixed length
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
        sizes: Mapping[str, Sequence[int] | NDArray[np.int64]],
        cells: Mapping[str, np.ndarray],
        at_points: Mapping[str, np.ndarray] | None = None,
    ) -> None:
        """Take one step at a time [s].

        points      (p, 3) [m]
        sizes       how many points each cell has, by kind ("Lines": [2, 2]); kinds may lack
        cells       arrays (cells, ...) by name, the same names and types in every step
        at_points   arrays (p, ...), likewise
        """
        starts = [np.cumsum([0, *sizes.get(kind, ())]) for kind in KINDS]
        ids = np.array([offsets[-1] for offsets in starts])
        if self._ids:
            first = self._ids[0]
            last = max(np.flatnonzero(first), default=0)
            if (ids != first)[:last].any() or ids[first == 0].any():
                raise ValueError(f"points by kind: {ids} after {first}; see PolyDataFile")
        self._extend("Points", points)
        for where, arrays in (("CellData", cells), ("PointData", at_points or {})):
            for key, values in arrays.items():
                self._extend(f"{where}/{key}", values)
        for kind, offsets in zip(KINDS, starts, strict=True):
            self._extend(f"{kind}/Offsets", offsets.astype(np.int64))
        self._times.append(time)
        self._points.append(len(points))
        self._cells.append(np.array([len(offsets) - 1 for offsets in starts]))
        self._ids.append(ids)

    def content(self) -> bytes:
        """The whole file, of one step at least; no step can follow."""
        root, n_steps = self._root, len(self._times)
        points, cells, ids = map(np.array, (self._points, self._cells, self._ids))
        root["NumberOfPoints"] = points
        first_point = np.cumsum([0, *ids[0, :-1]])
        for index, kind in enumerate(KINDS):
            root[f"{kind}/NumberOfCells"] = cells[:, index]
            root[f"{kind}/NumberOfConnectivityIds"] = ids[:, index]
            longest = np.arange(ids[:, index].max(), dtype=np.int64)
            self._extend(f"{kind}/Connectivity", first_point[index] + longest)
        steps = root.create_group("Steps")
        steps.attrs["NSteps"] = n_steps
        steps["Values"] = np.array(self._times)
        steps["PartOffsets"], steps["NumberOfParts"] = np.arange(n_steps), np.ones(n_steps, int)
        steps["PointOffsets"], steps["CellOffsets"] = _before(points), _before(cells)
        steps["ConnectivityIdOffsets"] = np.zeros((n_steps, len(KINDS)), dtype=np.int64)
        for where, counts in (("Cell", cells.sum(axis=1)), ("Point", points)):
            for key in root.get(f"{where}Data", ()):
                steps[f"{where}DataOffsets/{key}"] = _before(counts)
        self._file.close()
        return self._image.getvalue()

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
    """Return how many there were in all earlier steps."""
    return np.cumsum(counts, axis=0) - counts
