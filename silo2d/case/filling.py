"""Filling as a silo chooses it: how far its rain falls, the laws that stop it, and their time step.

The rain may be softer than the materials file says, since softer contacts allow longer steps, and
must be stiffer where soft contacts would let it pass through what it falls on. A particle of mass m
that lands on one contact at the speed v overlaps by v sqrt(m/kn); the engine takes overlaps up to
half of the spheroradius at a wall (`DEEPEST` in engine/lists.py) and twice that between particles.
"""

import math
from typing import NamedTuple

import numpy as np

from granulab.contact.laws import LinearLaw
from granulab.contact.material import Pair
from granulab.errors import InputError
from silo2d.case.outline import Outline
from silo2d.case.settings import Fill, Settings
from silo2d.case.shape import ShapeSet
from silo2d.case.stability import chosen_step, largest_stable_step

GRAVITY = 9.81  # [m/s2]
# Packing fraction that the number of poured particles is reckoned with; above any seen.
LOOSE = 0.93
USUAL_FRACTION = 0.88  # packing fraction
PITCH = 2.05  # of the rain, over the largest bounding radius; its rows are sqrt(3)/2 of it apart
# Filling takes a quarter of the stiffness, and so twice the step, of the materials file ...
_SOFTER = 4.0
# ... unless the landing would be deeper than this part of the spheroradius, ...
_DEEPEST_LANDING = 0.3
# ... and at least this part of the critical damping: less damped rain is long a gas.
_LEAST_DAMPING = 0.05


def particles_below(level: float, outline: Outline, shapes: ShapeSet) -> int:
    """About how many particles fill a silo to a level [m]."""
    return round(outline.area_below(level) * USUAL_FRACTION / shapes.mean_area)


class Layer(NamedTuple):
    """Layer that is poured at once: from a height to a height, over what lies there [m]."""

    begin: float
    end: float
    above: float  # how high what lies there reaches, bounding circles included; 0 for nothing


class Rain(NamedTuple):
    """The hardest landing of a filling: what its stiffness follows from."""

    fall: float  # farthest fall before a landing [m]
    mass: float  # of the heaviest particle [kg]
    mean_mass: float  # [kg]
    spheroradius: float  # the smallest [m]

    @property
    def stiffness(self) -> float:
        """Least stiffness [N/m] of one contact that stops the rain."""
        energy = self.mass * GRAVITY * self.fall
        return 2 * energy / (_DEEPEST_LANDING * self.spheroradius) ** 2


def layers_of(fill: Fill) -> list[tuple[float, float]]:
    """Heights [m] from and to which the silo is poured at once; one pair without layers."""
    height = fill.layer or fill.level
    n = max(math.ceil(fill.level / height - 1e-9), 1)
    return [(k * height, min((k + 1) * height, fill.level)) for k in range(n)]


def rows_of_rain(outline: Outline, shapes: ShapeSet, layer: Layer) -> tuple[np.ndarray, float]:
    """Centroids (n, 2) [m] of enough particles for a layer, none touching another, and their top.

    They stand in staggered rows from the door up, or above what lies there, in the silo and over
    it; the top [m] is where the next row would be. Raises InputError where none has room.
    """
    from shapely import LineString

    radius = shapes.bounding_radius
    pitch, above = PITCH * radius, layer.above
    area = outline.area_below(layer.end) - (outline.area_below(layer.begin) if layer.begin else 0)
    n = math.ceil(area * LOOSE / shapes.mean_area)
    high = outline.raised(above + n * pitch)  # more than enough: one particle a row
    free = high.inside.buffer(-1.02 * radius)
    left, bottom, right, top = free.bounds if not free.is_empty else (0.0, 0.0, 0.0, 0.0)
    rows, count = [np.zeros((0, 2))], 0
    y = max(bottom, above + radius if above else bottom) + 1e-3 * pitch
    staggered = False
    while count < n and y < top:
        stretch = free.intersection(LineString([(left - 1, y), (right + 1, y)]))
        for line in getattr(stretch, "geoms", [stretch]):
            if line.is_empty:
                continue
            left_end, _, right_end, _ = line.bounds
            # Every second row stands over the gaps of the one below.
            first = left + (pitch / 2 if staggered else 0.0)
            columns = np.arange(
                math.ceil((left_end - first) / pitch), math.floor((right_end - first) / pitch) + 1
            )
            rows.append(np.column_stack([first + columns * pitch, np.full(len(columns), y)]))
            count += len(columns)
        y += math.sqrt(0.75) * pitch
        staggered = not staggered
    if not count:
        raise InputError(
            f"{outline.name}: the silo is too small for its particles: it must be wider than "
            f"{2.04e3 * radius:.3g} mm somewhere, a largest particle and a little more"
        )
    return np.concatenate(rows), y


