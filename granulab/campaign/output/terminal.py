"""Progress of a run at a terminal, and stopping it in good order."""

import _thread
import math
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from time import monotonic
from typing import Any, Self

_LINE_INTERVAL = 10.0  # s between lines where stderr is a file or a pipe
INTERVAL = "GRANULAB_PROGRESS_INTERVAL"  # environment variable: other seconds between them
_UNNOTICED = 2.0  # [s] that nobody minds to wait without a word
_GRACE = 0.5  # [s] for a run to notice that it is to end
_AGAIN = 0.05  # [s] after which a Ctrl-C that was lost comes again
_TELLING = 0.01  # part done from which on its speed says something; before, it is start-up


class Progress:
    """Progress of a run on stderr: a bar on a terminal, else a line every ten seconds.

    `with Progress("A4") as progress: progress.update(0.42, "t = 1.2 s")`. Quiet prints nothing.
    """

    def __init__(self, title: str, quiet: bool = False, estimates: bool = True) -> None:
        self._title = title
        # Whether the time left follows from the fraction. Else the words say it, and begin with
        # the stage that is on, of which each begins with a line.
        self._estimates, self._stage = estimates, ""
        self._quiet = quiet
        self._bar: Any = None
        self._started = 0.0
        self._last_line = -math.inf  # the first line comes at once
        self._interval = _seconds(os.environ.get(INTERVAL, ""))

    def __enter__(self) -> Self:
        self._started = monotonic()
        if not self._quiet and sys.stderr.isatty():
            self._bar = _bar(self._estimates)
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
            return
        stage = "" if self._estimates else text.partition(",")[0]
        due = monotonic() - self._last_line >= self._interval or stage != self._stage
        if due and not self._quiet:
            self._last_line, self._stage = monotonic(), stage
            left = _time_left(fraction, self._last_line - self._started) if self._estimates else ""
            line = f"{self._title}: {fraction:.0%}{left} {text}".rstrip()
            print(line, file=sys.stderr, flush=True)


def _seconds(text: str) -> float:
    """Seconds between lines of progress; the usual ones for a text that is no time."""
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    return _LINE_INTERVAL if math.isnan(seconds) else max(seconds, 0.1)


@contextmanager
def patience(words: str, quiet: bool = False) -> Iterator[None]:
    """Say on stderr what takes long, after two seconds and then every ten; quiet says nothing."""
    done, begun = threading.Event(), monotonic()

    def say() -> None:
        after = _UNNOTICED
        while not done.wait(after):
            print(f"{words} ... {monotonic() - begun:.0f} s", file=sys.stderr, flush=True)
            after = _LINE_INTERVAL

    if not quiet:
        threading.Thread(target=say, daemon=True).start()
    try:
        yield
    finally:
        done.set()


def announce_compilation(quiet: bool, already_compiled: bool) -> None:
    """Say why nothing happens for a while, where kernels are compiled first."""
    if not quiet and not already_compiled:
        line = "compiling the kernels, once for this version (about a minute) ..."
        print(line, file=sys.stderr, flush=True)


def _bar(estimates: bool):
    from rich import progress
    from rich.console import Console

    return progress.Progress(
        progress.TextColumn("{task.description}", markup=False),
        progress.BarColumn(),
        progress.TaskProgressColumn(),
        progress.TimeRemainingColumn() if estimates else progress.TimeElapsedColumn(),
        progress.TextColumn("{task.fields[text]}", markup=False),
        console=Console(stderr=True),
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

    Where nobody has looked at it in half a second, or at a further Ctrl-C, KeyboardInterrupt is
    raised: what has no frames (growing particles, a shape, a long step) ends too. Outside the main
    thread, where Python takes no signals, it does nothing.
    """

    interrupted = False  # whether one has raised KeyboardInterrupt, which a compiler may swallow

    def __init__(self) -> None:
        self._requested = False
        self._previous: dict[signal.Signals, Any] = {}
        self._last_resort: threading.Timer | None = None

    @property
    def requested(self) -> bool:
        """True once the run is to end; who sees that ends it in good order."""
        if self._requested:
            self._forget_last_resort()
        return self._requested

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM):
                self._previous[number] = signal.signal(number, self._receive)
        return self

    def __exit__(self, *exception: object) -> None:
        self._forget_last_resort()
        for number, handler in self._previous.items():
            # None stands for a handler that was not set from Python and cannot be put back.
            signal.signal(number, signal.SIG_DFL if handler is None else handler)

    def _receive(self, number: int, _frame: object) -> None:
        if self._requested and number == signal.SIGINT:
            StopRequest.interrupted = True
            raise KeyboardInterrupt
        if not self._requested:
            self._requested = True
            self._last_resort = threading.Timer(_GRACE, _thread.interrupt_main)  # a SIGINT to us
            self._last_resort.daemon = True
            self._last_resort.start()

    def _forget_last_resort(self) -> None:
        if self._last_resort is not None:
            self._last_resort.cancel()
            self._last_resort = None


def pass_on_interrupt(unraisable: Any) -> None:
    """Let a Ctrl-C that came within a compiler's callback, where none can end it, come again.

    A sys.unraisablehook: what else is raised there is reported as usual.
    """
    if not issubclass(unraisable.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(unraisable)
        return
    again = threading.Timer(_AGAIN, _thread.interrupt_main)
    again.daemon = True
    again.start()
