"""
What the particles do at four accelerations
===========================================

When does a bed leave the floor, and when does it bounce as one? Phases of the thesis's sections
6.3 and 6.4, named by stated criteria from what a run measures.

On the command line::

    $ damper3d run --diameter "20 mm" --height "20 mm" --count 40 --gamma 0.5 --no-figures
      motion           solid_like; ...
"""

import matplotlib.pyplot as plt
import numpy as np

from damper3d import DamperCase, run

# %%
small = {"enclosure.diameter": "20 mm", "enclosure.height": "20 mm", "particles.count": 40}
results = [
    run(DamperCase.load("thesis", small | {"motion.gamma": gamma})) for gamma in (0.5, 2, 8, 20)
]

# %%
# Height of the bed's centre of mass within the last cycle, in the enclosure.
for result in results:
    frames = result.trajectory()
    cycle = np.flatnonzero(frames["time"] > frames["time"][-1] - 0.025)
    height = frames["mean_position"][cycle, 2] - frames["displacement"][cycle]
    label = f"Gamma {result.gamma:g}: {result.phase.replace('_', ' ')}"
    plt.plot(40 * (frames["time"][cycle] - frames["time"][cycle[0]]), 1e3 * height, label=label)
plt.gca().set(xlabel="cycles [-]", ylabel="centre of mass over the floor [mm]")
plt.legend()

# %%
# Below Gamma 1 the floor's acceleration never passes that of free fall: nothing lifts off, and
# all particles are carried along. Beyond it some are not.
carried = [result.phase_measures["carried_share"] for result in results]
print(carried)
assert carried[0] == 1
assert carried[1] < 1
