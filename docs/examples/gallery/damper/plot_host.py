r"""
A damper on a structure that rings
==================================

How much faster does a structure come to rest with a damper on it? A structure of 60 g at 40 Hz
with a damping ratio of 0.01, let go, with 40 spheres and bare.

On the command line::

    $ damper3d run --diameter "20 mm" --height "20 mm" --count 40 --host-mass "60 g" \
          --host-frequency "40 Hz" --host-damping 0.01 --start-displacement "1 mm" \
          --time-step "2 us" --no-figures
      host             decay from 1 mm to 0.5 after ...
"""

import matplotlib.pyplot as plt
import numpy as np

from damper3d import DamperCase, run

# %%
host = {"enclosure.diameter": "20 mm", "enclosure.height": "20 mm", "particles.count": 40,
        "host.mass": "60 g", "host.frequency": "40 Hz", "host.damping_ratio": 0.01,
        "host.start_displacement": "1 mm", "run.time_step": "2 us"}  # fmt: skip
case = DamperCase.load("thesis", host)
result = run(case)

# %%
frames = result.trajectory()
time, omega = frames["time"], 2 * np.pi * 40
plt.plot(time, 1e3 * frames["displacement"], label="with 40 spheres")
for sign in (1, -1):
    plt.plot(time, sign * np.exp(-0.01 * omega * time), "0.6", label="bare" if sign > 0 else None)
plt.gca().set(xlabel="time [s]", ylabel="displacement [mm]")
plt.legend()

# %%
# A bed takes at most 4 V^2 m a cycle (thesis, eq. 6.10, at an efficiency of 1), of M V^2/2 in the
# structure. So the amplitude falls by at most 4 m/M + 2 pi zeta in logarithm a cycle, and by at
# least 2 pi zeta: the time to its half lies between.
half = result.host["decay_times_s"]["0.5"]
fastest = np.log(2) / 40 / (4 * case.mass / 0.06 + 2 * np.pi * 0.01)
bare = np.log(2) / (0.01 * omega)
print(f"half after {half:.3f} s; between {fastest:.3f} and {bare:.3f} s")
assert fastest < half < bare
