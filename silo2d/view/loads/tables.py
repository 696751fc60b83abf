"""Loads in facts and tables, which the report prints and the sheet sets."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from silo2d.measures.basics.balance import PARTS

_LOAD_CASES = {
    "wall_pressure": "pressure on the wall",
    "wall_friction": "friction on the wall",
    "bottom": "load on the bottom",
    "hopper_filling": "hopper, filling",
    "hopper_discharge": "hopper, discharge",
}
_EVERY = 4  # of the points of a series, which is printed
_COHESIONLESS = "no cohesion given: no cohesive arch, no rathole"


class Fact(NamedTuple):
    """A line: a name and words."""

    name: str
    words: str


class Table(NamedTuple):
    """A table of texts, with what it shows."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]


Part = Fact | Table


def pressure(value: float | None) -> str:
    """A pressure in kPa as engineers write it, three digits."""
    return "-" if value is None else f"{value / 1e3:#.3g}".rstrip(".")


def facts_of(forms: Mapping[str, Any]) -> list[Part]:
    """The silo, its solid and its class."""
    silo, solid = forms["silo"], forms["solid"]
    size = f"{silo['width_m']:.4g} m" + (
        "" if silo["plan"] == "circular" else f" x {silo['length_m']:.4g} m"
    )
    hopper = (
        "flat bottom" if silo["half_angle_deg"] is None
        else f"hopper {silo['half_angle_deg']:.3g} deg from the vertical"
    )  # fmt: skip
    return [
        Fact("silo", f"{silo['plan']}, {size}, walls {silo['height_m']:.4g} m high, {hopper}, "
                     f"outlet {silo['outlet_m']:.3g} m{_off_the_middle(forms)}; holds "
                     f"{_force(silo['weight_n'])}"),
        Fact("solid", f"{solid['name']}: {solid['unit_weight_n_per_m3'] / 1e3:.3g} kN/m3, "
                      f"repose {_degrees(solid['repose_rad'])}, internal friction "
                      f"{_degrees(solid['internal_friction_rad'])}, K "
                      f"{solid['lateral_ratio']:.3g}, wall friction {solid['wall_friction']:.3g}, "
                      f"C_op {solid['patch']:.2g}"),
        Fact("class", f"{silo['class']}, h_c/d_c = {silo['slenderness']:.2f}; action assessment "
                      f"class {forms['rules']['assessment_class']}; h_o = "
                      f"{forms['highest_contact_m']:.3g} m"),
    ]  # fmt: skip


def _off_the_middle(forms: Mapping[str, Any]) -> str:
    """Words on an outlet that is not in the middle."""
    off = forms["rules"]["outlet_eccentricity"]
    part = off / forms["silo"]["characteristic_width_m"]
    return f", {off:.3g} m ({part:.2f} d_c) off the middle" if off else ""


def _degrees(angle: float) -> str:
    return f"{angle * 57.29577951308232:.3g} deg"


def _force(newtons: float) -> str:
    return f"{newtons / 1e3:.4g} kN" if newtons >= 1e3 else f"{newtons:.3g} N"


def characteristic_table(forms: Mapping[str, Any]) -> Table:
    """Characteristic values by load case."""
    rows = [
        (_LOAD_CASES[name], f"{one['wall_friction']:.3f}", f"{one['lateral_ratio']:.3f}",
         f"{one['internal_friction_deg']:.1f}", f"{one['janssen_length_m']:.2f}")
        for name, one in forms["characteristic"].items()
    ]  # fmt: skip
    if len({row[1:] for row in rows}) == 1:  # without scatter, or means
        rows = [("all load cases", *rows[0][1:])]
    return Table("characteristic values (table 3.1)",
                 ("load case", "mu", "K", "phi_i [deg]", "z_o [m]"), rows)  # fmt: skip


