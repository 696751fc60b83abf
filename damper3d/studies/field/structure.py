"""A structure with the empty enclosure, as numbers: its modes, and what moves it.

Mode r has the angular frequency w_r, the damping ratio zeta_r and the shape phi_r of unit modal
mass. At the damper the receptance H and the bare response X_b to a force F0 and a base B are

    H = sum phi_r^2/d_r,   X_b = B + sum phi_r (psi_r F0 + p_r w^2 B)/d_r,
    d_r = w_r^2 - w^2 + 2 i zeta_r w_r w

with the shape psi_r where the force acts and the participation p_r. Of one mode of a mass M these
are 1/(k - w^2 M + i w c), F0 H and (k + i w c) B H. The product P of all d_r is taken out, so that
an undamped mode at its own frequency is no division by zero.
"""

import csv
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granulab.contact.files.datafile import is_file, toml_text
from granulab.contact.files.units import is_plain_number, nearest, to_si
from granulab.errors import InputError

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

DRIVES = {"force": "N", "base_displacement": "m", "base_acceleration": "m/s2"}
_SINGLE = {"mass": "kg", "frequency": "Hz", "damping_ratio": "1"}
_RELEASES = ("start_displacement", "start_velocity")
_SHAPES = {"shape": "kg^-0.5", "force_shape": "kg^-0.5", "participation": "kg^0.5"}


@dataclass(frozen=True, eq=False)
class Structure:
    """Modes (r,) of a structure, and the amplitude of what moves it; base motion or a force."""

    omega: Floats  # [rad/s]
    damping_ratio: Floats  # [-]
    shape: Floats  # at the damper [kg^-0.5]
    force_shape: Floats  # where the force acts [kg^-0.5]
    participation: Floats  # [kg^0.5]
    force: float = 0.0  # [N]
    base_displacement: float = 0.0  # [m]
    base_acceleration: float = 0.0  # [m/s2]

    @classmethod
    def single(
        cls, mass: float, frequency: float, damping_ratio: float, **drive: float
    ) -> "Structure":
        """One mode of a mass [kg] and a frequency [Hz], moved by one of DRIVES."""
        shape = np.array([1.0 / math.sqrt(mass)])
        omega, ratio = np.array([2.0 * math.pi * frequency]), np.array([damping_ratio])
        return cls(omega, ratio, shape, shape, 1.0 / shape).driven(**drive)

    def driven(
        self, force: float = 0.0, base_displacement: float = 0.0, base_acceleration: float = 0.0
    ) -> "Structure":
        """The structure moved by these amplitudes [N, m, m/s2]."""
        return replace(
            self, force=force, base_displacement=base_displacement,
            base_acceleration=base_acceleration,
        )  # fmt: skip

    def products(self, frequency: ArrayLike) -> tuple[Complexes, Complexes, Complexes]:
        """P, H P and X_b P at frequencies (f,) [Hz], each d_r divided by w^2."""
        w = 2.0 * math.pi * np.asarray(frequency, float)[:, None]
        d = (self.omega**2 - w**2 + 2j * self.damping_ratio * self.omega * w) / w**2
        others = np.stack(
            [np.prod(np.delete(d, r, axis=1), axis=1) for r in range(len(self.omega))], axis=1
        )
        base = self.base_displacement + self.base_acceleration / w**2
        driven = self.force_shape * self.force / w**2 + self.participation * base
        product = np.prod(d, axis=1)
        return (
            product,
            (others * self.shape**2).sum(axis=1) / w[:, 0] ** 2,
            base[:, 0] * product + (others * self.shape * driven).sum(axis=1),
        )

    def bare(self, frequency: ArrayLike) -> Complexes:
        """Response at the damper without a bed (f,) [m]; infinite for an undamped resonance."""
        product, _, moved = self.products(frequency)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(product == 0, np.inf, moved / product)


