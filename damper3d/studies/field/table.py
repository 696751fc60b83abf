"""Effective mass of a bed over frequency and Gamma: table, interpolation, CSV.

m = m' - i m'' [kg], F = omega^2 m X of the bed on an enclosure at x = Re(X e^(i omega t)): m' rides
along, m'' > 0 dissipates. Between the frequencies and Gammas of the table m is linear in their
logarithms.
"""

import csv
import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from damper3d.case.parts import GRAVITY
from granulab.errors import InputError

Floats = NDArray[np.float64]

COLUMNS = (
    "frequency_hz", "gamma", "amplitude_m", "m_in_phase_kg", "m_in_phase_half_width_kg",
    "m_out_of_phase_kg", "m_out_of_phase_half_width_kg", "packings",
)  # fmt: skip
_NEEDED = ("frequency_hz", "gamma", "m_in_phase_kg", "m_out_of_phase_kg")
_ROUND = 1e-9  # by which frequencies of a table may be missed


@dataclass(frozen=True, eq=False)
class Field:
    """Effective mass at n points (n,), whose frequencies have some Gammas each."""

    frequency: Floats  # [Hz]
    gamma: Floats
    mass: NDArray[np.complex128]  # m' - i m'' [kg]

    @cached_property
    def frequencies(self) -> Floats:
        """Frequencies of the table, rising [Hz]."""
        return np.unique(self.frequency)

    @cached_property
    def gammas(self) -> Floats:
        """Gammas that some frequency has, between the greatest least and the least greatest."""
        spans = [self.gamma[self.frequency == f] for f in self.frequencies]
        low, high = max(span.min() for span in spans), min(span.max() for span in spans)
        every = np.unique(self.gamma)
        return every[(every >= low) & (every <= high)]

    @cached_property
    def _grid(self) -> NDArray[np.complex128]:
        """Mass at all frequencies and gammas (f, g)."""
        wanted, rows = np.log(self.gammas), []
        for f in self.frequencies:
            here = self.frequency == f
            order = np.argsort(self.gamma[here])
            known, mass = np.log(self.gamma[here][order]), self.mass[here][order]
            rows.append(
                np.interp(wanted, known, mass.real) + 1j * np.interp(wanted, known, mass.imag)
            )
        return np.array(rows)

    def at(self, omega: Floats) -> tuple[NDArray[np.complex128], Floats]:
        """Mass (n, g) and amplitude [m] (n, g) of the gammas at angular frequencies (n,) [rad/s].

        InputError for one outside the table.
        """
        frequency = np.asarray(omega) / (2 * np.pi)
        low, high = self.frequencies[[0, -1]]
        outside = (frequency < low * (1 - _ROUND)) | (frequency > high * (1 + _ROUND))
        if outside.any():
            raise InputError(
                f"{float(frequency[outside][0]):g} Hz: the field is known from {low:g} to "
                f"{high:g} Hz; give frequencies between, or compute it there"
            )
        wanted, known = np.log(frequency), np.log(self.frequencies)
        mass = np.stack([_between(wanted, known, column) for column in self._grid.T], axis=1)
        amplitude = self.gammas * GRAVITY / np.asarray(omega)[:, None] ** 2
        return mass, amplitude


def _between(wanted: Floats, known: Floats, mass: NDArray[np.complex128]) -> np.ndarray:
    """Linear interpolation of complex numbers (n,) that are known at rising places."""
    return np.interp(wanted, known, mass.real) + 1j * np.interp(wanted, known, mass.imag)


def read_field(path: Path) -> Field:
    """A field from its CSV table; InputError, one line, where it is none."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: no field can be read: {error}") from None
    if not rows:
        raise InputError(f"{path}: holds no points of a field; damper3d field writes a table")
    columns = {}
    for name in _NEEDED:
        if name not in rows[0]:
            raise InputError(f"{path}: column {name!r} is missing; damper3d field writes a table")
        columns[name] = np.array([_number(path, k, name, row[name]) for k, row in enumerate(rows)])
    for name in ("frequency_hz", "gamma"):
        if not (columns[name] > 0).all():
            raise InputError(f"{path}: {name} = {columns[name].min():g}: must be above 0")
    mass = columns["m_in_phase_kg"] - 1j * columns["m_out_of_phase_kg"]
    field = Field(columns["frequency_hz"], columns["gamma"], mass)
    points = list(zip(field.frequency.tolist(), field.gamma.tolist(), strict=True))
    if len(set(points)) < len(points) or len(field.gammas) < 2:
        raise InputError(
            f"{path}: a field has each frequency and Gamma once, and two Gammas at least that all "
            "frequencies have between"
        )
    return field


def _number(path: Path, row: int, name: str, text: str | None) -> float:
    try:
        value = float(text or "")
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{path}: point {row + 1}: {name} = {text!r}: no number")
    return value
