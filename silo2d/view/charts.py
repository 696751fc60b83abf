"""Graphs of one run: particles out, energies and wall forces against time."""

from typing import TYPE_CHECKING

import numpy as np

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
from silo2d.run.numbers import discharge_curve, dissipated, energy_closure
from silo2d.view.scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MECHANISM_COLOURS = {
    "friction_grain_grain": BLUE,
    "normal_damping_grain_grain": VERMILION,
    "tangential_damping_grain_grain": PURPLE,
    "friction_grain_wall": SKY,
    "normal_damping_grain_wall": ORANGE,
    "tangential_damping_grain_wall": "#e6b8d0",
}
_SMOOTHED = 10  # frames
_WALL_COLOURS = [BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY, GREY]


def discharge_chart(scene: Scene) -> "Figure":
    """Particles out against time, with T90 and the published discharge times where they exist."""
    figure, (axes,) = _canvas(scene, [1], (7.5, 4.8))
    times, count = discharge_curve(scene.trajectory)
    end = float(scene.time[-1])
    axes.step([0, *times, end], [0, *count, len(count)], where="post", color=INK, lw=1.8)
    axes.set_ylabel("particles out")
    axes.set_ylim(0, 1.05 * max(scene.n_bed, len(count)))
    axes.axhline(scene.n_bed, color=GREY, lw=0.6)
    axes.annotate(f"all {scene.in_all}", (0, scene.n_bed), (4, -3), color=GREY, va="top",
                  textcoords="offset points")  # fmt: skip
    latest = _published_lines(axes, scene)
    t90 = scene.summary.get("t90_s")
    if t90 is not None:
        n90 = -(-9 * len(count) // 10)
        axes.plot([0, t90, t90], [n90, n90, 0], color=BLUE, lw=0.8, ls=(0, (2, 2)))
        axes.plot(t90, n90, "o", color=BLUE, ms=6, label=f"T90: {t90:.2f} s", zorder=5)
    axes.set_xlim(0, 1.04 * max(end, latest) or 1.0)
    _time_axis(axes)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, borderaxespad=0.2)
    return figure


def _published_lines(axes: "Axes", scene: Scene) -> float:
    """Draw the published discharge times; the latest of them [s]."""
    known = scene.summary.get("published") or {}
    mean, sd = known.get("experiment_mean_s"), known.get("experiment_sd_s")
    trials, clogged = known.get("experiment_n"), known.get("experiment_clogged")
    remark = f", {clogged} of {trials} clogged" if clogged else ""
    if mean is not None:
        spread = f" \N{PLUS-MINUS SIGN} {sd:.2f}" if sd is not None else ""
        axes.axvspan(mean - (sd or 0), mean + (sd or 0), color=GREEN, alpha=0.18, lw=0)
        axes.axvline(mean, color=GREEN, lw=1.4, label=f"experiment: {mean:.2f}{spread} s{remark}")
    elif clogged:
        axes.plot([], [], " ", label=f"experiment{remark.replace(',', ':')}")
    simulated = known.get("simulation_s")
    if simulated is not None:
        axes.axvline(
            simulated, color=VERMILION, lw=1.4, ls=(0, (5, 2)), label=f"SPOLY: {simulated:.2f} s"
        )
    elif known.get("simulation_clogged"):
        axes.plot([], [], " ", label="SPOLY: clogged")
    return max((mean or 0) + (sd or 0), simulated or 0)


def energy_chart(scene: Scene) -> "Figure":
    """Energies of the particles inside, what each mechanism dissipated, and what is unaccounted.

    Where the engine keeps no account of mechanisms, what was lost is one number.
    """
    if any(name not in scene.trajectory for name in MECHANISM_COLOURS):
        return _energy_without_mechanisms(scene)
    figure, (held, lost, rest) = _canvas(scene, [3, 3, 1.1], (9.2, 7.6))
    traj, time = scene.trajectory, scene.time
    elastic = traj["elastic_normal"] + traj["elastic_tangential"]
    for label, energy, colour in (
        ("potential", traj["potential"], INK),
        ("kinetic", traj["kinetic"], VERMILION),
        ("elastic", elastic, GREEN),
        ("carried out\nby particles that left", traj["carried_out"] - traj["carried_out"][0], GREY),
    ):
        held.plot(time, energy, color=colour, label=label)
    if "given_to_door" in traj and traj["given_to_door"].any():
        worked = traj["given_to_door"][0] - traj["given_to_door"]
        door = "door_speed" in traj.attributes
        held.plot(time, worked, color=SKY, label=f"work of the {'door' if door else 'walls'}")
    held.set_ylabel("particles inside [J]")
    _legend(held)

    by = dissipated(traj)
    # Friction at the bottom, the particles' share first: the largest carries the others.
    stacked = lost.stackplot(
        time, *(by[name] for name in MECHANISM_COLOURS), colors=list(MECHANISM_COLOURS.values())
    )
    labels = [_words(name, by[name][-1]) for name in MECHANISM_COLOURS]
    _legend(lost, stacked[::-1], labels[::-1])
    lost.set_ylabel("dissipated [J]")

    unaccounted, closure = energy_closure(traj)
    rest.axhline(0, color=GREY, lw=0.6)
    rest.plot(time, 1e3 * unaccounted, color=PURPLE)
    rest.set_ylabel("unaccounted\n[mJ]")
    share = "nothing dissipated yet" if closure is None else f"{100 * closure:.2g} % of dissipated"
    rest.set_title(f"unaccounted at the end: {share}", loc="left", fontsize=9, color=PURPLE)
    _time_axis(rest)
    return figure


