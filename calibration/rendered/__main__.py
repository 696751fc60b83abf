"""Render a sample of data/media again: python -m calibration.rendered NAME FOLDER."""

import sys
from pathlib import Path

from calibration.rendered.samples import SAMPLES


def main(arguments: list[str]) -> int:
    """Write the sample's clip and its truth; their paths on stdout. 2 for what cannot be done."""
    if len(arguments) != 2 or arguments[0] not in SAMPLES:
        print(f"python -m calibration.rendered {'|'.join(SAMPLES)} FOLDER", file=sys.stderr)
        return 2
    name, folder = arguments
    Path(folder).mkdir(parents=True, exist_ok=True)
    for path in SAMPLES[name](Path(folder)):
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
