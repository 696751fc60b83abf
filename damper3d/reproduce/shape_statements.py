"""What the thesis says of shapes and the bouncing bed, judged on our optima (sec. 8.5.1)."""

import itertools
import math
from collections.abc import Callable, Sequence

from damper3d.reproduce.dampers import ORIENTATIONS
from damper3d.reproduce.optima import Optimum
from damper3d.reproduce.shape_optima import Found, Line
from damper3d.reproduce.shape_plan import BOUNCING, sphericities
from damper3d.reproduce.statements import Check, Statement
from granulab.campaign.output.statistics import slope

_RISE = 1.5  # "the increase in Gamma_optimum is over 50 %" (sec. 8.5.1.2)
_ALIKE = 1.5  # largest over least peak efficiency that still counts as insensitive; our choice

Onsets = dict[float, Optimum]  # by ratio, of the optima that there are
Judge = Callable[[Onsets], Check]


def bouncing_statements(found: Found) -> list[Statement]:
    """Each judged at 20 and 40 Hz in both orientations."""
    return [
        _of("spheroids: the onset is least for spheres", "spheroid", _least_at_sphere, found),
        _of("spheroids: it is more than 50 % higher by 1.5", "spheroid", _rises, found),
        _of(
            "spheroids: it is flat from 1.5 to 3.0: all within half of that rise",
            "spheroid", _flat, found,
        ),
        _of(
            "spheroids: it rises to 0.7 likewise: there nearer to 1.5 than to the sphere",
            "spheroid", _rises_to_oblate, found,
        ),
        _of(
            "toroids: it rises to 0.05 as spheroids' does: by more than half of 50 %",
            "toroid", _rises_to_toroid, found,
        ),
        _of(
            "spheroids: closer packing alone (eq. 6.12) explains less than the rise to 1.5",
            "spheroid", _beyond_packing, found,
        ),
        _of("toroids: it falls from 0.05 to 0.33", "toroid", _falls, found),
        _of("toroids: at 0.33 it is nearer to the sphere's than to 0.05's", "toroid", _back, found),
        _of(
            f"the best efficiency is insensitive to shape: largest over least at most {_ALIKE:g}",
            "spheroid", _peaks_alike, found,
        ),
    ]  # fmt: skip


def by_sphericity(found: Found, line: Line) -> list[tuple[float, float]]:
    """(sphericity, onset over the sphere's of its family) of prolates and toroids, falling."""
    pairs = []
    for family in ("spheroid", "toroid"):
        own = onsets(found, family, line)
        reference = own.get(1.0 if family == "spheroid" else 0.0)
        if reference is None:
            continue
        for ratio, one in own.items():
            if family == "toroid" or ratio >= 1:
                pairs.append((sphericities()[family, ratio], one.gamma / reference.gamma))
    return sorted(pairs, reverse=True)


def onsets(found: Found, family: str, like: Line) -> Onsets:
    """The optima of a family that agree with a line in all but the shape, by rising ratio."""
    return {
        line.shape[1]: one
        for line, one in sorted(found.items())
        if one is not None and line.shape[0] == family and line[1:] == like[1:]
    }


def rise(own: Onsets, ratio: float, reference: float) -> float | None:
    """Onset of a ratio over that of another one; None where either is not there."""
    if ratio not in own or reference not in own:
        return None
    return own[ratio].gamma / own[reference].gamma


def _of(words: str, family: str, judge: Judge, found: Found) -> Statement:
    """A statement judged at each frequency and orientation."""
    checks = []
    for frequency, orientation in itertools.product(BOUNCING, ORIENTATIONS):
        own = onsets(found, family, Line((family, 1.0), orientation, frequency))
        check = judge(own)
        checks.append(Check(check.holds, check.found, f"{frequency:g} Hz {orientation}"))
    return Statement(words, checks)


