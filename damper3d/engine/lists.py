"""What the lists of pairs and of wall contacts share: outcomes of a search, skins, copies.

Skins follow the speed, so that a list lasts for a few tens of steps whatever it is.
"""

from damper3d.engine.state import N_HISTORY, STEP
from granulab.contact.jit import uncounted

DONE, NEAR_FULL, CLOSE_FULL, WALL_FULL, NOT_FINITE, TOO_DEEP = range(6)
DEEPEST = 0.25  # overlap over the sum of the radii that is taken for a failure

# How many steps a list should last, and by how much its skin changes where it does not. Short
# lists are quick to pass through, long ones to make; the cost is flat about these.
_SHORT, _LONG = 12, 40
_GROW, _SHRINK = 1.25, 0.9
_LEAST, _MOST = 0.002, 0.03  # of the close skin over the largest radius


@uncounted
def adapt(counts, lengths, skin, made, largest):
    """Widen a skin whose list was short-lived, and narrow one whose list lasted long."""
    lasted = counts[STEP] - counts[made]
    if 0 < lasted < _SHORT:
        lengths[skin] = min(_GROW * lengths[skin], _MOST * largest)
    elif lasted > _LONG:
        lengths[skin] = max(_SHRINK * lengths[skin], _LEAST * largest)


@uncounted
def copy(to, what, n):
    """The first n numbers of an array, into another."""
    for k in range(n):
        to[k] = what[k]


@uncounted
def copy_histories(to, histories, n):
    """The first n histories, into others."""
    for k in range(n):
        for h in range(N_HISTORY):
            to[k, h] = histories[k, h]


@uncounted
def copy_rows(to, rows):
    """As many rows of four as there is room for."""
    for i in range(len(to)):
        for c in range(4):
            to[i, c] = rows[i, c]
