"""Descriptions of the pack's tables and of the damper's maps, as Frictionless data packages."""

import csv
import json
import re
from collections.abc import Sequence
from itertools import takewhile
from pathlib import Path
from typing import Any

from record import CLOSED, MEASURED, SIMULATED

from damper3d.measures.phases.motion_measures import MEANING
from damper3d.reproduce import TABLES
from granulab.campaign.output.results import origin_words, read_results

ROOT = Path(__file__).parents[2]
MAPS = ROOT / "docs/results/damper3d"
PROFILE = "tabular-data-package"
LICENCE = {"name": "MIT", "path": "https://opensource.org/license/mit", "title": "MIT License"}
# Units by the ends of names; every name of a column with a unit ends so.
SUFFIXES = {"_hz": "Hz", "_mm": "mm", "_kg": "kg", "_n": "N", "_m": "m", "_s": "s"}
UNITS = {*SUFFIXES.values(), "1", "", "m/s", "rad/s", "J", "Pa", "m2", "m3", "m4"}
# Columns of the maps; a name that ends in a point describes all that begin so.
COLUMNS = {
    "orientation": "motion of the enclosure to gravity: vertical, along it; horizontal, across it",
    "height_mm": "inner height of the cylinder, whose diameter is 40 mm",
    "diameter_mm": "diameter of the spheres",
    "frequency_hz": "frequency of the enclosure's sine",
    "gamma": "largest acceleration of the enclosure over 9.81 m/s2 (thesis, eq. 6.2)",
    "seed": "number of the random packing that the run starts from",
    "fill_ratio": "volume of the particles over that of the enclosure",
    "efficiency": "energy dissipated in a counted cycle over 4 (Gamma g/omega)^2 M (eqs 6.8-6.10)",
    "efficiency_interval": "ends of the 95 % interval of the mean over the counted cycles, as JSON",
    "efficiency_wall_work": "the same of the work of the walls in place of what is dissipated",
    "efficiency_per_cycle": "efficiency of every cycle, those not counted too, as JSON",
    "energy_closure": "energy that the balance leaves unaccounted, over what is dissipated",
    "peak_wall_force_n": "largest force of the bed on the enclosure",
    "mass_kg": "mass of all particles",
    "bed_height_m": "mean height of the bed's mass over the lower end",
    "discarded": "number of cycles that do not count",
    "cycles": "number of cycles that were run",
    "phase": "name of the bed's motion, from the phase measures (docs, phases)",
    "steady": "true where the counted cycles are alike",
    "state": "done, or why there is no result",
    "reason": "reason of a run that failed",
    "steady.": "the same of the bed shaken on until its cycles are alike: ",
    "phase_measures.": "measure of the motion: ",
    "shares.": "share of the dissipated energy, by class of contact and mechanism",
    "shares_contact_count.": "the same by the thesis's count (eq. 6.7)",
    "max_impact_over_yield_velocity.": "fastest impact over the yield velocity (eq. 5.26)",
    "impacts_beyond_yield.": "share of the impacts faster than the yield velocity",
    "effective_mass.": "apparent mass of the bed at the frequency of the motion, part of it",
    "cycle.": "history within the counted cycles, folded into one, as JSON",
    "sign.": "moment of the strongest collision in a cycle (docs, statements)",
    "variant": "name of what differs from the thesis's damper",
    "surface": "particles of the experiments, which are their restitutions: smooth or printed",
    "law": "restitution: constant, or falling above the yield velocity",
    "property": "name of the property that is changed",
    "value": "value of that property in its SI unit; 1 of the standard",
    "part": "figure that the row belongs to",
    "shape": "shape of the particles",
    "ratio": "aspect ratio of spheroids, hole ratio of toroids",
    "treatment": "multi-contact model: sum, deepest or scaled",
    "bed": "name of the bed",
    "count": "number of particles",
    "at": "value that the run is made at, of what is sought",
    "amplitude_m": "amplitude of the enclosure's sine",
    "m_in_phase_kg": "effective mass in phase with the acceleration, m' of m' - i m''",
    "m_in_phase_half_width_kg": "half width of its 95 % interval over the packings",
    "m_out_of_phase_kg": "effective mass out of phase, m'' of m' - i m''",
    "m_out_of_phase_half_width_kg": "half width of its 95 % interval over the packings",
    "bed_mass_kg": "mass of all particles",
    "seeds": "number of packings",
    "rebound": "height of the first rebound of a dropped box over the drop",
}
_INTEGERS = {"seed", "cycles", "discarded", "count", "diameter_mm", "height_mm", "steady.cycles",
             "seeds"}  # fmt: skip
