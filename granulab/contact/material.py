"""Materials and pairs of materials: what is known of a contact, with uncertainty and source."""

import dataclasses
import datetime
import math
import re
from collections.abc import Callable
from typing import Literal, NamedTuple

from granulab.errors import InputError


class Property(NamedTuple):
    """Unit and range of a measured property."""

    unit: str  # SI; "1" for a pure number
    unit_in_files: str  # the one people use for it
    allowed: str  # the range, in words that follow "must be"
    holds: Callable[[float], bool]  # whether an SI number is in the range
    meaning: str  # for a person who writes a file


_POSITIVE: tuple[str, Callable[[float], bool]] = "above 0", lambda value: value > 0
_NOT_NEGATIVE: tuple[str, Callable[[float], bool]] = "at least 0", lambda value: value >= 0

PROPERTIES = {
    "density": Property("kg/m3", "g/cm3", *_POSITIVE, "density"),
    "length": Property(
        "m", "mm", *_POSITIVE, "length of the prisms whose cross section is simulated"
    ),
    "youngs_modulus": Property("Pa", "GPa", *_POSITIVE, "Young's modulus"),
    "poisson": Property(
        "1", "1", "between -1 and 0.5", lambda value: -1 < value < 0.5, "Poisson's ratio"
    ),
    "yield_strength": Property(
        "Pa",
        "MPa",
        *_POSITIVE,
        "yield strength, for the speed at which spheres yield; may be left out",
    ),
    "loss_factor": Property(
        "1",
        "1",
        "above 0 and below 2",
        lambda value: 0 < value < 2,
        "loss factor of a viscoelastic material, which gives the restitution of a pair without one",
    ),
    "friction": Property("1", "1", *_NOT_NEGATIVE, "Coulomb coefficient"),
    "restitution": Property(
        "1",
        "1",
        "above 0 and at most 1",
        lambda value: 0 < value <= 1,
        "leaving over arriving normal speed",
    ),
    "kn": Property("N/m", "N/mm", *_POSITIVE, "normal stiffness of one vertex-edge contact"),
    "kt": Property(
        "N/m", "N/mm", *_NOT_NEGATIVE, "tangential stiffness of one vertex-edge contact"
    ),
    "gamma_n": Property(
        "1/s",
        "1/s",
        *_NOT_NEGATIVE,
        "normal damping; left out: [law] damping = 'restitution'",
    ),
    "gamma_t": Property("1/s", "1/s", *_NOT_NEGATIVE, "tangential damping; likewise"),
}


@dataclasses.dataclass(frozen=True, slots=True)
class Measured:
    """A value and what is known of its origin; with a sigma it stands for a distribution.

    Where a scatter is given, sigma is how well the value itself, a mean, is known.
    """

    value: float  # SI
    sigma: float | None = None  # standard deviation of the normal distribution, SI, absolute
    source: str | None = None  # where it is published, or who measured it
    method: str | None = None  # how it was measured
    trials: int | None = None  # how many measurements are behind it
    date: datetime.date | None = None  # when it was measured
    scatter: float | None = None  # standard deviation of a single trial, SI, absolute
    digest: str | None = None  # SHA-256 of what was measured from, in hexadecimal
    history: "tuple[Measured, ...]" = ()  # what stood here before, the oldest first

    @property
    def spread(self) -> float | None:
        """Standard deviation from one contact to the next: scatter, or sigma where it is alone."""
        return self.sigma if self.scatter is None else self.scatter


@dataclasses.dataclass(frozen=True, slots=True)
class Material:
    """The material of a particle or wall.

    Raises InputError, one line without the file, for a value out of its range in PROPERTIES.
    """

    name: str  # letters, digits and _
    density: Measured  # [kg/m3]
    length: Measured | None = None  # of the prism a plane particle is the section of [m]
    youngs_modulus: Measured | None = None  # [Pa]
    poisson: Measured | None = None  # [-]
    yield_strength: Measured | None = None  # [Pa]
    loss_factor: Measured | None = None  # of a viscoelastic one [-]

    def __post_init__(self) -> None:
        if not re.fullmatch(r"\w+", self.name, re.ASCII):
            raise InputError(
                f"material name {self.name!r}: takes letters, digits and _ only"
                " (a hyphen joins the two names of a pair)"
            )
        _check_ranges(self)


@dataclasses.dataclass(frozen=True, slots=True)
class LinearParameters:
    """Stiffness and damping of the linear spring and dashpot, one vertex-edge contact.

    The dashpots are -m gamma v with the reduced mass m (wood-silo paper, eqs 2.2 and 2.3). None
    where a value is not known.
    """

    kn: Measured | None = None  # normal stiffness [N/m]
    kt: Measured | None = None  # tangential stiffness [N/m]
    gamma_n: Measured | None = None  # normal damping [1/s]
    gamma_t: Measured | None = None  # tangential damping [1/s]

    def __post_init__(self) -> None:
        _check_ranges(self)

    @property
    def numbers(self) -> tuple[float, float, float, float]:
        """kn, kt [N/m], gamma_n, gamma_t [1/s] where all are known."""
        known = self.kn, self.kt, self.gamma_n, self.gamma_t
        kn, kt, gamma_n, gamma_t = (one.value for one in known if one is not None)
        return kn, kt, gamma_n, gamma_t


@dataclasses.dataclass(frozen=True, slots=True)
class Pair:
    """Contact of two materials, named in either order.

    Raises InputError, one line without the file, for a value out of its range in PROPERTIES.
    """

    first: str
    second: str
    friction: Measured  # Coulomb coefficient [-]
    restitution: Measured | None = None  # leaving over arriving normal speed [-]
    linear: LinearParameters | None = None
    restitution_model: Literal["constant"] | None = None  # at all speeds; None: see damper3d.case

    def __post_init__(self) -> None:
        _check_ranges(self)


def _check_ranges(record: Material | LinearParameters | Pair) -> None:
    for field in dataclasses.fields(record):
        measured = getattr(record, field.name)
        if isinstance(measured, Measured):
            check_range(field.name, measured)


def check_range(name: str, measured: Measured) -> None:
    """Raise InputError where a value of that name is out of its range in PROPERTIES."""
    unit, value, trials = PROPERTIES[name].unit, measured.value, measured.trials
    shown = "" if unit == "1" else f" {unit}"
    if not (math.isfinite(value) and PROPERTIES[name].holds(value)):
        raise InputError(f"{name} = {value:g}{shown}: must be {PROPERTIES[name].allowed}")
    for key in ("sigma", "scatter"):
        width = getattr(measured, key)
        if width is not None and not 0 <= width < math.inf:
            raise InputError(f"{name}.{key} = {width:g}{shown}: must be at least 0")
    if trials is not None and trials < 1:
        raise InputError(f"{name}.trials = {trials}: must be at least 1")
