"""Dead zones: where the solid stands while the silo flows, and where it is left at the end.

In the flow a point is dead where it is filled (a packing fraction above half the largest) and its
mean speed is below a tenth of the plug's, the speed that the same flow would have if the whole
width sank at once, W/(rho_b width). At the end of a run that left dead zones, what is filled by the
same measure is dead. Areas are counted on the grid of the coarse-grained fields, so that they are
right to about the Gaussian's width times the length of the edge.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from granulab.campaign.output.figure import INK, WALL
from silo2d.measures.basics.coarse_graining import (
    Floats,
    Grid,
    inside_edges,
    inside_mask,
    inside_polygon,
)
from silo2d.view.scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SLOW = 0.1  # of the plug's speed
_FILLED = 0.5  # of the largest packing fraction


@dataclass(frozen=True, eq=False)
class DeadZones:
    """Points of a grid (j, i) that are dead, and those that flow.

    silo     area of the silo's inside below the fill level [m2], of which shares are taken
    plug     speed of the plug [m/s], 0 of what lies at the end
    """

    grid: Grid
    dead: NDArray[np.bool_]
    flowing: NDArray[np.bool_]
    silo: float
    plug: float = 0.0

    @property
    def area(self) -> float:
        """[m2]"""
        return self.grid.cell * float(self.dead.sum())

    @property
    def share(self) -> float:
        """Area over that of the silo's inside below the fill level."""
        return self.area / self.silo


def filled(solid: Floats) -> NDArray[np.bool_]:
    """Mask of the points (j, i) with a packing fraction above half the largest; NaN: outside."""
    known = np.nan_to_num(solid)
    return known > _FILLED * max(known.max(), np.finfo(float).tiny)


def area_of_silo(scene: Scene, grid: Grid) -> float:
    """Area [m2] of the silo's inside below the fill level, counted on a grid."""
    below = grid.y <= float(scene.trajectory.attributes["level"])
    return grid.cell * float(inside_mask(inside_edges(scene), grid)[below].sum())


def standing(
    scene: Scene, grid: Grid, solid: Floats, speed: Floats, mass_flow: float, density: float
) -> DeadZones:
    """Dead zones of a flow from its fields (j, i).

    speed [m/s], NaN where there is none; mass_flow [kg/s] out of the silo; density: of the bulk
    [kg/m2].
    """
    left, right = scene.across
    plug = mass_flow / (density * (right - left))
    there = filled(solid)
    slow = (np.nan_to_num(speed) < SLOW * plug) | (plug == 0)  # where nothing flows all stands
    return DeadZones(grid, there & slow, there & ~slow, area_of_silo(scene, grid), plug)


def draw_dead_zones(axes: "Axes", scene: Scene, dead: DeadZones, left: DeadZones | None) -> None:
    """Dead zones of the flow as colour, and the edge of what is left at the end."""
    from matplotlib.patches import Polygon

    grid = dead.grid
    clip = Polygon(inside_polygon(scene), transform=axes.transData)
    shown = np.where(dead.dead, 1.0, np.nan)
    extent = grid.x[0], grid.x[-1], grid.y[0], grid.y[-1]
    axes.imshow(np.ma.masked_invalid(shown), origin="lower", extent=extent, cmap="Reds", vmin=0,
                vmax=1.6, clip_path=clip)  # fmt: skip
    words = f"dead in the flow: {1e4 * dead.area:.0f} cm2, {100 * dead.share:.1f} %"
    if left is not None:
        words += f"\nleft at the end: {1e4 * left.area:.0f} cm2, {100 * left.share:.1f} %"
        if left.dead.any():
            axes.contour(left.grid.x, left.grid.y, left.dead, [0.5], colors=[INK], linewidths=1.2)
    for wall in scene.walls:
        axes.plot(*wall.T, color=WALL, lw=2)
    start, end, _, top = scene.window
    axes.set(xlim=(start - 5e-3, end + 5e-3), ylim=(-5e-3, top), aspect="equal", xlabel="x [m]")
    axes.set_title(words, loc="left", fontsize=8)
