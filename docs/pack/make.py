"""Write the benchmark pack: cases, expected results, index, data packages, and its page's table.

`python docs/pack/make.py` writes what is not up to date; a test compares what stands there with
what this would write. Numbers are those of closed forms and of committed results.
"""

import csv
import io
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "tests" / "helpers")]

import assemblies  # noqa: E402
import bodies  # noqa: E402
import impacts  # noqa: E402
import motions  # noqa: E402
import package  # noqa: E402
from record import QUANTITIES, Case  # noqa: E402

PAGE = HERE.parent / "verification/pack.md"
BEGIN, END = "<!-- cases: made by docs/pack/make.py -->\n", "<!-- end of cases -->\n"
EXPECTED = ("variant", "quantity", "body", "time_s", "value", "unit", "tolerance", "kind", "source")


def cases() -> list[Case]:
    """All cases, in the order of the index."""
    return [case for part in (impacts, motions, bodies, assemblies) for case in part.cases()]


def generated() -> dict[Path, str]:
    """Every file of the pack and its text as it should stand."""
    found = cases()
    files = {}
    for case in found:
        folder = HERE / "cases" / case.name
        files[folder / "case.toml"] = as_toml(case)
        files[folder / "expected.csv"] = as_csv(EXPECTED, map(expected, [case] * len(case.rows),
                                                              case.rows))  # fmt: skip
    return files | {
        HERE / "cases.csv": as_csv(
            ("case", "title", "quantities", "rows", "kinds", "source", "doi"), map(indexed, found)
        ),
        HERE / "quantities.csv": as_csv(
            ("quantity", "unit", "meaning"), ((name, *own) for name, own in QUANTITIES.items())
        ),
        HERE / "expected.schema.json": package.as_json(package.expected_schema()),
        HERE / "datapackage.json": package.as_json(package.pack([case.name for case in found])),
        package.MAPS / "datapackage.json": package.as_json(package.maps()),
        PAGE: page(found),
    }


def expected(case: Case, row) -> list[Any]:
    """A row of expected.csv."""
    unit, _ = QUANTITIES[row.quantity]
    value = 0.0 if abs(row.value) < 1e-6 * row.tolerance else row.value  # rounding, not a number
    return [row.variant, row.quantity, row.body, number(row.time_s), number(value), unit,
            f"{row.tolerance:.2g}", row.kind, row.source]  # fmt: skip


def number(value: float | str) -> str:
    """Twelve digits: more than any code agrees to, and but for the last the same everywhere."""
    return value if isinstance(value, str) else f"{value:.12g}"


def indexed(case: Case) -> list[Any]:
    """A row of cases.csv."""
    names = dict.fromkeys(row.quantity for row in case.rows)
    kinds = dict.fromkeys(row.kind for row in case.rows)
    return [case.name, case.title, "; ".join(names), len(case.rows), "; ".join(kinds), case.source,
            case.doi]  # fmt: skip


def as_csv(names: Iterable[str], rows: Iterable[Iterable[Any]]) -> str:
    """A table with its header."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([names, *rows])
    return text.getvalue()


def as_toml(case: Case) -> str:
    """The set-up; quantities are SI, with the unit at the end of the key."""
    about = {"title": case.title, "source": case.source, "doi": case.doi, "tolerance": case.reason}
    about = {key: text for key, text in about.items() if text}
    return "# Made by docs/pack/make.py.\n" + tomlkit.dumps(plain(about | case.setup))


def plain(value: Any) -> Any:
    """The same with numbers of twelve digits, and without what is empty."""
    if isinstance(value, dict):
        return {key: plain(one) for key, one in value.items() if one not in ([], {})}
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    if isinstance(value, float | np.floating):
        return float(f"{value:.12g}")
    return value


def page(found: list[Case]) -> str:
    """The page with its table of cases."""
    rows = ["| case | what it is | rows | numbers are |", "|---|---|---|---|"]
    for case in found:
        name, title, _, count, kinds, *_ = indexed(case)
        rows.append(f"| `{name}` | {title} | {count} | {kinds.replace(';', ',')} |")
    before, there, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    if not there or END not in rest:
        sys.exit(f"{PAGE.name}: has no lines {BEGIN.strip()} and {END.strip()}")
    total = sum(len(case.rows) for case in found)
    table = "\n".join([f"{len(found)} cases with {total} results.", "", *rows])
    return f"{before}{BEGIN}\n{table}\n\n{END}{rest.partition(END)[2]}"


def main() -> None:
    """Write the files that are not up to date, and name them."""
    for path, text in generated().items():
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8", newline="\n")
            print(path.relative_to(HERE.parents[1]))


if __name__ == "__main__":
    main()
