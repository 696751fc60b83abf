"""Quantities of particle shapes: where eta peaks along Gamma, what eq. 6.11 says, what changes it.

The thesis takes the highest peak of a curve: at 20 and 40 Hz the onset of the bouncing bed (sec.
8.5.1), at higher frequencies the fluidisation optimum (sec. 8.5.2).
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from itertools import product
from typing import Any, NamedTuple

from damper3d.case.random_packing import CLOSE_PACKING, close_packing
from damper3d.reproduce.panels import ORIENTATIONS, Row
from damper3d.reproduce.quantities.curves import curve
from damper3d.reproduce.quantities.optima import Optimum, located
from damper3d.reproduce.quantities.properties import STANDARD, VALUES, in_words
from damper3d.studies.map.grid import MapResult
from damper3d.studies.map.peaks import Peak, highest
from damper3d.studies.predict.prediction import Clearance, Prediction
from granulab.campaign.claims.judge import Quantities
from granulab.campaign.output.layout import done
from granulab.campaign.output.statistics import Slope, mean_sd, slope
from granulab.contact.files.datafile import shipped_rows

Shape = tuple[str, float]  # family of the thesis's tables, or GRIDDED, and ratio

GRIDDED = "gridded"  # the thesis's own oblates, of nine sub-spheres; see damper3d.shapes.oblate

BOUNCING = 20.0, 40.0  # Hz at which the thesis finds the bouncing bed (sec. 8.5.1)
HEIGHT = 40  # mm

_TELLING = 1.5  # by so much shape would shift the optimum: as "insensitive" is judged elsewhere

SHAPES = Quantities()


def shapes() -> tuple[Shape, ...]:
    """The shapes of Tables 8.1 and 8.2 that the thesis simulated."""
    return tuple(sphericities())


@cache
def sphericities() -> dict[Shape, float]:
    """Sphericity (eq. 8.3) of each shape, as these tables print it."""
    return {
        (row["shape"], float(row["ratio"])): float(row["sphericity"])
        for row in shipped_rows("published", "nonspherical_shapes")
        if row["simulated"] == "yes"
    }


def gridded() -> tuple[Shape, ...]:
    """The oblates of Table 8.1 as the thesis made them."""
    return tuple((GRIDDED, ratio) for family, ratio in shapes() if family != "toroid" and ratio < 1)


def sphericity(shape: Shape) -> float:
    """Sphericity of a shape; of one that the thesis made on a grid, that of the true spheroid."""
    family, ratio = shape
    return sphericities()["spheroid" if family == GRIDDED else family, ratio]


def particle_text(shape: Shape) -> str:
    """As `--particles` takes it; the sphere of a family is its ratio of 1 or 0."""
    family, ratio = shape
    if family == "toroid":
        return f"toroid:{ratio:g}"
    if family == GRIDDED:
        return f"oblate_grid:{ratio:g}"
    return f"{'oblate' if ratio < 1 else 'prolate'}:{ratio:g}"


class Line(NamedTuple):
    """Labels of a curve of eta along Gamma."""

    shape: Shape
    orientation: str
    frequency: float  # [Hz]
    model: str = "sum"


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
    return {line: optimum_of(own, line) for line, own in sorted(groups.items())}


def optimum_of(rows: Sequence[Row], line: Line) -> Optimum | None:
    """The highest peak of the rows of a curve; None where none stands out."""
    if not any(row["state"] == "done" for row in rows):
        return None

    def top(result: MapResult) -> Peak | None:
        return highest(result.peaks(line.frequency))

    return located(rows, line.frequency, top, _prediction(rows, line))


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


class Readings(NamedTuple):
    """Data of the claims: the rows and the optima of their curves."""

    rows: Sequence[Row]
    found: Found


def onsets(found: Found, family: str, like: Line) -> dict[float, Optimum]:
    """The optima of a family that agree with a line in all but the shape, by rising ratio."""
    return {
        line.shape[1]: one
        for line, one in sorted(found.items())
        if one is not None and line.shape[0] == family and line[1:] == like[1:]
    }


def bouncing_lines() -> list[Line]:
    """A line of spheres at each frequency and orientation of the bouncing bed."""
    return [Line(("spheroid", 1.0), o, f) for f, o in product(BOUNCING, ORIENTATIONS)]


def by_sphericity(found: Found, line: Line) -> list[tuple[float, float]]:
    """(sphericity, onset over the sphere's of its family) of prolates and toroids, falling."""
    pairs = []
    for family, sphere in (("spheroid", 1.0), ("toroid", 0.0)):
        own = onsets(found, family, line)
        pairs += [
            (sphericity((family, ratio)), one.gamma / own[sphere].gamma)
            for ratio, one in own.items()
            if sphere in own and (family == "toroid" or ratio >= 1)
        ]
    return sorted(pairs, reverse=True)


@SHAPES.quantity
def over_sphericity(readings: Readings, of: str, low: float, high: float) -> list[Row]:
    """Onsets over the sphere's of prolates and toroids, with a sphericity from low to high.

    of    "times": over the sphere's; "part": what they rise over the largest rise of all; "off":
          how far from the mean of those listed, over what that one rises
    """
    found = []
    for line in bouncing_lines():
        pairs = by_sphericity(readings.found, line)
        own = [(x, times) for x, times in pairs if low <= x <= high]
        if len({x for x, _ in pairs}) < 4 or not own:
            continue
        most = max(times for _, times in pairs) - 1
        mean = sum(times for _, times in own) / len(own)
        for x, times in own:
            parts = {"times": times, "part": (times - 1) / most if most > 0 else -math.inf,
                     "off": abs(times - mean) / (mean - 1) if mean > 1 else math.inf}  # fmt: skip
            found.append(_at(line) | {"sphericity": x, "value": parts[of], "times": times,
                                      "most": most + 1, "level": mean})  # fmt: skip
    return found


@SHAPES.quantity
def slope_over_sphericity(readings: Readings, low: float, high: float) -> list[Row]:
    """Slope of ln onset over sphericity of the same; `change` from the highest to the lowest."""
    found: list[Row] = []
    for line in bouncing_lines():
        own = [(x, y) for x, y in by_sphericity(readings.found, line) if low <= x <= high]
        shown = ", ".join(f"{times:.2f} at {x:.3f}" for x, times in own)
        found += _trend(line, own, low - high, shown)
    return found


def _trend(line: Line, pairs: Sequence[tuple[float, float]], span: float, shown: str) -> list[Row]:
    """Slope of ln y over x of some pairs (x, y), and by how much y changes over a span of x."""
    trend = slope([x for x, _ in pairs], [math.log(y) for _, y in pairs])
    if trend is None:
        return []
    hidden = abs(trend.value) <= trend.half_width
    return [
        _at(line) | {"value": trend.value, "change": math.exp(span * trend.value) - 1,
                     "remark": " (within noise)" * hidden, "shown": shown}
    ]  # fmt: skip


@SHAPES.quantity
def onset(readings: Readings) -> list[Row]:
    """Gamma of the bouncing bed's onset of each shape; eta there, and the bracket in `shown`."""
    return [
        _at(line) | {"family": family, "ratio": ratio, "value": one.gamma,
                     "eta": one.mean.efficiency, "shown": _shown(ratio, one)}
        for line in bouncing_lines()
        for family in ("spheroid", "toroid", GRIDDED)
        for ratio, one in onsets(readings.found, family, line).items()
    ]  # fmt: skip


@SHAPES.quantity
def best_efficiency(readings: Readings) -> list[Row]:
    """Efficiency at the onset of each shape."""
    return [one | {"value": one["eta"]} for one in onset(readings)]


@SHAPES.quantity
def departure_from_plateau(readings: Readings) -> list[Row]:
    """Return how far the onsets of 1.5 and more are from that of 1.5, over the rise from 1 to 1.5.

    Infinite where there is no rise. rise, away: in Gamma, the rise and the largest departure.
    """
    found: list[Row] = []
    for line in bouncing_lines():
        own = onsets(readings.found, "spheroid", line)
        zone = {ratio: one for ratio, one in own.items() if ratio >= 1.5}
        if 1.0 not in own or 1.5 not in own or len(zone) < 3:
            continue
        rise = own[1.5].gamma - own[1.0].gamma
        away = {ratio: abs(one.gamma - own[1.5].gamma) for ratio, one in zone.items()}
        found += [
            _at(line) | {"value": away[ratio] / rise if rise > 0 else math.inf, "rise": rise,
                         "away": max(away.values()), "shown": _shown(ratio, one)}
            for ratio, one in zone.items()
        ]  # fmt: skip
    return found


@SHAPES.quantity
def rise_beyond_packing(readings: Readings) -> list[Row]:
    """Onset of 1.5 over that of the sphere; `packed`: the same of eq. 6.11 with close packings."""
    found = []
    for line in bouncing_lines():
        own = onsets(readings.found, "spheroid", line)
        if 1.0 in own and 1.5 in own:
            closer, sphere = own[1.5].predicted("close"), own[1.0].predicted("close")
            if closer and sphere:
                times, packed = own[1.5].gamma / own[1.0].gamma, closer / sphere
                found.append(_at(line) | {"value": times, "packed": packed, "change": times - 1,
                                          "of_packing": packed - 1})  # fmt: skip
    return found


@SHAPES.quantity
def slope_over_hole_ratio(readings: Readings) -> list[Row]:
    """Slope of ln onset over the hole ratio of toroids; `change` from 0.05 to 0.33."""
    found: list[Row] = []
    for line in bouncing_lines():
        own = {r: one for r, one in onsets(readings.found, "toroid", line).items() if r > 0}
        shown = ", ".join(_shown(ratio, one) for ratio, one in own.items())
        found += _trend(line, [(ratio, one.gamma) for ratio, one in own.items()], 0.28, shown)
    return found


@SHAPES.quantity
def gain_past_onset(readings: Readings) -> list[Row]:
    """Least and largest (most) gain of eta of a prolate over the sphere from its onset on."""
    found = []
    for at, ratio in product(bouncing_lines(), (1.5, 3.0)):
        line = at._replace(shape=("spheroid", ratio))
        own = readings.found.get(line)
        if own is None:
            continue
        theirs, ours = (
            curve(rows_of(readings.rows, one), "efficiency").points for one in (at, line)
        )
        gains = [ours[g] - theirs[g] for g in ours.keys() & theirs.keys() if g >= own.gamma]
        if gains:
            found.append(_at(at) | {"ratio": ratio, "value": min(gains), "most": max(gains)})
    return found


@SHAPES.quantity
def fluidisation_optimum(readings: Readings) -> list[Row]:
    """Gamma of each shape's optimum above 40 Hz (NaN: no peak); eta; how many have peaks."""
    lines = {line: one for line, one in readings.found.items() if line.frequency > max(BOUNCING)}
    found: list[Row] = []
    for where in sorted({(line.frequency, line.orientation) for line in lines}):
        own = {
            line.shape: one
            for line, one in lines.items()
            if (line.frequency, line.orientation) == where
        }
        true = [one for shape, one in own.items() if shape[0] != GRIDDED]
        found += [
            {"frequency_hz": where[0], "orientation": where[1], "family": shape[0],
             "ratio": shape[1], "particles": particle_text(shape),
             "value": one.gamma if one else math.nan,
             "eta": one.mean.efficiency if one else math.nan,
             "peaks": sum(each is not None for each in true), "curves": len(true)}
            for shape, one in own.items()
        ]  # fmt: skip
    return found


@SHAPES.quantity
def trend_over_shape(readings: Readings) -> list[Row]:
    """Slopes of ln Gamma over ln aspect ratio of prolates, and over the hole ratio of toroids.

    noise: so that all slopes without a trend lie within theirs in 95 of 100 tables. telling: the
    slope that changes Gamma by _TELLING over the shapes there are.
    """
    from pandas import DataFrame

    optima = DataFrame(fluidisation_optimum(readings))
    found = []
    places = ["frequency_hz", "orientation"]
    for (frequency, orientation), own in optima.groupby(places) if len(optima) else ():
        counts = own.iloc[0][["peaks", "curves"]].to_dict()
        own = own.dropna(subset="value")
        prolates = own[(own["family"] == "spheroid") & (own["ratio"] >= 1)]
        toroids = own[own["family"] == "toroid"]
        for name, x, gamma in (
            ("prolates", map(math.log, prolates["ratio"]), prolates["value"]),
            ("toroids", toroids["ratio"], toroids["value"]),
        ):
            at = list(x)
            trend = slope(at, list(map(math.log, gamma)))
            labels = {"frequency_hz": frequency, "orientation": orientation, "name": name}
            found.append((counts | labels, trend, max(at, default=0) - min(at, default=0)))
    known = sum(trend is not None for _, trend, _ in found)
    return [
        labels | {"value": trend.value, "noise": trend.half_width_among(known),
                  "telling": math.log(_TELLING) / span}
        if trend else labels | dict.fromkeys(("value", "noise", "telling"), math.nan)
        for labels, trend, span in found
    ]  # fmt: skip


@SHAPES.quantity
def slope_over_frequency(readings: Readings, of: str) -> list[Row]:
    """Slope of ln of each shape's optimum ("value") or of its "eta" over ln f, of three or more."""
    labels = "orientation", "family", "ratio"
    curves: dict[tuple[Any, ...], list[tuple[float, float]]] = {}
    for one in fluidisation_optimum(readings):
        if not math.isnan(one["value"]) and one["family"] != GRIDDED:
            point = one["frequency_hz"], math.log(one[of])
            curves.setdefault(tuple(one[name] for name in labels), []).append(point)
    trends = {key: _per_e_fold(points) for key, points in sorted(curves.items())}
    return [
        dict(zip(labels, key, strict=True)) | {"value": trend.value}
        for key, trend in trends.items()
        if trend
    ]


def _per_e_fold(points: Iterable[tuple[float, float]]) -> Slope | None:
    """Slope of y over ln x."""
    pairs = list(points)
    return slope([math.log(x) for x, _ in pairs], [y for _, y in pairs])


def values_of(rows: Sequence[Row], name: str) -> dict[float, dict[float, float]]:
    """By rising value of a property: mean efficiency over the packings, by aspect ratio."""
    groups: dict[float, dict[float, list[float]]] = {}
    for value, row in _varied(rows, name):
        groups.setdefault(value, {}).setdefault(row["ratio"], []).append(row["efficiency"])
    return {
        value: {ratio: mean_sd(etas).mean or 0.0 for ratio, etas in sorted(own.items())}
        for value, own in sorted(groups.items())
    }


def _varied(rows: Sequence[Row], name: str) -> list[tuple[float, Row]]:
    """The runs that differ in one property only, its standard among them, with its value."""
    own = [row for row in rows if row["part"] == "sensitivity"]
    return [
        (STANDARD[name] if row["property"] == "standard" else row["value"], row)
        for row in done(own)
        if row["property"] in (name, "standard")
    ]


@SHAPES.quantity
def slope_over_property(readings: Readings, name: str) -> list[Row]:
    """Slope of eta over ln of a property, of all packings of each aspect ratio, with its noise."""
    points: dict[float, list[tuple[float, float]]] = {}
    for value, row in _varied(readings.rows, name):
        points.setdefault(row["ratio"], []).append((value, row["efficiency"]))
    trends = {ratio: _per_e_fold(own) for ratio, own in sorted(points.items())}
    return [
        {"ratio": ratio, "value": trend.value, "noise": trend.half_width}
        for ratio, trend in trends.items()
        if trend
    ]


@SHAPES.quantity
def gain_of_prolates(readings: Readings) -> list[Row]:
    """Least gain of eta of prolates of 1.5 and more over the sphere, for each property's values.

    eta at Gamma 35 stands for the onset there (the thesis's own argument).
    """
    return [
        {"property": name, "setting": in_words(name, value),
         "value": min(eta for ratio, eta in etas.items() if ratio >= 1.5) - etas[1.0]}
        for name in VALUES
        for value, etas in values_of(readings.rows, name).items()
        if 1.0 in etas and 1.5 in etas
    ]  # fmt: skip


@SHAPES.quantity
def slope_over_friction(readings: Readings) -> list[Row]:
    """Slope over friction of eta(1.5) - eta(1), of three values or more; `shown`: each."""
    gains = {
        value: etas[1.5] - etas[1.0]
        for value, etas in values_of(readings.rows, "friction").items()
        if 1.0 in etas and 1.5 in etas
    }
    trend = slope(list(gains), list(gains.values()))
    shown = ", ".join(f"mu {value:g} {gain:+.3f}" for value, gain in gains.items())
    return [{"value": trend.value, "shown": shown}] if trend else []


def _at(line: Line) -> Row:
    return {"frequency_hz": line.frequency, "orientation": line.orientation}


def _shown(ratio: float, one: Optimum) -> str:
    """An onset with what grid and noise leave open."""
    low, high = one.mean.bracket
    return f"{ratio:g}: {one.gamma:.3g} [{low:.3g}, {high:.3g}]"
