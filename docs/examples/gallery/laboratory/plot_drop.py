"""
Restitution from a film of a bouncing ball
==========================================

What is the coefficient of restitution of a ball on a plate? From the film that comes with the
project, rendered with e = 0.75 at every bounce; sqrt(H1/H0) (eq. 3.5 of the wood-silo paper) or
the ratio of successive flights.

On the command line::

    $ calibrate drop data/media/drop.mp4
    restitution 0.75 ...
"""

import matplotlib.pyplot as plt

from calibration import measure_drop
from granulab.contact import data_root

# %%
drop = measure_drop(data_root() / "media" / "drop.mp4")
print(drop.text().splitlines()[0])

# %%
# The track, and where the ball touches the plate. In pictures y counts downwards.
track = drop.bounces.track
plt.plot(track.frame, track.y, ".", markersize=3)
for contact in drop.bounces.contacts[:, 0]:
    plt.axvline(drop.frame(contact), color="0.8")
plt.gca().invert_yaxis()
plt.gca().set(xlabel="frame [-]", ylabel="y [px]")

# %%
# The truth is within four of the uncertainty given: a normal error is beyond that once in 16,000.
found = drop.restitution
assert abs(found.value - 0.75) < 4 * found.sigma
