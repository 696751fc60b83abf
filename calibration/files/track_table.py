"""Track tables as other tools write them: which column is what, several tracks in one file.

Understood: one line per frame with x, y (or X1 Y1 X2 Y2 ...), or one line per frame and object with
a column that names the object (particle, track id). Comma, semicolon, tab or spaces; decimal comma;
short lines; more than one line of words at the top; words after the numbers end the table.
Some trackers leave out empty fields, so that a number does not stand below its name: such lines are
read as a frame and pairs, and the pairs are linked to tracks by where they are.
"""

import csv
import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from calibration.tracking.track import Array, Track, link
from granulab.contact.files.units import to_si
from granulab.errors import InputError

_MOST_BYTES = 512 * 2**20
_EMPTY = ("", "nan", "na", "null", "none", "*")
_KINDS = {
    "frame": r"frame|frames|frame[ _]?(number|no|nr|index)|slice|image",
    "time": r"t|time|times|timestamp|position_t|sec|seconds",
    "x": r"(position_|pos_?|centroid_)?x(?P<x>_?\d+|_[a-z]\w*)?",
    "y": r"(position_|pos_?|centroid_)?y(?P<y>_?\d+|_[a-z]\w*)?",
    "object": r"particle|track|track[ _]?id|object|trajectory|id",
    "flag": r"flag\d*",
}
_UNIT = re.compile(r"(?P<name>.*?)\s*(?:[\[(](?P<unit>[^\])]*)[\])]|_(?P<tail>px|mm|cm|m|s|ms))?")


@dataclass(frozen=True)
class _Column:
    kind: str  # of _KINDS, or "" for one that is not needed
    which: str  # of several x or y
    unit: str


def read_tracks(path: str | Path) -> list[Track]:
    """All tracks of a table, as they stand in it.

    Raises InputError, one line with file, line and what would do, for what holds no track.
    """
    path = Path(path)
    head, rows, remarks = _split(path, _text(path))
    columns = _columns(path, head, max(len(row) for row in rows), rows)
    if _packed(columns, rows):
        tracks, more = _from_pairs(path, rows)
    else:
        wide = np.array([_padded(row, len(columns)) for row in rows])
        tracks, more = _from_columns(path, columns, wide)
    remarks += more
    return [replace(track, remarks=track.remarks + tuple(remarks)) for track in tracks]


def _text(path: Path) -> list[str]:
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise InputError(f"{path}: larger than {_MOST_BYTES >> 20} MiB")
        return path.read_text(encoding="utf-8-sig").splitlines()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file; tables of frame or time, x, y") from None


def _split(path: Path, lines: list[str]) -> tuple[list[str], list[list[float]], list[str]]:
    """The names of the columns ([] where there are none), the numbers, and remarks."""
    separator = _separator(lines)
    head: list[str] = []
    rows: list[list[float]] = []
    remarks: list[str] = []
    for number, line in enumerate(lines, start=1):
        fields = _fields(line, separator)
        if line.lstrip().startswith("#") or not any(_filled(field) for field in fields):
            continue
        values = [_number(field, separator) for field in fields]
        if all(value is not None for value in values):
            rows.append([value for value in values if value is not None])
        elif rows and values[0] is None:
            after = sum(bool(line.strip()) for line in lines[number - 1 :])
            remarks.append(f"{after} lines from line {number} ({fields[0]!r} ...) on left out")
            break  # words after the numbers: what another tool adds at the end
        elif rows:
            bad = fields[values.index(None)]
            raise InputError(f"{path}: line {number}: {bad!r} is no number")
        elif sum(map(_known, fields)) >= max(1, sum(map(_known, head))):
            head = fields
    if not rows:
        raise InputError(f"{path}: no line of numbers; a track table has frame or time, x and y")
    return head, rows, remarks


def _separator(lines: list[str]) -> str:
    """Semicolon, tab or comma where most lines of digits have it; else spaces ("")."""
    digits = [line for line in lines if re.search(r"\d", line)]
    for separator in (";", "\t"):
        if sum(separator in line.strip() for line in digits) > len(digits) / 2:
            return separator
    # a comma with a space, or two in a row of digits, separates; one inside each word is decimal
    by_space = [line.split() for line in digits if len(line.split()) > 1]
    decimal = sum(all(re.fullmatch(r"[-+\d.eE]+(,\d+)?", w) for w in row) for row in by_space)
    if sum("," in line for line in digits) > len(digits) / 2 and decimal <= len(digits) / 2:
        return ","
    return ""


def _fields(line: str, separator: str) -> list[str]:
    if not separator:
        return [word for word in line.split() if word != "*"]
    parsed = next(csv.reader([line], delimiter=separator), [])
    return [field.strip() for field in parsed]


def _filled(field: str) -> bool:
    return field.lower() not in _EMPTY


def _number(field: str, separator: str) -> float | None:
    """A field as a number, NaN where it is empty, None where it is a word."""
    if not _filled(field):
        return np.nan
    plain = field.replace(",", ".", 1)
    try:
        value = None if "_" in field else float(plain)
    except ValueError:
        return None
    return value if value is not None and np.isfinite(value) else None


def _known(field: str) -> bool:
    return _column(field).kind != ""


