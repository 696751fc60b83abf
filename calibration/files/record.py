"""Record of how a value came into a parameter file: command, answers, raw data, figure.

Next to wood.toml stands the folder wood.record, with a JSON file for each value and the figure of
its measurement, called after section and key. A value that is replaced takes its record along into
`history` of the new one; `calibrate report` shows what fits the file as it stands.
"""

import csv
import io
import json
import math
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from calibration.files.sheets import is_spreadsheet, sheets
from calibration.files.tables import text_of
from granulab.campaign.output.files import in_shell, write_atomic
from granulab.campaign.runs.provenance import provenance
from granulab.contact.material import Measured
from granulab.errors import InputError

PACKAGES = ["numpy", "scipy", "opencv-python-headless"]
_MOST_TEXT = 200_000  # bytes of a table that is kept whole; of others name and size are
_CLOSE = 1e-9  # of a value: its digits in the file and in the record


@dataclass(frozen=True)
class Record:
    """Record of one value; see the head of this file.

    raw       text of each file that was measured, by name (where two have the same, by path), of
              a spreadsheet its sheets as CSV; None of one that is no short text
    figure    PNG of the measurement, where it has one
    """

    section: str
    key: str
    value: float
    provenance: Mapping[str, Any]
    answers: Mapping[str, Any]
    raw: Mapping[str, str | None]
    figure: bytes | None = None


def folder_of(path: Path) -> Path:
    """The folder of the records of a parameter file."""
    return path.with_suffix(".record")


def keep(
    path: Path, section: str, key: str, value: float, answers: Mapping[str, Any],
    files: Sequence[str | Path], figure: bytes | None,
) -> Path:  # fmt: skip
    """Write the record of a value of a parameter file; the file. FolderError where it cannot be."""
    folder = folder_of(path)
    target = folder / f"{section}.{key}.json"
    history: list[Any] = []
    if (old := _read(target)) is not None:
        before = old.pop("history", [])
        history = [*before, old] if old.get("value") != value else before
    command = ["calibrate", *map(in_shell, sys.argv[1:])]
    kept = {
        "section": section,
        "key": key,
        "value": value,
        "provenance": provenance(
            command=command, seed=0, packages=PACKAGES, sources=[Path(__file__).parents[1]]
        ),
        "answers": answers,
        "raw": _raw(files),
        "history": history,
    }
    folder.mkdir(parents=True, exist_ok=True)
    write_atomic(target, json.dumps(kept, indent=1))
    if figure is not None:
        write_atomic(target.with_suffix(".png"), figure)
    return target


def records_of(
    path: Path, values: Mapping[tuple[str, str], Measured]
) -> dict[tuple[str, str], Record]:
    """Records of those values of a file that stand there as they were measured."""
    found = {}
    for (section, key), value in values.items():
        target = folder_of(path) / f"{section}.{key}.json"
        kept = _read(target)
        if kept is None or not _same(kept.get("value"), value):
            continue
        picture = target.with_suffix(".png")
        figure = picture.read_bytes() if picture.is_file() else None
        found[section, key] = Record(
            section, key, kept["value"], kept.get("provenance") or {}, kept.get("answers") or {},
            kept.get("raw") or {}, figure,
        )  # fmt: skip
    return found


def _same(kept: Any, value: Measured) -> bool:
    """True if the file's value is the record's, which the file rounds to a hundredth of sigma."""
    if not isinstance(kept, int | float):
        return False
    return math.isclose(kept, value.value, rel_tol=_CLOSE, abs_tol=(value.sigma or 0.0) / 50)


def _read(path: Path) -> dict[str, Any] | None:
    """A record as it stands there; None where there is none that can be read."""
    try:
        read = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None
    return read if isinstance(read, dict) else None


def _raw(files: Sequence[str | Path]) -> dict[str, str | None]:
    """Texts of files by name, by path as given where several have one name."""
    times = Counter(Path(file).name for file in files)
    return {
        Path(file).name if times[Path(file).name] == 1 else str(file): _text(Path(file))
        for file in files
    }


def _text(path: Path) -> str | None:
    try:
        if path.stat().st_size > _MOST_TEXT:
            return None
        return _as_csv(path) if is_spreadsheet(path) else text_of(path)
    except (OSError, ValueError, InputError):
        return None


def _as_csv(path: Path) -> str:
    """All sheets of a spreadsheet as CSV, one below the other under their names."""
    written = io.StringIO()
    for name, lines in sheets(path).items():
        written.write(f"# {name}\n")
        csv.writer(written, lineterminator="\n").writerows(fields for _, fields in lines)
    return written.getvalue()
