"""A damper before it is run: enclosure, the level that its bed is expected to have, particles."""

import numpy as np
from numpy.typing import NDArray

from damper3d.case.case import DamperCase
from damper3d.case.level import level_of
from damper3d.case.random_packing import CLOSE_PACKING, LOOSE_PACKING, close_packing, loose_packing
from damper3d.shapes.multisphere import MultiSphere
from damper3d.view.scene import view_of
from damper3d.view.shape import lit_triangles
from damper3d.view.spheres import section
from granulab.campaign.sweeps.sketch import (
    BED,
    Filled,
    Panel,
    lit,
    particle_beside,
    side_by_side,
)

Array = NDArray[np.float64]

_FEW = 6  # kinds that are drawn


def sketch(case: DamperCase) -> list[Panel]:
    """Enclosure with the level of its bed, and particles with their sizes, of each damper."""
    dampers = case.dampers or (case,)
    return [panel for one in dampers for panel in (_enclosure(one), _particles(one))]


def fractions(case: DamperCase) -> tuple[float, float, str]:
    """Packing fractions between which the bed is expected, and what they are of."""
    name = case.particle.name
    close, loose = close_packing(name), loose_packing(name)
    if close is None:
        return LOOSE_PACKING, CLOSE_PACKING, "as of spheres"
    ratio = LOOSE_PACKING / CLOSE_PACKING  # of spheres; that of another shape is not known
    words = "random loose to close"
    return close.value * ratio if loose is None else loose.value, close.value, words


def _enclosure(case: DamperCase) -> Panel:
    enclosure, view = case.enclosure, view_of(case.gravity, case.direction)
    lines = section(enclosure, view)
    everything = np.concatenate(lines)
    (left, bottom), (right, top) = everything.min(axis=0), everything.max(axis=0)
    filled, dashed, words = _bed(case, lines)
    shape, beside = particle_beside(_lit(case.particle), right, bottom, "particle")
    aside, under = left - 0.06 * (right - left), bottom - 0.06 * (top - bottom)
    return Panel(
        f"{case.count} particles, fill ratio {case.fill_ratio:.3f}, {_moved(case)}\n{words}",
        filled=[*filled, *shape],
        lines=lines,
        dashed=dashed,
        spans=[
            ((left, under), (right, under), _mm(right - left)),
            ((aside, bottom), (aside, top), _mm(top - bottom)),
        ],
        words=[beside],
    )


def _bed(case: DamperCase, lines: list[Array]) -> tuple[list[Filled], list[Array], str]:
    """Parts of a section that the bed covers, lines at its levels, and words on these."""
    strength = float(np.linalg.norm(case.gravity))
    if strength == 0.0:
        return [], [], "without gravity the bed has no level"
    up, volume = -case.gravity / strength, case.count * case.particle.volume
    loose, close, of = fractions(case)
    ends = [min(volume / part, case.enclosure.volume) for part in (close, loose)]
    levels = [level_of(case.enclosure, up, end) for end in ends]
    view = view_of(case.gravity, case.direction)
    depth = float(view.project(np.array([0.0, 0.0, case.enclosure.height / 2]))[2])
    along = np.array([up @ view.right, up @ view.up])
    offset = depth * float(up @ view.nearer)
    covered = [_below(lines, along, level - offset) for level in levels]
    filled = [Filled(points, BED) for points in covered[1][0]]
    floor = case.enclosure.lowest(up)
    heights = " to ".join(f"{1e3 * (level - floor):.3g}" for level in levels)
    words = f"bed expected to {heights} mm (packing {loose:.3g} to {close:.3g},\n{of})"
    return filled, [line for _, tops in covered for line in tops], words


def _below(lines: list[Array], up: Array, level: float) -> tuple[list[Array], list[Array]]:
    """Areas within closed lines below a level along `up` (2,), and the lines at the level."""
    from shapely import LineString, MultiLineString, Polygon, build_area

    inside = build_area(MultiLineString(lines))
    size = 4.0 * float(np.ptp(np.concatenate(lines), axis=0).max()) + 1e-9
    side = np.array([up[1], -up[0]])
    middle = np.concatenate(lines).mean(axis=0)
    at = middle + (level - middle @ up) * up
    ends = [at - size * side, at + size * side]
    half = Polygon([*ends, ends[1] - 2 * size * up, ends[0] - 2 * size * up])
    below, tops = inside.intersection(half), inside.intersection(LineString(ends))
    return (
        [np.array(p.exterior.coords) for p in _parts(below, "Polygon")],
        [np.array(line.coords) for line in _parts(tops, "LineString")],
    )


def _parts(geometry: object, kind: str) -> list:
    found = getattr(geometry, "geoms", [geometry])
    return [part for part in found if part.geom_type == kind and not part.is_empty]


def _particles(case: DamperCase) -> Panel:
    if case.bed is None:
        size = np.ptp(case.particle.surface.vertices, axis=0)
        density = f"{case.density:g} kg/m³"
        return side_by_side(
            f"{case.particle.name}: {case.particle_mass * 1e3:.3g} g each, {density}",
            [(_lit(case.particle), " x ".join(f"{1e3 * d:.3g}" for d in size) + " mm")],
        )
    shapes = []
    for sort in case.bed.sorts[:_FEW]:
        low, mean, high = (2e3 * f(sort.radius) for f in (np.min, np.mean, np.max))
        span = f"{low:.3g} to {high:.3g} mm" if high > low else f"{mean:.3g} mm"
        drawn = _lit(sort.of_size(float(sort.radius.mean())))
        shapes.append((drawn, f"{len(sort.radius)} of {sort.material.name}\n{span}"))
    what = "spheres" if case.bed.of_spheres else "particles"
    return side_by_side(f"{len(case.bed.sorts)} kinds of {what}, each at its mean size", shapes)


def _lit(particle: MultiSphere) -> list[Filled]:
    triangles, light = lit_triangles(particle)
    colours = lit(light)
    return [Filled(p, c, c) for p, c in zip(triangles, colours, strict=True)]


def _moved(case: DamperCase) -> str:
    return {"none": "no gravity"}.get(case.orientation, f"{case.orientation} motion")


def _mm(length: float) -> str:
    return f"{1e3 * length:.4g} mm"
