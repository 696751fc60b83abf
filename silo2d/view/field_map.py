"""A field of the plane drawn in the silo: colours up to the walls, the walls over them."""

from typing import TYPE_CHECKING, Any

import numpy as np

from granulab.campaign.output.figure import WALL
from silo2d.measures.from_contacts.coarse_graining import Floats, Grid
from silo2d.measures.from_contacts.silo_geometry import inside_polygon
from silo2d.view.scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_map(
    axes: "Axes", scene: Scene, grid: Grid, field: Floats, label: str, **colours: Any
) -> None:
    """A field (j, i), clipped at the silo's inside, with its colour bar and the walls.

    Where the field is NaN nothing is drawn.
    """
    from matplotlib.patches import Polygon

    half = (grid.x[1] - grid.x[0]) / 2  # a point is the middle of its cell
    extent = grid.x[0] - half, grid.x[-1] + half, grid.y[0] - half, grid.y[-1] + half
    image = axes.imshow(
        np.ma.masked_invalid(field),
        origin="lower", extent=extent, interpolation="bilinear", **colours,
    )  # fmt: skip
    image.set_clip_path(Polygon(inside_polygon(scene), transform=axes.transData))
    assert axes.figure is not None
    axes.figure.colorbar(image, ax=axes, label=label, shrink=0.75)
    for wall in scene.walls:
        axes.plot(*wall.T, color=WALL, lw=2)
    left, right, _, top = scene.window
    axes.set(xlim=(left - 5e-3, right + 5e-3), ylim=(-5e-3, top), aspect="equal")
    axes.set(xlabel="x [m]", ylabel="height over the outlet [m]")