def wall_table(forms: Mapping[str, Any]) -> Table:
    """Pressures on the walls by depth, EN 1991-4, with Janssen by mean properties."""
    walls = forms["walls"]
    keys = ("janssen_horizontal_pa", "filling_horizontal_pa", "filling_friction_pa",
            "filling_vertical_pa", "discharge_horizontal_pa", "discharge_friction_pa")  # fmt: skip
    rows = [
        (f"{depth:.3g}", *(pressure(walls[key][k]) for key in keys))
        for k, depth in enumerate(walls["depth_m"])
        if k % _EVERY == 0
    ]
    return Table(
        f"vertical walls [kPa]; discharge: C_h = {forms['C_h']:.3f}, C_w = {forms['C_w']:.3f}",
        ("z [m]", "Janssen", "p_hf", "p_wf", "p_vf", "p_he", "p_we"),
        rows,
    )


def patch_facts(forms: Mapping[str, Any]) -> list[Part]:
    """Patch loads in words."""
    found: list[Part] = []
    for name, one in forms["patches"].items():
        if not one["factor"]:
            found.append(Fact(f"patch, {name}", "none: C_p = 0"))
            continue
        words = (f"C_p = {one['factor']:.3f}: {pressure(one['pressure'])} kPa over "
                 f"{one['side']:.3g} m, governing at z = {one['depth']:.3g} m")  # fmt: skip
        if one["inward"]:
            words += f", inwards {pressure(one['inward'])} kPa"
        if one["force"]:
            words += f"; resultant {one['force'] / 1e3:.3g} kN"
        found.append(Fact(f"patch, {name}", words))
    return found


def bottom_parts(forms: Mapping[str, Any]) -> list[Part]:
    """Load on the bottom, or the hopper's pressures."""
    own = forms["bottom"]
    if own["kind"] == "flat":
        return [Fact("bottom", f"flat: {pressure(own['vertical_pa'])} kPa, C_b = {own['C_b']:g}")]
    filling, discharge = own["filling"], own["discharge"]
    rows = [
        (f"{x:.3g}", *(pressure(side[key][k]) for side in (filling, discharge)
                       for key in ("vertical_pa", "normal_pa", "friction_pa")))
        for k, x in enumerate(filling["height_m"]) if k % (2 * _EVERY) == 0
    ]  # fmt: skip
    return [
        *_steepness(own),
        Fact("bottom", f"{own['kind']} hopper: {pressure(own['vertical_at_transition_pa'])} kPa at "
                       f"the transition, C_b = {own['C_b']:g}; F_f = {filling['F']:.3f}, F_e = "
                       f"{discharge['F']:.3f}, mu_eff = {discharge['effective_friction']:.3f}"),
        Table("hopper [kPa], x above its apex",
              ("x [m]", "p_v fill", "p_nf", "p_tf", "p_v disch", "p_ne", "p_te"), rows),
    ]  # fmt: skip


def _steepness(own: Mapping[str, Any]) -> list[Part]:
    """Steep or shallow, where that hangs on the scatter of the properties."""
    if not own["steepness_differs"]:
        return []
    return [
        Fact("steep hopper", f"up to {own['steep_up_to_deg']:.3g} deg by the lower values of K and "
                             "mu_h, which decide (6.1.1); by the upper ones up to "
                             f"{own['steep_up_to_by_upper_values_deg']:.3g} deg, and this one "
                             "would be shallow"),
    ]  # fmt: skip


def jenike_facts(forms: Mapping[str, Any]) -> list[Part]:
    """Flow and outlets after Jenike."""
    own = forms["jenike"]
    shape = "plane" if own["plane"] else "conical"
    found: list[Part] = [
        Fact("Jenike", f"{own['flow']}: half angle {own['half_angle_deg']:.3g} deg, mass flow up "
                       f"to {own['mass_flow_up_to_deg']:.3g} deg less 3 ({shape}; delta "
                       f"{own['effective_friction_deg']:.3g} deg, wall "
                       f"{own['wall_friction_deg']:.3g} deg)")
    ]  # fmt: skip
    factor = own["flow_factor"]
    words = "" if factor is None else f"flow factor {factor:.2f}; "
    if own["cohesionless"]:
        return [*found, Fact("outlet", words + _COHESIONLESS)]
    found.append(Fact("outlet", words + _arch_in_words(own, forms["silo"]["outlet_m"])))
    if own["flow"] != "mass flow":
        up_to, across = own["rathole_up_to_m"], forms["silo"]["outlet_across_m"]
        enough = "wide enough" if across > up_to else "too narrow"
        found.append(Fact("rathole", f"up to {up_to:.3g} m across: the outlet, {across:.3g} m "
                                     f"across, is {enough}"
                                     + _extrapolated(own, own["rathole_stress_pa"])))  # fmt: skip
    return found


