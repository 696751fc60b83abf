"""Case files of any simulator: keys with units, one line for a mistake, and back to TOML.

The settings of a simulator are one schema: a Section for each table of a case file, a `key` for
each key. Options of the commands, the commented case of `init` and the key reference in the docs
are made from it (granulab.contact.files.reference, granulab.campaign.cli.caseoptions).
"""

import copy
import json
import re
import reprlib
import typing
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Generic, TypeVar

from pydantic import (
    AfterValidator,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    ValidationInfo,
    model_validator,
)

from granulab.contact.files.datafile import read_toml
from granulab.contact.files.schema import Table
from granulab.contact.files.units import is_plain_number, nearest, to_si
from granulab.errors import InputError


@dataclass(frozen=True)
class Unit:
    """Marks a field that is a quantity, a number in this SI unit; "1" is that of pure numbers."""

    name: str


# Lengths [m] that a case may have: from one atom's width to the earth's.
SMALLEST, LARGEST = 1e-10, 1e7


def read(unit: str) -> BeforeValidator:
    """Reader of a quantity in this SI unit, as a mark of a field."""

    def to_number(value: object, info: ValidationInfo) -> float:
        return to_si(value, unit, info.field_name or "value")

    return BeforeValidator(to_number)


def _read_frequency(value: object, info: ValidationInfo) -> float:
    """A plain number is in Hz; a text may also carry a unit."""
    name = info.field_name or "value"
    return to_si(value, "1" if is_plain_number(value) else "Hz", name)


def _yes_or_number(value: object, info: ValidationInfo) -> object:
    return value if isinstance(value, bool) else to_si(value, "1", info.field_name or "value")


def of_a_size(length: float, name: str) -> float:
    """A length [m] that something may have; ValueError for one below atoms or beyond the earth."""
    if not SMALLEST <= abs(length) <= LARGEST and length != 0.0:
        raise ValueError(
            f"{name} = {length:g} m: {SMALLEST:g} to {LARGEST:g} m are taken; check the unit"
        )
    return length


def _sized(value: float, info: ValidationInfo) -> float:
    return of_a_size(value, info.field_name or "value")


Length = Annotated[float, read("m"), Unit("m"), AfterValidator(_sized)]
Size = Annotated[float, read("m"), Unit("m"), Field(gt=0), AfterValidator(_sized)]
Time = Annotated[float, read("s"), Unit("s"), Field(gt=0)]
Angle = Annotated[float, read("rad"), Unit("rad")]
Stiffness = Annotated[float, read("N/m"), Unit("N/m"), Field(gt=0)]
Rate = Annotated[float, read("1/s"), Unit("1/s"), Field(ge=0)]
Number = Annotated[float, read("1"), Unit("1"), Field(ge=0)]
Friction = Annotated[float, read("1"), Unit("1"), Field(ge=0, le=1000)]
Positive = Annotated[float, read("1"), Unit("1"), Field(gt=0)]
Frequency = Annotated[float, BeforeValidator(_read_frequency), Unit("1"), Field(gt=0)]
Speed = Annotated[float, read("m/s"), Unit("m/s"), Field(gt=0)]
Velocity = Annotated[float, read("m/s"), Unit("m/s")]
Acceleration = Annotated[float, read("m/s2"), Unit("m/s2"), Field(gt=0)]
Mass = Annotated[float, read("kg"), Unit("kg"), Field(gt=0)]
Force = Annotated[float, read("N"), Unit("N"), Field(gt=0)]
Density = Annotated[float, read("kg/m3"), Unit("kg/m3"), Field(gt=0)]
Pressure = Annotated[float, read("Pa"), Unit("Pa"), Field(gt=0)]
# Yes, no, or a number that stands for yes.
YesOrNumber = Annotated[
    bool | float, BeforeValidator(_yes_or_number), Unit("1"), Field(ge=0, le=1000)
]


class Section(Table):
    """A table of the case file; takes the keys of its class and no others."""

    model_config = ConfigDict(frozen=True, strict=False)

    @model_validator(mode="before")
    @classmethod
    def _no_truth_for_a_number(cls, table: object) -> object:
        """Refuse true and false where a key takes a number: Python would count them as 1 and 0."""
        for name, value in table.items() if isinstance(table, dict) else ():
            field = cls.model_fields.get(name)
            within = value if isinstance(value, list) else [value]
            if field and any(isinstance(one, bool) for one in within) and not takes_truth(field):
                shown = str(value).lower()
                raise ValueError(f"{name} = {shown}: true and false are no numbers; give a number")
        return table


Model = TypeVar("Model", bound=Section)


