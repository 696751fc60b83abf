"""Fixed kernels to measure machines by: never to be changed, or old ratios mean nothing.

A pair is what a contact costs most: two rows of eight numbers at random positions are read, with a
root and two divisions, and both are added to; 100,000 pairs of 4,096 rows. A row is what a particle
costs least: eight numbers are read and written in their order.
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


@numba.njit(error_model="numpy")
def _move(rows):
    for i in range(len(rows)):
        for c in range(4):
            rows[i, 4 + c] *= 0.999
            rows[i, c] += 1e-6 * rows[i, 4 + c]


def _best_ns(run, entries: int) -> float:
    """CPU time of an entry [ns]; best of 20 after one that compiles."""
    run()
    best = np.inf
    for _ in range(20):
        began = time.process_time()
        run()
        best = min(best, time.process_time() - began)
    return 1e9 * best / entries


def reference_ns() -> float:
    """CPU time of one pair of the reference kernel on this machine now [ns]."""
    rng = np.random.default_rng(0)
    rows = rng.random((4096, 8))
    first = rng.integers(0, 4096, 100_000)
    pairs = np.stack([first, (first + rng.integers(1, 64, 100_000)) % 4096], axis=1)
    return _best_ns(lambda: _pass(rows, pairs), len(pairs))


def row_ns() -> float:
    """CPU time of reading and writing a row on this machine now [ns]."""
    rows = np.random.default_rng(0).random((4096, 8))
    return _best_ns(lambda: [_move(rows) for _ in range(10)], 10 * len(rows))


def bound_us(contacts: int, particles: int) -> float:
    """Time of a step that only reads and adds to the rows of its contacts and particles [us]."""
    return 1e-3 * (contacts * reference_ns() + particles * row_ns())
