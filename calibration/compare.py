"""A simulated discharge beside a filmed one: profiles and curves on the same axes, and a distance.

    D = sqrt(<(y_film - y_run)^2>)        over layers, columns and times where both have a line [m]
    C = sqrt(<(R_film - R_run)^2>)        over the time of the film; R the share that remains

R is the area of the material that is seen, and the mass of the run's grains in the silo; both begin
at the opening. The uncertainty of D follows from that of the lines to first order,
u(D) = sum |d| u/(N D), as if all of them erred together: they share grains, scale and opening.
`floor` is the root mean square of the lines' own uncertainty: what D would be for equal flows.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibration.flow.result import Flow
from calibration.statistics.uncertainty import Estimate, as_pair
from granulab.errors import InputError
from silo2d.measures.basics.particles import column_edges, leavers
from silo2d.measures.profile import measure
from silo2d.view.scene import Scene, read_scene

Floats = NDArray[np.float64]

_FEWEST = 3  # places where both have a line


@dataclass(frozen=True)
class Comparison:
    """Lines (t, l, c) [m] and curves of a film and a run at the same places and times.

    distance     D [m]; floor [m]; curve_distance C
    time_off     discharge time of the run less that of the film [s]; None where one has none
    """

    scene: Scene
    flow: Flow
    edges: Floats
    times: Floats
    film: Floats
    sigma: Floats
    run: Floats
    remaining_run: Floats
    distance: Estimate
    floor: float
    curve_distance: Estimate
    time_off: Estimate | None
    warnings: list[str]


def columns_of(folder: str | Path) -> tuple[int, float]:
    """Number of columns of a run's profiles, and the silo's inner width [m]."""
    edges = column_edges(read_scene(folder))
    return len(edges) - 1, float(np.ptp(edges))


def compare(folder: str | Path, flow: Flow) -> Comparison:
    """Set a run beside a film; InputError where they have no line in common."""
    scene = read_scene(folder)
    if flow.silo.unit != "m":
        raise InputError("compare: the film has no scale; give --scale or --width")
    profile = measure(Path(folder), flow.interval)
    known = [_array(layer["lines_m"]) for layer in profile["layers"]]
    run = np.stack(known, axis=1)  # (t, l, c)
    film = np.array([p.lines for p in flow.profiles])
    sigma = np.array([p.sigma for p in flow.profiles])
    if film.shape[2] != run.shape[2]:
        raise InputError(f"compare: {film.shape[2]} columns of the film, {run.shape[2]} of the run")
    warnings = list(flow.warnings)
    if film.shape[1] != run.shape[1]:
        warnings.append(f"{film.shape[1]} layers in the film, {run.shape[1]} in the run: "
                        "the lowest are set beside each other")  # fmt: skip
    times, layers = (min(a, b) for a, b in zip(film.shape[:2], run.shape[:2], strict=True))
    film, sigma, run = (part[:times, :layers] for part in (film, sigma, run))
    both = np.isfinite(film) & np.isfinite(run)
    if both.sum() < _FEWEST:
        raise InputError("compare: the film and the run have no lines at the same place and time")
    distance, floor = _distance(film[both] - run[both], sigma[both])
    remaining = _remaining(scene, flow.curve.time)
    return Comparison(
        scene, flow, flow.edges, np.array(profile["times_s"][:times]), film, sigma, run, remaining,
        distance, floor, _curve_distance(flow, remaining), _time_off(scene, flow), warnings,
    )  # fmt: skip


def _array(lines: list[Any]) -> Floats:
    return np.array([[np.nan if v is None else v for v in row] for row in lines], dtype=float)


def _distance(off: Floats, sigma: Floats) -> tuple[Estimate, float]:
    value = float(np.sqrt(np.mean(off**2)))
    floor = float(np.sqrt(np.mean(sigma**2)))
    # Lines of neighbouring columns share grains and scale: as if all errors went together.
    slope = float(np.mean(np.abs(off) * sigma)) / value if value > 0 else floor
    return Estimate(value, slope, len(off)), floor


def _remaining(scene: Scene, time: Floats) -> Floats:
    """Share of the run's mass that is in the silo at times from the opening (n,)."""
    left, mass = leavers(scene)
    whole = float(scene.trajectory.static["mass"].sum())
    gone = np.concatenate([[0.0], np.cumsum(mass)])[np.searchsorted(left, time, side="right")]
    return np.asarray(1 - gone / whole)


def _curve_distance(flow: Flow, remaining: Floats) -> Estimate:
    off = flow.curve.remaining - remaining
    return Estimate(float(np.sqrt(np.mean(off**2))), flow.curve.sigma, len(off))


def _time_off(scene: Scene, flow: Flow) -> Estimate | None:
    ended = scene.summary.get("discharge_time_s")
    if ended is None or flow.discharge is None:
        return None
    return Estimate(float(ended) - flow.discharge.value, flow.discharge.sigma, 1)


def as_json(found: Comparison) -> dict[str, Any]:
    """The answer of calibrate compare, in SI; times in s from the opening."""
    from calibration.flow.result import numbers

    return {
        "distance_m": as_pair(found.distance),
        "distance_of_equal_flows_m": found.floor,
        "curve_distance": as_pair(found.curve_distance),
        "discharge_time_run_s": found.scene.summary.get("discharge_time_s"),
        "discharge_time_film_s": as_pair(found.flow.discharge),
        "discharge_time_difference_s": as_pair(found.time_off),
        "outcome_run": found.scene.summary.get("outcome"),
        "outcome_film": found.flow.outcome,
        "times_s": numbers(found.times),
        "column_edges_m": numbers(found.edges),
        "lines_film_m": numbers(found.film),
        "sigma_film_m": numbers(found.sigma),
        "lines_run_m": numbers(found.run),
        "warnings": found.warnings,
    }
