"""A film of each phase, of a typical run of the table `phases`, and one picture of them all.

python docs/examples/phases/gallery.py FOLDER chooses of the committed points of 40 mm and 8 cycles
from Gamma 1 on the one of each name that is farthest from any threshold, at up to 80 Hz where that
has the name (of equals the least Gamma), runs it, and writes a film of its last two cycles; and
gallery.png, a still of each.
`damper3d render RUN` makes the film of a whole run.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from damper3d import DamperCase, run
from damper3d.measures.phases.criteria import PHASES, classify
from damper3d.reproduce.phases.quantities import label
from damper3d.reproduce.phases.readings import Point, points_of
from damper3d.view.film import film_frames
from damper3d.view.scene import read_scene
from granulab.campaign.output.figure import write_figure
from granulab.campaign.output.film import Image, write_film
from granulab.campaign.output.results import read_results

ROWS = Path(__file__).parents[2] / "results" / "damper3d" / "reproduce-phases.csv"
LOW = 80.0  # Hz
CYCLES = 2  # in a film
ACROSS = 4  # stills a row of the picture
AT = 0.25  # of the film: the enclosure is half-way through a cycle


def distance(point: Point) -> float:
    """Distance of a point from the threshold that would give it another name; see Neighbour."""
    near = classify(point.measures, point.orientation).neighbours
    return near[0].distance if near else float("inf")


def typical() -> Iterator[Point]:
    """The point of each name farthest from any threshold, in the order of the legends."""
    _, rows = read_results(ROWS)
    points = [one for one in points_of(rows) if (one.height_mm, one.cycles) == (40, 8)
              and one.gamma >= 1.0]  # fmt: skip
    for orientation in ("vertical", "horizontal"):
        for name in PHASES[orientation]:
            own = [one for one in points if (one.orientation, one.name) == (orientation, name)]
            if own:
                # Above LOW the filling's own motion is a part of what is seen in 8 cycles.
                yield max(own, key=lambda one: (
                    one.frequency_hz <= LOW, round(distance(one), 2), -one.gamma))  # fmt: skip


def filmed(point: Point, folder: Path) -> Image:
    """Run a point, write the film of its last cycles, and return a still of it."""
    changes = {"motion.orientation": point.orientation, "motion.frequency": point.frequency_hz,
               "motion.gamma": point.gamma}  # fmt: skip
    result = run(DamperCase.load("thesis", changes), out=folder / "runs")
    scene = read_scene(result.run_folder)
    name = f"{point.orientation}-{point.name}".replace("_", "-")
    path = write_film(folder, lambda: film_frames(scene, cycles=CYCLES), name)
    frames = list(film_frames(scene, cycles=CYCLES))
    print(f"{label(point.name)}, {point.orientation}: {point.frequency_hz:g} Hz, "
          f"Gamma {point.gamma:g}, {distance(point):.2f} from a threshold: {path}")  # fmt: skip
    return frames[round(AT * len(frames))]


def main(folder: Path) -> None:
    """Films and picture into a folder."""
    from matplotlib.figure import Figure

    points = list(typical())
    stills = [filmed(point, folder) for point in points]
    down = int(np.ceil(len(points) / ACROSS))
    figure = Figure(figsize=(2.1 * ACROSS, 2.3 * down), layout="constrained")
    for axes in figure.subplots(down, ACROSS).flat:
        axes.axis("off")
    for axes, point, still in zip(figure.axes, points, stills, strict=False):
        axes.imshow(still)
        words = f"{label(point.name)}, {point.orientation}"
        axes.set_title(f"{words}\n{point.frequency_hz:g} Hz, Γ {point.gamma:g}", fontsize=7)
    print(write_figure(folder / "gallery.png", lambda: figure))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
