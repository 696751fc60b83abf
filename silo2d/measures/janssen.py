"""Wall pressure and vertical stress against Janssen's law, before the opening and in the flow.

Between two vertical walls a distance W apart, where the horizontal stress is K times the vertical
one and the walls bear mu_m times what presses them, a slice of bulk density rho_b (per area of the
plane) is balanced by

    d sigma/dz = rho_b g - 2 mu_m K sigma/W
    sigma(z) = rho_b g lambda (1 - exp(-z/lambda)),   lambda = W/(2 mu_m K)

(Janssen 1895; the plane's form: two walls instead of a perimeter over an area). Without friction
at the walls, as in the paper's filling, lambda is infinite and the law is hydrostatic, rho_b g z.

Nothing is fitted to the law: K is the ratio of wall pressure to vertical stress and mu_m that of
shear to pressure at the walls, each summed over the vertical part, and depth is measured by the
weight above, rho_b g z = (weight above)/W. In the flow the fill sinks: the law is taken at each
moment's own depths, and then its mean. A silo that discharges accelerates and its hopper carries
what its outlet lets go: the law is drawn with it for orientation only.

Stresses and tractions are of the plane [N/m]; divided by the prisms' length, which stands in the
materials file, they are in pascals, as pictures have them.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from granulab.campaign.output.figure import BLUE, GREY, INK, VERMILION, headline
from granulab.errors import InputError
from silo2d.loads.janssen import Floats, janssen_stress
from silo2d.measures.basics.contacts import (
    GRAVITY,
    STATES,
    Moment,
    branches,
    in_words,
    read_moments,
    states,
)
from silo2d.measures.basics.particles import prism_length, with_pascals
from silo2d.measures.basics.walls import STRETCH, Tractions, outwards, sides, tractions
from silo2d.view.scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_TRACTIONS = {"normal": "pressure on the walls", "shear": "traction down the walls"}
_FRICTIONLESS = 1e-3  # mobilised friction: below it the walls bear next to nothing
_VERTICAL = 1e-6  # run over length of a wall that counts as vertical, at most


@dataclass(frozen=True, eq=False)
class Column:
    """The vertical part of a silo in slabs of even height, from above; means over moments.

    height      of the middles of the slabs (b,) [m]
    vertical    mean vertical contact stress in each (b,) [N/m]
    weight      weight above, mean over each slab, over the width (b,) [N/m]
    pressure    mean pressure on the two walls at each (b,) [N/m]
    shear       mean traction on them, downwards (b,) [N/m]
    density     weight per area of the plane before the opening [N/m2], rho_b g
    width       W [m]
    weights     weight above at each moment (m, b) [N/m]
    fill        height of the fill at the first and the last moment [m]: what lies in the vertical
                part, at the bulk density before the opening; its foot where nothing does
    """

    height: Floats
    vertical: Floats
    weight: Floats
    pressure: Floats
    shear: Floats
    density: float
    width: float
    weights: Floats
    fill: tuple[float, float]

    @property
    def stress_ratio(self) -> float:
        """K: wall pressure over vertical stress; 0 where nothing is stressed."""
        return _over(self.pressure.sum(), self.vertical.sum())

    @property
    def friction(self) -> float:
        """mu_m, mobilised at the walls: shear over pressure, positive where they bear weight.

        0 where nothing presses the walls.
        """
        return _over(self.shear.sum(), self.pressure.sum())

    def janssen(self) -> Floats:
        """The law at the depths of each moment, the mean over them (b,) [N/m]."""
        product = self.friction * self.stress_ratio
        depth = self.weights / self.density
        return janssen_stress(depth, self.density, product, self.width).mean(axis=0)


def _over(part: float, whole: float) -> float:
    return float(part / whole) if whole else 0.0


def column(moments: list[Moment]) -> Column:
    """The part between the topmost vertical walls, below the highest particle of the first frame.

    Raises InputError for a silo without a vertical wall on each side.
    """
    scene = moments[0].scene
    walls = vertical_walls(scene)
    segments = scene.walls[walls]
    low, width = segments[:, :, 1].min(axis=1).max(), float(np.ptp(segments[:, :, 0]))
    top = float(scene.trajectory["y"][0][scene.trajectory["inside"][0]].max())
    n = max(int((top - low) / (STRETCH * scene.particle_size)), 1)
    levels = np.linspace(top, low, n + 1)
    slabs = np.column_stack([levels[1:], levels[:-1]])
    each = np.array([_slabs(m, slabs, width, walls) for m in moments])
    inside = scene.trajectory["inside"][0]
    first, mass = scene.trajectory["y"][0][inside], scene.trajectory.static["mass"][inside]
    full = levels[min(1, n - 1)]  # the uppermost slab holds the rough surface
    counted = (first >= low) & (first < full) if n > 1 else first >= low
    density = GRAVITY * mass[counted].sum() / _free(scene, low, full, width)
    vertical, weight, pressure, shear = each.mean(axis=0)
    middles = slabs.mean(axis=1)
    ends = (moments[0], moments[-1])
    start, end = (float(low + _over(_weight_over(m, low), density * width)) for m in ends)
    return Column(
        middles, vertical, weight, pressure, shear, float(density), width, each[:, 1], (start, end)
    )


def _free(scene: Scene, low: float, high: float, width: float) -> float:
    """Area [m2] between the vertical walls and two heights [m] that no insert takes."""
    from shapely import box, linestrings, polygonize

    inserts = polygonize(linestrings(scene.walls[scene.of_insert]))
    left, right = scene.across
    taken = inserts.intersection(box(left, low, right, high)).area
    return float(width * (high - low) - taken)


def _weight_over(moment: Moment, low: float) -> float:
    """Weight [N] of the particles with centroids above a height [m]."""
    mass = moment.scene.trajectory.static["mass"]
    return float(GRAVITY * mass[moment.inside & (moment.centres[:, 1] > low)].sum())


def vertical_walls(scene: Scene) -> list[int]:
    """The topmost vertical wall of each side of a run's silo, left and right."""
    return topmost_vertical(scene.walls, sides(scene)[: len(scene.walls)])


