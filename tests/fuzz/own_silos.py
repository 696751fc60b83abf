"""Silos as strangers would describe them: shapes, materials and an outline of their own.

    python tests/fuzz/own_silos.py [--cases 200] [--first 0] [--workers 2] [--write FILE.csv]

Each case is drawn from its number alone: one to four convex outlines of 1 to 30 mm with a
spheroradius of their own, density, stiffness, damping and friction, a hopper or an asymmetric
outline, and a level; at most 3,000 particles. What refuses it, what it came to and how its energy
closed goes into a table, a line a case.
"""

import argparse
import csv
import io
import math
import multiprocessing
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from granulab.errors import InputError, SimulationError
from silo2d.case.case import SiloCase
from silo2d.case.plan import expected_particles
from silo2d.run.packing import load_packing, packing_folder
from silo2d.run.protocol import run

MOST_PARTICLES = 3000
MOST_WORK = 3e8  # particles times steps that a case may need: some twenty seconds of CPU


def drawn_case(number: int, smaller: float = 1.0) -> dict[str, str]:
    """Texts of case.toml, shapes.toml and materials.toml of the case of a number.

    smaller: by how much the number of particles is divided.
    """
    rng = np.random.default_rng([18, number])
    size = log_uniform(rng, 1.0, 30.0)  # [mm]
    shapes = [_shape(rng, size * rng.uniform(0.8, 1.25)) for _ in range(rng.integers(1, 5))]
    thinnest = min(_width(np.array(shape)) for shape in shapes)
    area = float(np.mean([_area(np.array(shape)) for shape in shapes]))
    spheroradius = rng.uniform(0.03, 0.25) * thinnest
    listed = "\n".join(
        f'[[shape]]\nname = "s{k}"\noutline = {[[round(x, 4), round(y, 4)] for x, y in shape]}\n'
        for k, shape in enumerate(shapes)
    )
    return {
        "shapes.toml": f'schema = 1\nspheroradius = "{spheroradius:.4g} mm"\nunit = "mm"\n{listed}',
        "materials.toml": _materials(rng),
        "case.toml": _case(rng, number, size, area, smaller),
    }


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(math.log(low), math.log(high))))


def _shape(rng: np.random.Generator, size: float) -> list[tuple[float, float]]:
    """Outline of a particle [mm], counter-clockwise: regular, a rod, or without any symmetry."""
    kind, n = rng.choice(["regular", "rod", "irregular"]), int(rng.integers(3, 9))
    if kind == "rod":
        long, thick = size, size / rng.uniform(1.5, 6.0)
        return [(0.0, 0.0), (long, 0.0), (long, thick), (0.0, thick)]
    turn = 2 * math.pi / n
    angles = turn * (np.arange(n) + (rng.uniform(-0.3, 0.3, n) if kind == "irregular" else 0.0))
    x, y = 0.5 * size * np.cos(angles), 0.5 * size * np.sin(angles)
    if kind == "irregular":
        y = y * rng.uniform(0.4, 1.0)
    return list(zip(x.tolist(), y.tolist(), strict=True))


def _area(outline: np.ndarray) -> float:
    x, y = outline.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def _width(outline: np.ndarray) -> float:
    edge = np.roll(outline, -1, axis=0) - outline
    normal = np.stack([edge[:, 1], -edge[:, 0]], axis=1) / np.hypot(*edge.T)[:, None]
    return float(np.ptp(outline @ normal.T, axis=0).min())


