"""Progress of a run at a terminal, and stopping it in good order."""

import math
import signal
import sys
import threading
from time import monotonic
from typing import Any, Self

_LINE_INTERVAL = 10.0  # s between lines where stderr is a file or a pipe
_TELLING = 0.01  # part done from which on its speed says something; before, it is start-up


class Progress:
    """Progress of a run on stderr: a bar on a terminal, else a line every ten seconds.

    `with Progress("A4") as progress: progress.update(0.42, "t = 1.2 s")`. Quiet prints nothing.
    """

    def __init__(self, title: str, quiet: bool = False, memory: float = 30.0) -> None:
        self._title = title
        self._memory = memory  # [s] over which the speed is taken that gives the time left
        self._quiet = quiet
        self._bar: Any = None
        self._started = 0.0
        self._last_line = -math.inf  # the first line comes at once

    def __enter__(self) -> Self:
        self._started = monotonic()
        if not self._quiet and sys.stderr.isatty():
            self._bar = _bar(self._memory)
            self._task = self._bar.add_task(self._title, total=1.0, text="")
            self._bar.start()
        return self

    def __exit__(self, *exception: object) -> None:
        if self._bar is not None:
            self._bar.stop()

    def update(self, fraction: float, text: str = "") -> None:
        """Show the fraction done (0 to 1) and a few words on what goes on."""
        fraction = min(max(fraction, 0.0), 1.0)
        if self._bar is not None:
            self._bar.update(self._task, completed=fraction, text=text)
        elif not self._quiet and monotonic() - self._last_line >= _LINE_INTERVAL:
            self._last_line = monotonic()
            left = _time_left(fraction, self._last_line - self._started)
            line = f"{self._title}: {fraction:.0%}{left} {text}".rstrip()
            print(line, file=sys.stderr, flush=True)


def announce_compilation(quiet: bool, already_compiled: bool) -> None:
    """Say why nothing happens for a while, where kernels are compiled first."""
    if not quiet and not already_compiled:
        line = "compiling the kernels, once for this version (10 to 30 s) ..."
        print(line, file=sys.stderr, flush=True)


def _bar(memory: float):
    from rich import progress
    from rich.console import Console

    return progress.Progress(
        progress.TextColumn("{task.description}", markup=False),
        progress.BarColumn(),
        progress.TaskProgressColumn(),
        progress.TimeRemainingColumn(),
        progress.TextColumn("{task.fields[text]}", markup=False),
        console=Console(stderr=True),
        speed_estimate_period=memory,
        redirect_stdout=False,  # the object of --json must not end up on stderr
    )


def _time_left(fraction: float, elapsed: float) -> str:
    """The words "(3 min left)" at the mean speed so far, or nothing while that says nothing."""
    if fraction < _TELLING or fraction >= 1.0:
        return ""
    left = elapsed * (1.0 - fraction) / fraction
    return f" ({left / 60:.0f} min left)" if left >= 90 else f" ({left:.0f} s left)"


class StopRequest:
    """Turns the first Ctrl-C or SIGTERM into `requested`, so that a run ends at a whole frame.

    A further Ctrl-C raises KeyboardInterrupt. Outside the main thread, where Python takes no
    signals, it does nothing.
    """

    def __init__(self) -> None:
        self.requested = False
        self._previous: dict[signal.Signals, Any] = {}

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM):
                self._previous[number] = signal.signal(number, self._receive)
        return self

    def __exit__(self, *exception: object) -> None:
        for number, handler in self._previous.items():
            # None stands for a handler that was not set from Python and cannot be put back.
            signal.signal(number, signal.SIG_DFL if handler is None else handler)

    def _receive(self, number: int, _frame: object) -> None:
        if self.requested and number == signal.SIGINT:
            raise KeyboardInterrupt
        self.requested = True
