"""What a damper's case file may hold: sections, keys, units, ranges, defaults."""

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, FiniteFloat

from granulab.contact.files import casefile
from granulab.contact.files.casefile import (
    Density,
    Frequency,
    Number,
    Positive,
    Pressure,
    Section,
    Size,
    Time,
    folder_name,
)

SCHEMA = 1
MOST_PARTICLES = 10_000_000

Vector = Annotated[list[FiniteFloat], Field(min_length=3, max_length=3)]
Restitution = Annotated[Positive, Field(le=1)]


class Enclosure(Section):
    """[enclosure]: the closed void that holds the particles; inner sizes."""

    shape: Literal["cylinder", "box"] = "cylinder"
    diameter: Size | None = None  # of a cylinder; 40 mm
    width: Size | None = None  # of a box, along x
    depth: Size | None = None  # of a box, along y; its width if left out
    height: Size = 0.04  # along the axis
    material: str = "acrylic"


class Particles(Section):
    """[particles]: what moves inside, and what it is made of."""

    shape: str = "sphere:5mm"
    equal_volume_radius: Size | None = None  # where the shape names no size
    sub_spheres: Annotated[int, Field(ge=1, strict=True)] | None = None  # of one particle
    tolerance: Positive | None = None  # of its surface, over the equal-volume radius [-]
    mesh_unit: str | None = None  # of a mesh that keeps its size
    count: Annotated[int, Field(ge=1, le=MOST_PARTICLES, strict=True)] | None = None
    material: str = "acrylic"
    materials: str = "acrylic"


class Motion(Section):
    """[motion]: how the enclosure moves, and where gravity points."""

    orientation: Literal["vertical", "horizontal", "none"] = "vertical"
    frequency: Frequency = 40.0  # [Hz]
    gamma: Positive = 20.0  # largest acceleration over g [-]
    direction: Vector | None = None  # of the motion; the axis if left out
    gravity: Vector | None = None  # its direction; the orientation's if left out
    ramp: Number = 0.0  # cycles over which the amplitude grows


class Law(Section):
    """[law]: the contact law; what is given here goes before the materials file."""

    friction: Number | None = None
    friction_wall: Number | None = None
    restitution: Restitution | None = None
    restitution_wall: Restitution | None = None
    contact_treatment: Literal["sum", "deepest", "scaled"] = "sum"  # of several of one pair
    tangential: Literal["displacement", "force"] = "displacement"
    contact_end: Literal["overlap", "force"] = "overlap"
    wall_curvature: bool = False
    yielding: bool = False
    youngs_modulus: Pressure | None = None  # of particles and walls
    density: Density | None = None  # of the particles


class Fill(Section):
    """[fill]: how the particles come to rest before the motion begins."""

    settle_time: Time = 0.2


class Run(Section):
    """[run]: seed, length and time step."""

    seed: Annotated[int, Field(ge=0, le=2**63 - 1, strict=True)] = 1
    cycles: Annotated[int, Field(ge=1, le=1_000_000, strict=True)] = 8
    discard: Annotated[int, Field(ge=0, strict=True)] = 3
    steady: bool = False
    max_cycles: Annotated[int, Field(ge=1, le=1_000_000, strict=True)] = 60  # of a steady run
    time_step: Time | None = None


class Output(Section):
    """[output]: what is kept."""

    samples: Annotated[int, Field(ge=8, le=10_000, strict=True)] = 100  # a cycle
    frames: Annotated[int, Field(ge=0, le=10_000, strict=True)] = 20  # a cycle; 0: none
    keep: Literal["all", "summary"] = "all"


class Settings(Section):
    """A whole case file, but for its schema number."""

    name: Annotated[str, AfterValidator(folder_name)] = "damper"
    enclosure: Enclosure = Enclosure()
    particles: Particles = Particles()
    motion: Motion = Motion()
    law: Law = Law()
    fill: Fill = Fill()
    run: Run = Run()
    output: Output = Output()


def known_keys() -> dict[str, list[str]]:
    """The keys of each section of a case file."""
    return casefile.known_keys(Settings)


def read_settings(path: Path) -> dict[str, Any]:
    """The tables of a case file as they are written; InputError if it is none."""
    return casefile.read_document(path, SCHEMA)


def check_settings(document: dict[str, Any], where: str) -> Settings:
    """The settings of a document; InputError with one line for the first thing that is wrong."""
    return casefile.check_document(Settings, document, where)


def to_toml(settings: Settings) -> str:
    """The settings as a case file, all in SI."""
    return casefile.to_toml(settings, SCHEMA)
