"""Silos for the inverse fit: discharge time, T90, discharge curve, layer profile, clogging."""

import numpy as np

from calibration.inverse.observation import (
    Kind,
    Observation,
    Row,
    Simulated,
    Values,
    Written,
    finite,
    single,
)
from calibration.inverse.statistics.prior import Array
from granulab.campaign.runs.trajectory import read_trajectory
from granulab.contact.files.keys import Keys
from granulab.errors import InputError
from silo2d.case.case import SiloCase
from silo2d.case.settings import Settings
from silo2d.measures.basics.particles import column_edges
from silo2d.measures.profile import layer_lines
from silo2d.run.sweep import SILO
from silo2d.view.scene import read_scene

# Columns of a discharge curve: what has left, as a part of all, or as a mass.
_LEFT = {"fraction": "1", "mass": "kg", "n_out": "1"}


def _read_time(kind: str) -> Kind:
    def read(written: Written) -> list[Observation]:
        value, sigma = written.positive("value", "s"), written.positive("sigma", "s")
        return [single(kind, value, sigma, written.count("trials", 1), "s")]

    return Kind(read, lambda observation, row: np.array([row[f"{kind}_s"]], dtype=float))


def _read_clogging(written: Written) -> list[Observation]:
    trials = written.count("trials", None)
    clogged = written.count("clogged", None, least=0)
    if clogged > trials:
        raise InputError(f"{written.where} clogged = {clogged}: more than the {trials} trials")
    nothing = np.zeros(0)
    return [
        Observation(
            "clogging", (), nothing, nothing, trials, np.zeros((0, 0)), (), nothing, ("", ""),
            blocked=clogged,
        )
    ]  # fmt: skip


def _read_curve(written: Written) -> list[Observation]:
    table = written.table()
    name = next((name for name, unit in _LEFT.items() if table.has(name, unit)), None)
    if name is None:
        raise InputError(
            f"{table.path}: no column of what has left; give time [s] and one of fraction, "
            "mass [kg], n_out"
        )
    times = finite(table.column("time", "s"), table, "time")
    values = finite(table.column(name, _LEFT[name]), table, name)
    if (times < 0).any():
        raise InputError(f"{table.path}: time = {times.min():g} s: counts from the opening on")
    words = {"fraction": "part that has left", "mass": "mass that has left [kg]"}
    sigma, trials = written.sigma(table, _LEFT[name]), written.count("trials", 1)
    return [
        Observation(
            "curve", (), values, sigma, trials, times[:, None], (name,) * len(times), times,
            ("time since the opening [s]", words.get(name, "particles out")), table.path,
        )
    ]  # fmt: skip


def _curve_of(observation: Observation, row: Row) -> Array:
    """Discharged share, mass or number at the times; masses are those of the run."""
    frames = read_trajectory(row["run_folder"])
    out, mass = frames["out_time"][-1], frames.static["mass"]
    name = observation.series[0]
    weight = np.ones(len(mass)) if name == "n_out" else mass
    if name == "fraction":
        weight = mass / mass[~np.isnan(out)].sum()
    gone = out[None] <= observation.at[:, :1]  # NaN: never
    return gone @ weight


def _read_profile(written: Written) -> list[Observation]:
    table = written.table()
    columns = [("time", "s"), ("layer", "1"), ("x", "m"), ("y", "m")]
    time, layer, x, y = (finite(table.column(n, u), table, n) for n, u in columns)
    if (layer != layer.round()).any() or (layer < 0).any():
        raise InputError(f"{table.path}: layer: give whole numbers, 0 for the lowest")
    series = tuple(f"layer {k:.0f} at {t:.3g} s" for t, k in zip(time, layer, strict=True))
    sigma, trials = written.sigma(table, "m"), written.count("trials", 1)
    return [
        Observation(
            "profile", (), y, sigma, trials, np.stack([time, layer, x], axis=1), series, x,
            ("x [m]", "height of the layer's line [m]"), table.path,
        )
    ]  # fmt: skip


def _profile_of(observation: Observation, row: Row) -> Array:
    """Heights of the layers' lines (n,) [m]; a layer that has left, or is not there, stands at 0.

    Between the middles of columns the line is straight, beyond them level.
    """
    scene = read_scene(row["run_folder"])
    edges = column_edges(scene)
    middles = (edges[:-1] + edges[1:]) / 2
    names = np.unique(scene.trajectory.static["layer"])
    times = np.unique(observation.at[:, 0])
    frames = [int(np.abs(scene.time - t).argmin()) for t in times]
    lines, _, _ = layer_lines(scene, frames)
    found = np.zeros(len(observation.values))
    for k, (time, layer, x) in enumerate(observation.at):
        if layer not in names:
            continue
        line = lines[int(np.searchsorted(names, layer)), int(np.searchsorted(times, time))]
        filled = np.isfinite(line)
        if filled.any():
            found[k] = np.interp(x, middles[filled], line[filled])
    return found


def _parameters(case: SiloCase) -> Values:
    """Friction, stiffness and damping of both pairs."""
    particle, wall = case.settings.particles.names
    found: Values = {}
    for other, law in ((particle, case.particle_law), (wall, case.wall_law)):
        section = f"pair.{particle}-{other}"
        found[section, "friction"] = law.mu
        for key in ("kn", "kt", "gamma_n", "gamma_t"):
            found[section, key] = getattr(law, key)
    return found


SIMULATED = Simulated(
    campaign=SILO,
    keys=Keys(Settings),
    load=SiloCase.load,
    kinds={
        "discharge_time": _read_time("discharge_time"),
        "t90": _read_time("t90"),
        "curve": Kind(_read_curve, _curve_of),
        "profile": Kind(_read_profile, _profile_of),
        "clogging": Kind(_read_clogging, lambda observation, row: np.zeros(0)),
    },
    passed=lambda row: row["outcome"] in ("empty", "dead_zones"),
    parameters=_parameters,
)
