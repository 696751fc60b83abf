"""
Restitution from the sound of a bouncing ball
=============================================

What does a microphone tell of a bounce? A made recording of five impacts with e = 0.8: the
flights between them shorten by e each, T(k+1) = e T(k).

On the command line, with the recording that this script writes::

    $ calibrate impacts drop.wav
    restitution 0.799999 ...
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.io import wavfile

from calibration import measure_impacts

# %%
# Each impact rings at 2.5 kHz and dies away within milliseconds; noise is 0.3 % of the first.
rate, rng = 44100, np.random.default_rng(1)  # [Hz]
starts = 0.3137 + np.concatenate([[0], np.cumsum(0.45 * 0.8 ** np.arange(4))])  # [s]
time = np.arange(0, 2.0, 1 / rate)
sound = rng.normal(0, 0.003, len(time))
for k, start in enumerate(starts):
    since = np.clip(time - start, 0, None)
    sound += 0.8**k * np.sin(2 * np.pi * 2500 * since) * np.exp(-since / 3e-3)
wavfile.write("drop.wav", rate, np.int16(20000 * sound))

# %%
impacts = measure_impacts("drop.wav")
found = impacts.restitution
print(f"restitution {found.value:.7f} +- {found.sigma:.1g}")

figure, (signal, flights) = plt.subplots(2, layout="constrained")
signal.plot(time[::20], sound[::20], linewidth=0.5)
signal.plot(impacts.times_s, np.zeros(5), "rv")
signal.set(xlabel="time [s]", ylabel="sound [-]")
flights.semilogy(range(1, 5), np.diff(impacts.times_s), "o-")
flights.set(xlabel="flight [-]", ylabel="duration [s]", xticks=range(1, 5))

# %%
# The truth is within four of the uncertainty given: a normal error is beyond that once in 16,000.
assert abs(found.value - 0.8) < 4 * found.sigma
