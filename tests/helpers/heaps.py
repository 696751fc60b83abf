"""A small silo to fill within a second, and what a heap of particles in it must obey."""

from pathlib import Path

import numpy as np

from silo2d.case.case import GRAVITY, SiloCase
from silo2d.run.packing import Packing

CASE = """
schema = 1
[silo]
angle = "30 deg"
outlet = "40 mm"
width = "100 mm"
height = "120 mm"
[fill]
level = "100 mm"
"""


def small_case(folder: Path, changes: dict[str, float] | None = None) -> SiloCase:
    """About 40 particles in a hopper; a convex outline, which `wall_overlaps` needs."""
    file = folder / "small.toml"
    file.write_text(CASE, encoding="utf-8")
    return SiloCase.load(file, changes)


def silent(phase: str, fraction: float, text: str) -> None:
    """A report to nobody."""


def weight(case: SiloCase, kinds: np.ndarray) -> float:
    """Of the particles [N]."""
    areas = np.array([shape.area for shape in case.shapes.shapes])
    return float(GRAVITY * case.surface_density * areas[kinds].sum())


def cores(case: SiloCase, kinds: np.ndarray, poses: np.ndarray) -> list[np.ndarray]:
    """Core corners (n, 2) of each particle in the silo's frame [m]."""
    placed = []
    for kind, (x, y, angle) in zip(kinds, poses, strict=True):
        axes = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        placed.append(case.shapes.shapes[kind].core @ axes + [x, y])
    return placed


def particle_overlaps(case: SiloCase, kinds: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Overlaps [m] of the pairs of particles that touch, from shapely's distance of the cores."""
    from shapely import Polygon, STRtree, distance

    reach = 2 * case.shapes.shapes[0].spheroradius  # one for the whole set
    polygons = np.array([Polygon(core) for core in cores(case, kinds, poses)])
    first, second = STRtree(polygons).query(polygons, predicate="dwithin", distance=reach)
    once = first < second
    return reach - distance(polygons[first[once]], polygons[second[once]])


def wall_overlaps(case: SiloCase, kinds: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """How far each particle reaches beyond the walls and the door of a convex silo (n,) [m]."""
    start, end = case.outline.walls().segments.transpose(1, 0, 2)
    along = (end - start) / np.linalg.norm(end - start, axis=1)[:, None]
    inwards = np.column_stack([-along[:, 1], along[:, 0]])  # the inside is on the left
    radius = case.shapes.shapes[0].spheroradius
    return np.array(
        [
            radius - np.einsum("cwx,wx->cw", core[:, None] - start, inwards).min()
            for core in cores(case, kinds, poses)
        ]
    )


def solid_fraction(case: SiloCase, packing: Packing) -> float:
    """Area of particles over area of silo under the level less the largest particle, cut exactly.

    Packing.fraction counts whole particles, of which there are too few here.
    """
    from shapely import Polygon, box

    line = case.settings.fill.level - 2 * case.shapes.bounding_radius
    below = Polygon(case.outline.polygon).intersection(box(-1, 0, 1, line))
    radius = case.shapes.shapes[0].spheroradius
    particles = (Polygon(core).buffer(radius) for core in cores(case, packing.kinds, packing.poses))
    return sum(particle.intersection(below).area for particle in particles) / below.area


def assert_filled_to_the_level(case: SiloCase, packing: Packing) -> None:
    """No hole as large as a particle under the level, in any third of the width."""
    largest = 2 * case.shapes.bounding_radius
    level = case.settings.fill.level
    left = case.outline.polygon[:, 0].min()
    third = ((packing.poses[:, 0] - left) / (case.outline.width / 3)).astype(int)
    for k in range(3):
        assert level - largest < packing.poses[third == k, 1].max() < level + largest / 10
