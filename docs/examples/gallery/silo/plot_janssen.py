"""
Pressure on the wall of a silo for wheat
========================================

How large are the pressures when the silo is filled and when it is emptied? Janssen's law with the
characteristic values of EN 1991-4:2006, table E.1: eqs 5.1 to 5.6, and C_h of 5.2.2.1.

On the command line::

    $ silo2d init my_silo.toml --loads
    $ silo2d loads --silo my_silo.toml
        pressure on the wall  0.328  0.599         26.8     6.37
"""

import matplotlib.pyplot as plt
import numpy as np

from silo2d.loads.janssen import janssen_stress

# %%
# A cylinder of 5 m by 15 m. Largest pressure: the least friction, with the largest lateral ratio.
unit_weight, diameter = 9e3, 5.0  # [N/m3], [m]
friction, ratio = 0.38 / 1.16, 0.54 * 1.11  # mu_m/a_mu and K_m a_K, wall D2
depth = np.linspace(0, 15, 101)
area_over_perimeter = diameter / 4
filled = ratio * janssen_stress(depth, unit_weight, friction * ratio, 2 * area_over_perimeter)
characteristic_depth = area_over_perimeter / (friction * ratio)
print(f"z_o = {characteristic_depth:.2f} m")

# %%
plt.plot(1e-3 * filled, depth, label="filled")
plt.plot(1.15e-3 * filled, depth, label="discharge, C_h = 1.15")
plt.axvline(1e-3 * unit_weight * area_over_perimeter / friction, color="0.6", linestyle=":")
plt.gca().set(xlabel="horizontal pressure [kPa]", ylabel="depth [m]", ylim=(15, 0))
plt.legend()

# %%
# At the depth z_o the stress is 1 - 1/e of what it tends to, gamma (A/U)/mu, by eq. 5.1; what is
# left is round-off.
at_depth = ratio * janssen_stress(characteristic_depth, unit_weight, friction * ratio, 2.5)
expected = (1 - np.exp(-1)) * unit_weight * area_over_perimeter / friction
assert abs(at_depth / expected - 1) < 1e-12