def _arch_in_words(own: Mapping[str, Any], outlet: float) -> str:
    """The widest arch, compared with the outlet [m]."""
    if own["arch_not_computed"]:
        return f"arches not computed: {own['arch_not_computed']}"
    if own["arch_at_any_width"]:
        return f"arches at any width: {outlet:.3g} m is too narrow" + _extrapolated(own, math.inf)
    arch = own["arch_up_to_m"]
    enough = "wide enough" if outlet > arch else "too narrow"
    return f"arches up to {arch:.3g} m: {outlet:.3g} m is {enough}" + _extrapolated(
        own, own["arch_stress_pa"]
    )


def _extrapolated(own: Mapping[str, Any], stress: float) -> str:
    """Words where a strength is taken beyond the last point of the flow function."""
    last = own["strength_known_up_to_pa"]
    if stress <= last:
        return ""
    at = "" if math.isinf(stress) else f" at {pressure(stress)} kPa"
    return f"; strength{at} extrapolated beyond its last point, {pressure(last)} kPa"


def closed_parts(forms: Mapping[str, Any]) -> list[Part]:
    """All closed forms of a silo, but for its facts."""
    return [
        characteristic_table(forms), wall_table(forms), *patch_facts(forms), *bottom_parts(forms),
        *jenike_facts(forms),
    ]  # fmt: skip


def pascal(value: float | None) -> str:
    """A pressure in whole pascals."""
    return "-" if value is None else f"{no_sign(value, 0):.0f}"


def run_parts(found: Mapping[str, Any]) -> list[Part]:
    """Loads by runs: pressures compared with the closed forms, fluctuation, balance, flow."""
    dem = found["dem"]
    return [
        compared_table(found), *fluctuation_facts(dem), balance_table(dem), *flow_facts(found)
    ]  # fmt: skip


def compared_table(found: Mapping[str, Any]) -> Table:
    """Pressures on the vertical walls by depth."""
    stages = [name for name in ("filling", "at_rest", "opening", "flow", "end")
              if name in found["dem"]["stages"]]  # fmt: skip
    shown, eccentric = stages[-1], found["closed_forms"]["rules"]["outlet_eccentricity"] > 0
    shown = "flow" if "flow" in stages else shown
    keys = [*stages, "janssen", "en_filling", "en_discharge"]
    if "flow" in stages and len(found["runs"]) > 1:
        keys.insert(stages.index("flow") + 1, "flow_half_width")
    if eccentric:
        at = stages.index(shown) + 1
        keys[at:at] = [f"{shown}_left", f"{shown}_right"]
    rows = [
        (f"{row['depth_m']:.3f}", *(pascal(row[f"{key}_pa"]) for key in keys))
        for row in found["compared"]
    ]
    names = {
        "janssen": "Janssen", "en_filling": "EN fill", "en_discharge": "EN disch",
        "flow_half_width": "+-", f"{shown}_left": "left", f"{shown}_right": "right",
    }  # fmt: skip
    head = ("z [m]", *(names.get(key, key.replace("_", " ")) for key in keys))
    title = "pressure on the vertical walls [Pa], mean of both sides"
    if eccentric:
        title += f"; {shown.replace('_', ' ')} also left and right of the outlet"
    return Table(title, head, rows)


