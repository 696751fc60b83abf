"""Energy that contacts dissipate, by mechanism and by sphere.

Each contact gives half of its loss to each of its spheres, with its torques (simd.add_loads). The
sums by mechanism run lane by lane over the blocks of a part, so that they are vectorised, and the
lanes are added up at its end: an order that the number of threads does not change.
"""

import numpy as np

from damper3d.engine.geometry import entry
from damper3d.engine.state import (
    BLOCK,
    FRICTION,
    LAW_TERM,
    N_MECHANISMS,
    NORMAL_DAMPING,
    SLIP_COUNT,
    TANGENTIAL_DAMPING,
)
from granulab.contact.jit import inlined_inner, inner

NOTHING = 0.0, 0.0, 0.0, 0.0, 0.0  # sums by mechanism, see take_totals


@inlined_inner
def add_dissipated(n_contacts, block):
    """Add what the contacts of a block dissipate to the totals by mechanism, lane by lane.

    They are exact zeros where nothing touches.
    """
    totals = block.totals
    for k in range(np.uintp(n_contacts)):
        totals[entry(NORMAL_DAMPING, k)] += block.normal_power[k]
        totals[entry(TANGENTIAL_DAMPING, k)] += block.tangential_power[k]
        totals[entry(FRICTION, k)] += block.friction_work[k]
        totals[entry(LAW_TERM, k)] += block.stiffness_work[k]
        totals[entry(SLIP_COUNT, k)] += block.slip_power[k]


@inlined_inner
def take_totals(block, n_contacts):
    """Sum the totals of the lanes, and wipe them: normal, tangential, friction, law term, slip.

    n_contacts: how many there were at most in a row, so that only so many lanes are not 0.
    """
    normal, tangential, friction_work, stiffness_work, slipped = NOTHING
    lanes = np.uintp(min(n_contacts, BLOCK))
    for k in range(lanes):
        normal += block.totals[entry(NORMAL_DAMPING, k)]
        tangential += block.totals[entry(TANGENTIAL_DAMPING, k)]
        friction_work += block.totals[entry(FRICTION, k)]
        stiffness_work += block.totals[entry(LAW_TERM, k)]
        slipped += block.totals[entry(SLIP_COUNT, k)]
    for c in range(N_MECHANISMS):
        for k in range(lanes):
            block.totals[entry(c, k)] = 0.0
    return normal, tangential, friction_work, stiffness_work, slipped


@inlined_inner
def added(a, b):
    """Sums by mechanism, of two."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4]


@inlined_inner
def add_to_balance(balance, first, sums, dt):
    """Add what was dissipated in this step to the balance of a class."""
    balance[first + NORMAL_DAMPING] += sums[0] * dt
    balance[first + TANGENTIAL_DAMPING] += sums[1] * dt
    balance[first + FRICTION] += sums[2]
    balance[first + LAW_TERM] += sums[3]
    balance[first + SLIP_COUNT] += sums[4] * dt


@inner
def take_heat(heat, torque, i):
    """Move what the contacts of sphere i dissipated in a step from its torque row to its heat."""
    heat[i] -= torque[i, 3]
