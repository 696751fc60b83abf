"""The particle shapes of a table of slow tests, and their curves as means over the packings."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from granulab.campaign.output.layout import done
from granulab.campaign.output.statistics import Sample, among, mean_sd, quantile

Row = dict[str, Any]

# The thesis's (Figs 8.16 to 8.19), each family with its sphere, and an oblate, which it left out.
SPHEROIDS = (1.0, 1.25, 1.5, 2.0, 2.5, 3.0)
HOLES = (0.0, 0.05, 0.11, 0.2, 0.27, 0.33)
SHAPES = (
    *(f"prolate:{ratio:g}" for ratio in SPHEROIDS),
    *(f"toroid:{ratio:g}" for ratio in HOLES),
    "oblate:0.7",
)


@dataclass(frozen=True)
class Shape:
    """The tests of a shape that came to their end."""

    name: str  # as in the case
    rows: list[Row]

    def sample(self, column: str) -> Sample:
        """Mean and deviation of a column over the packings."""
        return mean_sd(self.values(column))

    def values(self, column: str) -> list[float]:
        """A column, a number a packing."""
        return [row[column] for row in self.rows]

    def curve(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Displacement (n,) [m]; rise of the force, mean and sample deviation (n,) [N].

        No deviation of one packing: NaN.
        """
        way = np.array(self.rows[0]["displacement_m"])
        each = np.array([
            np.interp(way, row["displacement_m"], np.array(row["force_n"]) - row["force_start_n"])
            for row in self.rows
        ])  # fmt: skip
        spread = each.std(axis=0, ddof=1) if len(each) > 1 else np.full(len(way), np.nan)
        return way, each.mean(axis=0), spread


@dataclass(frozen=True)
class Scatter:
    """Scatter of one packing about the mean of its shape, pooled over the shapes of a table.

    A shape has few packings, a table many shapes. Stiffnesses of compression are scattered in
    proportion, from shape to shape by a factor of ten; shear forces alike, all near mu N.
    """

    sd: float  # of one packing; over the mean where it is relative
    freedom: int
    relative: bool

    def error(self, sample: Sample) -> float:
        """Standard error of a mean."""
        assert sample.mean is not None
        scale = abs(sample.mean) if self.relative else 1.0
        return self.sd * scale / math.sqrt(sample.n)

    def half_width(self, *samples: Sample, comparisons: int = 1) -> float:
        """Half width of the 95 % interval of a mean, or of the difference of two.

        comparisons: so many such intervals are to hold together.
        """
        return quantile(self.freedom, among(comparisons)) * math.hypot(*map(self.error, samples))


def scatter_of(shapes: Mapping[str, Shape], test: str, column: str) -> Scatter | None:
    """The scatter of a column; None where no shape has two packings."""
    relative, squares, freedom = test == "compress", 0.0, 0
    for shape in shapes.values():
        values = np.array(shape.values(column))
        scale = values.mean() if relative else 1.0
        squares += float(np.sum(((values - values.mean()) / scale) ** 2))
        freedom += len(values) - 1
    return Scatter(math.sqrt(squares / freedom), freedom, relative) if freedom else None


def by_shape(rows: Sequence[Row]) -> dict[str, Shape]:
    """The tests that are done by their shape, in the order of the rows; only shapes with any."""
    found: dict[str, list[Row]] = {}
    for row in done(rows):
        found.setdefault(row["shape"], []).append(row)
    return {name: Shape(name, own) for name, own in found.items()}


def ratio_of(shape: str) -> float:
    """The number that stands in a shape's name, such as 1.5 in "prolate:1.5"."""
    return float(shape.partition(":")[2])


def family(shapes: dict[str, Shape], kind: str) -> dict[float, Shape]:
    """The shapes of a family, "prolate" or "toroid", by their rising ratio."""
    own = {ratio_of(n): s for n, s in shapes.items() if n.partition(":")[0] == kind}
    return dict(sorted(own.items()))
