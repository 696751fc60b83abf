"""Progress on stderr and stopping a run in good order."""

import ctypes
import os
import pty
import re
import signal
import sys
import threading
import time

import pytest

from granulab.campaign.output import terminal
from granulab.campaign.output.terminal import Progress, StopRequest
from granulab.campaign.runs import stages as stages_module
from granulab.campaign.runs.stages import COMPILING, Stages
from granulab.campaign.sweeps.engine import Tally
from granulab.campaign.sweeps.sweep import progress_of
from granulab.errors import Stopped


@pytest.fixture
def clock(monkeypatch):
    """A clock that the test moves by hand, in seconds."""
    now = [100.0]
    for module in (terminal, stages_module):
        monkeypatch.setattr(module, "monotonic", lambda: now[0])
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


@pytest.mark.parametrize(
    ("written", "seconds"), [("2", 2), ("0", 0.1), ("nan", 10), ("soon", 10), ("", 10)]
)
def test_a_program_that_reads_the_lines_says_how_often_they_come(
    clock, capsys, monkeypatch, written, seconds
):
    """The studio shows them twice a second; what is no time leaves the usual ten."""
    monkeypatch.setenv(terminal.INTERVAL, written)
    with Progress("A4") as progress:
        progress.update(0.1, "t = 1 s")
        for part in (0.9, 1.01):
            clock[0] = 100.0 + part * seconds
            progress.update(0.2, "t = 2 s")
    assert capsys.readouterr().err.count("t = 2 s") == 1


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


class Cell:
    """Output of a notebook's cell: keeps what it has shown."""

    def __init__(self):
        self.shown = []

    def update(self, data, raw):
        assert raw
        self.shown.append(data["text/plain"])


@pytest.fixture
def cell(monkeypatch):
    made = Cell()
    monkeypatch.setattr(terminal, "in_notebook", lambda: True)
    monkeypatch.setattr(terminal, "_cell", lambda: made)
    return made


def test_notebook_gets_one_line_that_changes_and_vanishes(clock, capsys, cell):
    """Changed three times a second at most, never back; stderr and stdout stay empty."""
    with Progress("A4 <1>") as progress:
        for tenth in range(30):
            clock[0] = 100.0 + tenth / 10
            progress.update(0.5 if tenth == 15 else tenth / 100, "on")
    assert capsys.readouterr() == ("", "")
    *lines, last = cell.shown
    assert last == ""
    assert 3 < len(lines) <= 1 + 2.9 / terminal._REDRAWN
    parts = [int(re.search(r"(\d+)%", line)[1]) for line in lines]
    assert parts == sorted(parts)
    assert parts[-1] == 50
    assert lines[-1] == "A4 <1>: 50% (3 s left) on"


def test_line_of_a_notebook_stays_where_the_run_was_stopped(clock, cell):
    def stopped():
        with Progress("A4", estimates=False) as progress:
            progress.update(0.43, "discharging, t = 1 s; 3 s left")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stopped()
    assert cell.shown == ["A4: 43% discharging, t = 1 s; 3 s left"]


def test_a_script_is_no_notebook():
    assert not terminal.in_notebook()


def test_interrupt_of_what_python_called_asks_and_comes_out_as_itself():
    """Who looks ends in good order; afterwards Ctrl-C is Python's own again."""

    def work():
        with terminal.interruptible() as stop:
            assert not stop()
            signal.raise_signal(signal.SIGINT)
            if stop():
                raise Stopped("kept")

    hook = sys.unraisablehook
    with pytest.raises(KeyboardInterrupt, match="kept"):
        work()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert sys.unraisablehook is hook


def test_interrupt_that_means_something_else_is_left_alone():
    """Within a command, and in a worker that is kept from Ctrl-C."""
    with StopRequest() as command, terminal.interruptible() as stop:
        signal.raise_signal(signal.SIGINT)
        assert command.requested
        assert not stop()
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with terminal.interruptible() as stop:
            signal.raise_signal(signal.SIGINT)
            assert not stop()
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_first_signal_is_a_request(number):
    """The loop sees a flag at its next frame; afterwards the old handlers are back."""
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    with StopRequest() as stop:
        assert not stop.requested
        signal.raise_signal(number)
        assert stop.requested
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before


def test_an_interrupt_within_a_compilers_callback_comes_again(monkeypatch, capfd):
    """ctypes swallows it and prints a traceback; after it the program would go on."""
    monkeypatch.setattr(sys, "unraisablehook", terminal.pass_on_interrupt)
    calls = []

    @ctypes.CFUNCTYPE(None)
    def callback():
        calls.append(1)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):  # noqa: PT012  the second line is where it comes
        callback()
        time.sleep(5.0)
    assert calls == [1]
    assert capfd.readouterr().err == ""


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


def test_what_never_looks_is_interrupted_within_a_second(monkeypatch):
    """Growth, shapes and long steps have no frames to end at; who looks ends by itself."""
    monkeypatch.setattr(StopRequest, "interrupted", False)

    def busy():
        with StopRequest():
            signal.raise_signal(signal.SIGINT)
            while time.monotonic() - begun < 10.0:
                pass

    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        busy()
    assert time.monotonic() - begun < 5.0  # half a second on a machine that is not busy
    with StopRequest() as stop:
        signal.raise_signal(signal.SIGINT)
        assert stop.requested
        time.sleep(0.7)


