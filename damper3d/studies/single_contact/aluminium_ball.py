"""The 200 mm aluminium ball on a rigid wall (Fig. 5.21; finite elements of the thesis's [205])."""

from typing import TYPE_CHECKING

from damper3d.studies.single_contact import Found
from damper3d.studies.single_contact.ball import draw_hits, hit
from damper3d.studies.single_contact.impact import Impact
from granulab.contact.files.table import load_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RESTITUTIONS = {0.02: 0.81, 0.2: 0.56}  # at these speeds [m/s]; Table 5.2


def compute() -> Found:
    """At both speeds, with the restitution that was found there."""
    aluminium = load_table("aluminium").material("aluminium")
    balls = [
        Impact(aluminium, None, radius=0.1, speed=speed, restitution=e)
        for speed, e in RESTITUTIONS.items()
    ]
    printed = {"yield_velocity_m_s": 0.0016, "speed_over_yield_velocity": [12.2, 122]}
    remark = (
        "the damped law has no plastic part: it stays at its overlap only where a ball that yields "
        "keeps a dent, so overlaps differ at 122 times the yield velocity (sec. 5.5.4)"
    )
    return hit(balls, printed, (remark,))


def draw(found: Found) -> "Figure":
    """Force against time and overlap."""
    return draw_hits(found, "Aluminium ball of 200 mm on a rigid wall")
