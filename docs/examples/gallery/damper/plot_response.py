r"""
Response of a structure from the field of its bed
=================================================

How does the resonance of a structure change with the level, once the effective mass of the bed is
known over frequency and amplitude? Harmonic balance with a committed field, on one mode of 0.2
kg.

On the command line::

    $ damper3d response docs/results/damper3d/field-host.toml \
          --field docs/results/damper3d/field.csv --levels 0.1,1,10 --no-figures
         0.1    0.03958 mm    0.03979 mm  0.03967 mm to 0.03991 mm  39.69 Hz      1.005
"""

import matplotlib.pyplot as plt
import numpy as np

from damper3d.studies.field.balance import respond
from damper3d.studies.field.structure import Structure
from damper3d.studies.field.table import read_field
from granulab.contact import data_root

# %%
field = read_field(data_root().parent / "docs" / "results" / "damper3d" / "field.csv")
structure = Structure.single(0.2, 40.0, 0.005, force=0.05)  # [kg], [Hz], [-], [N]
frequency = np.linspace(36, 44, 801)  # [Hz]
levels = (0.01, 0.3, 1.0, 3.0, 10.0)
found = respond(structure, field, frequency, levels)

# %%
plt.figure(layout="constrained")
for number, level in enumerate(levels):
    gain = found.stable[number] / level
    plt.semilogy(frequency, 1e3 * np.nanmax(gain, axis=1), label=f"level {level:g}")
plt.gca().set(xlabel="frequency [Hz]", ylabel="amplitude over level [mm]")
plt.legend()

# %%
# At low levels the bed rides along: the resonance falls with the root of the mass, 40 Hz by
# sqrt(M/(M + m)), known to a step of the frequencies; the field's least mass is 0.1 % off.
peak, _ = found.largest(0)
expected = 40 * np.sqrt(0.2 / (0.2 + field.bed_mass))
print(f"{peak:.2f} Hz, {expected:.2f} Hz")
assert abs(peak - expected) <= frequency[1] - frequency[0]
