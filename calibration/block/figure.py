"""Diagnostic figures of a block on a plate: edge and block in the picture, and what they do."""

from typing import TYPE_CHECKING

import numpy as np

from calibration.block.edge import Edge
from calibration.block.result import Slid, Tilted
from calibration.statistics.quantity import plus_minus
from calibration.statistics.uncertainty import Estimate
from calibration.tracking.film.reader import open_film
from calibration.tracking.track import Array
from granulab.campaign.output.figure import BLUE, GREEN, GREY, VERMILION, headline

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BESIDE = 1.6  # of the fitted frames that are shown on either side


def draw_tilt(one: Tilted) -> "Figure":
    """Edge and block on the first picture, inclination and way against the frame."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12, 4.2), layout="constrained")
    picture, angle, way = figure.subplots(1, 3, width_ratios=[1.3, 1, 1])
    _picture(picture, one.path, one.edge, one.block)
    degrees, found = np.degrees(one.angle), np.degrees([one.found.value, one.found.sigma or 0.0])
    angle.plot(one.frame, degrees, ".", color=BLUE, ms=3)
    _instant(angle, one)
    angle.axhspan(found[0] - found[1], found[0] + found[1], color=GREEN, alpha=0.4, lw=0)
    angle.axhline(found[0], color=GREEN, lw=0.8)
    angle.set(xlabel="frame", ylabel="inclination of the plate [deg]")
    at, fitted = one.slip.shown
    way.plot(one.frame, one.way, ".", color=BLUE, ms=4, label="of the block")
    way.plot(at, fitted, color=VERMILION, label="fitted")
    _instant(way, one)
    middle, half = (at[0] + at[-1]) / 2, _BESIDE * np.ptp(at) / 2
    way.set(xlim=(middle - half, middle + half), xlabel="frame", ylabel="way down the plate [px]")
    top = float(np.nanmax(fitted))
    way.set_ylim(-0.15 * top, 1.3 * top)
    way.legend()
    slip = plus_minus(one.slip.time, one.slip.sigma)
    words = f"first slip at {plus_minus(*found)} deg, frame {slip}"
    headline(figure, f"{one.name}: {words}")
    return figure


def _instant(axes: "Axes", one: Tilted) -> None:
    at, sigma = one.slip.time, one.slip.sigma
    axes.axvspan(at - sigma, at + sigma, color=VERMILION, alpha=0.4, lw=0)
    axes.axvline(at, color=VERMILION, lw=0.8)


def draw_slide(one: Slid) -> "Figure":
    """Edge, block and its path on the first picture, its way, and what leaves its line."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12, 4.2), layout="constrained")
    picture, way, aside = figure.subplots(1, 3, width_ratios=[1.3, 1, 1])
    _picture(picture, one.path, one.edge, one.block)
    picture.plot(*one.path_px.T, color=BLUE, lw=1, label="path of its middle")
    picture.legend(fontsize=7)
    way.plot(one.time, 1e3 * one.way, ".", color=BLUE, ms=3)
    way.set(xlabel="time [s]", ylabel="way down the plate [mm]")
    aside.plot(1e3 * one.way, 1e3 * one.aside, ".", color=BLUE, ms=3)
    aside.axhline(0, color=GREY, lw=0.8)
    aside.set(xlabel="way down the plate [mm]", ylabel="off its straight line [mm]")
    headline(figure, f"{one.name}: plate at {_degrees(one.incline)} deg")
    return figure


def _degrees(known: Estimate) -> str:
    return plus_minus(np.degrees(known.value), np.degrees(known.sigma or 0.0))


def _picture(axes: "Axes", path: "Path", edge: Edge, block: Array) -> None:
    """The first picture, the edge found in it, and the block's corners."""
    first = next(open_film(path).frames()).picture
    axes.imshow(first[:, :, ::-1], interpolation="antialiased")
    axes.plot(*edge.ends.T, color=VERMILION, lw=1.2, label="edge of the plate")
    axes.plot(*block.T, "+", color=GREEN, ms=4, mew=0.8, label="corners of the block")
    axes.set(xlabel="x [px]", ylabel="y [px]")
    axes.legend(fontsize=7)
