"""Vectors a second on one core: correlation and optical flow, by size of window and picture.

Run as `python benchmarks/piv.py`, on a machine with nothing else to do. CPU time of all
threads, pictures in memory; the best of three.
"""

import time

import cv2
import numpy as np

from calibration.piv import displacement
from granulab.campaign.runs.provenance import cpu_model


def pair(side: int) -> tuple[np.ndarray, np.ndarray]:
    """Smoothed noise, moved by three pixels along x and two along y."""
    noise = np.random.default_rng(1).standard_normal((side + 8, side + 8)).astype(np.float32)
    grey = 128 + 200 * cv2.GaussianBlur(noise, (0, 0), 1.5)
    return grey[2 : side + 2, 3 : side + 3], grey[:side, :side]


def seconds(method: str, side: int, window: int, overlap: float) -> tuple[int, float]:
    """Vectors and CPU time of a pair."""
    a, b = pair(side)
    times = []
    for _ in range(3):
        began = time.process_time()
        field = displacement(a, b, window=window, overlap=overlap, method=method)
        times.append(time.process_time() - began)
    return field.u.size, min(times)


def main() -> None:
    """Print the table."""
    cv2.setNumThreads(1)
    print(cpu_model())
    print(f"{'method':8}{'picture':>12}{'window':>8}{'overlap':>9}{'vectors':>9}{'s':>8}{'1/s':>8}")
    for method in ("piv", "flow"):
        for side, window, overlap in (
            (512, 32, 0.5),
            (512, 16, 0.5),
            (512, 32, 0.75),
            (1024, 32, 0.5),
        ):
            vectors, spent = seconds(method, side, window, overlap)
            print(f"{method:8}{side:>7} x {side:<4}{window:6}{overlap:9.2f}{vectors:9}{spent:8.2f}"
                  f"{vectors / spent:8.0f}", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