def topmost_vertical(walls: Floats, side: NDArray[np.int64]) -> list[int]:
    """The topmost vertical one of walls (w, 2, 2) on the left (side -1) and the right (1).

    Raises InputError where a side has none.
    """
    run, rise = np.abs(walls[:, 1] - walls[:, 0]).T
    found = []
    for way in (-1, 1):
        here = np.flatnonzero((run <= _VERTICAL * rise) & (side == way))
        if not len(here):
            raise InputError("Janssen's law needs a vertical wall on each side of the silo")
        found.append(int(here[walls[here, :, 1].max(axis=1).argmax()]))
    return found


def _slabs(moment: Moment, slabs: Floats, width: float, walls: list[int]) -> Floats:
    """Vertical stress, weight above, wall pressure and shear of slabs (b, 2): (4, b) [N/m].

    Means over each slab, exact: of a branch, the part that lies in the slab counts.
    """
    low, high = slabs[:, :1], slabs[:, 1:]
    thick = (high - low)[:, 0]
    _, start, end, force = branches(moment)
    part = np.clip(end[:, 1], low, high) - np.clip(start[:, 1], low, high)
    vertical = -(part @ force[:, 1]) / (width * thick)
    y = moment.centres[moment.inside, 1]
    weight = GRAVITY * moment.scene.trajectory.static["mass"][moment.inside]
    above = np.clip(y - low, 0.0, high - low) @ weight / (width * thick)
    pressure, shear = np.zeros((2, len(slabs)))
    for wall in walls:
        here = moment.bodies[:, 1] == moment.scene.n_particles + wall
        inside = (moment.point[here, 1] >= low) & (moment.point[here, 1] < high)
        out = outwards(moment.scene.walls)[wall]
        pressure += inside @ (moment.force[here] @ out) / (2 * thick)
        shear += inside @ -moment.force[here, 1] / (2 * thick)
    return np.array([vertical, above, pressure, shear])


def measure(folder: Path, between: tuple[float, float] | None = None) -> dict[str, Any]:
    """Numbers and profiles before the opening, in the mean flow, and at the end.

    between: from and until [s], taken for the flow.

    ..._stress_ratio            K; ..._wall_friction mu_m, both as they fall out
    ..._janssen_length_m        lambda; None where mu_m is below 0.001
    ..._bottom_vertical_n_per_m vertical stress in the lowest slab of the vertical part, and
    ..._bottom_janssen_..., ..._bottom_hydrostatic_...   the law there, and the weight above
    ..._rms_over_janssen        rms of stress less law over the slabs, over the law's rms
    ..._fill_from_m, ..._fill_until_m  height of the fill at the first and the last moment
    profiles                    the column and the tractions on each wall, see Column and Tractions

    What is in N/m stands in Pa as well, by keys that end with _pa.

    Keys begin with before_opening, flow or end; those of a flow are None for a run of which
    fewer than twenty particles left, those of the end for one that did not clog. Raises InputError
    for a silo without vertical walls.
    """
    moments, length = read_moments(folder), prism_length(folder)
    chosen = states(moments, between)
    numbers: dict[str, Any] = {}
    profiles: dict[str, Any] = {}
    for name in STATES:
        of = dict.fromkeys(_KEYS)
        if name in chosen:
            found = column(chosen[name])
            of = _numbers(found, len(chosen[name]))
            walls = [_as_lists(wall, length) for wall in tractions(chosen[name])]
            profiles[name] = {"column": _as_lists(found, length), "walls": walls}
        numbers |= {f"{name}_{key}": value for key, value in with_pascals(of, length).items()}
    return {**numbers, "profiles": profiles}


