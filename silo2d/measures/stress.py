"""The stress field, coarse-grained from the contacts: before the opening, and in the mean flow.

    sigma(r) = - sum_k f_k (x) b_k  int_0^1 phi(r - x_k - s b_k) ds             contact part
               + sum_i m_i (v_i - V(r)) (x) (v_i - V(r)) phi(r - x_i)           kinetic part

over all pairs k of a particle and a contact it has: f the force on the particle, b the branch from
its centroid x to the contact point; V is the momentum density over the mass density (Goldhirsch
2010, Granular Matter 12, 239; with contact points and walls Weinhart et al. 2012, Granular Matter
14, 289). Pressure is positive. As d/ds phi(r - x - s b) = -b . grad phi,

    sum_i m_i a_i phi(r - x_i) = rho g - div sigma + sum over walls of f phi(r - point)

holds at every point, with the contact part alone and the accelerations a of the same forces; the
last sum is what the walls push back with, spread by the same Gaussian. The integral of the
contact part over the plane is the virial sum - sum f (x) b, exactly.

Stresses are of the plane [N/m]; divided by the prisms' length, which stands in the materials file,
they are in pascals, as pictures have them. Within two widths of a wall they are smeared over it,
not corrected: a correction would break the balance of momentum.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from granulab.campaign.output.figure import INK, WALL, headline
from silo2d.measures.basics.coarse_graining import (
    Grid,
    along_branches,
    draw_map,
    grid_round,
    inside_edges,
    inside_mask,
)
from silo2d.measures.basics.contacts import STATES, Moment, branches, in_words, read_moments, states
from silo2d.measures.basics.particles import prism_length, with_pascals
from silo2d.view.scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class StressField:
    """Stress on a grid, or its mean over moments; pressure positive [N/m].

    contact, kinetic    (2, 2, j, i): force (momentum) component, direction of the branch
    moments             over how many moments the mean is
    """

    grid: Grid
    contact: Floats
    kinetic: Floats
    moments: int

    @property
    def total(self) -> Floats:
        """Both parts (2, 2, j, i)."""
        return self.contact + self.kinetic

    @property
    def pressure(self) -> Floats:
        """Half the trace (j, i)."""
        return (self.total[0, 0] + self.total[1, 1]) / 2

    def principal(self) -> tuple[Floats, Floats, Floats]:
        """Larger and smaller principal stress (j, i), and the angle of the larger from x [rad]."""
        (xx, xy), (yx, yy) = self.total
        shear = (xy + yx) / 2
        radius = np.hypot((xx - yy) / 2, shear)
        return (self.pressure + radius, self.pressure - radius, np.arctan2(2 * shear, xx - yy) / 2)


def virial(moment: Moment) -> Floats:
    """- sum f (x) b over all branches (2, 2) [N m]: the integral of the contact stress."""
    _, start, end, force = branches(moment)
    return -force.T @ (end - start)


def contact_stress(moment: Moment, grid: Grid) -> Floats:
    """The contact part (2, 2, j, i) [N/m]."""
    _, start, end, force = branches(moment)
    points, weights = along_branches(start, end)
    each = -force[:, :, None] * (end - start)[:, None, :]
    per_branch = len(points) // max(len(start), 1)
    spread = np.repeat(each.reshape(-1, 4), per_branch, axis=0) * weights
    return grid.deposit(points, spread).reshape(2, 2, len(grid.y), len(grid.x))


def kinetic_stress(scene: Scene, frame: int, grid: Grid) -> Floats:
    """The kinetic part (2, 2, j, i) [N/m]: sum m v (x) v phi less rho V (x) V."""
    mass, position, velocity = moving(scene, frame)
    products = velocity[:, :, None] * velocity[:, None, :]
    density = grid.deposit(position, mass[:, None])[0]
    momentum = grid.deposit(position, mass[:, None] * velocity)
    total = grid.deposit(position, mass[:, None] * products.reshape(-1, 4))
    mean = momentum[:, None] * momentum[None] / np.maximum(density, np.finfo(float).tiny)
    return total.reshape(mean.shape) - mean


def moving(scene: Scene, frame: int) -> tuple[Floats, Floats, Floats]:
    """Mass (n,) [kg], centroid (n, 2) [m] and velocity (n, 2) [m/s] of the particles inside."""
    frames, inside = scene.trajectory, scene.trajectory["inside"][frame]
    x, y, vx, vy = (frames[key][frame][inside].astype(float) for key in ("x", "y", "vx", "vy"))
    mass = frames.static["mass"][inside]
    return mass, np.column_stack([x, y]), np.column_stack([vx, vy])


def stress_of(moments: list[Moment], width: float | None = None) -> StressField:
    """Mean stress of moments, on a grid over the silo and six widths round it.

    width of the Gaussian [m]; one typical particle size (root of the mean area) unless given.
    """
    scene = moments[0].scene
    corners = scene.walls.reshape(-1, 2)
    grid = grid_round(corners.min(axis=0), corners.max(axis=0), width or scene.particle_size)
    contact = np.mean([contact_stress(m, grid) for m in moments], axis=0)
    kinetic = np.mean([kinetic_stress(scene, m.frame, grid) for m in moments], axis=0)
    return StressField(grid, contact, kinetic, len(moments))


def measure(folder: Path, between: tuple[float, float] | None = None) -> dict[str, Any]:
    """Numbers and fields of the stress before the opening, in the mean flow, and at the end.

    between: from and until [s], taken for the flow.

    ..._virial_n_m               integral of the contact stress over the plane [[xx, xy], [yx, yy]]
    ..._max_pressure_n_per_m     largest mean of the principal stresses; ..._max_pressure_pa
    ..._kinetic_share            integral of the kinetic part's trace over that of the total
    ..._anisotropy               mean of (s1 - s2)/(s1 + s2), weighted by the pressure
    fields                       x_m, y_m, the total stress xx, xy, yx, yy (j, i) [N/m], and
                                 xx_pa, xy_pa, yx_pa, yy_pa

    Keys begin with before_opening, flow or end; those of a flow are None for a run of which
    fewer than twenty particles left, those of the end for one that did not clog.
    """
    moments, length = read_moments(folder), prism_length(folder)
    fields = {name: stress_of(chosen) for name, chosen in states(moments, between).items()}
    numbers: dict[str, Any] = {"width_m": moments[0].scene.particle_size}
    for name in STATES:
        of = _numbers(fields[name]) if name in fields else dict.fromkeys(_KEYS)
        of = with_pascals(of, length)
        numbers |= {f"{name}_{key}": value for key, value in of.items()}
    return {**numbers, "fields": {name: _as_lists(one, length) for name, one in fields.items()}}


_KEYS = ("moments", "virial_n_m", "max_pressure_n_per_m", "kinetic_share", "anisotropy")


def _numbers(field: StressField) -> dict[str, Any]:
    larger, smaller, _ = field.principal()
    traces = [np.trace(field.grid.integral(part)) for part in (field.kinetic, field.total)]
    values = (
        field.moments,
        field.grid.integral(field.contact).tolist(),
        float(field.pressure.max()),
        float(traces[0] / traces[1]),
        float((larger - smaller).sum() / (larger + smaller).sum()),
    )
    return dict(zip(_KEYS, values, strict=True))


def _as_lists(field: StressField, length: float) -> dict[str, Any]:
    parts = {f"{a}{b}": field.total[i, j] for i, a in enumerate("xy") for j, b in enumerate("xy")}
    grid = {"x_m": field.grid.x.tolist(), "y_m": field.grid.y.tolist()}
    pascals = {f"{name}_pa": np.round(part / length, 2).tolist() for name, part in parts.items()}
    return {**grid, **{k: np.round(part, 4).tolist() for k, part in parts.items()}, **pascals}


def draw(folder: Path, between: tuple[float, float] | None = None) -> "Figure":
    """Pressure as colour, principal directions as crosses, in each state of the run."""
    from matplotlib.figure import Figure

    moments = read_moments(folder)
    scene = moments[0].scene
    length, chosen = prism_length(folder), states(moments, between)
    panels = {in_words(name, few): stress_of(few) for name, few in chosen.items()}
    figure = Figure(figsize=(5.3 * len(panels), 6.6), layout="constrained")
    headline(figure, scene.headline)
    grid = figure.subplots(1, len(panels), squeeze=False)[0]
    highest = max(field.pressure.max() for field in panels.values())
    for axes, (words, field) in zip(grid, panels.items(), strict=True):
        draw_map(axes, scene, field.grid, field.pressure / length, "pressure [Pa]",
                 cmap="YlGnBu", vmin=0, vmax=highest / length)  # fmt: skip
        inside = inside_mask(inside_edges(scene), field.grid)
        _draw_crosses(axes, field, inside, 2 * highest)
        axes.set_title(words, fontsize=10)
    words = "crosses: principal stresses; colours and lengths on one scale"
    figure.supxlabel(words, x=0.01, ha="left", fontsize=8, color=WALL)
    return figure


def _draw_crosses(
    axes: "Axes", field: StressField, inside: NDArray[np.bool_], longest: float
) -> None:
    """Both principal stresses as lines in their directions, every third point.

    longest: the stress [N/m] whose line reaches from one drawn point to the next.
    """
    from matplotlib.collections import LineCollection

    larger, smaller, angle = field.principal()
    step = 3
    chosen = np.zeros_like(inside)
    chosen[::step, ::step] = True
    j, i = np.nonzero(chosen & inside)
    scale = 1.1 * step * (field.grid.x[1] - field.grid.x[0]) / max(longest, 1e-12)
    position = np.column_stack([field.grid.x[i], field.grid.y[j]])
    for stress, rotation in ((larger, 0.0), (smaller, np.pi / 2)):
        towards = np.column_stack([np.cos(angle[j, i] + rotation), np.sin(angle[j, i] + rotation)])
        half = scale * stress[j, i, None] * towards
        lines = np.stack([position - half, position + half], axis=1)
        axes.add_collection(LineCollection(list(lines), colors=INK, linewidths=0.9))
