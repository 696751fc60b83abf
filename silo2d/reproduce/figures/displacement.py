"""Displacement profiles as a figure: the lines of every seed and their mean."""

from typing import TYPE_CHECKING

import numpy as np

from granulab.campaign.output.figure import BLUE, VERMILION, WALL
from silo2d.case.outline import preset

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from pandas import DataFrame


def draw_profiles(found: "DataFrame") -> "Figure":
    """A row of panels a silo, every 0.25 s: lines of each seed thin, their mean thick."""
    from matplotlib.figure import Figure

    silos = list(dict.fromkeys(found["silo"]))
    times = sorted(set(found["time_s"])) if silos else []
    figure = Figure(figsize=(1.4 * max(len(times), 1) + 0.3, 2.6 * max(len(silos), 1)),
                    layout="constrained")  # fmt: skip
    panels = figure.subplots(max(len(silos), 1), max(len(times), 1), squeeze=False)
    for panel in panels.flat:
        panel.set_axis_off()
    for line, silo in zip(panels, silos, strict=False):  # none where all failed
        for panel, time in zip(line, times, strict=True):
            _panel(panel, silo, found[(found["silo"] == silo) & (found["time_s"] == time)])
            panel.set_title(f"{silo}, {time:.2f} s", fontsize=9)
    return figure


def _panel(panel: "Axes", silo: str, own: "DataFrame") -> None:
    from matplotlib.collections import LineCollection

    outline = preset(silo)
    panel.add_collection(LineCollection(list(outline.walls().segments[:-1]), colors=WALL, lw=1.6))
    left, right = outline.polygon[:, 0].min(), outline.polygon[:, 0].max()
    for layer, of_layer in own.groupby("layer"):
        colour = (BLUE, VERMILION)[int(layer) % 2]
        lines = of_layer.filter(regex=r"^y\d+_m$").to_numpy(float)
        x = left + (np.arange(lines.shape[1]) + 0.5) * (right - left) / lines.shape[1]
        panel.plot(x, lines.T, color=colour, lw=0.4, alpha=0.6)
        seen = np.isfinite(lines).sum(axis=0)
        mean = np.nansum(lines, axis=0) / np.maximum(seen, 1)
        panel.plot(x, np.where(2 * seen > len(lines), mean, np.nan), color=colour, lw=1.7)
    panel.set(xlim=(left - 0.004, right + 0.004), ylim=(-0.004, outline.height), aspect="equal")
