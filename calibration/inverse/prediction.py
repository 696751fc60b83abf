"""Predictions of the fitted simulator for each observed value, as lines for figures."""

from dataclasses import dataclass

import numpy as np

from calibration.inverse.observation import Observation
from calibration.inverse.result import Fitted
from calibration.inverse.statistics.prior import Array

_DRAWS = 2000
_BAND = 0.025, 0.5, 0.975


@dataclass(frozen=True)
class Line:
    """Values that belong together along an abscissa (n,), as observed and as predicted."""

    name: str
    x: Array
    observed: Array
    sigma: Array
    low: Array
    median: Array
    high: Array


@dataclass(frozen=True)
class Panel:
    """Lines on the same axes; where they have no abscissa, predictions stand `aside`."""

    title: str
    abscissa: str
    ordinate: str
    lines: tuple[Line, ...]
    aside: float


def predicted(found: Fitted, seed: int = 1) -> Array:
    """Quantiles (3, d) of a new observation's true values: parameters, emulator and chance."""
    model = found.posterior.model
    assert model.processes is not None
    assert model.reduction is not None
    random = np.random.default_rng(seed)
    samples = found.posterior.samples
    chosen = samples[random.integers(len(samples), size=_DRAWS)]
    mean, variance = model.processes.predict(chosen)
    values = model.reduction.back(mean + np.sqrt(variance) * random.standard_normal(mean.shape))
    scatter = np.sqrt(np.diag(model.observed.over_trials(model.single)))
    values = values + scatter * random.standard_normal(values.shape)
    return np.quantile(values, _BAND, axis=0)


def panels(found: Fitted) -> list[Panel]:
    """One for each observation; dampers' efficiencies together, profiles one for each time."""
    quantiles = predicted(found)
    groups: dict[tuple[str, ...], list[tuple[Observation, int]]] = {}
    first = _starts(found)
    for number, one in found.fit.observations:
        for k in range(len(one.values)):
            member = one, first[id(one)] + k
            groups.setdefault(_panel_of(found, number, one, k), []).append(member)
    return [_panel(found, key[0], members, quantiles) for key, members in groups.items()]


def _panel_of(found: Fitted, number: int, one: Observation, k: int) -> tuple[str, ...]:
    """Properties that the values of a panel share, its title first."""
    if one.kind == "profile":
        return f"profile at {one.at[k, 0]:.3g} s", str(one.file)
    if one.changes:
        return one.label, str(one.file)
    case = found.fit.cases[number][0].rsplit("/")[-1]
    several = len(found.fit.cases) > 1
    return (f"{one.label}, {case}" if several else one.label), str(number), str(id(one))


def _panel(
    found: Fitted, title: str, members: list[tuple[Observation, int]], quantiles: Array
) -> Panel:
    observed = found.posterior.model.observed
    first = _starts(found)
    lines: dict[str, list[tuple[float, int]]] = {}
    for one, at in members:
        k = at - first[id(one)]
        lines.setdefault(one.series[k], []).append((float(one.abscissa[k]), at))
    one = members[0][0]
    drawn = []
    for name, entries in lines.items():
        x, rows = (np.array(column) for column in zip(*sorted(entries), strict=True))
        drawn.append(
            Line(name if len(lines) > 1 or one.changes else "", x, observed.values[rows],
                 observed.sigma[rows], *quantiles[:, rows])
        )  # fmt: skip
    everywhere = np.concatenate([line.x for line in drawn])
    aside = 0.02 * float(np.ptp(everywhere)) if one.axes[0] else 1.0
    return Panel(title, one.axes[0], one.axes[1], tuple(drawn), aside)


def _starts(found: Fitted) -> dict[int, int]:
    """Index at which the values of each observation begin, by its identity."""
    starts, start = {}, 0
    for _, one in found.fit.observations:
        starts[id(one)] = start
        start += len(one.values)
    return starts
