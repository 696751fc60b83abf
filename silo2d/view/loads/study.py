"""Loads by runs of one silo, over their seeds, compared with Janssen, EN 1991-4 and Jenike."""

import csv
import dataclasses
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from granulab.campaign.runs.folder import RunFolder
from granulab.contact.files.units import located
from granulab.errors import FolderError, InputError
from silo2d.case.case import SiloCase
from silo2d.case.outline import Outline
from silo2d.loads.assess import Loads, closed_forms
from silo2d.loads.design import Design, design_of, load_beside
from silo2d.loads.janssen import Floats
from silo2d.loads.jenike import flow_pattern, mass_flow_limit
from silo2d.loads.solid import find_row
from silo2d.loads.spec import SolidKeys
from silo2d.loads.vessel import Vessel
from silo2d.measures import fields, loads, massflow
from silo2d.measures.basics.contacts import read_moments
from silo2d.measures.basics.particles import prism_length
from silo2d.measures.basics.walls import STRETCH, sides_of
from silo2d.measures.janssen import Column, column, topmost_vertical, vertical_walls
from silo2d.view.loads.pooling import combined, half_width, mean_of, of_stage, stages_of
from silo2d.view.scene import Scene

_LEVEL = {"rules.surface": "level"}  # a filling of the simulation is levelled off
_SLENDEREST = 10.0  # h_c/d_c, for which the standard is made (1.1.2)
_LARGEST_PARTICLE = 0.03  # of d_c, for which the standard is made (1.1.2)
_AT_REST = 0.05  # of the weight, that walls and base lack: A4 has 0.01 to 0.02
_BEAR_NOTHING = 0.005  # of the weight
_ROWS = 13  # stretches of the vertical walls at most
Between = tuple[float, float] | None