def rain_of(outline: Outline, shapes: ShapeSet, surface_density: float, fill: Fill) -> Rain:
    """The rain of a filling, the hardest of its layers.

    The rows fall together. Those that stand above the level fall farthest: by the height to which
    the rain, looser than what it becomes, stands above it. Raises InputError where no particle has
    room in the silo.
    """
    falls = [0.0]
    for begin, end in layers_of(fill):
        positions, _ = rows_of_rain(outline, shapes, Layer(begin, end, begin))
        falls.append(positions[:, 1].max() - end)
    return Rain(
        fall=max(falls) + PITCH * shapes.bounding_radius,
        mass=surface_density * max(shape.area for shape in shapes.shapes),
        mean_mass=surface_density * shapes.mean_area,
        spheroradius=min(shape.spheroradius for shape in shapes.shapes),
    )


def filling_laws(
    pairs: tuple[Pair, Pair], friction: tuple[float, float], rain: Rain
) -> tuple[LinearLaw, LinearLaw]:
    """Laws of the filling: soft, to be quick, but not too soft to land on; friction of their own.

    The rest comes from the materials file alone: what a case changes acts after the opening, and
    cases that differ in it share a packing.
    """
    laws = []
    for pair, mu, mass in zip(pairs, friction, (rain.mean_mass / 2, rain.mean_mass), strict=True):
        assert pair.linear is not None  # see whole_pairs
        known, kt, gamma_n, gamma_t = pair.linear.numbers
        kn = max(known / _SOFTER, rain.stiffness)
        kt *= kn / known
        gamma_n = max(gamma_n * math.sqrt(kn / known), 2 * _LEAST_DAMPING * math.sqrt(kn / mass))
        laws.append(LinearLaw(kn, kt, mu, gamma_n, gamma_t, True))
    return laws[0], laws[1]


def stiffened(law: LinearLaw) -> LinearLaw:
    """The same law four times as stiff, its restitution held; its stable step is half as long."""
    return law._replace(kn=4 * law.kn, kt=4 * law.kt, gamma_n=2 * law.gamma_n)


def filling_friction(
    settings: Settings, laws: tuple[LinearLaw, LinearLaw], where: str
) -> tuple[float, float]:
    """Friction of the filling, between particles and at walls: none, the laws' or a given one."""
    fill = settings.fill
    if fill.pour_with == "pymunk" and (fill.friction or fill.layer is not None):
        key = "friction" if fill.friction else "layer"
        raise InputError(
            f"{where}: [fill] {key} goes with pour_with = 'dem'; pymunk pours all at once and "
            "without friction"
        )
    if fill.friction is True:
        return laws[0].mu, laws[1].mu
    return float(fill.friction), float(fill.friction)


def filling_time_step(
    shapes: ShapeSet, surface_density: float, laws: tuple[LinearLaw, LinearLaw]
) -> float:
    """The time step [s] of the filling."""
    limit, _ = largest_stable_step(shapes, surface_density, *laws)
    return chosen_step(math.sqrt(_SOFTER), limit)
