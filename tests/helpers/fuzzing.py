"""Number of drawn examples: few with every test run, many with `make fuzz`."""

import os

# `make fuzz` sets it: how many times as many examples as `make test` draws.
TIMES = int(os.environ.get("FUZZ_TIMES", "1"))


def examples(usual: int) -> int:
    """The number of examples that a test draws, of which `usual` are enough for every day."""
    return usual * TIMES
