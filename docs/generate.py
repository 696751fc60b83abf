"""Write what the docs take from the code: key tables, example cases, the map of the packages.

`python docs/generate.py` writes it; a test compares what stands there with what this would write.
"""

import ast
import csv
import json
import re
import sys
from pathlib import Path

from house import picture

from benchmarks.speed import table
from damper3d.case import settings as damper
from damper3d.run import sweep as damper_sweep
from granulab.campaign.sweeps.study_keys import StudyKeys
from granulab.contact.files.reference import key_tables, plain_table
from silo2d.case import settings as silo
from silo2d.loads.spec import Spec
from silo2d.run import sweep as silo_sweep

ROOT = Path(__file__).parents[1]
# Packages of the README's map, and their folders.
PACKAGES = (
    "granulab/contact", "granulab/campaign", "silo2d", "damper3d", "calibration", "granulab/studio",
)  # fmt: skip
# Folders of tests, and what they are about.
VERIFIED = {
    "contact": "Contact laws", "silo2d": "Silos", "damper3d": "Dampers",
    "calibration": "Measurements", "campaign": "Statistics and runs",
}  # fmt: skip
# A picture of a file of tests that shows what they compare.
FIGURES = {
    "test_partial_slip": "contact-force", "test_sphere_impact": "contact-oblique",
    "test_damper_contact": "contact-damping", "test_cluster_contacts": "contact-shape-force",
    "test_ring_shear": "contact-ring-shear", "test_rigid_motion": "contact-free-rotation",
    "test_shapes_errors": "shape-toroid-0.2", "test_arch": "measure-arch",
    "test_fields": "measure-fields", "test_loads_closed_forms": "silo-loads-wheat",
    "test_loads_of_runs": "silo-loads-a4", "test_host": "damper-host",
    "test_excitation": "damper-excitation", "test_field": "damper-field",
    "test_design": "damper-design", "test_damper_phases": "phases-map",
}  # fmt: skip
MEASURED = ROOT / "docs/results/verification.csv"  # by `make verified`
# A docstring that names an equation, a section, a table, a figure, a publication or a law.
SOURCE = re.compile(
    r"\b(?:[Ee]qs?|[Ss]ecs?|[Ff]igs?)\. |\bTables? \d|\b(?:19|20)\d\d\b|EN 1991|Hertz|Mindlin|"
    r"Janssen|Rayleigh|Coulomb|Newton|Steiner|Student|Wilson|closed form|by hand|exact"
)


def generated() -> dict[Path, str]:
    """Every file with generated parts, and its text as it should stand."""
    return {
        ROOT / "data/cases/example.toml": silo.commented_case(),
        ROOT / "data/cases/damper.toml": damper.commented_case(),
        ROOT / "data/studies/friction.toml": silo_sweep.commented_study(),
        ROOT / "data/studies/damper.toml": damper_sweep.commented_study(),
        **_with_part("docs/runs/sweeps.md", "keys", plain_table(StudyKeys)),
        **_with_part("docs/silo/case.md", "keys", key_tables(silo.Settings)),
        **_with_part("docs/damper/case.md", "keys", key_tables(damper.Settings)),
        **_with_part("docs/silo/loads.md", "keys", key_tables(Spec)),
        **_with_part("README.md", "map", _map()),
        **_with_part("docs/reference/modules.md", "modules", _modules()),
        **_with_part("docs/runs/speed.md", "bench", _speed()),
        ROOT / "docs/pictures/house.svg": picture(ROOT, _purposes()),
        **_verified(),
    }


def _with_part(name: str, part: str, text: str) -> dict[Path, str]:
    """A file with the text between its comments `part` and `end of part`."""
    begin, end = f"<!-- {part}: made by docs/generate.py -->\n", f"<!-- end of {part} -->\n"
    before, found, rest = (ROOT / name).read_text(encoding="utf-8").partition(begin)
    if not found or end not in rest:
        sys.exit(f"{name}: has no lines {begin.strip()} and {end.strip()}")
    return {ROOT / name: f"{before}{begin}\n{text}\n{end}{rest.partition(end)[2]}"}


def _purposes() -> dict[str, str]:
    """The sentence of each package, by its folder."""
    return {name: _summary(ROOT / name / "__init__.py") for name in PACKAGES}


