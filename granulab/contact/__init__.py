"""Contact parameters and laws: the layer that every simulator and every measurement shares."""

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from granulab.contact.files.table import load_pairs, load_table, write_table
    from granulab.contact.material import Material, Pair

__all__ = ["Material", "Pair", "load_pairs", "load_table", "write_table"]


def __getattr__(name: str):
    # Imported on first use: commands must print --help without pydantic and pint.
    if name not in __all__:
        raise AttributeError(f"module 'granulab.contact' has no attribute {name!r}")
    home = "material" if name in ("Material", "Pair") else "files.table"
    return getattr(importlib.import_module(f"granulab.contact.{home}"), name)
