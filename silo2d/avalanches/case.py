"""A case of avalanches: a silo, how many it gives, how an arch is broken and the level kept."""

import dataclasses
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np

from granulab.campaign.runs.folder import digest
from granulab.campaign.sweeps.sweep import over_seeds
from granulab.errors import InputError
from silo2d.case.case import SiloCase
from silo2d.case.plan import expected_particles, expected_rate, expected_stages
from silo2d.case.settings import Settings

Breaking = Literal["remove", "shake"]
AVALANCHES, LARGEST = 50, 2000  # of a run; particles after which an avalanche is cut off
# Of the protocol besides its numbers: 2 since particles that are put on move as the bed does.
_REFILLING = 2
_MOST = 1_000_000  # of either
_ROOM = 0.25  # of the silo's height that its walls are raised by, for a bed that heaps up ...
_ROOM_RADII = 10  # ... or so many radii of the largest particle, where that is more
# Mean avalanche of the wood's particles, A exp(C (D/d)^2), as the committed study found it: for
# estimates of cost alone (docs/results/silo2d/clogging/clog-D3-wood19.txt).
_USUAL_A, _USUAL_C = 2.5, 0.16
_FREELY = "avalanches flow freely, and are refilled"
_REFUSED = (
    ("flow", "gate_times", _FREELY),
    ("flow", "feed_rate", _FREELY),
    ("flow", "refill", _FREELY),
    ("flow", "vibration_amplitude", "a bed that is shaken never comes to rest, which a clog is"),
    ("silo", "outlets", "avalanches are those of one outlet"),
    ("silo", "inserts", "an arch is looked for between the walls"),
)


@dataclass(frozen=True)
class Protocol:
    """Avalanches of a run; SI.

    avalanches      that are counted, the one from the opening not among them
    largest         particles after which an avalanche is cut off (censored) and the next begins
    breaking        of the arch: its particles are taken out and put on top ("remove"), or thrown in
                    random directions as fast as lifts a mean particle by its own size ("shake")
    drop            height above the lowest free place of the surface at which particles are put [m]
    """

    avalanches: int = AVALANCHES
    largest: int = LARGEST
    breaking: Breaking = "remove"
    drop: float = 0.0

    def __post_init__(self) -> None:
        for option, number in (("--avalanches", self.avalanches), ("--largest", self.largest)):
            if not 1 <= number <= _MOST:
                raise InputError(f"{option} = {number}: must be from 1 to {_MOST:,}")
        if self.breaking not in get_args(Breaking):
            raise InputError(f"--break = {self.breaking!r}: 'remove' or 'shake'")
        if not 0.0 <= self.drop <= 10.0:
            raise InputError(f"--drop = {1e3 * self.drop:g} mm: must be from '0 mm' to '10 m'")


@dataclass(frozen=True, eq=False)
class AvalancheCase:
    """A silo whose walls are raised for the refilling, and the protocol of its avalanches."""

    silo: SiloCase
    protocol: Protocol

    @classmethod
    def of(cls, silo: SiloCase, protocol: Protocol) -> "AvalancheCase":
        """Case of a silo; InputError where it is no case of avalanches."""
        if silo.impulses:
            raise InputError("[run] engine = 'pymunk': avalanches need the contacts of dem")
        for section, key, why in _REFUSED:
            if getattr(getattr(silo.settings, section), key):
                raise InputError(f"[{section}] {key}: {why}; leave it out")
        return cls(silo, protocol)

    @property
    def raised(self) -> SiloCase:
        """The silo with walls that hold what is put on its bed."""
        outline, radius = self.silo.outline, self.silo.shapes.bounding_radius
        by = max(_ROOM * outline.height, _ROOM_RADII * radius) + self.protocol.drop
        return dataclasses.replace(self.silo, outline=outline.raised(by))

    @property
    def name(self) -> str:
        """Name that the run folder is called after."""
        return f"{self.silo.name}-{1e3 * self.silo.outline.outlet:g}mm-avalanches"

    @property
    def settings(self) -> Settings:
        """Settings of the silo, of which the machinery of runs takes the seed."""
        return self.silo.settings

    @property
    def time_step(self) -> float:
        """Time step of the silo [s]."""
        return self.silo.time_step

    @property
    def files(self) -> dict[str, str]:
        """Texts of the run folder besides the case: shapes, materials, and the protocol."""
        own = self.protocol
        text = (
            "# The avalanches of this run; case.toml is the silo, as any other.\n"
            f"avalanches = {own.avalanches}\nlargest = {own.largest}\n"
            f'break = "{own.breaking}"\ndrop = "{1e3 * own.drop:g} mm"\n'
        )
        return {**self.silo.files, "avalanches.toml": text}

    def to_toml(self) -> str:
        """The silo as a case file."""
        return self.silo.to_toml()

    def with_seed(self, seed: int) -> "AvalancheCase":
        """The same with another seed."""
        ((_, silo),) = over_seeds({}, self.silo, [seed])
        return dataclasses.replace(self, silo=silo)

    @property
    def diameter(self) -> float:
        """Diameter of the disc of the particles' mean area [m]."""
        return float(np.sqrt(4 * self.silo.shapes.mean_area / np.pi))


def run_digest(case: AvalancheCase) -> str:
    """Names a run: silo, seed and protocol."""
    protocol = {**dataclasses.asdict(case.protocol), "refilling": _REFILLING}
    return digest({**case.silo.identity(), "avalanches": protocol})


def expected_avalanche(case: AvalancheCase) -> float:
    """About how many particles an avalanche has, cut off as it is."""
    across = case.silo.outline.outlet / case.diameter
    largest = case.protocol.largest
    return largest * -float(np.expm1(-_USUAL_A * np.exp(_USUAL_C * across**2) / largest))


def expected_cpu_s(case: AvalancheCase) -> tuple[float, float]:
    """About what the filling of a case and its avalanches cost [s of CPU]."""
    stages = expected_stages(case.silo)
    return stages["filling"], stages["settling"] + expected_flow_s(case)


def expected_flow_s(case: AvalancheCase) -> float:
    """About what the avalanches of a case cost [s of CPU]."""
    silo, stages = case.silo, expected_stages(case.silo)
    n, rate = expected_particles(silo), expected_rate(silo)
    flowing = expected_avalanche(case) / rate
    resting = 2.0 * silo.settings.run.rest_time
    # A discharge empties the silo, these keep it full: by the particles inside and the time.
    empties = min(silo.settings.run.max_time, n / rate)
    inside = n * empties - 0.5 * rate * empties**2  # of what "discharging" is for
    return stages["discharging"] * n * case.protocol.avalanches * (flowing + resting) / inside


def summary_of(case: AvalancheCase) -> dict[str, Any]:
    """Part of a case that stands with the results of its run."""
    return {
        "silo": case.silo.label,
        "seed": case.settings.run.seed,
        "outlet_m": case.silo.outline.outlet,
        "diameter_m": case.diameter,
        **dataclasses.asdict(case.protocol),
    }
