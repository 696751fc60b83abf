"""Tangential force of a lying toroid on a flat wall: finite elements and sub-spheres (Fig. 5.10b).

The smooth steel toroid of Fig. 5.9 is pressed on a wall of its own material and shifted along it
without rotation, its middle plane rigid; the thesis does not say how its own finite elements are
held, or under which normal force. The multi-sphere particle bears the same normal force. Two forces
are taken: that of the largest overlap of Fig. 5.10a here, and that at which the sum of 50
sub-spheres has the smooth toroid's overlap too, where the two differ by their tangential law alone.
"""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from damper3d.studies.single_contact import Found
from damper3d.studies.single_contact.particles.axisymmetric_fe import Body, tube, wall
from damper3d.studies.single_contact.particles.contact_limit import sum_is_smooth_at
from damper3d.studies.single_contact.particles.ring_contact import (
    Contact,
    press,
    quarter,
    shear,
    stick_stiffness,
    tilt,
    yields,
)
from damper3d.studies.single_contact.particles.shape_shear import (
    Smooth,
    Way,
    legend,
    of_sub_spheres,
    panel,
    shifts,
)
from damper3d.studies.single_contact.particles.smooth_body import Elastic, ring_force, ring_width
from damper3d.studies.single_contact.particles.steel_shapes import RING, TUBE, settings, steel
from granulab.campaign.output.figure import headline

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ALL = 0.999  # of mu N: it slides
_MARGIN = 1.3  # fine elements reach so far, in half widths of the contact


class Mesh(NamedTuple):
    """Fineness of the elements and of the directions round the ring."""

    elements: int = 8  # in the half width of the contact; points lie about half as far apart
    harmonics: int = 4  # 1, 3, 5, 7


def toroid_on_wall(
    material: Elastic, overlap: float, elements: int, rigid: bool = True
) -> tuple[tuple[Body, Body], Contact]:
    """The thesis's toroid and its wall, pressed by an overlap [m].

    elements: in the half width of the contact.
    rigid: its middle plane is moved as one in shear; else an even force on its volume moves it.
    """
    width = float(ring_width(material, RING, TUBE, np.array([overlap]))[0]) / TUBE
    body = tube(material, RING, TUBE, width / elements, _MARGIN * width, rigid=rigid)
    bodies = body, wall(material, body.places[0])
    return bodies, press(bodies, overlap)


def smooth_toroid(
    material: Elastic, friction: float, overlap: float, mesh: Mesh
) -> tuple[Smooth, dict[str, float]]:
    """The smooth body's contact with its curve, and what its finite elements are good for.

    Stiffnesses in N/m: of the contact that sticks; with half as many elements; and of a body that
    an even force moves, where the shift is that of its mean point. Changes are over mu N.
    """
    bodies, contact = toroid_on_wall(material, overlap, mesh.elements)
    own = yields(bodies, contact, mesh.harmonics)
    here = quarter(contact, friction, own)
    stiffness, limit = stick_stiffness(here), friction * contact.force
    bare = Smooth(contact.force, stiffness, limit)
    forces = shear(here, shifts(bare))
    fewer = shear(quarter(contact, friction, own[: mesh.harmonics // 2]), shifts(bare))
    coarse, moved = (
        _stick(material, overlap, elements, rigid)
        for elements, rigid in ((mesh.elements // 2, True), (mesh.elements, False))
    )
    closed = float(ring_force(material, RING, TUBE, np.array([overlap]))[0])
    return bare._replace(slip=(shifts(bare), forces)), {
        "overlap_m": overlap,
        "normal_force_n": contact.force,
        "normal_force_over_closed_form": contact.force / closed,
        "stiffness_n_m": stiffness,
        "stiffness_with_half_the_elements_n_m": coarse,
        "stiffness_of_a_body_moved_by_an_even_force_n_m": moved,
        "change_by_half_the_harmonics": float(np.abs(fewer - forces).max()) / limit,
        "slides_at_over_simplified": float(np.interp(_ALL * limit, forces, shifts(bare)))
        * stiffness
        / limit,
        "tilt_over_overlap": tilt(bodies, contact, friction),
    }


def _stick(material: Elastic, overlap: float, elements: int, rigid: bool) -> float:
    """Stiffness before any slip [N/m], in which all is of the first harmonic."""
    bodies, contact = toroid_on_wall(material, overlap, elements, rigid)
    return stick_stiffness(quarter(contact, 1.0, yields(bodies, contact, 1)))


def compute(mesh: Mesh | None = None) -> Found:
    """Curves of the toroid with each number of sub-spheres and each multi-contact model."""
    material, law = steel()
    largest = float(_way("").setting.overlaps[-1])
    overlaps = largest, sum_is_smooth_at(RING, TUBE, 50, material)
    rows: list[dict[str, Any]] = []
    numbers: dict[str, Any] = {"friction": law.mu}
    for overlap in overlaps:
        way = _way(f"toroid lying, pressed by {1e6 * overlap:.3g} um")
        smooth, found = smooth_toroid(material, law.mu, overlap, mesh or Mesh())
        numbers[f"{way.name}, finite elements"] = found
        departures, mine = of_sub_spheres(way, material, law, smooth)
        numbers |= departures
        rows += mine
    remarks = (
        "most above, most below: the sub-spheres' less the finite elements' force over mu N",
        "simplified: the finite elements' stiffness up to mu N",
        "forces are divided by 10^3 G pi r s_max (eq. 5.17) in the figure",
    )
    return Found(numbers, rows, remarks)


def _way(name: str) -> Way:
    (lying,) = (setting for setting in settings() if setting.key == "toroid lying")
    return Way(name, "5.10b", True, lying, lying.orientation)


def draw(found: Found) -> "Figure":
    """A panel for each normal force."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.5, 4.6), layout="constrained")
    names = list(dict.fromkeys(row["particle"] for row in found.rows))
    for axes, name in zip(figure.subplots(1, len(names)).flat, names, strict=True):
        rows = [row for row in found.rows if row["particle"] == name]
        panel(axes, _way(name), rows)
    legend(figure, axes, "10, 20, 100 sub-spheres, sum", "smooth body, finite elements")
    headline(figure, "Lying steel toroid shifted on a flat wall under the same normal force")
    return figure
