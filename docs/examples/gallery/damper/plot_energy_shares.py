"""
Where a damper's energy goes
============================

Which contacts dissipate, and by which mechanism? A small damper of 40 acrylic spheres at Gamma
20, with the contact law of F. Terzioglu's thesis (Sheffield 2023), eqs 5.7, 5.14, 5.22, 5.32 and
5.33.

On the command line::

    $ damper3d run --diameter "20 mm" --height "20 mm" --count 40 --gamma 20 --no-figures
      energy           balance closed to ...
"""

import matplotlib.pyplot as plt

from damper3d import DamperCase, run

# %%
small = {"enclosure.diameter": "20 mm", "enclosure.height": "20 mm", "particles.count": 40}
result = run(DamperCase.load("thesis", small | {"motion.gamma": 20}))
print(f"efficiency {result.efficiency:.3f}")

# %%
# Shares of what is dissipated in the counted cycles, by pair and mechanism.
shares = {
    f"{pair}, {mechanism}".replace("_", " "): share
    for pair, parts in result.shares.items()
    for mechanism, share in parts.items()
}
plt.figure(layout="constrained")
plt.barh(list(shares), list(shares.values()))
plt.xlabel("share of the dissipated energy [-]")

# %%
# Each mechanism is integrated by itself. Their sum is the work of the walls less the change of
# the bed's kinetic, potential and elastic energy, to the error of the integration: the square of
# the step over the contact time, (1/40)^2 at 1 us, times the number of terms, 8.
print(f"balance closed to {100 * abs(result.energy_closure):.2g} %")
assert abs(result.energy_closure) < 8 / 40**2
