"""
Flow against outlet: Beverloo's law
===================================

Does the flow follow W = rho_b sqrt(g) C (D - k d)^1.5 (Beverloo, Leniger and van de Velde, *Chem.
Eng. Sci.* 15 (1961) 260), and does it need k? The rates are committed results
of a wide silo of small particles, with five outlets and three seeds each.

On the command line, one of these runs::

    $ silo2d run beverloo --outlet "46 mm" --dry-run
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.stats import chi2

from granulab.campaign import read_results
from granulab.contact import data_root
from silo2d.reproduce.quantities.beverloo_law import fit_law

# %%
# A table of results: its origin, and a row for each run.
results = data_root().parent / "docs" / "results" / "silo2d"
_, rows = read_results(results / "reproduce-beverloo.csv")
# A run that clogged has no rate.
rows = [row for row in rows if row["silo"] == "wide" and row["rate_kg_per_s"] is not None]
outlet = 1e-3 * np.array([row["outlet_mm"] for row in rows])  # [m]
rate, error, density = (
    np.array([row[key] for row in rows])
    for key in ("rate_kg_per_s", "error_kg_per_s", "bulk_density_kg_per_m2")
)

# %%
# C and k by least squares, with a band of 95 %.
fit = fit_law(outlet, rate, density, rows[0]["grain_diameter_m"], error)
print(f"C = {fit.c:.2f}, k = {fit.k:.2f}")

fine = np.linspace(0.033, 0.06)
plt.fill_between(fine, *fit.band(fine), color="0.9")
plt.plot(fine, fit.rate(fine))
plt.errorbar(outlet, rate, error, fmt="o")
plt.gca().set(xlabel="outlet D [m]", ylabel="mass flow [kg/s]")

# %%
# If the law holds, the squared deviations over the runs' own errors follow chi-squared with n - 2
# degrees of freedom, as two constants are fitted: they stay below its 95 % point. Without k, and
# with one constant, they do not. (The power is not tested: with k free, 2 fits these as well.)
deviation = np.sum(((rate - fit.rate(outlet)) / error) ** 2)
power = outlet**1.5 / error
without = np.sum((rate / error - power * (power @ (rate / error)) / (power @ power)) ** 2)
print(f"chi-squared {deviation:.1f}, without k {without:.1f}")
assert deviation < chi2.ppf(0.95, len(rate) - 2)
assert without > chi2.ppf(0.95, len(rate) - 1)
