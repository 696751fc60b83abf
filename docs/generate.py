"""Write what the docs take from the code: key tables, example cases, the map of the packages.

`python docs/generate.py` writes it; a test compares what stands there with what this would write.
"""

import ast
import re
import sys
from pathlib import Path

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
        **_with_part("docs/sweeps.md", "keys", plain_table(StudyKeys)),
        **_with_part("docs/silo-case.md", "keys", key_tables(silo.Settings)),
        **_with_part("docs/damper-case.md", "keys", key_tables(damper.Settings)),
        **_with_part("docs/silo-loads.md", "keys", key_tables(Spec)),
        **_with_part("README.md", "map", _map()),
        **_with_part("docs/contributing.md", "modules", _modules()),
        **_with_part("docs/verification.md", "tests", _verified()),
    }


def _with_part(name: str, part: str, text: str) -> dict[Path, str]:
    """A file with the text between its comments `part` and `end of part`."""
    begin, end = f"<!-- {part}: made by docs/generate.py -->\n", f"<!-- end of {part} -->\n"
    before, found, rest = (ROOT / name).read_text(encoding="utf-8").partition(begin)
    if not found or end not in rest:
        sys.exit(f"{name}: has no lines {begin.strip()} and {end.strip()}")
    return {ROOT / name: f"{before}{begin}\n{text}\n{end}{rest.partition(end)[2]}"}


def _map() -> str:
    """A row for each package: its purpose and its folders."""
    rows = ["| package | purpose | folders |", "|---|---|---|"]
    for name in PACKAGES:
        folders = [f"`{path.name}`" for path in _folders(ROOT / name)]
        rows.append(
            f"| `{name}/` | {_summary(ROOT / name / '__init__.py')} | {', '.join(folders)} |"
        )
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


def _verified() -> str:
    """Each test that compares with a source or a closed form, numbered, in its own words."""
    parts, number = [], 0
    for folder, title in VERIFIED.items():
        parts.append(f"## {title}\n")
        for file in sorted((ROOT / "tests" / folder).glob("test_*.py")):
            tree = ast.parse(file.read_text(encoding="utf-8"))
            own = [(f.name, ast.get_docstring(f) or "") for f in ast.walk(tree)
                   if isinstance(f, ast.FunctionDef) and f.name.startswith("test_")]  # fmt: skip
            own = [(name, words) for name, words in own if SOURCE.search(words)]
            if own:
                parts.append(f"### {_summary(file).rstrip('.')}\n\n`tests/{folder}/{file.name}`\n")
            for name, words in own:
                number += 1
                sentence = name.removeprefix("test_").replace("_", " ")
                parts.append(
                    f"**{number}.** {sentence[0].upper()}{sentence[1:]}.\n{_plain(words)}\n"
                )
    return "\n".join(parts)


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
