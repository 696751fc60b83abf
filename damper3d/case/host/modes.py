"""Modes of a structure: one of a mass, or a table of frequencies, damping ratios and shapes.

A single mode of a mass M (structure and empty enclosure) has the shape 1/sqrt(M), so that
M x'' + c x' + k x = f + F with c = 2 zeta_0 omega_0 M, k = omega_0^2 M.
"""

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from damper3d.case.settings import Host as HostKeys
from granulab.contact.files.datafile import csv_rows, is_file
from granulab.contact.files.units import nearest
from granulab.errors import InputError

MODES = "modes.csv"  # in a run folder
# Columns of a table of modes, and the units that stand behind their names in brackets.
_UNITS = {
    "frequency": "Hz", "damping_ratio": "", "shape": "kg^-0.5", "force_shape": "kg^-0.5",
    "participation": "kg^0.5",
}  # fmt: skip
_REQUIRED = ("frequency", "damping_ratio")
_AT = "shape_"  # begins the name of a column of shapes at a place of a name


@dataclass(frozen=True, eq=False)
class Modes:
    """Modes of a structure, of unit modal mass (r,)."""

    omega: np.ndarray  # [rad/s]
    damping_ratio: np.ndarray  # [-]
    shape: np.ndarray  # at the damper, along its motion [kg^-0.5]
    force_shape: np.ndarray  # where the force acts [kg^-0.5]
    participation: np.ndarray  # [kg^0.5]
    # Of several dampers the shape at the first, whose bare motion tells phases and the start of a
    # decay [kg^-0.5]; None: this one
    first: np.ndarray | None = None

    @property
    def lead(self) -> np.ndarray:
        """Shape at the first damper [kg^-0.5]."""
        return self.shape if self.first is None else self.first

    @classmethod
    def single(cls, mass: float, omega: float, damping_ratio: float) -> "Modes":
        """One degree of freedom."""
        shape = np.array([1 / math.sqrt(mass)])
        return cls(np.array([omega]), np.array([damping_ratio]), shape, shape, 1 / shape)

    def only(self, mode: int) -> "Modes":
        """One of the modes, by its number."""
        own: dict[str, Any] = {
            name: None if values is None else values[mode : mode + 1]
            for name, values in vars(self).items()
        }
        return replace(self, **own)

    @property
    def slowest(self) -> float:
        """Least rate of a mode's free decay [1/s]."""
        return float((self.damping_ratio * self.omega).min())

    def nearest(self, omega: float) -> int:
        """The mode whose own frequency is nearest [rad/s]."""
        return int(np.argmin(np.abs(self.omega - omega)))

    def receptance(self, omega: float, drive: np.ndarray) -> np.ndarray:
        """Modal amplitudes (r,) for a modal force drive e^(i omega t) (r,)."""
        damping = 2j * self.damping_ratio * self.omega * omega
        return np.asarray(drive / (self.omega**2 - omega**2 + damping))


def given(keys: HostKeys) -> bool:
    """True where a case has a host."""
    return any(value is not None for value in keys.model_dump().values())


def modes_of(keys: HostKeys, folder: Path, where: str, base_moves: bool = False) -> Modes:
    """The modes of [host]; InputError where keys or the table of modes are not right.

    base_moves: by an excitation, where no key of [host] says it.
    """
    single = {name: getattr(keys, name) for name in ("mass", "frequency", "damping_ratio")}
    if keys.modes is not None:
        both = [name for name, value in single.items() if value is not None]
        if both:
            raise InputError(
                f"{where}: [host] {both[0]} is given, and modes = {keys.modes!r} has it for each "
                "mode; leave one of them out"
            )
        return read_modes(_table(keys.modes, folder), base_moves or bool(base_of(keys)), keys.at)
    if keys.at is not None:
        raise InputError(
            f"{where}: [host] at = {keys.at!r}: names a column {_AT}{keys.at} of a table of modes; "
            "give [host] modes, or leave it out"
        )
    for name, value in single.items():
        if value is None:
            raise InputError(
                f"{where}: [host] {name} is missing; a host has mass, frequency and damping_ratio, "
                "or a table of modes"
            )
    omega = 2.0 * math.pi * single["frequency"]
    return Modes.single(single["mass"], omega, single["damping_ratio"])


def _table(name: str, folder: Path) -> Path:
    """The table of modes that a case names: next to it, or where the command stands."""
    return folder / name if is_file(folder / name) else Path(name)


