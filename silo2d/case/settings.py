"""What a case file may hold: sections, keys, units, ranges, defaults."""

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field, ValidationInfo

from granulab.contact.files import casefile
from granulab.contact.files.casefile import (
    Angle,
    Length,
    Number,
    Rate,
    Section,
    Size,
    Speed,
    Stiffness,
    Time,
    folder_name,
    unit_of,
)
from granulab.contact.files.units import to_si

__all__ = ["Settings", "check_settings", "known_keys", "read_settings", "to_toml", "unit_of"]

SCHEMA = 1


def _yes_or_number(value: object, info: ValidationInfo) -> object:
    return value if isinstance(value, bool) else to_si(value, "1", info.field_name or "value")


# Yes, no, or a number that stands for yes.
YesOrNumber = Annotated[bool | float, BeforeValidator(_yes_or_number), Field(ge=0)]


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

    name: Annotated[str, AfterValidator(folder_name)] = "silo"
    silo: Silo
    particles: Particles = Particles()
    law: Law = Law()
    disorder: Disorder = Disorder()
    fill: Fill = Fill()
    run: Run = Run()
    pymunk: Pymunk = Pymunk()
    output: Output = Output()


def known_keys() -> dict[str, list[str]]:
    """The keys of each section of a case file."""
    return casefile.known_keys(Settings)


def read_settings(path: Path) -> dict[str, Any]:
    """The tables of a case file as they are written; InputError if it is none."""
    return casefile.read_document(path, SCHEMA)


def check_settings(document: dict[str, Any], where: str) -> Settings:
    """The settings of a document; InputError with one line for the first thing that is wrong."""
    return casefile.check_document(Settings, document, where, "[silo] preset = 'A4'")


def to_toml(settings: Settings) -> str:
    """The settings as a case file, all in SI."""
    return casefile.to_toml(settings, SCHEMA)
