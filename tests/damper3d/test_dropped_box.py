"""No rebound of a cylinder partially filled with particles (Pacheco-Vazquez and Dorbolo 2013)."""

import pytest

from damper3d.case.case import DamperCase
from damper3d.studies.dropped import rebound

# 150 spheres of 5 mm fill 27 of 100 mm; dropped from 100 mm.
BOX = {"enclosure.diameter": "30 mm", "enclosure.height": "100 mm", "particles.count": 150,
       "run.time_step": "2 us"}  # fmt: skip
DROP = 0.1


@pytest.mark.validation  # compiles kernels of its own
@pytest.mark.parametrize("restitution", [0.5, 0.9])
def test_a_nearly_empty_box_rebounds_as_the_empty_one(restitution):
    """To e0^2 of the drop, less what the bed takes.

    Of a ratio r that is at most 2 r (1 + e0) v from the box's e0 v, and heights go as the square:
    a part of at most 4 r (1 + e0)/e0.
    """
    case = DamperCase.load("thesis", BOX | {"particles.count": 20})
    least = 1e-3 * restitution
    taken = 4 * least * (1 + restitution) / restitution
    empty = rebound(case, least, restitution, drop=0.02)
    assert (1 - taken) * restitution**2 < empty < restitution**2


@pytest.mark.validation
@pytest.mark.parametrize("restitution", [0.5, 0.7, 0.9])
def test_a_dropped_cylinder_with_enough_particles_has_no_rebound(restitution):
    """Below 2 % of the drop where the particles have 1.5 e0 times its mass.

    A sixth of that mass is not enough, so that the limit of 2 % can be missed.
    """
    case = DamperCase.load("thesis", BOX)
    assert rebound(case, 0.25 * restitution, restitution, DROP) > 0.05
    assert rebound(case, 1.5 * restitution, restitution, DROP) < 0.02
