"""Values and damages that the campaign draws from: tables, and the few functions that apply them.

`chance` is a random.Random, or hypothesis's in its place, so that a bad input can be made smaller.
"""

import json
import math
import re
import tomllib
from pathlib import Path
from random import Random
from typing import Any

# Numbers that are likely wrong, at the ends of what a float holds, or of another unit.
NUMBERS = [
    0, -0.0, 1, -1, 2, 3, 0.5, 0.1, 10, 1e-3, 1e3, 1e-6, 1e6, 1e-9, 1e9, 1e-12, 1e12, 1e-30, 1e30,
    1e20, 1e-300, 1e300, 5e-324, 1.7e308, -1e-9, -1e9, 2**31, 2**63, -(2**63), 10**400,
    math.nan, math.inf, -math.inf,
]  # fmt: skip
# What stands where a quantity, a number, a choice or a name is wanted.
WRONG: list[Any] = [
    True, False, "", " ", "nan", "inf", "-inf", "NaN m", [], [1], [[1, 2]], {}, {"a": 1}, "a\x00b",
    "x" * 300, "1 m", "1 s", "1 kg", "1e400 m", "1e-400 s", "1,5 mm", "1 parsec", "..", "/", "~",
    "/dev/zero", "/dev/null", "\n", "é", "𝟙 mm", "0x10", "1_000", "a-b", "a.b", "no.toml", ".",
    [0, 0, 0], [1, 0, 0], [1e308] * 3, [math.nan] * 3, "; rm", "--json", "%s", "{0}", "NaN",
]  # fmt: skip
UNITS = [
    "m", "mm", "um", "km", "s", "ms", "us", "N/m", "N/mm", "1/s", "deg", "rad", "%", "Pa", "GPa",
    "kg/m3", "g/cm3", "m/s", "Hz", "kHz", "N", "g", "px", "mm/px", "", "parsec", "degC", "m m",
]  # fmt: skip
# Names of what is shipped: texts that are right somewhere.
NAMES = [
    "wood", "wood_small", "acrylic", "steel", "glass", "methacrylate", "wood19", "pentagons", "A4",
    "thesis", "B2", "sphere:5mm", "prolate:1.5", "oblate:0.7", "toroid:0.2", "prolate:1e9",
    "sphere:1e-9 m", "superquadric:0,0,0,0", "cylinder:0,0", "mesh:no.stl", "prolate:nan", ":",
]  # fmt: skip
CELLS = ["", " ", "nan", "inf", "-1", "0", "1e300", "1e-300", "abc", "1,5", "1.5.2", "=1+1", "\x00",
         "9" * 400, "-", "1 mm", "#", '"', "1e999", "ｘ"]  # fmt: skip
HEADS = ["", "x", "time", "time [ms]", "time [N]", "frame", "load [N]", "y [parsec]", "x [", "z",
         "time,time", "angle_deg", "particle", "#"]  # fmt: skip


def respelled(text: str, chance: Random) -> str:
    """A quantity with another number, another unit, or a little of both."""
    how, number = chance.randrange(4), chance.choice(NUMBERS)
    if how == 0:
        return text
    if how == 1:  # near what it was: often right
        factor = chance.choice([0.5, 0.8, 1.2, 2.0, -1.0])
        return re.sub(r"\d+(\.\d*)?(e-?\d+)?", lambda m: f"{float(m[0]) * factor:g}", text, count=1)
    if how == 2:
        return re.sub(r"-?\d+(\.\d*)?(e-?\d+)?", f"{number!r}", text, count=1)
    return f"{text.partition(' ')[0]} {chance.choice(UNITS)}"


def value(
    written: str, unit: str, choices: tuple[str, ...], chance: Random, wild: float = 1.0
) -> Any:
    """A value for a key: about its example, an extreme one, one of its choices, or a wrong one.

    wild: share of those that are not about its example, over the usual.
    """
    share = chance.random() * wild
    if share < 0.55 and written:
        try:
            plain = tomllib.loads(f"plain = {written}")["plain"]
        except ValueError:
            plain = written
        if isinstance(plain, str):
            return chance.choice(choices) if choices else respelled(plain, chance)
        if isinstance(plain, list | dict):
            return _within(plain, chance)
        if isinstance(plain, int | float) and not isinstance(plain, bool):
            return type(plain)(plain * chance.choice([0, 0.5, 1, 2, 3])) if share < 0.4 else (
                chance.choice(NUMBERS))  # fmt: skip
        return chance.choice([plain, not plain])
    if share < 0.75:
        number = chance.choice(NUMBERS)
        return f"{number!r} {unit}" if unit else number
    return chance.choice(NAMES if share < 0.85 else WRONG)


def _within(plain: Any, chance: Random) -> Any:
    """A list or table, of others too, with one entry changed, or one more or fewer."""
    if isinstance(plain, str):
        return respelled(plain, chance)
    if isinstance(plain, int | float):
        return chance.choice([plain * 1.1, -plain, chance.choice(NUMBERS)])
    found = json.loads(json.dumps(plain))
    names = list(found) if isinstance(found, dict) else range(len(found))
    if found and chance.random() < 0.3:
        found.pop(chance.choice(names))
    elif found:
        k = chance.choice(names)
        found[k] = _within(found[k], chance)
    return found