def modes_copy(keys: HostKeys, folder: Path) -> dict[str, str]:
    """The table of modes as a file for the run folder: its name and text; one mode has none."""
    if keys.modes is None:
        return {}
    return {MODES: _table(keys.modes, folder).read_text(encoding="utf-8-sig")}


def read_modes(path: Path, with_base: bool = False, at: str | None = None) -> Modes:
    """Modes from a CSV table, a line each; with_base: the participation factors are needed.

    at: name of the damper's place, of which the column shape_<at> holds the shapes.
    Raises InputError, one line that names file, line and column.
    """
    rows = csv_rows(path, "the table of the host's modes")
    if len(rows) < 2:
        raise InputError(f"{path}: no modes; write a head, {_head()}, and a line for each mode")
    names = [_column(path, cell.strip()) for cell in rows[0][1]]
    if twice := next((name for k, name in enumerate(names) if name in names[:k]), None):
        raise InputError(f"{path}: column {twice!r} stands twice; leave one of them out")
    own = "shape" if at is None else f"{_AT}{at}"
    needed = [*_REQUIRED, own]
    needed += ["participation"] if with_base else []
    needed += ["force_shape"] if at is not None and "shape" not in names else []
    for name in needed:
        if name not in names:
            raise InputError(f"{path}: column {name!r} is missing{_why(name, names)}")
    table = np.array([_mode(path, line, names, row) for line, row in rows[1:]])
    values = dict(zip(names, table.T, strict=True))
    _check_modes(path, [line for line, _ in rows[1:]], values, own)
    return Modes(
        2.0 * math.pi * values["frequency"], values["damping_ratio"], values[own],
        values["force_shape"] if "force_shape" in values else values["shape"],
        values.get("participation", np.zeros(len(table))),
    )  # fmt: skip


def _why(name: str, names: list[str]) -> str:
    """The end of a refusal of a table without a column."""
    if name == "force_shape":
        return ", which says where the force acts; write 'force_shape [kg^-0.5]'"
    places = [one.removeprefix(_AT) for one in names if one.startswith(_AT)]
    if name.startswith(_AT) and places:
        return f"; places in it are {', '.join(places)}"
    if name == "shape" and places:
        return f"; name the damper's place, [host] at = {places[0]!r}"
    return f"{', which base motion needs' * (name == 'participation')}; the head is {_head()}"


def _head() -> str:
    return ", ".join(f"{name} [{unit}]" if unit else name for name, unit in _UNITS.items())


def _column(path: Path, cell: str) -> str:
    """The name of a column from its head, which has the unit that it must have."""
    name, _, rest = cell.partition("[")
    name, unit = name.strip(), rest.rstrip("] ").strip().replace("**", "^")
    known = _UNITS["shape"] if name.startswith(_AT) else _UNITS.get(name)
    if known is None:
        raise InputError(f"{path}: column {cell!r}: {nearest(name, list(_UNITS))}")
    if unit != known and (unit or "kg" in known):
        said = f"the unit is {unit!r}" if unit else "the unit is missing"
        raise InputError(
            f"{path}: column {cell!r}: {said}; shapes of unit modal mass are needed: write "
            f"'{name} [{known}]'" if "kg" in known else
            f"{path}: column {cell!r}: {said}; write '{name} [{known}]'"
        )  # fmt: skip
    return name


def _mode(path: Path, line: int, names: list[str], row: list[str]) -> list[float]:
    if len(row) != len(names):
        raise InputError(f"{path}: line {line} has {len(row)} values, its head {len(names)}")
    found = []
    for name, cell in zip(names, row, strict=True):
        try:
            value = float(cell)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise InputError(f"{path}: line {line}: {name} = {cell.strip()!r}: no number")
        found.append(value)
    return found


def _check_modes(path: Path, lines: list[int], values: dict[str, np.ndarray], own: str) -> None:
    for k, frequency, ratio in zip(
        lines, values["frequency"], values["damping_ratio"], strict=True
    ):
        if not frequency > 0:
            raise InputError(f"{path}: line {k}: frequency = {frequency:g} Hz: must be above 0")
        if not 0 <= ratio < 1:
            raise InputError(
                f"{path}: line {k}: damping_ratio = {ratio:g}: must be 0 or more and below 1"
            )
    if not np.any(values[own]):
        raise InputError(f"{path}: every {own} is 0: no mode moves the damper")


def base_of(keys: HostKeys) -> float | None:
    """The amplitude of the base as a length [m] or acceleration [m/s2]; None: it does not move."""
    return keys.base_displacement or keys.base_acceleration
