"""Result of the film of a silo that empties: times, curve, profiles, velocities; its tables."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from calibration.flow.layers import Band, Profile
from calibration.flow.silo import Silo
from calibration.flow.survey import Survey
from calibration.flow.velocity import VelocityField
from calibration.statistics.quantity import plus_minus, six_digits
from calibration.statistics.uncertainty import Estimate, as_pair
from calibration.tracking.film.reader import Film
from granulab.campaign.output.files import write_atomic
from granulab.campaign.output.table import as_csv

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Curve:
    """Frame by frame: time since the opening [s], and what remains, as a share.

    area       of the material that is seen in the silo; NaN where the backing is not known
    tracers    of the points that are followed
    surface    mean height of the free surface, in the silo's unit; NaN likewise
    """

    time: Floats
    area: Floats
    tracers: Floats
    surface: Floats

    @property
    def remaining(self) -> Floats:
        """By area, or by tracers where that is not known."""
        return self.area if np.isfinite(self.area).all() else self.tracers

    @property
    def sigma(self) -> float | None:
        """Root mean square difference of the two measures of the share that remains."""
        if not np.isfinite(self.area).all():
            return None
        return float(np.sqrt(np.mean(np.square(self.area - self.tracers))))


@dataclass(frozen=True)
class Flow:
    """A filmed discharge; a result (calibration.result). In silo.unit and s from the opening.

    opening      frame of the film, with a part of one
    outcome      empty, dead_zones, clogged, unfinished or nothing_flows
    discharge    from the opening to the last particle [s]; None if clogged or unfinished
    rests_on     where the rate comes from
    pull         mean acceleration of the first fall above the outlet [px/frame2]; None if unknown
    """

    film: Film
    rate: float
    silo: Silo
    outlet: tuple[float, float]
    opening: Estimate
    outcome: str
    discharge: Estimate | None
    curve: Curve
    bands: list[Band]
    edges: Floats
    interval: float
    profiles: list[Profile]
    velocities: list[VelocityField]
    seen: Survey
    warnings: list[str] = field(default_factory=list)
    rests_on: str = "the file's head"
    pull: float | None = None

    def depths(self) -> tuple[Floats, Floats]:
        """Depth of each layer's V, and its sigma, (times, layers); NaN for none.

        The mean of the line's outermost columns less the column at the outlet, as silo2d has it.
        """
        middle = int(np.digitize(sum(self.outlet) / 2, self.edges[1:-1]))
        out = np.full((2, len(self.profiles), len(self.bands)), np.nan)
        for t, layer in np.ndindex(out.shape[1:]):
            line, sigma = self.profiles[t].lines[layer], self.profiles[t].sigma[layer]
            filled = np.flatnonzero(np.isfinite(line))
            if len(filled) and filled[0] < middle < filled[-1] and np.isfinite(line[middle]):
                ends = filled[[0, -1]]
                out[0, t, layer] = line[ends].mean() - line[middle]
                out[1, t, layer] = np.sqrt(np.sum(sigma[ends] ** 2) / 4 + sigma[middle] ** 2)
        return out[0], out[1]

    @property
    def first_fall(self) -> float | None:
        """Acceleration of the first fall above the outlet [m/s2]; None without a scale."""
        if self.pull is None or self.silo.unit != "m":
            return None
        return self.pull * self.silo.scale.value * self.rate**2

    @property
    def name(self) -> str:
        """Name of the film in file names."""
        return self.film.path.stem.strip("*?[]") or "pictures"

    @property
    def end(self) -> str:
        """End of the discharge, and its time, in words."""
        text = self.outcome.replace("_", " ")
        if self.discharge is None:
            return text
        after = " after" if self.outcome == "empty" else "; the last particle left at"
        return f"{text}{after} {plus_minus(self.discharge.value, self.discharge.sigma)} s"

    def to_dict(self) -> dict[str, Any]:
        """Lengths in `length_unit`, times in s from the opening."""
        silo, curve, fall = self.silo, self.curve, self.first_fall
        return {
            "fps_header": self.film.rate,
            "fps_used": self.rate,
            "time_base": {
                "duplicated_frames": self.seen.repeated,
                "corrupt_frames": len(self.film.corrupt),
                "uneven_stamps": self.seen.uneven,
                "rests_on": self.rests_on,
                "first_fall_m_per_s2": six_digits(np.nan if fall is None else fall),
            },
            "length_unit": silo.unit,
            "scale_m_per_px": as_pair(silo.scale) if silo.unit == "m" else None,
            "silo_px": [silo.left, silo.top, silo.width, silo.height],
            "outlet": list(self.outlet),
            "outlet_over_width": (
                (self.outlet[1] - self.outlet[0]) / (self.silo.width * self.silo.scale.value)
            ),
            "opening_frame": as_pair(self.opening),
            "outcome": self.outcome,
            "discharge_time_s": as_pair(self.discharge),
            "curve": {
                "time_s": numbers(curve.time),
                "remaining": numbers(curve.remaining),
                "remaining_by_tracers": numbers(curve.tracers),
                "sigma": curve.sigma,
                "surface": numbers(curve.surface),
            },
            "profile": _profile(self),
            "velocity": [
                {
                    "from_s": one.start, "until_s": one.end,
                    "x": numbers(one.x), "y": numbers(one.y),
                    "vx_per_s": numbers(one.vx), "vy_per_s": numbers(one.vy),
                    "sigma_per_s": numbers(one.sigma),
                }
                for one in self.velocities
            ],
            "warnings": self.warnings,
        }  # fmt: skip

    def text(self) -> str:
        """The end, the opening, the silo in the picture, and a line for each profile."""
        silo, unit = self.silo, self.silo.unit
        lines = [
            self.end,
            f"opening  at frame {plus_minus(self.opening.value, self.opening.sigma)} of "
            f"{self.seen.count}, {self.rate:g} frames/s",
            f"silo     {silo.width:g} x {silo.height:g} px at ({silo.left:g}, {silo.top:g}); "
            f"outlet {self.outlet[0]:.4g} to {self.outlet[1]:.4g} {unit}",
        ]
        if unit == "m":
            lines.append(f"scale    {plus_minus(silo.scale.value, silo.scale.sigma)} m/px")
        depth, _ = self.depths()
        head = f"deepest V [{unit}]"
        lines.append(f"{'time [s]':>10} {'remains':>8} {head:>15} {'lines':>6}")
        for k, one in enumerate(self.profiles):
            remains = float(np.interp(one.time, self.curve.time, self.curve.remaining))
            known = depth[k][np.isfinite(depth[k])]
            deepest = f"{known.max():.4g}" if len(known) else "-"
            seen = int(np.isfinite(one.lines).any(axis=1).sum())
            lines.append(f"{one.time:10.3g} {remains:8.3f} {deepest:>15} {seen:6d}")
        return "\n".join(lines + [f"warning: {warning}" for warning in self.warnings])

    def figure(self) -> "Figure":
        """Lines of the layers over pictures of the film, curve, depths and velocities."""
        from calibration.flow.figure import draw

        return draw(self)


Row = dict[str, float]


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


def write_tables(flow: Flow, folder: Path) -> list[Path]:
    """Write curve, profiles and velocities as CSV, those that there are; their paths."""
    tables = {
        "curve": _curve_rows(flow),
        "profile": _profile_rows(flow),
        "velocity": _velocity_rows(flow),
    }
    return [
        write_rows(folder / f"flow-{flow.name}-{what}.csv", rows)
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
            "grains": p.particles[layer, column],
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
