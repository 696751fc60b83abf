"""The paper's tables and ours: a table of names, each a module of this package.

A module offers what granulab.campaign.cli.reproduce.PublishedTable says.
"""

import importlib
from typing import Any, cast

from granulab.campaign.cli.reproduce import PublishedTable
from granulab.contact.files.units import nearest
from granulab.errors import InputError

Row = dict[str, Any]

# name as in `silo2d reproduce TABLE`: module of this package, what it shows
TABLES: dict[str, tuple[str, str]] = {
    "beverloo": ("beverloo", "flow rate against the outlet, here and in a wide silo"),
    "clogging": ("clogging", "how often 40, 60 and 100 mm clog (paper's Table 5)"),
    "discharge": ("discharge", "discharge times of the sixteen silos (paper's Tables 5 and 6)"),
    "disorder": ("disorder", "A4 and A3 with parameters drawn from pair to pair"),
    "displacement": ("displacement", "profiles of the painted layers in A4 and D4"),
    "filling": ("filling", "A3 and B3 poured in three ways, opened in two"),
    "sensitivity": ("sensitivity", "A4's time against each parameter (paper's Tables 7 to 11)"),
}


def find(name: str) -> PublishedTable:
    """The table of a name; InputError with the names there are."""
    if name not in TABLES:
        raise InputError(f"reproduce {name!r}: no such table; {nearest(name, list(TABLES))}")
    return cast(PublishedTable, importlib.import_module(f"silo2d.reproduce.{TABLES[name][0]}"))
