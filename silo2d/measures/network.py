"""The contact network before the opening and at the end, and how its forces are distributed.

Forces are those between two bodies: the normal forces of their vertex-edge contacts, added up.
The distribution P(f/<f>) of the forces that press has an exponential tail in many packings,
P ~ exp(-beta f/<f>) (Mueth, Jaeger, Nagel 1998, Phys. Rev. E 57, 3164); beta is fitted to the
forces above the mean by the maximum of likelihood: 1/beta is the mean of their excess over <f>, in
units of <f>. Its standard error is that of a bootstrap over all forces, since <f> varies too.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from granulab.campaign.output.figure import BLUE, GREEN, GREY, INK, VERMILION, WALL, headline
from silo2d.measures.basics.coarse_graining import Floats
from silo2d.measures.basics.contacts import Moment, read_moments
from silo2d.view.scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_FEWEST = 20  # forces in a tail that is fitted
_NO_FRICTION = 1e-3  # tangential over normal forces, in sum: less than any friction
_RESAMPLES = 200  # of the bootstrap: its error has an error of 5 %
_WIDEST = 5.0  # line of a force of six times the mean [points]
_PALE = "#f0e6d2", "#c9b79a"  # of particles under a network: face, edge


@dataclass(frozen=True)
class Tail:
    """P(f/<f>) ~ exp(-beta f/<f>) above the mean: beta, its standard error, forces used."""

    beta: float
    error: float
    n: int


def measure(folder: Path) -> dict[str, Any]:
    """Numbers of the network before the opening and at the last frame.

    contacts, pairs           vertex-edge contacts; pairs of bodies that touch
    coordination              particles and walls that one inside touches, mean
    touching_nothing          part of the particles inside
    sliding                   part of the contacts at their Coulomb limit; all without friction
    mean_normal_force_n       over the pairs
    pulling                   part of the pairs whose normal force pulls (law of the paper)
    tail_beta, ..._error      of P(f/<f>); None with fewer than 20 forces above the mean
    """
    moments = read_moments(folder)
    rows = [numbers_of(moment) for moment in moments]
    numbers = {
        f"{name}_{key}": value
        for name, row in (("before_opening", rows[0]), ("end", rows[-1]))
        for key, value in row.items()
    }
    series = {key: [row[key] for row in rows] for key in ("time_s", "coordination", "sliding")}
    return {**numbers, "series": series}


def numbers_of(moment: Moment) -> dict[str, Any]:
    """The numbers of one moment, see `measure`."""
    pairs, force = moment.pairs
    n_inside = int(moment.inside.sum())
    touched = np.unique(pairs[pairs < moment.scene.n_particles])
    tail = exponential_tail(force)
    return {
        "time_s": moment.time,
        "grains": n_inside,
        "contacts": len(moment.bodies),
        "pairs": len(pairs),
        "coordination": coordination(moment),
        "touching_nothing": float(1 - len(touched) / n_inside) if n_inside else None,
        "sliding": float(moment.slides.mean()) if len(pairs) else None,
        "mean_normal_force_n": float(force.mean()) if len(pairs) else None,
        "pulling": float((force < 0).mean()) if len(pairs) else None,
        "tail_beta": tail.beta if tail else None,
        "tail_beta_error": tail.error if tail else None,
        "tail_forces": tail.n if tail else None,
    }


def coordination(moment: Moment) -> float | None:
    """Bodies, particles and walls, that a particle inside touches, mean; None without particles."""
    n_inside = int(moment.inside.sum())
    pairs, _ = moment.pairs
    return float((pairs < moment.scene.n_particles).sum() / n_inside) if n_inside else None


def exponential_tail(force: Floats) -> Tail | None:
    """Fit to the forces above the mean of those that press; None where they are too few."""
    pressing = force[force > 0]
    n = int((pressing > pressing.mean()).sum()) if len(pressing) else 0
    if n < _FEWEST:
        return None
    drawn = np.random.default_rng(0).integers(len(pressing), size=(_RESAMPLES, len(pressing)))
    error = np.std([_beta(pressing[sample]) for sample in drawn], ddof=1)
    return Tail(_beta(pressing), float(error), n)


def _beta(pressing: Floats) -> float:
    excess = pressing / pressing.mean() - 1
    return float(1 / excess[excess > 0].mean())


def draw(folder: Path) -> "Figure":
    """The network over the particles at both moments, and the distributions of forces.

    Where no contact is left at the end, the moment is shown when half of the leavers were out.
    """
    from matplotlib.figure import Figure

    moments = read_moments(folder)
    scene = moments[0].scene
    figure = Figure(figsize=(11.5, 6.2), layout="constrained")
    headline(figure, scene.headline)
    panels = figure.subplots(1, 3, width_ratios=[1, 1, 1.25])
    before, end = moments[0], _last_shown(moments)
    scale = before.pairs[1]
    unit = float(scale[scale > 0].mean()) if (scale > 0).any() else 1.0
    for panel, moment, words in ((panels[0], before, "just before the opening"),
                                 (panels[1], end, f"{end.time:.2f} s")):  # fmt: skip
        draw_particles(panel, scene, moment.frame)
        draw_network(panel, moment, unit)
        panel.set_title(f"{words}\n{in_words(moment)}", fontsize=10)
    words = f"lines: normal forces, {_WIDEST / 6:.1f} points wide for {unit:.3g} N; red pulls"
    figure.text(0.01, 0.01, words, fontsize=8, color=WALL)
    _draw_distribution(
        panels[2], {"before the opening": (before, BLUE), f"{end.time:.2f} s": (end, GREEN)}
    )
    return figure


def _last_shown(moments: list[Moment]) -> Moment:
    """The last moment, or where it has no contact the one at which half of the leavers are out."""
    if len(moments[-1].bodies):
        return moments[-1]
    n_out = moments[-1].scene.trajectory["n_out"]
    return min(moments, key=lambda m: abs(n_out[m.frame] - n_out[-1] / 2))


def in_words(moment: Moment) -> str:
    """Neighbours of a particle and how many contacts slide, for the head of a picture."""
    numbers = numbers_of(moment)
    if not numbers["pairs"]:
        return "no contacts"
    normal, force = moment.normal, moment.force
    along = np.abs(normal[:, 0] * force[:, 1] - normal[:, 1] * force[:, 0])
    sliding = numbers["sliding"]
    if along.sum() <= _NO_FRICTION * np.hypot(*force.T).sum():
        how = "frictionless"
    else:
        how = "all contacts slide" if sliding == 1 else f"{100 * sliding:.0f} % of contacts slide"
    return f"{numbers['coordination']:.2f} neighbours, {how}"


def draw_particles(axes: "Axes", scene: Scene, frame: int) -> None:
    """Particles in pale colours, walls, and the window of the silo."""
    from matplotlib.collections import LineCollection, PolyCollection

    for _, outlines in scene.outlines(frame):
        axes.add_collection(
            PolyCollection(list(outlines), facecolors=_PALE[0], edgecolors=_PALE[1], linewidths=0.4)
        )
    axes.add_collection(
        LineCollection(list(scene.walls), colors=WALL, linewidths=2, capstyle="round")
    )
    left, right, bottom, top = scene.window
    pad = 0.01 * (right - left)
    axes.set(xlim=(left - pad, right + pad), ylim=(bottom, top), aspect="equal")
    axes.set_axis_off()


def draw_network(axes: "Axes", moment: Moment, unit: float) -> None:
    """Lines from centroid through contact point to centroid, as wide as the normal force.

    unit: the force [N] of a line of a sixth of the widest, whose width is then the limit.
    """
    from matplotlib.collections import LineCollection

    force = (moment.force * moment.normal).sum(axis=1)
    first, second = moment.bodies.T
    n = moment.scene.n_particles
    ends = np.where(
        moment.at_wall[:, None], moment.point, moment.centres[np.minimum(second, n - 1)]
    )
    lines = np.stack([moment.centres[first], moment.point, ends], axis=1)
    width = np.minimum(np.abs(force) / unit, 6) * _WIDEST / 6
    colours = np.where(force < 0, VERMILION, BLUE)
    axes.add_collection(
        LineCollection(
            list(lines), linewidths=width, colors=list(colours), capstyle="round", joinstyle="round"
        )
    )


def _draw_distribution(axes: "Axes", moments: dict[str, tuple[Moment, str]]) -> None:
    for label, (moment, colour) in moments.items():
        force = moment.pairs[1]
        pressing = force[force > 0]
        if len(pressing) < _FEWEST:
            axes.plot([], [], " ", label=f"{label}: {len(pressing)} forces only")
            continue
        scaled = pressing / pressing.mean()
        edges = np.linspace(0, scaled.max() * 1.0001, max(8, round(len(scaled) ** 0.4) * 2))
        count, _ = np.histogram(scaled, edges)
        density = count / len(scaled) / np.diff(edges)
        some = count > 0
        middle = (edges[1:] + edges[:-1]) / 2
        error = density[some] / np.sqrt(count[some])
        words = f"{label}: {len(scaled)} pairs"
        axes.errorbar(middle[some], density[some], error, fmt="o", ms=4, lw=0.8, color=colour,
                      label=words)  # fmt: skip
        tail = exponential_tail(force)
        if tail:
            x = np.array([1.0, edges[-1]])
            height = tail.n / len(scaled) * tail.beta
            axes.plot(x, height * np.exp(-tail.beta * (x - 1)), color=colour,
                      label=f"$\\beta$ = {tail.beta:.2f} $\\pm$ {tail.error:.2f}")  # fmt: skip
    axes.set_yscale("log")
    axes.axvline(1, color=GREY, lw=0.6)
    axes.set(xlabel="normal force over its mean, $f/\\langle f\\rangle$",
             ylabel="$P(f/\\langle f\\rangle)$")  # fmt: skip
    axes.legend(loc="upper right", labelcolor=INK)
