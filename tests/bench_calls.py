"""The command calibrate in this process, and tables for it."""

import contextlib
import io
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

from calibration.cli import main


class Answer(NamedTuple):
    """What a command left."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> dict[str, Any]:
        return json.loads(self.out)


def calibrate(*arguments: object) -> Answer:
    """Run the command; a traceback fails the test."""
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


def write(path: Path, head: str, columns: Sequence[Sequence[object]]) -> Path:
    """A table of columns below its head; the floats as repr writes them."""
    rows = [";".join(str(v) for v in row) for row in zip(*columns, strict=True)]
    path.write_text("\n".join([head, *rows]) + "\n")
    return path
