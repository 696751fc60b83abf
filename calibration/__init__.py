"""Measurements to contact parameters: videos, tables and signals to values with uncertainty."""

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from calibration.drop.measure import measure_drop
    from calibration.impacts.measure import measure_impacts
    from calibration.impacts.stopwatch import measure_stopwatch
    from calibration.pendulum.measure import measure_pendulum

__all__ = ["measure_drop", "measure_impacts", "measure_pendulum", "measure_stopwatch"]

_HOMES = {
    "measure_drop": "drop.measure",
    "measure_impacts": "impacts.measure",
    "measure_pendulum": "pendulum.measure",
    "measure_stopwatch": "impacts.stopwatch",
}


def __getattr__(name: str):
    # Imported on first use: --help must print at once.
    if name not in _HOMES:
        raise AttributeError(f"module 'calibration' has no attribute {name!r}")
    return getattr(importlib.import_module(f"calibration.{_HOMES[name]}"), name)
