"""What the inverse fit asks of a simulator: its cases, what can be observed, what is measured."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from calibration.inverse.observation import Observation, Written
from calibration.inverse.prior import Array
from granulab.campaign.sweeps.sweep import Simulator
from granulab.contact.files.keys import Keys

Row = dict[str, Any]
Values = dict[tuple[str, str], float]  # section and key of a parameter file -> value in SI


@dataclass(frozen=True)
class Kind:
    """A kind of observation.

    read    what a fit file has for it
    of      the same of a finished run: (n,) for an observation and the row of the run
    """

    read: Callable[[Written], list[Observation]]
    of: Callable[[Observation, Row], Array]


@dataclass(frozen=True)
class Simulated:
    """A simulator as the fit takes it.

    load          the case of a name, with changes by key
    passed        whether a finished run gave what was observed; a clogged silo did not
    parameters    what a case holds of a parameter file
    """

    campaign: Simulator
    keys: Keys
    load: Callable[[str, dict[str, Any]], Any]
    kinds: Mapping[str, Kind]
    passed: Callable[[Row], bool]
    parameters: Callable[[Any], Values]