def _energy_without_mechanisms(scene: Scene) -> "Figure":
    """Energies of the particles inside, and what was lost by difference."""
    figure, (held, lost) = _canvas(scene, [3, 2], (9.2, 5.6))
    traj, time = scene.trajectory, scene.time
    carried_out = traj["carried_out"] - traj["carried_out"][0]
    for label, energy, colour in (
        ("potential", traj["potential"], INK),
        ("kinetic", traj["kinetic"], VERMILION),
        ("carried out\nby particles that left", carried_out, GREY),
    ):
        held.plot(time, energy, color=colour, label=label)
    held.set_ylabel("particles inside [J]")
    _legend(held)
    energy = traj["potential"] + traj["kinetic"] + carried_out
    lost.plot(time, energy[0] - energy, color=BLUE)
    lost.set_ylabel("lost [J]")
    remark = "by difference: impulses give neither the mechanisms nor the energy balance"
    lost.set_title(remark, loc="left", fontsize=9)
    _time_axis(lost)
    return figure


def _words(mechanism: str, energy: float) -> str:
    how, _, between = mechanism.partition("_grain_")
    between = between.replace("grain", "particle")
    return f"{how.replace('_', ' ')},\nparticle\N{EN DASH}{between}: {energy:.3g} J"


def force_chart(scene: Scene) -> "Figure":
    """Vertical and normal force on each wall, means between frames."""
    figure, (vertical, normal) = _canvas(scene, [1, 1], (9.2, 6.6))
    force = scene.trajectory["wall_force"]
    first, second = scene.trajectory.static["wall_segments"].transpose(1, 0, 2)
    along = second - first
    outwards = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]
    pressing = (force * outwards).sum(axis=2)
    styles = wall_styles(scene.bearing)
    for k, (name, style) in enumerate(styles.items()):
        _thin_and_thick(vertical, scene.time, -force[:, k, 1], label=name, **style)
        _thin_and_thick(normal, scene.time, pressing[:, k], label=name, **style)
    total = -np.nan_to_num(force[:, :, 1]).sum(axis=1)  # with the doors
    _thin_and_thick(vertical, scene.time, total, label="all walls", color=INK)
    if not scene.gate and np.isfinite(door := -force[0, -1, 1]) and door > 0:
        label = f"door, until it opened:\n{door:.3g} N"
        vertical.plot(0, door, "v", color=INK, ms=7, label=label, clip_on=False)
    vertical.set_ylabel("vertical force, downwards [N]")
    normal.set_ylabel("normal force, outwards [N]")
    vertical.set_title(
        f"thin: mean between frames, thick: over {_SMOOTHED} of them", loc="left", fontsize=9
    )
    _legend(vertical)
    _time_axis(normal)
    return figure


def _thin_and_thick(axes: "Axes", time: np.ndarray, force: np.ndarray, label: str, **style) -> None:
    """A force as it stands, and its running mean."""
    axes.plot(time, force, color=style["color"], lw=0.5, alpha=0.5)
    n = min(_SMOOTHED, len(time))
    window = np.full(n, 1 / n)
    smooth = np.convolve(force, window, "valid")
    axes.plot(np.convolve(time, window, "valid"), smooth, label=label, **style)


def wall_styles(names: list[str]) -> dict[str, dict]:
    """Left and right of a kind share a colour; the right one is dashed."""
    kinds = list(dict.fromkeys(_kind(name) for name in names))
    return {
        name: {
            "color": _WALL_COLOURS[kinds.index(_kind(name)) % len(_WALL_COLOURS)],
            "ls": (0, (4, 1.5)) if "right" in name else "-",
        }
        for name in names
    }


def _kind(wall_name: str) -> str:
    return " ".join(word for word in wall_name.split() if word not in ("left", "right"))


def _canvas(
    scene: Scene, heights: list[float], size: tuple[float, float]
) -> tuple["Figure", list["Axes"]]:
    """A figure with the run's headline and axes one below the other that share the time."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    headline(figure, scene.headline)
    grid = figure.subplots(len(heights), 1, sharex=True, squeeze=False, height_ratios=heights)
    for axes in grid[:, 0]:
        ruled(axes)
    return figure, list(grid[:, 0])


def _legend(axes: "Axes", *handles_and_labels: list) -> None:
    """To the right of the axes, where it hides nothing."""
    axes.legend(*handles_and_labels, loc="upper left", bbox_to_anchor=(1, 1), labelspacing=0.6)


def _time_axis(axes: "Axes") -> None:
    axes.set_xlabel("time since the opening [s]")
    axes.set_xlim(left=0)
