"""The effective field: the complex effective mass of a bed over frequency and amplitude.

With x = Re(X e^(i omega t)) and F the first harmonic of the bed's force on the enclosure,

    F = omega^2 m X,    m = m' - i m''

A bed that rides along has m' = its mass and m'' = 0; m'' > 0 takes the mean power
omega^3 |X|^2 m''/2, as the dashpot omega m'' to the ground would.

Between the points of a frequency the force is taken as linear: m Gamma in Gamma. So a bed that
rides along is met exactly, and so is one whose mass falls as 1/Gamma. Between two frequencies m is
linear in ln f at the same Gamma, which is right of a bed that does not reach its lid; one that does
goes by the amplitude. by_amplitude() goes as far that way as the frequencies differ at the same
Gamma: to see by how much it matters. Below the least Gamma, m is as there (a straight line of the
force from zero); above the greatest, and outside the frequencies, there is none.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from damper3d.case.parts import GRAVITY, amplitude_of, gamma_at
from granulab.campaign.output.files import write_atomic
from granulab.campaign.output.table import as_csv
from granulab.contact.files.datafile import csv_lines, numbered
from granulab.contact.files.units import nearest
from granulab.errors import InputError

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

COLUMNS = (
    "frequency_hz", "gamma", "amplitude_m", "m_in_phase_kg", "m_in_phase_half_width_kg",
    "m_out_of_phase_kg", "m_out_of_phase_half_width_kg", "bed_mass_kg", "seeds",
)  # fmt: skip
_MAY_LACK = ("m_in_phase_half_width_kg", "m_out_of_phase_half_width_kg")
_HEAD = "# "
_WANTED = "the field.csv that damper3d field writes"
_ROUNDED = 1e-3  # part of an amplitude by which a table of few digits may be off its Gamma
_NEAR = 0.1  # part of a frequency within which what the table has there is taken for known
RIDES = 0.05  # of the bed's mass, that m' may be off it where a bed is said to ride along


@dataclass(frozen=True, eq=False)
class Field:
    """Effective masses at n points, by rising frequency and then Gamma.

    Half widths are of 95 % intervals over the packings, NaN where there is one packing.
    """

    frequency: Floats  # (n,) [Hz]
    gamma: Floats  # (n,)
    in_phase: Floats  # (n,) m' [kg]
    out_of_phase: Floats  # (n,) m'' [kg]
    in_phase_half_width: Floats  # (n,) [kg]
    out_of_phase_half_width: Floats  # (n,) [kg]
    seeds: NDArray[np.int64]  # (n,) packings
    bed_mass: float  # of all particles [kg]
    head: tuple[str, ...] = ()  # lines on where it comes from
    same_amplitude: bool = False  # between two frequencies, as far as these differ

    @classmethod
    def of(
        cls, frequency: ArrayLike, gamma: ArrayLike, mass: ArrayLike, bed_mass: float
    ) -> "Field":
        """From complex masses m' - i m'' (n,) [kg] without intervals, such as those of a law."""
        f, g, m = np.asarray(frequency, float), np.asarray(gamma, float), np.asarray(mass, complex)
        order, unknown = np.lexsort((g, f)), np.full(len(f), math.nan)
        return cls(f[order], g[order], m.real[order], -m.imag[order], unknown, unknown,
                   np.ones(len(f), np.int64), bed_mass)  # fmt: skip

    @property
    def mass(self) -> Complexes:
        """m' - i m'' (n,) [kg]."""
        return self.in_phase - 1j * self.out_of_phase

    @cached_property
    def frequencies(self) -> Floats:
        """Each frequency once, rising [Hz]."""
        return np.unique(self.frequency)

    @property
    def amplitude(self) -> Floats:
        """Of the enclosure (n,) [m]."""
        return amplitude_of(self.gamma, self.frequency)

    @property
    def rides_at_least(self) -> bool:
        """True where the bed rides along at the least Gamma of every frequency.

        To RIDES of its mass, or within the interval.
        """
        first = [int(np.argmax(self.frequency == f)) for f in self.frequencies]
        off = np.abs(self.mass[first] - self.bed_mass)
        allowed = np.fmax(self.in_phase_half_width[first], RIDES * self.bed_mass)
        return bool((off <= allowed).all())

    def shifted(self, in_phase: float, out_of_phase: float) -> "Field":
        """The field with m' and m'' moved by so many of their half widths; unknown ones by none."""
        each = (self.in_phase_half_width, self.out_of_phase_half_width)
        a, b = (np.nan_to_num(width) for width in each)
        return Field(
            self.frequency, self.gamma, self.in_phase + in_phase * a,
            self.out_of_phase + out_of_phase * b, *each, self.seeds, self.bed_mass, self.head,
            self.same_amplitude,
        )  # fmt: skip

    def far_between(self, frequency: float, amplitude: float) -> list[float] | None:
        """The two frequencies of the table that a motion lies far between [Hz]; None of others.

        Far is more than _NEAR off both, with a bed that leaves its floor: beyond Gamma 1.
        """
        known = self.frequencies
        above = int(np.searchsorted(known, frequency))
        lifted = amplitude * (2.0 * math.pi * frequency) ** 2 > GRAVITY
        if not (0 < above < len(known) and lifted):
            return None
        ends = [float(f) for f in known[above - 1 : above + 1]]
        return ends if min(frequency / ends[0], ends[1] / frequency) > 1.0 + _NEAR else None

    def by_amplitude(self) -> "Field":
        """The field with m of the same amplitude between two frequencies, not of the same Gamma.

        It is moved by no more than these differ at the same Gamma: where they agree, that is known.
        """
        return replace(self, same_amplitude=True)

    def knots(self, frequency: ArrayLike) -> tuple[Floats, Complexes]:
        """Knots of the force at each frequency (f,) [Hz]: Gammas (f, k) and m Gamma (f, k) [kg].

        From Gamma 0 up to the greatest of both neighbours; k is the same for all, the last one
        repeated. Raises InputError for a frequency outside the table.
        """
        wanted = np.atleast_1d(np.asarray(frequency, float))
        known = self.frequencies
        outside = wanted[~((known[0] <= wanted) & (wanted <= known[-1]))]
        if outside.size:
            raise InputError(
                f"frequency {outside[0]:g} Hz: outside the field, {known[0]:g} to {known[-1]:g} "
                "Hz; compute the field there (damper3d field --frequencies)"
            )
        gammas = np.concatenate([[0.0], np.unique(self.gamma)])
        above = np.clip(np.searchsorted(known, wanted), 1, len(known) - 1) if len(known) > 1 else 0
        below = above - 1 if len(known) > 1 else 0
        low, high = known[below], known[above]
        with np.errstate(invalid="ignore"):
            part = np.nan_to_num(np.log(wanted / low) / np.log(high / low))[:, None]
        last = np.array([self.gamma[self.frequency == f][-1] for f in known])
        force = np.array([self._curve(f, gammas) for f in known])
        joined = (1 - part) * force[below] + part * force[above]
        if self.same_amplitude:
            away = (1 - part) * self._at_amplitude(low, wanted, gammas) - joined
            away += part * self._at_amplitude(high, wanted, gammas)
            apart = np.abs(force[above] - force[below])
            longest = np.maximum(np.abs(away), apart)
            joined += away * np.divide(apart, longest, out=np.zeros_like(apart), where=longest > 0)
        # A frequency of the table has its own greatest Gamma, whatever its neighbour's.
        ends = np.minimum(
            np.where(part[:, 0] < 1, last[below], np.inf), np.where(part[:, 0] > 0, last[above],
            np.inf),
        )  # fmt: skip
        inside = gammas <= ends[:, None]
        index = np.minimum(np.arange(len(gammas)), inside.sum(axis=1, keepdims=True) - 1)
        return gammas[index], np.take_along_axis(np.atleast_2d(joined), index, axis=1)

    def _at_amplitude(self, own: Any, wanted: Floats, gammas: Floats) -> Complexes:
        """m Gamma (f, k) at wanted frequencies and Gammas, m that of others (f,) at the amplitude;
        beyond their greatest it is as there.
        """
        scale = (np.broadcast_to(own, wanted.shape) / wanted)[:, None] ** 2  # Gamma there over here
        curves = zip(np.broadcast_to(own, wanted.shape), scale * gammas, strict=True)
        return np.asarray([self._curve(*one) for one in curves] / scale, complex)

    def _curve(self, frequency: float, gammas: Floats) -> Complexes:
        """Return m Gamma at these Gammas of a frequency of the table; beyond it m is as there."""
        own = self.frequency == frequency
        g, m = np.append(0.0, self.gamma[own]), self.mass[own]
        force = np.interp(gammas, g, np.append(0.0, m * g[1:]))
        return np.asarray(force * np.maximum(gammas / g[-1], 1.0), complex)

    def has_interval(self, frequency: float, amplitude: float) -> bool:
        """True where all points have intervals that the mass at such a motion [Hz, m] comes of."""
        gamma = gamma_at(amplitude, frequency)
        known = np.isfinite(self.in_phase_half_width) & np.isfinite(self.out_of_phase_half_width)
        above = int(np.searchsorted(self.frequencies, frequency))
        exact = above < len(self.frequencies) and self.frequencies[above] == frequency
        for each in self.frequencies[above if exact else above - 1 : above + 1]:
            own = np.flatnonzero(self.frequency == each)
            k = int(np.searchsorted(self.gamma[own], gamma))
            if not known[own[max(k - 1, 0) : k + 1]].all():
                return False
        return True

    def at(self, frequency: float, amplitude: float) -> complex:
        """m' - i m'' [kg] at a frequency [Hz] and amplitude of the enclosure [m].

        Raises InputError outside the table, but below its least Gamma.
        """
        gamma = gamma_at(amplitude, frequency)
        (knots,), (force,) = self.knots(frequency)
        if gamma > knots[-1]:
            raise InputError(
                f"amplitude {1e3 * amplitude:g} mm at {frequency:g} Hz is Gamma {gamma:.4g}: above "
                f"the field, which ends at {knots[-1]:g}; compute it there (--gammas)"
            )
        if gamma <= knots[1]:  # also at 0
            return complex(force[1] / knots[1])
        return complex(np.interp(gamma, knots, force) / gamma)

    def rows(self) -> list[dict[str, Any]]:
        """A row a point, by the names of COLUMNS; an interval that is not known is None."""
        columns = (
            self.frequency, self.gamma, self.amplitude, self.in_phase, self.in_phase_half_width,
            self.out_of_phase, self.out_of_phase_half_width, np.full(len(self.gamma),
            self.bed_mass), self.seeds,
        )  # fmt: skip
        return [
            {
                name: None if value != value else value.item()
                for name, value in zip(COLUMNS, values, strict=True)
            }
            for values in zip(*columns, strict=True)
        ]

    def write(self, path: Path) -> Path:
        """Write the CSV table, its head in lines that begin with #; its path."""
        words = "".join(f"{_HEAD}{line}\n" for line in self.head)
        write_atomic(path, words + as_csv(self.rows()))
        return path


