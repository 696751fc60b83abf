"""Tasks of an engine: the call that runs one, and its outcome."""

import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from granulab.campaign.runs.protocol import Stop
from granulab.errors import Failed, Stopped

Function = Callable[[Any, Stop], Any]  # of a task; importable by name, and safe to call twice


class EngineError(RuntimeError):
    """The engine cannot work; one line that says what would do."""


class WorkerLost(Exception):
    """The worker of a task ended under it."""


@dataclass(frozen=True)
class Outcome:
    """Outcome of a task."""

    state: Literal["done", "failed", "interrupted"]
    value: Any = None  # what the function returned
    reason: str = ""  # why it is not done, in one line
    wall_s: float = 0.0  # that the function took


def call(function: Function, task: Any, stop: Stop) -> Outcome:
    """Return what comes of a task, in the process that runs it."""
    if stop():
        return Outcome("interrupted", reason="not started")
    begun = time.perf_counter()

    def ended(state: Literal["done", "failed", "interrupted"], **what: Any) -> Outcome:
        return Outcome(state, wall_s=time.perf_counter() - begun, **what)

    try:
        return ended("done", value=function(task, stop))
    except Stopped as error:
        return ended("interrupted", reason=in_one_line(error))
    except Exception as error:
        return ended("failed", reason=in_one_line(error))


def in_one_line(error: BaseException) -> str:
    """An exception in one line; one that nobody foresaw with its kind and line."""
    text = " ".join(str(error).split())
    if isinstance(error, (Failed, Stopped)):
        return text
    stack = traceback.extract_tb(error.__traceback__)
    where = f" ({Path(stack[-1].filename).name}:{stack[-1].lineno})" if stack else ""
    return f"{type(error).__name__}: {text}{where}"
