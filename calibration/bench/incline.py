"""Coefficient of friction from the inclination at which a block begins to slide.

Paper sec. 3.1: with N = m g cos(alpha), F = m g sin(alpha) and F = mu N, mu = tan(alpha). The angle
is read, or follows from the heights H1 and H2 of two points of the plane and the length L between
them: measured along the slope, sin(alpha) = |H1 - H2|/L; along the base, tan(alpha) = |H1 - H2|/L.
The paper does not say which L it has. A film of the test gives the angle itself
(calibration.block).
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from calibration.bench.measure import Quantity, measure
from calibration.bench.sections import (
    Columns,
    Input,
    Request,
    Section,
    filmed,
    need,
    refuse_without_films,
    rows,
)
from calibration.statistics.quantity import measured_quantity
from calibration.statistics.uncertainty import Estimate
from calibration.tracking.film.reader import Progress, Region, is_film
from granulab.errors import InputError

if TYPE_CHECKING:
    from calibration.block.result import Tilted

INPUTS = (
    Input("angle", "rad", "inclination at first slip"),
    Input("h1", "m", "or the height of one point of the plane, H1,"),
    Input("h2", "m", "of the other, H2,"),
    Input("length", "m", "and the length between them, L"),
)


_CHOICES = (["angle"], ["h1", "h2", "length"])
_SIGMA = "sigma of the angle"  # rad, of a film
_START = "--start-angle"  # rad that the plate of a film is off what was given; 0


def friction(
    files: Sequence[str | Path], what: Request, *, along: str = "slope", fps: float | None = None,
    roi: Region | None = None, start_angle: str | None = None, progress: Progress | None = None,
) -> list[Quantity]:  # fmt: skip
    """The coefficient of friction, one row or one film a trial; of films also the angle.

    along                "slope" or "base", what L is
    fps, roi             of films; start_angle: their plate's inclination in the first frame
    """
    films: list[Tilted] = []
    tables = [path for path in files if not is_film(path)]
    refuse_without_films(files, {"--fps": fps, "--roi": roi, "--start-angle": start_angle})
    start = None if start_angle is None else measured_quantity(start_angle, "rad", "--start-angle")
    if start is not None and start.sigma is not None and len(tables) < len(files):
        what = replace(what, shared={**what.shared, _START: start.sigma})

    def seen(path: Path) -> dict[str, float]:
        from calibration.block.measure import Options, measure_tilt

        known = None if start is None else Estimate(start.value, 0.0, 1)  # sigma: of all films
        films.append(measure_tilt(path, Options(fps, roi, known), progress))
        found = films[-1].found
        return {"angle": found.value, _SIGMA: found.sigma or 0.0, _START: 0.0}

    sections, remarks = rows(tables, INPUTS, what, _CHOICES) if tables else ([], [])
    by_film = filmed([path for path in files if is_film(path)], seen, what)
    remarks += [f"{one.path.name}: {remark}" for one in films for remark in one.remarks]
    sections += by_film
    by_heights = any(_by_heights(section) for section in sections)
    if by_heights:
        formula = {"slope": "sin(alpha)", "base": "tan(alpha)"}[along]
        remarks.append(f"L lies along the {along}: {formula} = |H1 - H2|/L")
    elif along == "base":
        raise InputError("--length-along base: no trial has heights and a length; leave it out")

    remarks += _in_degrees_by_mistake(sections)

    def evaluate(columns: Columns) -> Estimate:
        mu = _friction(columns, along)
        sigma = (1 + mu**2) * float(columns[_SIGMA][0]) if _SIGMA in columns else None
        return Estimate(mu, sigma, 1)

    found = measure(sections, evaluate, what, key="friction", name="friction", remarks=remarks)
    if not films:
        return [found]

    def repose(columns: Columns) -> Estimate:
        sigma = float(columns[_SIGMA][0]) if _SIGMA in columns else None
        return Estimate(float(np.arctan(_friction(columns, along))), sigma, 1)

    angle = measure(sections, repose, what, key="angle_of_repose_rad", name="angle of repose",
                    si="rad", unit="deg")  # fmt: skip
    return [replace(found, films=tuple(films)), angle]


def _in_degrees_by_mistake(sections: Sequence[Section]) -> list[str]:
    """A remark where every angle is less in degrees than a right one has radians."""
    angles = [float(np.degrees(s.columns["angle"][0])) for s in sections if "angle" in s.columns]
    if not angles or not 0 < max(angles) < np.pi / 2:
        return []
    return [f"all angles are below {max(angles):.2g} deg: if they are in radians, say so: [rad]"]


def _by_heights(section: Section) -> bool:
    return need(section, _CHOICES, INPUTS) == 1


def _friction(columns: Columns, along: str) -> float:
    if "angle" in columns:
        angle = float(columns["angle"][0]) + (float(columns[_START][0]) if _START in columns else 0)
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
