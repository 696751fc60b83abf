"""
A hot floor: the Leidenfrost effect
===================================

Where are the fastest particles at 160 Hz and Gamma 12? The thesis's damper, in the phase for
which its section 6.4 gives 12 < Gamma < 80 above 40 Hz.

On the command line::

    $ damper3d run --frequency 160 --gamma 12 --no-figures
      motion           leidenfrost; ...
"""

import matplotlib.pyplot as plt
import numpy as np

from damper3d import DamperCase, run
from granulab.campaign import read_tables

# %%
result = run(DamperCase.load("thesis", {"motion.frequency": 160, "motion.gamma": 12}))
frames = result.trajectory()

# %%
# Kinetic energy against the bed's mean motion, by height over the floor, over the counted cycles.
particles = read_tables(result.run_folder, "particles")
height, energy = [], []
for k in range(len(particles)):
    if particles.frame[k] < 300:  # the first three cycles of 100 samples do not count
        continue
    one = particles.at(k)
    height.append(one["z"] - frames["displacement"][particles.frame[k]])
    velocity = np.column_stack([one["vx"], one["vy"], one["vz"]])
    energy.append(0.5 * np.sum((velocity - velocity.mean(axis=0)) ** 2, axis=1))
height, energy = np.concatenate(height), np.concatenate(energy)
layers = np.linspace(0, 0.04, 11)
layer = np.digitize(height, layers)
plt.plot([energy[layer == k].mean() for k in range(1, 11)], 500 * (layers[1:] + layers[:-1]), "o-")
plt.gca().set(xlabel="kinetic energy over mass [J/kg]", ylabel="height over the floor [mm]")

# %%
# The phase has this name where the lowest fifth of the particles has at least twice the energy of
# the middle fifth, while most of them travel and are not packed.
hot = result.phase_measures["hot_low"]
print(result.phase, f"{hot:.1f}")
assert hot > 2
