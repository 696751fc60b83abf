"""A table of slow tests in words: the stiffness of each shape, and the thesis's claims."""

from collections.abc import Sequence
from typing import Any

from damper3d.studies.quasistatic.claims import verdicts
from damper3d.studies.quasistatic.measure import Result
from damper3d.studies.quasistatic.shapes import Scatter, Shape, by_shape, scatter_of
from granulab.campaign.claims.judge import report_claims
from granulab.campaign.output.layout import columns, done, not_done
from granulab.campaign.runs.folder import RunFolder

Row = dict[str, Any]

# Inertial number up to which a test is slow (GDR MiDi 2004, 10.1140/epje/i2003-10153-0), and part
# of the pre-load by which its mean may be off.
_SLOW, _HELD = 1e-3, 0.25
_SCATTERED = ("stiffness_n_per_m", "force_mean_n")
_MEASURED = (*_SCATTERED, "force_end_n", "bed_height_m", "packing_fraction")
_TITLES = {
    "compress": "normal force on the base over the displacement of the table (Figs 8.16, 8.17)",
    "shear": "horizontal force on the bottom half over that of the top half (Figs 8.18, 8.19)",
}


def report(rows: Sequence[Row]) -> str:
    """Report of a table: a line a shape, the claims judged, and the quality of the tests."""
    shapes = by_shape(rows)
    lines = not_done(rows, ["shape", "seed"])
    if not shapes:
        return "\n".join(["no test is done", *lines])
    first = next(iter(shapes.values())).rows[0]
    return "\n\n".join(
        filter(
            None,
            [
                f"{first['test']}: {_TITLES[first['test']]}\n{_how(first, shapes)}",
                "\n".join(lines + warnings(done(rows))),
                _table(shapes),
                "" if warnings(done(rows)) else report_claims(verdicts(first["test"], shapes)),
                _quality(done(rows)),
            ],
        )
    )


def warnings(rows: Sequence[Row]) -> list[str]:
    """Lines on tests that were not slow or not under their pre-load; no claim is judged by them."""
    fastest, off, found = max(row["inertial_number"] for row in rows), _off(rows), []
    if fastest > _SLOW:
        found.append(f"an inertial number of {fastest:.1e}, above {_SLOW:g}, is not slow")
    if off > _HELD:
        found.append(f"a mean pre-load {100 * off:.2g} %, more than {100 * _HELD:g} %, off")
    return [f"warning: {one}: no claim is judged; give a lower --speed" for one in found]


def _off(rows: Sequence[Row]) -> float:
    """Part of the pre-load by which its mean is off, at most; 0 where none is held."""
    held = [row for row in rows if row["preload_mean_n"] is not None]
    return max((abs(row["preload_mean_n"] / row["preload_n"] - 1) for row in held), default=0.0)


def finished_test(run: RunFolder) -> str:
    """A finished run of one test for a person to read."""
    return one_test(Result.read(run, reused=False))


def one_test(found: Result) -> str:
    """A test of one packing for a person to read."""
    held = ""
    if found.preload_mean_n is not None:
        held = f", held at {found.preload_mean_n:.4g} N in the mean"
        held += f" ({found.preload_rms_deviation_n:.2g} N rms away)"
    closed = found.energy_closure
    lines = [
        f"{found.test} of {found.n_particles} of {found.particles}, seed {found.seed}: secant "
        f"stiffness {1e-3 * found.stiffness_n_per_m:.4g} N/mm to {1e3 * found.at_m:g} mm",
        f"  {_TITLES[found.test]}",
        f"  force            {found.force_start_n:.4g} N at the start, {found.force_end_n:.4g} N "
        f"at {1e3 * found.distance_m:g} mm, {found.force_mean_n:.4g} N above the start in the mean",
        f"  pre-load         {found.preload_n:g} N{held}",
        f"  bed              {1e3 * found.bed_height_m:.2f} mm high under it, packing fraction "
        f"{found.packing_fraction:.3f}",
        f"  slow             {1e3 * found.speed_m_per_s:g} mm/s, inertial number "
        f"{found.inertial_number:.1e}",
        f"  checks           forces balance to {found.force_imbalance:.1e} of the largest"
        + ("" if closed is None else f", energy balance closed to {100 * abs(closed):.1g} %"),
        f"  cost             {found.cpu_us_per_step:.1f} us of CPU a step, {found.steps:,} steps "
        f"of {found.time_step_s:.3g} s; {found.cpu_s:.0f} s in all",
        f"  run folder       {found.run_folder}",
        *warnings([vars(found)]),
    ]
    return "\n".join(lines)


