"""A pendulum test in words and as the object that --json prints."""

from typing import Any

import numpy as np

from calibration.pendulum.result import Pendulum
from calibration.statistics.uncertainty import as_pair
from calibration.tracking.track import Array


def as_json(found: Pendulum) -> dict[str, Any]:
    """The object that `calibrate pendulum --json` prints; None where a value does not exist."""
    hit, damping, things = found.collisions, found.damped.damping, found.things
    assert damping.sigma is not None
    length, heights = found.length_m(), found.heights()
    before, after = found.amplitudes()
    seen = found.from_amplitudes()
    return {
        "restitution": {
            "value": found.pooled.value,
            "sigma": found.pooled.sigma,
            "per_collision": hit.restitution.tolist(),
            "per_collision_sigma": np.sqrt(np.diag(hit.covariance)).tolist(),
            "from_heights": hit.from_heights[:, 0].tolist(),
            "from_heights_sigma": hit.from_heights[:, 1].tolist(),
            "from_amplitudes": None if seen is None else seen.tolist(),
            "constant_within_noise": found.constant_within_noise,
            "p": found.p,
        },
        "contact_frames": [found.frame(time) for time in found.times[:, 0]],
        "contact_frames_sigma": found.times[:, 1].tolist(),
        "contact_times_s": _seconds(found),
        "amplitudes": _each(after),
        "amplitudes_before": _each(before),
        "heights": None if heights is None else _each(heights[1]),
        "heights_before": None if heights is None else _each(heights[0]),
        "unit": things.unit,
        "planar": found.planar,
        "coordinate": "angle" if found.fitted.seen.angles else "x",
        "string_length": _best([one.length for one in found.arcs if one.known]),
        "string_length_m": None if length is None else length.value,
        "period_frames": 2 * np.pi / found.fitted.law.omega,
        "damping": {
            "per_frame": damping.value,
            "sigma": damping.sigma,
            "loss_between_contacts": _loss(found),
            "taken_off": found.fitted is found.damped,
        },
        "mass_ratio": None if hit.mass_ratio is None else hit.mass_ratio[0],
        "mass_ratio_sigma": None if hit.mass_ratio is None else hit.mass_ratio[1],
        "things": "ball and wall" if len(found.arcs) == 1 else "two blocks",
        "tracks": [one.name for one in things.tracks],
        "fps_header": things.rate_header,
        "fps_used": things.rate,
        "time_base": {
            "duplicated_frames": list(things.repeated),
            "remark": "; ".join(things.time_remarks) or "even",
        },
        "warnings": list(found.warnings),
        "sheet": None if found.sheet is None else str(found.sheet),
    }


def as_text(found: Pendulum) -> str:
    """The same for a person."""
    one = {
        True: f"one number describes the clip (p = {found.p or 0:.2g})",
        False: f"one number does not describe the clip (p = {found.p or 0:.2g})",
        None: "one value: nothing to compare it with",
    }[found.constant_within_noise]
    what = "a ball against a wall" if len(found.arcs) == 1 else "two blocks"
    rate = found.things.rate
    lines = [
        f"restitution {found.pooled.value:.4f} +- {found.pooled.sigma:.2g}, {what}; {one}",
        *_contacts(found),
        f"plane   {_plane(found)}",
        f"string  {_string(found)}",
        f"air     {_air(found)}",
        f"rate    {'not known' if rate is None else f'{rate:.5g} frames/s'}",
    ]
    if found.collisions.mass_ratio is not None:
        value, sigma = found.collisions.mass_ratio
        lines.append(f"masses  right over left {value:.4g} +- {sigma:.1g}, by momentum")
    lines += [f"time base: {remark}" for remark in found.things.time_remarks]
    lines += [f"warning: {warning}" for warning in found.warnings]
    if found.sheet is not None:
        lines.append(f"sheet {found.sheet}")
    return "\n".join(lines)


def _contacts(found: Pendulum) -> list[str]:
    hit, (before, after) = found.collisions, found.amplitudes()
    unit = found.things.unit
    lines = [
        f"{'frame':>16} {'restitution':>18} {'from heights':>18} "
        f"{f'amplitudes [{unit}], before -> after':>36}"
    ]
    own = np.sqrt(np.diag(hit.covariance))
    for k, (time, sigma) in enumerate(found.times):
        turns = [" and ".join(f"{a:.4g}" for a in one[:, k]) for one in (before, after)]
        lines.append(
            f"{f'{found.frame(time):.2f} +- {sigma:.1g}':>16} "
            f"{f'{hit.restitution[k]:.4f} +- {own[k]:.1g}':>18} "
            f"{'{:.4f} +- {:.1g}'.format(*hit.from_heights[k]):>18} {' -> '.join(turns):>36}"
        )
    return lines


def _plane(found: Pendulum) -> str:
    return {
        True: "the paths are arcs: heights are known, angles are used",
        False: "not planar: x is used",
        None: "the paths look straight: x is used, swings are taken to be isochronous",
    }[found.planar]


def _string(found: Pendulum) -> str:
    unit, length = found.things.unit, found.length_m()
    known = [
        f"{one.length.value:.4g} +- {one.length.sigma:.2g} {unit}"
        for one in found.arcs
        if one.known
    ]
    metres = [] if length is None else [f"{length.value:.4g} m by its period"]
    period = 2 * np.pi / found.fitted.law.omega
    return "; ".join([*known, *metres, f"period {period:.5g} frames"])


def _air(found: Pendulum) -> str:
    used = "taken off" if found.fitted is found.damped else "not taken off"
    return f"{100 * _loss(found):.2g} % of the speed from contact to contact, {used}"


def _loss(found: Pendulum) -> float:
    """Share of the amplitude that a swing loses to the air between contacts."""
    times = found.times[:, 0]
    swing = float(np.median(np.diff(times))) if len(times) > 1 else np.pi / found.fitted.law.omega
    return float(-np.expm1(-found.damped.damping.value * swing))


def _each(values: Array) -> list[Any]:
    """Of each contact: a number for a ball, [left, right] for two blocks."""
    return list(values[0].tolist() if len(values) == 1 else values.T.tolist())


def _best(known: list[Any]) -> dict[str, float | None] | None:
    return as_pair(min(known, key=lambda one: one.sigma, default=None))


def _seconds(found: Pendulum) -> list[float] | None:
    things = found.things
    if things.rate is None:
        return None
    stamps = things.tracks[0].time
    start = things.t[0] / things.rate
    if stamps is not None and things.rate == things.rate_header:
        start = float(stamps[0])
    return [start + (time - things.t[0]) / things.rate for time in found.times[:, 0]]
