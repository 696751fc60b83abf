"""What a case file may hold: sections, keys, units, ranges, defaults."""

import json
import reprlib
import typing
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    ValidationInfo,
)

from contact.datafile import read_toml
from contact.quantity import InputError, to_si
from contact.schema import Table

SCHEMA = 1


@dataclass(frozen=True)
class Unit:
    """Marks a field that is written with a unit; its number is in this SI unit."""

    name: str


def _read(unit: str) -> BeforeValidator:
    def read(value: object, info: ValidationInfo) -> float:
        return to_si(value, unit, info.field_name or "value")

    return BeforeValidator(read)


Length = Annotated[float, _read("m"), Unit("m")]
Size = Annotated[float, _read("m"), Unit("m"), Field(gt=0)]
Time = Annotated[float, _read("s"), Unit("s"), Field(gt=0)]
Angle = Annotated[float, _read("rad"), Unit("rad")]
Stiffness = Annotated[float, _read("N/m"), Unit("N/m"), Field(gt=0)]
Rate = Annotated[float, _read("1/s"), Unit("1/s"), Field(ge=0)]
Number = Annotated[float, _read("1"), Field(ge=0)]
Speed = Annotated[float, _read("m/s"), Unit("m/s"), Field(gt=0)]


def _yes_or_number(value: object, info: ValidationInfo) -> object:
    return value if isinstance(value, bool) else to_si(value, "1", info.field_name or "value")


# Yes, no, or a number that stands for yes.
YesOrNumber = Annotated[bool | float, BeforeValidator(_yes_or_number), Field(ge=0)]


def _folder_name(name: str) -> str:
    if not name or not name.isprintable() or "/" in name or "\\" in name:
        raise ValueError(
            f"name = {name!r}: the run folder is called after it; give letters, digits, '-', '_'"
        )
    return name


class Section(Table):
    """A table of the case file; takes the keys of its class and no others."""

    model_config = ConfigDict(frozen=True, strict=False)


class Silo(Section):
    """[silo]: a preset A1 ... D4, or a hopper, or a polygon."""

    preset: str | None = None
    angle: Angle | None = None  # hopper from the horizontal
    outlet: Size | None = None
    width: Size | None = None
    height: Size | None = None
    outline: list[list[float]] | None = None  # inside of the silo, counter-clockwise
    outline_unit: str = "mm"
    outlet_centre: Length | None = None


class Particles(Section):
    """[particles]: shapes, and what they and the walls are made of."""

    shapes: str = "wood19"
    materials: str = "wood"
    material: str = "wood"
    wall: str = "methacrylate"


class Law(Section):
    """[law]: the contact law; what is given here goes before the materials file."""

    damping: Literal["published", "restitution"] = "published"
    contact_end: Literal["overlap", "force"] = "overlap"
    mu_particle: Number | None = None
    mu_wall: Number | None = None
    kn: Stiffness | None = None
    kt: Stiffness | None = None
    gamma_n: Rate | None = None
    gamma_n_wall: Rate | None = None
    gamma_t: Rate | None = None
    keep_ratios: bool = False


class Disorder(Section):
    """[disorder]: contact parameters that differ from pair to pair."""

    per: Literal["none", "particle", "pair"] = "none"
    friction: YesOrNumber = True
    stiffness: YesOrNumber = True
    restitution: YesOrNumber = True


class Fill(Section):
    """[fill]: how the silo is filled."""

    level: Size = 0.475
    pour_with: Literal["dem", "pymunk"] = "dem"
    friction: YesOrNumber = False
    layer: Size | None = None
    settled: Annotated[Number, Field(gt=0)] = 1e-4


class Run(Section):
    """[run]: seed, engine, time step, and when the run ends."""

    seed: Annotated[int, Field(ge=0, strict=True)] = 1
    engine: Literal["dem", "pymunk"] = "dem"
    time_step: Time | None = None
    door_speed: Speed | None = None
    max_time: Time = 6.0
    at_rest: Annotated[Number, Field(gt=0)] = 1e-4
    rest_time: Time = 0.15
    opening_count: Annotated[int, Field(ge=0, strict=True)] = 5


class Pymunk(Section):
    """[pymunk]: how the impulse engine is run; see impulses.py."""

    iterations: Annotated[int, Field(ge=1, le=10_000)] = 30
    time_step: Time = 2.5e-4
    restitution: Literal["measured", "none"] = "measured"


class Output(Section):
    """[output]: what is kept."""

    frame_interval: Time = 0.01
    contact_interval: Time = 0.05  # rounded to whole frames
    checkpoint_interval: Time = 0.1
    layer_height: Size = 0.045


class Settings(Section):
    """A whole case file, but for its schema number."""

    name: Annotated[str, AfterValidator(_folder_name)] = "silo"
    silo: Silo
    particles: Particles = Particles()
    law: Law = Law()
    disorder: Disorder = Disorder()
    fill: Fill = Fill()
    run: Run = Run()
    pymunk: Pymunk = Pymunk()
    output: Output = Output()


_TABLES = [name for name in Settings.model_fields if name != "name"]


def known_keys() -> dict[str, list[str]]:
    """The keys of each section of a case file."""
    sections = {key: field.annotation for key, field in Settings.model_fields.items()}
    return {
        key: list(section.model_fields)
        for key, section in sections.items()
        if isinstance(section, type) and issubclass(section, Section)
    }


def read_settings(path: Path) -> dict[str, Any]:
    """The tables of a case file as they are written; InputError if it is none."""
    document = read_toml(path, "cases", SCHEMA)
    document.setdefault("name", path.stem)
    return document


def check_settings(document: dict[str, Any], where: str) -> Settings:
    """The settings of a document; InputError with one line for the first thing that is wrong."""
    try:
        return Settings.model_validate(document)
    except ValidationError as error:
        raise InputError(f"{where}: {_one_line(error)}") from None


def _one_line(error: ValidationError) -> str:
    problem = error.errors()[0]
    place = [str(part) for part in problem["loc"]]
    section = f"[{place[0]}] " if place and place[0] in _TABLES else ""
    if problem["type"] == "value_error":
        return f"{section}{problem['ctx']['error']}"
    if problem["type"] == "missing":
        return f"[{place[0]}] is missing; write at least [silo] preset = 'A4'"
    key = f"{section}{'.'.join(place[1:] if section else place)}"
    what = problem["msg"].lower().removeprefix("input should be ")
    return f"{key} = {reprlib.repr(problem['input'])}: must be {what}"


def to_toml(settings: Settings) -> str:
    """The settings as a case file, all in SI."""
    lines = [f"schema = {SCHEMA}", f"name = {_toml(settings.name)}"]
    for section in type(settings).model_fields:
        table = getattr(settings, section)
        if isinstance(table, Section):
            lines += ["", f"[{section}]"]
            for key, field in type(table).model_fields.items():
                value = getattr(table, key)
                if value is not None:
                    lines.append(f"{key} = {_toml(value, unit_of(field))}")
    return "\n".join(lines) + "\n"


def unit_of(field: Any) -> str:
    """The SI unit of a field, or "1"."""
    choices = typing.get_args(field.annotation)  # of "X | None"
    metadata = [*field.metadata, *(m for c in choices for m in getattr(c, "__metadata__", ()))]
    return next((m.name for m in metadata if isinstance(m, Unit)), "1")


def _toml(value: Any, unit: str = "1") -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and unit != "1":
        return f'"{value!r} {unit}"'
    if isinstance(value, str):
        # JSON's escapes are TOML's, except that TOML wants DEL escaped too.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return repr(value)  # numbers, and lists of numbers, are written as in Python
