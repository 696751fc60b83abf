"""The specification of a design: structure, level, space, budget, catalogue; a TOML file."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field

from damper3d.case.parts import GRAVITY
from granulab.contact.files import casefile, reference
from granulab.contact.files.casefile import (
    Acceleration,
    Force,
    Frequency,
    Mass,
    Number,
    Positive,
    Section,
    Size,
    folder_name,
    key,
)
from granulab.contact.files.datafile import data_names, find, read_toml
from granulab.contact.files.units import located, nearest, to_si
from granulab.errors import InputError

SCHEMA = 1
Count = Annotated[int, Field(ge=1, le=100_000, strict=True)]


class StructureKeys(Section):
    """The structure to be damped: one mode at the damper's place."""

    mass: Mass = key(..., "modal mass at the damper, with the empty enclosure", example="2 kg")
    frequency: Frequency = key(..., "natural frequency of the bare structure", example=60.0)
    damping_ratio: Annotated[Positive, Field(lt=1)] = key(
        ..., "damping ratio of the bare structure", example=0.005
    )


class LevelKeys(Section):
    """Level at which it is shaken, and direction of gravity."""

    acceleration: Acceleration | None = key(
        None, "amplitude of the bare structure at its resonance", example="5 g",
        left_out="by the force",
    )  # fmt: skip
    force: Force | None = key(
        None, "amplitude of the harmonic force on it, in place of that", example="9.8 N",
        left_out="by the acceleration",
    )  # fmt: skip
    range: Annotated[list[Positive], Field(min_length=1, max_length=20)] = key(
        [0.8, 1.0, 1.2], "levels over that one for which the damper is meant; the goal is the "
        "smallest response over bare response at the worst of them"
    )  # fmt: skip
    orientation: Literal["vertical", "horizontal", "none"] = key(
        "vertical", "direction of the motion to gravity; none: there is no gravity"
    )


class SpaceKeys(Section):
    """The room for the enclosure: inner sizes of a box whose height lies along the motion."""

    width: Size = key(..., "width", example="60 mm")
    depth: Size | None = key(None, "depth", example="60 mm", left_out="its width")
    height: Size = key(..., "height, along the motion", example="60 mm")


class BudgetKeys(Section):
    """Limits of what the damper may add."""

    added_mass: Annotated[Number, Field(gt=0, le=1)] = key(
        0.05, "largest mass of the particles over the structure's"
    )
    catalogue: str = key("balls", "particles to choose from: a shipped list, or a TOML file")


class SearchKeys(Section):
    """Extent of what is computed."""

    candidates: Count | None = key(
        None, "designs of which a field is computed", example=20,
        left_out="as many as some 20 minutes of one core take, 12 to 40",
    )  # fmt: skip
    verified: Count = key(4, "best designs that are verified with the structure")
    seeds: Annotated[int, Field(ge=2, le=100, strict=True)] = key(
        2, "packings of each of these verifications"
    )
    seed: Annotated[int, Field(ge=1, le=2**31 - 1, strict=True)] = key(
        1, "seed of the search and of the first packing"
    )
    fewest: Count = key(12, "least number of particles of a design")
    most: Count = key(400, "largest number of particles of a design, which its cost goes with")


class Spec(Section):
    """A whole specification, but for its schema number."""

    name: Annotated[str, AfterValidator(folder_name)] = "design"
    structure: StructureKeys
    level: LevelKeys = LevelKeys()
    space: SpaceKeys
    budget: BudgetKeys = BudgetKeys()
    search: SearchKeys = SearchKeys()


FILE = casefile.CaseFile(Spec, SCHEMA, "[structure] mass, frequency, damping_ratio, [space]")


@dataclass(frozen=True)
class Ball:
    """Particles of one kind and size in a catalogue."""

    kind: str
    diameter: float  # of the sphere of its volume [m]
    extent: float  # the longest [m]
    density: float  # [kg/m3]
    changes: tuple[tuple[str, Any], ...]  # keys of a case that has them
    source: str

    @property
    def volume(self) -> float:
        """[m3]"""
        return math.pi * self.diameter**3 / 6.0

    @property
    def mass(self) -> float:
        """[kg]"""
        return self.density * self.volume

    @property
    def walls(self) -> str:
        """Material of the enclosure."""
        return str(dict(self.changes)["enclosure.material"])

    @property
    def name(self) -> str:
        """Name such as "5 mm steel"."""
        return f"{1e3 * self.diameter:g} mm {self.kind}"


@dataclass(frozen=True)
class Task:
    """A specification in numbers."""

    spec: Spec
    catalogue: tuple[Ball, ...]

    @property
    def bare_gamma(self) -> float:
        """Amplitude of the bare structure at its resonance, at level 1, over g."""
        own, level = self.spec.structure, self.spec.level
        if level.acceleration is not None:
            return level.acceleration / GRAVITY
        assert level.force is not None
        return level.force / (2.0 * own.damping_ratio * own.mass * GRAVITY)

    @property
    def force(self) -> float:
        """Amplitude of the force at level 1 [N]: 2 zeta M a at resonance."""
        own = self.spec.structure
        return 2.0 * own.damping_ratio * own.mass * GRAVITY * self.bare_gamma

    @property
    def omega(self) -> float:
        """Of the bare structure [rad/s]."""
        return 2.0 * math.pi * self.spec.structure.frequency

    @property
    def bare_amplitude(self) -> float:
        """At resonance and level 1 [m]."""
        return self.bare_gamma * GRAVITY / self.omega**2

    @property
    def widest(self) -> float:
        """Largest diameter [m] of a cylinder in the space."""
        space = self.spec.space
        return min(space.width, space.depth or space.width)

    @property
    def budget(self) -> float:
        """Largest mass of the particles [kg]."""
        return self.spec.budget.added_mass * self.spec.structure.mass


