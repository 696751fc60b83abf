"""Damping from a measured restitution, with the uncertainty of all that goes into it.

Linear contact (wood-silo paper, eqs 3.8 to 3.10): gamma = 2 b sqrt(kn/(n m)) for n contacts in
parallel of stiffness kn each, m the reduced mass: m1/2 for two equal particles (eq. 3.9; the
appendix has m1), m1 against a wall (eq. 3.10). Hertz contact with Tsuji's dashpot: the same b by
itself. b(e) stands in granulab/contact/restitution.py for both ends of a contact.

Uncertainties are carried to first order (GUM, JCGM 100:2008, eq. 10):

    s_b = s_e/|de/db|,    (s_gamma/gamma)^2 = (s_b/b)^2 + (s_kn/kn)^2/4 + (s_m/m)^2/4

A quantity without a sigma counts as exact; where none has one, neither has the result.
"""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from calibration.files.provenance import read_values
from calibration.result import AsText, Parameter
from calibration.statistics.quantity import measured_quantity, plus_minus
from calibration.statistics.uncertainty import Estimate
from granulab.contact.files.units import located
from granulab.contact.material import PROPERTIES, Measured, check_range
from granulab.contact.restitution import (
    ContactEnd,
    damping_for_restitution,
    ratio_of_restitution,
    restitution_of_ratio,
    slope_of_restitution,
)
from granulab.errors import InputError


def reduced_mass_of(first: Measured, second: Measured | None = None) -> Measured:
    """m1 m2/(m1 + m2) [kg] of two particles whose masses were measured each; of a wall, m1.

    For two particles of one measured mass, halve it: then their errors are one.
    """
    if second is None:
        return first
    total = first.value + second.value
    mass = first.value * second.value / total
    slopes = (second.value / total) ** 2, (first.value / total) ** 2
    return Measured(mass, _root_sum(zip(slopes, (first.sigma, second.sigma), strict=True)))


def damping_ratio(restitution: Measured, end: ContactEnd = "overlap") -> Measured:
    """The b [-] of a linear contact (eqs 5.29, 5.30), or a Hertz one, that gives a restitution."""
    ratio = ratio_of_restitution(restitution.value, end)
    slope = 1 / slope_of_restitution(ratio, end)
    return Measured(ratio, _root_sum([(slope, restitution.sigma)]))


def tsuji_damping_ratio(restitution: Measured, end: ContactEnd = "overlap") -> Measured:
    """The thesis's zeta [-] of a Hertz contact, eq. 5.31: (sqrt(5)/2) b."""
    ratio, factor = damping_ratio(restitution, end), math.sqrt(5) / 2
    return Measured(factor * ratio.value, _root_sum([(factor, ratio.sigma)]))


def linear_damping(
    restitution: Measured,
    kn: Measured,
    mass: Measured,
    *,
    end: ContactEnd = "overlap",
    contacts: int = 1,
) -> Measured:
    """The gamma_n [1/s] of each of n contacts in parallel that together give a restitution.

    kn [N/m] of each, mass the reduced mass [kg]. Raises ValueError for a restitution outside
    (0, 1].
    """
    gamma = damping_for_restitution(restitution.value, kn.value, mass.value, end=end,
                                    contacts=contacts)  # fmt: skip
    ratio = damping_ratio(restitution, end)
    per_ratio = 2 * math.sqrt(kn.value / (contacts * mass.value))
    terms = [
        (per_ratio, ratio.sigma),
        (gamma / (2 * kn.value), kn.sigma),
        (gamma / (2 * mass.value), mass.sigma),
    ]
    return Measured(gamma, _root_sum(terms))