def read_field(path: str | Path) -> Field:
    """A field from the CSV that Field.write makes.

    Raises InputError, one line that names file, line and column.
    """
    path = Path(path)
    lines = csv_lines(path, _WANTED)
    rows = numbered(lines)
    if len(rows) < 2:
        raise InputError(f"{path}: no points; give {_WANTED}")
    _, names = rows[0]
    for name in COLUMNS:
        if name not in names and name not in _MAY_LACK:
            raise InputError(f"{path}: column {name!r} is missing; {nearest(name, names)}")
        if names.count(name) > 1:
            raise InputError(f"{path}: column {name!r} stands twice; leave one of them out")
    points = [_point(path, line, names, row) for line, row in rows[1:]]
    return _checked(path, points, tuple(line.lstrip("# ") for line in lines if line[:1] == "#"))


def _point(path: Path, line: int, names: Sequence[str], row: Sequence[str]) -> dict[str, float]:
    if len(row) != len(names):
        raise InputError(f"{path}: line {line} has {len(row)} values, its head {len(names)}")
    found = dict.fromkeys(_MAY_LACK, math.nan)
    for name, cell in zip(names, row, strict=True):
        if name not in COLUMNS or (name in _MAY_LACK and not cell.strip()):
            continue
        try:
            found[name] = float(cell)
        except ValueError:
            found[name] = math.nan
        if not math.isfinite(found[name]):
            raise InputError(f"{path}: line {line}: {name} = {cell.strip()!r}: no number")
        if name in ("frequency_hz", "gamma", "bed_mass_kg", "seeds") and not found[name] > 0:
            raise InputError(f"{path}: line {line}: {name} = {found[name]:g}: must be above 0")
    _refuse_nonsense(f"{path}: line {line}", found)
    return found


