"""Graphs of one run: what a cycle dissipates as it goes on, and how bed and enclosure move."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from damper3d.engine.records import cut
from damper3d.measures.efficiency import efficiencies
from damper3d.view.scene import Scene
from granulab.campaign.output.figure import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    headline,
    ruled,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

# Friction at the bottom of a stack, particle-particle first: the largest carries the others.
COLOURS = {
    "friction_particle_particle": BLUE,
    "normal_damping_particle_particle": VERMILION,
    "tangential_damping_particle_particle": PURPLE,
    "friction_particle_wall": SKY,
    "normal_damping_particle_wall": ORANGE,
    "tangential_damping_particle_wall": "#e6b8d0",
}
WALL_COLOURS = [BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY]
_FAINT = 0.02  # of the largest force: walls that bear less along the motion are not drawn


def dissipated(scene: Scene) -> dict[str, Array]:
    """Energy that each mechanism dissipated since a cycle began, of whole cycles (c, k + 1) [J]."""
    found = {}
    for name in COLOURS:
        series = scene.by_cycle(scene.trajectory[name])
        found[name] = series - series[:, :1]
    return found


def efficiency_of_cycles(scene: Scene) -> Array:
    """Efficiency of each whole cycle (c,), from the budget (eqs 6.8 to 6.10).

    As the results of a finished run have it: of a free decay by each cycle's own amplitude.
    """
    if known := scene.summary.get("efficiency_per_cycle"):
        return np.array(known)
    per = scene.samples_per_cycle
    return efficiencies(cut(scene.trajectory, per, 0), per, scene.full_energy)["efficiency"]


def energy_chart(scene: Scene) -> "Figure":
    """Dissipation as a cycle goes on (Figs 6.7 and 6.16), and the efficiency of each cycle."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.6, 7.2), layout="constrained")
    headline(figure, f"{scene.title}: {scene.outcome}")
    stack, cycles = figure.subplots(2, 1, height_ratios=[3, 1.6])
    _stacked(stack, scene)
    _per_cycle(cycles, scene)
    return figure


def _stacked(axes: "Axes", scene: Scene) -> None:
    """Mean over the cycles that count, by mechanism; thin: their sum in each."""
    found, counted = dissipated(scene), scene.counted
    mean = {name: found[name][counted].mean(axis=0) for name in COLOURS}
    total = np.sum([found[name][counted] for name in COLOURS], axis=0)
    factor, unit = _milli(float(np.max(total)))
    colours = list(COLOURS.values())
    ruled(axes)
    layers = axes.stackplot(
        scene.phase, *(factor * series for series in mean.values()), colors=colours
    )
    whole = sum(series[-1] for series in mean.values())
    words = [
        f"{name.partition('_particle')[0].replace('_', ' ')},\n{_between(name)}: "
        f"{_percent(series[-1], whole)}"
        for name, series in mean.items()
    ]
    each = [axes.plot(scene.phase, factor * one, color=INK, lw=0.5)[0] for one in total][:1]
    first, last = counted[0] + 1, counted[-1] + 1
    several = f"sum in each of\ncycles {first} to {last}" if last > first else f"cycle {first}"
    legend_beside(axes, [*layers[::-1], *each], [*words[::-1], several], right=1.14)
    axes.set(xlim=(0, 1), xlabel="part of the cycle", ylabel=f"dissipated in the cycle [{unit}]")
    axes.set_ylim(bottom=0)
    right = axes.secondary_yaxis(
        "right", functions=(_over(factor * scene.full_energy), _times(factor * scene.full_energy))
    )
    right.set_ylabel("over 4 (\u0393g/\u03c9)\u00b2 M")


def _over(number: float):
    return lambda values: values / number


def _times(number: float):
    return lambda values: values * number


def _milli(largest: float) -> tuple[float, str]:
    """A factor and the unit in which an energy [J] is easy to read."""
    for unit, factor in (("J", 1.0), ("mJ", 1e3), ("\N{MICRO SIGN}J", 1e6), ("nJ", 1e9)):
        if largest * factor >= 1:
            return factor, unit
    return 1e9, "nJ"


def _between(name: str) -> str:
    return "particle\N{EN DASH}" + name.rpartition("_")[2]


def _percent(part: float, whole: float) -> str:
    return f"{100 * part / whole:.1f} %" if whole > 0 else "none"


