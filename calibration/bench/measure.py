"""Trials evaluated and pooled, with the uncertainty of readings and instruments; and the result."""

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from calibration.bench.sections import Columns, Request, Section
from calibration.result import AsText, Parameter
from calibration.statistics.quantity import plus_minus
from calibration.statistics.uncertainty import Estimate, Pooled, pooled
from granulab.contact.files.units import located, to_si
from granulab.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Evaluate = Callable[[Columns], Estimate]

_ROUNDING = 1e-9  # share of a value, by which sums of floats change it

_COARSE = (
    "the trials do not differ: their readings are too coarse for a sigma; give the resolution as "
    "--reading or --instrument"
)


class Filmed(Protocol):
    """A trial measured from a film."""

    @property
    def name(self) -> str:
        """Name of the film in file names."""

    def to_dict(self) -> dict[str, Any]:
        """Series of the film, for JSON."""

    def figure(self) -> "Figure":
        """The diagnostic figure of the film."""


class Curve(NamedTuple):
    """Record of one trial, and what was fitted to it.

    x, y     (n,) each, as the axes of the quantity say
    fits     (x, y) of each line or curve that was fitted
    """

    name: str
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    fits: tuple[tuple[NDArray[np.float64], NDArray[np.float64]], ...] = ()


@dataclass(frozen=True)
class Quantity:
    """One quantity of all trials.

    key      its name in JSON, with the SI unit: "density_kg_m3"
    unit     in which people read it
    pooled   over all trials, and by group; sigma with what instruments add
    trials   (name, group, value) of each
    shared   {input: how much its uncertainty, which all trials share, adds to sigma}
    idle     inputs whose uncertainty, shared or of a reading, changes no trial
    """

    key: str
    name: str
    si: str
    unit: str
    pooled: Pooled
    trials: tuple[tuple[str, str, Estimate], ...]
    shared: dict[str, float] = field(default_factory=dict)
    idle: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    details: dict[str, Any] = field(default_factory=dict)  # more of the method's own, for JSON
    curves: tuple[Curve, ...] = ()  # for the figure, with the names of
    axes: tuple[str, str] = ("", "")  # its axes
    films: tuple["Filmed", ...] = ()  # with a figure of their own

    def to_dict(self) -> dict[str, Any]:
        """The keys of docs/laboratory/bench.md."""
        whole = asdict(self.pooled.all) | {
            "groups": {name: asdict(one) for name, one in self.pooled.groups.items()},
            "groups_alike": self.pooled.alike,
            "groups_p": self.pooled.p,
            "sigma_shared": self.shared,
            "per_trial": [
                {"trial": name, "group": group, "value": one.value, "sigma": one.sigma}
                for name, group, one in self.trials
            ],
            "remarks": list(self.remarks),
        }
        films = {"films": [one.to_dict() for one in self.films]} if self.films else {}
        return {self.key: whole} | films | self.details


def measure(
    sections: Sequence[Section], evaluate: Evaluate, what: Request, *, key: str, name: str,
    si: str = "1", unit: str = "1", remarks: Sequence[str] = (),
) -> Quantity:  # fmt: skip
    """Evaluate every trial, pool them by group and together, and add what instruments share.

    Raises InputError for a trial that cannot be evaluated, and for the uncertainty of an input that
    no trial has.
    """
    _refuse_unknown(sections, what)
    values, idle = [], set(what.single) | set(what.shared)
    for section in sections:
        one_value, moved = _one(section, evaluate, what)
        values.append(one_value)
        idle -= moved
    found = _pooled(sections, values, bool(what.single))
    shared = {}
    for one, sigma in what.shared.items():
        slopes = []
        for section in sections:
            with located(f"{section.name}:"):
                slopes.append(_half_difference(section, evaluate, one, sigma))
        if any(slopes):  # not an input that only another result of the method needs
            found, shared[one] = _widened(found, sections, slopes)
            idle.discard(one)
    trials = tuple((s.name, s.group, v) for s, v in zip(sections, values, strict=True))
    alike = len(values) > 1 and found.all.scatter == 0 and found.all.sigma is None
    coarse = [_COARSE] if alike else []
    return Quantity(
        key, name, si, unit, found, trials, shared, tuple(sorted(idle)), (*remarks, *coarse)
    )