def _refuse_nonsense(where: str, point: dict[str, float]) -> None:
    """Raise InputError for numbers of a point that no bed has, or that contradict each other."""
    if point["seeds"] != int(point["seeds"]):
        raise InputError(f"{where}: seeds = {point['seeds']:g}: a whole number of packings")
    for name in _MAY_LACK:
        if point[name] < 0:
            raise InputError(f"{where}: {name} = {point[name]:g}: must not be below 0")
    amplitude = amplitude_of(point["gamma"], point["frequency_hz"])
    if not math.isclose(point["amplitude_m"], amplitude, rel_tol=_ROUNDED):
        raise InputError(
            f"{where}: amplitude_m = {point['amplitude_m']:g}: Gamma {point['gamma']:g} at "
            f"{point['frequency_hz']:g} Hz is {amplitude:.4g} m; correct one of them"
        )
    noise = np.fmax(point["m_out_of_phase_half_width_kg"], RIDES * point["bed_mass_kg"])
    if point["m_out_of_phase_kg"] < -noise:
        raise InputError(
            f"{where}: m_out_of_phase_kg = {point['m_out_of_phase_kg']:g}: below 0 a bed would "
            "give energy; is its sign turned?"
        )


def _checked(path: Path, points: list[dict[str, float]], head: tuple[str, ...]) -> Field:
    column = {name: np.array([point[name] for point in points]) for name in COLUMNS}
    order = np.lexsort((column["gamma"], column["frequency_hz"]))
    column = {name: values[order] for name, values in column.items()}
    f, g = column["frequency_hz"], column["gamma"]
    twice = np.flatnonzero((np.diff(f) == 0) & (np.diff(g) == 0))
    if twice.size:
        raise InputError(
            f"{path}: {f[twice[0]]:g} Hz, Gamma {g[twice[0]]:g} stands twice; leave one out"
        )
    masses = np.unique(column["bed_mass_kg"])
    if len(masses) > 1:
        raise InputError(f"{path}: bed_mass_kg is {masses[0]:g} and {masses[1]:g}: fields of two "
                         "beds; give one table for each")  # fmt: skip
    return Field(
        f, g, column["m_in_phase_kg"], column["m_out_of_phase_kg"],
        column["m_in_phase_half_width_kg"], column["m_out_of_phase_half_width_kg"],
        column["seeds"].astype(np.int64), float(masses[0]), head,
    )  # fmt: skip
