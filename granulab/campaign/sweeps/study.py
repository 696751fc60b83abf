"""Study files: keys and series, and the list of combinations that it stands for; no physics.

A key is a word such as "law.kn" whose meaning the caller knows: it hands over a reader that
turns what is written for a key into a number (in SI) or a word.
"""

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from granulab.campaign.sweeps.series import SeriesError, series
from granulab.contact.files.datafile import toml_text
from granulab.contact.files.units import nearest
from granulab.errors import InputError

SCHEMA = 1
MAX_RUNS = 10_000  # more is taken for a slip
MAX_SEED = 2**63 - 1  # of a case too: what a table holds

Reader = Callable[[str, Any], Any]  # key and value as written -> number in SI, or a word


class StudyError(ValueError):
    """A study file that cannot be used; one line that says what would do."""


@dataclass(frozen=True)
class Study:
    """Cases times combinations times seeds."""

    name: str
    cases: tuple[str, ...]  # as written: presets or files
    combinations: tuple[dict[str, Any], ...]  # key -> value, in SI
    seeds: tuple[int, ...]
    draw_seed: int  # of the distributions
    text: str  # of the file
    drawn: frozenset[str] = frozenset()  # keys whose values come from a distribution


def read_study(path: str | Path, read: Reader) -> Study:
    """The study of a TOML file; StudyError, or what the reader raises, where it cannot be used."""
    path = Path(path)
    try:
        text, document = toml_text(path)
    except FileNotFoundError:
        raise StudyError(f"{path}: cannot be read (no such file); give a study file") from None
    except InputError as error:
        raise StudyError(str(error)) from None
    try:
        return _study(document, path.stem, text, read)
    except (StudyError, SeriesError) as error:
        raise StudyError(f"{path}: {error}") from None


def _study(document: dict[str, Any], stem: str, text: str, read: Reader) -> Study:
    from granulab.campaign.sweeps.study_keys import StudyKeys  # pydantic: --help needs it not
    from granulab.contact.files.casefile import folder_name

    known = ("schema", *StudyKeys.model_fields, "vary")
    unknown = next((key for key in document if key not in known), None)
    if unknown is not None:
        raise StudyError(f"unknown key {unknown!r}; {nearest(unknown, known)}")
    if document.get("schema") != SCHEMA or isinstance(document["schema"], bool):
        raise StudyError(f"schema must be {SCHEMA}; write schema = {SCHEMA} on the first line")
    name = document.get("name", stem)
    try:
        folder_name(name)
    except ValueError as error:
        raise StudyError(str(error)) from None
    draw_seed = document.get("draw_seed", 1)
    if not _is_seed(draw_seed):
        raise StudyError(f"draw_seed = {draw_seed!r}: must be an integer, 0 to {MAX_SEED}")
    cases, seeds = _cases(document.get("case")), _seeds(document.get("seeds", 1))
    vary = _axes(document.get("vary", {}))
    axes = [(keys, series(written, keys, read, draw_seed, MAX_RUNS)) for keys, written in vary]
    drawn = {
        key
        for keys, written in vary
        for key in keys
        if isinstance(written, dict) and "distribution" in written
    }
    _check_once(keys for keys, _ in axes)
    combinations = _combined(axes, document.get("combine", "product"), len(cases) * len(seeds))
    return Study(name, cases, tuple(combinations), seeds, draw_seed, text, frozenset(drawn))


def _axes(vary: Any) -> list[tuple[tuple[str, ...], Any]]:
    """Keys that take the same value, and what is written for them; by section or "section.key"."""
    if not isinstance(vary, dict):
        raise StudyError(f"vary = {vary!r}: must be a table, [vary]")
    axes = []
    for name, written in vary.items():
        if "." in name:
            axes.append((tuple(key.strip() for key in name.split(",")), written))
        elif isinstance(written, dict):
            axes += [((key,), values) for key, values in _below(name, written)]
        else:
            raise StudyError(f"[vary] {name}: write section.key, such as law.mu_wall")
    return axes


def _below(name: str, table: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """The keys of a table and of tables in it, which are no series: have other tables or lists."""
    for key, written in table.items():
        values = written.values() if isinstance(written, dict) else ()
        nested = any(isinstance(value, dict | list) for value in values)
        if nested and "distribution" not in written:
            yield from _below(f"{name}.{key}", written)
        else:
            yield f"{name}.{key}", written


def _check_once(axes: Iterable[tuple[str, ...]]) -> None:
    seen: set[str] = set()
    for key in itertools.chain.from_iterable(axes):
        if key == "run.seed":
            raise StudyError("[vary] run.seed: write seeds = 5, or a list, above [vary]")
        if key in seen:
            raise StudyError(f"[vary] {key}: stands there twice")
        seen.add(key)


def _combined(
    axes: Sequence[tuple[tuple[str, ...], list[Any]]], how: Any, times: int
) -> list[dict[str, Any]]:
    """All distinct combinations of the values of each axis, or the k-th of each together."""
    lengths = [len(values) for _, values in axes]
    if how not in ("product", "zip"):
        raise StudyError(f"combine = {how!r}: must be 'product' or 'zip'")
    if how == "zip":
        longest = max(lengths, default=1)
        odd = next((axis for axis in axes if len(axis[1]) not in (1, longest)), None)
        if odd is not None:
            raise StudyError(
                f"[vary] {', '.join(odd[0])}: {len(odd[1])} values, but another key has {longest};"
                " combine = 'zip' takes as many of each, or one"
            )
        total = longest
        axes = [(keys, vals * longest if len(vals) == 1 else vals) for keys, vals in axes]
    else:
        total = math.prod(lengths)
    if total * times > MAX_RUNS:
        parts = " x ".join(str(n) for n in ([total] if how == "zip" else lengths) if n > 1)
        raise StudyError(
            f"too many runs: {parts} combinations x {times} cases and seeds = {total * times:,}; "
            f"at most {MAX_RUNS:,} in one study"
        )
    values = [values for _, values in axes]
    together = how == "zip" and axes  # without axes there is one combination, of nothing
    picks = zip(*values, strict=True) if together else itertools.product(*values)
    combinations = (
        {key: value for (keys, _), value in zip(axes, pick, strict=True) for key in keys}
        for pick in picks
    )
    # A run that stands there twice would count twice in means over seeds.
    return list({repr(combination): combination for combination in combinations}.values())


def _cases(written: Any) -> tuple[str, ...]:
    cases = written if isinstance(written, list) else [written]
    if not cases or not all(isinstance(case, str) and case for case in cases):
        raise StudyError(f"case = {written!r}: write a preset or a case file, or a list of them")
    return tuple(dict.fromkeys(cases))


def _seeds(written: Any) -> tuple[int, ...]:
    """Seeds as listed, or 1 to a count."""
    if _is_count(written) and written > 0:
        return tuple(range(1, min(written, MAX_RUNS + 1) + 1))
    if isinstance(written, list) and written and all(map(_is_seed, written)):
        return tuple(dict.fromkeys(written))
    raise StudyError(
        f"seeds = {written!r}: write how many (seeds 1, 2, ...), or a list [1, 4, 7] of seeds 0 to "
        f"{MAX_SEED}"
    )


def _is_seed(value: Any) -> bool:
    return _is_count(value) and value <= MAX_SEED


def _is_count(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0