_OF_ITS_ROW = {"value", "at"}  # numbers whose unit another column of the row decides
_FIELDS = ("field", "arm-middle")  # tables of the effective mass over frequency and Gamma


def field(name: str, kind: str, description: str, unit: str = "") -> dict[str, Any]:
    """A column; a pure number has the unit 1, a text none."""
    found = {"name": name, "type": kind, "description": description}
    return found | ({"unit": unit} if unit else {})


def unit_of(name: str) -> str:
    """Unit of a number by the end of its name; 1: a pure number."""
    return next((unit for end, unit in SUFFIXES.items() if name.endswith(end)), "1")


def described(name: str) -> str:
    """Description of a column of the maps; KeyError for one that has none."""
    if name in COLUMNS:
        return COLUMNS[name]
    group, _, rest = name.partition(".")
    text = COLUMNS[f"{group}."]
    more = {"phase_measures": MEANING, "steady": COLUMNS}.get(group)
    words = rest.replace("_", " ").replace(".", ", ")
    return text + more[rest] if more else f"{text}: {words}"


def map_field(name: str, values: Sequence[Any]) -> dict[str, Any]:
    """A column of a map with the type that its values have."""
    kinds = {type(one) for one in values if one is not None}
    kind = "number"
    if kinds == {bool}:
        kind = "boolean"
    elif kinds == {list}:
        kind = "array"
    elif str in kinds or not kinds:
        kind = "string"
    elif name in _INTEGERS:
        kind = "integer"
    pure = kind in ("string", "boolean") or name in _OF_ITS_ROW
    return field(name, kind, described(name), "" if pure else unit_of(name))


def tables() -> dict[Path, list[dict[str, Any]]]:
    """Tables of the damper over frequency and Gamma, and their rows."""
    made = [(path, read_results(path)[1]) for path in sorted(MAPS.glob("reproduce-*.csv"))]
    found = {path: rows for path, rows in made if {"frequency_hz", "gamma"} <= set(rows[0])}
    for path in (MAPS / f"{name}.csv" for name in _FIELDS):
        lines = (x for x in path.read_text(encoding="utf-8").splitlines() if x[0] != "#")
        found[path] = [
            {key: int(text) if key in _INTEGERS else float(text) for key, text in row.items()}
            for row in csv.DictReader(lines)
        ]
    return found


def _about(path: Path) -> dict[str, Any]:
    """Title of a table, and the lines at its head that say where it is from."""
    lines = path.read_text(encoding="utf-8").splitlines()
    head = [line[2:] for line in takewhile(lambda line: line[0] == "#", lines)]
    if path.stem in _FIELDS:
        return {"title": head[0], "origin": {"command": head[1], "meaning": head[2]}}
    return {"title": TABLES[path.stem.removeprefix("reproduce-")], "origin": origin_words(head)}


def maps() -> dict[str, Any]:
    """Data package of the damper's tables over frequency and Gamma."""
    resources = [{
        "name": path.stem, "path": path.name, "profile": "tabular-data-resource", **_about(path),
        "rows": len(rows), "encoding": "utf-8", "format": "csv", "dialect": {"commentChar": "#"},
        "schema": {"fields": [map_field(name, [row[name] for row in rows]) for name in rows[0]],
                   "missingValues": [""]},
    } for path, rows in tables().items()]  # fmt: skip
    return {
        "profile": PROFILE, "name": "granular-damper-maps",
        "title": "Efficiency of granular dampers over frequency and amplitude",
        "description": "Simulated beds of acrylic particles in a closed cylinder of 40 mm that is "
        "shaken along its axis, a row a run. Conditions unless a column says otherwise: 358 "
        "spheres of 5 mm, E = 3.3 GPa, nu = 0.37, 1190 kg/m3, restitution 0.86, friction 0.52, "
        "8 cycles of which the last 5 count. Limits: the thesis's window of 5 cycles is short "
        "where the bed packs down or its cycles alternate; an interval is over the cycles of one "
        "packing, which others scatter about; one packing a point in the maps, several in the "
        "rest; spheres, but for shapes; a simulation, compared with LAMMPS and with no measured "
        "map.",
        **_common(), "resources": resources,
    }  # fmt: skip


