"""Loads of a design in closed form, as numbers for JSON, report and sheet."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from silo2d.loads import bottom, jenike
from silo2d.loads.design import Design, FlowFunction
from silo2d.loads.janssen import Floats, janssen_stress
from silo2d.loads.solid import LOAD_CASES, Values, as_numbers, at_hopper, characteristic
from silo2d.loads.walls import (
    LARGE_ECCENTRICITY,
    Patch,
    Wall,
    discharge_factors,
    discharge_patch,
    filling_patch,
    patch_load,
)

_GRAVITY = 9.81  # [m/s2]
_SMALL = 100.0  # [t] up to which a silo may be of assessment class 1 (2.5)
_DEPTHS = 33  # of the series of pressures; every fourth is printed


class Loads:
    """The closed forms of one design."""

    def __init__(self, design: Design) -> None:
        self.design = design
        self.vessel, self.solid, self.rules = design.vessel, design.solid, design.rules
        heap = self.rules.surface == "heap"
        self.highest = self.vessel.highest_contact(self.solid.repose, heap)
        self.pile = self.vessel.pile_height(self.solid.repose, heap)
        self.eccentricity = max(
            self.rules.filling_eccentricity,
            self.rules.outlet_eccentricity if self.rules.emptied == "below" else 0.0,
        )

    def values(self, load_case: str) -> Values:
        """Characteristic values of a load case."""
        return characteristic(self.solid, load_case, means=self.rules.assessment_class == 1)

    def wall(self, load_case: str) -> Wall:
        """Symmetrical filling loads by the values of a load case."""
        values = self.values(load_case)
        return Wall(self.vessel, values, self.solid.unit_weight, self.highest, self.solid.repose)

    def janssen(self, depths: Floats) -> tuple[Floats, Floats]:
        """Horizontal and vertical stress [Pa] by Janssen's law and mean properties."""
        mu, ratio, _ = characteristic(self.solid, "wall_pressure", means=True)
        radius = self.vessel.area / self.vessel.perimeter
        vertical = janssen_stress(depths, self.solid.unit_weight, mu * ratio, 2.0 * radius)
        return ratio * vertical, vertical

    @property
    def factors(self) -> tuple[float, float]:
        """C_h and C_w."""
        return discharge_factors(
            self.vessel, self.solid.patch, self.rules.assessment_class, self.eccentricity,
            self.rules.emptied == "above",
        )  # fmt: skip

    def patches(self) -> dict[str, Patch]:
        """Patch loads on filling and discharge; none in class 1, whose factors cover them."""
        if self.rules.assessment_class == 1:
            return {}
        wall, c_h = self.wall("wall_pressure"), self.factors[0]
        filling = filling_patch(self.vessel, self.solid.patch, self.rules.filling_eccentricity)
        found = {"filling": patch_load(self.vessel, filling, wall, 1.0)}
        if self.rules.emptied == "below":
            factor = discharge_patch(self.vessel, self.solid.patch, self.eccentricity)
            found["discharge"] = patch_load(self.vessel, factor, wall, c_h)
        return found

    def wall_table(self, depths: Floats) -> dict[str, Any]:
        """Pressures on the walls at depths [m], on filling and discharge, by table 3.1."""
        pressed, rubbed = self.wall("wall_pressure"), self.wall("wall_friction")
        borne, (c_h, c_w) = self.wall("bottom"), self.factors
        horizontal, friction = pressed.horizontal(depths), rubbed.friction(depths)
        carried, janssen = rubbed.carried(depths), self.janssen(depths)
        lists = {
            "depth_m": depths,
            "filling_horizontal_pa": horizontal,
            "filling_friction_pa": friction,
            "filling_vertical_pa": borne.vertical(depths),
            "filling_wall_force_n_per_m": carried,
            "discharge_horizontal_pa": c_h * horizontal,
            "discharge_friction_pa": c_w * friction,
            "discharge_wall_force_n_per_m": c_w * carried,
            "janssen_horizontal_pa": janssen[0],
            "janssen_vertical_pa": janssen[1],
        }
        return {name: series.tolist() for name, series in lists.items()}

    def bottom(self) -> dict[str, Any]:
        """Load on a flat bottom, or on the transition of a hopper and its walls."""
        magnifier = bottom.bottom_magnifier(self.rules.assessment_class, self.rules.dynamic_bottom)
        wall = self.wall("bottom")
        top = magnifier * float(wall.vertical(np.array(self.vessel.height)))
        found: dict[str, Any] = {"C_b": magnifier, "vertical_at_transition_pa": top}
        if self.vessel.is_flat:
            return found | {"kind": "flat", "vertical_pa": bottom.flat_bottom(
                wall, magnifier, self.pile)}  # fmt: skip
        return found | self._hopper(top)

    def _hopper(self, top: float) -> dict[str, Any]:
        vessel, weight = self.vessel, self.solid.unit_weight
        assert vessel.half_angle is not None
        lower = self.values("hopper_filling")
        upper = lower if self.rules.assessment_class == 1 else at_hopper(self.solid, (1, 1, 1))
        limits = bottom.steep_up_to(lower), bottom.steep_up_to(upper)
        steep = [vessel.half_angle < limit for limit in limits]
        filling = discharge = bottom.hopper_filling(vessel, weight, top, lower, _DEPTHS)
        if steep[0]:
            flowing = self.values("hopper_discharge")
            discharge = bottom.hopper_discharge(vessel, weight, top, flowing, _DEPTHS)
        return {
            "kind": "steep" if steep[0] else "shallow",
            "steep_up_to_deg": math.degrees(limits[0]),
            "steep_up_to_by_upper_values_deg": math.degrees(limits[1]),
            "steepness_differs": steep[0] != steep[1],
            "filling": _of_hopper(filling),
            "discharge": _of_hopper(discharge),
        }

    def jenike(self) -> dict[str, Any]:
        """Mass or funnel flow, and the outlets that do not arch or rathole."""
        return jenike_numbers(
            self.vessel.half_angle, self.solid.effective_friction,
            math.atan(self.solid.hopper_friction), self.vessel.hopper == "wedge",
            self.solid.unit_weight_lower, self.design.flow_function, self.solid.internal_friction,
            float(self.janssen(np.array(self.vessel.height))[1]),
        )  # fmt: skip

    def assumptions(self) -> list[str]:
        """Assumptions of the numbers, a sentence each."""
        own = {
            "slender": "Janssen's law (5.2.1.1)",
            "intermediate": "modified Reimbert's law (5.3.1.1)",
            "squat": "modified Reimbert's law (5.3.1.1)",
            "retaining": "a retaining silo's pressures, without silo action (5.4)",
        }[self.vessel.slenderness_class]
        words = [
            f"EN 1991-4:2006, {self.vessel.slenderness_class} silo: {own}; pressures are "
            "characteristic, without partial factors",
            "class 1: mean properties and larger factors, no patches"
            if self.rules.assessment_class == 1
            else "upper and lower characteristic values by table 3.1; mu at most tan phi_i",
            "surface level: h_o = 0"
            if self.rules.surface == "level"
            else "surface a heap at the angle of repose, filled about the axis",
        ]
        if self.vessel.plan == "slot":
            rubs = "rub as the walls" if self.vessel.rough_plates else "carry nothing"
            words.append(
                f"slot: plates {rubs}, A/U = {self.vessel.area / self.vessel.perimeter:.4g} m"
            )
        if not self.vessel.is_flat and self.vessel.friction_shape not in (1.0, 2.0):
            words.append("pyramid: F and mu_eff of its longer sides on its flatter ends, too")
        one = self.solid.unit_weight_lower == self.solid.unit_weight
        if self.design.flow_function and one:
            words.append("Jenike's outlets: by unit_weight, as no lower one is given")
        tonnes = self.vessel.volume * self.solid.unit_weight / _GRAVITY / 1e3
        if self.rules.assessment_class == 1 and tonnes > _SMALL:
            words.append(
                f"holds {tonnes:.0f} t: class 1 is for up to 100 t (2.5); take class 2 or 3"
            )
        if self.eccentricity > LARGE_ECCENTRICITY * self.vessel.characteristic_width:
            words.append(
                "eccentricity over 0.25 d_c: the standard's rules for large eccentricities "
                "(5.2.4, 5.3.4) are NOT made here and govern"
            )
        return [*words, *self.design.assumptions]


