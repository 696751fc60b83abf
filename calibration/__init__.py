"""Measurements to contact parameters: videos, tables and signals to values with uncertainty."""

from typing import TYPE_CHECKING

from granulab.lazy import public

if TYPE_CHECKING:
    from calibration.drop.measure import measure_drop
    from calibration.files.parameter_file import into
    from calibration.impacts.measure import measure_impacts
    from calibration.impacts.stopwatch import measure_stopwatch
    from calibration.pendulum.measure import measure_pendulum

__all__ = [
    "into",
    "measure_drop",
    "measure_impacts",
    "measure_pendulum",
    "measure_stopwatch",
]

__getattr__, __dir__ = public(__name__, {
    "into": "files.parameter_file",
    "measure_drop": "drop.measure",
    "measure_impacts": "impacts.measure",
    "measure_pendulum": "pendulum.measure",
    "measure_stopwatch": "impacts.stopwatch",
})  # fmt: skip
