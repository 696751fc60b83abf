"""
Clogging as statistics
======================

How does the mean number of particles between two clogs go with the outlet? A thousand avalanches
of silo D3 (committed results) with A exp(C (D/d)^2) (Janda et al., *EPL* 84 (2008) 44002) and A (1
- D/(d R_c))^-g (Zuriguel et al., *Phys. Rev. E* 71 (2005) 051303).

On the command line, for one outlet::

    $ silo2d clog D3 --fill-level "300 mm" --outlets "45 mm" --avalanches 40 --dry-run
"""

import matplotlib.pyplot as plt
import numpy as np

from granulab.campaign import read_results
from granulab.contact import data_root
from silo2d.measures.clogging.laws import Outlets, exponential, power

# %%
results = data_root().parent / "docs" / "results" / "silo2d" / "clogging"
_, rows = read_results(results / "clog-D3-wood19.csv")
outlets = sorted({row["outlet_m"] for row in rows})  # [m]
sizes = [np.concatenate([row["sizes"] for row in rows if row["outlet_m"] == outlet])
         for outlet in outlets]  # fmt: skip

# %%
# Maximum likelihood of both laws. None of these avalanches was cut off, so each ended with a
# clog.
seen = Outlets(np.array(outlets) / rows[0]["diameter_m"], np.array([s.sum() for s in sizes]),
               np.array([len(s) for s in sizes]))  # fmt: skip
fine = np.linspace(2.7, 4.7)
for law in (exponential(seen), power(seen)):
    print(f"{law.name}: AIC {law.aic:.1f}, p {law.p_value:.2f} of the scatter about it")
    plt.semilogy(fine, law.mean(fine), label=law.name)
mean = seen.exposure / seen.clogs
plt.errorbar(seen.across, mean, mean / np.sqrt(seen.clogs), fmt="ko")
plt.gca().set(xlabel="outlet over particle D/d [-]", ylabel="particles between two clogs [-]")
plt.legend()

# %%
# Neither law is refuted at 95 %: p is that of the scatter of the outlets about it, were it true.
assert min(exponential(seen).p_value, power(seen).p_value) > 0.05