def _of_hopper(own: bottom.Hopper) -> dict[str, Any]:
    return {
        "height_m": own.height.tolist(),
        "vertical_pa": own.vertical.tolist(),
        "normal_pa": own.normal.tolist(),
        "friction_pa": own.friction.tolist(),
        "F": own.factor,
        "n": own.exponent,
        "effective_friction": own.effective_friction,
    }


def jenike_numbers(
    half_angle: float | None, delta: float, wall: float, plane: bool, unit_weight: float,
    flow_function: FlowFunction, internal: float, largest: float,
) -> dict[str, Any]:  # fmt: skip
    """Jenike's answers for a hopper, angles [rad]; largest: vertical pressure at its top [Pa].

    unit_weight: the lower characteristic one [N/m3], by which what stands is widest.
    """
    limit = jenike.mass_flow_limit(delta, wall, plane)
    beta = math.pi / 2 if half_angle is None else half_angle
    flow = jenike.converging(delta, wall, beta, plane)
    found: dict[str, Any] = {
        "plane": plane,
        "half_angle_deg": math.degrees(beta),
        "effective_friction_deg": math.degrees(delta),
        "wall_friction_deg": math.degrees(wall),
        "mass_flow_up_to_deg": math.degrees(limit),
        "flow": jenike.flow_pattern(beta, limit),
        "flow_factor": None if flow is None else flow.flow_factor,
        "stress_over_gamma_r": None if flow is None else flow.stress,
        "cohesionless": not any(strength for _, strength in flow_function),
    }
    strong = jenike.strength(flow_function, largest)
    why = None
    if flow is None or found["flow"] == "funnel flow":
        why = "flat bottom" if half_angle is None else found["flow"]
    return found | _arch(flow, why, flow_function, unit_weight, largest) | {
        "rathole_up_to_m": jenike.rathole(internal, strong, unit_weight),
        "rathole_stress_pa": largest,
        "strength_known_up_to_pa": flow_function[-1][0] if flow_function else None,
    }  # fmt: skip


