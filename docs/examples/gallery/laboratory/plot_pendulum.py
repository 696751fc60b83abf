"""
Restitution from two blocks on strings
======================================

How much speed is left when two equal blocks collide? From the film that comes with the project,
rendered with e = 0.45 at every contact (eq. 3.6 of the wood-silo paper).

On the command line::

    $ calibrate pendulum data/media/pendulum.mp4
    restitution 0.4506 +- 0.00079, two blocks; ...
"""

import matplotlib.pyplot as plt

from calibration import measure_pendulum
from granulab.contact import data_root

# %%
pendulum = measure_pendulum(data_root() / "media" / "pendulum.mp4")
found = pendulum.restitution
print(f"restitution {found.value:.4f} +- {found.sigma:.4f}")

# %%
# Positions of both blocks, and the contacts.
for track, name in zip(pendulum.objects.tracks, ("left", "right"), strict=True):
    plt.plot(track.frame, track.x, ".", markersize=3, label=name)
for contact in pendulum.times[:, 0]:
    plt.axvline(pendulum.frame(contact), color="0.8")
plt.gca().set(xlabel="frame [-]", ylabel="x [px]")
plt.legend()

# %%
# The truth is within four of the uncertainty given: a normal error is beyond that once in 16,000.
assert abs(found.value - 0.45) < 4 * found.sigma
