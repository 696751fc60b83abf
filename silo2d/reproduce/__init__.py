"""The paper's tables and ours: a table of names, each a module of this package.

A module offers what granulab.campaign.cli.reproduce.PublishedTable says.
"""

from functools import partial
from typing import Any

from granulab.campaign.cli.reproduce import find_table

Row = dict[str, Any]

# name of the module, as in `silo2d reproduce TABLE`: what it shows
TABLES: dict[str, str] = {
    "beverloo": "flow rate against the outlet, here and in a wide silo",
    "causes": "clogging at 100 mm, and what the source leaves open varied",
    "clogging": "how often 40, 60 and 100 mm clog (paper's Table 5)",
    "discharge": "discharge times of the sixteen silos (paper's Tables 5 and 6)",
    "disorder": "A4 and A3 with parameters drawn from pair to pair",
    "displacement": "profiles of the painted layers in A4 and D4",
    "filling": "A3 and B3 poured in three ways, opened in two",
    "remarks": "arches, interruptions of the flow and overlaps that the paper remarks",
    "sensitivity": "A4's time against each parameter (paper's Tables 7 to 11)",
}

find = partial(find_table, __name__)
