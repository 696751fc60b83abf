"""Energy that contacts dissipate, by mechanism and by sphere.

Each contact gives half of its loss to each of its spheres, with its torques. The sums by mechanism
go in the order of the list (simd.add_loads), to which contacts that do not touch add exact zeros:
so no bit of them depends on when a list was made, or on the number of threads.
"""

import numpy as np

from damper3d.engine.simd import add_loads
from damper3d.engine.state import (
    FRICTION,
    LAW_TERM,
    N_MECHANISMS,
    NORMAL_DAMPING,
    SLIP_COUNT,
    TANGENTIAL_DAMPING,
)
from granulab.contact.jit import inlined_inner, inner

NO_LOSS = 0.0, 0.0, 0.0, 0.0, 0.0  # sums by mechanism: of powers [W], but for friction's work [J]


@inlined_inner
def totals_so_far(block):
    """Sums by mechanism, of the blocks since they were taken."""
    totals = block.totals
    return totals[0], totals[1], totals[2], totals[3], totals[4]


@inlined_inner
def add_and_sum(spheres, to_i, to_j, touching, begin, n_contacts, block):
    """Add the loads of a block to rows, see add_loads, and what its contacts lose to the sums."""
    sums = totals_so_far(block)
    sums = add_loads(spheres, to_i, to_j, touching, begin, n_contacts, block, sums)
    for c in range(np.uintp(N_MECHANISMS)):
        block.totals[c] = sums[c]


@inlined_inner
def take_totals(block):
    """Sums by mechanism, with what laws added to those of their own; wipes both."""
    own = block.own_totals
    sums = added(totals_so_far(block), (own[0], own[1], own[2], own[3], own[4]))
    for c in range(np.uintp(N_MECHANISMS)):
        block.totals[c] = block.own_totals[c] = 0.0
    return sums


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
