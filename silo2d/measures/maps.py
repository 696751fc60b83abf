"""A field of the plane drawn in the silo: colours up to the walls, the walls over them."""

from typing import TYPE_CHECKING, Any

from silo2d.measures.coarse import Floats, Grid
from silo2d.measures.silo import inside_polygon
from silo2d.scene import WALL, Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_map(
    axes: "Axes", scene: Scene, grid: Grid, field: Floats, label: str, **colours: Any
) -> None:
    """A field (j, i), clipped at the silo's inside, with its colour bar and the walls."""
    from matplotlib.patches import Polygon

    mesh = axes.pcolormesh(grid.x, grid.y, field, shading="gouraud", **colours)
    outline = Polygon(inside_polygon(scene), transform=axes.transData)
    mesh.set_clip_path(outline)
    assert axes.figure is not None
    axes.figure.colorbar(mesh, ax=axes, label=label, shrink=0.75)
    for wall in scene.walls:
        axes.plot(*wall.T, color=WALL, lw=2)
    left, right, _, top = scene.window
    axes.set(xlim=(left - 5e-3, right + 5e-3), ylim=(-5e-3, top), aspect="equal")
    axes.set(xlabel="x [m]", ylabel="height over the outlet [m]")
