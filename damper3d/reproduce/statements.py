"""What the thesis says in words about its figures, judged: passes, fails, or not known yet.

The thesis draws more than it prints. Each sentence is judged by rules that stand beside it, once,
or for each count or curve that it speaks of, and told with what decided.
"""

from collections.abc import Sequence
from dataclasses import dataclass

_WORDS = {True: "PASS", False: "FAIL", None: "----"}


@dataclass(frozen=True)
class Check:
    """Whether ours agrees (None: too few runs), and what was found."""

    holds: bool | None
    found: str  # "" where there is no run
    of: str = ""  # the count or curve that it was judged for; "" where it needs no name


@dataclass(frozen=True)
class Statement:
    """A sentence of the thesis and our checks of it."""

    words: str
    checks: Sequence[Check]

    @property
    def holds(self) -> bool | None:
        """Whether all checks hold; see all_of."""
        return all_of([check.holds for check in self.checks])


def all_of(verdicts: Sequence[bool | None]) -> bool | None:
    """False where one fails; None where one is not known, or where there is none."""
    if False in verdicts:
        return False
    return None if None in verdicts or not verdicts else True


def report_statements(statements: Sequence[Statement]) -> str:
    """How many hold, then each with a line for what was found in every check."""
    verdicts = [one.holds for one in statements]
    unknown = verdicts.count(None)
    head = f"statements: {verdicts.count(True)} of {len(verdicts) - unknown} hold"
    if unknown:
        head += f", {unknown} cannot be judged yet ({_WORDS[None]})"
    return "\n".join([head, *(line for one in statements for line in _lines(one))])


def _lines(one: Statement) -> list[str]:
    """The words, with the verdict in front where there is but one and it needs no name."""
    if len(one.checks) == 1 and not one.checks[0].of:
        return [f"{_WORDS[one.holds]}  {one.words}", f"      {one.checks[0].found or 'no run'}"]
    width = max(len(check.of) for check in one.checks)
    return [one.words, *(_named(check, width) for check in one.checks)]


def _named(check: Check, width: int) -> str:
    name = f"{check.of:{width}}  " if width else ""
    return f"  {_WORDS[check.holds]}  {name}{check.found or 'no run'}"
