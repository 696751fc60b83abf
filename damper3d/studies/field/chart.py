"""Pictures of a field, and of responses by it."""

from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.studies.field.balance import Branch
from damper3d.studies.field.runs import Points
from granulab.campaign.output.figure import GREY, headline

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NAMED = (0.1, 0.2, 0.5, 1, 2, 3, 5, 10, 20, 30, 50, 100)  # Gammas that an axis names


def draw_field(points: Points, name: str, bed_mass: float) -> "Figure":
    """Effective mass over the bed's own against Gamma, a line for each frequency."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.6, 4.4), layout="constrained")
    headline(figure, f"{name}: effective mass over the bed's own, {bed_mass:.4g} kg")
    left, right = figure.subplots(1, 2)
    frequencies = np.unique(points.frequency)
    colours = mpl.colormaps["viridis"](np.linspace(0.0, 0.9, len(frequencies)))
    for frequency, colour in zip(frequencies.tolist(), colours, strict=True):
        here = np.flatnonzero(points.frequency == frequency)
        here = here[np.argsort(points.gamma[here])]
        gamma, mass, half = (a[here] for a in (points.gamma, points.mass, points.half_width))
        for axes, value, width in ((left, mass.real, half.real), (right, -mass.imag, half.imag)):
            axes.errorbar(
                gamma, value / bed_mass, np.nan_to_num(width) / bed_mass, fmt="o-", ms=3, lw=0.8,
                color=colour, label=f"{frequency:g} Hz",
            )  # fmt: skip
    for axes, what in ((left, "in phase: rides along"), (right, "out of phase: dissipates")):
        axes.axhline(0.0, color=GREY, lw=0.6)
        axes.set(xscale="log", xlabel="Gamma [-]", ylabel=f"{what} [-]")
        named = [g for g in _NAMED if points.gamma.min() <= g <= points.gamma.max()]
        axes.set_xticks(named, [f"{g:g}" for g in named])
        axes.minorticks_off()
    left.axhline(1.0, color=GREY, lw=0.6, ls="--")
    figure.legend(*left.get_legend_handles_labels(), loc="outside right upper")
    return figure


def draw_response(
    branch: Branch, frequency: np.ndarray, bare: np.ndarray, levels: list[str], name: str
) -> "Figure":
    """Amplitude against frequency at several levels, each over its excitation's static response.

    bare (levels, n): amplitudes without the damper [m]. Unstable solutions are dotted.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.6, 5.2), layout="constrained")
    headline(figure, name)
    axes: Any = figure.subplots()
    colours = mpl.colormaps["viridis"](np.linspace(0.0, 0.85, len(levels)))
    for k, (level, colour) in enumerate(zip(levels, colours, strict=True)):
        axes.semilogy(frequency, 1e3 * bare[k], color=colour, lw=0.6, ls="--")
        chosen = branch.response == k
        for stable, marker, size in ((True, "o", 2.0), (False, "x", 3.0)):
            of = chosen & (branch.stable == stable)
            axes.semilogy(
                frequency[branch.frequency[of]], 1e3 * branch.amplitude[of], marker, ms=size,
                color=colour, label=level if stable else None,
            )  # fmt: skip
    axes.set(xlabel="frequency [Hz]", ylabel="amplitude of the structure [mm]")
    axes.plot([], [], color=GREY, lw=0.6, ls="--", label="without the damper")
    figure.legend(loc="outside right upper", title="excitation")
    return figure
