"""The schema of a damper's case file: sections, keys, units, ranges, defaults, meanings."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Annotated, Any, ClassVar, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    ConfigDict,
    Field,
    FiniteFloat,
    WithJsonSchema,
    model_validator,
)

from granulab.contact.files import casefile, reference
from granulab.contact.files.casefile import (
    Acceleration,
    Angle,
    Density,
    Force,
    Frequency,
    Friction,
    Length,
    Mass,
    Number,
    Positive,
    Pressure,
    Section,
    Size,
    Time,
    Unit,
    Velocity,
    YesOrNumber,
    folder_name,
    key,
    read,
)
from granulab.contact.files.units import nearest

SCHEMA = 1
MOST_PARTICLES = 10_000_000
MOST_SAMPLES = 10_000  # a cycle


def _registered(name: str) -> dict[str, dict[str, str]]:
    """The enclosures (shape) or motions (kind) that there are; the own keys of each, with units."""
    if name == "shape":
        from damper3d.engine.enclosures import ENCLOSURES

        return {shape: enclosure.units() for shape, enclosure in ENCLOSURES.items()}
    from damper3d.engine.motions import MOTIONS

    return {kind: motion.units for kind, motion in MOTIONS.items()}


def _one_of(name: str, default: str) -> BeforeValidator:
    """Takes the name of a registered enclosure (shape) or motion (kind)."""

    def check(value: object) -> object:
        if value == default:  # without a look at the engine, which takes time to import
            return value
        known = _registered(name)
        if not isinstance(value, str) or value not in known:
            names = " or ".join(repr(each) for each in known)
            raise ValueError(f"{name} = {value!r}: must be {names}")
        return value

    return BeforeValidator(check)


class Extensible(Section):
    """A table that also takes the keys of the registered enclosure or motion that it names."""

    model_config = ConfigDict(extra="allow")
    _names: ClassVar[tuple[str, str]]  # the key that names it, and the key's default

    @model_validator(mode="before")
    @classmethod
    def _only_known_keys(cls, table: object) -> object:
        if not isinstance(table, dict):
            raise ValueError("expected a table of keys")
        unknown = [key for key in table if key not in cls.model_fields]
        if unknown:
            name, default = cls._names
            own = _registered(name).get(str(table.get(name, default)), {})
            for key in unknown:
                if key not in own:
                    known = dict.fromkeys([*cls.model_fields, *own])
                    raise ValueError(f"unknown key {key!r}; {nearest(key, known)}")
        return table


Vector = Annotated[list[FiniteFloat], Field(min_length=3, max_length=3)]
Rows = Annotated[list[list[FiniteFloat]], Field(min_length=4)]
Cell = Annotated[int, Field(ge=1, le=1000, strict=True)]
Restitution = Annotated[Positive, Field(le=1)]


_SHAPES = ["cylinder", "box", "frustum", "sphere", "hexagonal_prism", "polyhedron", "cavity"]


class Enclosure(Extensible):
    """The closed void that holds the particles; all sizes are inner ones."""

    _names = "shape", "cylinder"

    shape: Annotated[
        str,
        _one_of("shape", "cylinder"),
        WithJsonSchema({"enum": _SHAPES, "type": "string"}),
    ] = key("cylinder", "shape: a cylinder with a diameter, or a box with width and depth")
    diameter: Size | None = key(
        None, "diameter of a cylinder or a sphere, or of the bottom of a frustum", example="40 mm",
        left_out="40 mm of a cylinder", spelled_out=True, option="--diameter",
    )  # fmt: skip
    top_diameter: Size | None = key(None, "diameter of a frustum at the top", example="30 mm")
    across_flats: Size | None = key(
        None, "distance of opposite sides of a hexagonal prism", example="40 mm"
    )
    width: Size | None = key(None, "width of a box, along x", example="40 mm")
    depth: Size | None = key(None, "depth of a box, along y", example="40 mm", left_out="its width")
    height: Size = key(
        0.04, "height along the axis; the thesis has 40, 45, 50 and 55 mm", example="40 mm",
        option="--height",
    )  # fmt: skip
    vertices: Rows | None = key(
        None, "corners of a convex polyhedron",
        example=[[0, 0, 0], [40, 0, 0], [0, 40, 0], [0, 0, 40]],
    )  # fmt: skip
    faces: Rows | None = key(
        None, "faces of a convex polyhedron in place of its corners: a direction that leads "
        "outwards, and the distance from the origin along it",
        example=[[1, 0, 0, 20], [-1, 0, 0, 20], [0, 1, 0, 20], [0, -1, 0, 20], [0, 0, 1, 40],
                 [0, 0, -1, 0]],
    )  # fmt: skip
    file: str | None = key(
        None, "STL or OBJ file of a cavity, whose triangles face outwards, next to this one",
        example="cavity.stl",
    )  # fmt: skip
    unit: str | None = key(None, "unit of vertices, faces or the file", example="mm")
    cells: Annotated[list[Cell], Field(min_length=2, max_length=2)] | None = key(
        None, "number along x and y of equal cylinders or boxes in one carrier", example=[2, 2],
        left_out="one",
    )  # fmt: skip
    cell_wall: Size | None = key(
        None, "thickness of the walls between cells, where they are thinnest", example="1 mm"
    )
    material: str = key("acrylic", "material of the walls, in the materials table")
    walls: dict[str, str] | None = key(
        None, "walls that are of another material, by their names", example={"bottom": "steel"},
        left_out="all walls are of that material",
    )  # fmt: skip


Distribution = Literal["normal", "lognormal", "sieve"]
Sieve = list[Annotated[list[Any], Field(min_length=2, max_length=2)]]


class Kind(Section):
    """A kind of particles of a mixture, [[particles.kind]]; keys as in [particles]."""

    shape: str
    equal_volume_radius: Size | None = None
    sub_spheres: Annotated[int, Field(ge=1, strict=True)] | None = None
    tolerance: Positive | None = None
    mesh_unit: str | None = None
    material: str | None = None  # that of [particles] where it is left out
    count: Annotated[int, Field(ge=1, le=MOST_PARTICLES, strict=True)] | None = None
    mass_fraction: Annotated[Positive, Field(le=1)] | None = None
    size_distribution: Distribution | None = None
    size_deviation: Size | None = None
    sieve: Sieve | None = None


class Particles(Section):
    """The particles, and their material."""

    shape: str = key(
        "sphere:5mm", 'spheres by diameter (the thesis has 3, 4, 5 and 6 mm), or a shape such as '
        '"prolate:1.5", "oblate:0.7", "oblate_grid:0.7" (aspect ratio), "toroid:0.2" (hole ratio), '
        '"superquadric:1,1,0.5,0.5" (b/a, c/a, e1, e2), "cylinder:1.5,0.2" (length, rounding), '
        '"mesh:rock.stl"; see damper3d shape --help', option="--particles",
        metavar="sphere:5mm|prolate:1.5|oblate:0.7|toroid:0.2|mesh:FILE",
    )  # fmt: skip
    equal_volume_radius: Size | None = key(
        None, "size of a shape that is named without one", example="2.5 mm",
        left_out="3.8 mm; of toroids 3.5 mm, of spheres 2.5 mm", option="--equal-volume-radius",
        metavar='"3.8 mm"',
    )  # fmt: skip
    sub_spheres: Annotated[int, Field(ge=1, strict=True)] | None = key(
        None, "spheres that stand for one particle", example=51,
        left_out="the thesis's number, or by the tolerance", option="--sub-spheres", metavar="N",
    )  # fmt: skip
    tolerance: Positive | None = key(
        None, "largest error of their surface, over the equal-volume radius, in place of a number",
        example=0.02, option="--tolerance",
    )  # fmt: skip
    mesh_unit: str | None = key(
        None, "unit of a mesh that keeps its size", example="mm",
        left_out="it is scaled to the radius above", option="--mesh-unit",
    )  # fmt: skip
    count: Annotated[int, Field(ge=1, le=MOST_PARTICLES, strict=True)] | None = key(
        None, "number of particles", example=358,
        left_out="by a fill ratio of 7/15, as of 358 of 5 mm in 40 x 40 mm; of toroids that of 110 "
        "of 3.5 mm, of other shapes that of 90 of 3.8 mm", option="--count", metavar="N",
    )  # fmt: skip
    fill_ratio: Annotated[Positive, Field(le=1)] | None = key(
        None, "volume of the particles over that of the enclosure (eq. 6.1), in place of count",
        example=0.41, option="--fill-ratio", metavar="0.41",
    )  # fmt: skip
    size_distribution: Distribution | None = key(
        None, "distribution of the diameters, by number, about that of the shape (of the sphere "
        "of its volume); sieve: of spheres, by a table; see docs/damper/beds.md", example="normal",
        left_out="all are alike",
    )  # fmt: skip
    size_deviation: Size | None = key(
        None, "standard deviation of the diameters, of a normal or lognormal distribution",
        example="0.2 mm",
    )  # fmt: skip
    sieve: Sieve | None = key(
        None, "sieves, and the share of the mass that passes each, from 0 to 1",
        example=[["2 mm", 0.0], ["3 mm", 0.4], ["4 mm", 1.0]],
    )  # fmt: skip
    kind: list[Kind] | None = key(
        None, "kinds of particles of a mixture, each with shape, its size, material, and count or "
        "mass_fraction; also written as [[particles.kind]] tables; see docs/damper/beds.md",
        example=[{"shape": "sphere:5mm", "mass_fraction": 0.7},
                 {"shape": "sphere:3mm", "mass_fraction": 0.3}],
        left_out="one, of the shape above",
    )  # fmt: skip
    material: str = key("acrylic", "material of the particles, in the materials table")
    materials: str = key(
        "acrylic", "materials table: a shipped one, or a TOML file next to this one"
    )

    @property
    def kinds(self) -> Sequence["Particles | Kind"]:
        """Kinds of particles; these themselves where there is one."""
        return self.kind if self.kind else [self]


class Motion(Extensible):
    """Motion of the enclosure, and the direction of gravity."""

    _names = "kind", "sines"

    kind: Annotated[
        str, _one_of("kind", "sines"), WithJsonSchema({"enum": ["sines"], "type": "string"})
    ] = key("sines", "kind of motion: a sine, or one that is registered from outside")
    orientation: Literal["vertical", "horizontal", "none"] = key(
        "vertical", 'direction of the axis; with "horizontal" gravity is -x, with "none" there '
        "is no gravity", option="--orientation",
    )  # fmt: skip
    frequency: Frequency = key(
        40.0, 'frequency in Hz, or with a unit: "2.4 kHz"', unit="Hz", option="--frequency",
        metavar="40",
    )  # fmt: skip
    gamma: Positive = key(
        20.0, "largest acceleration of the enclosure, over 9.81 m/s2", unit="g", option="--gamma",
        metavar="20",
    )  # fmt: skip
    direction: Vector | None = key(
        None, "direction of the motion", example=[0, 0, 1], left_out="along the axis"
    )
    gravity: Vector | None = key(
        None, "direction of gravity", example=[0, 0, -1], left_out="by the orientation"
    )
    ramp: Number = key(
        0.0, "cycles over which the amplitude grows; 0: it is there at once, and with it the "
        "velocity gamma g/omega", option="--ramp", metavar="0",
    )  # fmt: skip


_NO_HOST = "no host: the motion is prescribed"


# A name, or a number in place of one.
Place = Annotated[
    str, BeforeValidator(lambda name: str(name) if type(name) is int else name), Field(min_length=1)
]


class Host(Section):
    """A structure that the enclosure rides on, in place of a prescribed motion.

    [motion] then says direction, gravity and the frequency of what moves it, by itself that of the
    bare structure; displacements count from static equilibrium.
    """

    mass: Mass | None = key(
        None, "structure with the empty enclosure; of a mode, its modal mass at the damper",
        example="1 kg", left_out=_NO_HOST, option="--host-mass", metavar='"1 kg"',
    )  # fmt: skip
    frequency: Frequency | None = key(
        None, "natural frequency of the bare structure", example="10 Hz", left_out=_NO_HOST,
        option="--host-frequency", metavar="10",
    )  # fmt: skip
    damping_ratio: Annotated[Number, Field(lt=1)] | None = key(
        None, "damping ratio of the bare structure", example=0.01, left_out=_NO_HOST,
        option="--host-damping", metavar="0.01",
    )  # fmt: skip
    inertia: Annotated[float, read("kg m2"), Unit("kg m2"), Field(gt=0)] | None = key(
        None, "in place of mass, moment of inertia of a structure that twists about the axis of "
        "the enclosure, a body of revolution; amplitudes are then arcs at its largest radius",
        example="1e-4 kg m2", left_out="it moves along",
    )  # fmt: skip
    torque: Annotated[float, read("N m"), Unit("N m"), Field(gt=0)] | None = key(
        None, "amplitude of a harmonic torque on one that twists", example="0.01 N m",
        left_out="none",
    )  # fmt: skip
    start_angle: Angle | None = key(
        None, "angle where a free decay of one that twists starts", example="5 deg", left_out="0"
    )
    modes: str | None = key(
        None, "several modes, in place of mass, frequency and damping ratio: a CSV table next to "
        "this file with columns frequency [Hz], damping_ratio, shape [kg^-0.5] at the damper; "
        "force_shape [kg^-0.5] where the force acts, if not there; participation [kg^0.5] for "
        "base motion", example="modes.csv", left_out="one mode",
    )  # fmt: skip
    at: Place | None = key(
        None, "name of the damper's place: its shapes are the column shape_<at> of that table",
        example="tip", left_out="the column shape",
    )  # fmt: skip
    shown: Annotated[int, Field(ge=1, strict=True)] | None = key(
        None, "of several dampers, number of the one whose results stand in the run folder itself",
        example=2, left_out="the first",
    )  # fmt: skip
    force: Force | None = key(
        None, "amplitude of a harmonic force on it", example="0.79 N", left_out="none",
        option="--force", metavar='"0.79 N"',
    )  # fmt: skip
    base_displacement: Size | None = key(
        None, "amplitude of a harmonic motion of its base", example="0.2 mm", left_out="none",
        option="--base-displacement", metavar='"0.2 mm"',
    )  # fmt: skip
    base_acceleration: Acceleration | None = key(
        None, "the same as an acceleration", example="0.1 g", left_out="none",
        option="--base-acceleration", metavar='"0.1 g"',
    )  # fmt: skip
    start_displacement: Length | None = key(
        None, "where a free decay starts", example="10 mm", left_out="0",
        option="--start-displacement", metavar='"10 mm"',
    )  # fmt: skip
    start_velocity: Velocity | None = key(
        None, "velocity with which a free decay starts", example="0.5 m/s", left_out="0",
        option="--start-velocity", metavar='"0.5 m/s"',
    )  # fmt: skip


_NO_EXCITATION = "a sine, by [motion] or [host]"
Breakpoints = Annotated[list[Annotated[list[FiniteFloat], Field(min_length=2, max_length=2)]],
                        Field(min_length=2)]  # fmt: skip


class Excitation(Section):
    """Excitation of the enclosure, or the host, in place of one sine of [motion] or [host].

    Its kind says which keys go with it. Amplitudes are accelerations ("2 g"), velocities or
    displacements, of a force forces, as their unit says.
    """

    kind: Literal["sines", "rotation", "sweep", "random", "shock", "signal"] | None = key(
        None, "kind of excitation; see docs/damper/excitation.md", example="random",
        left_out=_NO_EXCITATION,
    )  # fmt: skip
    on: Literal["enclosure", "force", "base"] | None = key(
        None, "where it acts: on the enclosure itself, or on a host as a force or by its base",
        example="base", left_out="the enclosure; of a host a force",
    )  # fmt: skip
    frequencies: Annotated[list[Frequency], Field(min_length=1)] | None = key(
        None, "sines, rotation: frequency of each, in Hz", example=[20, 33]
    )
    amplitudes: list[str] | None = key(
        None, "sines: amplitude of each; rotation: an angle for each", example=["2 g", "1 g"]
    )
    phases: list[str] | None = key(
        None, "sines, rotation: phase of each", example=["0 deg", "90 deg"], left_out="0"
    )
    across: Vector | None = key(
        None, "sines: direction of a second motion at the same frequencies, of the enclosure",
        example=[1, 0, 0], left_out="none",
    )  # fmt: skip
    across_amplitudes: list[str] | None = key(
        None, "sines: amplitude of each there", example=["2 g", "1 g"]
    )
    across_phases: list[str] | None = key(
        None, "sines: phase of each there", example=["90 deg", "0 deg"], left_out="0"
    )
    from_frequency: Frequency | None = key(
        None, "sweep: frequency at its beginning", example="10 Hz"
    )
    to_frequency: Frequency | None = key(None, "sweep: frequency at its end", example="40 Hz")
    amplitude: str | None = key(None, "sweep or shock: amplitude", example="2 g")
    spacing: Literal["logarithmic", "linear"] | None = key(
        None, "sweep: how the frequency goes with time", example="linear", left_out="logarithmic"
    )
    octaves_per_minute: Positive | None = key(None, "sweep: rate of a logarithmic one", example=30)
    length: Time | None = key(
        None, "sweep: its length, in place of a rate; shock: length of the pulse; random: of "
        "what is counted", example="20 s",
    )  # fmt: skip
    steps: Annotated[int, Field(ge=2, le=1000, strict=True)] | None = key(
        None, "sweep: frequencies that are held one after the other, of a stepped one", example=12,
        left_out="a continuous sweep",
    )  # fmt: skip
    and_back: bool | None = key(
        None, "sweep: there and back, which shows hysteresis", example=True, left_out="one way"
    )
    psd: str | Breakpoints | None = key(
        None, "random: breakpoints [Hz, g2/Hz] of its power spectral density, of a force "
        "[Hz, N2/Hz], straight lines between them on logarithmic scales; or a CSV file of two such "
        "columns", example=[[20, 0.01], [200, 0.01]],
    )  # fmt: skip
    seed: Annotated[int, Field(ge=0, le=2**63 - 1, strict=True)] | None = key(
        None, "random: seed of its phases", example=1, left_out="1"
    )
    pulse: Literal["half_sine", "terminal_peak"] | None = key(
        None, "shock: its form", example="terminal_peak", left_out="half_sine"
    )
    file: str | None = key(
        None, "signal: CSV table with columns time [s] and one such as acceleration [g], or WAV "
        "file, next to this one", example="signal.csv",
    )  # fmt: skip
    column: str | None = key(
        None, "signal: name of the column", example="acceleration", left_out="the only one"
    )
    full_scale: str | None = key(
        None, "signal: what the largest number of a WAV file stands for", example="10 g"
    )
    integration: Literal["balanced", "as_measured"] | None = key(
        None, "signal: its means are taken off before an acceleration or a velocity is integrated, "
        "or it is taken as it was measured, from rest", example="as_measured", left_out="balanced",
    )  # fmt: skip


_TABLE = "materials table"


class Law(Section):
    """The contact law; what is given here goes before the materials table."""

    friction: Friction | None = key(
        None, "friction of all contacts", example=0.52, left_out=_TABLE, option="--friction"
    )
    friction_wall: Friction | None = key(
        None, "friction of contacts with the walls", example=0.52, left_out="as of all contacts",
        option="--friction-wall",
    )  # fmt: skip
    restitution: Restitution | None = key(
        None, "restitution of all contacts", example=0.86, left_out=_TABLE, option="--restitution"
    )
    restitution_wall: Restitution | None = key(
        None, "restitution of contacts with the walls", example=0.86, left_out="as of all contacts",
        option="--restitution-wall",
    )  # fmt: skip
    contact_treatment: Literal["sum", "deepest", "scaled"] = key(
        "sum", "multi-contact model, of several contacts of one pair of multi-sphere particles: "
        'each acts; "deepest": it alone; "scaled": together as stiff as one',
        option="--contact-treatment",
    )  # fmt: skip
    tangential: Literal["displacement", "force"] = key(
        "displacement", "quantity that the tangential spring carries on: its displacement, or "
        "its force", option="--tangential",
    )  # fmt: skip
    contact_end: Literal["overlap", "force"] = key(
        "overlap", 'end of a contact: it may pull until the overlap is zero, with "force" '
        "never", option="--contact-end",
    )  # fmt: skip
    wall_curvature: bool = key(
        False, "the contact law knows that the side of a cylinder is round; flat in the "
        "thesis", option="--wall-curvature",
    )  # fmt: skip
    yielding: bool | None = key(
        None, "restitution falls above the yield velocity (eq. 5.26), or does not", example=True,
        left_out="it falls for a pair whose yield velocity is below gamma g/omega, unless the "
        "materials table says restitution_model = \"constant\"", option="--yielding",
    )  # fmt: skip
    rolling_friction: Friction | None = key(
        None, "coefficient of rolling resistance: its largest torque over normal force and "
        "reduced radius", example=0.1, left_out="nothing resists rolling",
    )  # fmt: skip
    rolling_stiffness: Annotated[float, read("N/m"), Unit("N/m"), Field(gt=0)] | None = key(
        None, "stiffness of the spring that resists rolling", example="1e5 N/m"
    )
    rolling_damping: Annotated[float, read("N s/m"), Unit("N s/m"), Field(ge=0)] | None = key(
        None, "dashpot beside it", example="0.05 N s/m", left_out="none"
    )
    cohesion: Literal["dmt", "jkr"] | None = key(
        None, "cohesion of all contacts of spheres: of Derjaguin, Muller and Toporov, or of "
        "Johnson, Kendall and Roberts", example="jkr", left_out="none",
    )  # fmt: skip
    surface_energy: Annotated[float, read("J/m2"), Unit("J/m2"), Field(gt=0)] | None = key(
        None, "energy of each surface, half of the work of adhesion", example="0.05 J/m2"
    )
    youngs_modulus: Pressure | None = key(
        None, "Young's modulus of particles and walls", example="3.3 GPa", left_out=_TABLE,
        option="--youngs-modulus",
    )  # fmt: skip
    density: Density | None = key(
        None, "density of the particles", example="1.19 g/cm3", left_out=_TABLE, option="--density"
    )


class Fill(Section):
    """Settling of the particles before the motion begins."""

    settle_time: Time = key(
        0.2, "time of settling under gravity, before the motion begins", example="0.2 s"
    )
    friction: YesOrNumber = key(
        True, "friction while they settle; true: that of the motion; false: none; or a number"
    )


class Run(Section):
    """Seed, length and time step."""

    seed: Annotated[int, Field(ge=0, le=2**63 - 1, strict=True)] = key(
        1, "seed of the filling", option="--seed", metavar="1"
    )
    cycles: Annotated[int, Field(ge=1, le=1_000_000, strict=True)] = key(
        8, "cycles of the motion: the thesis's for spheres; 18 where they are left out and the "
        "particles have another shape", option="--cycles",
    )  # fmt: skip
    discard: Annotated[int, Field(ge=0, strict=True)] = key(
        3, "first cycles that do not count", option="--discard"
    )
    steady: bool = key(
        False, "as many cycles as a steady result takes",
        option="--steady",
    )  # fmt: skip
    max_cycles: Annotated[int, Field(ge=1, le=1_000_000, strict=True)] = key(
        60, "most cycles of a run until it is steady", option="--max-cycles"
    )
    time_step: Time | None = key(
        None, "time step, shortened so that a sample has a whole number of steps", example="1 us",
        left_out="1 us, or 0.2 of its limit (multi-sphere particles 0.3) if that is less",
        option="--time-step",
    )  # fmt: skip


class Output(Section):
    """Data that is kept."""

    samples: Annotated[int, Field(ge=8, le=MOST_SAMPLES, strict=True)] = key(
        100, "samples a cycle, of energies, forces and means", option="--samples"
    )
    frames: Annotated[int, Field(ge=0, le=10_000, strict=True)] = key(
        20, "frames a cycle, of all particles and contacts; divides samples; 0: none",
        option="--frames",
    )  # fmt: skip
    keep: Literal["all", "summary"] = key(
        "all", "data kept in the run folder: all, or the results without the trajectory",
        option="--keep",
    )  # fmt: skip


class Damper(Section):
    """One of several dampers on the host: keys that it gives stand before those of all."""

    at: Place | None = None
    seed: Annotated[int, Field(ge=0, le=2**63 - 1, strict=True)] | None = None
    enclosure: dict[str, Any] | None = None
    particles: dict[str, Any] | None = None
    law: dict[str, Any] | None = None


class Settings(Section):
    """A whole case file, but for its schema number."""

    name: Annotated[str, AfterValidator(folder_name)] = "damper"
    enclosure: Enclosure = Enclosure()
    particles: Particles = Particles()
    motion: Motion = Motion()
    host: Host = Host()
    excitation: Excitation = Excitation()
    law: Law = Law()
    fill: Fill = Fill()
    run: Run = Run()
    output: Output = Output()
    damper: Annotated[list[Damper], Field(min_length=2, max_length=100)] | None = None


_FOLLOWS = dict.fromkeys(
    ("motion.kind", "motion.frequency", "motion.gamma", "motion.ramp", "run.cycles", "run.discard",
     "run.steady", "run.max_cycles")
)  # fmt: skip
_NO_SINE = {**_FOLLOWS, "output.samples": None}
# Cases that `init` writes besides the thesis's, without keys that follow. `--host`: the thesis's
# bed on a structure of 20 times its mass, whose amplitude and length of run are found.
EXAMPLES: dict[str, dict[str, Any]] = {
    "host": {
        **_FOLLOWS, "host.mass": "0.56 kg", "host.frequency": 20.0, "host.damping_ratio": 0.01,
        "host.force": "0.5 N",
    },
    "sines": {
        **_NO_SINE, "excitation.kind": "sines", "excitation.frequencies": [20, 60],
        "excitation.amplitudes": ["4 g", "6 g"], "excitation.phases": ["0 deg", "90 deg"],
    },
    "sweep": {
        **_NO_SINE, "excitation.kind": "sweep", "excitation.from_frequency": "20 Hz",
        "excitation.to_frequency": "80 Hz", "excitation.amplitude": "8 g",
        "excitation.octaves_per_minute": 30, "excitation.and_back": True,
    },
    "random": {
        **_NO_SINE, "excitation.kind": "random",
        "excitation.psd": [[20, 0.05], [80, 0.2], [400, 0.05]], "excitation.seed": 1,
    },
    "shock": {
        **_NO_SINE, "excitation.kind": "shock", "excitation.pulse": "half_sine",
        "excitation.amplitude": "30 g", "excitation.length": "11 ms",
    },
}  # fmt: skip


def commented_case(values: Mapping[str, Any] = MappingProxyType({})) -> str:
    """A case file with a comment on every key; as it stands it is the preset `thesis`.

    values: by "section.key", what is written instead.
    """
    text = reference.commented_case(
        Settings,
        "A granular damper. Every key but schema may be left out; what stands here are the "
        "defaults, those of F. Terzioglu's thesis (University of Sheffield, 2023), Tables 6.1 and "
        "6.2. Quantities are texts with a unit; pure numbers have none. z is the axis of the "
        "enclosure, and its origin the centre of the bottom.",
        "damper",
        SCHEMA,
        values,
    )
    return text + _SEVERAL * ("host.mass" in values)


# What `init --host` writes behind all keys.
_SEVERAL = """
# Several dampers on the host: a table for each, whose keys of enclosure, particles and law go
# before those above. On several modes also at = "tip": its shapes are the column shape_tip of the
# table [host] modes; on one mode of a mass all dampers move alike. seed: of its filling, by itself
# far from those of the others.
# [[damper]]
#
# [[damper]]
# seed = 7
# enclosure = { height = "30 mm" }
# particles = { count = 250 }
"""

_FILE = casefile.CaseFile(Settings, SCHEMA)
read_settings, check_settings, to_toml = _FILE.read, _FILE.check, _FILE.to_toml
