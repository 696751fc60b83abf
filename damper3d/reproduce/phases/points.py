"""Points at which phases are looked for: the thesis's maps, below Gamma 1, after 50 cycles."""

import itertools
from collections.abc import Sequence

from damper3d.reproduce.panels import ORIENTATIONS, SPHERES, Panel
from damper3d.studies.map.grid import FREQUENCIES, GAMMAS

CYCLES = {8: 3, 60: 50}  # cycles that are shaken, and how many of them do not count
STANDARD, LARGE = 40, 55  # mm: fill ratios 0.466 and 0.339
BELOW = (0.1, 0.2, 0.3, 0.5, 0.7, 0.85)
ABOUT_ONE = (0.9, 0.95, 1.05, 1.1, 1.2)
BOUNCING = (20.0, 40.0, 80.0)  # Hz at which the bouncing bed is within the maps
WAITED = {
    "vertical": (0.3, 1.0, 1.5, 2.0, 3.0, 8.0, 12.0, 20.0, 40.0, 80.0),
    "horizontal": (0.3, 1.0, 1.5, 2.0, 3.0, 5.0, 8.0),
}
WAITED_AT = (80.0, 160.0, 320.0, 1024.0)  # Hz, and 40 Hz horizontally about its optimum
WEIGHTLESS = (0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0)


def panels() -> list[Panel]:
    """The maps of 40 mm with what is below and about Gamma 1, long runs, no gravity, 55 mm."""
    whole = list(itertools.product(FREQUENCIES, GAMMAS))
    return [
        *(_panel(o, STANDARD, 8, [*whole, *_low(o)]) for o in ORIENTATIONS),
        *(_panel(o, STANDARD, 60, _waited(o)) for o in ORIENTATIONS),
        _panel("none", STANDARD, 8, list(itertools.product((40.0, 160.0), WEIGHTLESS))),
        *(_panel(o, LARGE, 8, list(itertools.product(BOUNCING, GAMMAS))) for o in ORIENTATIONS),
    ]


def _low(orientation: str) -> list[tuple[float, float]]:
    below = list(itertools.product(FREQUENCIES, BELOW))
    return below + list(itertools.product(BOUNCING, ABOUT_ONE)) * (orientation == "vertical")


def _waited(orientation: str) -> list[tuple[float, float]]:
    points = list(itertools.product(WAITED_AT, WAITED[orientation]))
    if orientation == "horizontal":
        points += [(40.0, gamma) for gamma in (1.0, 1.5, 2.0, 3.0, 4.0, 6.0)]
    return points


def _panel(
    orientation: str, height: int, cycles: int, points: Sequence[tuple[float, float]]
) -> Panel:
    labels = {"orientation": orientation, "height_mm": height, "cycles": cycles}
    changes = {
        "motion.orientation": orientation,
        "enclosure.height": f"{height} mm",
        "particles.count": SPHERES[5],
        "run.cycles": cycles,
        "run.discard": CYCLES[cycles],
    }
    return Panel(labels, changes, tuple(points))
