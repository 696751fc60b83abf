"""The thesis's tables and figures, and ours: a table of names, each a module of this package.

A module offers what granulab.campaign.cli.reproduce.PublishedTable says.
"""

import importlib
from typing import Any, cast

from granulab.campaign.cli.reproduce import PublishedTable
from granulab.contact.files.units import nearest
from granulab.errors import InputError

Row = dict[str, Any]

# name as in `damper3d reproduce TABLE`: module of this package, what it shows
TABLES: dict[str, tuple[str, str]] = {
    "chapter": ("chapter", "the maps of 4 sizes, 4 fills and 2 orientations (thesis, chapter 6)"),
    "cycles": (
        "cycles",
        "within the cycle (thesis, Figs 6.7, 6.10, 6.16 and 6.18)",
    ),
    "map": ("map", "efficiency over frequency and Gamma, 4 fills (thesis, Figs 6.4 and 6.5)"),
    "optimum": ("optimum", "where the bouncing bed damps best (thesis, Table 6.3)"),
    "packing": ("packing", "how densely each shape packs (thesis, eq. 6.13 and sec. 8.5.1.2)"),
    "sensitivity": ("sensitivity", "the optimum against four properties (thesis, Fig. 6.13)"),
    "shapes": ("shapes", "spheroids and toroids of unlike ratio (thesis, chapter 8)"),
    "shares": ("shares", "friction and particle-particle contacts (thesis, Figs 6.28, 6.29)"),
    "sizes": ("sizes", "spheres of 3, 4, 5 and 6 mm (thesis, Figs 6.12, 6.22 and 6.26)"),
}


def find(name: str) -> PublishedTable:
    """The table of a name; InputError with the names there are."""
    if name not in TABLES:
        raise InputError(f"reproduce {name!r}: no such table; {nearest(name, list(TABLES))}")
    return cast(PublishedTable, importlib.import_module(f"damper3d.reproduce.{TABLES[name][0]}"))
