"""Up to which overlap sub-spheres stand for a lying toroid or prolate (eqs 5.18-5.20, Fig. 5.12).

The thesis takes the depth of the grooves. Here it is compared with the overlap at which the sum of
the sub-spheres' forces is that of the smooth toroid; both depend on shape and number alone, but
for Poisson's ratio (steel's), by which a ring widens.
"""

from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.shapes.multisphere import MultiSphere
from damper3d.shapes.prolate import prolate
from damper3d.shapes.surfaces.grooves import groove_depth, limit_of_ring, most_sub_spheres
from damper3d.shapes.toroid import fewest_sub_spheres, toroid
from damper3d.studies.single_contact import Found
from damper3d.studies.single_contact.particles.smooth_body import Elastic, ellipse, ring_force
from damper3d.studies.single_contact.particles.steel_shapes import RING, TUBE, steel
from granulab.campaign.output.figure import BLUE, GREEN, GREY, ORANGE, VERMILION, headline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HOLES = (0.05, 0.2, 0.33, (RING - TUBE) / (RING + TUBE))  # those of chapter 8, and Fig. 5.9's
RATIOS = (1.5, 2.0, 3.0)  # a/b of prolates
_OVERLAPS = np.geomspace(2e-4, 5e-2, 60)  # over the tube's diameter
_PROLATE_NUMBERS = (11, 15, 21, 31, 41, 51, 71, 101, 151)
_COLOURS = (BLUE, VERMILION, GREEN, ORANGE)


def compute() -> Found:
    """Curves of both limits; the toroid of Fig. 5.9 and prolates of 51 sub-spheres as numbers."""
    material, _ = steel()
    rows = [row for hole in HOLES for row in _ring_rows(hole, material)]
    rows += [row for ratio in RATIOS for row in _prolate_rows(ratio)]
    outer = RING - TUBE  # the ring's radius if the 3 mm are the outer one
    numbers: dict[str, Any] = {
        "toroid of 50": {
            "eq_5_19_m": limit_of_ring(RING, TUBE, 50),
            "groove_depth_m": _depth(toroid_of(RING, TUBE, 50)),
            "sum_is_smooth_at_m": sum_is_smooth_at(RING, TUBE, 50, material),
            "eq_5_19_over_diameter": limit_of_ring(RING, TUBE, 50) / (2 * TUBE),
        },
        "toroid of 50, 3 mm taken as its outer radius": {
            "eq_5_19_m": limit_of_ring(outer, TUBE, 50),
            "sum_is_smooth_at_m": sum_is_smooth_at(outer, TUBE, 50, material),
            "eq_5_19_over_diameter": limit_of_ring(outer, TUBE, 50) / (2 * TUBE),
        },
        "printed": {"eq_5_19_over_diameter": 2.5e-3},
    }
    for ratio in RATIOS:
        made = prolate(ratio, 51)
        numbers[f"prolate {ratio:g} of 51"] = {
            "groove_under_wall_over_diameter": _depth(made) / (2 * float(made.radii.max())),
            "deepest_groove_over_diameter": made.surface_error / (2 * float(made.radii.max())),
        }
    remark = "the diameter of a toroid is its tube's, that of a prolate the one across its axis"
    return Found(numbers, rows, (remark,))


def toroid_of(distance: float, tube: float, number: int) -> MultiSphere:
    """A toroid by its two radii [m]."""
    made = toroid((distance - tube) / (distance + tube), number)
    return made.scaled(tube / float(made.radii[0]))


def sum_is_smooth_at(distance: float, tube: float, number: int, material: Elastic) -> float:
    """The overlap [m] at which sub-spheres' forces add up to that of the smooth lying toroid."""
    from scipy.optimize import brentq

    sphere = ellipse(material, tube, tube).hertz

    def excess(overlap: float) -> float:
        smooth = ring_force(material, distance, tube, np.array([overlap]))[0]
        return number * sphere * overlap**1.5 / smooth - 1.0

    return float(brentq(excess, 1e-9 * tube, 0.2 * tube))


