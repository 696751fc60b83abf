"""
The clearance for a structure
=============================

How much room does a bed need above it, to damp best at a given frequency and level? The clearance
whose bouncing bed sets in there, h = pi Gamma g/omega^2 (thesis, eq. 6.11).

On the command line::

    $ damper3d predict --for 60,5 --no-figures
      for 60 Hz and Gamma 5 a clearance of 1.084 mm; ...
"""

import matplotlib.pyplot as plt
import numpy as np

from damper3d.case.closed_forms import clearance_for

# %%
frequency = np.geomspace(20, 200)  # [Hz]
for gamma in (2, 5, 10, 20):
    plt.loglog(frequency, 1e3 * clearance_for(frequency, gamma), label=f"Gamma {gamma}")
plt.gca().set(xlabel="frequency [Hz]", ylabel="clearance [mm]")
plt.legend()

# %%
# At that clearance the amplitude of the enclosure, Gamma g/omega^2, is 1/pi of it; what is left
# is round-off.
amplitude = 5 * 9.81 / (2 * np.pi * 60) ** 2
print(f"{1e3 * clearance_for(60, 5):.3f} mm")
assert abs(clearance_for(60, 5) / (np.pi * amplitude) - 1) < 1e-12