def _column(field: str) -> _Column:
    match = _UNIT.fullmatch(field.strip())
    assert match is not None
    name, unit = match["name"].strip().lower(), match["unit"] or match["tail"] or ""
    for kind, pattern in _KINDS.items():
        found = re.fullmatch(pattern, name)
        if found:
            which = (found.groupdict().get(kind) or "").strip("_") if kind in "xy" else ""
            return _Column(kind, which, "" if unit in ("px", "pixel", "pixels") else unit)
    return _Column("", "", "")


def _columns(path: Path, head: list[str], width: int, rows: list[list[float]]) -> list[_Column]:
    """Meaning of each column, by its name, or by its position where there is no head."""
    if not head:
        if width not in (2, 3):
            raise InputError(
                f"{path}: {width} columns without names; write a first line such as 'frame,x,y'"
            )
        first = [row[0] for row in rows if np.isfinite(row[0])]
        kind = "frame" if all(value.is_integer() for value in first) else "time"
        return [_Column(k, "", "") for k in ([kind, "x", "y"] if width == 3 else [kind, "y"])]
    columns = [_column(field) for field in head]
    if not any(column.kind == "y" for column in columns):
        names = ", ".join(repr(field) for field in head if field)
        raise InputError(f"{path}: no column 'y'; there are {names}")
    return columns


def _packed(columns: list[_Column], rows: list[list[float]]) -> bool:
    """True if numbers stand where the head has flags, or lines are shorter than a single track."""
    flags = [k for k, column in enumerate(columns) if column.kind == "flag"]
    pairs = sum(column.kind == "y" for column in columns)
    kinds = [column.kind for column in columns if column.kind != "flag"]
    if not flags or kinds != ["frame", *["x", "y"] * pairs]:
        return False
    if any(k < len(row) and np.isfinite(row[k]) for row in rows for k in flags):
        return True
    return pairs > 1 and all(len(row) < len(columns) for row in rows)


def _padded(row: list[float], width: int) -> list[float]:
    return (row + [np.nan] * width)[:width]


def _from_pairs(path: Path, rows: list[list[float]]) -> tuple[list[Track], list[str]]:
    frames, points, left_out = [], [], 0
    for row in rows:
        numbers = [value for value in row if np.isfinite(value)]
        if len(numbers) < 3 or len(numbers) % 2 == 0:
            left_out += 1
            continue
        frames.append(numbers[0])
        points.append(np.reshape(numbers[1:], (-1, 2)))
    if not frames:
        raise InputError(f"{path}: no line with a frame, x and y")
    remarks = ["numbers do not stand below their names: pairs linked to tracks by their positions"]
    if left_out:
        remarks.append(f"{left_out} lines left out: not a frame and pairs of x, y")
    return link(np.array(frames), points), remarks


def _from_columns(path: Path, columns: list[_Column], wide: Array) -> tuple[list[Track], list[str]]:
    frame, time, remarks = _clock(path, columns, wide)
    of_kind = {kind: [k for k, c in enumerate(columns) if c.kind == kind] for kind in _KINDS}
    tracks = []
    for k in of_kind["y"]:
        with_it = [i for i in of_kind["x"] if columns[i].which == columns[k].which]
        factor, scale = _length(path, columns[k])
        x = factor * wide[:, with_it[0]] if with_it else np.zeros(len(wide))
        track = Track(frame, x, factor * wide[:, k], time, None, scale, columns[k].which)
        tracks += _by_object(track, wide[:, of_kind["object"][0]]) if of_kind["object"] else [track]
    return tracks, remarks


def _by_object(track: Track, object: Array) -> list[Track]:
    names = np.unique(object[np.isfinite(object)])
    if not len(names):
        return [track]
    each = [(track.chosen(np.flatnonzero(object == name)), f"{name:g}") for name in names]
    return [replace(one, name=name) for one, name in each]


def _length(path: Path, column: _Column) -> tuple[float, float | None]:
    """Factor to metres and 1, for a column with a unit; 1 and no scale for pixels."""
    if not column.unit:
        return 1.0, None
    return to_si(f"1 {column.unit}", "m", f"{path}: column 'y'"), 1.0


def _clock(
    path: Path, columns: list[_Column], wide: Array
) -> tuple[Array, Array | None, list[str]]:
    """Frame numbers, and times in s where the table has them."""
    frames = [k for k, c in enumerate(columns) if c.kind == "frame"]
    times = [k for k, c in enumerate(columns) if c.kind == "time"]
    if not times:
        if frames:
            return wide[:, frames[0]], None, []
        return np.arange(float(len(wide))), None, ["no column of frames: one frame a line assumed"]
    unit = columns[times[0]].unit
    time = wide[:, times[0]] * (to_si(f"1 {unit}", "s", f"{path}: column 'time'") if unit else 1)
    steps = np.diff(np.unique(time[np.isfinite(time)]))
    if not len(steps):
        raise InputError(f"{path}: the column of times does not go on")
    if not unit and np.all(steps == np.round(steps)):
        return time, None, ["times are whole numbers without a unit: read as frame numbers"]
    remarks = [] if unit else ["times without a unit: read as seconds"]
    if frames:
        return wide[:, frames[0]], time, remarks
    # Rounded stamps would put two lines into one frame or leave one out; stamps that leave gaps
    # of a whole frame and more are gaps.
    step = float(np.median(steps))
    return (time - np.nanmin(time)) / step, time, remarks
