r"""
Friction from a tilted plate, into a materials file
===================================================

Which friction do thirty trials of three pairings give, and how well is it known? mu = tan(alpha)
of the angle at first slip (sec. 3.1 of the wood-silo paper); angles made with the paper's
scatter.

On the command line::

    $ calibrate incline docs/examples/wood/tilt_wood.csv --instrument "angle=0.2 deg" \
          --into wood.toml --pair wood-wood
      all         0.371 +- 0.033, 30 trials, scatter 0.04 (11 %)
"""

import matplotlib.pyplot as plt
import numpy as np

from calibration import into, measure_incline
from granulab.contact import data_root

# %%
# All trials share the error of the zero of the plate's angle, 0.2 deg.
table = data_root().parent / "docs" / "examples" / "wood" / "tilt_wood.csv"
found = measure_incline(table, instruments={"angle": "0.2 deg"})
mean = found.quantities[0].pooled.all
print(f"{mean.value:.3f} +- {mean.sigma:.3f}")

# %%
# The value goes into a materials file with its uncertainty and source; `lacking` is what a
# simulator still needs.
written = into("wood.toml", "pair.wood-wood", "friction", mean, method="incline", source=table.name)
print(written.lacking)

pairing, angle = np.loadtxt(table, delimiter=",", skiprows=1, unpack=True)
each = np.tan(np.radians(angle))
plt.plot(pairing, each, "o")
plt.errorbar(2, mean.value, mean.sigma, fmt="ks", capsize=4)
plt.gca().set(xlabel="pairing [-]", ylabel="friction [-]", xticks=[1, 2, 3])

# %%
# The pairings differ by more than chance, so each counts once: the value is the mean of their
# means. What is left is round-off.
means = [each[pairing == k].mean() for k in (1, 2, 3)]
assert abs(mean.value - np.mean(means)) < 1e-12
