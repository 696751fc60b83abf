"""The bed in space, whole and in perspective, drawn by pyvista (extra "pyvista")."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from damper3d.view.export import walls
from damper3d.view.pictures.colouring import Colouring
from damper3d.view.pictures.scene import Scene
from granulab.campaign.output.figure import WALL
from granulab.errors import InputError

_WIDTH, _HEIGHT = 480, 540  # of a picture [px]
SHAPE = _HEIGHT / _WIDTH
_ROUND = 24  # edges of a sphere's outline
_ASIDE, _ABOVE = 0.5, 0.35  # how far the eye goes to the right and up, of its way back


def draw_space(scene: Scene, frame: int, colours: Colouring) -> NDArray[np.uint8]:
    """Spheres in the enclosure, of which the walls let light through (rows, columns, 3).

    Raises InputError where pyvista is not installed.
    """
    pyvista = _pyvista()
    plotter = pyvista.Plotter(off_screen=True, window_size=(_WIDTH, _HEIGHT))
    plotter.set_background("white")
    arm, radius, whose = scene.spheres(frame)
    points = pyvista.PolyData(scene.particles(frame).position[whose] + arm + scene.shift(frame))
    points["size"] = radius
    points["colour"] = np.rint(255 * colours.of(frame)[whose]).astype(np.uint8)
    ball = pyvista.Sphere(radius=1.0, theta_resolution=_ROUND, phi_resolution=_ROUND)
    spheres = points.glyph(geom=ball, scale="size", orient=False, factor=1.0)
    plotter.add_mesh(spheres, scalars="colour", rgb=True, smooth_shading=True, specular=0.3)
    around = _mesh(pyvista, scene, frame)
    plotter.add_mesh(around, color=WALL, opacity=0.12)
    edges = around.clean().extract_feature_edges(feature_angle=30, manifold_edges=False)
    plotter.add_mesh(edges, color=WALL, line_width=3)
    _aim(plotter, scene)
    image = plotter.screenshot(return_img=True)
    plotter.close()
    return image


def _pyvista() -> Any:
    try:
        import pyvista
    except ImportError:
        raise InputError(
            "--engine pyvista: pyvista is not installed; get it with: pip install granulab[pyvista]"
        ) from None
    return pyvista


def _mesh(pyvista: Any, scene: Scene, frame: int) -> Any:
    """The walls where they stand."""
    polygons = [points for _, points in walls(scene)]
    starts = np.cumsum([0, *map(len, polygons)])
    faces = [
        [len(points), *range(start, start + len(points))]
        for points, start in zip(polygons, starts, strict=False)
    ]
    return pyvista.PolyData(np.concatenate(polygons) + scene.shift(frame), np.concatenate(faces))


def _aim(plotter: Any, scene: Scene) -> None:
    """The eye stands still: it sees the enclosure wherever it goes."""
    view, size = scene.view, float(np.linalg.norm(scene.size))
    travel = 2 * float(np.abs(scene.trajectory["displacement"]).max())
    middle = np.array([0.0, 0.0, scene.enclosure.height / 2])
    towards = view.nearer + _ASIDE * view.right + _ABOVE * view.up
    distance = 2.0 * (size + travel)
    plotter.camera.focal_point = middle
    plotter.camera.position = middle + distance * towards / np.linalg.norm(towards)
    plotter.camera.up = view.up
    plotter.camera.view_angle = 28.0
    plotter.camera.clipping_range = (0.1 * distance, 3 * distance)
