"""
How long two spheres touch
==========================

How does the time of contact go with the speed? Elastic impacts of a 5 mm acrylic sphere on a
wall, by the damper's law (thesis, eq. 5.7), against Hertz: 2.868 (m^2/(R E^2 v))^(1/5), with the
reduced mass, radius and modulus (Johnson, *Contact Mechanics*, 1985, eq. 11.24).

On the command line::

    $ damper3d impact --restitution 1 --friction 0 --speed 1
    contact time             41.88 us
"""

import matplotlib.pyplot as plt
import numpy as np

from damper3d.studies.single_contact.spheres.impact import Impact, run
from granulab.contact import load_table
from granulab.contact.reduced import reduced_modulus, sphere_mass

# %%
acrylic = load_table("acrylic").material("acrylic")
speeds = np.array([0.1, 0.3, 1.0, 3.0])  # [m/s]
times = [run(Impact(acrylic, acrylic, speed=speed)).contact_time_s for speed in speeds]

# %%
# At a wall the reduced mass and radius are those of the sphere.
modulus = reduced_modulus(*2 * (acrylic.youngs_modulus.value, acrylic.poisson.value))
mass = sphere_mass(2.5e-3, acrylic.density.value)
hertz = 2.868 * (mass**2 / (2.5e-3 * modulus**2 * speeds)) ** 0.2

plt.figure(layout="constrained")
plt.loglog(speeds, 1e6 * hertz, label="Hertz")
plt.loglog(speeds, 1e6 * np.array(times), "o", label="integrated")
plt.gca().set(xlabel="speed [m/s]", ylabel="time of contact [us]")
plt.legend()

# %%
# The constant has four digits, 2.868 +- 0.0005; the impact is integrated in 20,000 steps.
print(f"{1e6 * times[2]:.2f} us, Hertz {1e6 * hertz[2]:.2f} us")
assert abs(times[2] / hertz[2] - 1) < 0.0005 / 2.868 + 1 / 20000
