"""What a discharge film told, as one JSON object and as tables with units."""

import csv
import io
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibration.flow.result import Flow
from calibration.uncertainty import as_pair
from campaign.folder import write_atomic

_DIGITS = 6


def as_json(flow: Flow) -> dict[str, Any]:
    """The answer of calibrate flow; lengths in `length_unit`, times in s from the opening."""
    silo, curve = flow.silo, flow.curve
    return {
        "fps_header": flow.film.rate,
        "fps_used": flow.rate,
        "time_base": {
            "duplicated_frames": flow.seen.repeated,
            "corrupt_frames": len(flow.film.corrupt),
            "uneven_stamps": flow.seen.uneven,
        },
        "length_unit": silo.unit,
        "scale_m_per_px": as_pair(silo.scale) if silo.unit == "m" else None,
        "silo_px": [silo.left, silo.top, silo.width, silo.height],
        "outlet": list(flow.outlet),
        "opening_frame": as_pair(flow.opening),
        "outcome": flow.outcome,
        "discharge_time_s": as_pair(flow.discharge),
        "curve": {
            "time_s": numbers(curve.time),
            "remaining": numbers(curve.remaining),
            "remaining_by_tracers": numbers(curve.tracers),
            "sigma": curve.sigma,
            "surface": numbers(curve.surface),
        },
        "profile": _profile(flow),
        "velocity": [
            {
                "from_s": one.start, "until_s": one.end, "x": numbers(one.x), "y": numbers(one.y),
                "vx_per_s": numbers(one.vx), "vy_per_s": numbers(one.vy),
                "sigma_per_s": numbers(one.sigma),
            }
            for one in flow.velocities
        ],
        "warnings": flow.warnings,
    }  # fmt: skip


def _profile(flow: Flow) -> dict[str, Any]:
    depth, depth_sigma = flow.depths()
    layers = [
        {
            "layer": k,
            "painted": None if band.tone < 0 else band.tone == 0,
            "lines": [numbers(p.lines[k]) for p in flow.profiles],
            "sigma": [numbers(p.sigma[k]) for p in flow.profiles],
            "depth": numbers(depth[:, k]),
            "depth_sigma": numbers(depth_sigma[:, k]),
        }
        for k, band in enumerate(flow.bands)
    ]
    return {
        "interval_s": flow.interval,
        "column_edges": numbers(flow.edges),
        "times_s": [p.time for p in flow.profiles],
        "layers": layers,
    }


def numbers(series: NDArray) -> list[Any]:
    """A series as nested lists for JSON, NaN as None, to six digits."""
    if series.ndim > 1:
        return [numbers(row) for row in series]
    return [None if np.isnan(v) else float(f"{v:.{_DIGITS}g}") for v in series.tolist()]


def write_tables(flow: Flow, folder: Path, name: str) -> list[Path]:
    """Tables of the curve, the profiles and the velocities as CSV; their paths."""
    unit = flow.silo.unit
    curve, sigma = flow.curve, flow.curve.sigma
    rows = zip(curve.time, curve.remaining, curve.tracers, curve.surface, strict=True)
    tables = {
        "curve": (
            ["time_s", "remaining", "sigma", "remaining_by_tracers", f"surface_{unit}"],
            ([t, r, "" if sigma is None else sigma, by, s] for t, r, by, s in rows),
        ),
        "profile": (
            ["time_s", "layer", f"x_{unit}", f"y_{unit}", f"sigma_{unit}", "grains"],
            _profile_rows(flow),
        ),
        "velocity": (
            ["from_s", "until_s", f"x_{unit}", f"y_{unit}", f"vx_{unit}_per_s", f"vy_{unit}_per_s",
             f"sigma_{unit}_per_s", "pairs"],
            _velocity_rows(flow),
        ),
    }  # fmt: skip
    return [
        write_table(folder / f"flow-{name}-{what}.csv", head, lines)
        for what, (head, lines) in tables.items()
    ]


def write_table(path: Path, head: list[str], rows: Iterable[list[Any]]) -> Path:
    """A CSV of numbers to six digits, nothing where there is none; its path."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    for row in rows:
        writer.writerow(["" if _is_nan(v) else f"{v:.{_DIGITS}g}" if v != "" else v for v in row])
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomic(path, text.getvalue())
    return path


def _is_nan(value: Any) -> bool:
    return isinstance(value, float) and bool(np.isnan(value))


def _profile_rows(flow: Flow) -> Iterable[list[Any]]:
    x = (flow.edges[:-1] + flow.edges[1:]) / 2
    for p in flow.profiles:
        for layer, column in np.argwhere(np.isfinite(p.lines)):
            at = layer, column
            yield [p.time, layer, x[column], p.lines[at], p.sigma[at], p.grains[at]]


def _velocity_rows(flow: Flow) -> Iterable[list[Any]]:
    for one in flow.velocities:
        for j, i in np.argwhere(np.isfinite(one.vx)):
            at = j, i
            yield [one.start, one.end, one.x[i], one.y[j], one.vx[at], one.vy[at], one.sigma[at],
                   one.count[at]]  # fmt: skip
