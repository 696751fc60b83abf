"""Tasks without physics for the engines; workers import them by name."""

import os
import signal
import time
from pathlib import Path
from typing import Any

from granulab.campaign.runs.protocol import Stop
from granulab.errors import Failed, Stopped


def square(number: int, stop: Stop) -> int:
    """A task that always succeeds."""
    return number * number


def fussy(number: int, stop: Stop) -> int:
    """Fails for 1 as foreseen, for 2 as nobody foresaw, for 3 with an result nobody can send."""
    if number == 1:
        raise Failed("one is refused;\ngive another")
    if number == 2:
        return number // 0
    return (lambda: 0) if number == 3 else number


def surroundings(_: Any, stop: Stop) -> tuple[str | None, str | None, int]:
    """The threads that a library may start, and the process."""
    return os.environ.get("OMP_NUM_THREADS"), os.environ.get("NUMBA_NUM_THREADS"), os.getpid()


def on_ctrl_c(_: Any, stop: Stop) -> str:
    """What Ctrl-C does to the process of a task."""
    return "ignored" if signal.getsignal(signal.SIGINT) == signal.SIG_IGN else "taken"


def killed(task: tuple[Path, int], stop: Stop) -> int:
    """Kills its own process the first so many times that it is called; then says how many."""
    file, times = task
    calls = int(file.read_text() or 0) if file.exists() else 0
    file.write_text(str(calls + 1))
    if calls < times:
        os.kill(os.getpid(), signal.SIGKILL)
    return calls


def patient(task: tuple[Path, float], stop: Stop) -> str:
    """Writes its process number to a file and waits; keeps its state when requested to stop."""
    file, seconds = task
    file.write_text(str(os.getpid()))
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if stop():
            file.with_suffix(".kept").touch()
            raise Stopped("go on with: the same")
        time.sleep(0.01)
    return "waited"


def slow_to_end(task: tuple[Path, float], stop: Stop) -> str:
    """A patient task that takes two seconds to keep its state."""
    return patient(task, lambda: stop() and time.sleep(2.0) is None)


def logged(task: tuple[Path, str], stop: Stop) -> None:
    """Adds a word to a file."""
    file, word = task
    with file.open("a") as log:
        log.write(f"{word} ")


def either(task: int | tuple[Path, float], stop: Stop) -> int | str:
    """A number is squared, another task is a patient one."""
    return square(task, stop) if isinstance(task, int) else patient(task, stop)


def deaf(task: tuple[Path, float], stop: Stop) -> str:
    """A patient task that never asks whether it is to stop."""
    return patient(task, lambda: False)
