"""By what rules the sentences about shares are judged: all above, all falling, about a value."""

import math
from collections.abc import Sequence

from damper3d.reproduce.statements import Check

_ABOUT = 0.1  # "about 80 %": the mean over the bouncing bed is between 70 and 90 %

Named = Sequence[tuple[str, float]]  # of which point or curve, and the share or slope there


def above(of: str, shares: Named, limit: float) -> Check:
    """Whether all shares are above a limit.

    Told are the least and the mean, and how many are not.
    """
    if not shares:
        return Check(None, "no run there", of)
    low = [share for _, share in shares if share <= limit]
    where, least = min(shares, key=lambda named: named[1])
    found = (
        f"least {_percent(least)} ({where}), mean {_percent(_mean(shares))} of {len(shares)} points"
    )
    if low:
        found += f"; {len(low)} not above {_percent(limit)}"
    return Check(not low, found, of)


def falls(of: str, slopes: Named, unit: str) -> Check:
    """Whether all slopes are below zero; told in points of per cent."""
    if not slopes:
        return Check(None, "too few points, or no peak to part them at", of)
    rising = [name for name, slope in slopes if slope >= 0]
    mean = 100 * _mean(slopes)
    found = f"{len(slopes) - len(rising)} of {len(slopes)} fall, mean {mean:+.1f} points {unit}"
    if rising:
        rest = ", ..." if len(rising) > 3 else ""
        found += f"; not {'; '.join(rising[:3])}{rest}"
    return Check(not rising, found, of)


def about(of: str, shares: Named, target: float) -> Check:
    """Whether the mean of the shares is within a tenth of a target."""
    if not shares:
        return Check(None, "no run there, or no onset found", of)
    values, mean = [share for _, share in shares], _mean(shares)
    found = f"{100 * min(values):.0f} to {_percent(max(values))}"
    found += f", mean {_percent(mean)} of {len(shares)} points"
    return Check(abs(mean - target) <= _ABOUT, found, of)


def _mean(named: Named) -> float:
    return math.fsum(value for _, value in named) / len(named)


def _percent(part: float) -> str:
    return f"{100 * part:.0f} %"
