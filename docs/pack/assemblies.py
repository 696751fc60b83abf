"""Cases of many particles: numbers of committed results, of experiments and of other engines."""

import csv
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from impacts import of_table
from record import MEASURED, SIMULATED, THESIS, WOOD, Case, Row, hertz

from damper3d.case.case import DamperCase
from granulab.campaign.output.results import read_results
from granulab.campaign.output.statistics import mean_sd, noise_of_one_more
from granulab.contact.files.datafile import data_file
from silo2d.case.case import SiloCase
from silo2d.measures.clogging.sizes import mean_avalanche

DOCS = Path(__file__).parents[1]
RESULTS = DOCS / "results"
_ONE_MORE = """\
half width of the 95 % interval in which one more run of the same kind lies, t sd sqrt(1 + 1/n) of \
n runs (granulab.campaign.output.statistics)"""
POINTS = (("optimum", 20.0, 5.0), ("optimum", 40.0, 20.0), ("shares", 160.0, 3.0))
# A line of the table of the thesis's damper in docs/**/lammps-damper.md.
_NUMBER = r" ([\d.]+) ± ([\d.]+) "
_LINE = re.compile(
    rf"^\| (\d+), (\d+), along, the thesis's \|{_NUMBER}\|{_NUMBER}\|$", re.MULTILINE
)
_POURED = 3  # packings of each number there


def _table(name: str) -> list[dict[str, str]]:
    file = data_file("published", name)
    assert file is not None
    lines = file.read_text(encoding="utf-8").splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def _spread(variant, quantity, values: Iterable[float], kind, source) -> Row:
    found = mean_sd(list(values))
    assert found.mean is not None
    assert found.sd is not None
    more = noise_of_one_more(found.n, found.sd, found.n - 1)
    return Row(variant, quantity, found.mean, more, kind=kind, source=f"{source}, n = {found.n}")


def damper() -> Case:
    """The thesis's damper at three points, here and by LAMMPS."""
    case, rows, variants = DamperCase.load("thesis"), [], []
    (page,) = DOCS.rglob("lammps-damper.md")
    by_both = {
        (float(frequency), float(gamma)): {"GranuLab": (mean, sd), "LAMMPS of July 2025": other}
        for frequency, gamma, mean, sd, *other in _LINE.findall(page.read_text("utf-8"))
    }
    assert by_both
    for table, frequency, gamma in POINTS:
        label = f"{frequency:g} Hz, Gamma {gamma:g}"
        variants.append({"name": label, "motion.frequency_hz": frequency, "motion.gamma": gamma})
        here = [float(row["efficiency"])
                for row in read_results(RESULTS / f"damper3d/reproduce-{table}.csv")[1]
                if row["diameter_mm"] == 5 and (row["frequency_hz"], row["gamma"]) == (
                    frequency, gamma) and row.get("height_mm", 40) == 40
                and row.get("orientation", "vertical") == "vertical"]  # fmt: skip
        rows.append(_spread(label, "efficiency", here, SIMULATED,
                            f"GranuLab, damper3d reproduce {table}"))  # fmt: skip
        for engine, (mean, sd) in by_both.get((frequency, gamma), {}).items():
            more = noise_of_one_more(_POURED, float(sd), _POURED - 1)
            rows.append(Row(label, "efficiency by wall work", float(mean), more, kind=SIMULATED,
                            source=f"{engine}, docs {page.name}, n = {_POURED}"))  # fmt: skip
    run, enclosure = case.settings.run, case.enclosure
    law = hertz(case.pair_law.mu, case.restitution["particle_particle"])
    setup: dict[str, Any] = {
        "time_step_s": case.time_step, "cycles": run.cycles, "cycles_not_counted": run.discard,
        "gravity_m_s2": [float(x) for x in case.gravity], "law": law,
        "material": [of_table("acrylic")],
        "enclosure": {"shape": "cylinder", "diameter_m": enclosure.diameter,
                      "height_m": enclosure.height, "material": 1, "curvature": "none: R = r"},
        "particles": {"shape": "sphere", "count": case.count, "radius_m": float(case.radii[0]),
                      "start": "random and at rest under gravity, before the enclosure moves"},
        "motion": {"equation": "u(t) = Gamma g/omega^2 sin(omega t) of the enclosure along z",
                   "frequency_hz": 0.0, "gamma": 0.0},
        "variant": variants,
    }  # fmt: skip
    return Case("damper-thesis", "Efficiency of the thesis's damper: 358 spheres in a cylinder",
                f"{THESIS}, Tables 6.1 and 6.2; LAMMPS: docs/**/{page.name}", _ONE_MORE, setup,
                tuple(rows))  # fmt: skip


