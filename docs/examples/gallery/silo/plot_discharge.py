"""
A silo discharges
=================

How fast does a silo empty, and when is the flow steady? Silo A4 of Alonso-Marroquín et al.,
*Granular Matter* 15 (2013) 811, with a third of its filling; contacts by eqs 2.2 and 2.3.

On the command line::

    $ silo2d run A4 --fill-level "150 mm" --no-figures
    A4 (changed), seed 1: empty, ...
"""

import matplotlib.pyplot as plt

from silo2d import SiloCase, observe, run

# %%
# Every key of a case can be changed, by its section and name.
result = run(SiloCase.load("A4", {"fill.level": "150 mm"}))
print(result.outcome, f"after {result.discharge_time_s:.3f} s")

# %%
# The measure `curve` gives the flow over a moving window, and the time for which it is steady.
curve = observe(result.run_folder, "curve")

figure, (count, flow) = plt.subplots(2, sharex=True, layout="constrained")
result.records()["n_out"].plot(ax=count, ylabel="particles out [-]")
flow.plot(curve["times_s"], curve["mass_flow_kg_per_s"])
flow.axvspan(curve["steady_from_s"], curve["steady_until_s"], color="0.9")
flow.set(xlabel="time [s]", ylabel="mass flow [kg/s]")

# %%
# What the bed loses is dissipated, or carried out by the particles that leave. A run whose balance
# is off by more than 0.5 % of what is dissipated is done again in half the step.
records = result.records()
held = records[["kinetic", "potential", "elastic_normal", "elastic_tangential"]].sum(axis=1)
lost = held.iloc[0] - held.iloc[-1] - records["carried_out"].iloc[-1]
mechanisms = ("normal_damping", "tangential_damping", "friction")
dissipated = sum(records[name].iloc[-1] for name in records if name.startswith(mechanisms))
print(f"{dissipated:.3f} J dissipated, {lost:.3f} J lost")
assert abs(lost / dissipated - 1) < 0.005
