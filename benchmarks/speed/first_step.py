"""A command up to the end of its first step: what a start costs.

python -m benchmarks.speed.first_step silo2d run A4
"""

import importlib
import os
import sys


def main() -> None:
    """Run the command; its process ends with the first step."""
    package = sys.argv[1]
    simulation = importlib.import_module(f"{package}.engine.simulation").Simulation
    for name in ("run", "step"):
        if hasattr(simulation, name):
            setattr(simulation, name, ending(getattr(simulation, name)))
    sys.argv = sys.argv[1:]
    importlib.import_module(f"{package}.commands.main").main()


def ending(go):
    """One step (or sample) in place of many, and the end of the process."""

    def first(simulation, n, *arguments, **options):
        go(simulation, min(n, 1), *arguments, **options)
        os._exit(0)

    return first


if __name__ == "__main__":
    main()