def in_parallel(
    restitution: Measured, contacts: int, *, of: int = 1, end: ContactEnd = "overlap"
) -> Measured:
    """The restitution [-] through `contacts` equal contacts, where `of` such contacts have one.

    Damping adds as the stiffness does, and so b grows with the root of the number; mass and
    stiffness drop out.
    """
    ratio, root = damping_ratio(restitution, end), math.sqrt(contacts / of)
    several = root * ratio.value
    slope = root * slope_of_restitution(several, end)
    return Measured(restitution_of_ratio(several, end), _root_sum([(slope, ratio.sigma)]))


def _root_sum(terms) -> float | None:
    """Root of the sum of squares of slope times sigma; None where no sigma is known."""
    known = [slope * sigma for slope, sigma in terms if sigma is not None]
    return math.hypot(*known) if known else None


@dataclass(frozen=True)
class Impact:
    """Impact of two particles, or one and a wall, by the linear law; sigmas as far as known."""

    restitution: Measured  # through `contacts` in parallel [-]
    kn: Measured  # of each contact [N/m]
    mass: Measured  # reduced [kg]
    contacts: int
    end: ContactEnd
    remarks: list[str]


def impact_of(
    *, materials: str | None, pair: str | None, restitution: str | None, kn: str | None,
    mass: str | None, other_mass: str | None, area: str | None, wall: bool, contacts: int,
    end: Literal["overlap", "force"],
) -> Impact:  # fmt: skip
    """Put together what is given and what the pair of a parameter file holds.

    The file may be one in the making. Raises InputError, one line that says what is missing,
    wrong or given twice.
    """
    if contacts < 1:
        raise InputError(f"--contacts {contacts}: must be at least 1")
    known = _Known.of(materials, pair) if materials else None
    e, stiffness = _value("restitution", restitution, known), _value("kn", kn, known)
    reduced = _reduced(_mass(mass, area, known), other_mass, wall)
    remarks = [
        f"{name} has no uncertainty and counts as exact; give one such as '+- 5 %'"
        for name, value in (("restitution", e), ("kn", stiffness), ("the mass", reduced))
        if value.sigma is None
    ]
    if e.sigma is not None and not e.sigma < e.value <= 1 - e.sigma:
        remarks.append(
            f"restitution {e.value:g} +- {e.sigma:.2g} reaches beyond 0 or 1, where no contact is: "
            "sigmas to first order say little of what follows"
        )
    return Impact(e, stiffness, reduced, contacts, end, remarks)


@dataclass(frozen=True)
class _Known:
    """Values that a file has for a pair, by its own name or the reverse."""

    path: Path
    first: str
    second: str
    values: dict[tuple[str, str], Measured]

    @classmethod
    def of(cls, materials: str, pair: str | None) -> "_Known":
        first, _, second = (pair or "").partition("-")
        if not first or not second:
            raise InputError(f"{materials}: say which pair is meant, such as --pair wood-steel")
        path, values, _ = read_values(materials)
        return cls(path, first, second, values)

    def of_pair(self, key: str) -> Measured | None:
        linear = ".linear" if key == "kn" else ""
        names = (f"{self.first}-{self.second}", f"{self.second}-{self.first}")
        found = (self.values.get((f"pair.{name}{linear}", key)) for name in names)
        return next((value for value in found if value is not None), None)


def _value(key: str, given: str | None, known: _Known | None) -> Measured:
    """A property of the pair: as given, else from the file."""
    option = f"--{key}"
    if given is not None:
        value = measured_quantity(given, PROPERTIES[key].unit, option)
        check_range(key, value)
        return value
    if known is None:
        raise InputError(f"{option} is missing; give it, or --materials FILE and --pair A-B")
    found = known.of_pair(key)
    if found is None:
        raise InputError(
            f"{known.path}: no {key} of pair {known.first}-{known.second}; give {option}"
        )
    return found


