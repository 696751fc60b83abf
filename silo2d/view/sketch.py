"""A silo before it is run: walls, outlet, fill level, and the shapes of its particles."""

import numpy as np

from granulab.campaign.output.figure import RULE, WALL
from granulab.campaign.sweeps.sketch import BED, Filled, Panel, particle_beside, side_by_side
from silo2d.case.case import SiloCase
from silo2d.case.plan import expected_particles
from silo2d.case.shape import Shape
from silo2d.view.scene import PARTICLE_EDGE, WOOD

_ALIKE = 1e-9  # difference of shares
_BELOW = 0.05  # of the height, between the floor and the size of the outlet
_WORDS = 0.1  # of the silo, half of the width of words below a particle
_INSERT = RULE


def sketch(case: SiloCase) -> list[Panel]:
    """The silo with its outlet and fill level, and its shapes with their sizes and shares."""
    return [_silo(case), _shapes(case)]


def _silo(case: SiloCase) -> Panel:
    from shapely import box

    outline, level = case.outline, case.settings.fill.level
    corners = outline.polygon
    (left, right), top = (corners[:, 0].min(), corners[:, 0].max()), outline.height
    bed = outline.inside.intersection(box(left, 0.0, right, level))
    filled = [
        Filled(np.array(part.exterior.coords), BED)
        for part in getattr(bed, "geoms", [bed])
        if part.geom_type == "Polygon" and not part.is_empty
    ]
    filled += [Filled(insert, _INSERT, WALL) for insert in outline.inserts]
    mean = max(case.shapes.shapes, key=lambda shape: shape.area)
    particle, words = particle_beside(
        [Filled(mean.rounded_outline(), WOOD[0], PARTICLE_EDGE)], right, 0.0,
        "largest\nparticle", _WORDS * max(outline.width, top),
    )  # fmt: skip
    under, aside = -_BELOW * top, left - _BELOW * top
    (lip, _), (other, _) = outline.lips
    walls, n_doors = outline.walls().segments, len(outline.walls().doors)
    return Panel(
        f"outlet {_mm(outline.outlet)}, {_mm(outline.width)} wide\n"
        f"about {expected_particles(case)} particles, filled to {_mm(level)}",
        filled=[*filled, *particle],
        lines=list(walls[:-n_doors]),
        dashed=[*walls[-n_doors:], np.array([[left, level], [right, level]])],
        spans=[
            ((lip, under), (other, under), _mm(outline.outlet)),
            ((aside, 0.0), (aside, level), f"fill level {_mm(level)}"),
        ],
        words=[words],
    )


def _shapes(case: SiloCase) -> Panel:
    shapes = case.shapes
    alike = max(shapes.shares) - min(shapes.shares) < _ALIKE
    drawn = [
        (
            [Filled(shape.rounded_outline(), WOOD[0], PARTICLE_EDGE)],
            "\n".join([shape.name, *([] if alike else [f"{100 * share:.2g} %"]), _size(shape)]),
        )
        for shape, share in zip(shapes.shapes, shapes.shares, strict=True)
    ]
    number = len(shapes.shapes)
    many = "equally many of each" if alike else "share of the particles"
    return side_by_side(
        f"{shapes.name}: {number} shape{'' if number == 1 else 's'}, mean area "
        f"{1e6 * shapes.mean_area:.0f} mm²\nwidth x length [mm]{f'; {many}' if number > 1 else ''}",
        drawn,
    )


def _size(shape: Shape) -> str:
    points = shape.rounded_outline()
    length = float(np.linalg.norm(points[:, None] - points[None], axis=-1).max())
    return f"{1e3 * shape.width:.3g} x {1e3 * length:.3g}"


def _mm(length: float) -> str:
    return f"{1e3 * length:.6g} mm"
