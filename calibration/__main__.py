"""python -m calibration: the command calibrate."""

from calibration.cli import main

main()
