"""Mean roughness of a surface profile (thesis eq. 7.1), and how its form is taken off.

Ra = (1/L) integral of |z(x)| dx from 0 to L. z counts from the surface's form, which is taken off
first: the mean height, the straight line or a parabola of least squares over the whole path, or a
circle. The profile is taken as straight between its points, so that crossings of zero count where
they are. sigma of one path is that of its five equal lengths (ISO 4288).
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibration.bench.measure import Curve, Quantity, measure
from calibration.bench.sections import Columns, Input, Request, Section, curves, need
from calibration.statistics.uncertainty import Estimate, of_trials
from granulab.errors import InputError

INPUTS = (Input("x", "m", "along the path"), Input("z", "m", "height of the surface"))
_LENGTHS = 5  # equal parts of a path, ISO 4288
_LEAST_POINTS = 50
_FAR = 10  # usual steps that a point may be from the one before without a remark


def mean_roughness(
    files: Sequence[str | Path], what: Request, *, trial: str | None = None, form: str = "line"
) -> list[Quantity]:
    """Ra, a path a trial."""
    sections, remarks = curves(files, INPUTS, what, trial, [["x", "z"]])
    for section in sections:
        need(section, [["x", "z"]], INPUTS)
    remarks.append(f"form taken off: {form}")
    remarks += filter(None, map(_gap, sections))

    def above_form(columns: Columns) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        order = np.argsort(columns["x"], kind="stable")
        x, z = columns["x"][order], columns["z"][order]
        return x, without_form(x, z, form)

    def evaluate(columns: Columns) -> Estimate:
        return of_profile(*above_form(columns))

    found = measure(
        sections, evaluate, what,
        key="ra_m", name="mean roughness Ra", si="m", unit="um", remarks=remarks,
    )  # fmt: skip
    paths = [(section.name, *above_form(section.columns)) for section in sections]
    drawn = tuple(Curve(name, 1e3 * x, 1e6 * z) for name, x, z in paths)
    return [replace(found, curves=drawn, axes=("along the path [mm]", f"above the {form} [um]"))]


def _gap(section: Section) -> str | None:
    """A remark where a point stands far from its neighbours, and Ra counts a line between them."""
    x = np.sort(section.columns["x"])
    steps = np.diff(x)
    usual = float(np.median(steps)) if len(steps) else 0.0
    k = int(np.argmax(steps)) if len(steps) else 0
    if not usual > 0 or steps[k] <= _FAR * usual:
        return None
    return (
        f"{section.name}: no point between x = {x[k]:.6g} m and {x[k + 1]:.6g} m, "
        f"{steps[k] / usual:.0f} usual steps: a slip in x, or a gap, over which Ra counts a "
        "straight line; check it"
    )


def without_form(x: NDArray[np.float64], z: NDArray[np.float64], form: str) -> NDArray[np.float64]:
    """Heights z(x) [m], (n,) each with x rising, above the form."""
    if len(x) < _LEAST_POINTS or np.min(np.diff(x)) <= 0:
        raise InputError(
            f"{len(x)} points of a profile: at least {_LEAST_POINTS}, no two at the same x"
        )
    if form == "circle":
        return _without_circle(x, z)
    from numpy.polynomial import Polynomial

    degree = {"mean": 0, "line": 1, "parabola": 2}[form]
    return z - Polynomial.fit(x, z, degree)(x)


def _without_circle(x: NDArray[np.float64], z: NDArray[np.float64]) -> NDArray[np.float64]:
    """Heights above a circle of least squares along z, which begins from the parabola."""
    from scipy.optimize import least_squares

    half = (x[-1] - x[0]) / 2
    u = (x - x[0]) / half - 1
    bend, slope, offset = np.polyfit(u, z / half, 2)

    def arc(p: NDArray[np.float64]) -> NDArray[np.float64]:
        """z/half of a circle of curvature c, sine of slope s and height z0 at u = 0.

        c = 0 is a straight line: written so that nothing is divided by c.
        """
        c, s, z0 = p
        at, here = (np.sqrt(np.maximum(1 - w**2, 0)) for w in (s, c * u + s))
        return z0 + u * (c * u + 2 * s) / (at + here)

    begin = [2 * bend, slope / np.hypot(1, slope), offset]
    found = least_squares(lambda p: arc(p) - z / half, begin, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    return z - arc(found.x) * half


def of_profile(x: NDArray[np.float64], z: NDArray[np.float64]) -> Estimate:
    """Ra [m] of heights z above the form, and its sigma from five equal lengths."""
    edges = np.linspace(x[0], x[-1], _LENGTHS + 1)
    parts = [_mean_height(x, z, a, b) for a, b in pairwise(edges)]
    whole = _mean_height(x, z, x[0], x[-1])
    return Estimate(whole, of_trials(parts).sigma, 1)


def _mean_height(
    x: NDArray[np.float64], z: NDArray[np.float64], first: float, last: float
) -> float:
    """(1/L) integral of |z| from first to last, of straight pieces: exact at zero crossings."""
    ends = np.array([first, last])
    inner = (x > first) & (x < last)
    px = np.concatenate([[first], x[inner], [last]])
    pz = np.concatenate([np.interp(ends[:1], x, z), z[inner], np.interp(ends[1:], x, z)])
    a, b, width = pz[:-1], pz[1:], np.diff(px)
    crosses = a * b < 0
    sizes = np.abs(a) + np.abs(b)
    safe = np.where(sizes > 0, sizes, 1.0)
    areas = np.where(crosses, (a**2 + b**2) / (2 * safe), sizes / 2) * width
    return float(areas.sum() / (last - first))
