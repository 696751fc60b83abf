r"""
One particle that does not rebound
==================================

How much can a bed dissipate at most? A single sphere without gravity and almost without rebound
against the ideal bouncing bed: phi - sin phi = pi A0/A, eta = (1 - cos phi)^2/4, with A0 a 1/pi
of the clearance (thesis, eqs 6.10 and 6.11; Sack et al., *Phys. Rev. Lett.* 111 (2013) 018001).

On the command line, for one amplitude::

    $ damper3d run --diameter "10 mm" --height "10 mm" --count 1 --orientation none \
          --gamma 20.4956 --restitution 0.02 --friction 0 --cycles 12 --discard 6 --no-figures
    1 of sphere:5mm, none, 40 Hz, gamma 20.4956, seed 1: efficiency 0.700 ...
"""

import matplotlib.pyplot as plt
import numpy as np

from damper3d import DamperCase, run
from damper3d.case.closed_forms import bouncing_bed_onset, collect_and_collide

# %%
# The sphere has 5 mm, the enclosure 10 mm: a clearance of 5 mm.
onset = float(bouncing_bed_onset(40, 5e-3))  # Gamma at 40 Hz
block = {"enclosure.diameter": "10 mm", "enclosure.height": "10 mm", "particles.count": 1,
         "motion.orientation": "none", "law.restitution": 0.02, "law.friction": 0.0,
         "run.cycles": 12, "run.discard": 6}  # fmt: skip
ratios = np.array([1.2, 1.5, 2.0, 3.0, 4.0, 6.0])  # A/A0
efficiency = [
    run(DamperCase.load("thesis", block | {"motion.gamma": ratio * onset})).efficiency
    for ratio in ratios
]

# %%
fine = np.linspace(1, 6.5, 200)
plt.plot(fine, collect_and_collide(fine), label="closed form")
plt.plot(ratios, efficiency, "o", label="simulated")
plt.gca().set(xlabel="amplitude over that of the onset A/A0 [-]", ylabel="efficiency [-]")
plt.legend()

# %%
# A contact of 40 us is a phase of 0.01 at 40 Hz. The meeting may be late by that, and d eta/d
# phi, sin phi (1 - cos phi)/2, is at most 0.65; a rebound of e = 0.02 keeps 4e-4 of the energy.
found, expected = efficiency[2], float(collect_and_collide(2.0))
print(f"efficiency {found:.3f}, closed form {expected:.3f}")
assert abs(found - expected) < 0.65 * 0.01
