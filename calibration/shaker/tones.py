"""Complex amplitudes of tones in a signal, block by block, by least squares: no leakage.

x(t) = c + d t + Re sum_k X_k e^(j 2 pi f_k t). Tones need no whole number of cycles in a block, and
do not leak into one another; thesis, eqs 7.10 and 7.11 are the same sums where they have one, with
the factor 2/N that is not printed (errata). Amplifiers drift: without d t, a slope would leak alike
into all blocks of whole cycles, and no scatter would show it.
"""

import numpy as np
from numpy.typing import NDArray

_MOST_ROUNDS = 5


def amplitudes(
    x: NDArray[np.float64], rate: float, frequencies: NDArray[np.float64], blocks: int
) -> NDArray[np.complex128]:
    """X (blocks, k) of samples (n,) at tones (k,) [Hz]; phases count from the first sample."""
    length = len(x) // blocks
    angle = 2.0 * np.pi * np.outer(np.arange(length) / rate, frequencies)
    line = np.column_stack([np.ones(length), np.linspace(-1.0, 1.0, length)])
    terms = np.hstack([line, np.cos(angle), -np.sin(angle)])
    pieces = x[: blocks * length].reshape(blocks, length)
    solved, *_ = np.linalg.lstsq(terms, pieces.T, rcond=None)
    n = len(frequencies)
    found = (solved[2 : n + 2] + 1j * solved[n + 2 :]).T
    begin = np.arange(blocks) * length / rate
    return found * np.exp(-2j * np.pi * np.outer(begin, frequencies))


def remainder(
    x: NDArray[np.float64],
    rate: float,
    frequencies: NDArray[np.float64],
    found: NDArray[np.complex128],
) -> NDArray[np.float64]:
    """What tones (k,) [Hz] of amplitudes (blocks, k) leave of samples (n,), drift taken off."""
    from scipy.signal import detrend

    blocks = len(found)
    pieces = x[: len(x) // blocks * blocks].reshape(blocks, -1)
    t = np.arange(pieces.size).reshape(pieces.shape) / rate
    left = pieces - sum(
        (found[:, k, None] * np.exp(2j * np.pi * f * t)).real for k, f in enumerate(frequencies)
    )
    return np.asarray(detrend(left, axis=1)).ravel()


def strongest(x: NDArray[np.float64], rate: float) -> float:
    """The frequency [Hz] of the largest line of samples (n,), to about a tenth of a line."""
    spectrum = np.abs(np.fft.rfft((x - x.mean()) * np.hanning(len(x))))
    k = int(np.argmax(spectrum[1:-1])) + 1
    low, middle, high = np.log(np.maximum(spectrum[k - 1 : k + 2], 1e-300))
    return float((k + 0.5 * (low - high) / (low - 2.0 * middle + high)) * rate / len(x))


def tuned(x: NDArray[np.float64], rate: float, frequency: float, blocks: int) -> float:
    """A frequency [Hz] close to one given, at which the phase stands still from block to block."""
    span = len(x) // blocks / rate
    for _ in range(_MOST_ROUNDS):
        found = amplitudes(x, rate, np.array([frequency]), blocks)[:, 0]
        phase = np.unwrap(np.angle(found))
        change = np.polyfit(np.arange(blocks) * span, phase, 1)[0] / (2.0 * np.pi)
        frequency += float(change)
        if abs(change) < 1e-9 * frequency:
            break
    return frequency
