"""Observations of a fit file, numbers and tables; and what a simulator must offer for them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from calibration.files.tables import Table, read_table
from calibration.inverse.statistics.prior import Array
from granulab.campaign.sweeps.sweep import Simulator
from granulab.contact.files.keys import Keys
from granulab.contact.files.units import nearest, to_si
from granulab.errors import InputError


@dataclass(frozen=True)
class Observation:
    """Measured values of one kind, all of the same case; n of them.

    changes    of the case that they go with, by key ("motion.gamma"), in SI
    values     (n,) SI; sigma (n,); trials: how many trials each is the mean of
    at         (n, c) where they stand: times, or times, layers and positions
    series     (n,) words for lines of a figure; abscissa (n,)
    blocked    trials that gave no such value; values is then empty
    """

    kind: str
    changes: tuple[tuple[str, float], ...]
    values: Array
    sigma: Array
    trials: int
    at: Array
    series: tuple[str, ...]
    abscissa: Array
    axes: tuple[str, str]  # words for the abscissa and the values
    file: Path | None = None
    blocked: int = 0

    @property
    def label(self) -> str:
        """Name in a report."""
        return self.kind.replace("_", " ") + (f" of {self.file.name}" if self.file else "")


class Written:
    """An [[observation]] of a fit file, whose keys are taken one after the other."""

    def __init__(self, table: dict[str, Any], folder: Path, where: str) -> None:
        self.where = where
        self._table = dict(table)
        self._known = list(table)
        self._folder = folder

    def number(self, key: str, unit: str, usual: float | None = None) -> float:
        """A quantity in SI units; `usual` where it may be left out."""
        self._known.append(key)
        if key not in self._table:
            if usual is None:
                raise InputError(f"{self.where} {key} is missing")
            return usual
        return to_si(self._table.pop(key), unit, f"{self.where} {key}")

    def positive(self, key: str, unit: str) -> float:
        """The same, above 0."""
        value = self.number(key, unit)
        if not value > 0:
            raise InputError(f"{self.where} {key} = {value:g}: must be above 0")
        return value

    def count(self, key: str, usual: int | None, least: int = 1) -> int:
        """A whole number."""
        self._known.append(key)
        value = self._table.pop(key, usual)
        if not isinstance(value, int) or isinstance(value, bool) or value < least:
            raise InputError(
                f"{self.where} {key} = {value!r}: give a whole number, {least} or more"
            )
        return value

    def table(self) -> Table:
        """The table of the key `file`, looked for in the fit file's folder."""
        self._known.append("file")
        name = self._table.pop("file", None)
        if not isinstance(name, str):
            raise InputError(f"{self.where} file is missing; give the CSV with the measured values")
        return read_table(self._folder / name)

    def sigma(self, table: Table, unit: str) -> Array:
        """Uncertainty of each row (n,): the column sigma, else the key sigma; above 0."""
        if table.has("sigma", unit):
            if "sigma" in self._table:
                raise InputError(f"{self.where} sigma: {table.path} has a column sigma; give one")
            values = table.column("sigma", unit, written_in=None if unit == "1" else unit)
        elif "sigma" in self._table:
            values = np.full(len(table.lines), self.positive("sigma", unit))
        else:
            raise InputError(
                f"{self.where} sigma is missing: {table.path} has no such column; give how well "
                "a value was measured"
            )
        self._known.append("sigma")
        wrong = np.flatnonzero(~((values > 0) & np.isfinite(values)))
        if len(wrong):
            line = table.lines[wrong[0]]
            raise InputError(f"{table.path}: line {line}: sigma = {values[wrong[0]]:g}: must be "
                             "a number above 0")  # fmt: skip
        return values

    def end(self) -> None:
        """InputError for a key that nobody took."""
        for key in self._table:
            raise InputError(f"{self.where} unknown key {key!r}; {nearest(key, self._names())}")

    def _names(self) -> list[str]:
        return [key for key in dict.fromkeys(self._known) if key not in self._table]


def finite(values: Array, table: Table, what: str) -> Array:
    """The same values; InputError with the line of one that is missing."""
    wrong = np.flatnonzero(~np.isfinite(values))
    if len(wrong):
        raise InputError(f"{table.path}: line {table.lines[wrong[0]]}: {what} is missing")
    return values


def single(kind: str, value: float, sigma: float, trials: int, unit: str) -> Observation:
    """One measured number."""
    words = f"{kind.replace('_', ' ')} [{unit}]"
    return Observation(
        kind, (), np.array([value]), np.array([sigma]), trials, np.zeros((1, 0)), ("",),
        np.zeros(1), ("", words),
    )  # fmt: skip


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
