"""Quantities of the phases: which are found, where each begins and ends, in which order.

Of `Points` (readings.py): `cycles` 8 are the thesis's, and Gammas from 1 on those of its maps.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from statistics import median
from typing import Any

from damper3d.measures.phases.criteria import MOST, PHASES, UNEVEN
from damper3d.reproduce.phases.points import ABOUT_ONE, BOUNCING
from damper3d.reproduce.phases.readings import OURS, Point, Points
from damper3d.reproduce.quantities.maps import exponent
from granulab.campaign.claims.judge import Quantities

Row = dict[str, Any]

PHASE_MAPS = Quantities()

# Principal phases (sec. 2.5), and the order in which phases follow each other with Gamma (sec.
# 6.4.3). The transition leads from fluidisation to convection; the bouncing bed is in no order.
KINDS: dict[str, tuple[str, int]] = {
    "solid_like": ("solid", 0),
    "local_fluidisation": ("fluidisation", 1),
    "partial_fluidisation": ("fluidisation", 1),
    "global_fluidisation": ("fluidisation", 2),
    "fluidisation_convection": ("fluidisation", 2),
    "transition": ("fluidisation", 3),
    "leidenfrost": ("convection", 4),
    "convection": ("convection", 4),
    "buoyancy_convection": ("convection", 5),
}
BAND = 12.0, 80.0  # Gamma of the Leidenfrost effect, above 40 Hz (sec. 6.4.3.3)
MAP = "orientation", "height_mm", "cycles"
COLUMN = *MAP, "frequency_hz"


def label(name: str) -> str:
    """A phase's name as maps and legends have it."""
    return next(looks[name].label for looks in PHASES.values() if name in looks)


def grouped(points: Iterable[Point], *labels: str) -> Iterator[tuple[Row, list[Point]]]:
    """Labels and points, by rising Gamma, of each group that has the same ones."""
    found: dict[tuple[Any, ...], list[Point]] = {}
    for one in points:
        found.setdefault(tuple(getattr(one, name) for name in labels), []).append(one)
    for key, own in found.items():
        yield dict(zip(labels, key, strict=True)), own


def in_maps(points: Points, least: float = 1.0, most: float = 100.0) -> list[Point]:
    """The points at Gammas from `least` to `most`, without those close about Gamma 1."""
    return [one for one in points if least <= one.gamma <= most and one.gamma not in ABOUT_ONE]


@PHASE_MAPS.quantity
def counts(points: Points, least: float = 1.0, most: float = 100.0) -> list[Row]:
    """Number of points of each map that have each name, at Gammas from `least` to `most`."""
    return [
        labels | {"phase": name, "label": look.label, "of": len(own),
                  "value": sum(one.name == name for one in own)}
        for labels, own in grouped(in_maps(points, least, most), *MAP)
        for name, look in PHASES[labels["orientation"]].items()
    ]  # fmt: skip


@PHASE_MAPS.quantity
def onset(points: Points, phase: str) -> list[Row]:
    """Onset of a phase at each frequency: the first Gamma named so, and the last before.

    Not where the first Gamma that was run has the name, nor where none has.
    """
    items = []
    for labels, own in grouped(points, *COLUMN):
        first = next((k for k, one in enumerate(own) if one.name == phase), None)
        if first:
            items.append(labels | _between(own[first - 1], own[first]))
    return items


@PHASE_MAPS.quantity
def end_of_rest(points: Points, their_low: float, their_high: float) -> list[Row]:
    """The last Gamma up to which all are solid-like at a frequency, and the next one."""
    items = []
    for labels, own in grouped(points, *COLUMN):
        moves = next((k for k, one in enumerate(own) if one.name != "solid_like"), None)
        if moves:
            theirs = {"their_low": their_low, "their_high": their_high}
            items.append(labels | _between(own[moves - 1], own[moves]) | theirs)
    return items


def _between(before: Point, after: Point) -> Row:
    low, high = before.gamma, after.gamma
    return {"value": math.sqrt(low * high), "low": low, "high": high}


@PHASE_MAPS.quantity
def onset_exponent(points: Points, phase: str) -> list[Row]:
    """Exponent of f of the Gamma at which a phase begins, of each map."""
    items = []
    for labels, own in grouped(points, *MAP):
        found = onset(own, phase)
        value = exponent([one["frequency_hz"] for one in found], [one["value"] for one in found])
        if value is not None:
            items.append(labels | {"value": value, "number": len(found)})
    return items


@PHASE_MAPS.quantity
def bouncing_points(points: Points) -> list[Row]:
    """Number of points of each map that are a bouncing bed, at the frequencies of both heights.

    A measure of the width of its region, which goes on beyond the map.
    """
    own = [one for one in in_maps(points) if one.frequency_hz in BOUNCING]
    return [item for item in counts(own) if item["phase"] == "bouncing_bed"]


@PHASE_MAPS.quantity
def best_over_onset(points: Points) -> list[Row]:
    """Gamma of the best efficiency over the first one of the bouncing bed, where there is one."""
    items = []
    for item in onset(points, "bouncing_bed"):
        own = [one for one in points if all(one.labels[key] == item[key] for key in COLUMN)]
        best = max(own, key=lambda one: one.efficiency).gamma
        items.append(item | {"best": best, "value": best / item["high"]})
    return items


