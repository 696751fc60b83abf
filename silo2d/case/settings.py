"""The schema of a silo's case file: sections, keys, units, ranges, defaults, meanings, options."""

from collections.abc import Mapping
from itertools import pairwise
from types import MappingProxyType
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field

from granulab.contact.files import casefile, reference
from granulab.contact.files.casefile import (
    Angle,
    Friction,
    Length,
    Number,
    Rate,
    Section,
    Size,
    Speed,
    Stiffness,
    Time,
    YesOrNumber,
    folder_name,
    key,
    unit_of,
)
from granulab.contact.files.units import to_si

__all__ = ["Settings", "check_settings", "read_settings", "to_toml", "unit_of"]

SCHEMA = 1


def _times(value: list[str]) -> list[str]:
    """Ascending times above 0, as texts in seconds."""
    times = [to_si(one, "s", "gate_times") for one in value]
    if not times or times[0] <= 0 or any(b <= a for a, b in pairwise(times)):
        raise ValueError("gate_times: must be above 0 and ascend, such as ['0.3 s', '0.5 s']")
    return [f"{time!r} s" for time in times]


# Kinetic energy over what lifts each particle by its size: at 1 everything is in the air.
Calm = Annotated[Number, Field(gt=0, le=1)]


class Silo(Section):
    """The silo: a preset (A1 ... D4 of the wood-silo paper), or a hopper, or an outline."""

    preset: str | None = key(
        None, "the silo of the wood-silo paper, in place of all other keys here", example="A4",
        left_out="a hopper or an outline",
    )  # fmt: skip
    angle: Angle | None = key(
        None, "hopper angle from the horizontal; 0 deg is a flat floor", example="60 deg",
        spelled_out=True, option="--angle",
    )  # fmt: skip
    outlet: Size | None = key(
        None, "width of the outlet, in the middle of the floor", example="150 mm",
        spelled_out=True, option="--outlet",
    )  # fmt: skip
    width: Size | None = key(None, "width of the silo", example="300 mm", spelled_out=True)
    height: Size | None = key(
        None, "height of the silo, hopper included", example="500 mm", spelled_out=True
    )
    outline: list[list[float]] | None = key(
        None, "inside of any silo, counter-clockwise, in place of angle, width and height. Its "
        "lowest edge holds the outlet, its highest is the open top, and both are horizontal; "
        "without outlet and outlet_centre the whole lowest edge opens",
        example=[[-75, 0], [75, 0], [150, 130], [150, 500], [-150, 500], [-150, 130]],
    )  # fmt: skip
    outline_unit: str = key("mm", "unit of the outline, inserts and outlets")
    outlet_centre: Length | None = key(
        None, "x of the outlet's middle, in an outline", example="0 mm",
        left_out="the middle of its edge",
    )  # fmt: skip
    inserts: list[list[list[float]]] | None = key(
        None, "bodies that are held in their place: corners of each, counter-clockwise, inside the "
        "silo and apart from its walls, in outline_unit",
        example=[[[-40, 180], [40, 180], [0, 250]]], left_out="none",
    )  # fmt: skip
    outlets: list[list[list[float]]] | None = key(
        None, "further outlets, in the floor or in the side: both ends of each, on one wall, in "
        "outline_unit; they open with the first", example=[[[-150, 200], [-150, 260]]],
        left_out="none",
    )  # fmt: skip


class Particles(Section):
    """Shapes, and the materials of particles and walls."""

    shapes: str = key(
        "wood19", "shape set: a shipped one, or a TOML file next to this one",
        option="--shapes", metavar="FILE",
    )  # fmt: skip
    scale: Annotated[Number, Field(ge=0.01, le=100)] = key(
        1.0, "factor on the sizes of all shapes, their rounded corners too", option="--scale"
    )
    spheroradius: Size | None = key(
        None, "radius of the rounded corners of all shapes but discs, within their outlines",
        example="1 mm", left_out="of the shape file", option="--spheroradius",
    )  # fmt: skip
    materials: str = key(
        "wood", "materials table: a shipped one, or a TOML file next to this one",
        option="--materials", metavar="FILE",
    )  # fmt: skip
    material: str | None = key(
        None, "material of the particles, in that table", example="wood",
        left_out="wood; of a table without it, that of its only pair of a material with itself",
    )  # fmt: skip
    wall: str | None = key(
        None, "material of the walls, in that table", example="methacrylate",
        left_out="methacrylate; of a table without it, that which its particles have a pair with, "
        "or theirs",
    )  # fmt: skip

    @property
    def names(self) -> tuple[str, str]:
        """Materials of particles and walls; wood in methacrylate where they are left out."""
        return self.material or "wood", self.wall or "methacrylate"


_TABLE = "materials table"


