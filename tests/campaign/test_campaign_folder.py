"""The run folder: names, states, the lock, refusals, and files that are whole or absent."""

import math
import os
import resource
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from granulab.campaign.cli.library import packings_and_runs, write_output
from granulab.campaign.output.files import write_atomic
from granulab.campaign.runs.folder import SCHEMA, RunFolder, digest, open_run, resume_run
from granulab.campaign.runs.verify import verify
from granulab.errors import FolderError


def one_line(error: pytest.ExceptionInfo, *words: str) -> None:
    """A message for the command line: one line that holds the words."""
    text = str(error.value)
    assert "\n" not in text
    for word in words:
        assert word in text


def begun(run: RunFolder) -> RunFolder:
    run.write_case("schema = 1\n")
    return run


def finished(run: RunFolder) -> RunFolder:
    begun(run).write_summary({"n_out": 3})
    return run


@given(st.dictionaries(st.text(max_size=5), st.floats(allow_nan=False), min_size=1))
def test_digest_sees_every_bit_and_no_order(case):
    """Two cases share a folder exactly when their numbers agree to the last bit."""
    backwards = dict(reversed(case.items()))
    assert digest(case) == digest(backwards)
    key = next(iter(case))
    nudged = {**case, key: math.nextafter(case[key], 0.0 if case[key] else 1.0)}
    assert digest(case) != digest(nudged)


def test_digest_is_twelve_hex_digits_and_stays():
    """The name of a folder must not change from one Python to the next.

    The digits are those of sha256sum over {"a":0.1,"b":[1,2]}.
    """
    assert digest({"b": [1, 2], "a": 0.1}) == "deb925af18b3"
    assert digest({"b": np.array([1, 2]), "a": np.float64(0.1)}) == "deb925af18b3"


def test_states_of_a_run(tmp_path):
    """new -> unfinished at its case -> finished at its summary."""
    run = open_run(tmp_path / "runs", "A4", "0123456789ab")
    assert run.path == tmp_path / "runs" / "A4-0123456789ab"
    assert run.state == "new"
    assert begun(run).state == "unfinished"
    run.write_summary({"n_out": 3, "rate": np.float64(0.1), "t90_s": None})
    assert run.state == "finished"
    assert run.read_summary() == {"n_out": 3, "rate": 0.1, "t90_s": None}
    assert run.read_case() == "schema = 1\n"
    assert resume_run(run.path) == run


def test_again_leaves_begun_runs_alone(tmp_path):
    """--again computes in a new folder; without it the newest finished result counts."""
    base = begun(open_run(tmp_path, "A4", "d"))
    assert open_run(tmp_path, "A4", "d") == base
    second = open_run(tmp_path, "A4", "d", again=True)
    assert second.path.name == "A4-d-2"
    begun(second)
    assert open_run(tmp_path, "A4", "d") == second
    finished(base)
    assert open_run(tmp_path, "A4", "d") == base
    finished(second)
    assert open_run(tmp_path, "A4", "d") == second
    assert open_run(tmp_path, "A4", "d", again=True).path.name == "A4-d-3"


def test_nan_is_no_result(tmp_path):
    """A value that does not exist is null; NaN is no JSON and nothing of it may stay."""
    run = begun(open_run(tmp_path, "A4", "d"))
    with pytest.raises(ValueError, match="not JSON compliant"):
        run.write_summary({"rate": math.nan})
    assert run.state == "unfinished"


@pytest.mark.parametrize("text", ["", '{"schema": 1', "[]", "null", '{"n_out": 3}', '"schema"'])
def test_damaged_summary_is_refused_in_one_line(tmp_path, text):
    run = begun(open_run(tmp_path, "A4", "d"))
    (run.path / "summary.json").write_text(text)
    with pytest.raises(FolderError) as error:
        run.read_summary()
    one_line(error, "summary.json", "damaged", "--again")


def test_damaged_bytes_and_missing_files_are_refused_in_one_line(tmp_path):
    run = begun(open_run(tmp_path, "A4", "d"))
    with pytest.raises(FolderError) as error:
        run.read_provenance()
    one_line(error, "provenance.json", "No such file")
    (run.path / "provenance.json").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FolderError) as error:
        run.read_provenance()
    one_line(error, "provenance.json", "UTF-8")


def test_unknown_schema_is_refused_in_one_line(tmp_path):
    run = begun(open_run(tmp_path, "A4", "d"))
    (run.path / "provenance.json").write_text(f'{{"schema": {SCHEMA + 1}, "seed": 1}}')
    with pytest.raises(FolderError) as error:
        run.read_provenance()
    one_line(error, "provenance.json", f"schema {SCHEMA + 1}", f"reads {SCHEMA}")


def test_resume_needs_a_run_folder(tmp_path):
    with pytest.raises(FolderError) as error:
        resume_run(tmp_path)
    one_line(error, str(tmp_path), "case.toml")


