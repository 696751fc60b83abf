"""Exported films as ParaView reads them."""

from pathlib import Path

from vtkmodules.vtkIOHDF import vtkHDFReader


class Film:
    """A VTKHDF file as VTK's own reader gives it."""

    def __init__(self, path: Path) -> None:
        self.reader = vtkHDFReader()
        self.reader.SetFileName(str(path))
        self.reader.UpdateInformation()
        self.n_steps = self.reader.GetNumberOfSteps()

    def step(self, index: int):
        """The vtkPolyData of a step."""
        self.reader.SetStep(index)
        self.reader.Update()
        return self.reader.GetOutput()
