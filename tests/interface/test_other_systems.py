"""Windows and macOS where Linux can check them: names, texts, calls that are not everywhere."""

import ast
import errno
import io
import ntpath
import os
import re
import shlex
import signal
import sys
from collections.abc import Iterator
from pathlib import Path, PurePosixPath, PureWindowsPath
from types import SimpleNamespace

import numpy as np
import pytest
from fake_tasks import on_ctrl_c

from granulab.campaign.output.table import _seen_from, as_csv
from granulab.campaign.runs import sharing
from granulab.campaign.runs.checkpoint import checkpoints, keep_checkpoint
from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.sweeps import engine, processes
from granulab.contact.files.casefile import folder_name
from silo2d.commands.main import main

ROOT = Path(__file__).parents[2]
PACKAGES = ("granulab", "silo2d", "damper3d", "calibration")
SHIPPED = (*PACKAGES, "benchmarks", "data", "docs", "tests")

# Names of Python's library that Windows lacks; what stands behind a guard is tested below.
NOT_ON_WINDOWS = {
    "os": {
        "fork", "forkpty", "getuid", "geteuid", "getgid", "getpgid", "setsid", "killpg", "mkfifo",
        "nice", "sched_getaffinity", "statvfs", "uname", "getloadavg", "wait", "chown",
        "O_NONBLOCK", "sysconf", "pread", "pwrite", "posix_fadvise", "sync",
    },
    "signal": {
        "pthread_sigmask", "SIGKILL", "SIGHUP", "SIGALRM", "SIGCHLD", "SIGUSR1", "alarm", "pause",
        "setitimer", "sigwait", "siginterrupt",
    },
    "cv2": {"imread", "imwrite"},  # there, but they find no path with letters such as ß
}  # fmt: skip
GUARDED = {"os.sched_getaffinity", "signal.pthread_sigmask"}
OPENS = ("open", "NamedTemporaryFile", "TemporaryFile", "fdopen")  # as files
NO_MODULES = {"fcntl", "resource", "pwd", "grp", "termios", "tty", "pty", "syslog", "readline"}


@pytest.fixture(scope="module")
def sources() -> dict[Path, str]:
    """The modules of the packages."""
    modules = (path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))
    return {path.relative_to(ROOT): path.read_text(encoding="utf-8") for path in modules}


@pytest.mark.parametrize(
    "name",
    ["CON", "nul", "Aux.toml", "com1", "LPT9.a.b", "lpt²", "prn .x", "a:b", 'a"b', "a<b", "a>b",
     "a|b", "why?", "all*", "end.", "end ", "a/b", "a\\b", "tab\tb"],
)  # fmt: skip
def test_names_that_windows_refuses_are_refused_everywhere(name):
    with pytest.raises(ValueError, match="the run folder is called after it"):
        folder_name(name)


@pytest.mark.parametrize("name", ["console", "com10", "v1.2", "with space", ".hidden", "Опыт-ß_1"])
def test_other_names_are_taken_as_they_are(name):
    assert folder_name(name) == name


def test_files_of_the_project_can_stand_on_windows_and_macos():
    """No two differ by case only, and none has a name that Windows refuses; kept runs included."""
    names = [
        path.relative_to(ROOT).as_posix()
        for folder in SHIPPED
        for path in (ROOT / folder).rglob("*")
        if "__pycache__" not in path.parts
    ]
    assert len({name.casefold() for name in names}) == len(names) > 500
    for part in {part for name in names for part in name.split("/")}:
        folder_name(part)


def _texts_that_lack_a_word(tree: ast.Module) -> Iterator[int]:
    """Lines of calls that open a text without its encoding, or write one without its newline."""
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call) or ast.unparse(node.func) == "os.open":
            continue
        name = getattr(node.func, "attr", getattr(node.func, "id", ""))
        words = [a.value for a in node.args if isinstance(a, ast.Constant)]
        mode = next((word for word in words if re.fullmatch(r"[rwxabt+]+", str(word))), "r")
        opens = name in OPENS and "b" not in mode
        given = {keyword.arg for keyword in node.keywords}
        if (opens or name in ("read_text", "write_text")) and "encoding" not in given:
            yield node.lineno
        writes = (opens and mode[0] in "wax") or name in ("write_text", "to_csv")
        if writes and not given & {"newline", "lineterminator"}:
            yield node.lineno


def test_texts_are_written_with_their_encoding_and_newline_and_read_with_their_encoding(sources):
    """Else Windows writes another alphabet and other ends of lines, and seals differ."""
    concerned = re.compile(rf"\b({'|'.join(OPENS)}|read_text|write_text|to_csv)\(")
    wrong = [
        f"{path}:{line}"
        for path, text in sources.items()
        if concerned.search(text)
        for line in _texts_that_lack_a_word(ast.parse(text))
    ]
    assert wrong == []


