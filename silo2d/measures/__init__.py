"""Measures of finished runs, and the registry of all.

Functions of run folders, never of the live world. A measure is a module with two of them,

    measure(folder) -> dict            numbers and series in SI, ready for JSON
    draw(folder) -> Figure             the same as a matplotlib figure

and a line below; or, from outside, a call of `silo2d.register_measure`, see
granulab.campaign.output.measures. Quantities that several of them share are in `basics`.
"""

from granulab.campaign.output.measures import Measures, Shipped

_MEASURES = {
    "arch": ("arch that a clogged run stands on: particles, span, rise, load", "m"),
    "curve": ("discharge curve and rate, and the part where the flow is steady", "1/s"),
    "fields": ("packing fraction and velocity, coarse-grained over the flow", "m/s"),
    "janssen": ("wall pressure and vertical stress compared with Janssen's law", "N/m"),
    "loads": ("pressures on the walls from filling to flow, and what bears the weight", "Pa"),
    "massflow": ("mass flow index: velocity at the walls over that at the centre", "1"),
    "network": ("contact network: coordination, sliding, force distribution", "N"),
    "profile": ("lines of the painted layers every 0.25 s, V depth and V width", "m"),
    "residence": ("when particles leave, by starting level and position", "s"),
    "segregation": ("segregation index of a mixture's parts and of its fines, over time", "1"),
    "stickslip": ("particles that stick to the walls, slip along them, and how long", "s"),
    "stress": ("stress field before the opening and during the flow", "N/m"),
}

# Name as in `silo2d observe RUN WHAT`; each has a module of this package of that name.
MEASURES = Measures(
    {
        name: Shipped(text, unit, f"silo2d.measures.{name}")
        for name, (text, unit) in _MEASURES.items()
    }
)

find, register = MEASURES.find, MEASURES.register
observe, draw = MEASURES.observe, MEASURES.draw
