"""Tangential damping from a block that slides down an incline (paper sec. 3.4, eqs 3.11a-c).

dv/dt = -gamma_t v + g sin(theta) - mu g cos(theta)     (3.11a)
v = v0 (1 - exp(-gamma_t t)), from rest                 (3.11b)
v0 = g (sin(theta) - mu cos(theta))/gamma_t             (3.11c)

From curves of v(t): least squares of 3.11b, or of v0 + (v_s - v0) exp(-gamma_t t), which solves
3.11a for any velocity v_s at t = 0. From positions, of a film or a table: least squares of their
integrals (calibration.block.way). From terminal velocities: 3.11c solved for gamma_t. A curve
with theta also gives the friction while sliding, tan(theta) - gamma_t v0/(g cos(theta)).
"""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from calibration.bench.measure import Curve, Quantity, measure
from calibration.bench.sections import (
    Columns,
    Input,
    Request,
    Section,
    curves,
    filmed,
    need,
    refuse_without_films,
    rows,
)
from calibration.block.way import fit_way, from_any, from_rest
from calibration.statistics.uncertainty import Estimate, student
from calibration.tracking.film.reader import Progress, Region, is_film
from granulab.contact.files.units import located
from granulab.errors import InputError

if TYPE_CHECKING:
    from calibration.block.result import Slid

INPUTS = (
    Input("time", "s", "of a sliding block, and"),
    Input("velocity", "m/s", "its velocity,"),
    Input("position", "m", "or its position along the slope,"),
    Input("terminal_velocity", "m/s", "or its terminal velocity, with"),
    Input("incline", "rad", "the inclination of the slope and"),
    Input("friction", "1", "the coefficient of friction"),
)
GRAVITY = 9.80665  # [m/s2], standard

_MOVING = 4.0  # sigmas: once in 16000 curves that do begin at rest
_RESTS = 1e-3  # of v0: a velocity that moves gamma_t by as little, whatever its sigma

Fit = tuple[NDArray[np.float64], NDArray[np.float64]]  # parameters, their covariance

_CURVE, _WAY = ["time", "velocity"], ["time", "position"]
_TERMINAL = ["terminal_velocity", "incline", "friction"]
_CHOICES = (_CURVE, _WAY, _TERMINAL)
_SIGMA = "sigma of the incline"  # rad, of a film


class _Curves:
    """Fits of curves, and their quantities; each curve is fitted once."""

    def __init__(self, start: str) -> None:
        self.start = start
        self._known: dict[tuple[bytes, bytes], Fit] = {}

    def fitted(self, columns: Columns) -> Fit:
        """(v0, gamma_t, ...) and their covariance, of velocities or of positions."""
        fits, names = (fit, _CURVE) if "velocity" in columns else (fit_way, _WAY)
        time, values = (columns[name] for name in names)
        key = time.tobytes(), values.tobytes()
        if key not in self._known:
            self._known[key] = fits(time, values, self.start)
        return self._known[key]

    def terminal(self, columns: Columns) -> Estimate:
        """v0 [m/s]."""
        p, covariance = self.fitted(columns)
        return Estimate(float(p[0]), float(np.sqrt(covariance[0, 0])), 1)

    def gamma(self, columns: Columns) -> Estimate:
        """gamma_t [1/s]."""
        p, covariance = self.fitted(columns)
        return Estimate(float(p[1]), float(np.sqrt(covariance[1, 1])), 1)

    def friction(self, columns: Columns) -> Estimate:
        """While sliding."""
        sigma = float(columns[_SIGMA][0]) if _SIGMA in columns else 0.0
        return sliding_friction(*self.fitted(columns), float(columns["incline"][0]), sigma)


