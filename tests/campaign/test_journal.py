"""The journal of a study, and that a sweep's cost for each run does not grow with their number."""

import dataclasses
import json
import shutil
import sys
from pathlib import Path

import pytest
from fake_simulator import FAKE, fake, fake_digest

from granulab.campaign.cli.library import packings_and_runs
from granulab.campaign.output.table import write_table
from granulab.campaign.runs import folder as folders
from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.provenance import Sources
from granulab.campaign.sweeps import engine
from granulab.campaign.sweeps.sweep import over_seeds, run_labelled

N = 4


@pytest.fixture
def sweep(tmp_path, in_this_process):
    """A sweep of four fake runs, that keeps a journal; once it has run."""

    def run(simulator=FAKE):
        cases = over_seeds({}, fake(2), range(N))
        return run_labelled(simulator, cases, out=tmp_path / "runs", journal=journal, quiet=True)

    journal = tmp_path / "runs.journal"
    run()
    return run


@pytest.fixture
def opened(monkeypatch, sweep):
    """Names of the run folders of which a file is opened from here on."""
    found = []

    def open_kept(path):
        found.append(path.parent.name)
        return real(path)

    real = folders.open_kept
    monkeypatch.setattr(folders, "open_kept", open_kept)
    return found


def run_folder(tmp_path, seed) -> RunFolder:
    (path,) = (tmp_path / "runs").glob(f"square-seed{seed}-*")
    return RunFolder(path)


def test_repeated_sweep_opens_no_run_folder_and_gives_the_same_rows(tmp_path, sweep, opened):
    rows = sweep()
    assert opened == []
    (tmp_path / "runs.journal").unlink()
    assert sweep() == rows
    assert set(opened) == {run_folder(tmp_path, seed).path.name for seed in range(N)}
    opened.clear()
    assert sweep() == rows  # what was read is in the journal by now
    assert opened == []


def test_repeated_sweep_looks_once_at_each_folder_and_summary(tmp_path, sweep, monkeypatch):
    """Also where the table is written, with the folders as seen from there."""
    looks = []
    real = Path.stat

    def stat(path, **options):
        if "square-seed" in str(path):
            looks.append(path.name.partition("-")[0])
        return real(path, **options)

    monkeypatch.setattr(Path, "stat", stat)
    monkeypatch.setattr("os.lstat", lambda path: stat(Path(path), follow_symlinks=False))
    write_table(tmp_path, sweep())
    assert looks == ["square", "summary.json"] * N


def test_summary_or_provenance_that_was_replaced_or_edited_is_read(tmp_path, sweep, opened):
    """The time of the folder tells a replaced file, that of the summary one edited in place."""
    run = run_folder(tmp_path, 0)
    run.write_provenance(run.read_provenance())
    edited = run_folder(tmp_path, 1).path / "summary.json"
    edited.write_bytes(edited.read_bytes() + b" ")
    opened.clear()
    sweep()
    assert set(opened) == {run.path.name, edited.parent.name}


@pytest.mark.parametrize("damage", ["torn", "changed"])
def test_line_that_is_torn_or_changed_does_not_count(tmp_path, sweep, opened, damage):
    """kill -9 tears the last one. The line that follows a torn one counts."""
    journal, rows = tmp_path / "runs.journal", sweep()
    text = journal.read_bytes()
    journal.write_bytes(text[:-9] if damage == "torn" else text.replace(b"seed3", b"seed4"))
    last = {run_folder(tmp_path, 3).path.name}
    assert sweep() == rows
    assert set(opened) == last
    opened.clear()
    assert sweep() == rows
    assert opened == []


def test_folder_that_was_changed_is_read_and_one_that_was_removed_run_again(tmp_path, sweep):
    changed = run_folder(tmp_path, 1)
    changed.write_summary({"square": 400})
    shutil.rmtree(run_folder(tmp_path, 2).path)
    rows = sweep()
    assert [row["square"] for row in rows] == [4, 400, 4, 4]
    assert [row["reused"] for row in rows] == [True, True, False, True]


def test_run_of_other_sources_is_in_no_journal_and_reported_each_time(
    tmp_path, sweep, opened, capsys
):
    changed = run_folder(tmp_path, 1)
    changed.write_provenance({"source_digest": "0" * 12})
    changed.write_summary({"square": 400})
    for _ in range(2):
        opened.clear()
        sweep()
        assert set(opened) == {changed.path.name}
        assert "1 of 4 runs and 0 of 1 packings were made by another" in capsys.readouterr().err


def test_journal_of_other_sources_does_not_count(tmp_path, sweep, opened):
    """Their results may have other fields."""
    journal = tmp_path / "runs.journal"
    lines = [line.partition(b" ")[2] for line in journal.read_bytes().splitlines()]
    assert json.loads(lines[0])[2] == [FAKE.sources.digest] * 2
    others = Sources(Path(engine.__file__).parent)
    sweep(dataclasses.replace(FAKE, made_by=lambda case: (FAKE.sources, others)))
    assert len(set(opened)) == N


def test_shared_packing_is_looked_at_once(tmp_path, sweep):
    looks = []
    asked = dataclasses.replace(
        FAKE, packing_from=lambda file: looks.append(file) or FAKE.packing_from(file)
    )
    (tmp_path / "runs.journal").unlink()
    sweep(asked)
    assert len(looks) == 1


def calls(work) -> int:
    """How many functions a work calls, of Python and of C."""
    count = 0

    def note(frame, event, argument):
        nonlocal count
        count += event in ("call", "c_call")

    sys.setprofile(note)
    try:
        work()
    finally:
        sys.setprofile(None)
    return count


# A cost a + b n has f(80) - f(40) = 2 (f(40) - f(20)). A fiftieth is left for the sorting of names;
# before the journal and the heap of tasks it was 1.03 for the runs, and 1.47 for the list.
def assert_linear(cost):
    assert cost[80] - cost[40] <= 1.02 * 2 * (cost[40] - cost[20])


def test_cost_of_a_run_does_not_grow_with_their_number(tmp_path, in_this_process, monkeypatch):
    """First when they are run, then when they are there, then in a list of them."""
    monkeypatch.setattr(engine, "_LOOK", 1e3)  # reports go by time, twice is enough
    first, again, listed = {}, {}, {}
    run_labelled(FAKE, [({}, fake(2))], out=tmp_path / "0", quiet=True)
    packings_and_runs(tmp_path / "0", "run", str)  # from here on all is imported
    for n in (20, 40, 80):
        out = tmp_path / str(n)
        cases = over_seeds({}, fake(3), range(n))

        def sweep(cases=cases, out=out):
            run_labelled(FAKE, cases, out=out, journal=out.with_suffix(".journal"), quiet=True)

        first[n], again[n] = calls(sweep), calls(sweep)
        for k, (_, case) in enumerate(cases):
            run = RunFolder(out / f"square-seed{k}-{fake_digest(case)}")
            run.write_case(f'schema = 1\nname = "square"\n[run]\nseed = {k}\n')
        listed[n] = calls(lambda out=out: packings_and_runs(out, "run", str, every=True))
    assert_linear(first)
    assert_linear(again)
    assert_linear(listed)
