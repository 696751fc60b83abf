"""The command damper3d, run in this process."""

import contextlib
import io
import sys
from unittest import mock

from small_silo import Answer

from damper3d.cli import main


def damper3d(*arguments: object) -> Answer:
    """Run the command; a traceback fails the test."""
    out, err = io.StringIO(), io.StringIO()
    code = 0
    with (
        mock.patch.object(sys, "argv", ["damper3d", *map(str, arguments)]),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        try:
            main()
        except SystemExit as leave:
            code = int(leave.code or 0)
    return Answer(code, out.getvalue(), err.getvalue())
