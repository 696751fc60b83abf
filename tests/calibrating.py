"""The command calibrate, run in this process."""

import contextlib
import io
import sys
from unittest import mock

from small_silo import Answer

from calibration.cli import main


def calibrate(*arguments: object) -> Answer:
    """What the command gives back; a traceback fails the test."""
    out, err = io.StringIO(), io.StringIO()
    code = 0
    with (
        mock.patch.object(sys, "argv", ["calibrate", *map(str, arguments)]),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        try:
            main()
        except SystemExit as leave:
            code = int(leave.code or 0)
    return Answer(code, out.getvalue(), err.getvalue())
