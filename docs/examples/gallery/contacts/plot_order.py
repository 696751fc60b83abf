"""
Steps that a contact takes
==========================

How fine must the time step be? One elastic Hertz impact, in 50 to 800 steps: error of the largest
overlap, (15 m v^2/(16 E sqrt R))^(2/5), by the leapfrog of the engine.

On the command line, in 20,000 steps::

    $ damper3d impact --restitution 1 --friction 0 --speed 1
    largest overlap          14.23 um
"""

import matplotlib.pyplot as plt
import numpy as np

from damper3d.studies.single_contact.spheres.impact import Impact, run
from granulab.contact import load_table
from granulab.contact.reduced import reduced_modulus

# %%
acrylic = load_table("acrylic").material("acrylic")
impact = Impact(acrylic, acrylic, speed=1.0)
modulus = reduced_modulus(*2 * (acrylic.youngs_modulus.value, acrylic.poisson.value))
deepest = (15 * impact.mass / (16 * modulus * np.sqrt(impact.radius))) ** 0.4
print(f"{1e6 * deepest:.2f} um")

# %%
steps = np.array([50, 100, 200, 400, 800])
errors = [abs(run(impact, int(n)).max_overlap_m / deepest - 1) for n in steps]
plt.loglog(steps, errors, "o-")
plt.gca().set(xlabel="steps of a contact [-]", ylabel="error of the largest overlap [-]")

# %%
# The leapfrog is of second order, and the largest of the overlaps at the steps lies half a step
# from the turning point at most, which is of second order too: twice the steps, a quarter of the
# error, to the tenth that is usual for observed orders.
order = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
print(f"order {order:.2f}")
assert abs(order - 2) < 0.1