class Law(Section):
    """The contact law; what is given here goes before the materials table."""

    damping: Literal["published", "restitution"] = key(
        "published", 'source of gamma_n: the materials table, or with "restitution" from '
        "its restitution, by one contact of two mean particles", option="--damping",
    )  # fmt: skip
    contact_end: Literal["overlap", "force"] = key(
        "overlap", 'end of a contact: it may pull until the overlap is zero, with "force" '
        "never", option="--contact-end",
    )  # fmt: skip
    mu_particle: Friction | None = key(
        None, "friction between particles", example=0.38, left_out=_TABLE, option="--mu-particle"
    )
    mu_wall: Friction | None = key(
        None, "friction at the walls", example=0.44, left_out=_TABLE, option="--mu-wall"
    )
    kn: Stiffness | None = key(
        None, "normal stiffness of all contacts", example="1e4 N/mm", left_out=_TABLE, option="--kn"
    )
    kt: Stiffness | None = key(
        None, "tangential stiffness of all contacts", example="650 N/mm", left_out=_TABLE,
        option="--kt",
    )  # fmt: skip
    gamma_n: Rate | None = key(
        None, "normal damping; the wall's scales with it unless gamma_n_wall is given",
        example="6085 1/s", left_out=_TABLE, option="--gamma-n",
    )  # fmt: skip
    gamma_n_wall: Rate | None = key(
        None, "normal damping at the walls", example="4303 1/s", left_out=_TABLE,
        option="--gamma-n-wall",
    )  # fmt: skip
    gamma_t: Rate | None = key(
        None, "tangential damping of all contacts", example="3 1/s", left_out=_TABLE,
        option="--gamma-t",
    )  # fmt: skip
    cohesion: Stiffness | None = key(
        None, "pull that a contact takes before it parts, per length of contact, which is that of "
        "the prisms: moisture",
        example="1 N/m", left_out="none", option="--cohesion",
    )  # fmt: skip
    kn_curve: str | None = key(
        None, "CSV file next to this one of a measured force over overlap, in place of kn",
        example="curve.csv", left_out="none",
    )  # fmt: skip
    mu_plates: Annotated[Friction, Field(gt=0)] | None = key(
        None, "friction of front and back plate on the faces of the prisms, from the opening on",
        example=0.44, left_out="none", option="--mu-plates",
    )  # fmt: skip
    plates_ratio: Annotated[Number, Field(gt=0, le=10)] | None = key(
        None, "lateral pressure ratio: pressure on the plates over the mean pressure in the plane",
        example=0.4, option="--plates-ratio",
    )  # fmt: skip
    keep_ratios: bool = key(
        False,
        "ratios held where kn changes: kt goes with kn, gamma_n with its root",
        option="--keep-ratios",
    )


_DRAWN = 'true: by the measured standard deviation; a number or "10 %": by this one; false: alike'


class Disorder(Section):
    """Contact parameters drawn pair by pair, by the run's seed (docs/validation/disorder.md)."""

    per: Literal["none", "particle", "pair"] = key(
        "none", "parameters drawn for each particle, for each pair, or not at all",
        option="--disorder",
    )  # fmt: skip
    friction: YesOrNumber = key(True, f"friction drawn. {_DRAWN}")
    stiffness: YesOrNumber = key(True, "stiffness drawn, likewise; kt/kn is held")
    restitution: YesOrNumber = key(True, "restitution drawn, likewise")


class Fill(Section):
    """Filling of the silo."""

    level: Size = key(
        0.475, "height of the filling above the outlet, by centroids", example="475 mm",
        option="--fill-level",
    )  # fmt: skip
    pour_with: Literal["dem", "pymunk"] = key(
        "dem", "engine that fills the silo: the contact law, or impulses", option="--pour-with"
    )
    friction: YesOrNumber = key(
        False, "friction while pouring; true: that of the discharge; or a number"
    )
    layer: Size | None = key(
        None, "height of the layers that are poured and settled one by one", example="95 mm",
        left_out="all at once",
    )  # fmt: skip
    settled: Calm = key(
        1e-4, "normalised kinetic energy below which the filling counts as settled: kinetic "
        "energy over what lifts each particle by its size",
    )  # fmt: skip


