"""Assumptions, and how kt/kn changes with each.

Each row has one change, with half as many columns and load steps and with few profiles, the same
for all rows: what differs between rows is the change. For the uncertainty that all assumptions make
together the larger change of each counts as its standard uncertainty. A change of which no test
comes to its end has no values, and does not count.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from calibration.stiffness_fe.blocks import Array
from calibration.stiffness_fe.measure import Found, Progress, one_test
from calibration.stiffness_fe.protocol import Case, Load
from calibration.stiffness_fe.surfaces import Paths, Waves
from granulab.errors import InputError

_PROFILES = 4


@dataclass(frozen=True)
class Setting:
    """All that a test depends on."""

    case: Case
    flat: Load
    rough: Load
    surface: Waves | Paths


class Values(NamedTuple):
    """kt/kn of the flat and of the rough contact, and the rough one's normal stress in parts."""

    flat: float
    rough: float
    stress: float


@dataclass(frozen=True)
class Row:
    """One change, and the values with it.

    assumed    the paper does not give it
    values     None where a test came to no end; reason: why
    """

    what: str
    change: str
    assumed: bool
    values: Values | None
    reason: str = ""


Change = Callable[[Setting], Setting]


def vary(setting: Setting, seed: int, progress: Progress) -> list[Row]:
    """The rows; the first has nothing changed."""
    rows = []
    for what, change, assumed, changed in _changes(setting):
        progress(f"assumptions: {what}, {change}" if change else "assumptions")
        try:
            rows.append(Row(what, change, assumed, _values(changed(setting), seed)))
        except InputError as error:
            rows.append(Row(what, change, assumed, None, str(error)))
            if len(rows) == 1:  # with nothing that a change could be compared with
                break
    return rows


def applied(found: Found, rows: list[Row]) -> Found:
    """Result whose ratios have the uncertainty that all assumptions make together.

    As it was, where the test with nothing changed came to no end.
    """
    if (sigma := together(rows)) is None:
        return found
    assert found.flat is not None
    assert found.rough is not None
    assert found.stress is not None
    flat = replace(found.flat, ratio=found.flat.ratio.with_assumed(sigma.flat))
    rough = replace(found.rough, ratio=found.rough.ratio.with_assumed(sigma.rough))
    return replace(found, flat=flat, rough=rough, stress=found.stress.with_assumed(sigma.stress))


def together(rows: list[Row]) -> Values | None:
    """Standard uncertainty of each value by all that is assumed; None without any change."""
    base = rows[0].values
    largest: dict[str, Array] = {}
    for row in rows[1:]:
        if base and row.assumed and row.values:
            change = np.abs(np.subtract(row.values, base))
            largest[row.what] = np.maximum(largest.get(row.what, 0.0), change)
    if not largest:
        return None
    return Values(*np.sqrt(sum(change**2 for change in largest.values())))


def _values(setting: Setting, seed: int) -> Values:
    whole = setting.case
    case = replace(whole, columns=whole.columns // 2, steps=whole.steps // 2)
    flat = one_test(case, setting.flat, None, 0, seed)
    rough = [one_test(case, setting.rough, setting.surface, k, seed) for k in range(_PROFILES)]
    ratio, kn = np.mean([(one.ratio, one.kn) for one in rough], axis=0)
    return Values(flat.ratio, float(ratio), float(kn) / flat.kn)


def _changes(setting: Setting) -> list[tuple[str, str, bool, Change]]:
    case = setting.case
    sides = "free" if case.sides == "periodic" else "periodic"
    plane = "stress" if case.material.plane == "strain" else "strain"
    nu = case.material.poisson
    rows: list[tuple[str, str, bool, Change]] = [
        ("as stated", "", False, lambda s: s),
        ("sides", sides, True, lambda s: _case(s, sides=sides)),
        ("height of each block", "half", True, lambda s: _case(s, height=s.case.height / 2)),
        ("height of each block", "double", True, lambda s: _case(s, height=s.case.height * 2)),
        ("plane", plane, True, lambda s: _material(s, plane=plane)),
        ("shear", "with compression", True, lambda s: _case(s, together=not s.case.together)),
        *_of_surface(setting.surface, case.width),
        *_of_load("travel across", "across", True),
        *_of_load("travel along", "along", True),
        *_of_load("friction", "friction", False),
    ]
    others = [other for other in (nu - 0.1, nu + 0.1) if -1 < other < 0.5]
    return rows + [("Poisson's ratio", f"{other:g}", False, _poisson(other)) for other in others]


def _of_surface(surface: Waves | Paths, width: float) -> list[tuple[str, str, bool, Change]]:
    """Changes of a made surface; a measured one is what it is."""
    if isinstance(surface, Paths):
        return []
    rows: list[tuple[str, str, bool, Change]] = [
        ("roughness Ra", "half", True, lambda s: _waves(s, ra=surface.ra / 2)),
        ("roughness Ra", "double", True, lambda s: _waves(s, ra=surface.ra * 2)),
        # as many columns a wave as before
        ("shortest wave", "half", True,
         lambda s: _case(_waves(s, wavelength=surface.wavelength / 2), columns=2 * s.case.columns)),
        ("longest wave", "twice the shortest", True,
         lambda s: _waves(s, longest=2 * surface.wavelength)),
        ("rough surfaces", "one of the two", True, lambda s: _waves(s, one_sided=True)),
    ]  # fmt: skip
    if 2 * surface.wavelength <= width:
        longer = 2 * surface.wavelength
        rows.append(("shortest wave", "double", True, lambda s: _waves(s, wavelength=longer)))
    return rows


def _of_load(what: str, key: str, assumed: bool) -> list[tuple[str, str, bool, Change]]:
    """Half and double of what the loads of both contacts have."""

    def by(factor: float) -> Change:
        def change(s: Setting) -> Setting:
            flat, rough = (
                replace(load, **{key: factor * getattr(load, key)}) for load in (s.flat, s.rough)
            )
            return replace(s, flat=flat, rough=rough)

        return change

    return [(what, "half", assumed, by(0.5)), (what, "double", assumed, by(2.0))]


def _poisson(value: float) -> Change:
    return lambda setting: _material(setting, poisson=value)


def _case(setting: Setting, **changes: object) -> Setting:
    return replace(setting, case=replace(setting.case, **changes))  # type: ignore[arg-type]


def _material(setting: Setting, **changes: object) -> Setting:
    material = replace(setting.case.material, **changes)  # type: ignore[arg-type]
    return _case(setting, material=material)


def _waves(setting: Setting, **changes: object) -> Setting:
    """Another made surface, of which the waves that both have are alike."""
    assert isinstance(setting.surface, Waves)
    waves = int(setting.surface.numbers(setting.case.width)[-1])
    surface = replace(setting.surface, drawn=waves, **changes)  # type: ignore[arg-type]
    return replace(setting, surface=surface)