def _refuse_unknown(sections: Sequence[Section], what: Request) -> None:
    """InputError for an uncertainty of an input that stands in no table and is no constant."""
    for option, sigmas in (("--instrument", what.shared), ("--reading", what.single)):
        for name in sigmas:
            if not any(name in section.columns for section in sections):
                raise InputError(
                    f"{option} {name}: no trial has {name}; there are "
                    f"{', '.join(sections[0].columns)}: leave it out, or name the column"
                )


def _one(section: Section, evaluate: Evaluate, what: Request) -> tuple[Estimate, set[str]]:
    """One trial, its sigma that of its fit and of its readings; the inputs whose readings count."""
    moved = set()
    with located(f"{section.name}:"):
        found = evaluate(section.columns)
        variance = 0.0 if found.sigma is None else found.sigma**2
        for one, sigma in what.single.items():
            if by := _half_difference(section, evaluate, one, sigma):
                variance += by**2
                moved.add(one)
    if not math.isfinite(found.value):
        raise InputError(f"{section.name}: gives no finite number")
    return replace(found, sigma=math.sqrt(variance) if variance else found.sigma), moved


def _half_difference(section: Section, evaluate: Evaluate, name: str, sigma: float) -> float:
    """Change of a trial by an input that is one sigma off: a central difference.

    To one side alone where the other is none that an input can have, such as a height below 0; 0
    where the trial has no such input, and for a change of nothing but rounding. Raises InputError
    where neither side can be.
    """
    if name not in section.columns:
        return 0.0
    moved: dict[int, float] = {}
    for side in (1, -1):
        with suppress(InputError):
            columns = section.columns | {name: section.columns[name] + side * sigma}
            moved[side] = evaluate(columns).value
    if not moved:
        raise InputError(
            f"the uncertainty of {name}, {sigma:.3g} in SI, is as large as what is measured by it: "
            "check its unit"
        )
    if len(moved) == 2:
        change = (moved[1] - moved[-1]) / 2
    else:
        change = sum(side * (value - evaluate(section.columns).value)
                     for side, value in moved.items())  # fmt: skip
    return change if abs(change) > _ROUNDING * max(map(abs, moved.values())) else 0.0


def _pooled(sections: Sequence[Section], values: Sequence[Estimate], read: bool) -> Pooled:
    """Pooled values of the trials by group; a group of one trial has that trial's own sigma.

    read    whether readings have an uncertainty: no mean is better known than by these
    """
    groups: dict[str, list[Estimate]] = {}
    for section, value in zip(sections, values, strict=True):
        groups.setdefault(section.group, []).append(value)
    found = pooled({name: [one.value for one in ones] for name, ones in groups.items()})
    alone = {
        name: ones[0] if len(ones) == 1 else found.groups[name] for name, ones in groups.items()
    }
    whole = values[0] if len(values) == 1 else found.all
    if not read:
        return Pooled(whole, alone, found.p)
    known = {name: no_better_than(ones, alone[name]) for name, ones in groups.items()}
    each_once = found.alike is False
    return Pooled(
        no_better_than(list(known.values()) if each_once else values, whole), known, found.p
    )


def no_better_than(ones: Sequence[Estimate], mean: Estimate) -> Estimate:
    """The mean of these with at least the sigma that theirs give it.

    Trials that do not differ share the error of a reading that is too coarse to show it.
    """
    share = 1 if mean.scatter == 0 else len(ones)
    least = math.sqrt(sum((one.sigma or 0.0) ** 2 for one in ones) / len(ones) / share)
    return replace(mean, sigma=max(mean.sigma or 0.0, least) or None)


def _widened(
    found: Pooled, sections: Sequence[Section], moved: Sequence[float]
) -> tuple[Pooled, float]:
    """Every sigma with what moves all trials together, and by how much that moves the whole."""
    by_group = {
        name: float(np.mean([m for s, m in zip(sections, moved, strict=True) if s.group == name]))
        for name in found.groups
    }
    each_once = found.alike is False
    whole = abs(float(np.mean(list(by_group.values()) if each_once else moved)))

    def wider(one: Estimate, by: float) -> Estimate:
        return replace(one, sigma=math.hypot(one.sigma or 0.0, by))

    groups = {name: wider(one, by_group[name]) for name, one in found.groups.items()}
    return Pooled(wider(found.all, whole), groups, found.p), whole


