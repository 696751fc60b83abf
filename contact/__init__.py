"""Contact parameters and laws: the layer that every simulator and every measurement shares."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from contact.material import Material, Pair
    from contact.table import load_pairs, load_table, write_table

__all__ = ["Material", "Pair", "load_pairs", "load_table", "write_table"]


def __getattr__(name: str):
    # Imported when first asked for: commands must answer --help without pydantic and pint.
    if name in ("Material", "Pair"):
        from contact import material as module
    elif name in __all__:
        from contact import table as module
    else:
        raise AttributeError(f"module 'contact' has no attribute {name!r}")
    return getattr(module, name)
