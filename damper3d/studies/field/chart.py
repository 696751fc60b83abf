"""Pictures of a field and of the responses that follow from it."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.studies.field.balance import Responses, spaced
from damper3d.studies.field.structure import Structure
from damper3d.studies.field.table import Field
from granulab.campaign.output.figure import GREY, INK, headline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ALONG = 200  # points of an interpolated curve


def draw_field(field: Field, name: str) -> "Figure":
    """In-phase and out-of-phase mass over that of the bed, against Gamma, a curve a frequency."""
    from matplotlib import colormaps
    from matplotlib.figure import Figure
    from matplotlib.ticker import FuncFormatter

    figure = Figure(figsize=(8.6, 6.2), layout="constrained")
    headline(figure, f"{name}: effective mass over the bed's {1e3 * field.bed_mass:.4g} g")
    above, below = figure.subplots(2, 1, sharex=True)
    shades = colormaps["viridis"](np.linspace(0.05, 0.85, len(field.frequencies)))
    for frequency, colour in zip(field.frequencies, shades, strict=True):
        own = field.frequency == frequency
        (knots,), (force,) = field.knots(frequency)
        gamma = np.geomspace(knots[1], knots[-1], _ALONG) if knots[-1] > knots[1] else knots[1:]
        mass = np.interp(gamma, knots, force) / gamma / field.bed_mass
        for axes, line, points, widths in (
            (above, mass.real, field.in_phase, field.in_phase_half_width),
            (below, -mass.imag, field.out_of_phase, field.out_of_phase_half_width),
        ):
            axes.plot(gamma, line, color=colour, lw=1)
            axes.errorbar(
                field.gamma[own], points[own] / field.bed_mass,
                yerr=np.nan_to_num(widths[own]) / field.bed_mass, fmt="o", ms=3.5, capsize=2,
                color=colour, label=f"{frequency:g} Hz",
            )  # fmt: skip
    for axes, label in ((above, "in phase m'/M [-]"), (below, "out of phase m''/M [-]")):
        axes.axhline(0.0, color=GREY, lw=0.7)
        axes.set(xscale="log", ylabel=label)
    above.axhline(1.0, color=GREY, lw=0.7, ls=":")
    below.set_xlabel("Γ [-]")
    below.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    figure.legend(*above.get_legend_handles_labels(), loc="outside right upper")
    return figure


def draw_responses(
    name: str,
    structures: Mapping[str, Structure],
    together: Sequence[Responses] = (),
    simulated: Sequence[dict[str, Any]] = (),
) -> "Figure":
    """Amplitude over the level against frequency: with the bed, a colour a level, and bare.

    Over the level a linear structure has one curve, so that the bed's part shows. Lines are the
    harmonic balance, unstable solutions dashed; markers the simulated points (studies.field.
    simulated), whose structure gives the bare curve where there are no lines. Several dampers have
    a panel each.
    """
    from matplotlib import colormaps
    from matplotlib.figure import Figure

    rows = math.ceil(len(structures) / _COLUMNS) if len(structures) > 2 else len(structures)
    columns = math.ceil(len(structures) / rows)
    figure = Figure(figsize=(4.3 * (columns + 1), 1.4 + 3.8 * rows), layout="constrained")
    if len(structures) == 1:
        figure.set_size_inches(8.6, 5.2)
    headline(figure, f"{name}: response with the bed, over the level")
    known = [one for one in simulated if one["amplitude_m"] is not None]
    levels = {float(one["level"]) for one in known}
    levels |= set(together[0].levels.tolist()) if together else set()
    shades = colormaps["viridis"](np.linspace(0.05, 0.85, len(levels)))
    colours = dict(zip(sorted(levels), shades, strict=True))
    panels = figure.subplots(rows, columns, sharex=True, squeeze=False).ravel()
    for spare in panels[len(structures) :]:
        spare.set_axis_off()
    for d, (place, structure) in enumerate(structures.items()):
        several = len(structures) > 1
        points = [
            (one["level"], one["frequency_hz"],
             one["dampers"][d]["amplitude_m"] if several else one["amplitude_m"])
            for one in known
        ]  # fmt: skip
        _panel(panels[d], structure, together[d] if together else None, points, colours)
        if d + columns < len(structures):
            panels[d].set_xlabel("")  # it stands below
        if several:
            panels[d].set_title(f"at {place}", loc="left", fontsize="medium")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside right upper")
    return figure


_COLUMNS = 2  # of panels, of three dampers or more


def _panel(
    axes: "Axes",
    structure: Structure,
    responses: Responses | None,
    points: Sequence[tuple[float, float, float]],
    colours: dict[float, Any],
) -> None:
    """Draw the response at one damper; points: level, frequency [Hz] and amplitude [m]."""
    if responses is not None:
        bare = 1e3 * responses.bare[0] / responses.levels[0]
        axes.plot(responses.frequency, bare, color=INK, lw=1, label="bare")
        _branches(axes, responses, colours)
        axes.set_xlim(responses.frequency.min(), responses.frequency.max())
    elif points:
        each = [frequency for _, frequency, _ in points]
        along = spaced(structure, 0.99 * min(each), 1.01 * max(each))
        axes.plot(along, 1e3 * np.abs(structure.bare(along)), color=INK, lw=1, label="bare")
    for level, colour in colours.items():
        own = sorted((frequency, amplitude) for each, frequency, amplitude in points
                     if each == level)  # fmt: skip
        if not own:
            continue
        frequency, amplitude = np.array(own).T
        axes.plot(
            frequency, 1e3 * amplitude / level, "o" if responses is not None else "o-",
            color=colour, ms=4.5, lw=0.8, mec=INK, mew=0.5, label=f"level {level:g}, simulated",
        )  # fmt: skip
    axes.set(yscale="log", xlabel="frequency [Hz]", ylabel="amplitude over level [mm]")


def _branches(axes: "Axes", responses: Responses, colours: dict[float, Any]) -> None:
    """Draw the solutions of the harmonic balance, those of one rank joined."""
    stable = responses.is_stable
    for k, level in enumerate(responses.levels.tolist()):
        for rank, branch in enumerate(responses.amplitude[k].T):
            for style, own in (("-", stable[k, :, rank]), ("--", ~stable[k, :, rank])):
                if np.isfinite(branch[own]).any():
                    axes.plot(
                        responses.frequency, 1e3 * np.where(own, branch, np.nan) / level,
                        color=colours[level], lw=1.4, ls=style,
                        label=f"level {level:g}" if rank == 0 and style == "-" else None,
                    )  # fmt: skip
