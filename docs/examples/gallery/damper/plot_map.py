"""
A map of the efficiency, and its ridge
======================================

At which Gamma does a damper damp best, at each frequency? The thesis's damper 40 mm high
(committed results) with the onset of the bouncing bed, Gamma = omega^2 h/(pi g), of a bed packed
to 0.55 or 0.64 (thesis, eqs 6.11 and 6.13).

On the command line, the onsets alone::

    $ damper3d predict --height "40 mm" --no-figures
      close 0.64      10.87 mm   3.46 mm      5.57      22.3      89.1
"""

import matplotlib.pyplot as plt
import numpy as np

from damper3d.case.closed_forms import PACKINGS, bouncing_bed_onset, effective_clearance
from granulab.campaign import read_results
from granulab.contact import data_root

# %%
# Efficiency by the work of the walls, which leaves out what a bed that still packs down gives
# itself.
results = data_root().parent / "docs" / "results" / "damper3d"
_, rows = read_results(results / "reproduce-map.csv")
rows = [row for row in rows if row["orientation"] == "vertical" and row["height_mm"] == 40]
rows = [row for row in rows if row["diameter_mm"] == 5]
frequency, gamma = (sorted({row[key] for row in rows}) for key in ("frequency_hz", "gamma"))
efficiency = np.full((len(gamma), len(frequency)), np.nan)
for row in rows:
    at = gamma.index(row["gamma"]), frequency.index(row["frequency_hz"])
    efficiency[at] = row["efficiency_wall_work"]

# %%
plt.pcolormesh(frequency, gamma, efficiency, shading="nearest")
plt.colorbar(label="efficiency [-]")
for packing in PACKINGS.values():
    clearance = effective_clearance(rows[0]["fill_ratio"], 40e-3, packing)
    plt.plot(frequency, bouncing_bed_onset(frequency, clearance), "w")
plt.gca().set(xscale="log", yscale="log", xlabel="frequency [Hz]", ylabel="Gamma [-]")
plt.ylim(gamma[0], gamma[-1])

# %%
# A bed is packed between random loose and random close packing. So the best Gamma beyond that of
# fluidisation (below 8) lies between the onsets of the two, to a step of the map.
onset = [
    float(bouncing_bed_onset(40, effective_clearance(rows[0]["fill_ratio"], 40e-3, packing)))
    for packing in PACKINGS.values()
]
bouncing = [g for g in gamma if g > 8]
best = bouncing[int(np.nanargmax(efficiency[-len(bouncing) :, frequency.index(40)]))]
print(f"best at Gamma {best:g}; onsets {onset[0]:.1f} and {onset[1]:.1f}")
assert onset[0] < best < onset[1]
