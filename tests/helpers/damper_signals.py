"""Made-up samples of a damper whose bed is a mass, spring and dashpot with a closed form."""

from collections.abc import Callable

import numpy as np

from damper3d.engine.records import CLASSES, HELD, MECHANISMS

AMPLITUDE, FREQUENCY = 2e-3, 40.0  # [m], [Hz]
OMEGA = 2 * np.pi * FREQUENCY
PEAK_SPEED = AMPLITUDE * OMEGA
ALONG = np.array([0.0, 0.0, 1.0])


def at_rest(n_cycles: int = 5, per_cycle: int = 100) -> dict[str, np.ndarray]:
    """Samples of an enclosure that moves as a sine, with a bed that does nothing."""
    n = n_cycles * per_cycle + 1
    time = np.arange(n) / (per_cycle * FREQUENCY)
    numbers = ["wall_work", *HELD]
    for pair in CLASSES:
        numbers += [f"{name}_{pair}" for name in (*MECHANISMS, "law_term", "slip_count")]
        numbers += [f"{name}_{pair}" for name in ("impact_speed", "contacts")]
    return {
        "time": time,
        "displacement": AMPLITUDE * np.sin(OMEGA * time),
        "velocity": PEAK_SPEED * np.cos(OMEGA * time),
        **{name: np.zeros(n) for name in numbers},
        "wall_force": np.zeros((n, 3, 3)),
        "mean_position": np.zeros((n, 3)),
        "mean_velocity": np.zeros((n, 3)),
    }


def pushed(samples: dict[str, np.ndarray], force: Callable[[np.ndarray], np.ndarray]) -> None:
    """Put in the force of the bed on the enclosure, given at times, and the work that it takes.

    It is shared by bottom and top; each row is the mean over 200 moments since the row before.
    """
    time = samples["time"]
    step = time[1] - time[0]
    moments = time[:-1, None] + (np.arange(200) + 0.5) * step / 200
    on_enclosure = force(moments)
    samples["wall_force"][1:, 0, 2] = 0.3 * on_enclosure.mean(axis=1)
    samples["wall_force"][1:, 1, 2] = 0.7 * on_enclosure.mean(axis=1)
    power = -on_enclosure * PEAK_SPEED * np.cos(OMEGA * moments)
    samples["wall_work"][1:] = np.cumsum(power.mean(axis=1) * step)
