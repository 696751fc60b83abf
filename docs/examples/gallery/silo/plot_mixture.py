"""
A mixture, and how far it comes apart
=====================================

Does a mixture of squares and hexagons segregate while it leaves a silo? Lacey's measure (*J.
Appl. Chem.* 4 (1954) 257) as an index: 0 on average where the parts are mixed at random, 1 where
apart.

On the command line, with the file that this script writes::

    $ silo2d run A4 --shapes mixture.toml --fill-level "150 mm" --no-figures
    $ silo2d observe runs/A4-seed1-*/ segregation
    square_at_opening ...
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from silo2d import SiloCase, observe, run
from silo2d.measures.segregation import segregation_index

# %%
Path("mixture.toml").write_text("""
schema = 1
spheroradius = "1 mm"
[[shape]]
name = "square"
form = "square"
size = "12 mm"
share = 3
[[shape]]
name = "hexagon"
form = "hexagon"
size = "7 mm"
""")
result = run(SiloCase.load("A4", {"fill.level": "150 mm", "particles.shapes": "mixture.toml"}))
found = observe(result.run_folder, "segregation")
plt.plot(found["time_s"], found["components"][0]["index"])
plt.axhline(0, color="0.6", linestyle=":")
plt.gca().set(xlabel="time [s]", ylabel="segregation index [-]", ylim=(-0.1, 1))

# %%
# Shapes are drawn by the seed, whatever their position: the bed before the opening is mixed at
# random. Its index is one of those of shuffled beds, which 4 of their standard deviations hold.
frames = result.trajectory()
cells = np.floor(np.column_stack([frames["x"][0], frames["y"][0]]) / found["cell_m"]).astype(int)
is_square, rng = frames.static["kind"] == 0, np.random.default_rng(1)
shuffled = [segregation_index(cells, rng.permutation(is_square)) for _ in range(200)]
print(f"{found['components'][0]['at_opening']:.4f}, shuffled 0 +- {np.std(shuffled):.4f}")
assert abs(found["components"][0]["at_opening"] - np.mean(shuffled)) < 4 * np.std(shuffled)