def test_calls_that_windows_lacks_stand_behind_a_guard(sources):
    """One that is new here is guarded, and tested without it as those below are."""
    calls = re.compile(rf"\b({'|'.join(NOT_ON_WINDOWS)})\.(\w+)\b")
    modules = re.compile(r"^\s*(?:import|from) (\w+)", re.MULTILINE)
    used = {match.groups() for text in sources.values() for match in calls.finditer(text)}
    assert {f"{m}.{name}" for m, name in used if name in NOT_ON_WINDOWS[m]} == GUARDED
    imported = {name for text in sources.values() for name in modules.findall(text)}
    assert "signal" in imported
    assert not imported & NO_MODULES


def test_workers_start_where_no_signals_can_be_kept_from_them(monkeypatch):
    """As on Windows; they then leave Ctrl-C, which a console sends to all, to who started them."""
    without = SimpleNamespace(SIGINT=signal.SIGINT, SIGTERM=signal.SIGTERM)
    monkeypatch.setattr(processes, "signal", without)
    (outcome,) = engine.run_tasks(on_ctrl_c, [None], workers=1)
    assert (outcome.state, outcome.value) == ("done", "ignored")


def test_cores_are_counted_where_the_system_has_no_affinity(monkeypatch):
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    assert sharing.cores() == os.cpu_count()


@pytest.mark.parametrize("code", [errno.ENOTSUP, errno.EPERM, errno.EMLINK])
def test_the_newest_checkpoint_is_kept_where_files_have_one_name_only(tmp_path, monkeypatch, code):
    def no_link(*_: object) -> None:
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(os, "link", no_link)
    run = RunFolder(tmp_path)
    for parts in (1, 2, 3):
        keep_checkpoint(run, parts, {"x": np.arange(3.0)}, {})
    assert checkpoints(run) == [run.checkpoint]


@pytest.mark.parametrize(
    ("platform", "path", "word"),
    [("linux", PurePosixPath("runs/a-1"), "runs/a-1"),
     ("darwin", PurePosixPath("my runs/it's Опыт"), "'my runs/it'\"'\"'s Опыт'"),
     ("win32", PureWindowsPath("C:/runs/a-1"), r"C:\runs\a-1"),
     ("win32", PureWindowsPath("C:/my runs/it's Опыт"), r'"C:\my runs\it' "'" r's Опыт"')],
)  # fmt: skip
def test_the_line_that_goes_on_is_quoted_as_the_shell_wants_it(monkeypatch, platform, path, word):
    monkeypatch.setattr(sys, "platform", platform)
    line = RunFolder(path).go_on("silo2d")
    assert line == f"silo2d run --resume {word}"
    if platform != "win32":
        assert shlex.split(line)[-1] == str(path)


@pytest.mark.parametrize(
    ("folder", "path", "seen"),
    [(PurePosixPath("/w/studies/s"), PurePosixPath("/w/a b-1"), "../../a b-1"),
     (PurePosixPath("/w"), PurePosixPath("/w/a"), "a"),
     (PureWindowsPath("C:/w/studies/s"), PureWindowsPath("C:/w/Опыт-1"), "../../Опыт-1"),
     (PureWindowsPath("C:/w/studies"), PureWindowsPath("D:/runs/a-1"), "D:/runs/a-1")],
)  # fmt: skip
def test_run_folders_in_tables_have_slashes_and_may_be_on_another_drive(folder, path, seen):
    assert _seen_from(folder, path) == seen
    if path.drive == folder.drive:
        joined = ntpath if isinstance(path, PureWindowsPath) else os.path
        assert type(path)(joined.normpath(folder / seen)) == path


def test_tables_have_the_same_bytes_where_lines_end_otherwise(monkeypatch):
    rows = [{"name": "Опыт", "x": 1.5}, {"name": "b", "x": None}]
    here = as_csv(rows)
    monkeypatch.setattr(os, "linesep", "\r\n")
    assert as_csv(rows) == here == "name,x\nОпыт,1.5\nb,\n"


def test_words_that_the_alphabet_of_stdout_lacks_are_printed_escaped(tmp_path, monkeypatch):
    """Into a file or pipe Windows writes the alphabet of its country, here of western Europe."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["silo2d", "init", "größer Ж.toml"])
    said = io.TextIOWrapper(io.BytesIO(), encoding="cp1252", newline="\n")
    monkeypatch.setattr(sys, "stdout", said)
    main()
    assert (tmp_path / "größer Ж.toml").is_file()
    assert "größer \\u0416.toml" in said.buffer.getvalue().decode("cp1252")
