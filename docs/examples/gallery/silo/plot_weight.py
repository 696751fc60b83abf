"""
What bears the weight
=====================

How much of the weight do walls and floor bear while a silo comes to rest? Silo D1, with a flat
floor, whose outlet of 40 mm clogs. Wall forces are means over the time between two frames.

On the command line::

    $ silo2d run D1 --fill-level "100 mm" --no-figures
    D1 (changed), seed 1: clogged ...
"""

from silo2d import SiloCase, run

# %%
result = run(SiloCase.load("D1", {"fill.level": "100 mm"}))
records = result.records()
weight = 9.81 * (result.mass_kg - result.mass_out_kg)  # of what is left inside [N]
print(result.outcome, f"{weight:.4f} N")

# %%
# A column for each wall and axis. Forces are those on the walls: downwards is negative.
vertical = [name for name in records if name.startswith("wall_force") and name.endswith("_y")]
bears = -records[vertical]
bears.columns = [name.removeprefix("wall_force_").removesuffix("_y") for name in vertical]
axes = bears.plot(xlabel="time [s]", ylabel="vertical force [N]", ylim=(-1, 20))
axes.axhline(weight, color="0.6", linestyle=":")

# %%
# At rest the forces balance the weight. Rest means a kinetic energy below 1e-4 of what lifts each
# particle by its size, a speed of up to sqrt(2 * 1e-4 g 14 mm) = 5 mm/s; that speed, gained or
# lost within the five frames of 10 ms, is 0.01 of g.
last = bears.sum(axis=1).iloc[-5:].mean()
print(f"{last:.4f} N")
assert abs(last / weight - 1) < 0.01
