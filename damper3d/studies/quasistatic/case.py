"""A slow test's case: particles as a damper's, two halves, a pre-load, and how far it goes."""

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from damper3d.case.case import DamperCase
from damper3d.case.settings import Settings
from damper3d.shapes.multisphere import MultiSphere
from damper3d.studies.quasistatic.rig import Halves
from granulab.contact.files.units import to_si
from granulab.errors import InputError

Kind = Literal["shear", "compress"]

COUNT = 100  # particles (thesis, sec. 8.5.1.2)
PRELOAD = {"shear": 50.0, "compress": 10.0}  # [N] likewise
# Not in the thesis's text: ours. The shear force flattens within this, and that of compression
# rises to some 30 times the pre-load; beyond 80 times it, so many sub-spheres touch that steps of
# 1 us are too long for the sum of their dashpots, and the energy balance does not close.
DISTANCE = {"shear": 1e-3, "compress": 0.2e-3}  # [m]
AT = {"shear": 0.5e-3, "compress": 0.1e-3}  # [m] where the secant stiffness is taken
SPEED = 5e-3  # [m/s] an inertial number below 1e-3 in both tests

SAMPLES = 100  # rows of the test
_LOOSEST = 0.3  # packing fraction; toroids of 0.33, the loosest of the thesis's shapes, have 0.42

# The servo (see drive.py): lack of force where the bed gives way at the test's speed; viscosity
# over stiffness times time step; and the inertial number at which it may follow.
TOLERANCE, STEADY_STEPS, FASTEST_INERTIA = 0.01, 10.0, 1e-2