def pack(folders: Sequence[str]) -> dict[str, Any]:
    """Data package of the benchmark cases."""
    index = [
        field("case", "string", "folder in cases/"), field("title", "string", "the case in words"),
        field("quantities", "string", "what is compared, with semicolons"),
        field("rows", "integer", "rows of its expected.csv", "1"),
        field("kinds", "string", f"{CLOSED}, {SIMULATED}, {MEASURED}: where its numbers are from"),
        field("source", "string", "publication, or closed form"),
        field("doi", "string", "of the source, where it has one"),
    ]  # fmt: skip
    resources = [_resource("cases", "cases.csv", "Index of the cases", {"fields": index}),
                 _resource("quantities", "quantities.csv", "Quantities and their units",
                           {"fields": [field("quantity", "string", "name in expected.csv"),
                                       field("unit", "string", "SI unit; 1: a pure number"),
                                       field("meaning", "string", "what it is")]})]  # fmt: skip
    resources += [_resource(name, f"cases/{name}/expected.csv", f"Expected results of {name}",
                            "expected.schema.json") for name in folders]  # fmt: skip
    return {
        "profile": PROFILE, "name": "granular-benchmarks",
        "title": "Benchmark cases of granular mechanics with expected results",
        "description": "Each folder in cases/ has a set-up (case.toml, SI) and its expected "
        "results (expected.csv).", **_common(), "resources": resources,
    }  # fmt: skip


def expected_schema() -> dict[str, Any]:
    """Schema that every expected.csv has."""
    fields = [
        field("variant", "string", "name of the [[variant]] of case.toml; empty: as it stands"),
        field("quantity", "string", "a name of quantities.csv"),
        field("body", "integer", "number of the [[body]], from 1; empty: of the whole", "1"),
        field("time_s", "number", "when; empty: at the end, or over the whole run", "s"),
        field("value", "number", "expected result, in the unit of the row"),
        field("unit", "string", "SI unit; 1: a pure number"),
        field("tolerance", "number", "agrees where |result - value| is at most this, same unit"),
        field("kind", "string", f"{CLOSED}, {SIMULATED} or {MEASURED}"),
        field("source", "string", "where the number is from; empty: source of case.toml"),
    ]
    return {"fields": fields, "missingValues": [""]}


def _resource(name: str, path: str, title: str, schema: Any) -> dict[str, Any]:
    return {"name": name, "path": path, "profile": "tabular-data-resource", "title": title,
            "encoding": "utf-8", "format": "csv", "schema": schema}  # fmt: skip


def _common() -> dict[str, Any]:
    """Licence, version and citation of both packages, by CITATION.cff."""
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    known = dict(re.findall(r"^(title|version|license): (.+)$", text, re.MULTILINE))
    assert known["license"] == LICENCE["name"]
    works = re.findall(r"^    title: >-\n((?:      .+\n)+)", text, re.MULTILINE)
    works += re.findall(r"^    title: (?!>-)(.+)$", text, re.MULTILINE)
    dois = re.findall(r"^    doi: (\S+)$", text, re.MULTILINE)
    sources = [{"title": " ".join(work.split())} for work in works]
    for source, doi in zip(sources, dois, strict=False):
        source["path"] = f"https://doi.org/{doi}"
    return {
        "version": known["version"], "licenses": [LICENCE], "sources": sources,
        "citation": f"The {known['title']} developers, {known['title']} {known['version']} "
        "(CITATION.cff), and the works under sources",
    }  # fmt: skip


def as_json(package: dict[str, Any]) -> str:
    """Text of a descriptor."""
    return json.dumps(package, indent=1, ensure_ascii=False) + "\n"