def key(
    default: Any,
    meaning: str,
    *,
    example: Any = None,
    left_out: str | None = None,
    spelled_out: bool = False,
    unit: str | None = None,
    option: str | None = None,
    metavar: str | None = None,
) -> Any:
    """A key of a Section: its default, its meaning, and how people write it.

    meaning      comment in the case that `init` writes, text of the reference and of --help
    example      as it is written in a case file; where there is a default, the same value
    left_out     what holds where the key is left out, if there is no default
    spelled_out  whether `init` writes the example, though the key has no default
    unit         of a plain number, such as "Hz"; quantities have it from their type
    option       flag of the commands that changes the key; metavar: its example in --help
    """
    known = {"left_out": left_out, "spelled_out": spelled_out, "plain_unit": unit,
             "option": option, "metavar": metavar}  # fmt: skip
    return Field(
        default,
        description=meaning,
        examples=None if example is None else [example],
        json_schema_extra={name: value for name, value in known.items() if value},
    )


def takes_truth(field: Any) -> bool:
    """True where a field may be true or false."""
    return bool in (field.annotation, *typing.get_args(field.annotation))


def folder_name(name: object) -> str:
    """The name of a case, after which its run folder is called; ValueError if it cannot be."""
    usable = isinstance(name, str) and name.isprintable() and name not in ("", ".", "..")
    if not isinstance(name, str) or not usable or set("/\\") & set(name):
        raise ValueError(
            f"name = {reprlib.repr(name)}: the run folder is called after it; give letters, "
            "digits, '-', '_'"
        )
    if len(name.encode()) > _LONGEST_NAME:
        raise ValueError(
            f"name = {reprlib.repr(name)}: {len(name.encode())} bytes; the run folder is called "
            f"after it: at most {_LONGEST_NAME}"
        )
    if set(_NOT_IN_WINDOWS) & set(name) or name[-1] in ". " or _DEVICE.fullmatch(name):
        raise ValueError(
            f"name = {reprlib.repr(name)}: the run folder is called after it, and Windows has no "
            f"such folder; leave out {' '.join(_NOT_IN_WINDOWS)}, '.' and ' ' at the end, and "
            "names of devices (CON, NUL, COM1)"
        )
    return name


_NOT_IN_WINDOWS = '<>:"|?*'
_DEVICE = re.compile(r"(con|prn|aux|nul|(com|lpt)[0-9¹²³])( *\..*)?", re.IGNORECASE)
_LONGEST_NAME = 200  # [bytes] of the 255 of a file name: seed and digest follow


def sections(settings: type[Section]) -> dict[str, type[Section]]:
    """The sections of a case file, by their names."""
    fields = {name: field.annotation for name, field in settings.model_fields.items()}
    return {
        name: section
        for name, section in fields.items()
        if isinstance(section, type) and issubclass(section, Section)
    }


def known_keys(settings: type[Section]) -> dict[str, list[str]]:
    """The keys of each section of a case file."""
    return {name: list(section.model_fields) for name, section in sections(settings).items()}


@dataclass(frozen=True)
class CaseFile(Generic[Model]):
    """The case files of a simulator: their schema and its number.

    least: what a case must have at least, for the line about a table that is missing.
    """

    settings: type[Model]
    schema: int
    least: str = ""

    def read(self, path: Path) -> dict[str, Any]:
        """The tables of a case file as they are written; InputError where it cannot be read."""
        document = read_toml(path, "cases", self.schema, self._lacks)
        document.setdefault("name", path.stem)
        return document

    def _lacks(self, document: dict[str, Any]) -> str:
        required = [name for name, f in self.settings.model_fields.items() if f.is_required()]
        absent = [f"[{name}]" for name in required if name not in document]
        return f"{', '.join(absent)} is missing too; write at least {self.least}" if absent else ""

    def check(self, document: dict[str, Any], where: str) -> Model:
        """The settings of a document; InputError with one line for the first error in it."""
        try:
            return self.settings.model_validate(document)
        except ValidationError as error:
            line = _one_line(error, sections(self.settings), self.least)
            raise InputError(f"{where}: {line}") from None

    def to_toml(self, settings: Model) -> str:
        """The settings as a case file, all in SI."""
        lines = [
            f"schema = {self.schema}",
            f"name = {toml_value(settings.model_dump(include={'name'})['name'])}",
        ]
        for section in type(settings).model_fields:
            table = getattr(settings, section)
            if isinstance(table, Section):
                written = _written(table)
                lines += ["", f"[{section}]", *written] if written else []
            elif isinstance(table, list):  # of tables
                for one in table:
                    lines += ["", f"[[{section}]]", *_written(one)]
        return "\n".join(lines) + "\n"


def _written(table: Section) -> list[str]:
    """The keys of a table that have a value, a line each."""
    lines = []
    for key, field in type(table).model_fields.items():
        value = getattr(table, key)
        if value is not None:
            lines.append(f"{key} = {toml_value(value, unit_of(field))}")
    own = table.model_extra or {}  # keys of what is registered from outside, as written
    return lines + [f"{key} = {toml_value(value)}" for key, value in own.items()]


