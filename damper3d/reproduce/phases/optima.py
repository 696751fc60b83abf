"""Quantities of what phases damp: the optimum of fluidisation, by name and by what moves."""

from typing import Any

from damper3d.reproduce.phases.quantities import COLUMN, KINDS, PHASE_MAPS, grouped, in_maps, label
from damper3d.reproduce.phases.readings import OURS, Point, Points

Row = dict[str, Any]

UP_TO = 6.0  # Gamma: twice that of the thesis's optimum of fluidisation
FROM_HZ = 40.0  # at 20 Hz the bouncing bed begins there


@PHASE_MAPS.quantity
def optimum(points: Points, phase: str = "", reading: str = OURS) -> list[Row]:
    """The optimum of fluidisation: value is 1 where a reading names it so, else 0.

    Also its Gamma, and the shares of the particles that are fluidised and that travel there.
    """
    items = []
    for labels, own in grouped(_of_fluidisation(points), *COLUMN):
        near = [one for one in own if one.gamma <= UP_TO]
        if near:
            best = max(near, key=lambda one: one.efficiency)
            items.append(labels | {
                "gamma": best.gamma, "is": label(best.names[reading]),
                "value": float(best.names[reading] == phase),
                "fluidised": best.measures["fluidised_share"],
                "travelling": best.measures["travelling_share"],
            })  # fmt: skip
    return items


@PHASE_MAPS.quantity
def fluidised_at_optimum(points: Points) -> list[Row]:
    """Share of the particles that are fluidised at the optimum."""
    return [item | {"value": item["fluidised"]} for item in optimum(points)]


@PHASE_MAPS.quantity
def most_fluidised(points: Points) -> list[Row]:
    """Gamma of the optimum, and the Gammas next to the one at which most particles are fluidised.

    The optimum is looked for up to UP_TO, most fluidised particles at all Gammas.
    """
    items = []
    for labels, own in grouped(_of_fluidisation(points), *COLUMN):
        near = [one for one in own if one.gamma <= UP_TO]
        if near:
            best = max(near, key=lambda one: one.efficiency)
            most = max(range(len(own)), key=lambda k: own[k].measures["fluidised_share"])
            items.append(labels | {
                "value": best.gamma, "most": own[most].gamma,
                "low": own[max(most - 1, 0)].gamma,
                "high": own[min(most + 1, len(own) - 1)].gamma,
            })  # fmt: skip
    return items


def _of_fluidisation(points: Points) -> list[Point]:
    """The points of the maps under gravity without those of the bouncing bed, from FROM_HZ on."""
    return [
        one
        for one in in_maps(points)
        if one.frequency_hz >= FROM_HZ and one.orientation != "none" and one.name in KINDS
    ]


@PHASE_MAPS.quantity
def efficiency_of(points: Points, phase: str) -> list[Row]:
    """Efficiency by the walls' work at each point of a name."""
    return [one.labels | {"value": one.walls} for one in in_maps(points) if one.name == phase]


@PHASE_MAPS.quantity
def efficiency_by_kind(points: Points) -> list[Row]:
    """Mean efficiency of the points of each principal phase at each frequency."""
    items = []
    for labels, own in grouped(in_maps(points), *COLUMN):
        found: dict[str, list[float]] = {}
        for one in own:
            if one.name in KINDS:
                found.setdefault(KINDS[one.name][0], []).append(one.efficiency)
        items += [labels | {"kind": kind, "value": sum(etas) / len(etas)}
                  for kind, etas in found.items()]  # fmt: skip
    return items
