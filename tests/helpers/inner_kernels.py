"""A way from Python into functions that only kernels call (granulab.contact.jit.inner)."""

from collections.abc import Callable
from typing import Any

import numba


def called(function: Any) -> Callable[..., Any]:
    """Make a kernel of no more than a call of it."""

    def call(*arguments: Any) -> Any:
        return function(*arguments)

    return numba.njit(call)