def damping(
    files: Sequence[str | Path], what: Request, *, trial: str | None = None, start: str = "rest",
    fps: float | None = None, roi: Region | None = None, scale: str | None = None,
    progress: Progress | None = None,
) -> list[Quantity]:  # fmt: skip
    """gamma_t of curves or films, with terminal velocity and friction; or of terminal velocities.

    start              "rest" for eq. 3.11b, of velocities with t = 0 at the release; "any" for an
                       unknown velocity there
    fps, roi, scale    of films
    """
    films: list[Slid] = []
    refuse_without_films(files, {"--fps": fps, "--roi": roi, "--scale": scale})

    def seen(path: Path) -> dict[str, float | NDArray[np.float64]]:
        from calibration.block.measure import Options, measure_slide

        films.append(measure_slide(path, Options(fps, roi), scale, progress))
        one = films[-1]
        found: dict[str, float | NDArray[np.float64]] = {
            "time": one.time, "position": one.way, "incline": one.incline.value,
        }  # fmt: skip
        if "incline" in what.constants:  # which stands in place of the picture's, its sigma too
            return found
        return found | {_SIGMA: one.incline.sigma or 0.0}

    tables = [path for path in files if not is_film(path)]
    sections, remarks = curves(tables, INPUTS, what, trial, _CHOICES) if tables else ([], [])
    if any(need(section, _CHOICES, INPUTS) == 2 for section in sections):
        return [_from_terminal(files, what)]
    sections += filmed([path for path in files if is_film(path)], seen, what)
    remarks += [f"{one.path.name}: {remark}" for one in films for remark in one.remarks]
    sections = [_downhill(section) for section in sections]
    by_curve = _Curves(start)
    for section in sections:
        with located(f"{section.name}:"):
            p, _ = by_curve.fitted(section.columns)
            if "velocity" not in section.columns:
                continue
            if start == "rest":
                _refuse_moving(section)
            remarks += _not_random(section, p)
    results = [
        _gamma_t(sections, by_curve.gamma, what, remarks),
        measure(
            sections, by_curve.terminal, what,
            key="terminal_velocity_m_s", name="terminal velocity v0", si="m/s", unit="m/s",
        ),
    ]  # fmt: skip
    drawn = tuple(
        _drawn(section, by_curve.fitted(section.columns)[0], start) for section in sections
    )
    axes = "time [s]", "velocity [m/s]" if "velocity" in sections[0].columns else "position [m]"
    results[0] = replace(results[0], curves=drawn, axes=axes, films=tuple(films))
    if all("incline" in section.columns for section in sections):
        friction = by_curve.friction
        results.append(
            measure(sections, friction, what, key="friction_sliding", name="friction, sliding")
        )
    return results


def _drawn(section: Section, p: NDArray[np.float64], start: str) -> Curve:
    """A curve of velocities or positions, and eq. 3.11b, or what solves 3.11a, through it."""
    by_velocity = "velocity" in section.columns
    time, values = (section.columns[name] for name in (_CURVE if by_velocity else _WAY))
    at = np.linspace(min(0.0, float(time.min())), float(time.max()), 200)
    if by_velocity:
        model: Callable[..., NDArray[np.float64]] = _from_rest if len(p) == 2 else _from_any
    else:
        model = from_rest if start == "rest" else from_any
    return Curve(section.name, time, values, ((at, model(at, *p)),))


def _downhill(section: Section) -> Section:
    """A curve counted in the direction in which the block slides."""
    columns = section.columns
    if "velocity" in columns:
        down, name = columns["velocity"].sum(), "velocity"
    else:
        order = np.argsort(columns["time"])
        down, name = np.diff(columns["position"][order]).sum(), "position"
    return section._replace(
        columns=columns | {name: columns[name] if down >= 0 else -columns[name]}
    )


def _refuse_moving(section: Section) -> None:
    """InputError where the curve itself says that t = 0 is not the release, by _MOVING sigmas."""
    try:
        p, covariance = fit(section.columns["time"], section.columns["velocity"], "any")
    except InputError:  # too few points to decide
        return
    sigma = float(np.sqrt(covariance[2, 2]))
    if abs(p[2]) > max(_MOVING * sigma, _RESTS * abs(p[0])):
        raise InputError(
            f"the velocities give {p[2]:.3g} +- {sigma:.2g} m/s at t = 0, and not 0: count time "
            "from the release, or give --start any"
        )


