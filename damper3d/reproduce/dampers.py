"""The dampers of the thesis's chapter 6 (Table 6.1) as panels of a table."""

from collections.abc import Iterable, Sequence

from damper3d.case.closed_forms import PACKINGS, bouncing_bed_onset, fluidisation_threshold
from damper3d.reproduce.runs import Panel, Point, Row
from damper3d.studies.map.grid import GAMMAS
from damper3d.studies.predict.prediction import Clearance, Prediction

ORIENTATIONS = "vertical", "horizontal"
HEIGHTS = 40, 45, 50, 55  # mm
SPHERES = {3: 1659, 4: 700, 5: 358, 6: 207}  # how many of a diameter [mm]: the same volume
_FRICTION = 0.52  # of acrylic on acrylic (Table 6.2)


def panel(
    orientation: str, height: int, diameter: int, points: Iterable[Point], **changes: object
) -> Panel:
    """A damper of Table 6.1 by its height and the spheres' diameter [mm]; with changes, another.

    The names of changes are keys with "__" for the point, such as particles__count.
    """
    labels: Row = {"orientation": orientation, "height_mm": height, "diameter_mm": diameter}
    case: Row = {
        "motion.orientation": orientation,
        "enclosure.height": f"{height} mm",
        "particles.shape": f"sphere:{diameter}mm",
        "particles.count": SPHERES.get(diameter),
    }
    case |= {key.replace("__", "."): value for key, value in changes.items()}
    return Panel(labels, case, tuple(points))


def about(onset: float, factor: float, beyond: tuple[float, ...] = ()) -> list[float]:
    """The thesis's Gammas, and those `beyond`, within a factor of an onset."""
    return [gamma for gamma in GAMMAS + beyond if onset / factor <= gamma <= onset * factor]


def close_onset(height: int, frequency: float) -> float:
    """Gamma of eq. 6.11 for the close packing in the thesis's cylinder of a height [mm]."""
    fill = SPHERES[5] * (5 / 40) ** 2 * 5 / height * 2 / 3  # spheres of 5 mm in 40 mm, eq. 6.1
    clearance = (1 - fill / PACKINGS["close"]) * height / 1e3
    return float(bouncing_bed_onset(frequency, clearance))


def prediction_of(rows: Sequence[Row]) -> Prediction | None:
    """What is predicted of the damper that rows were computed with; None where none is done."""
    row = next((row for row in rows if row["state"] == "done"), None)
    if row is None:
        return None
    fill, length = row["fill_ratio"], row["height_mm"] / 1e3
    clearances = tuple(
        Clearance(name, most, (1 - fill / most) * length if fill < most else None)
        for name, most in PACKINGS.items()
    )
    threshold = fluidisation_threshold(row["orientation"], _FRICTION)
    name = f"{row['height_mm']} mm, spheres of {row['diameter_mm']} mm"
    return Prediction(name, fill, length, row["orientation"], clearances, threshold)
