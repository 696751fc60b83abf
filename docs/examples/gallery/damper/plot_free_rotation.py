"""
A particle that rotates freely
==============================

How exact is the rotation of a particle of any shape? An ellipsoid 1 : 0.75 : 0.5 that begins near
its middle axis, against Jacobi's elliptic functions (Landau and Lifshitz, *Mechanics*, sec. 37).

On the command line::

    $ damper3d contact free-rotation --no-figures
      order_of_spin                          2
"""

import matplotlib.pyplot as plt
import numpy as np

from damper3d.studies.single_contact.particles.free_rotation import (
    SPIN,
    jacobi,
    moments,
    own_spin,
    triaxial,
    turning,
)

# %%
# Largest error of the angular velocity after 0.05 s, over its largest component.
body = triaxial()
exact = jacobi(moments(body), np.array(SPIN), np.array([0.05]))[0]
steps, errors = np.array([4e-4, 2e-4, 1e-4, 5e-5]), []  # [s]
for step in steps:
    sim = turning(body, SPIN, step)
    sim.step(round(0.05 / step))
    errors.append(np.abs(own_spin(sim) - exact).max() / np.abs(exact).max())
plt.loglog(1e6 * steps, errors, "o-")
plt.gca().set(xlabel="time step [us]", ylabel="error of the angular velocity [-]")

# %%
# The scheme is of second order: half the step, a quarter of the error. The next term is of the
# step squared again, 1e-3 of the error at these steps; 0.01 leaves room for a root in the sizes.
order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
print(f"order {order:.3f}")
assert abs(order - 2) < 0.01
