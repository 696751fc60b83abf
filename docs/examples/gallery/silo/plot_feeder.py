r"""
A feeder under an insert
========================

Does a feeder set the flow, and what does a wedge above it bear? The outlet stays closed, and
every 1/rate the lowest particle over it is taken. Contacts by eqs 2.2 and 2.3 of the wood-silo
paper.

On the command line, without the wedge, which a case file has::

    $ silo2d run A4 --fill-level "180 mm" --feed-rate "200 1/s" --max-time "0.5 s" \
          --no-figures
      mean rate        200 particles/s, 2.08 kg/s until then
"""

import matplotlib.pyplot as plt
import numpy as np

from silo2d import SiloCase, run

# %%
# An insert is a simple polygon inside the silo; here corners in mm.
wedge = [[-30, 100], [30, 100], [0, 150]]
changes = {"fill.level": "180 mm", "silo.inserts": [wedge], "flow.feed_rate": "200 1/s",
           "run.max_time": "0.5 s"}  # fmt: skip
result = run(SiloCase.load("A4", changes))
records = result.records()

figure, (count, force) = plt.subplots(2, sharex=True, layout="constrained")
records["n_out"].plot(ax=count, ylabel="particles out [-]")
sides = [name for name in records if "insert" in name and name.endswith("_y")]
(-records[sides].sum(axis=1)).plot(ax=force, ylabel="weight on the wedge [N]")
force.set_xlabel("time [s]")

# %%
# The feeder takes a particle every 5 ms; the first and the last time are known to a step each.
times = np.sort(result.trajectory()["out_time"][-1])
times = times[np.isfinite(times)]
rate = (len(times) - 1) / np.ptp(times)
print(f"{len(times)} particles, {rate:.3f} 1/s")
assert abs(rate / 200 - 1) < 2 * result.time_step_s / np.ptp(times)
