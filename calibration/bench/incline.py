"""Coefficient of friction from the inclination at which a block begins to slide.

Paper sec. 3.1: with N = m g cos(alpha), F = m g sin(alpha) and F = mu N, mu = tan(alpha). The angle
is read, or follows from the heights H1 and H2 of two points of the plane and the length L between
them: measured along the slope, sin(alpha) = |H1 - H2|/L; along the base, tan(alpha) = |H1 - H2|/L.
The paper does not say which L it has.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from calibration.bench.measure import Quantity, measure
from calibration.bench.sections import Columns, Input, Request, Section, need, rows
from calibration.statistics.uncertainty import Estimate
from granulab.errors import InputError

INPUTS = (
    Input("angle", "rad", "inclination at first slip"),
    Input("h1", "m", "or the height of one point of the plane, H1,"),
    Input("h2", "m", "of the other, H2,"),
    Input("length", "m", "and the length between them, L"),
)


def friction(files: Sequence[str | Path], what: Request, *, along: str = "slope") -> list[Quantity]:
    """The coefficient of friction, one row a trial; `along`: "slope" or "base", what L is."""
    sections, remarks = rows(files, INPUTS, what)
    by_heights = any(_by_heights(section) for section in sections)
    if by_heights:
        formula = {"slope": "sin(alpha)", "base": "tan(alpha)"}[along]
        remarks.append(f"L lies along the {along}: {formula} = |H1 - H2|/L")

    remarks += _in_degrees_by_mistake(sections)

    def evaluate(columns: Columns) -> Estimate:
        return Estimate(_friction(columns, along), None, 1)

    found = measure(sections, evaluate, what, key="friction", name="friction", remarks=remarks)
    return [found]


def _in_degrees_by_mistake(sections: Sequence[Section]) -> list[str]:
    """A remark where every angle is less in degrees than a right one has radians."""
    angles = [float(np.degrees(s.columns["angle"][0])) for s in sections if "angle" in s.columns]
    if not angles or not 0 < max(angles) < np.pi / 2:
        return []
    return [f"all angles are below {max(angles):.2g} deg: if they are in radians, say so: [rad]"]


def _by_heights(section: Section) -> bool:
    return need(section, [["angle"], ["h1", "h2", "length"]], INPUTS) == 1


def _friction(columns: Columns, along: str) -> float:
    if "angle" in columns:
        angle = float(columns["angle"][0])
    else:
        rise = abs(float(columns["h1"][0]) - float(columns["h2"][0]))
        length = float(columns["length"][0])
        if length <= 0 or (along == "slope" and rise >= length):
            raise InputError(
                f"heights that differ by {1e3 * rise:g} mm over a length of {1e3 * length:g} mm: "
                "no slope"
            )
        angle = np.arcsin(rise / length) if along == "slope" else np.arctan(rise / length)
    if not 0 <= angle < np.pi / 2:
        raise InputError(
            f"angle = {np.degrees(angle):g} deg: takes 0 to below 90 deg from the horizontal"
        )
    return float(np.tan(angle))
