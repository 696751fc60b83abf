"""
An oblique impact that slides throughout
========================================

How much does a sphere rotate after it hit a wall at an angle? Chung and Ooi, *Granular Matter* 13
(2011) 643: while it slides all the time its angular velocity is 5 mu (1 + e) v_n/(2 R).

On the command line::

    $ damper3d impact --material alumina --speed 3.9 --angle 45
    angular velocity         501 rad/s
"""

import matplotlib.pyplot as plt
import numpy as np

from damper3d.studies.single_contact.spheres.impact import Impact, run
from granulab.contact import load_table

# %%
# A sphere of aluminium oxide, of 5 mm, at 3.9 m/s.
alumina = load_table("alumina").material("alumina")
friction, restitution, speed, radius = 0.092, 0.98, 3.9, 2.5e-3
angles = np.radians([2, 5, 10, 15, 20, 30, 45, 60, 75, 85])
spins = [
    run(Impact(alumina, alumina, radius=radius, speed=speed, angle=angle, friction=friction,
               restitution=restitution)).spin_rad_s
    for angle in angles
]  # fmt: skip

# %%
sliding = 5 * friction * (1 + restitution) * speed * np.cos(angles) / (2 * radius)
plt.plot(np.degrees(angles), sliding, label="sliding throughout")
plt.plot(np.degrees(angles), spins, "o", label="integrated")
plt.gca().set(xlabel="angle from the normal [deg]", ylabel="angular velocity after [rad/s]")
plt.legend()

# %%
# Beyond tan(angle) = 7/2 mu (1 + e), 33 deg, it slides throughout. The contact point lies nearer
# to the centre than the radius, by up to the overlap: 10 um of 2.5 mm, for which the closed form
# has no term.
print(f"{spins[6]:.1f} rad/s, closed form {sliding[6]:.1f} rad/s")
assert 0 < 1 - spins[6] / sliding[6] < 10e-6 / radius
