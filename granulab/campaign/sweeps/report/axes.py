"""Axes of a sweep: what was varied, and which keys went together."""

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

_DECADE = 8.0  # ratio of the ends from which on even ratios are drawn logarithmically

Labels = Mapping[str, Any]


class Varied(NamedTuple):
    """A column of labels: the key of a case that it holds, and how people write it.

    label, unit     of its axis; factor: SI of one such unit
    drawn           whether its values come from a distribution
    """

    column: str
    label: str
    unit: str = ""
    factor: float = 1.0
    drawn: bool = False

    def shown(self, value: Any) -> str:
        """A value as text in the unit."""
        if isinstance(value, float | int) and not isinstance(value, bool):
            return f"{value / self.factor:.6g}"
        return str(value)

    @property
    def heading(self) -> str:
        """Label with unit."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label


class Axis(NamedTuple):
    """Something that was varied: one column, with those that it determines and that determine it.

    kind        "number", "word", or "drawn" from a distribution
    values      of its column, numbers ascending, words as the study has them
    alike       columns that go along
    """

    varied: Varied
    kind: Literal["number", "word", "drawn"]
    values: tuple[Any, ...]
    alike: tuple[Varied, ...] = ()

    @property
    def heading(self) -> str:
        """Label with unit, and what goes along."""
        others = ", ".join(one.label for one in self.alike)
        return f"{self.varied.heading} (with {others})" if others else self.varied.heading

    def at(self, labels: Labels) -> float:
        """Position of a combination: the number in its unit, or that of the word."""
        value = labels[self.varied.column]
        if self.kind == "word":
            return float(self.values.index(key_of(value)))
        return float(value) / self.varied.factor

    @property
    def positions(self) -> list[float]:
        """Positions of the values."""
        return [self.at({self.varied.column: value}) for value in self.values]

    @property
    def texts(self) -> list[str]:
        """The values in words."""
        return [self.varied.shown(value) for value in self.values]

    @property
    def is_logarithmic(self) -> bool:
        """True where the values have rather even ratios than even steps, over a decade or so."""
        x = self.positions
        if self.kind == "word" or len(x) < 3 or x[0] <= 0 or x[-1] / x[0] < _DECADE:
            return False
        return _uneven([math.log(value) for value in x]) < _uneven(x)


def _uneven(x: Sequence[float]) -> float:
    """Deviation of the steps over their mean."""
    steps = [b - a for a, b in itertools.pairwise(x)]
    mean = sum(steps) / len(steps)
    return math.sqrt(sum((step / mean - 1) ** 2 for step in steps) / len(steps))


def key_of(value: Any) -> Any:
    """A label as something that can be compared: a list as its text."""
    return repr(value) if isinstance(value, list | dict) else value


def axes_of(varied: Sequence[Varied], combinations: Sequence[Labels]) -> list[Axis]:
    """The axes of some combinations, in the order of their columns.

    A column of one value is none. One whose values are given by those of an earlier one, and the
    other way round, goes along with that one.
    """
    axes: list[Axis] = []
    for one in varied:
        values = [key_of(labels[one.column]) for labels in combinations]
        if len(set(values)) < 2:
            continue
        partner = next((k for k, axis in enumerate(axes) if _go_along(axis, values, combinations)),
                       None)  # fmt: skip
        if partner is None:
            axes.append(_axis(one, values))
        else:
            axis = axes[partner]
            # A number is the better axis than a word that goes along with it, such as a case.
            if axis.kind == "word" and (other := _axis(one, values)).kind != "word":
                axes[partner] = other._replace(alike=(axis.varied, *axis.alike))
            else:
                axes[partner] = axis._replace(alike=(*axis.alike, one))
    return axes


def _go_along(axis: Axis, values: Sequence[Any], combinations: Sequence[Labels]) -> bool:
    own = [key_of(labels[axis.varied.column]) for labels in combinations]
    return len(set(own)) == len(set(values)) == len(set(zip(own, values, strict=True)))


def _axis(varied: Varied, values: Sequence[Any]) -> Axis:
    """The axis of a column alone."""
    if all(isinstance(v, float | int) and not isinstance(v, bool) for v in values):
        return Axis(varied, "drawn" if varied.drawn else "number", tuple(sorted(set(values))))
    return Axis(varied, "word", tuple(dict.fromkeys(values)))
