"""Which dampers and points the table of particle shapes runs (thesis, chapter 8).

90 spheroids of 3.8 mm, or 110 toroids of 3.5 mm, in the cylinder of 40 mm x 40 mm; 18 cycles of
which the last 15 count (sec. 8.4). The shapes are those of Tables 8.1 and 8.2.
"""

import csv
import itertools
import math
from collections.abc import Iterable
from functools import cache
from typing import Any

from damper3d.case.closed_forms import bouncing_bed_onset
from damper3d.case.random_packing import CLOSE_PACKING
from damper3d.reproduce.dampers import ORIENTATIONS
from damper3d.reproduce.runs import Panel, Point, Row
from damper3d.reproduce.sensitivity_values import STANDARD, VALUES, change
from damper3d.studies.map.grid import GAMMAS
from granulab.contact.files.datafile import data_file

BOUNCING = 20.0, 40.0  # Hz at which the thesis finds the bouncing bed (sec. 8.5.1)
FLUIDISED = 125.0, 160.0, 200.0, 320.0, 625.0, 1024.0  # Hz of Figs 8.21-8.26, vertical
SENSITIVE = 40.0, 35.0  # frequency [Hz] and Gamma of Fig. 8.20, horizontal
HEIGHT = 40  # mm
TREATMENTS = "sum", "deepest", "scaled"  # of several contacts of one pair; the thesis's first
TREATED = (("spheroid", 1.5), ("toroid", 0.2))  # for which they are compared, vertical
TREATED_AT = 40.0  # Hz
# [s] Sec. 8.4 takes chapter 6's 1 us; twice that changes eta by less than packings do (docs), but
# leaves the books of two spheroids open by more than 1 %: their shallow grooves let the most
# sub-spheres touch at once, and the sum of those contacts is the stiffest.
_TIME_STEP = 2e-6
_SHORT_STEP = 1e-6
_STIFFEST = (("spheroid", 1.25), ("spheroid", 1.5))

FILL = {"spheroid": 0.4115, "toroid": 0.393}  # ratio, of 90 of 3.8 mm and 110 of 3.5 mm
_COUNTS = {"spheroid": 90, "toroid": 110}  # sec. 8.3
# Factor about the close packing's onset within which Gammas are run; 20 Hz costs most.
_AROUND = {20.0: 2.0, 40.0: 2.5}
_CONVECTING = 30.0  # largest Gamma of the curves at high frequency

Shape = tuple[str, float]  # family of the thesis's tables, and ratio


def shapes() -> tuple[Shape, ...]:
    """The shapes of Tables 8.1 and 8.2 that the thesis simulated."""
    return tuple(sphericities())


@cache
def sphericities() -> dict[Shape, float]:
    """Sphericity (eq. 8.3) of each shape, as these tables print it."""
    path = data_file("published", "nonspherical_shapes")
    assert path is not None  # shipped
    lines = path.read_text(encoding="utf-8").splitlines()
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    return {
        (row["shape"], float(row["ratio"])): float(row["sphericity"])
        for row in rows
        if row["simulated"] == "yes"
    }


def particle_text(shape: Shape) -> str:
    """As `--particles` takes it; the sphere of a family is its ratio of 1 or 0."""
    family, ratio = shape
    if family == "toroid":
        return f"toroid:{ratio:g}"
    return f"{'oblate' if ratio < 1 else 'prolate'}:{ratio:g}"


def onset_panels(frequency: float) -> list[Panel]:
    """Figs 8.9-8.14: both orientations, Gammas about the onset, before they are refined."""
    return [
        panel(shape, orientation, [(frequency, gamma) for gamma in _about(shape, frequency)])
        for orientation, shape in itertools.product(ORIENTATIONS, shapes())
    ]


def curve_panels() -> list[Panel]:
    """Figs 8.21-8.26: vertical, the high frequencies."""
    gammas = [gamma for gamma in GAMMAS if gamma <= _CONVECTING]
    points = list(itertools.product(FLUIDISED, gammas))
    return [panel(shape, "vertical", points) for shape in shapes()]


def sensitivity_panels() -> list[Panel]:
    """Fig. 8.20: prolates and the sphere, one property changed at a time."""
    changed = [("standard", 1.0), *((name, v) for name, own in VALUES.items() for v in own)]
    prolates = [shape for shape in shapes() if shape[0] == "spheroid" and shape[1] >= 1]
    return [
        panel(shape, "horizontal", [SENSITIVE], part="sensitivity", changed=own)
        for own, shape in itertools.product(changed, prolates)
    ]


def treatment_panels() -> list[Panel]:
    """The two treatments of several contacts that the thesis has not, about the onset at 40 Hz."""
    return [
        panel(
            shape, "vertical", [(TREATED_AT, gamma) for gamma in _about(shape, TREATED_AT)],
            treatment=own,
        )
        for own, shape in itertools.product(TREATMENTS[1:], TREATED)
    ]  # fmt: skip


def panel(
    shape: Shape, orientation: str, points: Iterable[Point], *, part: str = "curves",
    changed: tuple[str, float] = ("standard", 1.0), treatment: str = "sum",
) -> Panel:  # fmt: skip
    """A shape's damper with its points; `changed` is a property and its value."""
    labels: Row = {
        "part": part, "shape": shape[0], "ratio": shape[1], "orientation": orientation,
        "treatment": treatment, "property": changed[0], "value": changed[1],
    }  # fmt: skip
    case: dict[str, Any] = {
        "motion.orientation": orientation,
        "enclosure.height": f"{HEIGHT} mm",
        "particles.shape": particle_text(shape),
        "particles.count": _COUNTS[shape[0]],
        "law.contact_treatment": treatment,
        "run.cycles": 18,
        "run.discard": 3,
        "run.time_step": f"{1e6 * _time_step(shape) * _shortened(*changed):.3g} us",
        **change(*changed),
    }
    return Panel(labels, case, tuple(points))


def _time_step(shape: Shape) -> float:
    """In s, of the particles as the thesis has them."""
    return _SHORT_STEP if shape in _STIFFEST else _TIME_STEP


def _shortened(name: str, value: float) -> float:
    """Of the time step, which goes as root(rho/E) (eq. 3.31); never longer than the standard's."""
    times = {"density": value / STANDARD["density"], "modulus": STANDARD["modulus"] / value}
    return min(1.0, math.sqrt(times.get(name, 1.0)))


def _about(shape: Shape, frequency: float) -> list[float]:
    """The thesis's Gammas about the onset that eq. 6.11 gives for spheres packed closely."""
    clearance = (1 - FILL[shape[0]] / CLOSE_PACKING) * HEIGHT / 1e3
    onset = float(bouncing_bed_onset(frequency, clearance))
    around = _AROUND[frequency]
    return [gamma for gamma in GAMMAS if onset / around <= gamma <= onset * around]