def test_root_that_cannot_be_made_is_refused_in_one_line(tmp_path):
    """A regular file in the path, as even root cannot make a folder below one."""
    (tmp_path / "notes").write_text("")
    with pytest.raises(FolderError) as error:
        open_run(tmp_path / "notes" / "runs", "A4", "d")
    one_line(error, "notes", "Not a directory", "--out")
    with pytest.raises(FolderError) as error:
        write_atomic(tmp_path / "missing" / "x.json", "")
    one_line(error, "x.json", "No such file", "--out")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_folder_without_permission_is_refused_in_one_line(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(FolderError) as error:
        open_run(tmp_path, "A4", "d")
    one_line(error, "Permission denied", "--out")


def test_name_cannot_leave_the_root(tmp_path):
    with pytest.raises(FolderError) as error:
        open_run(tmp_path, "../A4", "d")
    one_line(error, "'../A4'", "slashes")


def test_full_disk_keeps_the_old_file(tmp_path):
    """A write that breaks off (here at a file size limit) leaves the old file and no rest."""
    path = tmp_path / "summary.json"
    write_atomic(path, "old")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limits[1]))
    try:
        with pytest.raises(FolderError) as error:
            write_atomic(path, bytes(5000))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    one_line(error, "summary.json", "make room")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


_HOLDER = """
import sys
from pathlib import Path
from granulab.campaign.runs.folder import RunFolder
with RunFolder(Path(sys.argv[1])).lock():
    print("held", flush=True)
    sys.stdin.read()
"""


def test_lock_keeps_others_off_and_ends_with_a_killed_holder(tmp_path):
    """The lock belongs to the process: after SIGKILL nothing has to be cleared away."""
    run = begun(open_run(tmp_path, "A4", "d"))
    command = [sys.executable, "-c", _HOLDER, str(run.path)]
    pipe = subprocess.PIPE
    with subprocess.Popen(
        command, stdin=pipe, stdout=pipe, cwd=Path(__file__).parents[2]
    ) as holder:
        assert holder.stdout.readline() == b"held\n"
        with pytest.raises(FolderError) as error, run.lock():
            pass
        one_line(error, str(run.path), "another process", "--again")
        holder.send_signal(signal.SIGKILL)
        holder.wait()
    with run.lock():
        pass


def test_a_lock_that_is_a_link_empties_no_file_elsewhere(tmp_path):
    """As a stranger's run folder may hold one."""
    other, run = tmp_path / "other", RunFolder(tmp_path / "run")
    other.write_text("precious")
    run.path.mkdir()
    (run.path / ".lock").symlink_to(other)
    with pytest.raises(FolderError), run.lock():
        pass
    assert other.read_text() == "precious"


@pytest.mark.parametrize("name", ["figures", "export"])
def test_pictures_and_exports_replace_no_file_where_a_run_s_link_leads(tmp_path, name):
    outside, run = tmp_path / "outside", tmp_path / "run"
    outside.mkdir()
    run.mkdir()
    (outside / "a.csv").write_text("precious")
    (run / name).symlink_to(outside)
    write_output(run / name / "b.csv", b"")  # of no run: where a person wants it
    (run / "case.toml").touch()
    with pytest.raises(FolderError, match=f"{name}: a link that leads out.*; remove it"):
        write_output(run / name / "a.csv", b"")
    assert (outside / "a.csv").read_text() == "precious"


def test_lock_is_given_back_after_an_error(tmp_path):
    run = begun(open_run(tmp_path, "A4", "d"))
    with pytest.raises(ZeroDivisionError), run.lock():
        raise ZeroDivisionError
    with run.lock(), pytest.raises(FolderError), run.lock():
        pass


def test_holder_clears_what_a_killed_writer_left(tmp_path):
    run = begun(open_run(tmp_path, "A4", "d"))
    (run.path / "parts").mkdir()
    rests = [run.path / ".summary.json.0a1b2c3d.tmp", run.path / "parts" / ".00000.h5.00ff.tmp"]
    for rest in rests:
        rest.write_bytes(b"half")
    with run.lock():
        assert not any(rest.exists() for rest in rests)
    assert run.read_case() == "schema = 1\n"


@pytest.mark.parametrize("name", ["figures", "export"])
def test_holder_leaves_alone_what_another_process_draws_or_exports_now(tmp_path, name):
    """These take no lock; what is older than an hour nobody writes any more."""
    run = begun(open_run(tmp_path, "A4", "d"))
    (run.path / name).mkdir()
    now, long_ago = (run.path / name / f".{word}.png.0a1b2c3d.tmp" for word in ("now", "old"))
    for rest in (now, long_ago):
        rest.write_bytes(b"half")
    os.utime(long_ago, (0, 0))
    with run.lock():
        assert now.exists()
        assert not long_ago.exists()


@pytest.mark.parametrize("look", [verify, lambda root: packings_and_runs(root, "silo", str)])
def test_parts_that_go_while_somebody_looks_are_no_error(tmp_path, monkeypatch, look):
    """As of a run that ends: its parts are there when their folder is listed, and then not."""
    run = open_run(tmp_path, "A4", "d")
    run.write_case('[silo]\npreset = "A4"\n')
    parts, scandir = run.path / "parts", os.scandir
    parts.mkdir()
    (parts / "00000.h5").touch()

    def scan(path):
        if str(path) == str(parts):
            shutil.rmtree(parts, ignore_errors=True)
        return scandir(path)

    monkeypatch.setattr(os, "scandir", scan)
    look(tmp_path)
    assert not parts.exists()


def test_folder_module_is_light():
    """silo2d --help must come at once, so neither h5py nor rich nor numpy may load with it."""
    code = (
        "import sys, granulab.campaign as campaign, granulab.campaign.runs.folder\n"
        "print(sorted({'h5py', 'rich', 'numpy', 'filelock'} & set(sys.modules)))\n"
        "assert campaign.TrajectoryWriter.__name__ == 'TrajectoryWriter'"
    )
    shown = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, cwd=Path(__file__).parents[2], check=True
    )
    assert shown.stdout.strip() == b"[]"
