"""
Sub-spheres and sphericity of a toroid
======================================

How well do 50 spheres stand for a toroid? Hole ratio 0.2, as in Table 8.2 of the thesis;
sphericity by eq. 8.3, cbrt(36 pi V^2)/S.

On the command line::

    $ damper3d shape --toroid 0.2 --no-figures
    sphericity               0.7816 (eq. 8.3)
"""

import math

import matplotlib.pyplot as plt
from matplotlib.patches import Circle

from damper3d import DamperCase

# %%
case = DamperCase.load("thesis", {"particles.shape": "toroid:0.2"})
shape = case.particle
print(case.count, shape.name, f"sphericity {shape.sphericity:.4f}")

# %%
# The sub-spheres, seen along the axis.
axes = plt.gca()
for (x, y, _), radius in zip(1e3 * shape.offsets, 1e3 * shape.radii, strict=True):
    axes.add_patch(Circle((x, y), radius, fill=False, linewidth=0.5))
axes.set(xlabel="x [mm]", ylabel="y [mm]", aspect="equal", xlim=(-5, 5), ylim=(-5, 5))

# %%
# Pappus: V = 2 pi^2 a b^2 and S = 4 pi^2 a b of a tube of radius b round a circle of radius a.
# The hole ratio is (a - b)/(a + b), so b/a = (1 - 0.2)/(1 + 0.2), and the size cancels. What is
# left is round-off.
a, b = 1.0, 0.8 / 1.2
volume, area = 2 * math.pi**2 * a * b**2, 4 * math.pi**2 * a * b
assert abs(shape.sphericity / (math.cbrt(36 * math.pi * volume**2) / area) - 1) < 1e-12
