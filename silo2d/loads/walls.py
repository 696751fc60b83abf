"""Loads on vertical walls after EN 1991-4:2006, section 5: filling, discharge, patches.

Slender silos (h_c/d_c >= 2) follow Janssen, 5.2.1.1; of intermediate slenderness and squat ones a
modified Reimbert's law, 5.3.1.1, with z from the equivalent surface:

    p_h = p_ho Y,  p_ho = gamma K z_o,  z_o = (A/U)/(K mu),  p_w = mu p_h
    Y_J = 1 - exp(-z/z_o)                                        p_v = gamma z_o Y_J
    Y_R = 1 - ((z - h_o)/(z_o - h_o) + 1)^n                      p_v = gamma z_V
    n   = -(1 + tan phi_r)(1 - h_o/z_o)
    z_V = h_o - (z_o - h_o - (z + z_o - 2 h_o)^(n+1)/(z_o - h_o)^n)/(n + 1)

Retaining silos (h_c/d_c <= 0.4 over a flat bottom), 5.4: p_h = gamma K (1 + sin phi_r)(z - h_o),
p_v = gamma z. The others are in balance: A gamma z = A p_v + U n_z, n_z the integral of p_w.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from granulab.errors import InputError
from silo2d.loads.janssen import Floats, janssen_stress
from silo2d.loads.solid import Values
from silo2d.loads.vessel import Vessel

LARGE_ECCENTRICITY = 0.25  # over d_c: beyond it other rules hold (5.2.4, 5.3.4), not made here


@dataclass(frozen=True)
class Wall:
    """Symmetrical filling loads of a vessel by one set of characteristic values.

    unit_weight [N/m3]; highest: h_o [m]; repose: phi_r [rad]
    """

    vessel: Vessel
    values: Values
    unit_weight: float
    highest: float
    repose: float

    def __post_init__(self) -> None:
        if self._reimbert and self.values.wall_friction > 0 and self.length <= self.highest:
            raise InputError(
                f"wall_friction = {self.values.wall_friction:.3g}: too rough for so wide a heap "
                f"(z_o = {self.length:.3g} m, h_o = {self.highest:.3g} m); give a lower angle of "
                "repose, or surface = 'level'"
            )

    @property
    def _reimbert(self) -> bool:
        return self.vessel.slenderness_class in ("intermediate", "squat")

    @property
    def length(self) -> float:
        """Janssen's characteristic depth z_o [m]; infinite along frictionless walls."""
        product = self.values.wall_friction * self.values.lateral_ratio
        return self.vessel.area / self.vessel.perimeter / product if product else math.inf

    def horizontal(self, depth: Floats) -> Floats:
        """p_h [Pa] at depths z [m] below the equivalent surface; 0 above the solid."""
        ratio, weight = self.values.lateral_ratio, self.unit_weight
        if self.vessel.slenderness_class == "slender":
            return ratio * self.vertical(depth)
        wet = np.maximum(np.asarray(depth, dtype=float) - self.highest, 0.0)
        if not self._reimbert:
            return weight * ratio * (1.0 + math.sin(self.repose)) * wet
        if math.isinf(self.length):  # the limit of Y_R z_o
            return weight * ratio * (1.0 + math.tan(self.repose)) * wet
        base = wet / (self.length - self.highest) + 1.0
        return weight * ratio * self.length * (1.0 - base**self._exponent)

    @property
    def _exponent(self) -> float:
        return -(1.0 + math.tan(self.repose)) * (1.0 - self.highest / self.length)

    def friction(self, depth: Floats) -> Floats:
        """p_w [Pa]."""
        return self.values.wall_friction * self.horizontal(depth)

    def vertical(self, depth: Floats) -> Floats:
        """p_v [Pa], the mean over the cross section."""
        depth = np.asarray(depth, dtype=float)
        if self.vessel.slenderness_class == "slender":
            product = self.values.wall_friction * self.values.lateral_ratio
            radius = self.vessel.area / self.vessel.perimeter
            return janssen_stress(depth, self.unit_weight, product, 2.0 * radius)
        if not self._reimbert or math.isinf(self.length):
            return self.unit_weight * depth
        own, n = self.length - self.highest, self._exponent
        over = np.maximum(depth - self.highest, 0.0) / own + 1.0
        integral = own * (np.log(over) if abs(n + 1) < 1e-9 else (over ** (n + 1) - 1) / (n + 1))
        return self.unit_weight * (np.minimum(depth, self.highest) + integral)

    def carried(self, depth: Floats) -> Floats:
        """n_z [N/m], vertical force in the wall over its length, from the surface to depths."""
        depth = np.asarray(depth, dtype=float)
        if self.vessel.slenderness_class == "retaining":
            return 0.5 * self.friction(depth) * np.maximum(depth - self.highest, 0.0)
        if self.values.wall_friction == 0:
            return np.zeros_like(depth)
        radius = self.vessel.area / self.vessel.perimeter
        return (self.unit_weight * depth - self.vertical(depth)) * radius