def silo() -> Case:
    """Silo A4: experiment, SPOLY and here."""
    case = SiloCase.load("A4")
    where = "A", 1e3 * case.outline.outlet
    trials = [float(row["time_s"]) for row in _table("silo_discharge_experiment")
              if (row["silo"], float(row["outlet_mm"])) == where]  # fmt: skip
    spoly = [float(row["time_s"]) for row in _table("silo_discharge_simulation")
             if (row["silo"], float(row["outlet_mm"])) == where]  # fmt: skip
    ours = [float(row["discharge_time_s"])
            for row in read_results(RESULTS / "silo2d/reproduce-discharge.csv")[1]
            if row["silo"] == "A4"]  # fmt: skip
    found = mean_sd(ours)
    assert found.sd is not None
    rows = (
        _spread("", "discharge time", trials, MEASURED, "experiment, Table 5"),
        Row("", "discharge time", spoly[0], noise_of_one_more(1, found.sd, found.n - 1),
            kind=SIMULATED, source="SPOLY, Table 6, n = 1; scatter of GranuLab's"),
        _spread("", "discharge time", ours, SIMULATED, "GranuLab, silo2d reproduce discharge"),
    )  # fmt: skip
    return Case("silo-a4", "Discharge of silo A4: polygonal wood particles",
                "Alonso-Marroquin et al., Granular Matter 15 (2013) 811; the particles' outlines "
                "are a reconstruction", _ONE_MORE, _silo_setup(case), rows, WOOD)  # fmt: skip


def _silo_setup(case: SiloCase) -> dict[str, Any]:
    """Walls, particles, laws and filling of a silo."""
    laws = {"particles": case.particle_law, "walls": case.wall_law}
    return {
        "time_step_s": case.time_step, "gravity_m_s2": [0.0, 0.0, -9.81],
        "fill": {"level_m": case.settings.fill.level, "start": "poured without friction from the "
                 "top, at rest; then friction on, and the outlet opened at once"},
        "silo": {"outline_m": case.outline.polygon.tolist(), "outlet_m": case.outline.outlet},
        "law": {name: {"friction": law.mu, "stiffness_n_m": law.kn,
                       "tangential_stiffness_n_m": law.kt, "damping_1_s": law.gamma_n,
                       "tangential_damping_1_s": law.gamma_t, "ends_at_zero": "overlap"}
                for name, law in laws.items()},
        "surface_density_kg_m2": case.surface_density,
        "contacts": "each vertex of one and edge of the other particle is a contact of its own",
        "shape": [{"name": one.name, "corner_radius_m": one.spheroradius,
                   "core_m": [[round(float(x), 9) for x in corner] for corner in one.core]}
                  for one in case.shapes.shapes],
        "variant": [],
    }  # fmt: skip


def clogging() -> Case:
    """Mean avalanches of the wood's outlines over a flat floor."""
    head, found = read_results(RESULTS / "silo2d/clogging/clog-D3-wood19.csv", "silo2d clog")
    setup, rows, variants = _silo_setup(SiloCase.load("D3")), [], []
    level = re.search(r"--fill-level '([\d.]+) mm'", head["command"])[1]
    setup["fill"]["level_m"] = float(level) / 1e3
    setup["refill"] = "what left is put on the surface, as fast as the nearest; so is a broken arch"
    for outlet in sorted({row["outlet_m"] for row in found}):
        label = f"{1e3 * outlet:g} mm"
        own = [row for row in found if row["outlet_m"] == outlet]
        size = sum(sum(row["sizes"]) for row in own)
        clogs = sum(row["cut"].count(0) for row in own)
        mean = mean_avalanche(size, clogs)
        far = max(mean.high - mean.value, mean.value - mean.low)
        variants.append({"name": label, "silo.outlet_m": outlet})
        rows.append(Row(label, "mean avalanche", mean.value, 2**0.5 * far, kind=SIMULATED,
                        source=f"GranuLab, silo2d clog, {clogs} clogs"))  # fmt: skip
    return Case("clogging-wood", "Mean avalanche of polygonal particles over a flat floor",
                "GranuLab, silo2d clog; the particles of Alonso-Marroquin et al. 2013, "
                "reconstructed", "the farther end of the 95 % interval (Garwood 1936), times root "
                "2 for another study of as many clogs", setup | {"variant": variants}, tuple(rows),
                WOOD)  # fmt: skip


def cases() -> list[Case]:
    """All of this module."""
    return [damper(), silo(), clogging()]
