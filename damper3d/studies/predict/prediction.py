"""Predictions of a case by case.closed_forms, in numbers and in words."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from damper3d.case import closed_forms
from damper3d.case.case import DamperCase
from damper3d.case.level import level_of
from damper3d.case.random_packing import Fraction, close_packing, loose_packing
from granulab.errors import InputError

FREQUENCIES = (20.0, 40.0, 80.0)  # [Hz] of Table 6.3
_HEIGHTS = ("40 mm", "45 mm", "50 mm", "55 mm")  # of the thesis's four fills (Table 6.1)
_ALONG = 1e-6  # how far a unit vector may be off an axis
_LOOKED_AT = 0.25, 0.5  # parts of the volume, which take as much of the length where it is even
_EVEN = 1e-4  # of the length, to which they do: the walls that are drawn are polygons
_STEP = 1e-3  # of the volume, for a derivative

Free = Callable[[float], float]  # clearance [m] over a bed that takes a part of the volume


@dataclass(frozen=True)
class Clearance:
    """The free length that a bed has when packed to a fill ratio; `length` None: it has none."""

    name: str  # "loose", "close", "own" or "counted"
    packing: float | None  # None for "counted", which knows numbers of particles only
    length: float | None  # [m]
    uncertainty: float | None = None  # of the length, one standard deviation [m]
    source: str = ""  # of the packing, in words; "" of what was given by hand

    def onset(self, frequency: float) -> float | None:
        """Gamma at which the bouncing bed sets in (eq. 6.11)."""
        if self.length is None:
            return None
        return float(closed_forms.bouncing_bed_onset(frequency, self.length))

    def onset_uncertainty(self, frequency: float) -> float | None:
        """One standard deviation of that Gamma, which goes with the clearance; None: not known."""
        if self.length is None or self.uncertainty is None:
            return None
        return float(closed_forms.bouncing_bed_onset(frequency, self.uncertainty))


@dataclass(frozen=True)
class Prediction:
    """Onsets and optima of a case."""

    name: str
    fill_ratio: float
    length: float  # between the walls that the motion meets [m]
    orientation: str  # of the motion against gravity: vertical, horizontal, none or oblique
    clearances: tuple[Clearance, ...]
    threshold: float | None  # Gamma above which a rigid bed moves; None where oblique
    narrows: bool = False  # the enclosure is not as wide all along the motion

    @property
    def best(self) -> Clearance:
        """The one to go by: what the user gave, else the close packing (thesis sec. 6.4.1)."""
        known = {clearance.name: clearance for clearance in self.clearances}
        return next(known[name] for name in ("own", "counted", "close") if name in known)

    @property
    def fluidisation(self) -> tuple[float, float] | None:
        """Gamma and efficiency of the best inelastic block; of vertical motion only."""
        return closed_forms.fluidisation_optimum() if self.orientation == "vertical" else None


def predict(
    case: DamperCase,
    packing: float | None = None,
    full_count: int | None = None,
    close: Fraction | None = None,
    needed: bool = True,
) -> Prediction:
    """Predict a case for its shape's packings, and for one's own fill ratio or full number.

    close: the shape's close packing, where it was computed; else that of the shipped table, and
    None of a shape that is not in it. Raises InputError where the motion does not meet two parallel
    walls, or where the bed of one's own packing has no clearance; of a prediction that is not
    needed clearances are not known then.
    """
    fill, shape = case.fill_ratio, case.particle.name
    orientation = _orientation(case)
    known = {"loose": loose_packing(shape), "close": close or close_packing(shape)}
    try:
        length, free, narrows = _free(case, orientation)
    except InputError:
        if needed:
            raise
        length, free, narrows, known = math.nan, None, False, dict.fromkeys(known)
    clearances = [_packed(name, most, fill, free) for name, most in known.items()]
    if free and packing is not None:
        closed_forms.effective_clearance(fill, length, packing)  # refused where there is none
        clearances.append(Clearance("own", packing, free(fill / packing)))
    if free and full_count is not None:
        closed_forms.relative_clearance(case.count, full_count, length)
        clearances.append(Clearance("counted", None, free(case.count / full_count)))
    threshold = None
    if orientation != "oblique":
        threshold = closed_forms.fluidisation_threshold(orientation, case.wall_law.mu)
    return Prediction(case.name, fill, length, orientation, tuple(clearances), threshold, narrows)


def check_known(prediction: Prediction) -> None:
    """Raise InputError where no packing of the shape is known, so that no onset is."""
    if prediction.best.packing is None and prediction.best.name == "close":
        raise InputError(
            f"{prediction.name}: no packing of its particles' shape is shipped; give --packing, "
            "such as 0.65, or --pack to compute it"
        )


def _packed(name: str, most: Fraction | None, fill: float, free: Free | None) -> Clearance:
    """The clearance of eq. 6.13 with its uncertainty; none where no packing is known."""
    if most is None or free is None:
        return Clearance(name, None, None)
    packed = fill / most.value  # of the volume
    length = free(packed) if packed < 1 else None
    source = f"{most.value:.3g}, {most.source}"
    if most.uncertainty is None:
        return Clearance(name, most.value, length, None, source)
    part = packed * most.uncertainty / most.value
    near = min(packed, 1 - _STEP)
    off = part * (free(near - _STEP) - free(near + _STEP)) / (2 * _STEP)
    source = f"{most.value:.3g} +- {most.uncertainty:.1g}, {most.source}"
    if length:
        source += f"; onset +- {100 * off / length:.2g} %"
    return Clearance(name, most.value, length, off, source)


def frequencies_for(case: DamperCase) -> tuple[float, ...]:
    """FREQUENCIES, and that of the case where it gives one or follows from its host [Hz]."""
    motion = case.settings.motion
    given = "frequency" in motion.model_fields_set or case.modes is not None
    if not given or case.excitation is not None:
        return FREQUENCIES
    return tuple(sorted({*FREQUENCIES, motion.frequency}))


def fills(name: str | None, changes: dict[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    """Cases to load: the one given, or the thesis's four heights with equally many particles.

    A height or a count among the changes is one fill of one's own.
    """
    if name is not None or {"enclosure.height", "particles.count"} & set(changes):
        return [(name or "thesis", changes)]
    count = DamperCase.load("thesis", changes).count
    own = {"particles.count": count}
    return [("thesis", {**changes, **own, "enclosure.height": height}) for height in _HEIGHTS]


def onsets(prediction: Prediction, frequencies: Sequence[float]) -> list[dict[str, Any]]:
    """A row for each clearance: packing, clearance, A0 = h/pi, and Gamma at each frequency."""
    return [
        {
            "packing": clearance.name,
            "max_fill_ratio": clearance.packing,
            "clearance_m": clearance.length,
            "amplitude_m": clearance.length and clearance.length / np.pi,
            "gamma": [clearance.onset(frequency) for frequency in frequencies],
            "gamma_uncertainty": [clearance.onset_uncertainty(f) for f in frequencies],
            "packing_source": clearance.source or None,
        }
        for clearance in prediction.clearances
    ]


def inverted(prediction: Prediction, frequency: float, gamma: float) -> dict[str, Any]:
    """The clearance whose optimum is at a frequency [Hz] and Gamma, and what gives it.

    height_m holds the same particles, fill_ratio is that of fewer in the same height; None where
    the enclosure is not that high, or not as wide all along the motion, or no packing is known.
    """
    wanted = float(closed_forms.clearance_for(frequency, gamma))
    packing, length = prediction.best.packing, prediction.length
    known = packing is not None and not prediction.narrows
    fits = known and wanted < length
    depth = prediction.fill_ratio / packing * length if packing and known else None
    return {
        "frequency_hz": frequency,
        "gamma": gamma,
        "clearance_m": wanted,
        "height_m": None if depth is None else depth + wanted,
        "fill_ratio": packing * (1 - wanted / length) if packing is not None and fits else None,
    }


def inverted_words(found: dict[str, Any]) -> str:
    """The same in a line."""
    height, fill = found["height_m"], found["fill_ratio"]
    same = "" if height is None else f"; these particles need a height of {1e3 * height:.4g} mm"
    fewer = "" if fill is None else f", or a fill ratio of {fill:.3f} in this one"
    return (
        f"  for {found['frequency_hz']:g} Hz and Gamma {found['gamma']:g} a clearance of "
        f"{1e3 * found['clearance_m']:.4g} mm{same}{fewer}"
    )


def as_dict(prediction: Prediction, frequencies: Sequence[float]) -> dict[str, Any]:
    """A prediction for --json; what does not exist is None."""
    gamma, efficiency = prediction.fluidisation or (None, None)
    vertical = prediction.orientation == "vertical"
    return {
        "case": prediction.name,
        "fill_ratio": prediction.fill_ratio,
        "length_m": prediction.length,
        "orientation": prediction.orientation,
        "bouncing_bed": onsets(prediction, frequencies),
        "fluidisation": {
            "threshold_gamma": prediction.threshold,
            "optimum_gamma": gamma,
            "optimum_efficiency": efficiency,
            "whole_flight_gamma": closed_forms.WHOLE_FLIGHT if vertical else None,
            "period_doubling_gamma": closed_forms.PERIOD_DOUBLING if vertical else None,
        },
    }


def as_text(prediction: Prediction, frequencies: Sequence[float]) -> str:
    """A prediction in words: a line for each packing."""
    head = ["packing", "clearance", "A0", *(f"{f:g} Hz" for f in frequencies)]
    lines = [
        f"{prediction.name}: fill ratio {prediction.fill_ratio:.3f}, "
        f"{1e3 * prediction.length:g} mm between the ends, {prediction.orientation}",
        f"  {head[0]:14}" + "".join(f"{word:>10}" for word in head[1:]),
    ]
    for row in onsets(prediction, frequencies):
        packed = "" if row["max_fill_ratio"] is None else f" {row['max_fill_ratio']:.3g}"
        lengths = [_millimetres(row["clearance_m"]), _millimetres(row["amplitude_m"])]
        gammas = ["-" if gamma is None else f"{gamma:.3g}" for gamma in row["gamma"]]
        cells = "".join(f"{cell:>10}" for cell in [*lengths, *gammas])
        lines.append(f"  {row['packing'] + packed:14}{cells}")
    sources = [f"  {c.name} packing {c.source}" for c in prediction.clearances if c.source]
    return "\n".join([*lines, *sources, *_on_fluidisation(prediction)])


def _on_fluidisation(prediction: Prediction) -> list[str]:
    if prediction.threshold is None:
        return ["  fluidisation: no closed form for motion oblique to gravity"]
    why = {"vertical": "lift-off", "horizontal": "friction at the wall", "none": "nothing holds it"}
    lines = [
        f"  the bed moves in its enclosure above Gamma {prediction.threshold:g} "
        f"({why[prediction.orientation]})"
    ]
    if prediction.fluidisation:
        gamma, efficiency = prediction.fluidisation
        lines.append(
            f"  a block that does not rebound damps best at Gamma {gamma:.2f} (eta "
            f"{efficiency:.2f}), and cycles are unlike from {closed_forms.PERIOD_DOUBLING:.2f} on"
        )
    return lines


def _millimetres(length: float | None) -> str:
    return "-" if length is None else f"{1e3 * length:.2f} mm"


def _free(case: DamperCase, orientation: str) -> tuple[float, Free, bool]:
    """Distance [m] of the walls that the motion meets, and the free part of it over a packed bed.

    Also whether the enclosure is not as wide all along it. The bed takes a part of the volume,
    which is that of the length where the width is even (eq. 6.13). Elsewhere the bed lies at the
    lower end: InputError for motion that is not vertical, whose bed may lie at either.
    """
    length, enclosure = _between_walls(case), case.enclosure
    up = case.direction if orientation != "vertical" else -case.gravity
    up = up / float(np.linalg.norm(up))
    floor = enclosure.lowest(up)

    def over(part: float) -> float:
        return length - (level_of(enclosure, up, part * enclosure.volume) - floor)

    def even(part: float) -> float:
        return (1 - part) * length

    if all(abs(over(part) - even(part)) < _EVEN * length for part in _LOOKED_AT):
        return length, even, False
    if orientation != "vertical":
        raise InputError(
            "the enclosure is not as wide all along the motion: predictions are for vertical "
            "motion then, where the bed lies at the lower end"
        )
    return length, over, True


def _between_walls(case: DamperCase) -> float:
    """Distance [m] of the two parallel walls that the motion meets head on."""
    planes = case.enclosure.planes
    along = planes[:, :3] @ case.direction
    first, last = (planes[np.abs(along - sign) < _ALONG] for sign in (1.0, -1.0))
    if len(first) and len(last):
        return -float(first[0, 3] + last[0, 3])
    raise InputError(
        f"motion.direction = {[round(float(c), 4) for c in case.direction]}: predictions are for "
        "motion between two parallel walls; give [0, 0, 1], or one along a side of a box"
    )


def _orientation(case: DamperCase) -> str:
    """Direction of the motion to gravity, in words."""
    size = float(np.linalg.norm(case.gravity))
    if size == 0:
        return "none"
    along = abs(float(case.gravity @ case.direction)) / size
    if along < _ALONG:
        return "horizontal"
    return "vertical" if abs(along - 1) < _ALONG else "oblique"
