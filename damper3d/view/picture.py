"""Figures of a run, drawn from its folder: particles through a cycle here, graphs elsewhere."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from damper3d.measures.excitation import draw as draw_excitation
from damper3d.measures.host import draw as draw_host
from damper3d.view.charts import energy_chart, motion_chart
from damper3d.view.colouring import Colouring, colouring
from damper3d.view.film import make_film
from damper3d.view.scene import Scene, read_scene
from damper3d.view.spheres import draw_spheres, outline, spheres_drawn, window
from granulab.campaign.output.figure import GREY, INK, VERMILION, WALL, headline, ruled
from granulab.campaign.output.film import write_all
from granulab.campaign.runs.folder import RunFolder
from granulab.contact.files.units import nearest
from granulab.errors import FolderError, InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ENGINES = {"matplotlib": "cycle", "pyvista": "cycle-3d"}  # and the names of their figures
_MOST_PANELS = 8
_TALLEST, _WIDEST, _GAP = 3.2, 1.75, 0.1  # of a panel [inch]
_HEADLINE, _STRIP, _LEFT, _RIGHT, _BOTTOM = 0.72, 1.1, 0.75, 1.15, 0.5
_PIXELS = 240  # an inch of a panel
_WIDTH, _HEIGHT = 480, 540  # of a picture [px]
SHAPE = _HEIGHT / _WIDTH
_ROUND = 24  # edges of a sphere's outline
_ASIDE, _ABOVE = 0.5, 0.35  # how far the eye goes to the right and up, of its way back


def make_figures(
    run_folder: str | Path,
    film: bool = True,
    by: str = "velocity",
    engine: str = "matplotlib",
    cycles_in_film: int | None = None,
    report: Callable[[int, int], None] | None = None,
) -> list[Path]:
    """Draw a run, finished or not, into its folder figures/; the paths of the pictures.

    cycle.png     particles and enclosure at even times of the last whole cycle; cycle-3d.png in
                  its replacement by the engine "pyvista": the whole bed, in perspective
    energy.png    what a cycle dissipates, by mechanism, as it goes on; efficiency of each cycle
    motion.png    velocity of bed and enclosure, force on the enclosure, height of the bed's mass
    host.png      where the enclosure rides on one: its motion with the damper and bare
    excitation.png   where it is no single sine: a sweep by its frequency, or time and spectrum
    film.mp4      all frames, or those of the last `cycles_in_film`; left out without `film`

    report: called with the pictures done and left, a chart counting as many of a film's.

    `by` says what the particles' colours show: "velocity", "dissipation" or "kind". A run that kept
    no frames (output.frames = 0) has neither cycle.png nor film. Raises FolderError when the folder
    holds no cycle yet or cannot be read or written, InputError for another `by`.
    """
    if engine not in ENGINES:
        raise InputError(f"--engine {engine!r}: {nearest(engine, ENGINES)}")
    scene = read_scene(run_folder)
    folder = RunFolder(Path(run_folder)).figures
    figures = {"energy": energy_chart, "motion": motion_chart}
    if len(scene.tables):
        figures = {ENGINES[engine]: partial(cycle_figure, by=by, engine=engine), **figures}
    charts = {name: partial(draw, scene) for name, draw in figures.items()}
    if scene.on_host:
        charts["host"] = partial(draw_host, Path(run_folder))
    if scene.settings.excitation.kind is not None:
        charts["excitation"] = partial(draw_excitation, Path(run_folder))
    filmed = partial(make_film, scene, folder, by, cycles_in_film)
    return write_all(folder, charts, len(scene.tables) if film else 0, filmed, report)


def panel_frames(scene: Scene) -> list[int]:
    """Frames at even parts of the last whole cycle, at most eight."""
    frames = scene.frames_of(scene.n_cycles - 1)
    return frames[:: -(-len(frames) // _MOST_PANELS) or 1]


def cycle_figure(scene: Scene, by: str = "velocity", engine: str = "matplotlib") -> "Figure":
    """Particles and enclosure at even times of a cycle; below, the velocities.

    Drawn by matplotlib they are those behind the middle plane, by pyvista all, in perspective.
    Raises FolderError where the last cycle has no frame, InputError for another `by` or where
    pyvista is not installed.
    """
    from matplotlib.figure import Figure

    frames = panel_frames(scene)
    if not frames:
        raise FolderError("no frame in the last cycle; run it with output.frames above 0")
    shown, in_space = window(scene, 1.0), engine == "pyvista"
    shape = (shown.top - shown.bottom) / (shown.right - shown.left)
    shape = SHAPE if in_space else shape
    wide = min(_WIDEST, _TALLEST / shape)
    high = wide * shape
    across = len(frames) * (wide + _GAP)
    width, total = _LEFT + across + _RIGHT, _HEADLINE + high + 0.3 + _STRIP + _BOTTOM
    figure = Figure(figsize=(width, total))
    _words(figure, scene, total, in_space)
    colours = colouring(scene, by, frames)
    strip = figure.add_axes((_LEFT / width, _BOTTOM / total, across / width, _STRIP / total))
    _velocities(strip, scene, frames)
    bottom = _BOTTOM + _STRIP + 0.12
    for k, frame in enumerate(frames):
        x = _LEFT + _GAP / 2 + k * (wide + _GAP)
        box = (x / width, bottom / total, wide / width, high / total)
        panel = figure.add_axes(box)
        panel.set_axis_off()
        if in_space:
            panel.imshow(draw_space(scene, frame, colours))
        else:
            draw_enclosure(panel, scene, frame, colours, _PIXELS * wide)
    bar = figure.add_axes(((width - _RIGHT + 0.15) / width, bottom / total, 0.1 / width,
                           min(high, 2.2) / total))  # fmt: skip
    figure.colorbar(colours.scale, cax=bar, ticks=colours.ticks).set_label(colours.label)
    return figure


def _words(figure: "Figure", scene: Scene, total: float, in_space: bool) -> None:
    """The headline, and how to read the panels."""
    headline(figure, f"{scene.title}: {scene.outcome}")
    downwards = "gravity points down" if scene.gravity.any() else "no gravity"
    text = f"{downwards}; the half in front of the middle plane is taken away; dashed: the "
    text += "enclosure's position at rest; its amplitude: "
    text = f"{downwards}; the enclosure's amplitude: " if in_space else text
    text += _length(scene)
    figure.text(0.01, 1 - 0.5 / total, text, color=GREY, va="center")


def _length(scene: Scene) -> str:
    """The amplitude in words; under an excitation the largest displacement."""
    largest = scene.peak_speed * scene.period / (2 * np.pi)
    if scene.settings.excitation.kind is not None:
        largest = float(np.abs(scene.trajectory["displacement"]).max())
    return f"{1e3 * largest:.3g} mm" if largest > 1e-4 else f"{1e6 * largest:.3g} \N{MICRO SIGN}m"


def draw_enclosure(
    panel: "Axes", scene: Scene, frame: int, colours: Colouring, pixels: float
) -> None:
    """Particles and enclosure in a frame, to scale, `pixels` wide."""
    from matplotlib.collections import LineCollection
    from matplotlib.colors import to_rgb

    shown = window(scene, 1.0)
    shown = window(scene, pixels / (shown.right - shown.left))
    centre, radius, whose = spheres_drawn(scene, frame)
    picture = draw_spheres(centre, radius, colours.of(frame)[whose], shown, to_rgb("white"))
    panel.imshow(
        picture,
        extent=(shown.left, shown.right, shown.bottom, shown.top),
        interpolation="antialiased",
    )
    lines, moved = outline(scene), scene.view.project(scene.shift(frame))[:2]
    rest: dict[str, Any] = {"colors": GREY, "lw": 0.6, "ls": (0, (3, 3))}
    panel.add_collection(LineCollection(lines, clip_on=False, **rest))
    there = [line + moved for line in lines]
    panel.add_collection(LineCollection(there, clip_on=False, colors=WALL, lw=1.8))
    panel.set(xlim=(shown.left, shown.right), ylim=(shown.bottom, shown.top))


def _velocities(strip: "Axes", scene: Scene, frames: list[int]) -> None:
    """Velocities of bed and enclosure in that cycle, as wide as the panels, each over its time."""
    phase = scene.phase
    bed = scene.by_cycle(scene.along(scene.trajectory["mean_velocity"]))[-1]
    enclosure = scene.by_cycle(scene.trajectory["velocity"])[-1]
    samples = scene.frame_sample[frames]
    at = (samples - samples[0]) / (len(phase) - 1)
    ruled(strip)
    strip.plot(phase, enclosure, color=INK, label="enclosure")
    strip.plot(phase, bed, color=VERMILION, label="bed")
    strip.plot(at, scene.trajectory["velocity"][samples], "o", color=INK, ms=3.5)
    mean = scene.along(scene.trajectory["mean_velocity"][samples])
    strip.plot(at, mean, "o", color=VERMILION, ms=3.5)
    step = at[1] - at[0] if len(at) > 1 else 1.0
    strip.set(xlim=(at[0] - step / 2, at[-1] + step / 2), ylabel="velocity [m/s]")
    strip.set_xticks(at, [f"{part:.3g}" for part in at])
    strip.set_xlabel(f"part of cycle {scene.n_cycles}")
    strip.legend(loc="upper left", bbox_to_anchor=(1.0, 1), borderaxespad=0, handlelength=1.2)


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
    unit = pyvista.Sphere(radius=1.0, theta_resolution=_ROUND, phi_resolution=_ROUND)
    spheres = points.glyph(geom=unit, scale="size", orient=False, factor=1.0)
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
    polygons = [points for _, points in scene.enclosure.polygons]
    starts = np.cumsum([0, *map(len, polygons)])
    faces = [
        [len(points), *range(start, start + len(points))]
        for points, start in zip(polygons, starts, strict=False)
    ]
    return pyvista.PolyData(np.concatenate(polygons) + scene.shift(frame), np.concatenate(faces))


def _aim(plotter: Any, scene: Scene) -> None:
    """The eye stands still: it sees the enclosure wherever it goes."""
    view, size = scene.view, float(np.linalg.norm(scene.size))
    travel = 2 * float(np.linalg.norm(scene.way, axis=1).max())
    middle = np.array([0.0, 0.0, scene.enclosure.height / 2])
    towards = view.nearer + _ASIDE * view.right + _ABOVE * view.up
    distance = 2.0 * (size + travel)
    plotter.camera.focal_point = middle
    plotter.camera.position = middle + distance * towards / np.linalg.norm(towards)
    plotter.camera.up = view.up
    plotter.camera.view_angle = 28.0
    plotter.camera.clipping_range = (0.1 * distance, 3 * distance)
