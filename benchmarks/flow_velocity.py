"""Velocities of rendered discharge films and the run's own: bias, scatter, coverage, a figure.

python benchmarks/flow_velocity.py RUN FOLDER FILM ... renders a run folder as each FILM's camera of
flow_coverage.py sees it, measures the film, and writes FOLDER/velocity-FILM-RUN.npz and a figure;
without FILM it prints the table of all. Within one sigma: |component - truth| below the stated
sigma, over both components, all windows and all intervals in which both have one.
"""

import sys
from pathlib import Path

import numpy as np
from flow_coverage import rendered

from calibration.flow.measure import measure_flow
from calibration.flow.silo import Settings
from calibration.rendered.flow_velocity import TrueField, true_field
from granulab.campaign.output.figure import write_figure

COLUMNS = "| {} | windows | true speed | bias along x | along y | rms | sigma | within one sigma |"
PARTS = 3  # of the windows, by distance from walls and by strain, equally many in each


def measure(run: Path, folder: Path, name: str) -> Path:
    """Render, measure and compare one film; the numbers' file."""
    from silo2d.measures.basics.particles import column_edges

    stage, camera, times, film = rendered(run, folder, name)
    edges = column_edges(stage.scene)
    length = 0.05 if np.ptp(edges) < 0.1 else 0.1
    settings = Settings(width=f"{1e3 * np.ptp(edges)} mm", interval=f"{length} s",
                        columns=len(edges) - 1)  # fmt: skip
    flow = measure_flow(film, settings)
    true = [true_field(stage, times, field) for field in flow.velocities]
    rows = []
    for field, known in zip(flow.velocities, true, strict=True):
        both = np.isfinite(field.sigma) & np.isfinite(known.vx)
        columns = field.vx, field.vy, field.sigma, *known
        rows.append(np.stack([part[both] for part in columns]))
    missed = sum(int(np.isfinite(known.vx).sum()) for known in true)
    out = folder / f"velocity-{name.replace(' ', '-')}-{run.name.split('-')[0]}.npz"
    np.savez(out, rows=np.concatenate(rows, axis=1), there=missed, frame=1 / camera.rate)
    write_figure(out.with_suffix(".png"), lambda: figure(flow.velocities[1], true[1], name))
    return out


def figure(field: object, true: TrueField, name: str) -> object:
    """Measured and true arrows of an interval, and their differences with bars of sigma."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.5, 4.2), layout="constrained")
    fields, along = figure.subplots(1, 2, width_ratios=[1, 1.1])
    seen = np.isfinite(field.vx)
    most = np.nanmax(np.hypot(true.vx, true.vy))
    for vx, vy, colour, label in ((true.vx, true.vy, "#9a9a9a", "true"),
                                  (field.vx, field.vy, "#d1495b", "measured")):  # fmt: skip
        fields.quiver(1e3 * field.x, 1e3 * field.y, np.where(seen, vx, np.nan), vy, color=colour,
                      angles="xy", scale=8 * most, width=0.007 if label == "true" else 0.0035,
                      label=label)  # fmt: skip
    fields.set(aspect="equal", xlabel="x [mm]", ylabel="height above the outlet [mm]",
               title=f"{name}, {field.start:.2g} to {field.end:.2g} s")  # fmt: skip
    fields.margins(0.15, 0.3)  # arrows begin at their positions
    fields.legend(loc="lower left", bbox_to_anchor=(0, 1.08), ncols=2, fontsize=8)
    for got, known, label, colour in ((field.vx, true.vx, "along x", "#30638e"),
                                      (field.vy, true.vy, "along y", "#d1495b")):  # fmt: skip
        along.errorbar(known[seen], got[seen], field.sigma[seen], fmt="o", ms=3, lw=0.8,
                       color=colour, label=label)  # fmt: skip
    ends = along.get_xlim()
    along.plot(ends, ends, color="#555555", lw=0.8, zorder=0)
    along.set(xlabel="true velocity [m/s]", ylabel="measured, +- sigma [m/s]")
    along.legend(fontsize=8)
    return figure


def line(name: str, rows: np.ndarray) -> str:
    """One line of a table; in mm/s."""
    vx, vy, sigma, tx, ty = rows[:5]
    off = np.stack([vx - tx, vy - ty])
    within = np.mean(np.abs(off) < sigma)
    rms = [np.sqrt(np.mean(np.square(part))) for part in (np.hypot(tx, ty), off, sigma)]
    bias = off.mean(axis=1)
    return (
        f"| {name} | {rows.shape[1]} | {1e3 * rms[0]:.0f} | {1e3 * bias[0]:+.1f} | "
        f"{1e3 * bias[1]:+.1f} | {1e3 * rms[1]:.1f} | {1e3 * rms[2]:.1f} | {within:.0%} |"
    )


def thirds(rows: np.ndarray, key: int, factor: float, unit: str) -> list[str]:
    """Lines by a column's thirds, of the windows that have it: at the edge no slope is known."""
    rows = rows[:, np.isfinite(rows[key])]
    ends = np.quantile(rows[key], np.linspace(0, 1, PARTS + 1))
    which = np.clip(np.searchsorted(ends, rows[key], side="right") - 1, 0, PARTS - 1)
    return [
        line(f"{factor * ends[k]:.3g} to {factor * ends[k + 1]:.3g} {unit}", rows[:, which == k])
        for k in range(PARTS)
    ]


def table(folder: Path) -> str:
    """All films, and all windows by distance from walls and by strain."""
    files = sorted(folder.glob("velocity-*.npz"))
    found = [np.load(path) for path in files]
    every = np.concatenate([one["rows"] for one in found], axis=1)
    strain = np.concatenate([one["rows"][5] * one["frame"] for one in found])
    every = np.vstack([every, strain])
    rule = "|" + "---|" * 8
    parts = ["Speeds in mm/s, root mean square; bias is measured less true.", ""]
    parts += [COLUMNS.format("film"), rule]
    parts += [line(f"{path.stem.removeprefix('velocity-')} ({one['rows'].shape[1]} of "
                   f"{int(one['there'])} windows with particles)", one["rows"])
              for path, one in zip(files, found, strict=True)]  # fmt: skip
    parts += [line("all", every), "", COLUMNS.format("from the nearest wall"), rule]
    parts += [*thirds(every, 6, 1e3, "mm"), "", COLUMNS.format("strain per frame"), rule]
    return "\n".join([*parts, *thirds(every, 7, 100, "%")])


def main() -> None:
    """Measure the films named on the command line, or print what is there."""
    run, folder, *names = sys.argv[1:]
    Path(folder).mkdir(parents=True, exist_ok=True)
    for name in names:
        measure(Path(run), Path(folder), name)
    if not names:
        print(table(Path(folder)))


if __name__ == "__main__":
    main()