def read_structure(path: str | Path) -> Structure:
    """The [host] of a TOML file, of a case or by itself; its table of modes stands next to it.

    Raises InputError, one line that names file, key and cure.
    """
    path = Path(path)
    try:
        _, document = toml_text(path)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; give a TOML file with a table [host]") from None
    host = document.get("host")
    if not isinstance(host, dict):
        raise InputError(
            f'{path}: no [host]; write one with mass = "2 kg", frequency = "60 Hz", '
            'damping_ratio = 0.005 and force = "1 N"'
        )
    known = [*_SINGLE, "modes", *DRIVES, *_RELEASES]
    for name in host:
        if name not in known:
            raise InputError(f"{path}: [host] {name}: no such key; {nearest(name, known)}")
    drive = _drive(host, f"{path}: [host]")
    if "modes" in host:
        both = [name for name in _SINGLE if name in host]
        if both:
            raise InputError(f"{path}: [host] {both[0]} is given, and modes has it for each mode; "
                             "leave one of them out")  # fmt: skip
        modes = read_modes(path.parent / str(host["modes"]), "force" not in drive)
        return modes.driven(**drive)
    values = {}
    for name, unit in _SINGLE.items():
        if name not in host:
            raise InputError(f"{path}: [host] {name} is missing; a host has mass, frequency and "
                             "damping_ratio, or a table of modes")  # fmt: skip
        unit = "1" if name == "frequency" and is_plain_number(host[name]) else unit
        values[name] = to_si(host[name], unit, f"{path}: [host] {name}")
    _check_mode(f"{path}: [host]", values)
    return Structure.single(**values, **drive)


def _drive(host: dict[str, Any], where: str) -> dict[str, float]:
    released = [name for name in _RELEASES if name in host]
    if released:
        raise InputError(f"{where} {released[0]}: a free decay has no steady response; give force, "
                         "base_displacement or base_acceleration")  # fmt: skip
    given = [name for name in DRIVES if name in host]
    if len(given) != 1:
        said = f"{given[0]} and {given[1]} are both given" if given else "nothing moves it"
        raise InputError(f"{where} {said}; give one of {', '.join(DRIVES)}")
    value = to_si(host[given[0]], DRIVES[given[0]], f"{where} {given[0]}")
    if not value > 0:
        raise InputError(f"{where} {given[0]} = {host[given[0]]!r}: must be above 0")
    return {given[0]: value}


def _check_mode(where: str, values: dict[str, float]) -> None:
    for name in ("mass", "frequency"):
        if name in values and not values[name] > 0:
            raise InputError(f"{where} {name} = {values[name]:g}: must be above 0")
    if not 0 <= values["damping_ratio"] < 1:
        raise InputError(f"{where} damping_ratio = {values['damping_ratio']:g}: must be 0 or more "
                         "and below 1")  # fmt: skip


def read_modes(path: Path, with_base: bool = False) -> Structure:
    """Modes from a CSV table, a line each: frequency [Hz], damping_ratio, shape [kg^-0.5], ...

    with_base: the participation factors are needed. Raises InputError, one line.
    """
    head = "frequency [Hz], damping_ratio, shape [kg^-0.5]"
    if not is_file(path):
        raise InputError(f"{path}: no such file; give the table of the host's modes")
    with path.open(encoding="utf-8-sig", newline="") as file:
        rows = [row for row in csv.reader(file) if any(map(str.strip, row))]
    if len(rows) < 2:
        raise InputError(f"{path}: no modes; write the head {head}, and a line for each mode")
    names = []
    for cell in rows[0]:
        name, _, unit = (part.strip(" ]") for part in cell.partition("["))
        if name in _SHAPES and unit != _SHAPES[name]:
            raise InputError(f"{path}: column {cell.strip()!r}: shapes of unit modal mass are "
                             f"needed: write '{name} [{_SHAPES[name]}]'")  # fmt: skip
        names.append(name)
    for name in ("frequency", "damping_ratio", "shape", *["participation"] * with_base):
        if name not in names:
            raise InputError(f"{path}: column {name!r} is missing; the head is {head}")
    modes = []
    for line, row in enumerate(rows[1:], 2):
        try:
            mode = dict(zip(names, map(float, row), strict=True))
        except ValueError:
            raise InputError(f"{path}: line {line}: not a number for each of {head}") from None
        if not all(map(math.isfinite, mode.values())):
            raise InputError(f"{path}: line {line}: not a finite number for each of {head}")
        _check_mode(f"{path}: line {line}:", mode)
        modes.append(mode)
    if len({mode["frequency"] for mode in modes}) < len(modes):
        raise InputError(f"{path}: a frequency stands twice; join modes of one frequency")
    table = {name: np.array([mode[name] for mode in modes]) for name in names}
    return Structure(
        2.0 * math.pi * table["frequency"], table["damping_ratio"], table["shape"],
        table.get("force_shape", table["shape"]),
        table.get("participation", np.zeros(len(modes))),
    )  # fmt: skip
