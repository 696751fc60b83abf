"""Time steps of vertices, lines and polygons as ParaView's own reader gives them back."""

from pathlib import Path

import numpy as np
import pytest

from granulab.campaign.output.vtkhdf import PolyDataFile

SPHERES = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0]], dtype=np.float32)
WALL = np.array([[0, 0, 5], [1, 0, 5]], dtype=np.float32)


def polygon(n: int) -> np.ndarray:
    return np.column_stack([np.arange(n), np.arange(n) ** 2, np.full(n, 7)]).astype(np.float32)


def file_of(corners: list[int]) -> bytes:
    """Steps of three spheres as vertices, a line and a polygon with so many corners (0: none)."""
    file = PolyDataFile()
    for k, n in enumerate(corners):
        points = np.concatenate([SPHERES + k, WALL, polygon(n)])
        sizes = {"Polygons": [n] if n else [], "Lines": [2], "Vertices": [1, 1, 1]}
        cells = {"id": np.arange(4 + (n > 0), dtype=np.int32) + 10 * k}
        at_points = {"velocity": (points * 2).astype(np.float32)}
        file.append(0.5 * k, points, sizes, cells, at_points)
    return file.content()


def read(path: Path, step: int):
    """The points, cells as lists of point numbers, ids and velocities of a step."""
    vtk = pytest.importorskip("vtkmodules.vtkIOHDF")
    from vtkmodules.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    reader.SetStep(step)
    reader.Update()
    data = reader.GetOutput()
    cells = [
        [cell.GetPointId(k) for k in range(cell.GetNumberOfPoints())]
        for cell in (data.GetCell(c) for c in range(data.GetNumberOfCells()))
    ]
    return (
        vtk_to_numpy(data.GetPoints().GetData()),
        cells,
        vtk_to_numpy(data.GetCellData().GetArray("id")),
        vtk_to_numpy(data.GetPointData().GetArray("velocity")),
    )


def test_every_step_comes_back_as_it_was(tmp_path):
    """The polygon grows and goes; its points follow those of spheres and line."""
    corners = [3, 5, 0]
    path = tmp_path / "run.vtkhdf"
    path.write_bytes(file_of(corners))
    for step, n in enumerate(corners):
        points, cells, ids, velocity = read(path, step)
        np.testing.assert_array_equal(points, np.concatenate([SPHERES + step, WALL, polygon(n)]))
        assert cells == [[0], [1], [2], [3, 4], *([list(range(5, 5 + n))] if n else [])]
        np.testing.assert_array_equal(ids, np.arange(len(cells)) + 10 * step)
        np.testing.assert_array_equal(velocity, 2 * points)


def test_the_same_steps_give_the_same_bytes():
    assert file_of([3, 4]) == file_of([3, 4])


@pytest.mark.parametrize("sizes", [{"Vertices": [1, 1]}, {"Vertices": [1], "Polygons": [3]}])
def test_what_the_format_would_misread_is_refused(sizes):
    """Kinds before the last share one connectivity, which a change would shift."""
    file = PolyDataFile()
    for _ in range(2):
        file.append(0.0, SPHERES, {"Vertices": [1], "Lines": [2]}, {})
    with pytest.raises(ValueError, match="points by kind"):
        file.append(1.0, SPHERES, {"Lines": [2], **sizes}, {})
