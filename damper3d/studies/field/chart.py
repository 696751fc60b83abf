"""Pictures of a field and of the responses that follow from it."""

from collections.abc import Sequence
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
    responses: Responses | None,
    name: str,
    simulated: Sequence[dict[str, Any]] = (),
    structure: Structure | None = None,
) -> "Figure":
    """Amplitude over the level against frequency: with the bed, a colour a level, and bare.

    Over the level a linear structure has one curve, so that the bed's part shows. Lines are the
    harmonic balance, unstable branches dashed; markers the simulated points (studies.field.
    simulated), whose structure gives the bare curve where there are no lines.
    """
    from matplotlib import colormaps
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.6, 5.2), layout="constrained")
    headline(figure, f"{name}: response with the bed, over the level")
    axes = figure.subplots()
    known = [one for one in simulated if one["amplitude_m"] is not None]
    levels = sorted({float(one["level"]) for one in known})
    if responses is not None:
        levels = sorted({*levels, *responses.levels.tolist()})
    shades = colormaps["viridis"](np.linspace(0.05, 0.85, len(levels)))
    colours = dict(zip(levels, shades, strict=True))
    if responses is not None:
        bare = 1e3 * responses.bare[0] / responses.levels[0]
        axes.plot(responses.frequency, bare, color=INK, lw=1, label="bare")
        _branches(axes, responses, colours)
    elif structure is not None and known:
        each = [one["frequency_hz"] for one in known]
        along = spaced(structure, 0.99 * min(each), 1.01 * max(each))
        axes.plot(along, 1e3 * np.abs(structure.bare(along)), color=INK, lw=1, label="bare")
    for level in levels:
        own = sorted((o["frequency_hz"], o["amplitude_m"]) for o in known if o["level"] == level)
        if not own:
            continue
        frequency, amplitude = np.array(own).T
        axes.plot(
            frequency, 1e3 * amplitude / level, "o" if responses is not None else "o-",
            color=colours[level], ms=4.5, lw=0.8, mec=INK, mew=0.5,
            label=f"level {level:g}, simulated",
        )  # fmt: skip
    axes.set(yscale="log", xlabel="frequency [Hz]", ylabel="amplitude over level [mm]")
    if responses is not None:
        axes.set_xlim(responses.frequency.min(), responses.frequency.max())
    figure.legend(loc="outside right upper")
    return figure


def _branches(axes: "Axes", responses: Responses, colours: dict[float, Any]) -> None:
    """Draw the solutions of the harmonic balance."""
    for k, level in enumerate(responses.levels.tolist()):
        for rank, branch in enumerate(responses.amplitude[k].T):
            axes.plot(
                responses.frequency, 1e3 * branch / level, color=colours[level], lw=1.4,
                ls="--" if rank % 2 else "-", label=f"level {level:g}" if rank == 0 else None,
            )  # fmt: skip
