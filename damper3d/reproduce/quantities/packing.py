"""Packing fractions of a shape: means over packings, sizes, quantities, and the shipped table."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from damper3d.case.closed_forms import bouncing_bed_onset, effective_clearance
from granulab.campaign.claims.judge import Quantities
from granulab.campaign.output.layout import done, with_sd
from granulab.campaign.output.statistics import Sample, mean_sd, noise_of_difference, pooled_sd
from granulab.contact.files.datafile import shipped_rows

Row = dict[str, Any]
Shape = tuple[str, float]  # family and ratio

SPHERES = ("sphere", 1.0)  # of 5 mm, as in Table 6.3
BODIES = 100  # particles in the cell

_FILL = {"spheroid": 0.4115, "toroid": 0.393, "sphere": 7 / 15}  # of 90 of 3.8 mm and 110 of 3.5 mm
_HEAD = """\
# Random packing fractions by shape: means of damper3d reproduce packing (docs/damper/packing.md).
# close: frictionless, jammed in a periodic cell of 100; uncertainty: the standard deviation over
# packings that all shapes share and the largest change with the number in the cell, in quadrature.
"""


@dataclass
class Values:
    """Packing fractions of a shape; of the cell by the number of particles in it."""

    close: dict[int, Sample] = field(default_factory=dict)
    held: dict[int, float] = field(default_factory=dict)  # mean coordination [-]
    rattlers: dict[int, float] = field(default_factory=dict)  # mean share [-]
    loose: Sample | None = None
    shaken: Sample | None = None
    fill: float = 0.0  # ratio, of the thesis's number in its enclosure

    def largest(self) -> Sample | None:
        """Close packing with the most particles."""
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
    distances = []
    for row in shipped_rows("published", "damper_optimum_amplitude"):
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


class Readings(NamedTuple):
    """Data of the claims: the rows and the numbers of each shape."""

    rows: Sequence[Row]
    found: dict[Shape, Values]


PACKINGS = Quantities()


def text_of(shape: Shape) -> str:
    """As `--particles` takes it."""
    family, ratio = shape
    if shape == SPHERES:
        return "sphere:5mm"
    kind = family if family == "toroid" else "oblate" if ratio < 1 else "prolate"
    return f"{kind}:{ratio:g}"


@PACKINGS.quantity
def close_fraction(readings: Readings) -> list[Row]:
    """Close packing of each shape with the most particles in the cell."""
    largest = {shape: own.largest() for shape, own in readings.found.items()}
    return [
        _labels(shape) | {"value": sample.mean, "shown": with_sd(sample)}
        for shape, sample in largest.items()
        if sample
    ]


@PACKINGS.quantity
def neighbours(readings: Readings, bodies: int | None = None) -> list[Row]:
    """Mean coordination of each shape, of a number of particles in the cell or of the most."""
    found = []
    for shape, own in readings.found.items():
        number = max(own.held, default=None) if bodies is None else bodies
        if number in own.held:
            found.append(_labels(shape) | {"bodies": number, "value": own.held[number]})
    return found


@PACKINGS.quantity
def change_with_number(readings: Readings) -> list[Row]:
    """Change of the close packing between the two largest numbers in the cell, and its noise."""
    changes = {shape: size_change(own) for shape, own in readings.found.items()}
    return [
        _labels(shape) | {"value": change.value, "noise": change.noise}
        for shape, change in changes.items()
        if change
    ]


@PACKINGS.quantity
def shaken_and_close(readings: Readings) -> list[Row]:
    """Fraction of each shape shaken down in the enclosure, and jammed in the cell; `how`."""
    return [
        _labels(shape) | {"how": how, "value": sample.mean}
        for shape, own in readings.found.items()
        if own.shaken and BODIES in own.close
        for how, sample in (("shaken", own.shaken), ("close", own.close[BODIES]))
    ]


@PACKINGS.quantity
def distance_from_table_6_3(readings: Readings) -> list[Row]:
    """Mean |ln| of the thesis's onsets over eqs 6.11 and 6.13, by the packing of cell and bed."""
    own, spheres = readings.found.get(SPHERES), readings.found.get(("spheroid", 1.0))
    if own is None or own.shaken is None or spheres is None or BODIES not in spheres.close:
        return []
    packings = {"cell": spheres.close[BODIES].mean or 0.0, "bed": own.shaken.mean or 0.0}
    return [
        {"packing": name, "value": distance_from_table(fraction)} | packings
        for name, fraction in packings.items()
    ]


@PACKINGS.quantity
def overlap_left(readings: Readings) -> list[Row]:
    """Deepest overlap of each packing in the cell, over the radius."""
    return [
        {"shape": row["shape"], "ratio": row["ratio"], "value": row["overlap"]}
        for row in done(readings.rows)
        if row.get("overlap") is not None
    ]


def _labels(shape: Shape) -> Row:
    return {"shape": shape[0], "ratio": shape[1], "particles": text_of(shape)}
