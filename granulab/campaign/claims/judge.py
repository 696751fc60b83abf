"""Verdicts on claims: passes, fails, or not known yet, with the numbers that decided.

A quantity is a registered function of a table's readings that gives items: rows with a `value`,
labels, and what else a rule or the words need. A claim that fits no rule names a function instead,
which gives the checks itself.
"""

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from granulab.campaign.claims.claim import Claim, Criterion
from granulab.campaign.claims.rules import RULES, Outcome, all_of, groups, select
from granulab.campaign.claims.wording import found_words, named

if TYPE_CHECKING:
    from pandas import DataFrame

_WORDS = {True: "PASS", False: "FAIL", None: "----"}


@dataclass(frozen=True)
class Check:
    """Verdict on ours (None: too few runs), what was found, and the name of the check."""

    holds: bool | None
    found: str  # "" where there is no run
    of: str = ""  # the count or curve that it was judged for; "" where it needs no name


@dataclass(frozen=True)
class Verdict:
    """A claim and our checks of it."""

    claim: Claim
    checks: Sequence[Check]

    @property
    def words(self) -> str:
        """The sentence of the source."""
        return self.claim.sentence

    @property
    def holds(self) -> bool | None:
        """Return whether all checks hold; see all_of."""
        return all_of([check.holds for check in self.checks])


class Quantities:
    """The functions of a table's readings that its claims name."""

    def __init__(self) -> None:
        self.quantities: dict[str, Callable[..., Any]] = {}
        self.functions: dict[str, Callable[..., Sequence[Check]]] = {}

    def quantity(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Register what gives items: dictionaries or a frame; `name` of a claim's `quantity`."""
        self.quantities[function.__name__] = function
        return function

    def function(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Register what judges a claim that fits no rule."""
        self.functions[function.__name__] = function
        return function

    def judge(self, claims: Sequence[Claim], readings: Any) -> list[Verdict]:
        """The verdicts on claims, from the readings that all quantities take."""
        known: dict[str, DataFrame] = {}

        def items(criterion: Criterion) -> "DataFrame":
            from pandas import DataFrame

            key = f"{criterion.quantity} {sorted(criterion.arguments.items())}"
            if key not in known:
                found = self.quantities[criterion.quantity](readings, **criterion.arguments)
                known[key] = DataFrame(found)
                if "value" in known[key]:
                    known[key] = known[key].astype({"value": float})
            return known[key]

        def checks(criterion: Criterion) -> Sequence[Check]:
            if criterion.function:
                return self.functions[criterion.function](readings, **criterion.arguments)
            return _checks(criterion, select(items(criterion), criterion.where))

        return [Verdict(c, [x for one in c.criteria for x in checks(one)]) for c in claims]

    def judge_each(
        self, claims: Sequence[Claim], readings: Mapping[str, Any]
    ) -> dict[str, list[Verdict]]:
        """The verdicts by each of several readings of the same runs, such as counts."""
        return {name: self.judge(claims, own) for name, own in readings.items()}


def _checks(criterion: Criterion, items: "DataFrame") -> list[Check]:
    """A check for each group that the criterion names, or one for all items."""
    if isinstance(criterion.each, Mapping):
        labels = [dict(zip(criterion.each, values, strict=True))
                  for values in itertools.product(*criterion.each.values())]  # fmt: skip
        parts = [(one, select(items, one)) for one in labels]
    elif criterion.each:
        parts = groups(items, criterion.each)
    else:
        parts = [({}, items)]
    if not parts:
        words = criterion.words
        return [Check(None, str(words.get("empty", "")), str(words.get("of_empty", "")))]
    return [_check(criterion, labels, own) for labels, own in parts]


def _check(criterion: Criterion, labels: dict[str, Any], items: "DataFrame") -> Check:
    limits = dict(criterion.rule)
    rule = RULES[limits.pop("name")]
    outcome = rule(items, **limits) if len(items) else Outcome(items, items, [])
    name = named(criterion.words, labels)
    return Check(outcome.holds, found_words(criterion.words, outcome, items), name)


def report_claims(verdicts: Sequence[Verdict]) -> str:
    """Return how many claims hold, then each with a line for what was found in every check."""
    holds = [one.holds for one in verdicts]
    unknown = holds.count(None)
    head = f"claims: {holds.count(True)} of {len(holds) - unknown} hold"
    if unknown:
        head += f", {unknown} cannot be judged yet ({_WORDS[None]})"
    return "\n".join([head, *(line for one in verdicts for line in _lines(one))])


def report_each(found: Mapping[str, Sequence[Verdict]]) -> str:
    """Return how many claims hold by each reading, and what decided on those that turn.

    A claim turns where it holds by one reading and fails by another.
    """
    counts = {name: [one.holds for one in own] for name, own in found.items()}
    heads = [
        f"{name} {holds.count(True)} of {len(holds) - holds.count(None)}"
        for name, holds in counts.items()
    ]
    claims = list(zip(*found.values(), strict=True))
    turning = [own for own in claims if {True, False} <= {one.holds for one in own}]
    lines = [f"claims that hold by each count: {', '.join(heads)}; {len(turning)} turn"]
    for own in turning:
        lines.append(f"  turns: {own[0].words}")
        width = max(map(len, found))
        for name, one in zip(found, own, strict=True):
            decided = "; ".join(check.found or "no run" for check in one.checks)
            lines.append(f"    {_WORDS[one.holds]}  {name:{width}}  {decided}")
    return "\n".join(lines)


def _lines(one: Verdict) -> list[str]:
    """The words, with the verdict in front where there is but one and it needs no name."""
    if len(one.checks) == 1 and not one.checks[0].of:
        return [f"{_WORDS[one.holds]}  {one.words}", f"      {one.checks[0].found or 'no run'}"]
    width = max(len(check.of) for check in one.checks)
    return [one.words, *(_named(check, width) for check in one.checks)]


def _named(check: Check, width: int) -> str:
    name = f"{check.of:{width}}  " if width else ""
    return f"  {_WORDS[check.holds]}  {name}{check.found or 'no run'}"
