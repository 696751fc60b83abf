"""
Mass flow or funnel flow
========================

How steep must a hopper be for all of the solid to move? The end of Jenike's radial stress field
(1961, 1964) for cones, and his chart for wedges, over the friction of the wall.

On the command line, for wheat in a silo with a flat bottom::

    $ silo2d init my_silo.toml --loads
    $ silo2d loads --silo my_silo.toml
      Jenike            funnel flow: half angle 90 deg, mass flow up to 27 deg ...
"""

import math

import matplotlib.pyplot as plt
import numpy as np

from silo2d.loads.jenike import mass_flow_limit

# %%
# Half angles are from the vertical. Wheat has an effective angle of internal friction of 30 deg.
delta = math.radians(30)
walls = np.linspace(0, 30, 61)  # angle of wall friction [deg]
for name, plane in (("cone", False), ("wedge", True)):
    limits = [math.degrees(mass_flow_limit(delta, math.radians(wall), plane)) for wall in walls]
    plt.plot(walls, limits, label=name)
plt.gca().set(xlabel="angle of wall friction [deg]", ylabel="largest half angle [deg]")
plt.legend()

# %%
# The mean friction of wheat on a smooth wall, 0.38: a cone flows in mass up to this half angle.
wall = math.degrees(math.atan(0.38))
limit = math.degrees(mass_flow_limit(delta, math.radians(wall), False))

# %%
# In a cone the limit is 90 deg - acos((1 - sin delta)/(2 sin delta))/2 less half of phi and of
# asin(sin phi/sin delta). As sin delta = 1/2 the first two are 60 deg. What is left is round-off.
expected = 60 - (wall + math.degrees(math.asin(2 * math.sin(math.radians(wall))))) / 2
print(f"{limit:.0f} deg")
assert abs(limit - expected) < 1e-9
