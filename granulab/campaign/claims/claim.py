"""A claim of a source as data: what it says, of which quantity, by which rule it is judged.

The files are data/published/claims/*.toml. docs/reference/claims.md has the keys and the six rules.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from granulab.contact.files.datafile import data_root, read_toml

SCHEMA = 1


@dataclass(frozen=True)
class Criterion:
    """One check of a claim.

    quantity    name of a registered function of the table's rows, with what it takes
    where       the items that are looked at, by label: a value or a list of them
    each        labels of which every value has a check of its own, or {label: values}
    rule        name of one of granulab.campaign.claims.rules, with its limits
    function    instead of all these: a function for a claim that fits no rule
    words       templates: of (the name of the check), and those of granulab.campaign.claims.wording
    """

    quantity: str = ""
    arguments: Mapping[str, Any] = field(default_factory=dict)
    where: Mapping[str, Any] = field(default_factory=dict)
    each: Sequence[str] | Mapping[str, Sequence[Any]] = ()
    rule: Mapping[str, Any] = field(default_factory=dict)
    function: str = ""
    words: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Claim:
    """A sentence of a source and how it is judged.

    set_by    "source" where the limit is the source's own, "us" where we set it
    reason    why so, where we set it, or why it needs a function
    """

    id: str
    source: str
    sentence: str
    criteria: tuple[Criterion, ...]
    set_by: str
    reason: str = ""


@cache
def claims_of(table: str) -> tuple[Claim, ...]:
    """The claims about a table, in the order of its report."""
    path = data_root() / "published" / "claims" / f"{table}.toml"
    document = read_toml(path, "claims", SCHEMA)
    usual = document.get("words", {})
    return tuple(_claim(entry, document["source"], usual) for entry in document["claim"])


def _claim(entry: dict[str, Any], source: str, usual: dict[str, Any]) -> Claim:
    own = {key: entry[key] for key in ("id", "sentence", "set_by", "reason") if key in entry}
    shared = {k: v for k, v in entry.items() if k not in own and k not in ("source", "check")}
    words = usual | shared.pop("words", {})
    criteria = tuple(
        Criterion(**(shared | check | {"words": words | check.get("words", {})}))
        for check in entry.get("check", [{}])
    )
    return Claim(source=f"{source}, {entry['source']}", criteria=criteria, **own)