def toml(table: dict[str, Any]) -> str:
    """A document, its tables inline; as it is wanted, also where no reader would take it."""
    return "".join(f"{_key(name)} = {_toml(one)}\n" for name, one in table.items())


def _key(name: str) -> str:
    return json.dumps(name, ensure_ascii=False)


def _toml(one: Any) -> str:
    if isinstance(one, dict):
        return "{" + ", ".join(f"{_key(k)} = {_toml(v)}" for k, v in one.items()) + "}"
    if isinstance(one, list):
        return "[" + ", ".join(map(_toml, one)) + "]"
    if isinstance(one, float) and not math.isfinite(one):
        return repr(one)
    return json.dumps(one, ensure_ascii=False, default=str)


def _flipped(data: bytes, chance: Random) -> bytes:
    found = bytearray(data)
    for _ in range(chance.choice([1, 1, 3, 30])):
        found[chance.randrange(len(found))] ^= 1 << chance.randrange(8)
    return bytes(found)


def _zeroed(data: bytes, chance: Random) -> bytes:
    first = chance.randrange(len(data))
    return (
        data[:first] + bytes(min(chance.choice([8, 512]), len(data) - first)) + data[first + 512 :]
    )


# Damages to the bytes of a file.
BYTES = {
    "flipped": _flipped,
    "cut": lambda data, chance: data[: chance.randrange(len(data))],
    "beheaded": lambda data, chance: data[chance.randrange(len(data)) :],
    "zeroed": _zeroed,
    "emptied": lambda data, chance: b"",
    "longer": lambda data, chance: data + chance.randbytes(100),
    "twice": lambda data, chance: data + data,
    "shuffled": lambda data, chance: data[len(data) // 2 :] + data[: len(data) // 2],
}


def damage_bytes(path: Path, chance: Random) -> str:
    """Damage a file in place; the name of what was done."""
    name, data = chance.choice(list(BYTES)), path.read_bytes()
    path.write_bytes(BYTES[name](data, chance) if data else b"x")
    return name


def _scaled(rows: list[list[str]], chance: Random) -> None:
    column, factor = chance.randrange(len(rows[0]) or 1), chance.choice(NUMBERS)
    for row in rows[1:]:
        if column < len(row):
            try:
                row[column] = repr(float(row[column]) * float(factor))
            except (ValueError, OverflowError):
                continue


def _cell(rows: list[list[str]], chance: Random) -> None:
    row = chance.choice(rows)
    if row:
        row[chance.randrange(len(row))] = chance.choice(CELLS)


def _head(rows: list[list[str]], chance: Random) -> None:
    if rows[0]:
        rows[0][chance.randrange(len(rows[0]))] = chance.choice(HEADS)


def _unit(rows: list[list[str]], chance: Random) -> None:
    if rows[0]:
        k = chance.randrange(len(rows[0]))
        rows[0][k] = f"{rows[0][k].partition(' [')[0]} [{chance.choice(UNITS)}]"


def _drop_column(rows: list[list[str]], chance: Random) -> None:
    column = chance.randrange(len(rows[0]) or 1)
    for row in rows:
        del row[column : column + 1]


# Damages to the cells of a table; the first row is its head.
TABLE = {
    "cell": _cell,
    "head": _head,
    "unit in the head": _unit,
    "unit line": lambda rows, c: rows.insert(1, [c.choice(UNITS) for _ in rows[0]]),
    "scaled": _scaled,
    "row gone": lambda rows, c: rows.pop(c.randrange(len(rows))) if len(rows) > 2 else None,
    "row twice": lambda rows, c: rows.insert(c.randrange(len(rows)), list(c.choice(rows))),
    "rows in disorder": lambda rows, c: c.shuffle(rows),
    "backwards": lambda rows, c: rows.__setitem__(slice(1, None), rows[:0:-1]),
    "most rows gone": lambda rows, c: rows.__delitem__(slice(c.choice([1, 2, 5, 20, 60]), None)),
    "one row ragged": lambda rows, c: c.choice(rows).append(c.choice(CELLS)),
    "column gone": _drop_column,
    "no head": lambda rows, c: rows.pop(0) if len(rows) > 1 else None,
    "all alike": lambda rows, c: rows.__setitem__(
        slice(1, None), [list(rows[-1]) for _ in rows[1:]]
    ),
    "nothing": lambda rows, c: None,
}
ENCODINGS = ["utf-8"] * 9 + ["utf-8-sig", "utf-16", "latin-1"]


def damaged_table(text: str, chance: Random) -> bytes:
    """A table of commas with one to three damages, in some encoding, sometimes of other marks."""
    rows = [line.split(",") for line in text.strip().split("\n")]
    for _ in range(chance.choice([1, 1, 1, 2, 3])):
        TABLE[chance.choice(list(TABLE))](rows, chance)
    mark = chance.choice([","] * 6 + [";", "\t", " ", "|"])
    end = chance.choice(["\n"] * 6 + ["\r\n", "\r"])
    found = end.join(mark.join(row) for row in rows) + end
    return found.encode(chance.choice(ENCODINGS), errors="replace")
