"""Work in a copy of this process, which has the kernels; killed at a moment or at a write."""

import json
import os
import signal
import time
import warnings
from collections.abc import Callable
from dataclasses import astuple
from pathlib import Path
from unittest import mock

from small_silo import Completed


def fork() -> int:
    """os.fork; Python 3.12 warns of the threads by which a worker of pytest is controlled."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        return os.fork()


def forked(work: Callable[[], object], kill_at_write: int = 0) -> int:
    """Do a work in a copy of this process, which has the kernels; what ended it.

    0 where it came to its end, -9 where it was killed: with kill_at_write it kills itself at its
    so many-th write, the new file written but not in place.
    """
    child = fork()
    if child:
        _, status = os.waitpid(child, 0)
        return os.waitstatus_to_exitcode(status)
    replace, left = Path.replace, [kill_at_write]

    def killed(part: Path, target: Path) -> Path:
        left[0] -= 1
        if left[0] == 0:
            os.kill(os.getpid(), signal.SIGKILL)
        return replace(part, target)

    try:
        with mock.patch.object(Path, "replace", killed):
            work()
        os._exit(0)
    except BaseException:
        os._exit(1)


def killed_at(moment: Callable[[], object], wait: float, work: Callable[[], object]) -> bool:
    """Kill a copy of this process some time [s] after a moment of its work; False: too late."""
    child = fork()
    if not child:
        try:
            work()
        finally:
            os._exit(0)
    ended = 0
    while not moment() and not ended:
        ended, _ = os.waitpid(child, os.WNOHANG)
        time.sleep(1e-3)
    if ended:
        return False
    time.sleep(wait)
    os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    return os.waitstatus_to_exitcode(status) == -signal.SIGKILL


class Forked:
    """A command in a copy of this process, which has the kernels; cf. small_silo.start."""

    def __init__(self, command: Callable[..., Completed], *arguments: object) -> None:
        self._result, write = os.pipe()
        self.pid = fork()
        if not self.pid:
            try:
                os.write(write, json.dumps(astuple(command(*arguments))).encode())
            finally:
                os._exit(0)
        os.close(write)
        self._ended = False

    def poll(self) -> int | None:
        """0 once it has ended."""
        if not self._ended:
            self._ended = os.waitpid(self.pid, os.WNOHANG)[0] == self.pid
        return 0 if self._ended else None

    def send_signal(self, number: int) -> None:
        os.kill(self.pid, number)

    def finish(self) -> Completed:
        """Wait for it and give what it said."""
        with os.fdopen(self._result) as result:
            said = Completed(*json.loads(result.read()))
        if not self._ended:
            os.waitpid(self.pid, 0)
        return said
