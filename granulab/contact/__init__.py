"""Contact parameters and laws: the layer that every simulator and every measurement shares."""

from typing import TYPE_CHECKING

from granulab.lazy import public

if TYPE_CHECKING:
    from granulab.contact.files.datafile import data_root
    from granulab.contact.files.table import load_pairs, load_table, write_table
    from granulab.contact.material import Material, Pair

__all__ = [
    "Material",
    "Pair",
    "data_root",
    "load_pairs",
    "load_table",
    "write_table",
]

__getattr__, __dir__ = public(__name__, {
    "Material": "material",
    "Pair": "material",
    "data_root": "files.datafile",
    "load_pairs": "files.table",
    "load_table": "files.table",
    "write_table": "files.table",
})  # fmt: skip
