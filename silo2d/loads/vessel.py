"""Geometry of a silo as the standard sees it: area, perimeter, characteristic width, hopper.

A slot is a slice between two parallel plates, as the plane simulations have it. Frictionless plates
carry nothing: only the two walls across the slot count, A/U = W/2, as in the simulation. Rough
plates count as two more walls, A/U = W L/(2 (W + L)).
"""

import math
from dataclasses import dataclass

from granulab.errors import InputError

HOPPERS = {"cone": 2, "pyramid": 2, "wedge": 1}  # directions in which a hopper converges
_FLAT = math.radians(85)  # half angle beyond which a bottom is flat: 5 deg from level (6.1.1)
RETAINING, SQUAT, SLENDER = 0.4, 1.0, 2.0  # h_c/d_c between the classes (5.1)


@dataclass(frozen=True)
class Vessel:
    """A silo of constant cross section over a hopper or a flat bottom; SI.

    plan          "circular", "rectangular" or "slot"
    width         diameter, or the smaller side; of a slot the distance of its walls
    length        larger side; of a slot the distance of its plates
    height        h_c, from the transition to the equivalent (levelled) surface
    half_angle    of the hopper, from the vertical [rad], of a pyramid that of the walls that are
                  `width` apart at its top; None: a flat bottom
    outlet        width of the outlet
    thin          whether the wall of a circular silo is thin, d_c/t > 200 (5.2.1)
    rough_plates  whether the plates of a slot rub
    """

    plan: str
    width: float
    length: float
    height: float
    half_angle: float | None = None
    outlet: float = 0.0
    hopper: str = "cone"
    thin: bool = True
    rough_plates: bool = False

    def __post_init__(self) -> None:
        if self.outlet >= self.width:
            raise InputError(
                f"outlet = {self.outlet:g} m: must be narrower than the silo, {self.width:g} m"
            )

    @property
    def area(self) -> float:
        """Of the cross section A [m2]."""
        if self.plan == "circular":
            return math.pi * self.width**2 / 4.0
        return self.width * self.length

    @property
    def perimeter(self) -> float:
        """Length of wall that rubs along the cross section, U [m]."""
        if self.plan == "circular":
            return math.pi * self.width
        if self.plan == "slot" and not self.rough_plates:
            return 2.0 * self.length
        return 2.0 * (self.width + self.length)

    @property
    def characteristic_width(self) -> float:
        """d_c [m]: diameter of the inscribed circle; of a slot with frictionless plates W."""
        if self.plan == "rectangular" or self.rough_plates:
            return min(self.width, self.length)
        return self.width

    @property
    def slenderness(self) -> float:
        """h_c/d_c [-]."""
        return self.height / self.characteristic_width

    @property
    def slenderness_class(self) -> str:
        """ "slender", "intermediate", "squat" or "retaining" (5.1)."""
        if self.slenderness >= SLENDER:
            return "slender"
        if self.slenderness > SQUAT:
            return "intermediate"
        return "retaining" if self.slenderness <= RETAINING and self.is_flat else "squat"

    @property
    def is_flat(self) -> bool:
        """True for a bottom that is level to 5 deg (6.1.1)."""
        return self.half_angle is None or self.half_angle >= _FLAT

    @property
    def hopper_height(self) -> float:
        """h_h [m], from the apex of the hopper to the transition."""
        assert self.half_angle is not None
        return self.width / 2.0 / math.tan(self.half_angle)

    @property
    def friction_shape(self) -> float:
        """S of EN 1991-4:2006, 6.1.2: 2 of cones and square pyramids, 1 of wedges, else 1 + b/a."""
        if self.hopper == "pyramid" and self.plan != "circular":
            return 1.0 + self.width / self.length
        return float(HOPPERS[self.hopper])

    @property
    def outlet_across(self) -> float:
        """Largest width of the outlet [m], which a rathole must not bridge: a slot's diagonal."""
        slot = self.hopper == "wedge" and self.outlet > 0
        return math.hypot(self.outlet, self.length) if slot else self.outlet

    @property
    def volume(self) -> float:
        """Of what is stored [m3], down to the outlet."""
        if self.is_flat:
            return self.area * self.height
        power = HOPPERS[self.hopper] + 1
        cut = 1.0 - (self.outlet / self.width) ** power  # the tip below the outlet
        return self.area * (self.height + self.hopper_height / power * cut)

    def highest_contact(self, repose: float, heap: bool) -> float:
        """h_o [m], depth of the highest contact of solid and wall below the equivalent surface.

        Under a heap d_c tan(phi_r)/6 in a circular silo and d_c tan(phi_r)/4 in a rectangular one
        (5.3.1.1); 0 under a level surface.
        """
        if not heap:
            return 0.0
        return self.characteristic_width * math.tan(repose) / (6 if self.plan == "circular" else 4)

    def pile_height(self, repose: float, heap: bool) -> float:
        """h_tp [m], from the highest contact with the wall to the top of the heap."""
        return self.characteristic_width / 2.0 * math.tan(repose) if heap else 0.0
