"""Progress on stderr and stopping a run in good order."""

import os
import pty
import signal
import sys
import threading

import pytest

from granulab.campaign.output import terminal
from granulab.campaign.output.terminal import Progress, StopRequest


@pytest.fixture
def clock(monkeypatch):
    """A clock that the test moves by hand, in seconds."""
    now = [100.0]
    monkeypatch.setattr(terminal, "monotonic", lambda: now[0])
    return now


def test_log_gets_a_line_every_ten_seconds(clock, capsys):
    """A file or a pipe: at most one line in 10 s, on stderr, with the time left at mean speed."""
    with Progress("A4 [seed 1]") as progress:
        for second in range(31):
            clock[0] = 100.0 + second
            progress.update(second / 100, f"t = {second} s")
    shown = capsys.readouterr()
    assert shown.out == ""
    assert shown.err.splitlines() == [
        "A4 [seed 1]: 0% t = 0 s",
        "A4 [seed 1]: 10% (2 min left) t = 10 s",
        "A4 [seed 1]: 20% (80 s left) t = 20 s",
        "A4 [seed 1]: 30% (70 s left) t = 30 s",
    ]


def test_fraction_stays_within_its_bounds(clock, capsys):
    with Progress("A4") as progress:
        progress.update(-0.1)
        clock[0] += 10.0
        progress.update(1.2, "done")
    assert capsys.readouterr().err.splitlines() == ["A4: 0%", "A4: 100% done"]


def test_quiet_says_nothing(capsys):
    with Progress("A4", quiet=True) as progress:
        progress.update(0.5, "t = 1 s")
    assert capsys.readouterr() == ("", "")


def test_terminal_gets_a_bar_and_stdout_stays_clean(monkeypatch, capsys):
    """On a (pseudo) terminal: title, percent and text as given, brackets too; --json goes out."""
    master, slave = pty.openpty()
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "120")
    with open(slave, "w") as screen:  # noqa: PTH123, a file descriptor
        monkeypatch.setattr(sys, "stderr", screen)
        with Progress("A4 [bold]") as progress:
            progress.update(0.42, "t = 1.2 s [/x]")
            print('{"n_out": 3}')
        monkeypatch.undo()
        shown = ""
        while "t = 1.2 s [/x]" not in shown:  # a terminal may give what was written in parts
            shown += os.read(master, 65536).decode()
    os.close(master)
    for word in ("A4 [bold]", "42%", "t = 1.2 s [/x]"):
        assert word in shown
    assert "n_out" not in shown
    assert capsys.readouterr().out == '{"n_out": 3}\n'


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_first_signal_is_a_request(number):
    """The loop sees a flag at its next frame; afterwards the old handlers are back."""
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    with StopRequest() as stop:
        assert not stop.requested
        signal.raise_signal(number)
        assert stop.requested
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before


def test_second_interrupt_stops_at_once_and_second_term_waits():
    before = signal.getsignal(signal.SIGINT)
    with StopRequest() as stop:
        signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(signal.SIGTERM)
        assert stop.requested
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is before


def test_stop_request_is_harmless_in_other_threads():
    """A sweep may run cases in threads, where Python lets nobody set a handler."""
    before = signal.getsignal(signal.SIGINT)
    seen = []

    def work():
        with StopRequest() as stop:
            seen.append((stop.requested, signal.getsignal(signal.SIGINT)))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == [(False, before)]
