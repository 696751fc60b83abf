"""python -m calibration: the command calibrate."""

from calibration.commands.main import main

main()
