"""
The arch that a silo clogs with
===============================

Which particles hold up the rest? Silo A1 with an outlet of 30 mm, about two particles wide, which
clogs at once. The arch is found in the contacts of the last frame: the lowest chain of
load-bearing contacts from wall to wall.

On the command line::

    $ silo2d run A1 --outlet "30 mm" --fill-level "150 mm" --no-figures
    A1 (changed), seed 1: clogged ...
    $ silo2d observe runs/A1-seed1-*/ arch
    span_m ...
"""

import matplotlib.pyplot as plt
import numpy as np

from silo2d import SiloCase, observe, run

# %%
result = run(SiloCase.load("A1", {"silo.outlet": "30 mm", "fill.level": "150 mm"}))
arch = observe(result.run_folder, "arch")
print(result.outcome, f"span {arch['span_m']:.4f} m, rise {arch['rise_m']:.4f} m")

# %%
# The line runs through contact points and centroids, from foot to foot.
frames = result.trajectory()
inside = frames["inside"][-1]
x, y = np.array(arch["line_m"]).T
plt.scatter(frames["x"][-1][inside], frames["y"][-1][inside], color="0.8")
plt.plot(x, y, "o-")
plt.plot([-0.015, 0.015], [0, 0], "k", linewidth=3)
plt.gca().set(xlabel="x [m]", ylabel="y [m]", aspect="equal")

# %%
# Both feet stand on walls, and there is none within the outlet: the span is at least the outlet.
assert arch["span_m"] > 0.030
