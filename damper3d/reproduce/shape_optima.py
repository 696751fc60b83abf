"""Where the efficiency of each shape peaks along Gamma, and what eq. 6.11 says of it.

The thesis takes the highest peak of a curve: at 20 and 40 Hz the onset of the bouncing bed (sec.
8.5.1), at higher frequencies the fluidisation optimum (sec. 8.5.2).
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from damper3d.case.random_packing import CLOSE_PACKING, close_packing
from damper3d.reproduce.optima import Optimum
from damper3d.reproduce.runs import Row
from damper3d.reproduce.shape_plan import HEIGHT, Shape, particle_text
from damper3d.studies.map.grid import MapResult
from damper3d.studies.map.peaks import Peak
from damper3d.studies.predict.prediction import Clearance, Prediction


class Line(NamedTuple):
    """What a curve of eta along Gamma is of."""

    shape: Shape
    orientation: str
    frequency: float  # [Hz]
    treatment: str = "sum"


Found = Mapping[Line, Optimum | None]


def rows_of(rows: Sequence[Row], line: Line) -> list[Row]:
    """The rows of a curve."""
    return [row for row in rows if row["part"] == "curves" and line_of(row) == line]


def line_of(row: Row) -> Line:
    """The curve that a row belongs to."""
    shape = (row["shape"], row["ratio"])
    return Line(shape, row["orientation"], row["frequency_hz"], row["treatment"])


def optima(rows: Sequence[Row]) -> dict[Line, Optimum | None]:
    """The highest peak of each curve that there are rows of; None where none stands out."""
    groups: dict[Line, list[Row]] = {}
    for row in rows:
        if row["part"] == "curves":
            groups.setdefault(line_of(row), []).append(row)
    return {line: _optimum(own, line) for line, own in sorted(groups.items())}


def _optimum(rows: Sequence[Row], line: Line) -> Optimum | None:
    mean = _highest(rows, line.frequency)
    if mean is None:
        return None
    alone = (
        _highest([row for row in rows if row["seed"] == seed], line.frequency)
        for seed in sorted({row["seed"] for row in rows})
    )
    averaged = MapResult.of(rows)
    top = float(averaged.gamma[averaged.at(line.frequency)][mean.index])
    logarithms = tuple(math.log(peak.gamma) for peak in alone if peak)
    return Optimum(mean, top, logarithms, _prediction(rows, line), line.frequency)


def _highest(rows: Sequence[Row], frequency: float) -> Peak | None:
    peaks = MapResult.of(rows).peaks(frequency)
    return max(peaks, key=lambda peak: peak.efficiency, default=None)


def _prediction(rows: Sequence[Row], line: Line) -> Prediction:
    """Eq. 6.11 with the clearance of the shape's close packing, and of that of spheres."""
    fill = next(row["fill_ratio"] for row in rows if row["state"] == "done")
    length = HEIGHT / 1e3
    own = close_packing(particle_text(line.shape))
    packings = {"close": own.value if own else None, "spheres": CLOSE_PACKING}
    clearances = tuple(
        Clearance(name, most, (1 - fill / most) * length) for name, most in packings.items() if most
    )
    name = f"{line.shape[0]} {line.shape[1]:g}"
    return Prediction(name, fill, length, line.orientation, clearances, None)
