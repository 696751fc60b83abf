"""Tasks of a sweep in this process, which has the kernels, in place of workers of their own."""

from concurrent.futures import Future
from typing import Any, Self

from granulab.campaign.sweeps.task import Function, call


class ThisProcess:
    """One slot, whose task has ended when it was begun; see campaign.sweeps.processes."""

    slots = 1

    def __init__(self, *_: object) -> None:
        pass

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def submit(self, function: Function, task: Any) -> Future:
        """The outcome of a task."""
        outcome: Future = Future()
        outcome.set_result(call(function, task, lambda: False))
        return outcome

    def ask_to_stop(self) -> None:
        """No task runs when it could be asked."""

    def give_up(self) -> bool:
        """No task runs when it could be killed."""
        return False

    def lost(self) -> str:
        """Nothing is ever lost."""
        return ""