def _materials(rng: np.random.Generator) -> str:
    """A table of two materials and their pairs, damping by its constant or by the restitution."""
    kn = log_uniform(rng, 30.0, 3e4)  # [N/mm]
    pairs = []
    for other in ("seed", "wall"):
        e, mu = rng.uniform(0.1, 0.95), rng.choice([0.0, rng.uniform(0.05, 1.0)], p=[0.05, 0.95])
        pairs.append(
            f'[pair.seed-{other}]\nfriction = {{ value = {mu:.3f}, method = "incline", source = '
            f'"own" }}\nrestitution = {{ value = {e:.3f}, method = "drop", source = "own" }}\n'
            f'[pair.seed-{other}.linear]\nkn = {{ value = "{kn:.4g} N/mm", method = "press", '
            f'source = "own" }}\nkt = {{ value = "{kn * rng.uniform(0.05, 1.0):.4g} N/mm", method '
            '= "press", source = "own" }\n'
            f'gamma_n = {{ value = "{log_uniform(rng, 30, 1e4):.4g} 1/s", method = "drop", '
            'source = "own" }\ngamma_t = { value = "3 1/s", method = "incline", source = "own" }\n'
        )
    return (
        "schema = 1\n[material.seed]\n"
        f'density = {{ value = "{log_uniform(rng, 0.3, 8.0):.3g} g/cm3", source = "own" }}\n'
        f'length = {{ value = "{log_uniform(rng, 5.0, 200.0):.3g} mm", source = "own" }}\n'
        '[material.wall]\ndensity = { value = "2.7 g/cm3", source = "own" }\n' + "".join(pairs)
    )


def _case(rng: np.random.Generator, number: int, size: float, area: float, smaller: float) -> str:
    """A case file; all lengths of the silo go with the size [mm] and mean area of the particles."""
    wanted = log_uniform(rng, 60, MOST_PARTICLES) / smaller
    slender = rng.uniform(0.8, 3.0)  # height over width
    width = max(math.sqrt(wanted * area / slender), 5.0 * size)
    outlet = min(rng.uniform(3.0, 9.0) * size, 0.8 * width)
    angle = float(rng.choice([0.0, rng.uniform(15, 75)], p=[0.2, 0.8]))
    run = (width - outlet) / 2
    rise = run * math.tan(math.radians(angle))
    height = max(slender * width, rise + width / 2) + 3 * size
    level = rng.uniform(0.6, 0.97) * height
    if rng.random() < 0.4:  # an outline whose two sides differ
        left, right = -width / 2 * rng.uniform(0.6, 1.4), width / 2 * rng.uniform(0.8, 1.2)
        low = rise * rng.uniform(0.3, 1.0)
        points = [
            (-outlet / 2, 0.0), (outlet / 2, 0.0), (max(right, outlet / 2 + size), rise),
            (max(right, outlet / 2 + size), height), (min(left, -outlet / 2 - size), height),
            (min(left, -outlet / 2 - size), low),
        ]  # fmt: skip
        points = list(dict.fromkeys((round(x, 3), round(y, 3)) for x, y in points))
        silo = f"outline = {[list(p) for p in points]}\n"
    else:
        silo = (
            f'angle = "{angle:.1f} deg"\noutlet = "{outlet:.1f} mm"\nwidth = "{width:.1f} mm"\n'
            f'height = "{height:.1f} mm"\n'
        )
    damping = rng.choice(["published", "restitution"])
    rough = rng.choice(["false", "true"], p=[0.8, 0.2])
    end = rng.choice(["overlap", "force"])
    return (
        f'schema = 1\nname = "own{number:03}"\n[silo]\n{silo}'
        '[particles]\nshapes = "shapes.toml"\nmaterials = "materials.toml"\nmaterial = "seed"\n'
        f'wall = "wall"\n[law]\ndamping = "{damping}"\ncontact_end = "{end}"\n'
        f'[fill]\nlevel = "{level:.1f} mm"\nfriction = {rough}\n'
        f'[run]\nmax_time = "{max(60 * math.sqrt(size / 9810), 1.0):.2f} s"\n'
    )


def written_case(number: int, folder: Path) -> Path:
    """The case file of a number, in a folder of its own; few enough particles for MOST_WORK."""
    own = folder / f"own{number:03}"
    own.mkdir(parents=True, exist_ok=True)
    smaller = 1.0
    while True:
        for name, text in drawn_case(number, smaller).items():
            (own / name).write_text(text, encoding="utf-8")
        try:
            case = SiloCase.load(own / "case.toml")
        except InputError:
            return own / "case.toml"
        n = expected_particles(case)
        # A second of filling; of the discharge two, in which half of the particles are inside.
        steps = 1.0 / case.pour_time_step + 1.0 / case.time_step
        if (n <= MOST_PARTICLES and n * steps <= MOST_WORK) or smaller > MOST_PARTICLES:
            return own / "case.toml"
        smaller *= 2.0