class Factors(NamedTuple):
    """Discharge factors of horizontal pressure and wall friction [-]."""

    horizontal: float  # C_h
    friction: float  # C_w


def discharge_factors(
    vessel: Vessel, patch: float, assessment_class: int, eccentricity: float, from_top: bool
) -> Factors:
    """C_h and C_w (5.2.2.1, 5.3.2.1).

    patch: C_op; eccentricity: the larger of filling and outlet [m]; from_top: emptied from the top,
    without flow. Assessment class 1 takes mean properties and larger factors for it.
    """
    kind, e = vessel.slenderness_class, eccentricity / vessel.characteristic_width
    if from_top or kind in ("squat", "retaining"):
        return Factors(1.0, 1.0)
    part = 1.0 if kind == "slender" else vessel.slenderness - 1.0  # C_S
    if assessment_class > 1:
        return Factors(1.0 + 0.15 * part, 1.0 + 0.10 * part)
    horizontal = 1.0 + (0.15 + 1.5 * (1.0 + 0.4 * e) * patch) * part
    slender = 1.4 * (1.0 + 0.4 * e)
    return Factors(horizontal, slender if kind == "slender" else 1.0 + 0.4 * (1.0 + 1.4 * e) * part)


def filling_patch(vessel: Vessel, patch: float, filling_eccentricity: float) -> float:
    """C_pf = 0.21 C_op (1 + 2 E^2)(1 - exp(-1.5 (h_c/d_c - 1))), E = 2 e_f/d_c; >= 0 (5.2.1.2)."""
    e = 2.0 * filling_eccentricity / vessel.characteristic_width
    rise = 1.0 - math.exp(-1.5 * (vessel.slenderness - 1.0))
    return max(0.21 * patch * (1.0 + 2.0 * e**2) * rise, 0.0)


def discharge_patch(vessel: Vessel, patch: float, eccentricity: float) -> float:
    """C_pe (5.2.2.2): as C_pf with 0.42 above h_c/d_c = 1.2; 0.272 C_op (h_c/d_c - 1 + E) below.

    eccentricity: the larger of filling and outlet [m]. Squat silos need none while it is at most
    0.1 d_c (5.3.2.2).
    """
    e = 2.0 * eccentricity / vessel.characteristic_width
    if vessel.slenderness > 1.2:
        return 2.0 * filling_patch(vessel, patch, eccentricity)
    if vessel.slenderness_class in ("squat", "retaining") and e <= 0.2:
        return 0.0
    return max(0.272 * patch * (vessel.slenderness - 1.0 + e), 0.0)


class Patch(NamedTuple):
    """A patch load: an outward pressure on a part of the wall, anywhere."""

    factor: float  # C_pf or C_pe [-]
    side: float  # s, height of the patch [m]
    depth: float  # z_p, where it governs [m]
    pressure: float  # [Pa] at that depth
    inward: float  # on the rest of the same ring, thick circular walls [Pa]
    force: float  # its horizontal resultant, circular walls [N]; 0 where it has none


def patch_load(vessel: Vessel, factor: float, wall: Wall, magnifier: float) -> Patch:
    """A patch at the lower of z_o and half the height, whichever is higher up (5.2.1.3 to 5.2.1.5).

    magnifier: C_h on discharge, 1 on filling. Thin circular walls: p cos(theta) round a ring of
    height s, resultant pi/2 s d_c p. Thick ones: on two opposite squares s x s, and p/7 inwards
    elsewhere. Walls that are not circular: 0.36 p on a band of height s.
    """
    d_c = vessel.characteristic_width
    side = math.pi * d_c / 16.0
    depth = min(wall.length, vessel.height / 2.0)
    pressure = factor * magnifier * float(wall.horizontal(np.array(depth)))
    if vessel.plan != "circular":
        return Patch(factor, side, depth, 0.36 * pressure, 0.0, 0.0)
    if vessel.thin:
        return Patch(factor, side, depth, pressure, 0.0, math.pi / 2.0 * side * d_c * pressure)
    return Patch(factor, side, depth, pressure, pressure / 7.0, 0.0)