def _mass(mass: str | None, area: str | None, known: _Known | None) -> Measured:
    """Mass of one particle [kg]: as given, or of a prism of the first material of the pair."""
    if (mass is None) == (area is None):
        raise InputError(
            "give one of --mass '10.8 g +- 6 %' and, for a prism of the pair's first material, "
            "--area '200 mm2'"
        )
    if mass is not None:
        return _positive(measured_quantity(mass, "kg", "--mass"), "--mass", mass)
    assert area is not None
    section = _positive(measured_quantity(area, "m2", "--area"), "--area", area)
    if known is None:
        raise InputError("--area needs the density and length of --materials FILE and --pair A-B")
    factors = [section]
    for key in ("density", "length"):
        found = known.values.get((f"material.{known.first}", key))
        if found is None:
            raise InputError(f"{known.path}: [material.{known.first}] has no {key}; give --mass")
        factors.append(found)
    return _product(*factors)


def _product(*factors: Measured) -> Measured:
    """A product of independent factors; relative uncertainties add in squares."""
    value, variance = 1.0, 0.0
    for factor in factors:
        value *= factor.value
        variance += ((factor.sigma or 0.0) / factor.value) ** 2
    known = any(factor.sigma is not None for factor in factors)
    return Measured(value, value * variance**0.5 if known else None)


def _reduced(first: Measured, other: str | None, wall: bool) -> Measured:
    """Reduced mass: against a wall (eq. 3.10), another particle, or its like (eq. 3.9)."""
    if wall and other is not None:
        raise InputError("--wall does not move: leave out --other-mass, or --wall")
    if wall:
        return reduced_mass_of(first)
    if other is not None:
        second = measured_quantity(other, "kg", "--other-mass")
        return reduced_mass_of(first, _positive(second, "--other-mass", other))
    return Measured(first.value / 2, None if first.sigma is None else first.sigma / 2)


def _positive(value: Measured, field: str, given: str) -> Measured:
    with located(f"{field} = {given!r}:"):
        if value.value <= 0:
            raise InputError("must be above 0")
    return value


_PARALLEL = (1, 2, 4, 8)  # a corner; a face on a wall; shifted faces; aligned faces
_ENDS: tuple[ContactEnd, ...] = ("overlap", "force")


@dataclass(frozen=True, repr=False)
class Damping(AsText):
    """Damping that a restitution gives in both contact laws; a result (calibration.result).

    values     numbers in the unit of their key
    written    gamma_n as it stands in a parameter file, None where it was not written
    """

    impact: Impact
    values: dict[str, Any]
    written: dict[str, Any] | None = None

    def to_dict(self) -> dict[str, Any]:
        """The values, the warnings and what was written."""
        return self.values | {"warnings": self.impact.remarks, "into": self.written}

    def text(self) -> str:
        """The inputs, the damping for both ends of a contact, and contacts in parallel."""
        values = self.values
        lines = [
            f"restitution   {_shown(values['restitution'])} of {self._contacts}",
            f"kn            {_shown(values['kn_n_per_m'], 1e-3)} N/mm",
            f"reduced mass  {_shown(values['reduced_mass_kg'], 1e3)} g",
            "",
            f"{'the contact ends at':36}{'zero overlap':22}zero force",
            _row("gamma_n of each contact [1/s]", values["gamma_n_per_s"]),
            _row("b, linear or Hertz (eq. 5.29, 5.30)", values["damping_ratio"]),
            _row("zeta of Tsuji (eq. 5.31)", values["tsuji_zeta"]),
            "restitution with that gamma_n",
        ]
        parallel = values["restitution_in_parallel"]
        for k in _PARALLEL:
            name = "one contact" if k == 1 else f"{k} in parallel"
            lines.append(_row(f"  {name}", {end: parallel[end][str(k)] for end in _ENDS}))
        return "\n".join(lines + [f"warning: {remark}" for remark in self.impact.remarks])

    def figure(self) -> None:
        """None: nothing was measured here."""

    def parameters(self) -> dict[str, Parameter]:
        """gamma_n of the chosen end of contact, and what it came from."""
        values, impact = self.values, self.impact
        found = values["gamma_n_per_s"][impact.end]
        source = (
            f"restitution {_shown(values['restitution'])} of {self._contacts}, kn "
            f"{_shown(values['kn_n_per_m'], 1e-3)} N/mm, reduced mass "
            f"{_shown(values['reduced_mass_kg'], 1e3)} g"
        )
        estimate = Estimate(found["value"], found["sigma"], impact.restitution.trials or 0)
        method = f"from restitution, eq. 3.8, contact ends at zero {impact.end}"
        return {"gamma_n": Parameter(estimate, method, source)}

    @property
    def _contacts(self) -> str:
        count = self.impact.contacts
        return "one contact" if count == 1 else f"{count} contacts in parallel"


