"""Public names of a package that are loaded on first use, so that --help prints without numba."""

import importlib
import sys
from collections.abc import Callable, Mapping
from typing import Any


def public(
    package: str, homes: Mapping[str, str]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Return `__getattr__` and `__dir__` of a package.

    homes: the module below the package in which each name is, such as "run.protocol", or
    "measures:register" where it has another name there.
    """

    def load(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        module, _, inside = homes[name].partition(":")
        found = getattr(importlib.import_module(f"{package}.{module}"), inside or name)
        setattr(sys.modules[package], name, found)
        return found

    def names() -> list[str]:
        own = (name for name in vars(sys.modules[package]) if name.startswith("__"))
        return sorted({*homes, *own})

    return load, names