def fluctuation_facts(dem: Mapping[str, Any]) -> list[Part]:
    """The largest fluctuation of each stage that lasts, with its area and time."""
    found: list[Part] = []
    for name in ("opening", "flow"):
        walls = dem["stages"].get(name, {"walls": []})["walls"]
        known = [wall for wall in walls if wall["averaged_rms_pa"] is not None]
        if not known:
            continue
        worst = max(known, key=lambda wall: max(wall["averaged_rms_pa"]))
        k = int(max(range(len(worst["averaged_rms_pa"])), key=worst["averaged_rms_pa"].__getitem__))
        half = worst.get("normal_half_width_pa")
        spread = f" +- {half[k]:.0f}" if half else ""
        found.append(Fact(
            name, f"largest fluctuation at the {worst['name']}, {worst['height_m'][k]:.3f} m high: "
            f"mean {worst['normal_pa'][k]:.0f}{spread} Pa, rms {worst['averaged_rms_pa'][k]:.0f}, "
            f"peak {worst['averaged_peak_pa'][k]:.0f} Pa over {1e4 * worst['area_m2']:.0f} cm2 and "
            f"{1e3 * dem['averaged_s']:g} ms; single samples rms {worst['rms_pa'][k]:.0f}, peak "
            f"{worst['peak_pa'][k]:.0f} Pa"
        ))  # fmt: skip
    return found


def balance_table(dem: Mapping[str, Any]) -> Table:
    """Shares of the weight that walls and base bear."""
    known = {name: stage["balance"] for name, stage in dem["stages"].items() if stage["balance"]}
    parts = [part for part in (*PARTS, "inertia")
             if part != "inserts" or any(own["inserts_n"] for own in known.values())]  # fmt: skip
    rows = []
    for name, own in known.items():
        shares = (f"{no_sign(100 * own[f'{part}_share'], 1):.1f}" for part in parts)
        rows.append((name.replace("_", " "), f"{own['weight_n']:.3g}", *shares,
                     f"{no_sign(100 * own['closure'], 2):.2f}"))  # fmt: skip
    names = {"walls": "friction", "inertia": "accelerates"}
    return Table(
        "base and walls against the weight [% of it]",
        ("stage", "weight [N]", *(names.get(part, part) for part in parts), "error"),
        rows,
    )


def no_sign(value: float, digits: int) -> float:
    """A value rounded, without a sign where it is zero."""
    return round(value, digits) + 0.0


def flow_facts(found: Mapping[str, Any]) -> list[Part]:
    """Effective friction, Jenike's verdict and the mass flow index, dead zones."""
    dem, flow = found["dem"], found["flow"]
    parts: list[Part] = []
    clogged = sum(one.startswith("clogged") for one in found["outcomes"])
    if clogged:
        parts.append(Fact(
            "clogged", f"{clogged} of {len(found['outcomes'])} runs: particles arch over the "
            "outlet by their size, without cohesion too (silo2d clog says how often)"
        ))  # fmt: skip
    if dem["effective_friction_deg"] is not None:
        low, high = dem["effective_friction_low_deg"], dem["effective_friction_high_deg"]
        between = "" if low is None else f" ({low:.1f} to {high:.1f})"
        words = f"effective friction {dem['effective_friction_deg']:.1f}{between} deg"
        verdicts = " or ".join(flow["jenike_over_interval"])
        ends = [f"{one:.1f}" for one in sorted(flow["mass_flow_up_to_deg"])]
        limits = " to ".join(dict.fromkeys(ends))
        parts.append(Fact("measured", f"{words}: {verdicts} after Jenike (limit {limits} deg)"))
    if flow["mass_flow_index"] is not None:
        parts.append(
            Fact(
                "by the runs",
                f"{flow['by_index']}: lowest mass flow index "
                f"{no_sign(flow['mass_flow_index'], 2):.2f} +- "
                f"{dem['mass_flow_index_error']:.2f} (limit 0.3)",
            )
        )
    if dem["dead_share"] is not None:
        left = "" if dem["left_share"] is None else (
            f"; left at the end {1e4 * dem['left_area_m2']:.0f} cm2, "
            f"{100 * dem['left_share']:.1f} %"
        )  # fmt: skip
        words = (f"in the flow {1e4 * dem['dead_area_m2']:.0f} cm2, "
                 f"{100 * dem['dead_share']:.1f} % of the silo{left}")  # fmt: skip
        parts.append(Fact("dead zones", words))
    return parts