def read_spec(path: str | Path) -> Task:
    """A task from a TOML file; InputError, one line, where it cannot be."""
    path = Path(path)
    spec = FILE.check(FILE.read(path), str(path))
    level = spec.level
    if (level.acceleration is None) == (level.force is None):
        both = "are both given; leave one out" if level.force else "are missing; give one of them"
        raise InputError(f"{path}: [level] acceleration and force {both}")
    if level.range != sorted(set(level.range)):
        raise InputError(f"{path}: [level] range = {level.range}: must rise, each value once")
    if spec.search.fewest > spec.search.most:
        raise InputError(
            f"{path}: [search] fewest = {spec.search.fewest}: must be at most most = "
            f"{spec.search.most}"
        )
    return Task(spec, read_catalogue(spec.budget.catalogue, path.parent))


def read_catalogue(name: str, folder: Path) -> tuple[Ball, ...]:
    """The balls of a catalogue; InputError where the file, or what it names, is not right."""
    from damper3d.case.case import DamperCase

    file = Path(find(name, "catalogues", folder))
    document = read_toml(file, "catalogues", SCHEMA)
    kinds = document.get("kind")
    if not isinstance(kinds, list) or not kinds:
        raise InputError(f"{file}: no [[kind]]; write name, materials, material, diameters")
    found = []
    for number, kind in enumerate(kinds, 1):
        where = f"{file}: kind {number}"
        _check_kind(kind, where)
        changes = _changes(kind, folder)
        with located(where):
            sizes = [to_si(size, "m", "diameters") for size in kind["diameters"]]
        for size in sizes:
            with located(where):
                if not size > 0:
                    raise InputError(f"diameters = {size:g} m: must be above 0")
                own = changes | _shape(kind.get("shape", "sphere"), size)
                room = {"enclosure.diameter": f"{20 * size!r} m", "particles.count": 1,
                        "enclosure.height": f"{20 * size!r} m"}  # fmt: skip
                case = DamperCase.load("thesis", own | room)
            found.append(
                Ball(
                    kind["name"],
                    size,
                    2.0 * case.particle.bounding_radius,
                    case.density,
                    tuple(own.items()),
                    kind.get("source", ""),
                )
            )
    return tuple(found)


def _check_kind(kind: Any, where: str) -> None:
    """Raise InputError for a kind whose keys are not those of one; a case checks most values."""
    if not isinstance(kind, dict):
        raise InputError(f"{where}: no table; write [[kind]], with name, materials, material, "
                         "diameters")  # fmt: skip
    for wanted in ("name", "materials", "material", "diameters"):
        if wanted not in kind:
            raise InputError(f"{where}: {wanted} is missing")
        if wanted != "diameters" and not isinstance(kind[wanted], str):
            raise InputError(f"{where}: {wanted} = {kind[wanted]!r}: write it as text, in quotes")
    if not isinstance(walls := kind.get("walls", ""), str):
        raise InputError(f"{where}: walls = {walls!r}: write a material as text, in quotes")
    if not isinstance(sizes := kind["diameters"], list) or not sizes:
        raise InputError(f"{where}: diameters = {sizes!r}: give a list such as ['5 mm', '8 mm']")
    for given in kind:
        if given not in _OF_A_KIND:
            raise InputError(f"{where}: unknown key {given!r}; {nearest(given, _OF_A_KIND)}")


def _shape(name: str, size: float) -> dict[str, Any]:
    """Changes of a case to particles of a shape, with the volume of a sphere of this size [m]."""
    if name == "sphere":
        return {"particles.shape": f"sphere:{1e3 * size!r} mm"}
    return {"particles.shape": name, "particles.equal_volume_radius": f"{0.5 * size!r} m"}


_OF_A_KIND = ("name", "materials", "material", "diameters", "shape", "walls", "restitution",
              "friction", "youngs_modulus", "source")  # fmt: skip


def _changes(kind: dict[str, Any], folder: Path) -> dict[str, Any]:
    file = kind["materials"]
    own = folder / file
    return {
        "particles.materials": str(own.resolve()) if own.is_file() else file,
        "particles.material": kind["material"],
        "enclosure.material": kind.get("walls", kind["material"]),
        **{
            f"law.{name}": kind[name]
            for name in ("restitution", "friction", "youngs_modulus")
            if name in kind
        },
    }


def example() -> str:
    """A specification with a comment on every key."""
    return reference.commented_case(
        Spec,
        "Specification of a damper. The particles are chosen from the catalogue; the enclosure "
        "is a cylinder along the motion.",
        "my_damper",
        SCHEMA,
        {
            "structure.mass": "2 kg", "structure.frequency": 60.0, "structure.damping_ratio": 0.005,
            "level.acceleration": "5 g", "space.width": "60 mm", "space.height": "60 mm",
        },
    )  # fmt: skip


def catalogues() -> list[str]:
    """Names of the shipped catalogues."""
    return data_names("catalogues")
