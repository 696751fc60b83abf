"""Keys of a study file: what `init` writes of them, the docs say and a study may hold."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal

from granulab.campaign.sweeps.study import SCHEMA
from granulab.contact.files.casefile import Section, key
from granulab.contact.files.reference import commented_file

# What stands above the examples of [vary] in the study that `init` writes.
_VARIED = {
    "listed": "Listed values; keys that stand together take the same value.",
    "range": "A range, both ends included; log = true spaces by ratios.",
    "one": "One value for all.",
    "drawn": "Drawn values; sd (of the value itself) may be in % of the mean. Normal and lognormal "
    "are\ncut off at min and max where given.",
}


class StudyKeys(Section):
    """The keys of a study file, but for schema and [vary]."""

    name: str | None = key(
        None,
        "the folder of its table is called after it",
        example="mine",
        left_out="that of the file",
    )
    case: str | list[str] | None = key(
        None, "a preset, or a case file next to this one; or a list of them", example="A4"
    )
    seeds: int | list[int] = key(1, "how many: 1, 2, ...; or a list, such as [1, 4, 7]")
    combine: Literal["product", "zip"] = key(
        "product",
        'every value with every other; "zip": the k-th of each together; cases and seeds always go '
        "with all",
    )
    draw_seed: int = key(1, "of the distributions; another one draws other values")


def commented_study(
    values: Mapping[str, Any], varied: Mapping[str, Sequence[str]], *, package: str, note: str = ""
) -> str:
    """A study file with a comment on every key.

    values: of its own keys; varied: lines of [vary] by what they show, a key of _VARIED, those that
    begin with "# " as comments; package: whose cases it varies; note: on their units.
    """
    head = (
        "A study: cases, over the combinations of what stands in [vary], times seeds. Every key "
        "but schema and case may be left out. Quantities are texts with a unit; pure numbers have "
        f"none{note}."
    )
    lines = [f"# Any key of a case file (see {package} init), as section.key."]
    for shown, entries in varied.items():
        lines += [*(f"# {line}" for line in _VARIED[shown].split("\n")), *entries]
    return commented_file(StudyKeys, head, SCHEMA, values) + "\n[vary]\n" + "\n".join(lines) + "\n"
