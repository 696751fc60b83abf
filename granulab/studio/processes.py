"""Commands that the page started: their words while they go on, stopping them, their ends."""

import gc
import json
import multiprocessing
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from granulab.campaign.output.terminal import INTERVAL
from granulab.errors import InputError, Stopped

_SOURCES = Path(__file__).resolve().parents[2]
_LINES = 200  # of its words that are kept
_EVERY = "0.5"  # [s] between words on its progress
_GRACE = 20.0  # [s] for all to keep their state when the server ends
_PATIENCE = 600.0  # [s] for an answer of another process, kernels compiled
_LOOK = 0.3  # [s] between looks at whether the server ends
_PROGRESS = re.compile(r"^(?P<name>.*): (?P<percent>\d+)%(?P<words>.*)$")

Answer = TypeVar("Answer")


class Process:
    """A command of this project, as a process of its own."""

    def __init__(self, command: Sequence[str], folder: Path) -> None:
        self.command, self.begun = [*command], time.time()
        self.percent: int | None = None
        self.words = ""  # on its progress
        self.lines: deque[str] = deque(maxlen=_LINES)  # what else it said, of stderr
        self.said = ""  # on stdout, once it has ended
        self.stopping = False
        # A group of its own: Ctrl-C at the server's terminal reaches the server alone.
        apart: dict[str, Any] = {"start_new_session": True}
        if sys.platform == "win32":
            apart = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", *command], cwd=folder, env=_environment(),
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            encoding="utf-8", errors="replace", **apart,
        )  # fmt: skip
        self._readers = [
            threading.Thread(target=read, daemon=True) for read in (self._read_words, self._read)
        ]
        for reader in self._readers:
            reader.start()

    def _read_words(self) -> None:
        assert self._process.stderr
        for raw in self._process.stderr:
            line = raw.rstrip()
            if found := _PROGRESS.match(line):
                self.percent, self.words = int(found["percent"]), found["words"].strip()
            elif line:
                self.lines.append(line)

    def _read(self) -> None:
        assert self._process.stdout
        self.said = self._process.stdout.read()

    @property
    def code(self) -> int | None:
        """Its exit code; None while it goes on."""
        code = self._process.poll()
        if code is not None:
            for reader in self._readers:
                reader.join(timeout=1)
        return code

    def stop(self) -> None:
        """Ask it to end in good order, as Ctrl-C does; on Windows it ends at once."""
        if self._process.poll() is None:
            self.stopping = True
            if sys.platform == "win32":
                self._process.send_signal(signal.CTRL_BREAK_EVENT)
            else:
                self._process.send_signal(signal.SIGINT)

    def end(self, patience: float) -> None:
        """Stop it, and kill it where that takes longer [s]."""
        self.stop()
        try:
            self._process.wait(max(patience, 0.1))
        except subprocess.TimeoutExpired:
            self._process.kill()

    def state(self) -> dict[str, Any]:
        """Its state for the page: "running", "done", "refused", "failed", "stopped", with words."""
        code = self.code
        ends = {None: "running", 0: "done", 2: "refused", 130: "stopped"}
        state = "stopped" if self.stopping and code not in (None, 0) else ends.get(code, "failed")
        return {
            "state": state,
            "percent": 100 if state == "done" else self.percent,
            "words": self.words,
            "lines": list(self.lines)[-20:],
            "line": self.lines[-1] if self.lines and state in ("refused", "failed") else "",
            "seconds": time.time() - self.begun,
            "command": shell_words(self.command),
        }

    def result(self) -> Mapping[str, Any] | None:
        """The object of --json that it printed; None where it printed none."""
        try:
            found = json.loads(self.said)
        except ValueError:
            return None
        return found if isinstance(found, dict) else None


def _environment() -> dict[str, str]:
    """The environment with these same sources first, whatever the folder holds."""
    paths = [str(_SOURCES), *filter(None, [os.environ.get("PYTHONPATH")])]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths), INTERVAL: _EVERY}


_COMMANDS = {"silo2d": "silo2d", "damper3d": "damper3d", "calibration": "calibrate"}  # by module


def shell_words(command: Sequence[str]) -> str:
    """The same command as a person types it."""
    from granulab.campaign.output.files import in_shell

    module, *rest = command
    return " ".join([_COMMANDS.get(module, module), *map(in_shell, rest)])


class Processes:
    """All commands that the page started, by names; ended with the server."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._known: dict[str, Process] = {}
        self._lock = threading.Lock()

    def start(self, name: str, command: Sequence[str]) -> Process:
        """Start a command under a name; InputError where one of that name goes on."""
        with self._lock:
            known = self._known.get(name)
            if known is not None and known.code is None:
                raise InputError(f"{name}: runs already; stop it first, or wait for it")
            self._known[name] = Process(command, self._folder)
            return self._known[name]

    def get(self, name: str) -> Process | None:
        """The process of a name, going on or ended; None where none was started."""
        return self._known.get(name)

    def end(self) -> None:
        """End all that go on; their state is kept, and the same commands go on with them."""
        going = [one for one in self._known.values() if one.code is None]
        for one in going:
            one.stop()
        until = time.monotonic() + _GRACE
        for one in going:
            one.end(until - time.monotonic())


class Beside:
    """Another process for what compiles kernels: it would hold up the answers of this one."""

    def __init__(self) -> None:
        self._pool: Any = None
        self._lock = threading.Lock()
        self.ending = False  # answers are not waited for any more

    def call(self, function: Callable[..., Answer], *arguments: Any) -> Answer:
        """Result of a function of a module for arguments; its exceptions too.

        Raises Stopped where the server ends, or the answer takes longer than kernels compile.
        """
        with self._lock:
            if self._pool is None:
                self._pool = multiprocessing.get_context("spawn").Pool(1, _deaf)
        result, until = self._pool.apply_async(function, arguments), time.monotonic() + _PATIENCE
        while not self.ending and time.monotonic() < until:
            result.wait(_LOOK)
            if result.ready():
                return result.get()
        raise Stopped("no answer")

    def end(self) -> None:
        """End it, whatever it does."""
        if self._pool is not None:
            self._pool.terminate()
            self._pool.join()
            self._pool = None
            # its semaphores go with its last reference, and a signal ends the server before Python
            # would look for cycles
            gc.collect()


def _deaf() -> None:
    """Let Ctrl-C at the terminal be the server's, who ends this process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
