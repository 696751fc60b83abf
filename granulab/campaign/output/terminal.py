"""Progress of a run at a terminal or in a notebook, and stopping it in good order."""

import _thread
import html
import math
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from time import monotonic
from typing import IO, Any, Self

from granulab.errors import Stopped

_LINE_INTERVAL = 10.0  # s between lines where stderr is a file or a pipe
INTERVAL = "GRANULAB_PROGRESS_INTERVAL"  # environment variable: other seconds between them
_UNNOTICED = 2.0  # [s] that nobody minds to wait without a word
_GRACE = 0.5  # [s] for a run to notice that it is to end
_REDRAWN = 0.3  # s between changes of a line in a notebook
_AGAIN = 0.05  # [s] after which a Ctrl-C that was lost comes again
_TELLING = 0.01  # part done from which on its speed says something; before, it is start-up


def say(line: str) -> None:
    """Print a line on stderr; where its reader (head) has gone, what goes on is silent from now."""
    try:
        print(line, file=sys.stderr, flush=True)
    except BrokenPipeError:
        forget_reader(sys.stderr)


def forget_reader(stream: IO[str]) -> None:
    """Send to nowhere what a stream still holds and gets: it would fail again and again."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)


class Progress:
    """Progress of a run: a bar on a terminal, a line in a notebook, else a line every ten seconds.

    `with Progress("A4") as progress: progress.update(0.42, "t = 1.2 s")`. Quiet prints nothing.
    Terminal and lines are stderr. The line in a notebook changes in place; it vanishes at the end,
    and stays where the run is stopped or fails.
    """

    def __init__(self, title: str, quiet: bool = False, estimates: bool = True) -> None:
        self._title = title
        # Whether the time left follows from the fraction. Else the words say it, and begin with
        # the stage that is on, of which each begins with a line.
        self._estimates, self._stage = estimates, ""
        self._quiet = quiet
        self._bar: Any = None
        self._cell: Any = None  # of a notebook: the display that changes in place
        self._fraction = 0.0  # shown; it never goes back
        self._started = 0.0
        self._last_line = -math.inf  # the first line comes at once
        self._interval = _seconds(os.environ.get(INTERVAL, ""))

    def __enter__(self) -> Self:
        self._started = monotonic()
        if self._quiet:
            return self
        if in_notebook():
            self._cell, self._interval = _cell(), _REDRAWN
        elif sys.stderr.isatty():
            self._bar = _bar(self._estimates)
            self._task = self._bar.add_task(self._title, total=1.0, text="")
            self._bar.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, *exception: object) -> None:
        if self._bar is not None:
            self._bar.stop()
        if self._cell is not None and kind is None:
            self._cell.update({"text/plain": "", "text/html": ""}, raw=True)

    def update(self, fraction: float, text: str = "") -> None:
        """Show the fraction done (0 to 1), which never goes back, and a few words."""
        self._fraction = max(self._fraction, min(fraction, 1.0))
        if self._bar is not None:
            self._bar.update(self._task, completed=self._fraction, text=text)
            return
        stage = "" if self._estimates else text.partition(",")[0]
        due = monotonic() - self._last_line >= self._interval or stage != self._stage
        if due and not self._quiet:
            self._last_line, self._stage = monotonic(), stage
            self._show(text)

    def _show(self, text: str) -> None:
        """Show one line of progress, in place in a notebook."""
        left = ""
        if self._estimates:
            left = _time_left(self._fraction, self._last_line - self._started)
        line = f"{self._title}: {self._fraction:.0%}{left} {text}".rstrip()
        if self._cell is None:
            say(line)
            return
        bar = f'<progress value="{self._fraction:.3f}"></progress> {html.escape(line)}'
        self._cell.update({"text/plain": line, "text/html": bar}, raw=True)


def in_notebook() -> bool:
    """True in the main thread of a kernel of Jupyter, whose cells have outputs that can change."""
    ipython = sys.modules.get("IPython")  # where it is not loaded, no kernel runs
    if ipython is None or threading.current_thread() is not threading.main_thread():
        return False
    return hasattr(ipython.get_ipython(), "kernel")


def _cell() -> Any:
    """An output of the cell that runs, empty as yet."""
    from IPython.display import display

    return display({"text/plain": "", "text/html": ""}, raw=True, display_id=True)


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

    def remind() -> None:
        after = _UNNOTICED
        while not done.wait(after):
            say(f"{words} ... {monotonic() - begun:.0f} s")
            after = _LINE_INTERVAL

    if not quiet:
        threading.Thread(target=remind, daemon=True).start()
    try:
        yield
    finally:
        done.set()


def announce_compilation(quiet: bool, already_compiled: bool) -> None:
    """Say why nothing happens for a while, where kernels are compiled first."""
    if not quiet and not already_compiled:
        say("compiling the kernels, once for this version (half a minute) ...")


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
    thread, where Python takes no signals, it does nothing. signals: those that are taken.
    """

    interrupted = False  # whether one has raised KeyboardInterrupt, which a compiler may swallow

    def __init__(self, signals: Sequence[signal.Signals] = (signal.SIGINT, signal.SIGTERM)) -> None:
        self._signals = signals
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
            for number in self._signals:
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


@contextmanager
def interruptible() -> Iterator[Callable[[], bool]]:
    """Let Ctrl-C, or a notebook's interrupt, end within what Python called, its state kept.

    Gives what is true once it is to end. Whoever sees that raises Stopped, which comes out as
    KeyboardInterrupt; where nobody looks in half a second, that is raised at once. Where Ctrl-C
    has another meaning (within a command, in a worker, in a thread), nothing changes.
    """
    here = threading.current_thread() is threading.main_thread()
    if not here or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield lambda: False
        return
    StopRequest.interrupted = False
    before, sys.unraisablehook = sys.unraisablehook, pass_on_interrupt
    try:
        with StopRequest([signal.SIGINT]) as stop:
            yield lambda: stop.requested
    except Exception as error:
        if isinstance(error, Stopped) or StopRequest.interrupted:  # numba makes another error of it
            raise KeyboardInterrupt(f"{error}; from Python the same call does") from None
        raise
    finally:
        sys.unraisablehook = before