def _least_at_sphere(own: Onsets) -> Check:
    if 1.0 not in own or len(own) < 3:
        return _unknown()
    least = min(own, key=lambda ratio: own[ratio].gamma)
    return Check(least == 1.0, f"least at {least:g}: {_shown(own, least, 1.0)}")


def _rises(own: Onsets) -> Check:
    times = rise(own, 1.5, 1.0)
    if times is None:
        return _unknown()
    return Check(times > _RISE, f"{_percent(times)}: {_shown(own, 1.0, 1.5)}")


def _flat(own: Onsets) -> Check:
    zone = {ratio: one for ratio, one in own.items() if ratio >= 1.5}
    if 1.0 not in own or 1.5 not in own or len(zone) < 3:
        return _unknown()
    whole = zone[1.5].gamma - own[1.0].gamma
    away = max(abs(one.gamma - zone[1.5].gamma) for one in zone.values())
    return Check(away < 0.5 * whole, f"rise {whole:.3g}, then up to {away:.2g} away: "
                 + _shown(own, *zone))  # fmt: skip


def _rises_to_oblate(own: Onsets) -> Check:
    if not {0.7, 1.0, 1.5} <= own.keys():
        return _unknown()
    middle = 0.5 * (own[1.0].gamma + own[1.5].gamma)
    return Check(own[0.7].gamma > middle, _shown(own, 0.7, 1.0, 1.5))


def _rises_to_toroid(own: Onsets) -> Check:
    times = rise(own, 0.05, 0.0)
    if times is None:
        return _unknown()
    return Check(times > 1 + 0.5 * (_RISE - 1), f"{_percent(times)}: {_shown(own, 0.0, 0.05)}")


def _beyond_packing(own: Onsets) -> Check:
    times = rise(own, 1.5, 1.0)
    if times is None:
        return _unknown()
    closer, sphere = own[1.5].predicted("close"), own[1.0].predicted("close")
    if closer is None or sphere is None:
        return _unknown()
    packed = closer / sphere
    return Check(times > packed, f"{_percent(times)}, of packing {_percent(packed)}")


def _falls(own: Onsets) -> Check:
    zone = [ratio for ratio in own if ratio > 0]
    trend = slope(zone, [math.log(own[ratio].gamma) for ratio in zone])
    if trend is None:
        return _unknown()
    noise = " (within noise)" if abs(trend.value) <= trend.half_width else ""
    return Check(trend.value < 0, f"{_percent(math.exp(0.28 * trend.value))} from 0.05 to 0.33"
                 f"{noise}: {_shown(own, *zone)}")  # fmt: skip


def _back(own: Onsets) -> Check:
    if not {0.0, 0.05, 0.33} <= own.keys():
        return _unknown()
    middle = 0.5 * (own[0.0].gamma + own[0.05].gamma)
    return Check(own[0.33].gamma < middle, _shown(own, 0.0, 0.05, 0.33))


def _peaks_alike(own: Onsets) -> Check:
    known = {ratio: one.mean.efficiency for ratio, one in own.items()}
    if len(known) < 3:
        return _unknown()
    low, high = min(known.values()), max(known.values())
    return Check(high <= _ALIKE * low, f"{low:.2f} to {high:.2f}, ratio {high / low:.2f}")


def _shown(own: Onsets, *ratios: float) -> str:
    """Onsets with what grid and noise leave open."""
    words = []
    for ratio in dict.fromkeys(ratios):
        low, high = own[ratio].mean.bracket
        words.append(f"{ratio:g}: {own[ratio].gamma:.3g} [{low:.3g}, {high:.3g}]")
    return ", ".join(words)


def _percent(times: float) -> str:
    return f"{100 * (times - 1):+.0f} %"


def _unknown() -> Check:
    return Check(None, "")


def all_bouncing(found: Found) -> Sequence[Line]:
    """One line of each frequency and orientation, for tables and pictures."""
    return [
        Line(("spheroid", 1.0), orientation, frequency)
        for frequency, orientation in itertools.product(BOUNCING, ORIENTATIONS)
    ]
