"""The results of a finished run, read back from its folder and checked against their type.

They show themselves in a notebook, and give the run's series, frames, pictures and film.
"""

import base64
import html
import importlib
import json
import math
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from pydantic import TypeAdapter, ValidationError

from granulab.campaign.output.table import flat
from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.trajectory import Trajectory, read_trajectory
from granulab.errors import FolderError

if TYPE_CHECKING:
    from pandas import DataFrame

_AXES = "xyz"


class Results:
    """Base of a dataclass of results, which has the fields `reused` and `run_folder`."""

    run_folder: str

    @classmethod
    def read(cls, folder: RunFolder, *, reused: bool) -> Self:
        """Return the results kept in a finished run folder; FolderError where they are damaged."""
        kept = {**folder.read_summary(), "reused": reused, "run_folder": str(folder.path)}
        try:
            return cls._adapter().validate_python(kept)
        except ValidationError as error:
            problem = error.errors()[0]
            raise FolderError(
                f"{folder.path / 'summary.json'}: damaged ({problem['loc'][0]}: "
                f"{problem['msg'].lower()}); use --again to compute the run again"
            ) from None

    @classmethod
    @cache
    def _adapter(cls) -> TypeAdapter[Self]:
        """Return what checks a summary; a sweep reads many."""
        return TypeAdapter(cls)

    def trajectory(self) -> Trajectory:
        """All stored frames; FolderError where the run kept none."""
        return read_trajectory(self.run_folder)

    def records(self) -> "DataFrame":
        """The run's series by time [s], all SI: energies, forces on each wall, counts.

        A column for each number that a frame, or a sample, has of the whole bed; forces on walls
        and mean vectors by wall and axis, such as wall_force_bottom_z. FolderError as trajectory().
        """
        from pandas import DataFrame, Index

        frames = self.trajectory()
        walls = json.loads(frames.attributes.get("wall_names", "[]"))
        series: dict[str, Any] = {}
        for name, values in frames.items():
            axes = _AXES[: values.shape[-1]]
            if values.ndim == 1:
                series[name] = values
            elif values.ndim == 2 and values.shape[1] <= len(_AXES):
                series |= {f"{name}_{axis}": values[:, k] for k, axis in enumerate(axes)}
            elif name == "wall_force":
                series |= {
                    f"{name}_{wall.replace(' ', '_')}_{axis}": values[:, i, k]
                    for i, wall in enumerate(walls)
                    for k, axis in enumerate(axes)
                }
        return DataFrame(series, index=Index(series.pop("time"), name="time_s"))

    def plot(self) -> list[Path]:
        """Draw the run's pictures into its folder figures/; their paths."""
        return self._view().make_figures(self.run_folder, film=False)

    def film(self) -> Path:
        """Draw the film of all frames, with the pictures, into its folder figures/; its path."""
        return self._view().make_figures(self.run_folder)[-1]

    def _view(self) -> Any:
        """The module of the simulator's pictures, which stands above its results."""
        return importlib.import_module(f"{type(self).__module__.partition('.')[0]}.view.picture")

    def _repr_html_(self) -> str:
        """A table of the numbers and the first picture, for notebooks; series are left out."""
        rows = "".join(
            f"<tr><td>{html.escape(name)}</td><td>{html.escape(_word(value))}</td></tr>"
            for name, value in flat(vars(self))
            if not isinstance(value, list)
        )
        return f"<table>{rows}</table>{self._picture()}"

    def _picture(self) -> str:
        try:
            path = self.plot()[0]
            image = base64.b64encode(path.read_bytes()).decode("ascii")
        except (FolderError, OSError):  # it kept no frames, or its folder went away
            return ""
        return f'<img style="max-width: 100%" src="data:image/png;base64,{image}">'


def _word(value: bool | int | float | str | tuple[float, ...] | None) -> str:
    if value is None:
        return "-"
    if isinstance(value, tuple):  # an interval
        return " to ".join(map(_word, value))
    if isinstance(value, float) and math.isfinite(value):
        return f"{value:.6g}"
    return str(value)
