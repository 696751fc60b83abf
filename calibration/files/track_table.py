"""Track tables as other tools write them: which column is what, several tracks in one file.

Understood: one line per frame with x, y (or X1 Y1 X2 Y2 ...), or one line per frame and object with
a column that names the object (particle, track id). Dialect, head and units are those of all tables
(calibration/files/tables.py); short lines, and words after the numbers, which end the table.
Some trackers leave out empty fields, so that a number does not stand below its name: such lines are
read as a frame and pairs, and the pairs are linked to tracks by where they are.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from calibration.files import dialect
from calibration.files.dialect import Row, is_number
from calibration.files.layout import Layout, layout
from calibration.files.tables import rows_of
from calibration.tracking.track import Array, Track, link
from granulab.contact.files.units import nearest, to_si
from granulab.errors import InputError

_KINDS = {
    "frame": r"frame|frames|frame[ _]?(number|no|nr|index)|slice|image",
    "time": r"t|time|times|timestamp|position_t|sec|seconds",
    "x": r"(position_|pos_?|centroid_)?x(?P<x>_?\d+|_[a-z]\w*)?",
    "y": r"(position_|pos_?|centroid_)?y(?P<y>_?\d+|_[a-z]\w*)?",
    "object": r"particle|track|track[ _]?id|object|trajectory|id",
    "flag": r"flag\d*",
}
_HEIGHT = r"height|altitude|h|z|h\u00f6he|hoehe"  # is y in a table without a y
_TAIL = re.compile(r"(?P<name>.*?)(?:_(?P<tail>px|mm|cm|m|s|ms))?")
_PIXELS = ("px", "pixel", "pixels", "-")
_IN_PIXELS = "x and y without a unit of length: read as pixels"
_LARGEST = 1e12  # of a frame number, a time stamp or a position, whatever its unit
_SHORTEST = 1e-9  # frames or s from line to line: the fastest cameras take 1e-7 s


@dataclass(frozen=True)
class _Column:
    kind: str  # of _KINDS, or "" for one that is not needed
    which: str  # of several x or y
    unit: str


def read_tracks(path: str | Path, units: Mapping[str, str] | None = None) -> list[Track]:
    """All tracks of a table, as they stand in it.

    units   of columns whose head has none, or a wrong one: {"time": "ms", "x": "mm", "y": "mm"}

    Raises InputError, one line with file, line and what would do, for what holds no track.
    """
    path = Path(path)
    rows, of_sheets = rows_of(path)
    lines, remarks = _until_words(path, rows)
    found = layout(lines, str(path))
    numbers = [[_number(path, line, f) for f in fields] for line, fields in found.rows]
    columns = _with_units(path, _columns(path, found, numbers), units or {})
    if _packed(columns, numbers):
        tracks, more = _from_pairs(path, numbers)
    else:
        wide = np.array([_padded(row, len(columns)) for row in numbers])
        tracks, more = _from_columns(path, columns, wide)
    remarks = [*of_sheets, *remarks, *found.remarks, *more]
    return [replace(track, remarks=track.remarks + tuple(remarks)) for track in tracks]


def refuse_units(film: str | Path, units: Mapping[str, str] | None) -> None:
    """InputError for units of columns where the source is a film."""
    if units:
        raise InputError(f"{film}: --unit is of a column of a table, and this is a film")


def _until_words(path: Path, rows: list[Row]) -> tuple[list[Row], list[str]]:
    """The lines down to words below the numbers, which other tools add; marks of doubt taken out.

    Raises InputError where no line holds numbers.
    """
    rows = [(line, [f for f in fields if f != "*"]) for line, fields in rows]
    begin = next((k for k, row in enumerate(rows) if _all_numbers(row[1])), None)
    if begin is None:
        raise InputError(f"{path}: no line of numbers; a track table has frame or time, x and y")
    # "Tracks 1 to 2": a remark with numbers, and no head, which has none
    above = [(line, fields) for line, fields in rows[:begin] if not any(map(is_number, fields))]
    rows = above + rows[begin:]
    for k in range(len(above), len(rows)):
        line, fields = rows[k]
        first = fields[0] if fields else ""
        if dialect.number(first) is None and not first[:1].isdigit():
            words = f"{len(rows) - k} lines from line {line} ({first!r} ...) on left out"
            return rows[:k], [words]
    return rows, []


def _all_numbers(fields: list[str]) -> bool:
    return any(map(is_number, fields)) and all(dialect.number(f) is not None for f in fields)


def _number(path: Path, line: int, field: str) -> float:
    """A field as a number, NaN where it is empty; InputError for a word or what is no position."""
    value = dialect.number(field)
    if value is None:
        raise InputError(f"{path}: line {line}: {field!r} is no number")
    if abs(value) > _LARGEST:
        raise InputError(f"{path}: line {line}: {field!r}: no frame, time or position is as large")
    return value


def _apart(path: Path, clock: Array, kind: str) -> Array:
    """The clock; InputError where its usual step is no camera's: frames count, to a part of one."""
    steps = np.diff(np.unique(clock[np.isfinite(clock)]))
    if len(steps) and np.median(steps) < _SHORTEST:
        raise InputError(
            f"{path}: column {kind!r} goes on by {np.median(steps):.3g} a line: no camera's frames "
            "or s; check its unit"
        )
    return clock