def test_what_takes_long_says_so_and_what_does_not_is_silent(monkeypatch, capsys):
    monkeypatch.setattr(terminal, "_UNNOTICED", 0.01)
    with terminal.patience("filling a shape", quiet=True):
        time.sleep(0.05)
    assert capsys.readouterr().err == ""
    with terminal.patience("filling a shape"):
        time.sleep(0.1)
    assert capsys.readouterr().err == "filling a shape ... 0 s\n"


def _seconds(words):
    """The time left that words say [s], None where they say none."""
    found = re.search(r"; (\S+) (s|min|h) left", words)
    return found and float(found[1]) * {"s": 1, "min": 60, "h": 3600}[found[2]]


def test_time_left_is_within_a_factor_of_a_half_though_all_was_expected_wrong(clock):
    """Three stages on a machine three times as slow, the first four times.

    Reported from 5 s or 5 % of the work on, the later; the bar never goes back, and ends below 1
    as the caller's command goes on.
    """
    reported = []
    stages = Stages(lambda fraction, words: reported.append((clock[0], fraction, words)))
    stages.expect(filling=10.0, settling=2.0, shaking=20.0)
    for stage, cost in (("filling", 40.0), ("settling", 6.0), ("shaking", 60.0)):
        stages.begin(stage)
        for k in range(100):
            clock[0] += cost / 100
            stages.report(stage, k + 1, 99 - k, "on")
        stages.finish(stage)
    end = clock[0]
    fractions = [fraction for _, fraction, _ in reported]
    assert fractions == sorted(fractions)
    assert 0.9 < fractions[-1] < 1.0
    late = [(end - now, _seconds(words)) for now, _, words in reported if 105.3 < now < end - 2.0]
    assert len(late) > 280
    assert all(left / 1.5 < said < 1.5 * left for left, said in late)


def test_bar_of_what_may_end_early_is_by_its_position_and_hedged(clock):
    reported = []
    stages = Stages(lambda fraction, words: reported.append((fraction, words)))
    stages.expect(discharging=10.0)
    stages.hedge = " at most"
    clock[0] += 4.0
    stages.report("discharging", 3.0, 1.0, "t = 1 s of at most 6 s", position=1 / 6)
    fraction, words = reported[-1]
    assert fraction == pytest.approx(1 / 6)
    assert words == "discharging, t = 1 s of at most 6 s; 2 s left at most"


def test_stage_that_is_gone_on_with_is_judged_by_what_was_done_since(clock):
    stages = Stages(lambda fraction, words: None)
    stages.expect(filling=5.0, shaking=100.0)
    stages.finish("filling")  # it was there
    stages.begin("shaking", 90, 10)
    clock[0] += 5.0
    stages.report("shaking", 95, 5, "on")
    assert stages.seconds_left() == pytest.approx(5.0)


def test_stage_that_turns_out_longer_than_when_it_was_gone_on_with_has_time_left(clock):
    """A bed that lay still flows again: less of all is done than at the start."""
    stages = Stages(lambda fraction, words: None)
    stages.expect(shaking=600.0)
    stages.begin("shaking", 95, 5)
    for k in range(1, 60):
        clock[0] += 5.0
        stages.report("shaking", 95 + k, 160 - k, "on")
        assert stages.seconds_left() > 150.0


def test_compiling_is_reported_once_and_is_no_other_stages_time(clock, monkeypatch):
    """numba's own events of a function compiled on the fly: words, and no time of the stage's."""
    import numba

    reported = []
    stages = Stages(lambda fraction, words: reported.append(words), compiling=(4.0, 1))
    stages.expect(filling=10.0)
    stages.report("filling", 1, 9, "on")
    with stages.watching(), stages.watching():
        numba.njit(lambda x: x + 1)(1)
    assert reported[-1].startswith(f"{COMPILING}, function 1 of about 1")
    clock[0] += 1.0
    stages.report("filling", 2, 8, "on")
    assert stages.seconds_left() == pytest.approx(
        8.0 * (1 + 0.05 * 10) / (0.2 + 0.05) / 10, rel=0.2
    )


def test_sweep_says_the_time_left_from_what_its_runs_took():
    """Eight runs of 10 s expected; two took 30 s, two run for 15 s: 4.5 times 30 s on two cores."""
    tally = Tally(8, 2, 2, 0, slots=2, took={0: 30.0, 1: 30.0}, since={2: 15.0, 3: 15.0})
    done, left = progress_of(tally, [10.0] * 8)
    assert left == pytest.approx(75.0, rel=0.1)
    assert done == pytest.approx(3 / 8, abs=0.03)
    assert progress_of(Tally(1, 1, took={0: 5.0}), [10.0]) == (1.0, 0.0)


def test_a_run_that_takes_longer_than_its_like_is_not_done():
    """The last of two, of which the first took 10 s, is at work for a minute: not at 100 %."""
    done, left = progress_of(
        Tally(2, 1, 1, 0, slots=1, took={0: 10.0}, since={1: 60.0}), [10.0] * 2
    )
    assert done < 0.95
    assert left >= 0.15 * 60
