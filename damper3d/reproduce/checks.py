"""Statements of the thesis that are judged several times: for each count, or for each curve.

The thesis draws more than it prints. What it says of a drawing is judged here, by a rule that
stands beside it, and told with the number that decided.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from damper3d.reproduce.statements import WORDS


@dataclass(frozen=True)
class Check:
    """Whether a statement holds for one way of counting, or one curve; None: too little to say."""

    of: str  # what it was judged for; "" where there is one only
    holds: bool | None
    numbers: str


@dataclass(frozen=True)
class Judged:
    """A sentence of the thesis with its place, and our checks of it."""

    words: str
    checks: list[Check]


def above(of: str, named: Iterable[tuple[str, float]], limit: float) -> Check:
    """Whether all of some parts, each with its name, are above a limit.

    Told are the least and the mean, and how many are not.
    """
    values = sorted((value, name) for name, value in named)
    if not values:
        return Check(of, None, "no run there")
    low = [value for value, _ in values if value <= limit]
    mean = sum(value for value, _ in values) / len(values)
    least, where = values[0]
    numbers = f"least {_percent(least)} ({where}), mean {_percent(mean)} of {len(values)} points"
    if low:
        numbers += f"; {len(low)} not above {_percent(limit)}"
    return Check(of, not low, numbers)


def as_text(statements: Sequence[Judged]) -> str:
    """How many checks hold, then a paragraph a statement: its words, and a line a check."""
    verdicts = [check.holds for statement in statements for check in statement.checks]
    known = [holds for holds in verdicts if holds is not None]
    head = f"checks of the thesis's statements: {sum(known)} of {len(known)} hold"
    if len(known) < len(verdicts):
        head += f", {len(verdicts) - len(known)} cannot be judged yet ({WORDS[None]})"
    parts = [head]
    for statement in statements:
        width = max((len(check.of) for check in statement.checks), default=0)
        lines = [
            f"  {WORDS[check.holds]}  {f'{check.of:{width}}  ' if width else ''}{check.numbers}"
            for check in statement.checks
        ]
        parts.append("\n".join([statement.words, *lines]))
    return "\n".join(parts)


def _percent(part: float) -> str:
    return f"{100 * part:.0f} %"
