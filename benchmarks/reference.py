"""A fixed kernel to measure machines by: never to be changed, or old ratios mean nothing.

It does what a contact costs most: reads two rows of eight numbers at random positions, takes a
root and two divisions, and adds to both rows; 100,000 pairs of 4,096 rows.
"""

import time

import numba
import numpy as np

import granulab.contact.jit  # noqa: F401  its compiler settings count from the first decorator on


@numba.njit(error_model="numpy")
def _pass(rows, pairs):
    for k in range(len(pairs)):
        i, j = pairs[k, 0], pairs[k, 1]
        dx, dy = rows[j, 0] - rows[i, 0], rows[j, 1] - rows[i, 1]
        distance = np.sqrt(dx * dx + dy * dy)
        nx, ny = dx / distance, dy / distance
        approach = (rows[j, 2] - rows[i, 2]) * nx + (rows[j, 3] - rows[i, 3]) * ny
        force = 1e-3 * distance - 1e-6 * approach
        rows[i, 4] += force * nx
        rows[i, 5] += force * ny
        rows[j, 4] -= force * nx
        rows[j, 5] -= force * ny


def reference_ns() -> float:
    """CPU time of one pair of the reference kernel on this machine now [ns]; best of 20."""
    rng = np.random.default_rng(0)
    rows = rng.random((4096, 8))
    first = rng.integers(0, 4096, 100_000)
    pairs = np.stack([first, (first + rng.integers(1, 64, 100_000)) % 4096], axis=1)
    _pass(rows, pairs)
    best = np.inf
    for _ in range(20):
        began = time.process_time()
        _pass(rows, pairs)
        best = min(best, time.process_time() - began)
    return 1e9 * best / len(pairs)
