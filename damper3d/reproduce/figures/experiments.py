"""The experiments as a picture: efficiencies, restitution from flights, collisions."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from damper3d.reproduce.quantities.experiments import FREQUENCY, SURFACES, flights, readings
from granulab.campaign.output.figure import BLUE, VERMILION, headline, ruled, ticked

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from pandas import DataFrame

_COLOURS = dict(zip(SURFACES, (BLUE, VERMILION), strict=True))
_TICKS = (1.5, 2, 3, 4.5, 8, 12, 20, 37)
_STYLES = {40.0: "-", 160.0: ":"}


def experiment_panels(rows: Sequence[dict[str, Any]]) -> "Figure":
    """As Figs 7.5, 7.10 and 7.11, and what Figs 7.12 to 7.16 show of collisions at 40 Hz."""
    from matplotlib.figure import Figure

    found = readings(rows)
    figure = Figure(figsize=(10.4, 7.2), layout="constrained")
    headline(figure, "Experiments of chapter 7: 358 spheres of 5 mm, vertical, fill ratio 0.466")
    (eta, bounces), (when, force) = figure.subplots(2, 2)
    for frequency in _STYLES:
        _curves(eta, found, "efficiency_wall_work", frequency, _STYLES[frequency])
    _curves(when, found, "sign.base_acceleration", FREQUENCY, "-")
    _curves(when, found, "sign.lid_acceleration", FREQUENCY, "--")
    _curves(force, found, "sign.base_force", FREQUENCY, "-")
    _curves(force, found, "sign.lid_force", FREQUENCY, "--")
    eta.set_ylabel("efficiency, of the shaker's work [-]")
    when.set_ylabel("acceleration when struck [Γ g]")
    force.set_ylabel("force on base (-) and top (- -) [M g]")
    for axes in (eta, when, force):
        axes.set(xscale="log", xlabel="Γ [-]")
        ticked(axes, _TICKS)
        axes.set_ylim(0.0, None)
    force.set_yscale("symlog", linthresh=1.0)  # of the top, where nothing strikes it
    if len(found):
        eta.legend()
    _bounces(bounces)
    return figure


def _curves(axes: "Axes", found: "DataFrame", name: str, frequency: float, style: str) -> None:
    ruled(axes)
    if name not in found:
        return
    for surface, colour in _COLOURS.items():
        own = found[(found["surface"] == surface) & (found["frequency_hz"] == frequency)]
        own = own.sort_values("gamma")
        axes.plot(own["gamma"], own[name], style, marker="o", ms=3, color=colour,
                  label=f"{surface}, {frequency:g} Hz")  # fmt: skip


def _bounces(axes: "Axes") -> None:
    ruled(axes)
    for surface, colour in _COLOURS.items():
        own = [one for one in flights() if one["surface"] == surface]
        axes.plot([one["speed"] for one in own], [one["value"] for one in own], "o", color=colour)
        axes.axhline(SURFACES[surface], color=colour, lw=0.8)
    axes.set(xlabel="speed of the second impact [m/s]", ylabel="restitution T23/T12 [-]",
             ylim=(0.8, 0.95))  # fmt: skip