@PHASE_MAPS.quantity
def likeness(points: Points) -> list[Row]:
    """Share of a map's points whose principal phase is the same in both orientations."""
    items = []
    for labels, own in grouped(in_maps(points), "height_mm", "cycles"):
        kinds: dict[tuple[float, float], dict[str, str]] = {}
        for one in own:
            here = kinds.setdefault((one.frequency_hz, one.gamma), {})
            here[one.orientation] = KINDS.get(one.name, (one.name, 0))[0]
        pairs = [both for both in kinds.values() if {"vertical", "horizontal"} <= both.keys()]
        if pairs:
            same = sum(both["vertical"] == both["horizontal"] for both in pairs)
            items.append(labels | {"value": same / len(pairs), "of": len(pairs)})
    return items


@PHASE_MAPS.quantity
def steps_back(points: Points, reading: str = OURS) -> list[Row]:
    """Number of steps to a larger Gamma and a phase that comes before; the first one in words.

    Points of the bouncing bed are left out.
    """
    items = []
    for labels, own in grouped(points, *COLUMN):
        names = [(one.gamma, one.names[reading]) for one in own if one.names[reading] in KINDS]
        back = [(a, b) for a, b in pairwise(names) if KINDS[b[1]][1] < KINDS[a[1]][1]]
        shown = ""
        if back:
            (low, before), (high, after) = back[0]
            shown = f"{label(before)} at {low:g}, {label(after)} at {high:g}"
        items.append(labels | {"value": len(back), "shown": shown})
    return items


@PHASE_MAPS.quantity
def named(points: Points, phase: str, reading: str = OURS) -> list[Row]:
    """1 at each point that a reading names so, 0 at the others, with the name that it has."""
    return [
        one.labels | {"value": float(one.names[reading] == phase), "is": label(one.names[reading])}
        for one in points
    ]


@PHASE_MAPS.quantity
def among(points: Points, phase: str, kind: str) -> list[Row]:
    """Share that a phase has of the points of a principal phase, of each map."""
    return [
        labels | {"value": sum(one.name == phase for one in alike) / len(alike), "of": len(alike)}
        for labels, own in grouped(in_maps(points), *MAP)
        if (alike := [one for one in own if KINDS.get(one.name, ("", 0))[0] == kind])
    ]


@PHASE_MAPS.quantity
def in_band(points: Points, phase: str, of: str) -> list[Row]:
    """Share of points that have a name and lie in the band of sec. 6.4.3.3, of each map.

    of: of all points in "the band", above 40 Hz and with its ends, or of all of "the phase".
    """
    items = []
    for labels, own in grouped(in_maps(points), *MAP):
        band = [one for one in own
                if one.frequency_hz > 40.0 and BAND[0] <= one.gamma <= BAND[1]]  # fmt: skip
        all_of = band if of == "the band" else [one for one in own if one.name == phase]
        if all_of:
            both = sum(one.name == phase for one in band)
            items.append(labels | {"value": both / len(all_of), "of": len(all_of)})
    return items


@PHASE_MAPS.quantity
def measured(points: Points, measure: str, phase: str) -> list[Row]:
    """A measure of the motion at each point of a name."""
    return [one.labels | {"value": one.measures[measure]}
            for one in in_maps(points) if one.name == phase]  # fmt: skip


@PHASE_MAPS.quantity
def gammas(points: Points) -> list[Row]:
    """The Gammas of each name."""
    return [one.labels | {"phase": one.name, "value": one.gamma} for one in in_maps(points)]


@PHASE_MAPS.quantity
def alternating(points: Points) -> list[Row]:
    """1 where successive collisions of a coherent bed differ as in the transition, else 0.

    By the criteria of docs/damper/phases.md, in whatever orientation and phase.
    """
    return [
        one.labels | {"phase": one.name, "value": float(
            one.measures["coherence"] >= MOST and one.measures["contrast"] >= UNEVEN)}
        for one in in_maps(points)
    ]  # fmt: skip


def kept_names(points: Points) -> list[Row]:
    """The names of each point that was run for both numbers of cycles."""
    both = [(labels, {one.cycles: one.name for one in own})
            for labels, own in grouped(points, "orientation", "height_mm", "frequency_hz", "gamma")
           ]  # fmt: skip
    return [
        labels | {"short": names[8], "long": names[60]}
        for labels, names in both
        if {8, 60} <= names.keys()
    ]


def leidenfrost_medians(points: Points, measures: Sequence[str]) -> list[Row]:
    """Medians of measures of the Leidenfrost points, below, within and above the band of Gamma."""
    items = []
    for labels, own in grouped((p for p in points if p.name == "leidenfrost"), "cycles"):
        parts: dict[str, list[Point]] = {"below": [], "within": [], "above": []}
        for one in own:
            part = "below" if one.gamma < BAND[0] else "within" if one.gamma <= BAND[1] else "above"
            parts[part].append(one)
        items += [
            labels | {"part": part, "number": len(these)}
            | {name: median(one.measures[name] for one in these) for name in measures}
            for part, these in parts.items() if these
        ]  # fmt: skip
    return items
