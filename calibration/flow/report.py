"""What a discharge film told, as one JSON object and as tables with units."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibration.flow.result import Flow
from calibration.statistics.quantity import six_digits
from calibration.statistics.uncertainty import as_pair
from granulab.campaign.output.table import as_csv
from granulab.campaign.runs.folder import write_atomic

Row = dict[str, float]


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
    return [six_digits(value) for value in series.tolist()]


def write_tables(flow: Flow, folder: Path, name: str) -> list[Path]:
    """Tables of the curve, the profiles and the velocities as CSV, of those there are; paths."""
    tables = {
        "curve": _curve_rows(flow),
        "profile": _profile_rows(flow),
        "velocity": _velocity_rows(flow),
    }
    return [
        write_rows(folder / f"flow-{name}-{what}.csv", rows)
        for what, rows in tables.items()
        if rows
    ]


def write_rows(path: Path, rows: list[Row]) -> Path:
    """Numbers by name, to six digits, nothing where there is none, as a CSV; its path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomic(path, as_csv([{name: _cell(v) for name, v in row.items()} for row in rows]))
    return path


def _cell(value: float) -> float | None:
    return int(value) if isinstance(value, int | np.integer) else six_digits(value)


def _curve_rows(flow: Flow) -> list[Row]:
    curve, surface = flow.curve, f"surface_{flow.silo.unit}"
    sigma = np.nan if curve.sigma is None else curve.sigma
    return [
        {"time_s": t, "remaining": r, "sigma": sigma, "remaining_by_tracers": by, surface: s}
        for t, r, by, s in zip(
            curve.time, curve.remaining, curve.tracers, curve.surface, strict=True
        )
    ]


def _profile_rows(flow: Flow) -> list[Row]:
    x, unit = (flow.edges[:-1] + flow.edges[1:]) / 2, flow.silo.unit
    return [
        {
            "time_s": p.time, "layer": layer, f"x_{unit}": x[column],
            f"y_{unit}": p.lines[layer, column], f"sigma_{unit}": p.sigma[layer, column],
            "grains": p.grains[layer, column],
        }
        for p in flow.profiles
        for layer, column in np.argwhere(np.isfinite(p.lines))
    ]  # fmt: skip


def _velocity_rows(flow: Flow) -> list[Row]:
    unit = flow.silo.unit
    return [
        {
            "from_s": one.start, "until_s": one.end, f"x_{unit}": one.x[i], f"y_{unit}": one.y[j],
            f"vx_{unit}_per_s": one.vx[j, i], f"vy_{unit}_per_s": one.vy[j, i],
            f"sigma_{unit}_per_s": one.sigma[j, i], "pairs": one.count[j, i],
        }
        for one in flow.velocities
        for j, i in np.argwhere(np.isfinite(one.vx))
    ]  # fmt: skip
