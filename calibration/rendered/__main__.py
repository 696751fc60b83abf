"""Render a sample of data/media anew: python -m calibration.rendered NAME FOLDER."""

import importlib
import sys
from pathlib import Path

# name: module of calibration.rendered with a function write(folder) -> paths written
_SAMPLES: dict[str, str] = {
    "drop": "drop_sample",
    "flow": "flow_sample",
    "pendulum": "pendulum_sample",
}


def main(arguments: list[str]) -> int:
    """Write the sample's clip and its truth; their paths on stdout. 2 for what cannot be done."""
    if len(arguments) != 2 or arguments[0] not in _SAMPLES:
        print(f"python -m calibration.rendered {'|'.join(_SAMPLES)} FOLDER", file=sys.stderr)
        return 2
    name, folder = arguments
    module = importlib.import_module(f"calibration.rendered.{_SAMPLES[name]}")
    Path(folder).mkdir(parents=True, exist_ok=True)
    for path in module.write(Path(folder)):
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