def _column(head: str, unit: str) -> _Column:
    """Meaning of a head and its unit; the unit may be part of the name, as in x_mm."""
    match = _TAIL.fullmatch(head.strip())
    assert match is not None
    name = match["name"].strip().lower()
    unit = unit or match["tail"] or ""
    for kind, pattern in _KINDS.items():
        found = re.fullmatch(pattern, name)
        if found:
            which = (found.groupdict().get(kind) or "").strip("_") if kind in "xy" else ""
            return _Column(kind, which, "" if unit in _PIXELS else unit)
    return _Column("", "", "")


def _columns(path: Path, found: Layout, rows: list[list[float]]) -> list[_Column]:
    """Meaning of each column, by its name, or by its position where there is no head."""
    width = max(len(row) for row in rows)
    if not found.headed:
        if width not in (2, 3):
            raise InputError(
                f"{path}: {width} columns without names; write a first line such as 'frame,x,y'"
            )
        first = [row[0] for row in rows if np.isfinite(row[0])]
        kind = "frame" if all(value.is_integer() for value in first) else "time"
        return [_Column(k, "", "") for k in ([kind, "x", "y"] if width == 3 else [kind, "y"])]
    columns = [_column(name, found.units[name]) for name in found.names]
    if not any(column.kind == "y" for column in columns):
        columns = [
            _column(
                re.sub(rf"^({_HEIGHT})(?![^\W_])", "y", name.strip().lower()), found.units[name]
            )
            for name in found.names
        ]
    if not any(column.kind == "y" for column in columns):
        names = ", ".join(map(repr, found.names))
        raise InputError(f"{path}: no column 'y' and none 'height'; there are {names}")
    return columns


def _with_units(path: Path, columns: list[_Column], units: Mapping[str, str]) -> list[_Column]:
    """The columns with units that were given for time, x or y."""
    kinds = {column.kind for column in columns} & {"time", "x", "y"}
    for name in units:
        if name not in kinds:
            raise InputError(f"{path}: --unit {name}: no such column; {nearest(name, kinds)}")
    given = {kind: "" if unit in _PIXELS else unit for kind, unit in units.items()}
    return [replace(column, unit=given.get(column.kind, column.unit)) for column in columns]


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
    tracks, pixels = [], False
    for k in of_kind["y"]:
        with_it = [i for i in of_kind["x"] if columns[i].which == columns[k].which]
        factor, scale = _length(path, "y", columns[k])
        x = np.zeros(len(wide))
        if with_it:
            own, x_scale = _length(path, "x", columns[with_it[0]])
            x = own * wide[:, with_it[0]]
            if x_scale != scale:
                raise InputError(f"{path}: x and y: one has a unit of length and the other has not")
        pixels |= scale is None
        track = Track(frame, x, factor * wide[:, k], time, None, scale, columns[k].which)
        tracks += _by_object(track, wide[:, of_kind["object"][0]]) if of_kind["object"] else [track]
    return tracks, [*remarks, *([_IN_PIXELS] if pixels else [])]


def _by_object(track: Track, object: Array) -> list[Track]:
    names = np.unique(object[np.isfinite(object)])
    if not len(names):
        return [track]
    each = [(track.chosen(np.flatnonzero(object == name)), f"{name:g}") for name in names]
    return [replace(one, name=name) for one, name in each]


def _length(path: Path, name: str, column: _Column) -> tuple[float, float | None]:
    """Factor to metres and 1, for a column with a unit; 1 and no scale for pixels."""
    if not column.unit:
        return 1.0, None
    return to_si(f"1 {column.unit}", "m", f"{path}: column {name!r}"), 1.0


def _clock(
    path: Path, columns: list[_Column], wide: Array
) -> tuple[Array, Array | None, list[str]]:
    """Frame numbers, and times in s where the table has them."""
    frames = [k for k, c in enumerate(columns) if c.kind == "frame"]
    times = [k for k, c in enumerate(columns) if c.kind == "time"]
    if not times:
        if frames:
            return _apart(path, wide[:, frames[0]], "frame"), None, []
        return np.arange(float(len(wide))), None, ["no column of frames: one frame a line assumed"]
    unit = columns[times[0]].unit
    time = wide[:, times[0]] * (to_si(f"1 {unit}", "s", f"{path}: column 'time'") if unit else 1)
    steps = np.diff(np.unique(time[np.isfinite(time)]))
    if not len(steps):
        raise InputError(f"{path}: the column of times does not go on")
    _apart(path, time, "time")
    if not unit and np.all(steps == np.round(steps)):
        return time, None, ["times are whole numbers without a unit: read as frame numbers"]
    remarks = [] if unit else ["times without a unit: read as seconds"]
    if frames:
        return wide[:, frames[0]], time, remarks
    # Rounded stamps would put two lines into one frame or leave one out; stamps that leave gaps
    # of a whole frame and more are gaps.
    step = float(np.median(steps))
    return (time - np.nanmin(time)) / step, time, remarks
