"""The mean stress in each grain, from the contacts that a run folder keeps at some frames.

    sigma = - (1/A) sum_c f_c (x) b_c

over the contacts of a grain of area A: f the force on it, b the branch from its centroid to the
contact point (Christoffersen, Mehrabadi, Nemat-Nasser 1981, J. Appl. Mech. 48, 339); pressure is
positive. Weight and acceleration act at the centroid and add nothing; what spinning adds is left
out. Of the plane [N/m]: divide by the prisms' length for pascals.
"""

import numpy as np
from numpy.typing import NDArray

from campaign.ragged import Tables
from silo2d.scene import Scene

Floats = NDArray[np.float64]


def grain_stress(scene: Scene, contacts: Tables, frame: int) -> Floats | None:
    """Mean stress in all grains (n, 2, 2), its symmetric part [N/m]; None without contacts then.

    It is not symmetric by itself while a torque turns the grain. The area is that of the outline
    in the run folder, some 0.04 % small.
    """
    found = np.flatnonzero(contacts.frame == frame)
    if not len(found):
        return None
    table, trajectory, n = contacts.at(int(found[0])), scene.trajectory, scene.n_grains
    centre = np.column_stack([trajectory["x"][frame], trajectory["y"][frame]]).astype(np.float64)
    moment = np.zeros((n, 2, 2))
    for side, sign in ((0, -1.0), (1, 1.0)):  # the force is that on the second body
        body = table["bodies"][:, side].astype(np.int64)
        of_grain = body < n  # walls come after the grains
        grain, point = body[of_grain], table["point"][of_grain].astype(np.float64)
        force = sign * table["force"][of_grain].astype(np.float64)
        np.add.at(moment, grain, force[:, :, None] * (point - centre[grain])[:, None, :])
    stress = -moment / _areas(scene)[:, None, None]
    return 0.5 * (stress + stress.transpose(0, 2, 1))


def _areas(scene: Scene) -> Floats:
    """Of the grains' outlines (n,) [m2]."""
    static = scene.trajectory.static
    outlines = np.split(static["shape_points"], static["shape_start"][1:-1])
    areas = np.array([_area(x, y) for x, y in (outline.T for outline in outlines)])
    return areas[static["kind"]]


def _area(x: Floats, y: Floats) -> float:
    return float(0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)))