def _arch(
    flow: jenike.Converging | None, why: str | None, flow_function: FlowFunction,
    unit_weight: float, largest: float,
) -> dict[str, Any]:  # fmt: skip
    """The widest arch and the stress that makes its strength [Pa]; why: it is not computed."""
    found: dict[str, Any] = {
        "arch_up_to_m": None,
        "arch_stress_pa": None,
        "arch_at_any_width": False,
        "arch_not_computed": None,
    }
    if not any(strength for _, strength in flow_function):
        return found | {"arch_up_to_m": 0.0}
    if flow is None or why is not None:
        return found | {"arch_not_computed": why}
    fails = jenike.arching_stress(flow_function, flow.flow_factor, max(100 * largest, 1e7))
    if fails is None:
        return found | {"arch_at_any_width": True}
    arch, stress = flow.arch * fails / unit_weight, flow.flow_factor * fails
    return found | {"arch_up_to_m": arch, "arch_stress_pa": stress}


def closed_forms(design: Design) -> dict[str, Any]:
    """All closed forms of a design."""
    own = Loads(design)
    vessel = own.vessel
    c_h, c_w = own.factors
    return {
        "name": design.name,
        "silo": {
            "plan": vessel.plan,
            "width_m": vessel.width,
            "length_m": vessel.length,
            "height_m": vessel.height,
            "half_angle_deg": None if vessel.is_flat else math.degrees(vessel.half_angle or 0.0),
            "outlet_m": vessel.outlet,
            "outlet_across_m": vessel.outlet_across,
            "area_m2": vessel.area,
            "perimeter_m": vessel.perimeter,
            "characteristic_width_m": vessel.characteristic_width,
            "slenderness": vessel.slenderness,
            "class": vessel.slenderness_class,
            "weight_n": vessel.volume * own.solid.unit_weight,
        },
        "solid": as_numbers(own.solid),
        "rules": own.rules.model_dump(),
        "characteristic": {
            name: _of_values(own, name)
            for name in LOAD_CASES
            if not (vessel.is_flat and "hopper" in name)
        },
        "highest_contact_m": own.highest,
        "C_h": c_h,
        "C_w": c_w,
        "walls": own.wall_table(np.linspace(0.0, vessel.height, _DEPTHS)),
        "patches": {name: one._asdict() for name, one in own.patches().items()},
        "bottom": own.bottom(),
        "jenike": own.jenike(),
        "assumptions": own.assumptions(),
    }


def _of_values(own: Loads, load_case: str) -> Mapping[str, float]:
    values, length = own.values(load_case), own.wall(load_case).length
    return {
        "wall_friction": values.wall_friction,
        "lateral_ratio": values.lateral_ratio,
        "internal_friction_deg": math.degrees(values.internal_friction),
        "janssen_length_m": length,
    }
