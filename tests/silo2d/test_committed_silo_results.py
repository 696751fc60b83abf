"""The results that are shown are kept with their command; a small part is computed again here."""

from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from compare_results import checks, claims, numbers

from granulab.campaign.output.results import read_results
from granulab.campaign.output.statistics import mean_sd
from silo2d import SiloCase, run
from silo2d.measures.clogging.study import study
from silo2d.reproduce import TABLES, find
from silo2d.run.pour import pour
from silo2d.view.clogging.words import in_words

RESULTS = Path(__file__).parents[2] / "docs" / "results" / "silo2d"

# Table: how many lines it has, and at least how many seeds a line.
WHOLE = {"discharge": (16, 5), "clogging": (12, 20), "sensitivity": (68, 3)}


def committed(table):
    return read_results(RESULTS / f"reproduce-{table}.csv")


@pytest.mark.parametrize("table", WHOLE)
def test_committed_results_are_whole(table):
    """Every line with all its seeds, none failed, and the command that made them on top."""
    head, rows = committed(table)
    lines, seeds = WHOLE[table]
    labels = ("baseline", "parameter", "pairs", "value") if table == "sensitivity" else ("silo",)
    counts = Counter(tuple(row[k] for k in labels) for row in rows if row["state"] == "done")
    assert len(counts) == lines
    assert min(counts.values()) >= seeds
    assert head["command"].startswith(f"silo2d reproduce {table} --seeds ")


@pytest.mark.parametrize("table", TABLES)
def test_committed_numbers_are_what_the_rows_say(table):
    """The report is made again from the rows: the same verdict on each claim, the same numbers."""
    _, rows = committed(table)
    text = (RESULTS / f"reproduce-{table}.txt").read_text(encoding="utf-8")
    again = find(table).report(rows)
    assert claims(again) == claims(text)
    assert checks(again) == checks(text)
    assert numbers(again) == numbers(text)


CLOGGING = sorted(RESULTS.glob("clogging*/clog-*.csv"))


@pytest.mark.parametrize("table", CLOGGING, ids=lambda path: path.stem)
def test_committed_clogging_is_what_its_avalanches_say(table):
    """The report is made again from the avalanches; rest_time is that of a case without its own."""
    head, rows = read_results(table)
    text = table.with_suffix(".txt").read_text(encoding="utf-8")
    again = in_words(study(rows, SiloCase.load("D3").settings.run.rest_time))
    assert head["command"].startswith("silo2d clog ")
    assert {row["state"] for row in rows} == {"done"}
    assert numbers(again) == numbers(text)


@pytest.fixture(scope="module")
def a4() -> list[dict[str, Any]]:
    """Committed runs of A4, which emptied."""
    _, rows = committed("discharge")
    known = [row for row in rows if row["silo"] == "A4" and row["state"] == "done"]
    assert {row["outcome"] for row in known} == {"empty"}
    return known


def is_one_of(value: float, kind: list[float]) -> bool:
    """Whether a value may be one more of its kind.

    The bits are the same only on the same type of processor with the same versions; elsewhere a
    last digit makes it another draw of the same kind. One more value lies within
    t s sqrt(1 + 1/n) of the mean of n; t for 99 %, so that one machine in a hundred complains.
    """
    from scipy.stats import t

    kept = mean_sd(kind)
    assert kept.mean is not None
    assert kept.sd is not None
    allowed = t.ppf(0.995, kept.n - 1) * kept.sd * (1 + 1 / kept.n) ** 0.5
    return abs(value - kept.mean) <= allowed


def test_a4_filled_again_is_packed_as_committed(a4):
    found = pour(SiloCase.load("A4"), 1, lambda *_: None)
    assert is_one_of(found.fraction, [row["packing_fraction"] for row in a4])


@pytest.mark.validation
def test_a4_computed_again_is_one_of_its_committed_kind(a4, tmp_path):
    """Seed 1 of A4 empties as committed, its T90 within the spread from seed to seed."""
    found = run(SiloCase.load("A4", {"run.seed": 1}), out=tmp_path)
    assert found.outcome == "empty"
    for key in ("t90_s", "packing_fraction"):
        assert is_one_of(getattr(found, key), [row[key] for row in a4]), key
