"""Warnings about the restitution of a pendulum, before it is believed."""

import numpy as np

from calibration.pendulum.arc import HEIGHTS_OFF
from calibration.pendulum.result import Pendulum
from calibration.statistics.correlated import pool
from calibration.tracking.segments import noise

_SURE = 3  # sigma
_GROWS = 0.02  # share by which the apparent size may change: more, and the scale does, too
_MISFIT = 3  # times the noise of positions


def warnings_of(found: Pendulum) -> list[str]:
    """One line each."""
    return [
        *found.objects.remarks,
        *_plane(found),
        *_size(found),
        *_air(found),
        *_position(found),
        *_misfit(found),
        *_mass(found),
        *_one_number(found),
    ]


def _plane(found: Pendulum) -> list[str]:
    unit, lines = found.objects.unit, []
    for arc in found.arcs:
        assert arc.apart.sigma is not None
        if arc.planar is False:
            lines.append(
                f"the swing is not planar: the path is off a circle by {arc.deviation:.2g} {unit} "
                f"where it rises {arc.rise:.3g} {unit}; heights are not used, x alone is"
            )
        known = abs(arc.apart.value) > _SURE * arc.apart.sigma
        if known and abs(arc.apart.value) / 2 > HEIGHTS_OFF * arc.rise:
            lines.append(
                f"the path back is {abs(arc.apart.value):.2g} {unit} from the path out, at the "
                "lowest point of the widest swing"
            )
    return lines


def _size(found: Pendulum) -> list[str]:
    """True if the objects look larger or smaller at one end: they come nearer, or go away."""
    if found.objects.radius is None:
        return []
    lines = []
    for x, radius in zip(found.objects.x, found.objects.radius, strict=True):
        rows = np.concatenate(found.swings.rows)
        rows = rows[np.isfinite(radius[rows])]
        if len(rows) < 12 or np.ptp(x[rows]) == 0:
            continue
        thirds = np.array_split(rows[np.argsort(x[rows])], 3)
        ends = np.array([np.median(radius[one]) for one in (thirds[0], thirds[2])])
        change = float(np.ptp(ends) / ends.mean())
        scatter = noise(found.objects.t[rows], radius[rows]) * np.sqrt(
            np.pi / len(thirds[0])
        )  # of medians
        if change > _GROWS and np.ptp(ends) > _SURE * scatter:
            lines.append(
                f"the apparent size changes by {100 * change:.2g} % from end to end: blur, or the "
                "swing is not in the plane of the picture"
            )
    return lines


def _air(found: Pendulum) -> list[str]:
    beta = found.damped.damping
    assert beta.sigma is not None
    known = abs(beta.value) > _SURE * beta.sigma
    if found.fitted is not found.damped:
        if not known:
            return []
        return [
            "what the air takes between contacts cannot be separated from the swing's leaving its "
            f"plane: not taken off; with all of it taken off restitution would be "
            f"{found.pooled.value + found.left_in:.3f}, a rectangular share of that is in sigma"
        ]
    if known and beta.value < 0:
        return [
            "the swings gain speed between contacts: something drives them, or the clock is off"
        ]
    return []


def _position(found: Pendulum) -> list[str]:
    """True if contacts are where the swing is fastest, which eq. 3.6 needs."""
    whole = found.collisions.from_heights
    seen = found.from_amplitudes()
    mean = pool(whole[:, 0], np.diag(whole[:, 1] ** 2))[0].value
    assert found.pooled.sigma is not None
    lines = []
    if abs(mean - found.pooled.value) > _SURE * found.pooled.sigma:
        ratio = "" if seen is None else f", amplitudes seen from the wall {np.mean(seen):.3f}"
        lines.append(
            f"heights of whole swings (eq. 3.6) give {mean:.3f}{ratio}: contacts are off the "
            "lowest point, or air slows the swings; the speeds at the contacts are used"
        )
    gaps = found.collisions.gaps
    if len(gaps) > 1:
        drift = gaps[-1, 0] - gaps[0, 0]
        if abs(drift) > _SURE * np.hypot(gaps[0, 1], gaps[-1, 1]):
            lines.append(
                f"the position of contact moves by {drift:.3g} {found.objects.unit} from the first "
                "contact to the last"
            )
    return lines


def _misfit(found: Pendulum) -> list[str]:
    fitted = found.fitted
    own = max(noise(found.objects.t, z) for z in fitted.seen.z)
    used = np.isfinite(fitted.weights)
    out, lines = int(np.sum(fitted.weights[used] == 0)), []
    if fitted.sigma > _MISFIT * own:
        lines.append(
            f"the swings are no pendulum's to within the noise: residuals of {fitted.sigma:.2g} "
            f"{found.objects.unit}, noise {own:.2g}; the object rotates on its string, leaves "
            "its plane, or its tracking depends on where it is"
        )
    if out:
        lines.append(f"{out} of {int(used.sum())} positions fit no swing: left out")
    return lines


def _mass(found: Pendulum) -> list[str]:
    """Momentum, for two objects: equal ones where no masses are given."""
    if found.collisions.mass_ratio is None:
        return []
    first, second = found.masses or (1.0, 1.0)
    value, sigma = found.collisions.mass_ratio
    if abs(value - second / first) < max(_SURE * sigma, 0.05 * second / first):
        return []
    given = "the masses given" if found.masses else "equal masses"
    return [
        f"momentum requires a mass ratio of {value:.3g} (sigma {sigma:.2g}), right to left, not "
        f"{second / first:.3g} of {given}: a block that rotates, an oblique contact, or perspective"
    ]


def _one_number(found: Pendulum) -> list[str]:
    if found.constant_within_noise is not False:
        return []
    return [f"one number does not describe the clip (p = {found.p:.2g}): see per_collision"]
