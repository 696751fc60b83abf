"""The 40 mm steel ball at 2.4 m/s (Fig. 5.20; measured by Mishra et al., the thesis's [168])."""

from typing import TYPE_CHECKING

from damper3d.studies.single_contact import Found
from damper3d.studies.single_contact.ball import draw_hits, hit
from damper3d.studies.single_contact.impact import Impact
from granulab.contact.files.table import load_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def compute() -> Found:
    """Restitution 0.57 ("typical", sec. 5.5.4). The block is of steel: only that gives 8.1."""
    steel = load_table("steel").material("steel")
    ball = Impact(steel, steel, radius=20e-3, speed=2.4, restitution=0.57)
    printed = {
        "dissipated_measured_j": 0.47,
        "dissipated_by_the_law_j": 0.50,
        "speed_over_yield_velocity": 8.1,
    }
    remark = (
        "printed: 0.47 J measured, 0.50 J by the law, between ours to zero force and to zero "
        "overlap; the thesis does not say where its contact ended"
    )
    return hit([ball], printed, (remark,))


def draw(found: Found) -> "Figure":
    """Force against time and overlap."""
    return draw_hits(found, "Steel ball of 40 mm on a steel block")
