"""Stiffness from load-unload cycles in compression, modulus from it, and kn = E A/L (sec. 3.2.1).

The unloading branch of each cycle is taken as elastic: k = dF/dx; E = k L/A of the specimen, or
E = dsigma/depsilon; kn = E A/L with the section and length of the particles that touch.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from calibration.bench.cycles import Cycle, oriented, unloading_stiffness
from calibration.bench.measure import Curve, Quantity, measure
from calibration.bench.sections import Columns, Input, Request, Section, curves, need
from calibration.statistics.uncertainty import Estimate, of_trials
from granulab.contact.files.units import located
from granulab.errors import InputError

INPUTS = (
    Input("displacement", "m", "of a specimen, in the order of the measurement, and"),
    Input("load", "N", "on it, compression positive; with"),
    Input("area", "m2", "the specimen's cross section and"),
    Input("length", "m", "its length for the modulus;"),
    Input("strain", "1", "or the strain and"),
    Input("stress", "Pa", "the stress,"),
    Input("modulus", "Pa", "or the modulus itself;"),
    Input("contact_area", "m2", "cross section and"),
    Input("contact_length", "m", "length of the particle, for kn = E A/L"),
)
_CURVE, _STRESS = ["displacement", "load"], ["strain", "stress"]
_SPECIMEN, _CONTACT = ["area", "length"], ["contact_area", "contact_length"]
# Paper sec. 3.2.1: E [Pa], A [m2], L [m], and the kn [N/m] that is printed for them.
_PAPER, _PAPER_KN = (242e6, 1200e-6, 20e-3), 1.0e7


@dataclass(frozen=True)
class Branch:
    """The part of a record that counts: shares of the fall of the load, and of its whole range.

    upper, lower  the fit takes the unloading between these shares of its fall
    least         a fall by less than this share of the range of the load is no cycle
    """

    upper: float
    lower: float
    least: float

    def __post_init__(self) -> None:
        if not 0 <= self.lower < self.upper <= 1 or not 0 < self.least < 1:
            raise InputError(
                f"--range {self.upper:g},{self.lower:g} --least-cycle {self.least:g}: takes shares "
                "between 0 and 1, the upper one first"
            )


class _Records:
    """Cycles, slope and modulus of the curves of trials; the cycles of each are found once."""

    def __init__(self, by_load: bool, branch: Branch) -> None:
        self.x, self.y = _CURVE if by_load else _STRESS
        self.branch = branch
        self._known: dict[tuple[bytes, bytes], list[Cycle]] = {}

    def cycles(self, columns: Columns) -> list[Cycle]:
        """Every unloading of the curve."""
        x, y = columns[self.x], columns[self.y]
        key = x.tobytes(), y.tobytes()
        if key not in self._known:
            upper, lower, least = self.branch.upper, self.branch.lower, self.branch.least
            self._known[key] = unloading_stiffness(x, y, upper=upper, lower=lower, least=least)
        return self._known[key]

    def slope(self, columns: Columns) -> Estimate:
        """The mean of the cycles, sigma by their scatter; of one cycle, its fit. One trial."""
        found = [one.stiffness for one in self.cycles(columns)]
        if len(found) == 1:
            return found[0]
        mean = of_trials([one.value for one in found])
        return Estimate(mean.value, mean.sigma, 1)

    def drawn(self, section: Section) -> Curve:
        """A record with compression positive, and the points of each unloading that were fitted."""
        x, y = oriented(section.columns[self.x], section.columns[self.y])
        x_scale, y_scale, _ = self._axes
        fits = tuple(
            (x_scale * one.fitted[0], y_scale * one.fitted[1])
            for one in self.cycles(section.columns)
        )
        return Curve(section.name, x_scale * x, y_scale * y, fits)

    @property
    def axes(self) -> tuple[str, str]:
        """Names of the axes of what is drawn."""
        return self._axes[2]

    @property
    def _axes(self) -> tuple[float, float, tuple[str, str]]:
        if self.y == "load":
            return 1e3, 1.0, ("displacement [mm]", "load [N]")
        return 1.0, 1e-6, ("strain [-]", "stress [MPa]")

    def modulus(self, columns: Columns) -> Estimate:
        """E = k L/A, or the slope of stress against strain itself."""
        if self.y == "stress":
            return self.slope(columns)
        area, length = (_positive(columns, name) for name in _SPECIMEN)
        travel = float(np.ptp(columns[self.x]))
        if travel >= length:
            raise InputError(
                f"the displacement goes over {1e3 * travel:.3g} mm of a specimen that is "
                f"{1e3 * length:g} mm long; check the units in the head"
            )
        return _times(self.slope(columns), length / area)


def stiffness(
    files: Sequence[str | Path], what: Request, *, trial: str | None = None,
    share: tuple[float, float] = (0.95, 0.5), least_cycle: float = 0.1,
) -> list[Quantity]:  # fmt: skip
    """Unloading stiffness, modulus and kn, as far as the columns suffice; a curve a trial.

    share, least_cycle   the part of each unloading that is fitted, see Branch
    """
    branch = Branch(*share, least_cycle)
    if not files:
        return [_contact_stiffness([_given(what)], what, _modulus_given)]
    sections, remarks = curves(files, INPUTS, what, trial, [_CURVE, _STRESS])
    by_load = {need(section, [_CURVE, _STRESS], INPUTS) == 0 for section in sections}
    if len(by_load) > 1:
        raise InputError("some files have loads and some stresses; measure them one by one")
    records = _Records(by_load.pop(), branch)
    remarks.append(
        f"slopes between {branch.upper:.0%} and {branch.lower:.0%} of each unloading; its upper "
        "over its lower half: " + _bends(sections, records.cycles)
    )
    if len(sections) == 1 and (n := len(records.cycles(sections[0].columns))) > 1:
        remarks.append(f"{n} cycles of one specimen: sigma by their scatter, not by specimens'")
    found = []
    if records.y == "load":
        found.append(
            measure(
                sections, records.slope, what,
                key="unloading_stiffness_n_per_m", name="unloading stiffness", si="N/m",
                unit="N/mm",
            )
        )  # fmt: skip
    if records.y == "stress" or _all_have(sections, _SPECIMEN):
        found.append(
            measure(
                sections, records.modulus, what,
                key="youngs_modulus_pa", name="modulus", si="Pa", unit="MPa",
            )
        )  # fmt: skip
        if _all_have(sections, _CONTACT):
            found.append(_contact_stiffness(sections, what, records.modulus))
    details = _per_cycle(sections, records.cycles, "n" if records.y == "load" else "pa")
    first = replace(
        found[0], remarks=tuple(remarks), details=details, axes=records.axes,
        curves=tuple(records.drawn(section) for section in sections),
    )  # fmt: skip
    return [first, *found[1:]]


def _contact_stiffness(
    sections: Sequence[Section], what: Request, modulus: Callable[[Columns], Estimate]
) -> Quantity:
    """kn = E A/L of the particles in contact."""
    remarks = []

    def kn(columns: Columns) -> Estimate:
        area, length = (_positive(columns, name) for name in _CONTACT)
        return _times(modulus(columns), area / length)

    first = sections[0].columns
    used = (modulus(first).value, *(float(first[name][0]) for name in _CONTACT))
    if np.allclose(used, _PAPER, rtol=1e-6):
        remarks.append(
            f"the paper prints {_PAPER_KN / 1e3:.0f} N/mm for these E, A and L (sec. 3.2.1); "
            f"E A/L is {used[0] * used[1] / used[2] / 1e3:.0f} N/mm"
        )
    return measure(
        sections, kn, what, key="kn_n_per_m", name="normal stiffness kn = E A/L",
        si="N/m", unit="N/mm", remarks=remarks,
    )  # fmt: skip


def _given(what: Request) -> Section:
    """Constants alone, without a file."""
    section = Section("all", "as given", {k: np.array([v]) for k, v in what.constants.items()})
    need(section, [["modulus", *_CONTACT]], INPUTS)
    return section


def _modulus_given(columns: Columns) -> Estimate:
    return Estimate(_positive(columns, "modulus"), None, 0)  # nobody said of how many trials


def _positive(columns: Columns, name: str) -> float:
    value = float(columns[name][0])
    if value <= 0:
        raise InputError(f"{name} = {value:g} in SI: is above 0")
    return value


def _times(one: Estimate, factor: float) -> Estimate:
    scaled = [None if v is None else v * factor for v in (one.sigma, one.scatter)]
    return Estimate(one.value * factor, scaled[0], one.trials, scaled[1])


def _all_have(sections: Sequence[Section], names: Sequence[str]) -> bool:
    return all(name in section.columns for section in sections for name in names)


def _bends(sections: Sequence[Section], cycles: Callable[[Columns], list[Cycle]]) -> str:
    """The median over all cycles; the command's users see by it how straight the branches are."""
    bends = []
    for section in sections:
        with located(f"{section.name}:"):
            bends += [one.bend for one in cycles(section.columns) if one.bend is not None]
    return f"{np.median(bends):.2f} (median)" if bends else "too few points"


def _per_cycle(
    sections: Sequence[Section], cycles: Callable[[Columns], list[Cycle]], unit: str
) -> dict[str, object]:
    """Every cycle for JSON, and as lines."""
    said = "stiffness_n_per_m" if unit == "n" else "modulus_pa"
    return {
        "cycles": [
            {
                "trial": section.name,
                "group": section.group,
                "cycle": k,
                f"peak_{unit}": one.peak_load,
                said: one.stiffness.value,
                "sigma": one.stiffness.sigma,
                "upper_over_lower": one.bend,
                "points": one.points,
            }
            for section in sections
            for k, one in enumerate(cycles(section.columns), start=1)
        ]
    }