def runs_of(path: Path) -> list[Path]:
    """Run folders that a path stands for: itself, or those of a sweep's table."""
    if not (path / "table.csv").is_file():
        return [path]
    with (path / "table.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    found = [path / row["run_folder"] for row in rows if row.get("run_folder")]  # relative to it
    if not found:
        raise FolderError(f"{path / 'table.csv'}: no finished run; run the sweep first")
    return list(dict.fromkeys(found))


def refuse_case(case: SiloCase, between: Between = None) -> None:
    """Raise InputError for a case whose runs would have no loads to compare, before it is run.

    between: window of the flow [s], which must begin before the run ends.
    """
    longest = case.settings.run.max_time
    if between is not None and not between[0] < longest:
        raise InputError(
            f"--between {between[0]:g}: the run ends at {longest:g} s at the latest; begin before, "
            "or give a longer --max-time"
        )
    if case.impulses:
        raise InputError(f"{case.name}: [run] engine = 'pymunk': loads need the contacts of dem")
    walls, level = case.outline.walls(), case.settings.fill.level
    with located(f"{case.name}:"):
        upright = _upright(case.outline)
        _half_angle(walls.segments[: walls.doors[0]], upright)
        _refuse_below(_foot(upright), level, level)


def study(
    folders: Sequence[Path], spec: str | None, changes: Mapping[str, Any], between: Between = None,
    rough_plates: bool = False,
) -> dict[str, Any]:  # fmt: skip
    """Loads by runs that differ in their seed alone, beside the closed forms.

    spec: file with [solid] and [rules], or None; changes: keys of it; between: window of the flow
    [s]. Raises InputError where the runs are of unlike silos, or have no vertical walls.
    """
    cases = [SiloCase.load(folder / "case.toml") for folder in folders]
    _refuse_unlike(folders, cases)
    refuse_case(cases[0])
    eccentric = {"rules.outlet_eccentricity": f"{_eccentricity(cases[0].outline):.9f} m"}
    beside = load_beside(spec, changes, _LEVEL | eccentric)
    moments = read_moments(folders[0])
    scene, own = moments[0].scene, column(moments[:1])
    foot = _foot(scene.walls[vertical_walls(scene)])
    # One for all runs, whose particles differ a little, and as long as makes a page.
    stretch = max(STRETCH * scene.particle_size, (own.fill[0] - foot) / _ROWS)
    each = [loads.measure(folder, between, stretch) for folder in folders]
    dem = combined(each) | _flow_of(folders, between)
    with located(f"{folders[0]}:"):
        vessel = vessel_of(scene, own, prism_length(folders[0]), rough_plates)
    known = _known(cases[0], own, dem["prism_length_m"], dem)
    if "internal_friction" not in known and not (
        beside.solid.name or beside.solid.internal_friction
    ):
        raise InputError(
            f"{folders[0]}: hardly flowed, so that its internal friction is not known; give it, "
            "such as --internal-friction '30 deg'"
        )
    design = design_of(beside, vessel, spec or "the options", known)
    notes = (
        *design.assumptions, *_in_place_of_the_table(beside.solid, known),
        *_notes(scene, vessel, dem),
    )  # fmt: skip
    design = dataclasses.replace(design, name=cases[0].name, assumptions=notes)
    return {
        "case": cases[0].name,
        "silo": cases[0].label,
        "seeds": [case.settings.run.seed for case in cases],
        "runs": [str(folder) for folder in folders],
        "outcomes": [RunFolder(folder).read_summary()["outcome"] for folder in folders],
        "fill_m": own.fill[0],
        "foot_m": foot,
        "dem": dem,
        "closed_forms": closed_forms(design),
        "compared": compared(design, each, own.fill[0], foot),
        "flow": _flow_pattern(design, dem),
    }


def _upright(outline: Outline) -> Floats:
    """The vertical walls (2, 2, 2) [m] of a silo, left and right; InputError where it has none."""
    walls = outline.walls()
    side = sides_of(walls.segments, walls.names, outline.outlet_centre)
    return walls.segments[topmost_vertical(walls.segments, side)]


def _eccentricity(outline: Outline) -> float:
    """Distance of an outlet's middle from that between the vertical walls [m], the largest."""
    middle = float(_upright(outline)[:, 0, 0].mean())
    others = [float(ends[:, 0].mean()) for ends in outline.outlets]
    return max(abs(x - middle) for x in (outline.outlet_centre, *others))


def _refuse_unlike(folders: Sequence[Path], cases: Sequence[SiloCase]) -> None:
    for folder, case in zip(folders, cases, strict=True):
        one = case.settings.model_dump(exclude={"run": {"seed"}, "output": True})
        if one != cases[0].settings.model_dump(exclude={"run": {"seed"}, "output": True}):
            raise InputError(
                f"{folder}: differs from {folders[0]} in more than its seed; loads are a mean over "
                "seeds: give runs of one case"
            )


def _notes(scene: Scene, vessel: Vessel, dem: Mapping[str, Any]) -> list[str]:
    """Properties of the runs that are not those the closed forms are made for."""
    found, size = [], scene.particle_size
    n = max(stage["runs"] for stage in dem["stages"].values())
    found += [
        f"{name.replace('_', ' ')}: of {stage['runs']} of {n} runs, which have one"
        for name, stage in dem["stages"].items()
        if stage["runs"] < n
    ]
    if size > _LARGEST_PARTICLE * vessel.characteristic_width:
        found.append(
            f"particles of {1e3 * size:.3g} mm: the standard is made for at most 0.03 d_c, "
            f"{30 * vessel.characteristic_width:.3g} mm (1.1.2)"
        )
    if vessel.slenderness >= _SLENDEREST:
        found.append(
            f"h_c/d_c = {vessel.slenderness:.1f}: the standard is made for below 10 (1.1.2)"
        )
    rest = dem["stages"]["at_rest"]["balance"]
    if abs(rest["inertia_share"]) > _AT_REST:
        found.append(
            f"at rest the fill still accelerates, by {100 * rest['inertia_share']:.0f} % of its "
            "weight in the mean: friction at the walls is not what it comes to; let it settle "
            "longer ([fill] settled, below 1e-4)"
        )
    if abs(rest["walls_share"]) < _BEAR_NOTHING:
        found.append(
            "filled without friction: at rest the walls bear nothing, the stress is hydrostatic, "
            "and no law of the closed forms holds ([fill] friction = true fills with it)"
        )
    return found


def _in_place_of_the_table(solid: SolidKeys, known: Mapping[str, float]) -> list[str]:
    """Line on properties of the runs that stand in place of those of a named solid."""
    if solid.name is None:
        return []
    row, found = find_row(solid.name), []
    for name, words, unit, factor in (
        ("unit_weight", "unit weight", "kN/m3", 1e-3),
        ("internal_friction", "internal friction", "deg", math.degrees(1.0)),
    ):
        if name in known and getattr(solid, name) is None:
            of_table = factor * getattr(row, name)
            found.append(f"{words} {factor * known[name]:.3g} {unit} (table: {of_table:.3g})")
    if not found:
        return []
    return [
        f"of the runs, not of {solid.name} in table E.1: {', '.join(found)}; give them for others"
    ]


def _known(case: SiloCase, own: Column, length: float, dem: Mapping[str, Any]) -> dict[str, float]:
    """Properties of the solid that the case and its runs have, as [solid] takes them."""
    known = {"unit_weight": own.density / length}
    friction = getattr(case.wall_law, "mu", None)  # a law from outside may have none
    if friction is not None:
        known["wall_friction"] = float(friction)
    angle = dem["effective_friction_deg"]
    if angle is not None:
        known |= dict.fromkeys(("internal_friction", "effective_friction"), math.radians(angle))
    return known


def vessel_of(scene: Scene, own: Column, length: float, rough_plates: bool) -> Vessel:
    """The vessel that a run's silo is: a slot, filled to its level surface."""
    (left, _), (right, _) = scene.trajectory.attributes["lips"]
    upright = scene.walls[vertical_walls(scene)]
    foot, level = _foot(upright), scene.trajectory.attributes["level"]
    _refuse_below(foot, own.fill[0], level)
    return Vessel(
        "slot", own.width, length, own.fill[0] - foot, _half_angle(scene.walls, upright),
        float(right - left), "wedge", rough_plates=rough_plates,
    )  # fmt: skip


def _refuse_below(foot: float, surface: float, level: float) -> None:
    """Raise InputError unless the surface of a filling lies above the foot of the walls [m]."""
    if not surface > foot:
        raise InputError(
            f"[fill] level = {level:.4g} m: lies no higher than the foot of its vertical walls, "
            f"{foot:.4g} m, which bear nothing; fill it higher, such as --fill-level "
            f"'{2 * foot:.2g} m', or take silo2d observe RUN loads, which needs no such walls"
        )


def _foot(upright: Floats) -> float:
    """Height of the foot of the vertical walls (2, 2, 2) [m], the higher of the two."""
    return float(upright[:, :, 1].min(axis=1).max())


def _half_angle(walls: Floats, upright: Floats) -> float | None:
    """Half angle [rad] of the walls that go on below the vertical ones; None of a floor.

    Raises InputError where they end over a window, or their sides converge at unlike angles.
    """
    angles: list[float] = []
    for wall in upright:
        foot, before = min(wall, key=lambda end: end[1]), len(angles)
        for other in walls:
            ends = np.abs(other - foot).max(axis=1) < 1e-9
            run, rise = np.abs(other[1] - other[0])
            if ends.any() and run > 1e-9:
                angles.append(math.atan2(run, rise))
        if len(angles) == before and foot[1] > 0:  # at 0 it ends at a lip of the outlet
            raise InputError(
                f"[silo] outlets: an outlet in a vertical wall, below {foot[1]:.4g} m, which the "
                "closed forms do not know; silo2d observe RUN loads gives the runs' part alone"
            )
    if not angles:
        return None
    if max(angles) - min(angles) > math.radians(0.1):
        first, second = (f"{math.degrees(one):.3g} deg" for one in (min(angles), max(angles)))
        raise InputError(
            f"its sides converge at unlike angles, {first} and {second} from the vertical, and the "
            "closed forms are symmetric; silo2d observe RUN loads gives the runs' part alone"
        )
    return None if math.isclose(angles[0], math.pi / 2) else angles[0]


def _flow_of(folders: Sequence[Path], between: Between) -> dict[str, Any]:
    """Mass flow index and dead zones, means over runs; None of runs that hardly flowed."""
    flowed: list[dict[str, Any]] = []
    zones: dict[str, list[float | None]] = {
        key: [] for key in ("dead_area_m2", "dead_share", "left_area_m2", "left_share")
    }
    for folder in folders:
        try:
            flowed.append(massflow.measure(folder, between=between))
            own = fields.measure(folder, between)
        except InputError:  # fewer than twenty particles left
            continue
        for key, values in zones.items():
            values.append(own[key])
    index, error = massflow.lowest_over(flowed) or (None, None)
    return {
        "mass_flow_index": index,
        "mass_flow_index_error": error,
        **{key: mean_of(values) for key, values in zones.items()},
    }


def compared(
    design: Design, each: Sequence[Mapping[str, Any]], fill: float, foot: float
) -> list[dict[str, float | None]]:
    """Pressures on the vertical walls by depth [Pa]: the runs', Janssen's, the standard's.

    each: loads of the runs, by whose mean half widths of intervals go where there are several;
    fill, foot: heights [m] of the surface before the opening and of the walls' foot.
    """
    own, rows = Loads(design), []
    names = stages_of(each)
    profiles = {
        name: [loads.profile(stage, "normal_pa") for stage in of_stage(each, name)]
        for name in names
    }
    sides = {
        name: {
            side: [loads.profile(stage, "normal_pa", side) for stage in of_stage(each, name)]
            for side in ("left", "right")
        }
        for name in names
    }
    for k, height in enumerate(profiles[names[0]][0][0]):
        if not foot <= height < fill:
            continue
        table = own.wall_table(np.array([fill - height]))
        row: dict[str, float | None] = {"height_m": float(height), "depth_m": float(fill - height)}
        for name, several in profiles.items():
            values = [float(one[1][k]) for one in several]
            row[f"{name}_pa"] = float(np.mean(values))
            row[f"{name}_half_width_pa"] = half_width(values) if len(values) > 1 else None
            for side, lists in sides[name].items():
                near = [float(np.interp(height, at, value)) for at, value, _ in lists]
                row[f"{name}_{side}_pa"] = float(np.mean(near))
        row |= {
            "janssen_pa": table["janssen_horizontal_pa"][0],
            "en_filling_pa": table["filling_horizontal_pa"][0],
            "en_discharge_pa": table["discharge_horizontal_pa"][0],
        }
        rows.append(row)
    return rows[::-1]


def _flow_pattern(design: Design, dem: Mapping[str, Any]) -> dict[str, Any]:
    """Jenike's verdict over the interval of the measured friction, beside the mass flow index."""
    half = design.vessel.half_angle
    beta = math.pi / 2 if half is None else half
    wall = math.atan(design.solid.hopper_friction)
    given = [dem["effective_friction_low_deg"], dem["effective_friction_high_deg"]]
    ends = [math.radians(a) for a in given if a is not None] or [design.solid.effective_friction]
    limits = [mass_flow_limit(delta, wall, design.vessel.hopper == "wedge") for delta in ends]
    index, error = dem["mass_flow_index"], dem["mass_flow_index_error"]
    return {
        "jenike": flow_pattern(beta, mass_flow_limit(
            design.solid.effective_friction, wall, design.vessel.hopper == "wedge")),
        "jenike_over_interval": list(dict.fromkeys(flow_pattern(beta, one) for one in limits)),
        "mass_flow_up_to_deg": [math.degrees(one) for one in limits],
        "mass_flow_index": index,
        "by_index": massflow.flow_by(index, error),
    }  # fmt: skip
