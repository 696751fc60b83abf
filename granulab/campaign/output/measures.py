"""Measures of finished runs: named functions of a run folder, each with its unit and its picture.

A simulator keeps a registry of them, MEASURES in its package `measures`, which its command
`observe RUN WHAT` reads. A new measure is a module with `measure` and `draw` and a line there; or,
from outside, a call of `register`:

    register("spread", Measure("spread of the bed along the motion", "m", measure, draw))
"""

import importlib
import inspect
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from granulab.contact.files.units import nearest
from granulab.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Measure(NamedTuple):
    """A measure that can be made of a run; both functions read its folder and no live world.

    They may take `between`, from and until [s], which `observe --between` gives.
    """

    text: str  # in a line
    unit: str  # of the number that measure() gives first, such as "kg"; "1": without
    measure: Callable[..., dict[str, Any]]  # numbers and series in SI, ready for JSON
    draw: Callable[..., "Figure"]


class Shipped(NamedTuple):
    """A measure that a module of the simulator makes, imported when it is wanted."""

    text: str
    unit: str
    module: str  # with functions measure and draw

    def load(self) -> Measure:
        """The measure."""
        module = importlib.import_module(self.module)
        return Measure(self.text, self.unit, module.measure, module.draw)


class Measures:
    """A registry of measures by the names that `observe` takes."""

    def __init__(self, shipped: dict[str, Shipped]) -> None:
        self._known: dict[str, Shipped | Measure] = dict(shipped)

    def __iter__(self) -> Iterator[str]:
        return iter(self._known)

    def register(self, name: str, measure: Measure) -> None:
        """Add a measure from outside the package; InputError where the name is taken."""
        if name in self._known:
            raise InputError(f"measure {name!r}: there is one of that name; give another")
        self._known[name] = measure

    def remove(self, name: str) -> None:
        """Take a registered measure out again."""
        del self._known[name]

    def find(self, name: str) -> Measure:
        """The measure of a name; InputError with the names there are."""
        if name not in self._known:
            raise InputError(f"observe {name!r}: {nearest(name, list(self._known))}")
        known = self._known[name]
        return known.load() if isinstance(known, Shipped) else known

    def observe(self, folder: str | Path, name: str, **options: Any) -> dict[str, Any]:
        """Numbers and series [SI] that a measure makes of a run folder.

        options: between, from and until [s], of the measures that take it. InputError for a name or
        an option that there is not.
        """
        return self.find(name).measure(Path(folder), **self.options(name, **options))

    def draw(self, folder: str | Path, name: str, **options: Any) -> "Figure":
        """The picture of a measure of a run folder; see observe."""
        return self.find(name).draw(Path(folder), **self.options(name, **options))

    def options(self, name: str, **options: Any) -> dict[str, Any]:
        """Those options that are given; InputError where the measure of a name takes one not."""
        given = {key: value for key, value in options.items() if value is not None}
        for key in given:
            takes = [
                one for one in self if key in inspect.signature(self.find(one).measure).parameters
            ]
            if name not in takes:
                those = ", ".join(takes) or "none"
                raise InputError(f"observe {name!r} takes no --{key}; those that do: {those}")
        return given

    def listing(self) -> str:
        """A line for each measure: name, what it measures, unit."""
        return "\n".join(
            f"{name:15} {one.text}" + (f" [{one.unit}]" if one.unit != "1" else "")
            for name, one in self._known.items()
        )
