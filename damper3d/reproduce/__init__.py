"""Tables and figures of the thesis, and ours: a table of names, each a module or a room here.

A module offers what granulab.campaign.cli.reproduce.PublishedTable says.
"""

from functools import partial
from typing import Any

from granulab.campaign.cli.reproduce import find_table

Row = dict[str, Any]

# name of the module, as in `damper3d reproduce TABLE`: what it shows
TABLES: dict[str, str] = {
    "causes": "the onset's rise to prolates, by what the thesis leaves open (thesis, Fig. 8.11)",
    "chapter": "the maps of 4 sizes, 4 fills and 2 orientations (thesis, chapter 6)",
    "cycles": "within the cycle (thesis, Figs 6.7, 6.10, 6.16 and 6.18)",
    "design-rules": "the design rules and the shape rule (thesis, secs 9.2 and 9.3)",
    "experiments": "two kinds of spheres on a shaker (thesis, chapter 7)",
    "map": "efficiency over frequency and Gamma, 4 fills (thesis, Figs 6.4 and 6.5)",
    "measured": "shaken and dropped beds that others measured",
    "optimum": "where the bouncing bed damps best (thesis, Table 6.3)",
    "packing": "how densely each shape packs (thesis, eq. 6.13 and sec. 8.5.1.2)",
    "phases": "names of the motion over frequency and Gamma (thesis, Figs 2.12, 6.2 and 6.3)",
    "printed": "printed numbers: fill, time step, impacts that yield (thesis, secs 6.2, 8.3)",
    "sensitivity": "the optimum against four properties (thesis, Fig. 6.13)",
    "shapes": "spheroids and toroids of unlike ratio (thesis, chapter 8)",
    "shares": "friction and particle-particle contacts (thesis, Figs 6.28, 6.29)",
    "sizes": "spheres of 3, 4, 5 and 6 mm (thesis, Figs 6.12, 6.22 and 6.26)",
}

find = partial(find_table, __name__)
