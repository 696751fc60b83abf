"""Findings in words: the templates of a claim filled in with its numbers.

Templates are those of str.format over an item's columns, or over these:

    items                    all items by the template `item`, joined by `separator`
    n, passed, number        how many cases there are and how many hold; how many items
    least, largest, mean     of the items' values; least_item, largest_item: where
    case                     the cases by the template `case` (items: by `item`)
    case_...                 a column of the first case, such as case_first
    mean_...                 the mean of a column of the cases

`found` is written where a case was judged, `but` after it where one fails ({failed}: those that do,
the first `most` of them), `none` where items are too few to judge, `empty` without any. Numbers
take the format specifications of Python, "percent" and "signed" (of layout), and "+.0f %" for a
part in per cent.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from granulab.campaign.claims.rules import Outcome
from granulab.campaign.output.layout import percent, signed

if TYPE_CHECKING:
    from pandas import DataFrame


class Number(float):
    """A number that can be written as a part in per cent."""

    def __format__(self, spec: str) -> str:
        if spec in ("percent", "signed"):
            return {"percent": percent, "signed": signed}[spec](float(self))
        if spec.endswith(" %"):
            return f"{100 * float(self):{spec[:-2]}} %"
        return format(float(self), spec)


def named(words: Mapping[str, Any], labels: Mapping[str, Any]) -> str:
    """The name of a check, from its labels."""
    return _fill(words.get("of", ""), labels)


def found_words(words: Mapping[str, Any], outcome: Outcome, items: "DataFrame") -> str:
    """Return what decided a check; "" where nothing was there and no word is set for that."""
    if not len(items):
        return str(words.get("empty", ""))
    facts = _facts(words, outcome, items)
    if not outcome.verdicts:
        return _fill(words.get("none", ""), facts)
    text = _fill(words.get("found", "{items}"), facts)
    return text + (_fill(words.get("but", ""), facts) if facts["fails"] else "")


def _facts(words: Mapping[str, Any], outcome: Outcome, items: "DataFrame") -> dict[str, Any]:
    item = words.get("item", "")
    separator = words.get("separator", ", ")
    shown, cases = _records(outcome.items), _records(outcome.cases)
    failed = [c for c, v in zip(cases, outcome.verdicts, strict=False) if v is False]
    most = words.get("most", len(failed))
    case = words.get("case", item if outcome.cases is outcome.items else "")
    facts: dict[str, Any] = dict(_records(items.head(1))[0]) if len(items) else {}
    facts |= {
        "items": separator.join(_fill(item, one) for one in shown),
        "case": separator.join(_fill(case, one) for one in cases) if outcome.verdicts else "",
        "n": len(outcome.verdicts),
        "number": len(outcome.items),
        "passed": outcome.verdicts.count(True),
        "fails": len(failed),
        "failed": separator.join(_fill(case, one) for one in failed[:most])
        + (f"{separator.strip().replace(';', ',')} ..." if len(failed) > most else ""),
    }
    facts |= {f"case_{name}": value for name, value in (cases[0] if cases else {}).items()}
    for name in outcome.cases.select_dtypes("number"):
        facts[f"mean_{name}"] = Number(outcome.cases[name].mean())
    return facts | _extremes(item, outcome.items, shown)


def _extremes(item: str, items: "DataFrame", shown: list[dict[str, Any]]) -> dict[str, Any]:
    if not len(items) or not items["value"].notna().any():
        return {}
    values = items["value"].reset_index(drop=True)
    least, largest = int(values.idxmin()), int(values.idxmax())
    return {
        "least": Number(values[least]),
        "largest": Number(values[largest]),
        "mean": Number(values.mean()),
        "least_item": _fill(item, shown[least]),
        "largest_item": _fill(item, shown[largest]),
    }


def _records(items: "DataFrame") -> list[dict[str, Any]]:
    return [
        {str(k): Number(v) if isinstance(v, float) else v for k, v in one.items()}
        for one in items.to_dict("records")
    ]


def _fill(template: str, facts: Mapping[str, Any]) -> str:
    return template.format_map(dict(facts))
