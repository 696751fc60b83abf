"""A particle beside its true surface, and its errors against the number of sub-spheres."""

from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.shapes.cluster import Cluster
from damper3d.shapes.errors import Errors
from damper3d.view.pictures.spheres import Window, draw_spheres
from granulab.campaign.output.figure import BLUE, GREEN, GREY, PURPLE, SKY, VERMILION, headline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_EYE = np.array([0.35, -0.75, 0.56])  # where it is seen from
_LIGHT = np.array([-0.45, 0.6, 0.661])  # right, up, towards the eye; as of the spheres
_PIXELS = 420  # across a picture


def draw_shape(particle: Cluster, curve: list[Errors], here: Errors) -> "Figure":
    """Three panels: the sub-spheres, the true surface, the errors."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.2, 3.9), layout="constrained")
    spheres, smooth, errors = figure.subplots(1, 3, width_ratios=(1.0, 1.0, 1.35))
    half = 1.03 * max(
        particle.bounding_radius, float(np.linalg.norm(particle.surface.vertices, axis=1).max())
    )
    _draw_spheres(spheres, particle, half)
    _draw_surface(smooth, particle, half)
    for axes, words in ((spheres, f"{len(particle.radii)} sub-spheres"), (smooth, "true surface")):
        axes.set(xlim=(-half, half), ylim=(-half, half), aspect="equal", title=words)
        axes.set_axis_off()
    _scale_bar(spheres, half)
    _draw_errors(errors, curve, here)
    apart = f"at most {100 * here.surface:.2g} % of the equal-volume radius apart"
    headline(figure, f"{particle.name}: the two surfaces are {apart}")
    return figure


def _view() -> np.ndarray:
    """Right, up and towards the eye in rows (3, 3)."""
    towards = _EYE / np.linalg.norm(_EYE)
    right = np.cross([0.0, 0.0, 1.0], towards)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(towards, right), towards])


def _draw_spheres(axes: "Axes", particle: Cluster, half: float) -> None:
    from matplotlib.colors import to_rgb

    window = Window(-half, half, -half, half, _PIXELS / (2.0 * half))
    colours = np.tile(np.array([to_rgb(SKY), to_rgb(BLUE)]), (len(particle.radii), 1))
    picture = draw_spheres(
        particle.offsets @ _view().T, particle.radii, colours[: len(particle.radii)], window,
        (1.0, 1.0, 1.0),
    )  # fmt: skip
    axes.imshow(picture, extent=(-half, half, -half, half), interpolation="none")


def _draw_surface(axes: "Axes", particle: Cluster, half: float) -> None:
    """Triangles from the farthest to the nearest, lit as the spheres are."""
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import to_rgb

    corners = particle.surface.corners @ _view().T
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    seen = np.flatnonzero(normals[:, 2] > 0.0)
    order = seen[np.argsort(corners[seen, :, 2].mean(axis=1), kind="stable")]
    light = 0.42 + 0.58 * np.maximum(normals[order] @ _LIGHT, 0.0)
    colours = light[:, None] * np.array(to_rgb(SKY))
    axes.add_collection(
        PolyCollection(list(corners[order, :, :2]), facecolors=colours, edgecolors=colours, lw=0.3)
    )


def _scale_bar(axes: "Axes", half: float) -> None:
    """A length of one, two or five times a power of ten, below the particle."""
    power = 10.0 ** np.floor(np.log10(half))
    length = max(step * power for step in (0.5, 1.0, 2.0, 5.0) if step * power <= half)
    axes.plot([-half, length - half], [-0.97 * half] * 2, color=GREY, lw=3)
    axes.text(-half, -0.93 * half, f"{1e3 * length:g} mm", color=GREY, ha="left", va="bottom")


def _draw_errors(axes: "Axes", curve: list[Errors], here: Errors) -> None:
    from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter

    lines: list[tuple[str, str, str, Any]] = [
        ("surface", "distance of surfaces / radius (bound)", VERMILION, "o-"),
        ("volume", "volume", BLUE, "s-"),
        ("area", "surface area", GREEN, "^-"),
        ("section_area", "area of the section (thesis)", PURPLE, "v--"),
        ("section_perimeter", "perimeter of the section (thesis)", GREY, "D--"),
    ]
    for key, words, colour, style in lines:
        points = [(e.sub_spheres, abs(getattr(e, key))) for e in curve if getattr(e, key)]
        if points:
            axes.loglog(*zip(*points, strict=True), style, color=colour, label=words, ms=3.5)
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter(ScalarFormatter())
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.axvline(here.sub_spheres, color=GREY, lw=0.8, ls=":")
    axes.set(xlabel="sub-spheres", ylabel="size of the relative error", title="errors")
    axes.legend(fontsize=7, loc="upper center", bbox_to_anchor=(0.45, -0.17), ncols=2)
    axes.grid(alpha=0.2)