class Run(Section):
    """Seed, engine, time step, and the end of the run."""

    seed: Annotated[int, Field(ge=0, le=2**63 - 1, strict=True)] = key(
        1, "seed of the filling: shapes, positions and angles", option="--seed", metavar="1"
    )
    engine: Literal["dem", "pymunk"] = key(
        "dem", "engine of the discharge: the contact law, or impulses", option="--engine"
    )
    time_step: Time | None = key(
        None, "time step of dem", example="5 us",
        left_out="5 us, or less where contacts are stiffer", option="--time-step",
    )  # fmt: skip
    door_speed: Annotated[Speed, Field(ge=1e-6, le=1000)] | None = key(
        None, "speed at which the door is drawn to the right", example="0.5 m/s",
        left_out="it is gone at once", option="--door-speed",
    )  # fmt: skip
    max_time: Time = key(
        6.0, "simulated time at which a run stops at the latest", example="6 s",
        option="--max-time",
    )  # fmt: skip
    at_rest: Calm = key(
        1e-4, "normalised kinetic energy, as of settled, below which the silo counts as at rest"
    )
    rest_time: Time = key(
        0.15, "time without a particle coming out after which the silo at rest is judged",
        example="0.15 s",
    )  # fmt: skip
    opening_count: Annotated[int, Field(ge=0, strict=True)] = key(
        5, 'clogged with fewer particles out is "clogged at the opening"'
    )


class Flow(Section):
    """Gate, feeder, refilling and vibration after the opening (docs/silo/beds.md)."""

    gate_times: Annotated[list[str], AfterValidator(_times)] | None = key(
        None, "times at which the gate closes, opens, closes ... again", example=["0.3 s", "0.5 s"],
        left_out="it stays open",
    )  # fmt: skip
    feed_rate: Annotated[Rate, Field(gt=0)] | None = key(
        None, "particles that a feeder takes from the closed outlet in a second", example="200 1/s",
        left_out="the outlet opens", option="--feed-rate",
    )  # fmt: skip
    refill: Annotated[int, Field(ge=0, le=100_000, strict=True)] = key(
        0, "particles kept in store, that are put on top as others leave", option="--refill",
        metavar="300",
    )  # fmt: skip
    vibration_amplitude: Annotated[Size, Field(gt=0)] | None = key(
        None, "amplitude of the vibration of all walls", example="0.5 mm", left_out="they stand",
        option="--vibration-amplitude",
    )  # fmt: skip
    vibration_frequency: Annotated[Rate, Field(gt=0)] | None = key(
        None, "its frequency", example="30 Hz", option="--vibration-frequency"
    )
    vibration_direction: Literal["vertical", "horizontal"] = key("vertical", "its direction")

    @property
    def gate(self) -> list[float]:
        """Times [s] at which the gate closes, opens, closes ...; none where it stays open."""
        return [to_si(time, "s", "gate_times") for time in self.gate_times or []]


class Pymunk(Section):
    """The impulse engine, where it is the engine (docs/verification/pymunk.md)."""

    iterations: Annotated[int, Field(ge=1, le=10_000)] = key(
        30, "iterations over all contacts, a step of pymunk", option="--iterations"
    )
    time_step: Time = key(
        2.5e-4, "time step of pymunk", example="0.25 ms", option="--pymunk-time-step"
    )
    restitution: Literal["measured", "none"] = key(
        "measured", "restitution of the pairs: that of the materials table, or none"
    )


class Output(Section):
    """Data that is kept."""

    frame_interval: Time | None = key(
        None, "time between frames", example="10 ms",
        left_out="10 ms for every 20,000 particles, begun ones counted",
    )  # fmt: skip
    contact_interval: Time | None = key(
        None, "time between frames with contacts, in whole frames; the first and the last have "
        "them always", example="50 ms", left_out="50 ms for every 20,000 particles",
    )  # fmt: skip
    wall_interval: Time | None = key(
        None, "time between samples of the forces at the walls, which come with the frames",
        example="1 ms", left_out="no samples but those in the contacts; `silo2d loads` takes 1 ms",
        option="--wall-interval",
    )  # fmt: skip
    checkpoint_interval: Time = key(0.1, "simulated time between checkpoints", example="100 ms")
    layer_height: Annotated[Size, Field(ge=1e-6)] = key(  # layers are counted: not of dust
        0.045, "height of the painted layers in the pictures", example="45 mm"
    )


class Settings(Section):
    """A whole case file, but for its schema number."""

    name: Annotated[str, AfterValidator(folder_name)] = "silo"
    silo: Silo
    particles: Particles = Particles()
    law: Law = Law()
    disorder: Disorder = Disorder()
    fill: Fill = Fill()
    run: Run = Run()
    flow: Flow = Flow()
    pymunk: Pymunk = Pymunk()
    output: Output = Output()


def commented_case(name: str = "example", values: Mapping[str, Any] = MappingProxyType({})) -> str:
    """A case file with a comment on every key; as it stands it is the preset A4.

    values: by "section.key", what is written instead.
    """
    return reference.commented_case(
        Settings,
        "A silo case. Every key but schema and those of [silo] may be left out; what stands here "
        "are the defaults. Quantities are texts with a unit; pure numbers have none.",
        name,
        SCHEMA,
        values,
    )


_FILE = casefile.CaseFile(Settings, SCHEMA, "[silo] preset = 'A4'")
read_settings, check_settings, to_toml = _FILE.read, _FILE.check, _FILE.to_toml