def changed(
    document: dict[str, Any], changes: dict[str, Any] | None, model: type[Section]
) -> dict[str, Any]:
    """The document with some keys ("section.key") set; a section that is None is left out."""
    document = copy.deepcopy(document)
    for path, value in (changes or {}).items():
        section, dot, key = path.partition(".")
        if not dot and value is None:
            document.pop(section, None)
            continue
        if not dot:
            known = [f"{s}.{k}" for s, keys in known_keys(model).items() for k in keys]
            close = [name for name in known if name.endswith(f".{path}")]
            tables = f"known sections: {', '.join(known_keys(model))}"
            raise InputError(
                f"change {path!r}: write section.key; {nearest(path, close) if close else tables}"
            )
        table = document.setdefault(section, {})
        if isinstance(table, dict):
            table[key] = value
    return document


def flat(tables: dict[str, Any]) -> dict[str, Any]:
    """The values of a case file's tables by "section.key", and by "key" of what is in none."""
    found: dict[str, Any] = {}
    for section, table in tables.items():
        within = isinstance(table, dict)
        found |= {f"{section}.{k}": v for k, v in table.items()} if within else {section: table}
    return found


# Words on what pydantic finds of another type, by the first word of its name for that.
_MUST = {
    "int": "a whole number, without a point, exponent or unit",
    "float": "a number, without quotation marks or a unit",
    "list": "a list, in brackets",
    "string": "a text, in quotation marks",
    "bool": "true or false",
}


def _must_be(problem: Any, tables: dict[str, type[Section]], path: list[str]) -> str:
    """Words on what a value must be, with the example of its key."""
    first, _, rest = problem["type"].partition("_")
    if first not in _MUST or rest not in ("type", "parsing", "from_float"):
        return str(problem["msg"]).lower().removeprefix("input should be ")
    section = tables.get(path[0]) if len(path) > 1 else None
    field = section.model_fields.get(path[1]) if section else None
    examples = field.examples if field else None
    such = f", such as {path[1]} = {toml_value(examples[0])}" if examples else ""
    return _MUST[first] + such


def _one_line(error: ValidationError, tables: dict[str, type[Section]], least: str) -> str:
    problems = error.errors()
    problem = problems[0]
    if problem["type"] == "string_type" and len(problems) > 1:  # of a text or a list, which it is
        problem = problems[1] | {
            "loc": (*problem["loc"][:-1], *problems[1]["loc"][len(problem["loc"]) :])
        }
    path = [str(part) for part in problem["loc"]]
    section = f"[{path[0]}] " if path and path[0] in tables else ""
    if problem["type"] == "value_error":
        return f"{section}{problem['ctx']['error']}"
    if problem["type"] == "missing":
        return f"[{path[0]}] is missing; write at least {least}"
    key = f"{section}{'.'.join(path[1:] if section else path)}"
    if problem["type"] in ("too_short", "too_long"):
        bound = problem["ctx"].get("min_length", problem["ctx"].get("max_length"))
        which = "least" if problem["type"] == "too_short" else "most"
        held = problem["ctx"]["actual_length"]
        given = reprlib.repr(problem["input"])
        return f"{key} = {given}: holds {held}; must hold at {which} {bound}"
    what = _must_be(problem, tables, path)
    return f"{key} = {reprlib.repr(problem['input'])}: must be {what}"


def marks_of(field: Any) -> list[Any]:
    """The units, validators and bounds that the type of a field is annotated with."""
    choices = typing.get_args(field.annotation)  # of "X | None"
    marks = [*field.metadata, *(m for c in choices for m in getattr(c, "__metadata__", ()))]
    return [one for mark in marks for one in (mark, *getattr(mark, "metadata", ()))]


def unit_of(field: Any) -> str:
    """The SI unit of a field, or "1"."""
    return next((mark.name for mark in marks_of(field) if isinstance(mark, Unit)), "1")


def toml_value(value: Any, unit: str = "1") -> str:
    """A value as TOML; a number with the unit it is in."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and unit != "1":
        return f'"{value!r} {unit}"'
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{toml_value(k)} = {toml_value(v)}' for k, v in value.items())} }}"
    if isinstance(value, str):
        # JSON's escapes are TOML's, except that TOML wants DEL escaped too.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Section):
        fields = type(value).model_fields.items()
        pairs = [(key, getattr(value, key), unit_of(field)) for key, field in fields]
        written = [f"{key} = {toml_value(one, u)}" for key, one, u in pairs if one is not None]
        return f"{{ {', '.join(written)} }}"
    if isinstance(value, list):
        return f"[{', '.join(map(toml_value, value))}]"
    return repr(value)  # a number is written as in Python
