"""What a command did with an input: refused it, answered it, was stopped; or something bad."""

import contextlib
import json
import math
import os
import re
import signal
import threading
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from small_silo import Completed, run_command

from granulab.campaign.output.ranges import judged
from granulab.errors import InputError

LIMIT = 60.0  # [s] that no command here may take, on a machine that does other things too
UNFORESEEN = "nobody foresaw"
FROM_A_LIBRARY = "its numbers cannot be evaluated"  # a numerical library's exception, in a line
# Ranges of the plan that --dry-run prints, by key: between 0 and these.
PLAN = {"time_step_s": 1.0, "n_particles": 1e8, "steps_at_most": 1e13, "steps": 1e13}
# Not after "; ": a source of a value, which may be any text.
_NO_NUMBER = re.compile(r"(?<![\w/.:'\"])(?<!; )-?(nan|inf)(?![\w.'\":-])")
_JSON = re.compile(r"\s*\{\s*[\"}]")


class Hung(BaseException):
    """The limit is over."""


@dataclass(frozen=True)
class Verdict:
    """refused, answered, stopped or bad; why, where it is bad; the seconds that it took."""

    what: str
    why: str = ""
    seconds: float = 0.0


@contextlib.contextmanager
def _limited(patience: float | None) -> Iterator[None]:
    """Ctrl-C after `patience` [s], where that is given; Hung at the limit, from then on.

    What compiles kernels may take most of that to end.
    """

    def hung(*_: object) -> None:
        raise Hung

    before = signal.signal(signal.SIGALRM, hung)
    signal.setitimer(signal.ITIMER_REAL, LIMIT + (patience or 0.0))
    ctrl_c = threading.Timer(patience or LIMIT, os.kill, (os.getpid(), signal.SIGINT))
    ctrl_c.daemon = True
    if patience is not None:
        ctrl_c.start()
    try:
        yield
    finally:
        ctrl_c.cancel()
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def verdict(
    name: str,
    main: Callable[[], None],
    arguments: tuple[str, ...],
    patience: float | None = None,
    expected: str | None = None,
) -> Verdict:
    """The verdict on a command in this process.

    patience   seconds after which it is given Ctrl-C, of those that compute
    expected   what `answer_of` makes of the only right answer, where there is one
    """
    begun = time.monotonic()
    try:
        with _limited(patience), warnings.catch_warnings():
            warnings.simplefilter("always")
            result = run_command(name, main, *arguments)
    except Hung:
        return Verdict("bad", "hung", time.monotonic() - begun)
    except BaseException as error:
        line = traceback.extract_tb(error.__traceback__)[-1]
        why = f"traceback {type(error).__name__}: {error} at {line.filename}:{line.lineno}"
        return Verdict("bad", why, time.monotonic() - begun)
    what, why = judge(name, result, "--quiet" in arguments, patience is not None)
    if what == "answered" and expected is not None and answer_of(result) != expected:
        what, why = "bad", f"another answer: {answer_of(result)[:300]!r}"
    return Verdict(what, why, time.monotonic() - begun)


def judge(
    name: str, result: Completed, quiet: bool, may_be_stopped: bool = False
) -> tuple[str, str]:
    """What a finished command came to, and why where that is bad.

    quiet: it was told to be, so that nothing but the refusal may stand on stderr.
    """
    if UNFORESEEN in result.err or "Traceback" in result.out + result.err:
        return "bad", f"traceback: {result.err[-600:]}"
    if FROM_A_LIBRARY in result.err:
        return "bad", f"a library's exception: {result.err[:400]}"
    if ".py:" in result.err:
        return "bad", f"a warning of Python: {result.err[:300]}"
    if result.code == 0:
        why = _impossible(name, result.out)
        return ("bad", why) if why else ("answered", "")
    if result.code not in (2, 3) and not (result.code == 130 and may_be_stopped):
        return "bad", f"exit code {result.code}: {result.err[:300]}"
    said = (
        result.err.lstrip("\n") if result.code == 130 else result.err
    )  # click ends the line of ^C
    *before, line = said.splitlines() or [""]
    own = [one for one in (*before, line) if one.startswith(f"{name}: ")]
    if own != [line] or (quiet and before) or not result.err.endswith("\n"):
        return "bad", f"not one line: {result.err[:600]!r}"
    if not line.isprintable() or len(line) > 3000:
        return "bad", f"not a line to be read: {line[:300]!r}"
    if result.out and result.code == 2 and not result.out.endswith("\n"):
        return "bad", f"refused after half an answer: {result.out[-300:]!r}"
    return ("stopped" if result.code == 130 else "refused"), ""


def _impossible(name: str, out: str) -> str:
    """What cannot be in an answer; "" where it can be."""
    if not _JSON.match(out):
        found = _NO_NUMBER.search(out)
        return f"no number: {out[max(found.start() - 80, 0) : found.end() + 20]!r}" if found else ""
    try:
        answer = json.loads(out, parse_constant=_refuse)
    except ValueError as error:
        return f"no JSON: {error}: {out[:200]!r}"
    try:
        judged({"calibrate": "calibration"}.get(name, name), answer)
    except InputError as error:
        return f"outside physics: {error}"
    return next(_outside(answer), "")


def _refuse(word: str) -> float:
    raise ValueError(f"{word} in JSON")


def _outside(answer: Any, name: str = "") -> Iterator[str]:
    """Uncertainties below 0, and numbers of a plan that cannot be."""
    if isinstance(answer, dict):
        for key, one in answer.items():
            yield from _outside(one, key)
    elif isinstance(answer, list):
        for one in answer:
            yield from _outside(one, name)
    elif isinstance(answer, int | float) and not isinstance(answer, bool):
        if (name == "sigma" or name.endswith("_sigma")) and answer < 0:
            yield f"{name} = {answer}: below 0"
        if not 0 < answer <= PLAN.get(name, math.inf) and name in PLAN:
            yield f"{name} = {answer}: not in 0 to {PLAN[name]:g}"


def answer_of(result: Completed) -> str:
    """An answer without what it cost, to be compared with another."""
    if result.out.lstrip().startswith("{"):
        answer = json.loads(result.out)
        if "state_digest" in answer:
            return str(answer["state_digest"])
    return re.sub(r"[\d.]+ (min|s) of CPU|CPU.*", "", result.out)
