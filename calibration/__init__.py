"""Measurements to contact parameters: videos, tables and signals to values with uncertainty."""

from typing import TYPE_CHECKING

from granulab.lazy import public

if TYPE_CHECKING:
    from calibration.bench.damping import Damping, damping
    from calibration.bench.measure import Measurement
    from calibration.drop.measure import measure_drop
    from calibration.files.parameter_file import into
    from calibration.files.provenance import Report, report
    from calibration.impacts.measure import measure_impacts
    from calibration.impacts.stopwatch import measure_stopwatch
    from calibration.methods import (
        Inputs,
        measure_compression,
        measure_density,
        measure_heights,
        measure_incline,
        measure_interface,
        measure_roughness,
        measure_slide,
    )
    from calibration.pendulum.measure import measure_pendulum
    from calibration.rebound.measure import measure_rebound

__all__ = [
    "Damping",
    "Inputs",
    "Measurement",
    "Report",
    "damping",
    "into",
    "measure_compression",
    "measure_density",
    "measure_drop",
    "measure_heights",
    "measure_impacts",
    "measure_incline",
    "measure_interface",
    "measure_pendulum",
    "measure_rebound",
    "measure_roughness",
    "measure_slide",
    "measure_stopwatch",
    "report",
]

__getattr__, __dir__ = public(__name__, {
    "Damping": "bench.damping",
    "Inputs": "methods",
    "Measurement": "bench.measure",
    "Report": "files.provenance",
    "damping": "bench.damping",
    "into": "files.parameter_file",
    "measure_compression": "methods",
    "measure_density": "methods",
    "measure_drop": "drop.measure",
    "measure_heights": "methods",
    "measure_impacts": "impacts.measure",
    "measure_incline": "methods",
    "measure_interface": "methods",
    "measure_pendulum": "pendulum.measure",
    "measure_rebound": "rebound.measure",
    "measure_roughness": "methods",
    "measure_slide": "methods",
    "measure_stopwatch": "impacts.stopwatch",
    "report": "files.provenance",
})  # fmt: skip
