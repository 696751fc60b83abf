"""Stages of a run on one scale: the part of all that is done, and the time left by what it cost."""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic

COMPILING = "compiling, once"
_PRIOR = 0.05  # weight of the expected cost of a stage against its measured one, in parts of it
_TRUSTED = 1.0  # [s] of work after which the speed of this machine is rather measured than assumed
_TELLING = 3.0  # [s] from which on a time left is said
_MOST = 0.995  # of what is not known to be over


class Stages:
    """Progress of a run over all its stages, monotone, with the time left.

    Each stage has an expected cost [s]; what was measured corrects it: that of a stage itself once
    it goes on, that of all which follow by the speed of this machine.

    progress   takes the part of all that is done (0 to 1), never less than before, and words
    compiling  expected cost of the kernels [s], and about how many functions they are
    hedge      words after the time left, where it is known with an "if" only
    """

    def __init__(
        self, progress: Callable[[float, str], None], compiling: tuple[float, int] = (30.0, 100)
    ) -> None:
        self.compiling, self.hedge = compiling, ""
        self._progress = progress
        self._expected: dict[str, float] = {}  # [s]
        self._measured: dict[str, float] = {}  # [s]
        self._first: dict[str, float] = {}  # part of each stage that was done before (a checkpoint)
        self._parts: dict[str, float] = {}  # of each stage's cost, that are done
        self._shown: dict[str, float] = {}  # of each stage on the bar
        self._fraction, self._compiled, self._watching = 0.0, 0, False
        self._begun = self._last = monotonic()
        self._stage = ""

    @classmethod
    def of(cls, progress: "Callable[[float, str], None] | Stages | None") -> "Stages":
        """The stages themselves, or new ones that report to a function."""
        if isinstance(progress, Stages):
            return progress
        return cls(progress or (lambda fraction, words: None))

    def expect(self, **seconds: float) -> None:
        """Set what stages are expected to cost [s], before they begin."""
        self._expected |= {stage: max(cost, 1e-9) for stage, cost in seconds.items()}

    def begin(self, stage: str, done: float = 0.0, left: float = 1.0) -> None:
        """Begin a stage, some of which may be done already; see report."""
        self._take_time(stage)
        self._measured[stage] = 0.0  # of an attempt before, in longer steps
        self._first[stage] = self._parts[stage] = done / (done + left)

    def finish(self, stage: str) -> None:
        """Count a stage as over; one that did not begin was not needed."""
        if stage not in self._parts:
            self._expected.pop(stage, None)
            return
        self._take_time(stage)
        self._parts[stage] = self._shown[stage] = 1.0

    def report(
        self, stage: str, done: float, left: float, words: str, position: float | None = None
    ) -> None:
        """Report how far a stage is.

        done, left  its work, in one unit of any kind
        position    on the bar (0 to 1), where it is not the part of the work
        """
        self._take_time(stage)
        self._parts[stage] = done / (done + left) if done > 0 else 0.0
        shown = self._parts[stage] if position is None else position
        self._shown[stage] = min(max(shown, 0.0), 1.0)
        self._say(words)

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Report what is compiled within; its time counts to no other stage."""
        if self._watching:
            yield
            return
        from granulab.contact.jit import watched_compilation  # numba: --help needs it not

        self._watching = True
        try:
            with watched_compilation(self._compiling):
                yield
        finally:
            self._watching = False

    def _compiling(self, ended: bool) -> None:
        """Take note that a function begins to be compiled, or has been."""
        if not ended:
            self._take_time(self._stage)
            return
        stage, (seconds, number) = self._stage, self.compiling
        self._compiled += 1
        self._expected.setdefault(COMPILING, seconds)
        self._take_time(COMPILING)
        self._parts[COMPILING] = self._shown[COMPILING] = min(self._compiled / number, _MOST)
        self._say(f"function {self._compiled} of about {max(number, self._compiled)}")
        self._stage = stage  # which goes on

    def _take_time(self, stage: str) -> None:
        """Count the time since the last call to a stage, which is the one that is on."""
        now = monotonic()
        self._measured[stage] = self._measured.get(stage, 0.0) + now - self._last
        self._last, self._stage = now, stage

    def _say(self, words: str) -> None:
        whole = sum(self._expected.values())
        shown = sum(cost * self._shown.get(name, 0.0) for name, cost in self._expected.items())
        if whole:
            self._fraction = max(self._fraction, min(shown / whole, _MOST))
        text = f"{self._stage}, {words}"
        if self._last - self._begun >= _TELLING and self._expected:
            text += f"; {in_words(self.seconds_left())} left{self.hedge}"
        self._progress(self._fraction, text)

    def seconds_left(self) -> float:
        """Time [s] that all is expected to take from now on."""
        slowness, left = self._slowness(), 0.0
        for name, cost in self._expected.items():
            part = self._parts.get(name, 0.0)
            own = slowness * cost  # of the whole stage
            if name == self._stage:
                measured, done = self._measured[name], self._gone(name)
                own = (measured + _PRIOR * own) / (done + _PRIOR)
            elif name == COMPILING and part:
                continue  # what another stage has still to compile is not known
            left += own * (1.0 - part)
        return left

    def _gone(self, stage: str) -> float:
        """Part of a stage that was done here; it may turn out longer than when it began."""
        return max(self._parts.get(stage, 0.0) - self._first.get(stage, 0.0), 0.0)

    def _slowness(self) -> float:
        """Measured over expected cost of what is done; that of compiling where nothing else is."""
        ratio, own = 1.0, [name for name in self._expected if name != COMPILING]
        for names in ([COMPILING], own):
            cost = sum(self._expected.get(name, 0.0) * self._gone(name) for name in names)
            measured = sum(self._measured.get(name, 0.0) for name in names)
            ratio = (_TRUSTED * ratio + measured) / (_TRUSTED + cost)
        return ratio


def in_words(seconds: float) -> str:
    """A time as a person says it: 40 s, 2.5 min, 12 min, 3 h."""
    if seconds < 90:
        return f"{max(math.ceil(seconds), 1)} s"
    if seconds < 5400:
        return f"{seconds / 60:.{1 if seconds < 600 else 0}f} min"
    return f"{seconds / 3600:.{1 if seconds < 36000 else 0}f} h"
