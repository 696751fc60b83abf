"""Parts of a bed: particles that follow one another, which threads share out among them."""

import numpy as np


def parts_of(n: int, most: int) -> np.ndarray:
    """Bounds of the parts of n particles (n_parts + 1,), of which there are so many at most.

    The number of parts is a power of two, so that 2, 4, 8 threads have as many each; one at least.
    """
    n_parts = 1 << max(most.bit_length() - 1, 0)
    return np.arange(n_parts + 1) * n // n_parts