def _depth(particle: MultiSphere) -> float:
    depth = groove_depth(particle)
    assert depth is not None
    return depth


def _ring_rows(hole: float, material: Elastic) -> list[dict[str, Any]]:
    """Number of sub-spheres with grooves as deep as an overlap, and the smooth body's force."""
    distance, tube = (1.0 + hole) / (1.0 - hole) * TUBE, TUBE
    overlaps = _OVERLAPS * 2 * tube
    sphere = ellipse(material, tube, tube).hertz
    smooth = ring_force(material, distance, tube, overlaps)
    return [
        {
            "shape": f"toroid {hole:.2f}",
            "overlap_over_diameter": float(share),
            "eq_5_20": most_sub_spheres(distance, tube, float(overlap)),
            "sum_is_smooth": float(force / (sphere * overlap**1.5)),
            "fewest": fewest_sub_spheres(hole),
        }
        for share, overlap, force in zip(_OVERLAPS, overlaps, smooth, strict=True)
    ]


def _prolate_rows(ratio: float) -> list[dict[str, Any]]:
    found = []
    for number in _PROLATE_NUMBERS:
        made = prolate(ratio, number)
        diameter = 2 * float(made.radii.max())
        found.append(
            {
                "shape": f"prolate {ratio:g}", "sub_spheres": number,
                "groove_under_wall_over_diameter": _depth(made) / diameter,
                "deepest_groove_over_diameter": made.surface_error / diameter,
            }
        )  # fmt: skip
    return found


def draw(found: Found) -> "Figure":
    """Fig. 5.12, and the grooves of prolates."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.5, 4.6), layout="constrained")
    rings, rows = figure.subplots(1, 2)
    for colour, hole in zip(_COLOURS, HOLES, strict=True):
        mine = [row for row in found.rows if row["shape"] == f"toroid {hole:.2f}"]
        mine = [row for row in mine if row["eq_5_20"] >= row["fewest"]]
        x = [1e3 * row["overlap_over_diameter"] for row in mine]
        label = f"hole ratio {hole:.2f}"
        rings.plot(x, [row["eq_5_20"] for row in mine], color=colour, label=label)
        rings.plot(x, [row["sum_is_smooth"] for row in mine], color=colour, ls="--")
    _two_lines(rings, "grooves as deep (eq. 5.20)", "sum as stiff as the smooth body")
    rings.set(xscale="log", yscale="log", xlabel="overlap / diameter of the tube [10\u207b\u00b3]",
              ylabel="sub-spheres at most [-]")  # fmt: skip
    rings.set_title("toroids lying on a flat wall", fontsize=9, loc="left")
    for colour, ratio in zip(_COLOURS, RATIOS, strict=False):
        mine = [row for row in found.rows if row["shape"] == f"prolate {ratio:g}"]
        n = [row["sub_spheres"] for row in mine]
        for key, style in (("groove_under_wall", "-"), ("deepest_groove", "--")):
            y = [1e3 * row[f"{key}_over_diameter"] for row in mine]
            label = f"a/b = {ratio:g}" if style == "-" else "_"
            rows.plot(n, y, style, color=colour, label=label)
    _two_lines(rows, "below a wall, lying", "below the smooth surface")
    rows.set(xscale="log", yscale="log", xlabel="sub-spheres [-]",
             ylabel="depth of the groove / diameter [10\u207b\u00b3]")  # fmt: skip
    rows.set_title("prolate spheroids", fontsize=9, loc="left")
    headline(figure, "Up to which overlap sub-spheres stand for the smooth body")
    return figure


def _two_lines(axes: "Axes", solid: str, dashed: str) -> None:
    axes.plot([], [], color=GREY, label=solid)
    axes.plot([], [], color=GREY, ls="--", label=dashed)
    axes.legend(fontsize=8)
