"""The ridges of an efficiency map: which peak along Gamma belongs to which, at each frequency."""

import math
from dataclasses import dataclass

from damper3d.studies.map.grid import MapResult
from damper3d.studies.map.peaks import Peak
from damper3d.studies.predict.prediction import Prediction

FLUIDISATION = 3.0  # Gamma about which the thesis finds that ridge (sec. 6.4.3.2)
_REACH = math.log(2.0)  # how far in ln Gamma a peak may be from where its ridge is looked for

RIDGES = ("bouncing_bed", "fluidisation", "other")


@dataclass(frozen=True)
class OnRidge:
    """A peak of a frequency, and the ridge that it was counted to."""

    ridge: str
    frequency: float  # [Hz]
    peak: Peak


def ridges(result: MapResult, prediction: Prediction) -> list[OnRidge]:
    """Each frequency's peaks, by rising frequency and Gamma.

    A peak is counted to the nearer, in ln Gamma, of the predicted onset of the bouncing bed and
    Gamma 3, if it lies within a factor of two of it; a ridge has the highest of several, and the
    rest are "other".
    """
    found = []
    for frequency in sorted(set(result.frequency.tolist())):
        predicted = {"fluidisation": FLUIDISATION}
        onset = prediction.best.onset(frequency)
        if onset is not None:
            predicted["bouncing_bed"] = onset
        peaks = result.peaks(frequency)
        nearest = [_nearest(peak, predicted) for peak in peaks]
        for k, (peak, ridge) in enumerate(zip(peaks, nearest, strict=True)):
            rivals = [p.efficiency for p, r in zip(peaks, nearest, strict=True) if r == ridge]
            highest = peak.efficiency == max(rivals)
            found.append(OnRidge(ridge if highest else "other", frequency, peaks[k]))
    return found


def _nearest(peak: Peak, predicted: dict[str, float]) -> str:
    """The ridge whose position is nearest to a peak, or "other" beyond its range."""
    away = {ridge: abs(math.log(peak.gamma / position)) for ridge, position in predicted.items()}
    ridge = min(away, key=lambda name: away[name])
    return ridge if away[ridge] <= _REACH else "other"
