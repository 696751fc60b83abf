"""What the thesis says in words about its figures, checked: passes, fails, or not known yet."""

from collections.abc import Sequence
from typing import NamedTuple

WORDS = {True: "PASS", False: "FAIL", None: "----"}


class Statement(NamedTuple):
    """A finding of the thesis, whether ours agrees (None: too few runs), and what was found."""

    words: str
    holds: bool | None
    found: str


def all_of(verdicts: Sequence[bool]) -> bool | None:
    """Whether all hold; None where there is none."""
    return all(verdicts) if verdicts else None


def report_statements(statements: Sequence[Statement]) -> str:
    """A line for each, and one for what was found; how many hold in front."""
    known = [one for one in statements if one.holds is not None]
    head = f"statements: {sum(bool(one.holds) for one in known)} of {len(known)} hold"
    if len(known) < len(statements):
        head += f", {len(statements) - len(known)} cannot be judged yet (----)"
    lines = [
        line
        for one in statements
        for line in (f"{WORDS[one.holds]}  {one.words}", f"      {one.found or 'no run'}")
    ]
    return "\n".join([head, *lines])