def fit(time: NDArray[np.float64], velocity: NDArray[np.float64], start: str) -> Fit:
    """(v0, gamma_t[, v_s]) of v(t) in (n,) s and m/s, and their covariance from the residuals.

    Student's factor for few points is in it.
    Raises InputError where there are too few points, or nothing bends so that gamma_t is open.
    """
    from scipy.optimize import OptimizeWarning, curve_fit

    model = _from_rest if start == "rest" else _from_any
    unknown = 2 if start == "rest" else 3
    if len(time) < unknown + 2 or np.ptp(time) == 0:
        raise InputError(f"{len(time)} velocities: at least {unknown + 2} at unlike times")
    span = float(np.ptp(time))
    guess = [float(velocity[np.argmax(time)]), 3 / span, 0.0][:unknown]
    try:
        with warnings.catch_warnings(), np.errstate(over="ignore"):
            warnings.simplefilter("error", OptimizeWarning)
            p, covariance = curve_fit(model, time, velocity, p0=guess)
    except (RuntimeError, OptimizeWarning):
        p = np.full(unknown, np.nan)
    if not np.all(np.isfinite(p)) or p[1] <= 0 or covariance[1, 1] > p[1] ** 2:
        raise InputError(
            f"the velocities over {span:g} s leave gamma_t open: they do not bend towards a "
            "terminal velocity; measure longer"
        )
    return p, student(len(time) - unknown) ** 2 * covariance


def _from_rest(t: NDArray[np.float64], v0: float, gamma: float) -> NDArray[np.float64]:
    return v0 * (1 - np.exp(-gamma * t))


def _from_any(t: NDArray[np.float64], v0: float, gamma: float, v_s: float) -> NDArray[np.float64]:
    return v0 + (v_s - v0) * np.exp(-gamma * t)


def sliding_friction(
    p: NDArray[np.float64], covariance: NDArray[np.float64], incline: float,
    incline_sigma: float = 0.0,
) -> Estimate:  # fmt: skip
    """mu = tan(theta) - gamma_t v0/(g cos(theta)), from eq. 3.11c, with the fit's covariance."""
    v0, gamma = p[:2]
    slope = np.array([gamma, v0]) / (GRAVITY * np.cos(incline))
    by_incline = 1 / np.cos(incline) ** 2 - v0 * slope[0] * np.tan(incline)
    variance = slope @ covariance[:2, :2] @ slope + (by_incline * incline_sigma) ** 2
    sigma = float(np.sqrt(variance))
    return Estimate(float(np.tan(incline) - v0 * slope[0]), sigma, 1)


def of_terminal_velocity(v0: float, incline: float, friction: float) -> float:
    """gamma_t [1/s] by eq. 3.11c; InputError where nothing pulls the block down the slope."""
    driving = GRAVITY * (np.sin(incline) - friction * np.cos(incline))
    if driving <= 0 or v0 <= 0:
        raise InputError(
            f"an incline of {np.degrees(incline):g} deg, friction {friction:g} and a terminal "
            f"velocity of {v0:g} m/s: eq. 3.11c needs tan(incline) above friction and v0 above 0"
        )
    return float(driving / v0)


def _from_terminal(files: Sequence[str | Path], what: Request) -> Quantity:
    sections, remarks = rows(files, INPUTS, what, _CHOICES)

    def gamma(columns: Columns) -> Estimate:
        v0, incline, friction = (float(columns[name][0]) for name in _TERMINAL)
        return Estimate(of_terminal_velocity(v0, incline, friction), None, 1)

    return _gamma_t(sections, gamma, what, remarks)


def _gamma_t(
    sections: Sequence[Section], gamma: Callable[[Columns], Estimate], what: Request,
    remarks: Sequence[str],
) -> Quantity:  # fmt: skip
    return measure(
        sections, gamma, what,
        key="gamma_t_per_s", name="tangential damping gamma_t", si="1/s", unit="1/s",
        remarks=remarks,
    )  # fmt: skip


def _not_random(section: Section, p: NDArray[np.float64]) -> list[str]:
    """A remark where neighbouring residuals go together, as they do not in white noise.

    Their correlation then has a standard deviation of 1/sqrt(n); beyond three it is reported.
    """
    order = np.argsort(section.columns["time"])
    time, velocity = (section.columns[name][order] for name in _CURVE)
    model = _from_rest if len(p) == 2 else _from_any
    left = velocity - model(time, *p)
    square = float(left @ left)
    r = float(left[1:] @ left[:-1]) / square if square else 0.0
    if abs(r) * np.sqrt(len(left)) < 3:
        return []
    return [
        f"{section.name}: neighbouring residuals go together (correlation {r:.2f}): eq. 3.11a "
        "does not describe the run, or its noise is not white; sigma is too "
        + ("small" if r > 0 else "large")
    ]
