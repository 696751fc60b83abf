"""Contacts of a list that touch, or did a step ago: the only ones that the laws are applied to.

In a bed that flies few of the pairs that may touch do. Finding out takes their places alone; what
is left out would add exact zeros, so that no bit depends on it. What touched a step ago is asked
once more, so that its history ends.
"""

import numpy as np

from damper3d.engine.geometry import vector
from damper3d.engine.simd import separate, whole
from damper3d.engine.state import BLOCK, DAMPING
from damper3d.engine.walls import clear_of_wall
from granulab.contact.jit import inlined

_ROUNDING = 1.0 + 1e-12  # squares may say "apart" where the root, rounded, says "touching"


@inlined
def touching_pairs(spheres, contacts, n_contacts, block):
    """Return how many of the first contacts of a list touch; `touching` names them."""
    found = np.int64(0)  # a typed number: numba would compile the passes once more for a literal
    for begin in range(np.int64(0), n_contacts, BLOCK):
        n = min(n_contacts - begin, BLOCK)
        separate(spheres, contacts, begin, n, block)
        for k in range(np.uintp(whole(n))):
            x, y, z = vector(block.separation, k)
            reach = contacts.reach[np.uintp(begin) + k]
            block.clearance[k] = x * x + y * y + z * z - _ROUNDING * (reach * reach)
        found = note_touching(contacts, begin, n, block, found)
    return found


@inlined
def touching_wall(spheres, walls, contacts, w, block):
    """The same of the contacts with wall w."""
    found = np.int64(0)
    for begin in range(walls.first[w], walls.first[w + 1], BLOCK):
        n = min(walls.first[w + 1] - begin, BLOCK)
        separate(spheres, contacts, begin, n, block)
        clear_of_wall(walls, w, contacts, begin, whole(n), block)
        found = note_touching(contacts, begin, n, block, found)
    return found


@inlined
def note_touching(contacts, begin, n_contacts, block, found):
    """Append those of a block that touch or did a step ago to `touching`; its new length.

    Each is written, and only counted where it is one of them: a branch that nobody could foresee
    would cost more.
    """
    for k in range(np.uintp(n_contacts)):
        n = np.uintp(begin) + k
        contacts.touching[found] = n
        lasts = contacts.history[n, DAMPING] >= 0.0
        found += np.int64((block.clearance[k] < 0.0) | lasts)
    return found