_KEYS = ("moments", "stress_ratio", "wall_friction", "janssen_length_m",
         "bottom_vertical_n_per_m", "bottom_janssen_n_per_m", "bottom_hydrostatic_n_per_m",
         "rms_over_janssen", "fill_from_m", "fill_until_m")  # fmt: skip


def _numbers(found: Column, n_moments: int) -> dict[str, Any]:
    law, product = found.janssen(), found.friction * found.stress_ratio
    values = (
        n_moments,
        found.stress_ratio,
        found.friction,
        found.width / (2 * product) if abs(found.friction) >= _FRICTIONLESS else None,
        float(found.vertical[-1]),
        float(law[-1]),
        float(found.weight[-1]),
        float(np.sqrt(((found.vertical - law) ** 2).sum() / (law**2).sum())) if law.any() else None,
        *found.fill,
    )
    return dict(zip(_KEYS, values, strict=True))


_STRESSES = ("vertical", "weight", "pressure", "shear", "normal")


def _as_lists(profile: Column | Tractions, length: float) -> dict[str, Any]:
    """A profile as lists, its stresses again in pascals."""
    values = {k: v for k, v in vars(profile).items() if k not in ("weights", "fill")}
    pascals = {f"{k}_pa": v / length for k, v in values.items() if k in _STRESSES}
    both = {**values, **pascals}
    return {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in both.items()}


def draw(folder: Path, between: tuple[float, float] | None = None) -> "Figure":
    """Vertical stress with the law, and tractions on the walls, in each state of the run."""
    from matplotlib.figure import Figure

    moments, length = read_moments(folder), prism_length(folder)
    scene, chosen = moments[0].scene, states(moments, between)
    rows = {in_words(name, few): few for name, few in chosen.items()}
    figure = Figure(figsize=(11, 4.6 * len(rows)), layout="constrained")
    headline(figure, scene.headline)
    for axes, (words, few) in zip(
        figure.subplots(len(rows), 3, squeeze=False, sharey=True), rows.items(), strict=True
    ):
        _draw_column(axes[0], column(few), words, length)
        walls = tractions(few)
        for panel, kind in zip(axes[1:], ("normal", "shear"), strict=True):
            _draw_tractions(panel, walls, kind, length)
    return figure


def _draw_column(axes: "Axes", found: Column, words: str, length: float) -> None:
    top = found.fill[0]
    height = np.r_[top, found.height[found.height < top]]
    shown = found.height < top
    law, over = (np.r_[0.0, series[shown]] / length for series in (found.janssen(), found.weight))
    axes.plot(over, height, color=GREY, lw=1, label="hydrostatic")
    mobilised = 0.0 if abs(found.friction) < _FRICTIONLESS else found.friction
    label = f"Janssen, K = {found.stress_ratio:.2f},\n$\\mu_m$ = {mobilised:.2f}"
    axes.plot(law, height, color=BLUE, label=label)
    axes.plot(found.vertical / length, found.height, "o", ms=4, color=INK, label="contacts")
    if found.fill[0] > found.fill[1]:
        axes.axhspan(*found.fill, color=GREY, alpha=0.15, lw=0, label="fill, as it sinks")
    axes.set(xlabel="vertical stress [Pa]", ylabel="height over the outlet [m]")
    axes.set_title(f"{words}\n{_in_words(found)}", loc="left", fontsize=9)
    axes.legend(loc="upper right")


def _in_words(found: Column) -> str:
    if abs(found.friction) < _FRICTIONLESS:
        return "frictionless filling: Janssen's law is hydrostatic"
    if not found.weight[-1]:
        return "nothing lies between the vertical walls"
    excess = 100 * (found.vertical[-1] / found.weight[-1] - 1)
    how = "more" if excess > 0 else "less"
    return f"lowest slab carries {abs(excess):.0f} % {how} than the weight above"


def _draw_tractions(axes: "Axes", walls: list[Tractions], kind: str, length: float) -> None:
    walls = [wall for wall in walls if "floor" not in wall.name]  # all at one height
    for wall in walls:
        colour = VERMILION if "right" in wall.name else BLUE
        style = "--" if "hopper" in wall.name else "-"
        axes.plot(getattr(wall, kind) / length, wall.height, style, marker="o", ms=3, color=colour,
                  label=wall.name)  # fmt: skip
    axes.axvline(0, color=GREY, lw=0.6)
    axes.set_xlabel(f"{_TRACTIONS[kind]} [Pa]")
    # Not narrower than a tenth of the pressure: what is next to nothing shall look so.
    widest = 0.1 * max(wall.normal.max() for wall in walls) / length
    low, high = axes.get_xlim()
    axes.set_xlim(min(low, -widest), max(high, widest))
    if kind == "normal":
        axes.legend(loc="upper right")