def _map() -> str:
    """A row for each package: its purpose and its folders."""
    rows = ["| package | purpose | folders |", "|---|---|---|"]
    for name, purpose in _purposes().items():
        folders = [f"`{path.name}`" for path in _folders(ROOT / name)]
        rows.append(f"| `{name}/` | {purpose} | {', '.join(folders)} |")
    return "\n".join(rows) + "\n"


def _modules() -> str:
    """A section for each folder with a row for each module."""
    parts = []
    for folder in [f for name in PACKAGES for f in (ROOT / name, *_below(ROOT / name))]:
        modules = [path for path in sorted(folder.glob("*.py")) if not path.name.startswith("__")]
        rows = [f"| `{path.stem}` | {_summary(path)} |" for path in modules]
        table = "\n".join(["", "| module | purpose |", "|---|---|", *rows, ""]) if rows else ""
        name = folder.relative_to(ROOT).as_posix()
        parts.append(f"### `{name}/`\n\n{_summary(folder / '__init__.py')}\n{table}")
    return "\n".join(parts)


def _speed() -> str:
    """The table of `make bench`."""
    text = (ROOT / "docs/results/bench.json").read_text(encoding="utf-8")
    return table.markdown(json.loads(text))


def _verified() -> dict[Path, str]:
    """A page for each folder of VERIFIED with its statements, numbered on, and the table of all."""
    measured = _measured()
    pages, rows, number = {}, ["| | statements | with a measured difference |", "|---|---|---|"], 1
    for folder, title in VERIFIED.items():
        parts, first, of_these = [f"# {title}: what the tests verify\n"], number, 0
        for file in sorted((ROOT / "tests" / folder).glob("test_*.py")):
            own = _statements(file)
            if own:
                parts.append(f"## {_summary(file).rstrip('.')}\n\n`tests/{folder}/{file.name}`\n")
                if file.stem in FIGURES:
                    parts.append(f"![{_summary(file)}](../pictures/{FIGURES[file.stem]}.png)\n")
            for name, words in own:
                found = measured.get(f"tests/{folder}/{file.name}::{name}")
                of_these += found is not None
                sentence = name.removeprefix("test_").replace("_", " ")
                parts.append(
                    f"**{number}.** {sentence[0].upper()}{sentence[1:]}.\n{_plain(words)}\n"
                    + (f"*{found}*\n" if found else "")
                )
                number += 1
        pages[ROOT / f"docs/verification/{folder}.md"] = "\n".join(parts)
        rows.append(f"| [{title}]({folder}.md) | {first} to {number - 1} | {of_these} |")
    return {**pages, **_with_part("docs/verification/tests.md", "tests", "\n".join(rows) + "\n")}


def _statements(file: Path) -> list[tuple[str, str]]:
    """Tests of a file that compare with a source or a closed form: their names and docstrings."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    own = [(f.name, ast.get_docstring(f) or "") for f in ast.walk(tree)
           if isinstance(f, ast.FunctionDef) and f.name.startswith("test_")]  # fmt: skip
    return [(name, words) for name, words in own if SOURCE.search(words)]


def _measured() -> dict[str, str]:
    """A sentence for each test on the comparison that comes closest to its tolerance."""
    with MEASURED.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return {
        row["test"]: f"Measured: {float(row['difference']):.2g} off {float(row['expected']):.4g}, "
        f"{float(row['allowed']):.2g} allowed; the closest of {row['comparisons']} comparisons."
        for row in rows
    }


def _plain(words: str) -> str:
    """Words of a docstring as they stand, whatever signs of Markdown are among them."""
    return re.sub(r"([*_<>|\[\]`])", r"\\\1", words)


def _folders(folder: Path) -> list[Path]:
    return sorted(path.parent for path in folder.glob("*/__init__.py"))


def _below(folder: Path) -> list[Path]:
    return [path for child in _folders(folder) for path in (child, *_below(child))]


def _summary(file: Path) -> str:
    """The first line of a module's docstring."""
    lines = (ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or "").split("\n")
    return lines[0].replace("|", r"\|")


def main() -> None:
    """Write the files that are not up to date, and name them."""
    for path, text in generated().items():
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8", newline="\n")
            print(path.relative_to(ROOT))


if __name__ == "__main__":
    main()
