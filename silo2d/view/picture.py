"""Figures of a run, drawn from its folder: the silo here, graphs and the film elsewhere."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from granulab.campaign.output.figure import INK, WALL, round_length
from granulab.campaign.output.film import write_all
from granulab.campaign.runs.folder import RunFolder
from silo2d.view.charts import discharge_chart, energy_chart, force_chart
from silo2d.view.film import make_film
from silo2d.view.scene import PARTICLE_EDGE, WOOD, Scene, read_scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_INTERVAL = 0.25  # s between panels, as in the paper's figures
_MOST_PANELS = 8
# Edges of particles [pt], and of small ones, in their size: else they would hide the layers.
_EDGE, _EDGE_OF_SMALL = 0.35, 0.04
_PANEL_WIDTH, _GAP, _TITLE, _HEADLINE, _NARROWEST = 2.5, 0.22, 0.36, 0.5, 6.0  # inches


def make_figures(
    run_folder: str | Path, film: bool = True, report: Callable[[int, int], None] | None = None
) -> list[Path]:
    """Draw a run, finished or not, into its folder figures/; the paths of the pictures.

    silo.png         the painted layers every 0.25 s, or every multiple of it that fits
    discharge.png    particles out against time, with the published times
    energy.png       where the energy went
    forces.png       what the walls carried
    film.mp4         all frames (see make_film); left out without `film`

    report: called with the pictures done and left, a chart counting as many of a film's.

    Raises FolderError when the folder holds no frame yet or cannot be read or written.
    """
    scene = read_scene(run_folder)
    folder = RunFolder(Path(run_folder)).figures
    figures = {
        "silo": silo_figure,
        "discharge": discharge_chart,
        "energy": energy_chart,
        "forces": force_chart,
    }
    charts = {name: partial(draw, scene) for name, draw in figures.items()}
    n_pictures = len(scene.time) if film else 0
    return write_all(folder, charts, n_pictures, partial(make_film, scene, folder), report)


def silo_figure(scene: Scene) -> "Figure":
    """The silo with its painted layers at even times, at most eight of them."""
    from matplotlib.figure import Figure

    frames = panel_frames(scene.time)
    rows = 1 if len(frames) <= 5 else 2
    columns = -(-len(frames) // rows)
    left, right, bottom, top = scene.window
    # All in inches: panels have the shape of the window, so that no margin is left around them.
    height = _PANEL_WIDTH * (top - bottom) / (right - left)
    pitch = _PANEL_WIDTH + _GAP, height + _TITLE
    width = max(columns * pitch[0] + _GAP, _NARROWEST)
    total = _HEADLINE + rows * pitch[1] + _GAP
    figure = Figure(figsize=(width, total))
    figure.text(_GAP / width, 1 - 0.3 / total, scene.headline, size=14, weight="bold", va="center")
    for k, frame in enumerate(frames):
        row, column = divmod(k, columns)
        x, y = _GAP + column * pitch[0], total - _HEADLINE - (row + 1) * pitch[1]
        panel = figure.add_axes((x / width, y / total, _PANEL_WIDTH / width, height / total))
        _draw_silo(panel, scene, frame)
        if k == 0:
            _scale_bar(panel, scene)
    return figure


def panel_frames(time: np.ndarray) -> list[int]:
    """Frames (n,) nearest to the times of the panels, for frames at `time` (F,) [s].

    The times are multiples of 0.25 s, or of the smallest multiple of it that gives no more than
    eight panels. The last frame is always one, in place of a panel that comes less than a quarter
    of a step before it.
    """
    end = time[-1] - time[0]
    step = _INTERVAL * max(1, np.ceil(end / _INTERVAL / (_MOST_PANELS - 1) - 1e-9))
    wanted = step * np.arange(int(end / step + 1e-9) + 1)
    if len(wanted) > 1 and end - wanted[-1] < step / 4:
        wanted = wanted[:-1]
    frames = [int(np.abs(time - time[0] - t).argmin()) for t in [*wanted, end]]
    return list(dict.fromkeys(frames))


def _draw_silo(panel: "Axes", scene: Scene, frame: int) -> None:
    from matplotlib.collections import LineCollection, PolyCollection

    layer = scene.trajectory.static["layer"]
    left, right, *_ = scene.window
    shown = 72 * _PANEL_WIDTH * scene.particle_size / (right - left)  # [pt]
    for particles, outlines in scene.outlines(frame):
        colours = [WOOD[tone] for tone in layer[particles] % len(WOOD)]
        panel.add_collection(
            PolyCollection(
                list(outlines),
                facecolors=colours,
                edgecolors=PARTICLE_EDGE,
                linewidths=min(_EDGE, _EDGE_OF_SMALL * shown),
            )
        )
    panel.add_collection(
        LineCollection(
            [*scene.walls, *scene.door(frame)],
            colors=WALL,
            linewidths=2,
            capstyle="round",
            clip_on=False,
        )
    )
    (left, y), (right, _) = scene.trajectory.attributes["lips"]
    panel.plot([left, right], [y, y], color=WALL, lw=0.7, ls=(0, (3, 3)))
    n_out = scene.trajectory["n_out"][frame]
    panel.set_title(f"{scene.time[frame]:.2f} s, {n_out} out", fontsize=10)
    left, right, bottom, top = scene.window
    panel.set(xlim=(left, right), ylim=(bottom, top))
    panel.set_axis_off()


def _scale_bar(panel: "Axes", scene: Scene) -> None:
    """A bar of about a third of the width, 1, 2 or 5 times a power of ten, below the silo."""
    left, right, bottom, _ = scene.window
    length = round_length((right - left) / 3)
    y = bottom + 0.012 * (right - left)
    panel.plot([left, left + length], [y, y], color=INK, lw=2.5, solid_capstyle="butt")
    panel.annotate(f"{1e3 * length:g} mm", (left, y), (0, 4), textcoords="offset points")