def _per_cycle(axes: "Axes", scene: Scene) -> None:
    """Efficiency of each cycle, filled where it counts; their mean, and its interval."""
    from matplotlib.ticker import MaxNLocator

    eta, counted = efficiency_of_cycles(scene), np.array(scene.counted)
    number = 1 + np.arange(len(eta))
    before = number[: counted[0]]
    ruled(axes)
    axes.plot(number, eta, color=GREY, lw=0.8)
    axes.plot(before, eta[: counted[0]], "o", mfc="white", color=GREY, label="discarded")
    axes.plot(number[counted], eta[counted], "o", color=BLUE, label="counted")
    mean = scene.summary.get("efficiency")
    mean = float(eta[counted].mean()) if mean is None else mean
    axes.axhline(mean, color=BLUE, lw=0.9, ls=(0, (4, 3)), label=f"mean: {mean:.3f}")
    low, high = scene.summary.get("efficiency_interval") or (mean, mean)
    if high > low:
        axes.axhspan(low, high, color=BLUE, alpha=0.12, lw=0, label=f"{low:.3f} to {high:.3f}")
    axes.set(xlabel="cycle", ylabel="efficiency", xlim=(0.5, len(eta) + 0.5))
    axes.set_ylim(min(0.0, float(eta.min())), 1.12 * max(float(eta.max()), high, 1e-9))
    if (gain := scene.summary.get("law_term")) is not None:
        words = (
            f"dissipated energy less the work of the changing stiffness: {100 * gain:.1f} % of it"
        )
        axes.set_title(words, loc="left", fontsize=9, color=GREY)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    handles, labels = axes.get_legend_handles_labels()
    legend_beside(axes, handles[not len(before) :], labels[not len(before) :])


def motion_chart(scene: Scene) -> "Figure":
    """Velocities (Figs 6.10 and 6.18), force on the enclosure, height of the bed's mass."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.6, 8.4), layout="constrained")
    headline(figure, f"{scene.title}: {scene.outcome}")
    velocity, force, height = figure.subplots(3, 1, sharex=True, height_ratios=[1.2, 1.2, 1])
    first, last = scene.counted[0] + 1, scene.counted[-1] + 1
    remark = f"thin: cycles {first} to {last}; thick: their mean"
    velocity.set_title(remark, loc="left", fontsize=9, color=GREY)
    enclosure = scene.by_cycle(scene.trajectory["velocity"])[scene.counted]
    _each(velocity, scene, enclosure, "enclosure", INK)
    bed = scene.along(scene.trajectory["mean_velocity"])
    _each(velocity, scene, _counted(scene, bed), "bed, mean", VERMILION)
    velocity.set_ylabel("velocity along\nthe motion [m/s]")
    _forces(force, scene)
    _each(height, scene, 1e3 * _counted(scene, _height(scene)), "bed's centre\nof mass", BLUE)
    height.set_ylabel(f"{_height_words(scene)} [mm]")
    height.set(xlim=(0, 1), xlabel="part of the cycle")
    for axes in (velocity, force, height):
        ruled(axes)
        axes.axhline(0, color=GREY, lw=0.6)
        legend_beside(axes)
    return figure


def _counted(scene: Scene, series: Array) -> Array:
    return scene.by_cycle(series)[scene.counted]


def _each(axes: "Axes", scene: Scene, cycles: Array, label: str, colour: str) -> None:
    """A series in each cycle (c, k + 1), and their mean."""
    axes.plot(scene.phase, cycles.T, color=colour, lw=0.4, alpha=0.5)
    axes.plot(scene.phase, cycles.mean(axis=0), color=colour, lw=1.6, label=label)


def _forces(axes: "Axes", scene: Scene) -> None:
    """Force of the bed on the enclosure along the motion: all walls, and those that bear of it.

    A force is a mean over the time since the sample before.
    """
    force = scene.along(scene.trajectory["wall_force"])
    all_walls = _counted(scene, force.sum(axis=1))
    seen = [
        (name, _counted(scene, force[:, wall]))
        for wall, name in enumerate(scene.wall_names)
        if np.abs(force[:, wall]).max() > _FAINT * np.abs(force).max()
    ]
    for (name, cycles), colour in zip(seen, WALL_COLOURS, strict=False):
        _each(axes, scene, cycles, name, colour)
    mean = all_walls.mean(axis=0)
    axes.plot(scene.phase, mean, color=INK, lw=0.9, ls=(0, (4, 2)), label="all walls")
    axes.set_ylabel("force on the enclosure\nalong the motion [N]")


def _height(scene: Scene) -> Array:
    """Height of the bed's mass in the enclosure (S,) [m], along gravity or, without, along z."""
    up = scene.view.up
    return scene.trajectory["mean_position"] @ up - scene.enclosure.lowest(up)


def _height_words(scene: Scene) -> str:
    return "height above\nthe bottom" if scene.view.up[2] else "height above\nthe lowest point"


def legend_beside(axes: "Axes", *handles_and_labels: list, right: float = 1.01) -> None:
    """A legend to the right of the axes, where it hides nothing: at `right` of their width."""
    axes.legend(*handles_and_labels, loc="upper left", bbox_to_anchor=(right, 1), labelspacing=0.6)
