"""
Restitution above the yield velocity
====================================

When does a sphere begin to yield, and how fast does its restitution fall? The yield velocity of
thesis eq. 5.26, and e0 (v_y/v)^(1/4) above it (Johnson, *Contact Mechanics*, 1985, sec. 11.5).

On the command line::

    $ damper3d impact --material steel --restitution 0.9 --friction 0 --yielding --speed 4.7676
    normal restitution       0.4500
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

from damper3d.studies.single_contact.spheres.impact import Impact, run
from granulab.contact import load_table

# %%
# A steel sphere of 5 mm on a wall of steel: reduced radius and mass are those of the sphere.
steel = load_table("steel").material("steel")
impact = Impact(steel, steel, restitution=0.9, yielding=True)
yield_velocity = impact.law.yielding * np.sqrt(impact.radius**3 / impact.mass)
print(f"yield velocity {yield_velocity:.3f} m/s")

# %%
speeds = yield_velocity * np.array([0.25, 0.5, 1, 2, 4, 8, 16])
restitution = [run(replace(impact, speed=speed)).normal_restitution for speed in speeds]
plt.figure(layout="constrained")
plt.loglog(speeds, restitution, "o-")
plt.axvline(yield_velocity, color="0.6", linestyle=":")
plt.gca().set(xlabel="speed [m/s]", ylabel="restitution [-]")

# %%
# At 16 times the yield velocity half of it is left. The impact is integrated in 20,000 steps of
# an elastic contact, whose results hold to 1e-4.
print(f"{restitution[-1]:.4f}")
assert abs(restitution[-1] - 0.9 / 2) < 1e-4