def summary(test: str, rows: Sequence[Row]) -> dict[str, Any]:
    """The table for --json: a word a shape, the claims, and all runs."""
    shapes = by_shape(rows)
    doubts = warnings(done(rows)) if shapes else []
    judged = [] if doubts else verdicts(test, shapes)
    return {
        "test": test,
        "warnings": doubts,
        "shapes": [
            {"shape": name, "packings": len(shape.rows)}
            | {column: _measured(shape, column, shapes, test) for column in _MEASURED}
            for name, shape in shapes.items()
        ],
        "statements": [{"statement": one.words, "holds": one.holds} for one in judged],
        "rows": list(rows),
    }


def _measured(
    shape: Shape, column: str, shapes: dict[str, Shape], test: str
) -> dict[str, float | None]:
    """A mean over the packings, and the half width of its 95 % interval where that is known."""
    scatter = scatter_of(shapes, test, column) if column in _SCATTERED else None
    sample = shape.sample(column)
    width = None if scatter is None else scatter.half_width(sample)
    return {"value": sample.mean, "half_width": width}


def _how(first: Row, shapes: dict[str, Shape]) -> str:
    counts = sorted({len(shape.rows) for shape in shapes.values()})
    packings = f"{counts[0]}" if len(counts) == 1 else f"{counts[0]} to {counts[-1]}"
    return (
        f"{first['n_particles']} particles, pre-load {first['preload_n']:g} N, "
        f"{1e3 * first['speed_m_per_s']:g} mm/s over {1e3 * first['distance_m']:g} mm; "
        f"packings of each shape: {packings};\n+- the 95 % interval of a mean, from the scatter of "
        "one packing pooled over the shapes"
    )


def _table(shapes: dict[str, Shape]) -> str:
    first = next(iter(shapes.values())).rows[0]
    header = [
        "  shape", f"secant to {1e3 * first['at_m']:g} mm [N/mm]", "rise of force, mean [N]",
        "at the end [N]", "bed [mm]", "packing",
    ]  # fmt: skip
    stiffness, mean = (scatter_of(shapes, first["test"], column) for column in _SCATTERED)
    lines = [
        [
            f"  {name}",
            _with_interval(shape, "stiffness_n_per_m", stiffness, 1e-3),
            _with_interval(shape, "force_mean_n", mean),
            f"{shape.sample('force_end_n').mean:.4g}",
            f"{1e3 * (shape.sample('bed_height_m').mean or 0.0):.2f}",
            f"{shape.sample('packing_fraction').mean:.3f}",
        ]
        for name, shape in shapes.items()
    ]
    return columns(header, lines)


def _with_interval(shape: Shape, column: str, scatter: Scatter | None, scale: float = 1.0) -> str:
    sample = shape.sample(column)
    spread = "" if scatter is None else f" +- {scale * scatter.half_width(sample):.3g}"
    return f"{scale * (sample.mean or 0.0):.4g}{spread}"


def _quality(rows: Sequence[Row]) -> str:
    """Worst of all tests: inertia, balances of force and energy, pre-load, yield."""
    closed = [abs(row["energy_closure"]) for row in rows if row["energy_closure"] is not None]
    parts = [
        f"inertial number at most {max(row['inertial_number'] for row in rows):.1e}",
        "forces on all walls balance weight and inertia to "
        f"{_most(rows, 'force_imbalance'):.1e} of the largest",
    ]
    if closed:
        parts.append(f"unaccounted energy at most {100 * max(closed):.2g} % of the dissipated")
    held = [r for r in rows if r["preload_mean_n"] is not None]
    if held:
        rms = max(r["preload_rms_deviation_n"] / r["preload_n"] for r in held)
        parts.append(
            f"pre-load held to {100 * _off(held):.2g} % in the mean, {100 * rms:.2g} % rms"
        )
    return "\n".join(["of all tests:", *(f"  {part}" for part in parts)])


def _most(rows: Sequence[Row], column: str) -> float:
    return max(float(row[column]) for row in rows)
