"""Candidates for impacts: where a signal holds what noise and ringing do not explain.

The signal is whitened by the prediction filter of its own quiet parts, so that hum and rumble weigh
little; its energy in a short window is set against the noise's. A candidate is a peak of the energy

  - that Gaussian noise would reach once in a thousand such recordings (chi-squared), and
  - over which the energy had first fallen by RISE since the last louder event: the ringing of the
    impact before must have decayed that far below what comes.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.files.signals import Signal

WINDOW = 2e-3  # [s] over which energy is taken: longer than a contact, shorter than a flight
RISE = 10.0  # [dB] from the energy before to the peak: tenfold
_ECHO = 6.0  # [dB] by which an echo that overlaps its impact may be louder
_FALSE_ALARMS = 1e-3  # expected in a recording of nothing but Gaussian noise
_QUIET = 0.1  # the part of all windows that is taken to be free of impacts, the quietest
_BLOCKS = 4  # energies per window
_LEAST_WINDOW = 8  # samples
_LARGEST_ORDER = 16  # of the prediction filter
_BITS = 24  # no converter resolves more: the least noise, relative to the largest sample


@dataclass(frozen=True)
class Search:
    """Candidates for impacts in a signal.

    white      (n, c) channels through their prediction filter, in units of their noise
    level      (b,) energy in a window over the noise's [dB]; window k starts at block k
    block      samples between windows
    threshold  [dB] that noise alone hardly reaches
    peaks      (m,) windows of candidates, ascending
    begins     (m,) the first windows of the candidates' rises
    """

    white: NDArray[np.float64]
    level: NDArray[np.float64]
    block: int
    threshold: float
    peaks: NDArray[np.intp]
    begins: NDArray[np.intp]
    late: bool

    @property
    def window(self) -> int:
        """Samples of a window."""
        return _BLOCKS * self.block


def search(signal: Signal, window: float = WINDOW) -> Search:
    """The energy of a signal over its noise, and the candidates for impacts in it."""
    from scipy.signal import find_peaks
    from scipy.stats import chi2

    block = max(_LEAST_WINDOW, round(window * signal.rate)) // _BLOCKS
    white = np.column_stack([_white(x, _BLOCKS * block) for x in signal.channels.T])
    energy = _energy(white, block)
    freedom = _BLOCKS * block * white.shape[1]
    noise = np.quantile(energy, _QUIET) / chi2.ppf(_QUIET, freedom)
    noise = max(noise, 0.1)  # quiet parts without a single change, as of a made signal
    level = 10.0 * np.log10(np.maximum(energy / (noise * freedom), 1e-3))
    unlikely = chi2.isf(_FALSE_ALARMS / len(energy), freedom) / freedom
    threshold = float(10.0 * np.log10(unlikely))
    padded = np.concatenate([[level.min()], level, [level.min()]])
    peaks, _ = find_peaks(padded, height=threshold, prominence=RISE)
    peaks -= 1
    before = [0, *peaks[:-1]]
    begins = np.array(
        [_begin(level, *pair, threshold) for pair in zip(before, peaks, strict=False)],
        dtype=np.intp,
    )
    risen = begins > 0
    late = not bool(risen.all())
    return Search(white, level, block, threshold, peaks[risen], begins[risen], late)


def _begin(level: NDArray[np.float64], previous: int, peak: int, threshold: float) -> int:
    """The first window of the rise to a peak, after the peak before it.

    The peak may be an echo that follows its impact too soon to be separated from it, and is louder.
    """
    rise = level[previous:peak]
    for foot in (max(level[peak] - RISE - _ECHO, threshold), level[peak] - RISE):
        below = np.flatnonzero(rise < foot)
        if foot <= level[peak] - RISE and len(below):
            return previous + int(below[-1]) + 1
    return previous


def _energy(white: NDArray[np.float64], block: int) -> NDArray[np.float64]:
    """Sum of squares over all channels in overlapping windows that start a block apart."""
    whole = len(white) // block * block
    blocks = (white[:whole] ** 2).sum(axis=1).reshape(-1, block).sum(axis=1)
    return np.convolve(blocks, np.ones(_BLOCKS), "valid")


def _white(x: NDArray[np.float64], window: int) -> NDArray[np.float64]:
    """A channel through the prediction filter of its quiet parts, in units of their noise."""
    from scipy.linalg import solve_toeplitz
    from scipy.signal import lfilter

    x = x - np.median(x)
    quiet = _quiet_parts(x, window)
    order = min(_LARGEST_ORDER, window // 4)
    lagged = np.array([np.mean(quiet[:, k:] * quiet[:, : window - k]) for k in range(order + 1)])
    steps = np.abs(np.diff(x))
    step = float(steps.min(where=steps > 0, initial=np.inf))  # of the converter
    least = max(step / np.sqrt(12.0), np.abs(x).max() * 2.0**-_BITS) if np.isfinite(step) else 1.0
    lagged[0] += least**2
    predicted = solve_toeplitz(lagged[:-1], lagged[1:])
    filtered = lfilter(np.concatenate([[1.0], -predicted]), [1.0], x)
    filtered[:order] = 0.0  # not yet in step
    return filtered / np.sqrt(max(lagged[0] - predicted @ lagged[1:], least**2))


def _quiet_parts(x: NDArray[np.float64], window: int) -> NDArray[np.float64]:
    """(q, window): the windows that hold and change least, which have no impact in them."""
    parts = x[: len(x) // window * window].reshape(-1, window)
    sizes = np.array([parts.var(axis=1), np.diff(parts, axis=1).var(axis=1)])
    least = np.finfo(float).tiny * max(sizes.max(), 1.0)  # their ratio is a number
    medians = np.maximum(np.median(sizes, axis=1, keepdims=True), least)
    largest = (sizes / medians).max(axis=0)
    return parts[largest <= np.quantile(largest, _QUIET)]