def tried(number: int, folder: Path) -> dict[str, Any]:
    """The row of a case: refused, or what it was and what it came to."""
    file = written_case(number, folder)
    row: dict[str, Any] = {"case": file.parent.name}
    try:
        case = SiloCase.load(file)
    except InputError as error:
        return {**row, "outcome": "refused", "said": str(error).replace(f"{file.parent}/", "")}
    shapes, law = case.shapes, case.particle_law
    row |= {
        "size_mm": 2e3 * shapes.bounding_radius,
        "spheroradius_mm": 1e3 * min(shape.spheroradius for shape in shapes.shapes),
        "mass_g": 1e3 * case.mean_mass,
        "kn_n_per_mm": 1e-3 * law.kn,
        "restitution": case.restitution()["particle_particle"]["one_contact"],
        "friction": law.mu,
        "width_mm": 1e3 * case.outline.width,
        "level_mm": 1e3 * case.settings.fill.level,
        "step_us": 1e6 * case.time_step,
        "filling_kn_n_per_mm": 1e-3 * case.pour_laws[0].kn,
    }
    try:
        result = run(case, out=folder)
    except SimulationError as error:
        return {**row, "outcome": "failed", "said": str(error)}
    packing = load_packing(packing_folder(case, folder))
    return row | {
        "outcome": result.outcome,
        "particles": result.n_particles,
        "poured": packing.attempts if packing else None,
        "halvings": result.time_step_halvings,
        "closure": result.energy_closure,
        "cpu_s": result.cpu_s,
    }


def report(rows: list[dict[str, Any]]) -> str:
    """Counts of what the cases came to."""
    ran = [row for row in rows if row["outcome"] not in ("refused", "failed")]
    closures = [abs(row["closure"] or 0.0) for row in ran]
    lines = [
        f"{len(rows)} silos of strangers: {len(ran)} ran, "
        f"{sum(row['outcome'] == 'refused' for row in rows)} refused before anything was "
        f"computed, {sum(row['outcome'] == 'failed' for row in rows)} failed",
        f"energy closed to {100 * max(closures, default=0.0):.2g} % of what was dissipated at "
        f"worst; "
        f"step halved in {sum(row['halvings'] > 0 for row in ran)}, poured more than once in "
        f"{sum(row['poured'] > 1 for row in ran)}; {sum(row['cpu_s'] for row in ran) / 60:.0f} min "
        "of CPU",
        *(f"{row['case']} {row['outcome']}: {row['said']}" for row in rows if "said" in row),
    ]
    return "\n".join(lines)


def table(rows: list[dict[str, Any]]) -> str:
    """The rows as CSV, numbers to four digits."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    text = io.StringIO()
    writer = csv.DictWriter(text, names, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({k: f"{v:.4g}" if isinstance(v, float) else v for k, v in row.items()})
    return text.getvalue()


def study(
    doc: str | None, cases: int, name: str,
    tried: Callable[..., dict[str, Any]], report: Callable[[list[dict[str, Any]]], str],
) -> None:  # fmt: skip
    """Run drawn cases from the command line, print what they came to, and keep the table if wanted.

    doc       of the command's help
    cases     how many by default
    name      of the folder of runs, in the system's temporary one
    tried     gives the row of a case from its number and `folder`
    report    puts all rows into words
    """
    parser = argparse.ArgumentParser(description=doc)
    parser.add_argument("--cases", type=int, default=cases)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path(tempfile.gettempdir()) / name)
    parser.add_argument("--write", type=Path, help="table to write (CSV); the words go with it")
    args = parser.parse_args()
    rows = []
    with multiprocessing.get_context("spawn").Pool(args.workers) as pool:
        numbers = range(args.first, args.first + args.cases)
        for row in pool.imap(partial(tried, folder=args.out), numbers):
            rows.append(row)
            print(*(f"{v:.4g}" if isinstance(v, float) else v for v in row.values()), flush=True)
    print(report(rows))
    if args.write:
        args.write.write_text(table(rows), encoding="utf-8")
        args.write.with_suffix(".txt").write_text(report(rows) + "\n", encoding="utf-8")


if __name__ == "__main__":
    study(__doc__, 200, "own-silos", tried, report)