_MOST_TRIALS = 60  # lines of single trials; JSON has them all


@dataclass(frozen=True, repr=False)
class Measurement(AsText):
    """Quantities that one method measured from tables; a result (calibration.result).

    method      name of the command, written to a parameter file
    writes      {property of a parameter file: key of its quantity}
    constants   nothing was read from files
    brief       text: a line for each quantity, of all trials
    """

    quantities: tuple[Quantity, ...]
    method: str = ""
    writes: Mapping[str, str] = field(default_factory=dict)
    constants: bool = False
    brief: bool = False

    def to_dict(self) -> dict[str, Any]:
        """The keys of docs/laboratory/bench.md, of all quantities."""
        return {key: value for one in self.quantities for key, value in one.to_dict().items()}

    def text(self) -> str:
        """Every quantity: by trial, by group, together, and whether the groups are alike."""
        if self.brief:
            return "\n".join(
                f"{title_of(one)}: {value(one.pooled.all, scale_of(one))}"
                for one in self.quantities
            )
        return "\n\n".join("\n".join(_lines(one)) for one in self.quantities)

    def figure(self) -> "Figure":
        """Trials of each quantity by group with what they give, and the curves they come from."""
        from calibration.bench.figure import draw

        return draw(self.quantities, self.method)

    def parameters(self) -> dict[str, Parameter]:
        """Values that a parameter file can take."""
        source = "constants on the command line" if self.constants else None
        found = {one.key: one.pooled.all for one in self.quantities}
        return {
            name: Parameter(found[key], self.method, source)
            for name, key in self.writes.items()
            if key in found
        }


def title_of(result: Quantity) -> str:
    """Name of a quantity with its unit."""
    return result.name if result.unit == "1" else f"{result.name} [{result.unit}]"


def scale_of(result: Quantity) -> float:
    """SI units in one of the units that are shown."""
    return 1.0 if result.unit == "1" else to_si(f"1 {result.unit}", result.si, result.name)


def _lines(result: Quantity) -> list[str]:
    scale = scale_of(result)
    lines = [title_of(result)]
    shown = result.trials[:_MOST_TRIALS] if len(result.trials) > 1 else ()
    several = len(result.pooled.groups) > 1
    names = [f"{group}, {name}" if several else name for name, group, _ in shown]
    width = max(map(len, [*names, *result.pooled.groups, "all"]))
    lines += [
        f"  {name:{width}}  {value(one, scale)}"
        for name, (_, _, one) in zip(names, shown, strict=True)
    ]
    if len(result.trials) > len(shown) > 0:
        lines.append(f"  ... and {len(result.trials) - len(shown)} more")
    if several:
        lines += [
            f"  {name:{width}}  {value(one, scale)}, {_trials(one, scale)}"
            for name, one in result.pooled.groups.items()
        ]
    whole = result.pooled.all
    lines.append(f"  {'all':{width}}  {value(whole, scale)}, {_trials(whole, scale)}")
    lines += [f"  {line}" for line in [*_alike(result), *_shared(result, scale), *result.remarks]]
    return lines


def value(one: Estimate, scale: float = 1.0) -> str:
    """A value and its sigma in a unit of `scale` SI units."""
    if not one.sigma:
        return f"{one.value / scale:.4g}"
    return plus_minus(one.value / scale, one.sigma / scale)


def _trials(one: Estimate, scale: float) -> str:
    if not one.trials:
        return "from constants"
    if one.scatter is None:
        return "1 trial" if one.trials == 1 else f"{one.trials} trials"
    share = f" ({100 * one.scatter / abs(one.value):.0f} %)" if one.value else ""
    return f"{one.trials} trials, scatter {one.scatter / scale:.2g}{share}"


def _alike(result: Quantity) -> list[str]:
    if result.pooled.p is None:
        return []
    said = "are alike" if result.pooled.alike else "differ: each counts once"
    return [f"the groups {said} (analysis of variance: p = {result.pooled.p:.2g})"]


def _shared(result: Quantity, scale: float) -> list[str]:
    return [
        f"in sigma, from {name}, which all trials share: {sigma / scale:.2g}"
        for name, sigma in result.shared.items()
    ]
