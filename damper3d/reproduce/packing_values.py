"""From packings to a shape's numbers: means over packings, sizes, and the table that is shipped."""

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from damper3d.case.closed_forms import bouncing_bed_onset, effective_clearance
from granulab.campaign.output.statistics import Sample, mean_sd, noise_of_difference, pooled_sd
from granulab.contact.files.datafile import data_file

Row = dict[str, Any]
Shape = tuple[str, float]  # family and ratio

_FILL = {"spheroid": 0.4115, "toroid": 0.393, "sphere": 7 / 15}  # of 90 of 3.8 mm and 110 of 3.5 mm
_HEAD = """\
# Random packing fractions by shape: means of damper3d reproduce packing (docs/damper-packing.md).
# close: frictionless, jammed in a periodic cell of 100; uncertainty: the standard deviation over
# packings that all shapes share and the largest change with the number in the cell, in quadrature.
"""


@dataclass
class Values:
    """What is known of a shape; of the cell by the number of bodies in it."""

    close: dict[int, Sample] = field(default_factory=dict)
    held: dict[int, float] = field(default_factory=dict)  # mean coordination [-]
    rattlers: dict[int, float] = field(default_factory=dict)  # mean share [-]
    loose: Sample | None = None
    shaken: Sample | None = None
    fill: float = 0.0  # ratio, of the thesis's number in its enclosure

    def largest(self) -> Sample | None:
        """Close packing with the most bodies."""
        return self.close[max(self.close)] if self.close else None

    def onset_over(self, spheres: "Values | None", bodies: int) -> float | None:
        """Onset of eqs 6.11 and 6.13 over that of spheres at the same fill ratio."""
        if spheres is None or bodies not in self.close or bodies not in spheres.close:
            return None
        own, theirs = self.close[bodies].mean, spheres.close[bodies].mean
        assert own is not None
        assert theirs is not None
        return (1 - self.fill / own) / (1 - self.fill / theirs)


class Change(NamedTuple):
    """Of a fraction, and how much of it may be noise (95 %)."""

    value: float
    noise: float


def values(rows: Sequence[Row]) -> dict[Shape, Values]:
    """The numbers of each shape, of rows that are done; spheroids first, by rising ratio."""
    found: dict[Shape, Values] = {}
    for shape in sorted({(row["shape"], row["ratio"]) for row in rows}):
        own = [row for row in rows if (row["shape"], row["ratio"]) == shape]
        one = found[shape] = Values(fill=_FILL[shape[0]])
        for bodies in sorted({row["bodies"] for row in own if row["place"] == "cell"}):
            here = [r for r in own if r["place"] == "cell" and r["bodies"] == bodies]
            one.close[bodies] = mean_sd([row["fraction"] for row in here])
            one.held[bodies] = math.fsum(row["coordination"] for row in here) / len(here)
            one.rattlers[bodies] = math.fsum(row["rattlers"] for row in here) / len(here)
        beds = [row for row in own if row["place"] == "enclosure"]
        if beds:
            one.loose = mean_sd([row["loose"] for row in beds])
            one.shaken = mean_sd([row["close"] for row in beds])
    return found


def size_change(own: Values) -> Change | None:
    """Between the two largest numbers in the cell; None where there are no two packed twice."""
    if len(own.close) < 2:
        return None
    few, many = (own.close[bodies] for bodies in sorted(own.close)[-2:])
    noise = noise_of_difference(few, many)
    if noise is None or few.mean is None or many.mean is None:
        return None
    return Change(many.mean - few.mean, noise)


def distance_from_table(packing: float) -> float:
    """Mean |ln(Gamma/predicted)| of the onsets that the thesis simulated (Table 6.3)."""
    path = data_file("published", "damper_optimum_amplitude")
    assert path is not None  # shipped
    lines = path.read_text(encoding="utf-8").splitlines()
    distances = []
    for row in csv.DictReader(line for line in lines if not line.startswith("#")):
        if not row["approach"].startswith("DEM"):
            continue
        length = float(row["height_m"])
        clearance = effective_clearance(float(row["fill_ratio"]), length, packing)
        for frequency in (20, 40, 80):
            found = row[f"f{frequency}Hz"]
            if not found.startswith(">"):
                onset = float(bouncing_bed_onset(frequency, clearance))
                distances.append(abs(math.log(float(found) / onset)))
    return math.fsum(distances) / len(distances)


def shipped(rows: Sequence[Row]) -> str:
    """The text of data/packings/random.csv."""
    found = {shape: own for shape, own in values(rows).items() if 100 in own.close}
    pooled = pooled_sd([own.close[100] for own in found.values()])
    assert pooled is not None  # of two packings or more
    changes = [abs(change.value) for own in found.values() if (change := size_change(own))]
    uncertainty = math.hypot(pooled[0], max(changes))
    lines = ["family,ratio,close,close_uncertainty"]
    for (family, ratio), own in found.items():
        lines.append(f"{family},{ratio:g},{own.close[100].mean:.4f},{uncertainty:.4f}")
    return _HEAD + "\n".join(lines) + "\n"
