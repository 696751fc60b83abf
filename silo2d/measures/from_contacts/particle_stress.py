"""The mean stress in each grain, from the contacts that a run folder keeps at some frames.

    sigma = - (1/A) sum_c f_c (x) b_c

over the contacts of a grain of area A: f the force on it, b the branch from its centroid to the
contact point (Christoffersen, Mehrabadi, Nemat-Nasser 1981, J. Appl. Mech. 48, 339); pressure is
positive. Weight and acceleration act at the centroid and add nothing; what spinning adds is left
out. Of the plane [N/m]: divide by the prisms' length for pascals.
"""

import numpy as np
from numpy.typing import NDArray

from granulab.campaign.runs.ragged import Tables
from silo2d.measures.from_contacts.contacts import branches, moment_at
from silo2d.measures.from_contacts.particles import areas
from silo2d.view.scene import Scene

Floats = NDArray[np.float64]


def grain_stress(scene: Scene, contacts: Tables, frame: int) -> Floats | None:
    """Mean stress in all grains (n, 2, 2), its symmetric part [N/m]; None without contacts then.

    It is not symmetric by itself while a torque turns the grain. The area is that of the outline
    in the run folder, some 0.04 % small.
    """
    found = np.flatnonzero(contacts.frame == frame)
    if not len(found):
        return None
    moment = moment_at(scene, contacts, int(found[0]))
    grain, start, end, force = branches(moment)
    total = np.zeros((scene.n_grains, 2, 2))
    np.add.at(total, grain, force[:, :, None] * (end - start)[:, None, :])
    stress = -total / areas(scene)[:, None, None]
    return 0.5 * (stress + stress.transpose(0, 2, 1))
