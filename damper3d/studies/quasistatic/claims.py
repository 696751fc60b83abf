"""Quantities of slow tests by which the thesis's claims on Figs 8.16 to 8.19 are judged.

Of compression by the secant stiffness; of shear, whose curves zig-zag as single particles slip, by
the rise of the force in its mean over the distance, as a secant catches the slip where it ends.
Two shapes differ where their means do beyond the 95 % interval of the difference, from the scatter
of one packing pooled over all shapes. Where they do not, a claim that one is stiffer is not judged:
more packings would show it.
"""

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from damper3d.studies.quasistatic.shapes import Scatter, Shape, family, scatter_of
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.claims.judge import Check, Quantities, Verdict

MEASURE = {"compress": "stiffness_n_per_m", "shear": "force_mean_n"}  # that is judged
_ALIKE_TO = 0.2  # the largest hole ratio at which toroids are alike, as the thesis says
_SIGNIFICANT = 0.05
# Shapes count as alike only where a difference of half would be seen: by so much shape moves the
# onset, which these tests are to explain.
_TELLING = 0.5
_OF = {"prolate": "spheroids", "toroid": "toroids"}
_SPHERE = {"prolate": 1.0, "toroid": 0.0}

SLOW = Quantities()


class Readings(NamedTuple):
    """The tests by shape, the column that is judged, and its scatter (None: not known)."""

    shapes: dict[str, Shape]
    column: str
    scatter: Scatter | None

    def over(self, shape: Shape, other: Shape, comparisons: int = 1) -> tuple[float, float]:
        """The measure of a shape over that of another, and its noise (NaN: not known).

        comparisons: of so many the noise is to cover all.
        """
        first, second = shape.sample(self.column), other.sample(self.column)
        assert first.mean is not None
        assert second.mean is not None
        noise = math.nan
        if self.scatter:
            noise = self.scatter.half_width(first, second, comparisons=comparisons)
        return first.mean / second.mean, noise / abs(second.mean)


def verdicts(test: str, shapes: dict[str, Shape]) -> list[Verdict]:
    """On the claims about "compress" or "shear"."""
    readings = Readings(shapes, MEASURE[test], scatter_of(shapes, test, MEASURE[test]))
    return SLOW.judge(claims_of(f"damper_{test}"), readings)


@SLOW.quantity
def over_sphere(readings: Readings, kind: str) -> list[dict[str, Any]]:
    """The measure of each shape of a family, "prolate" or "toroid", over its sphere's.

    The noise covers all of them together: a claim on each fails where one is beyond it.
    """
    own = family(readings.shapes, kind)
    sphere = own.pop(_SPHERE[kind], None)
    return [
        {"ratio": ratio} | _item(*readings.over(shape, sphere, len(own)))
        for ratio, shape in own.items()
        if sphere
    ]


@SLOW.quantity
def wide_over_narrow(readings: Readings) -> list[dict[str, Any]]:
    """The measure of toroids of holes above 0.20 over the mean of those up to it."""
    toroids = family(readings.shapes, "toroid")
    wide = [row for ratio, s in toroids.items() if ratio > _ALIKE_TO for row in s.rows]
    narrow = [row for ratio, s in toroids.items() if 0 < ratio <= _ALIKE_TO for row in s.rows]
    return [_item(*readings.over(Shape("", wide), Shape("", narrow)))] if wide and narrow else []


def _item(value: float, noise: float) -> dict[str, Any]:
    if math.isnan(noise):
        return {"value": value, "noise": noise, "remark": "; too few packings to judge"}
    hidden = ": within the scatter" if abs(value - 1) <= noise else ""
    return {"value": value, "noise": noise, "remark": f" (+- {noise:.2f}){hidden}"}


@SLOW.function
def falls_after_its_maximum(readings: Readings) -> Sequence[Check]:
    """That the stiffest of each family is neither its sphere nor its last shape, but above both.

    It fails where one of these two is above all others. Beyond the scatter, at a level for as many
    comparisons as there are shapes, each of which could be the stiffest.
    """
    checks = []
    for kind, of in _OF.items():
        own = family(readings.shapes, kind)
        means = {ratio: shape.sample(readings.column).mean or 0.0 for ratio, shape in own.items()}
        if len(own) < 3:
            checks.append(Check(None, "", of))
            continue
        top, ends = max(means, key=lambda ratio: means[ratio]), (min(means), max(means))
        at_end = top in ends
        others = [r for r in own if r not in ends] if at_end else ends
        over = {r: readings.over(own[top], own[r], len(own)) for r in others}
        seen = all(value - 1 > noise for value, noise in over.values())
        found = ", ".join(
            f"{value:.2f} of that at {ratio:g}{_item(value, noise)['remark']}"
            for ratio, (value, noise) in over.items()
        )
        checks.append(Check(not at_end if seen else None, f"largest at {top:g}: {found}", of))
    return checks


@SLOW.function
def alike(readings: Readings, kind: str) -> Sequence[Check]:
    """That shapes other than the sphere differ no more than packings: analysis of variance.

    Toroids up to a hole ratio of 0.20.
    """
    from scipy.stats import f as fisher

    own, scatter = family(readings.shapes, kind), readings.scatter
    most = _ALIKE_TO if kind == "toroid" else math.inf
    samples = [s.sample(readings.column) for r, s in own.items() if _SPHERE[kind] != r <= most]
    means = [sample.mean or 0.0 for sample in samples]
    if len(samples) < 2 or scatter is None:
        return [Check(None, "too few packings to judge" if samples else "")]
    total = sum(s.n for s in samples)
    middle = sum(s.n * m for s, m in zip(samples, means, strict=True)) / total
    one = scatter.sd * (abs(middle) if scatter.relative else 1.0)
    between = sum(s.n * (m - middle) ** 2 for s, m in zip(samples, means, strict=True))
    freedom = len(samples) - 1
    p = float(fisher.sf(between / freedom / one**2, freedom, scatter.freedom))
    found = f"means {min(means) / middle:.2f} to {max(means) / middle:.2f} of their mean"
    widest = max(itertools.starmap(scatter.half_width, itertools.combinations(samples, 2)))
    if widest > _TELLING * abs(middle) and p >= _SIGNIFICANT:
        return [Check(None, f"{found}: within the scatter, which would hide a half")]
    return [Check(p >= _SIGNIFICANT, f"{found}; packings alone spread so with p = {p:.2g}")]


@SLOW.function
def not_stiffer_at_the_end(readings: Readings) -> Sequence[Check]:
    """That the toroid of the largest hole is no stiffer than the sphere, beyond the scatter."""
    toroids: Mapping[float, Shape] = family(readings.shapes, "toroid")
    if 0.0 not in toroids or max(toroids) <= _ALIKE_TO:
        return [Check(None, "")]
    sphere = toroids[0.0]
    value, noise = readings.over(toroids[max(toroids)], sphere)
    found = f"{value:.2f} of the sphere's{_item(value, noise)['remark']}"
    if abs(value - 1) > noise:
        return [Check(value < 1, found)]
    return [Check(True if noise <= _TELLING else None, found)]
