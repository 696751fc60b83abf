"""The command calibrate, run in this process."""

from small_silo import Answer, answer

from calibration.commands.main import main


def calibrate(*arguments: object) -> Answer:
    """What the command gives back; see small_silo.answer."""
    return answer("calibrate", main, *arguments)
