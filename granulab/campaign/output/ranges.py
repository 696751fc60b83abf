"""Answers that are possible: data/ranges.toml has what physics and the experiment allow for each.

Every command that prints an answer asks here first: an impossible one is refused, an unusual one
is printed with a warning.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from granulab.contact.files.datafile import data_root, read_toml
from granulab.errors import InputError

SCHEMA = 1
_SURE = 3  # sigmas
_EVERYTHING = (-math.inf, math.inf)


@dataclass(frozen=True)
class Range:
    """Range of an answer, in SI; the head of data/ranges.toml says what each key means."""

    of: str
    keys: tuple[str, ...]
    why: str
    cure: str
    physics: tuple[float, float] = _EVERYTHING
    experiment: tuple[float, float] = _EVERYTHING
    slack: float = 0.0

    def possible(self, value: float, sigma: float | None) -> bool:
        """True if physics allows a value, its noise considered."""
        off = _off(value, self.physics)
        return off <= (self.slack if sigma is None else min(self.slack, _SURE * sigma))

    @property
    def found(self) -> tuple[float, float]:
        """Range that such an experiment finds; that of physics where none is given."""
        return self.physics if self.experiment == _EVERYTHING else self.experiment


@cache
def ranges(of: str) -> tuple[Range, ...]:
    """The ranges of the answers of "calibration", "silo2d" or "damper3d"."""
    tables = read_toml(data_root() / "ranges.toml", "ranges", SCHEMA)["answer"]
    read: list[dict[str, Any]] = [
        {name: tuple(v) if isinstance(v, list) else v for name, v in table.items()}
        for table in tables
    ]
    return tuple(Range(**table) for table in read if table["of"] == of)


def judged(of: str, answers: Mapping[str, Any]) -> list[str]:
    """Warnings about unusual answers, a line each; InputError, one line, for an impossible one.

    answers   as they stand in the JSON; those that are None do not exist
    """
    found = []
    for one in ranges(of):
        for key in one.keys:
            for name, value, sigma in _numbers(answers, key.split(".")):
                known = f"{name} = {value:.4g}" + (f" (sigma {sigma:.2g})" if sigma else "")
                if not one.possible(value, sigma):
                    raise InputError(
                        f"{known}: outside {_said(one.physics)}, which cannot be: {one.why}; "
                        f"{one.cure}"
                    )
                if _off(value, one.found) > 0.0:
                    found.append(f"{known}: outside {_said(one.found)}: {one.why}; {one.cure}")
    return list(dict.fromkeys(found))


def _off(value: float, within: tuple[float, float]) -> float:
    """Distance of a value from a range [0 within it]; infinite for one that is no number."""
    low, high = within
    return max(low - value, value - high, 0.0) if math.isfinite(value) else math.inf


def _said(within: tuple[float, float]) -> str:
    return f"{within[0]:g} to {within[1]:g}"


def _numbers(
    here: Any, path: list[str], name: str = "", sigma: Any = None
) -> Iterator[tuple[str, float, float | None]]:
    """Name, value and sigma of the numbers at a path; None for a sigma that is not known."""
    if not path:
        if isinstance(here, int | float) and not isinstance(here, bool):
            yield name, float(here), sigma if isinstance(sigma, float) else None
        return
    word, *rest = path
    if word == "*" and isinstance(here, list):
        own = sigma if isinstance(sigma, list) else [None] * len(here)
        for k, (one, its) in enumerate(zip(here, own, strict=True)):
            yield from _numbers(one, rest, f"{name}.{k}", its)
    elif isinstance(here, dict) and word in here:
        beside = here.get("sigma" if word == "value" else f"{word}_sigma")
        yield from _numbers(here[word], rest, f"{name}.{word}".strip("."), beside)