def damping(
    *, restitution: str | None = None, kn: str | None = None, mass: str | None = None,
    other_mass: str | None = None, area: str | None = None, wall: bool = False,
    contacts: int = 1, end: Literal["overlap", "force"] = "overlap",
    materials: str | Path | None = None, pair: str | None = None,
) -> Damping:  # fmt: skip
    """Convert a restitution into the damping gamma_n [1/s] of one contact, with its uncertainty.

    restitution   "0.53 +- 0.02", through `contacts` in parallel; else the pair's
    kn            "1e4 N/mm +- 18 %", of one contact; else the pair's
    mass          "10.8 g +- 6 %", of a particle; the other is its like
    other_mass    of the other particle, weighed by itself
    area          "200 mm2", instead of the mass: of a prism of the pair's first material
    wall          the other one is a wall that does not move
    end           a contact ends at zero overlap, or at zero force
    materials     a parameter file with a `pair`, such as "wood-steel", for what is not given

    Raises InputError, one line, for what is missing or wrong.
    """
    file = None if materials is None else str(materials)
    return damping_of(impact_of(
        materials=file, pair=pair, restitution=restitution, kn=kn, mass=mass,
        other_mass=other_mass, area=area, wall=wall, contacts=contacts, end=end,
    ))  # fmt: skip


def damping_of(impact: Impact) -> Damping:
    """Damping for both ends of a contact; InputError where no number can hold it."""
    e, n = impact.restitution, impact.contacts
    try:
        values = {
            "restitution": _pair(e),
            "contacts": n,
            "contact_end": impact.end,
            "kn_n_per_m": _pair(impact.kn),
            "reduced_mass_kg": _pair(impact.mass),
            "gamma_n_per_s": {
                end: _pair(linear_damping(e, impact.kn, impact.mass, end=end, contacts=n))
                for end in _ENDS
            },
            "restitution_in_parallel": {
                end: {str(k): _pair(in_parallel(e, k, of=n, end=end)) for k in _PARALLEL}
                for end in _ENDS
            },
            "damping_ratio": {end: _pair(damping_ratio(e, end)) for end in _ENDS},
            "tsuji_zeta": {end: _pair(tsuji_damping_ratio(e, end)) for end in _ENDS},
        }
    except (ValueError, OverflowError, ZeroDivisionError):  # of 1e-100, or a mass of 1e-300 g
        raise InputError(
            f"restitution {e.value:g}, kn {impact.kn.value:g} N/m and reduced mass "
            f"{impact.mass.value:g} kg: no number can hold the damping; check their units"
        ) from None
    return Damping(impact, values)


def _pair(value: Measured) -> dict[str, float | None]:
    return {"value": value.value, "sigma": value.sigma}


def _row(name: str, values: dict[str, dict[str, float | None]]) -> str:
    return f"{name:36}{_shown(values['overlap']):22}{_shown(values['force'])}"


def _shown(found: dict[str, float | None], factor: float = 1.0) -> str:
    """A value with its sigma, in the unit of the report."""
    value, sigma = found["value"], found["sigma"]
    assert value is not None
    return plus_minus(factor * value, None if sigma is None else factor * sigma)