@dataclass(frozen=True, eq=False)
class SlowTest:
    """Everything that a test needs to know, validated; SI."""

    kind: Kind
    damper: DamperCase  # particles, laws, seed, time step; its enclosure is both halves together
    halves: Halves
    preload: float  # of the table [N]
    speed: float  # of the top half, or of the table downwards [m/s]
    distance: float  # that it goes [m]
    at: float  # displacement of the secant stiffness [m]

    @classmethod
    def load(
        cls, kind: Kind, changes: dict[str, Any], options: dict[str, str | None], seed: int = 1
    ) -> "SlowTest":
        """A test from changes of a damper's keys ("particles.shape") and options as texts.

        The options are diameter, half_height, gap, preload, speed, distance and at; one that is
        None or left out is the thesis's, or ours where it prints none. Raises InputError, one line.
        """
        value = _reader(options)
        halves = Halves(
            value("diameter", "m", 0.04), value("half_height", "m", 0.02),
            value("gap", "m", 0.5e-3, least=0.0),
        )  # fmt: skip
        void = {
            "enclosure.diameter": f"{halves.diameter!r} m",
            "enclosure.height": f"{halves.enclosure.height!r} m",
            "run.seed": seed,
            "particles.count": COUNT,
        }
        distance = value("distance", "m", DISTANCE[kind])
        test = cls(
            kind, DamperCase.load("thesis", void | changes), halves,
            value("preload", "N", PRELOAD[kind]), value("speed", "m/s", SPEED), distance,
            value("at", "m", min(AT[kind], distance)),
        )  # fmt: skip
        test._check()
        return test

    def _check(self) -> None:
        width = least_width(self.damper.particle)
        if self.halves.gap >= width:
            raise InputError(
                f"--gap {1e3 * self.halves.gap:g} mm: particles {1e3 * width:.3g} mm wide would "
                "fall through; give a smaller one, such as '0.5 mm'"
            )
        if self.kind == "shear" and self.distance >= width:
            raise InputError(
                f"--distance {1e3 * self.distance:g} mm: opens a crescent between the halves "
                f"through which particles {1e3 * width:.3g} mm wide would fall; give less"
            )
        if self.at > self.distance:
            raise InputError(
                f"--at {1e3 * self.at:g} mm: beyond the distance of {1e3 * self.distance:g} mm; "
                "give at most that"
            )
        self._refuse_impossible()

    def _refuse_impossible(self) -> None:
        """Raise InputError now for what would come to nothing after minutes of settling."""
        room = self.halves.enclosure.height
        solid = self.damper.fill_ratio * room
        if self.kind == "compress" and self.distance >= room - solid:
            raise InputError(
                f"--distance {1e3 * self.distance:g} mm: all voids of the halves are "
                f"{1e3 * (room - solid):.3g} mm high; give less, such as '0.2 mm'"
            )
        if self.kind == "shear" and solid / _LOOSEST < self.halves.rim:
            raise InputError(
                f"--count {self.damper.count}: a bed of {1e3 * solid / _LOOSEST:.3g} mm at most "
                f"does not reach the top half, {1e3 * self.halves.rim:g} mm above the base; give "
                "more, or a smaller --half-height"
            )
        row = self.distance / SAMPLES
        if self.speed * self.time_step > row:
            raise InputError(
                f"--speed {1e3 * self.speed:g} mm/s: {1e3 * self.distance:g} mm are over in less "
                f"than {SAMPLES} time steps of {1e6 * self.time_step:.3g} us; at most "
                f"{1e3 * row / self.time_step:.3g} mm/s, or a longer --distance"
            )
        if self.at < row:
            raise InputError(
                f"--at {1e3 * self.at:g} mm: before the first of {SAMPLES} rows; at least "
                f"{1e3 * row:.3g} mm"
            )
        radius = self.damper.particle.equal_volume_radius
        if self._overlap >= radius:
            raise InputError(
                f"--preload {self.preload:g} N: would press a layer of particles by "
                f"{1e3 * self._overlap:.3g} mm into the table, more than their radius of "
                f"{1e3 * radius:.3g} mm; give less, such as '50 N'"
            )

    @property
    def name(self) -> str:
        """Name that the run folder begins with."""
        shape = self.damper.particle.name.replace(":", "-").replace("/", "-")
        return f"{self.kind}-{shape}"

    @property
    def settings(self) -> Settings:
        """Those of the particles, with the seed."""
        return self.damper.settings

    @property
    def files(self) -> dict[str, str]:
        """Texts by name, of the files that the case refers to."""
        return self.damper.files

    @property
    def time_step(self) -> float:
        """[s]"""
        return self.damper.steps.free

    @property
    def pressure(self) -> float:
        """Pressure of the pre-load on the cross section [Pa]."""
        return self.preload / self.halves.area

    def inertial_speed(self, inertial_number: float) -> float:
        """The speed [m/s] of an inertial number v sqrt(rho/p) across one particle [-]."""
        return inertial_number * math.sqrt(self.pressure / self.damper.density)

    @property
    def servo(self) -> tuple[float, float]:
        """Viscosity [N s/m] and speed limit [m/s] of the table.

        The stiffness that the viscosity must master over a step is that of a layer of particles
        against the table, as many as cover it, that share the pre-load: Hertz's (3/2) F/overlap.
        """
        stiffness = 1.5 * self.preload / self._overlap
        viscosity = max(
            TOLERANCE * self.preload / self.speed, STEADY_STEPS * stiffness * self.time_step
        )
        return viscosity, self.inertial_speed(FASTEST_INERTIA)

    @property
    def _overlap(self) -> float:
        """Of the particles of a layer with the table, under the pre-load [m]."""
        radius = self.damper.particle.equal_volume_radius
        layer = (0.5 * self.halves.diameter / radius) ** 2 * math.sqrt(radius)
        return (self.preload / (layer * self.damper.wall_law.hertz)) ** (2 / 3)

    def identity(self) -> dict[str, Any]:
        """All that the results of a run depend on, by which its folder is named."""
        return {
            **self.packing_identity(),
            "test": [self.kind, self.preload, self.speed, self.distance, self.at],
        }

    def packing_identity(self) -> dict[str, Any]:
        """All that a settled packing depends on; both tests of a bed share it."""
        halves = self.halves
        return {
            "halves": [halves.diameter, halves.height, halves.gap],
            **self.damper.packing_identity(),
        }

    def to_toml(self) -> str:
        """The damper's case, and the test, as a text for the run folder."""
        lines = [
            "", "[slow_test]", f'kind = "{self.kind}"', f'gap = "{self.halves.gap!r} m"',
            f'half_height = "{self.halves.height!r} m"', f'preload = "{self.preload!r} N"',
            f'speed = "{self.speed!r} m/s"', f'distance = "{self.distance!r} m"',
            f'at = "{self.at!r} m"',
        ]  # fmt: skip
        return self.damper.to_toml() + "\n".join(lines) + "\n"


def least_width(particle: MultiSphere) -> float:
    """The least extent of a particle along its principal axes [m]."""
    far = particle.offsets + particle.radii[:, None]
    near = particle.offsets - particle.radii[:, None]
    return float(np.min(far.max(axis=0) - near.min(axis=0)))


def _reader(options: dict[str, str | None]) -> Any:
    def value(name: str, unit: str, usual: float, least: float | None = None) -> float:
        text = options.get(name)
        if text is None:
            return usual
        field = f"--{name.replace('_', '-')}"
        number = to_si(text, unit, field)
        if number < 0.0 or (number == 0.0 and least is None):
            raise InputError(f"{field} = {text!r}: must be above 0 {unit}")
        return number

    return value
