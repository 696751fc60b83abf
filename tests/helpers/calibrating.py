"""The command calibrate, run in this process."""

from small_silo import Completed, run_command

from calibration.commands.main import main


def calibrate(*arguments: object) -> Completed:
    """What the command gives back; see small_silo.run_command."""
    return run_command("calibrate", main, *arguments)
