"""Measurements to contact parameters: videos, tables and signals to values with uncertainty."""

import importlib

_WHERE = {
    "measure_impacts": "calibration.impacts.measure",
}
__all__ = [*_WHERE]


def __getattr__(name: str) -> object:
    """A public function, imported with what it needs when it is first asked for."""
    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(_WHERE[name]), name)
