"""The notebooks of the documentation: executed as they stand, their assertions hold; and progress.

Each is executed by a kernel in an empty folder. What a kernel shows of a run's progress, and how it
answers an interrupt, is tested with a kernel too.
"""

import re
import time
from pathlib import Path
from queue import Empty

import pytest

pytest.importorskip("nbclient", reason="comes with the extra docs")

import nbformat
from jupyter_client.manager import start_new_kernel
from nbclient import NotebookClient

pytestmark = pytest.mark.docs

NOTEBOOKS = Path(__file__).parents[2] / "docs" / "notebooks"
NAMES = ["damper", "laboratory", "silo"]
LENGTH = {"code": 100, "markdown": 120}  # of a line: that of the code, and of the pages
MOST_PROGRESS = 6  # outputs of a notebook that were a line of progress: one a run, map or sweep
SOON = 5.0  # [s] a second on a machine that is not busy


@pytest.fixture(autouse=True)
def _own_files(tmp_path, monkeypatch):
    """Keep a kernel's history and connection out of the home folder."""
    for name in ("IPYTHONDIR", "JUPYTER_RUNTIME_DIR", "JUPYTER_DATA_DIR"):
        monkeypatch.setenv(name, str(tmp_path / name))
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")


def read(name):
    return nbformat.read(NOTEBOOKS / f"{name}.ipynb", as_version=4)


def test_every_notebook_is_executed():
    assert sorted(path.stem for path in NOTEBOOKS.glob("*.ipynb")) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_a_notebook_is_kept_without_outputs_and_opens_and_ends_as_all(name):
    book = read(name)
    nbformat.validate(book)
    assert set(book.metadata) == {"kernelspec", "language_info"}
    assert book.metadata.kernelspec.name == "python3"
    first, *_, last = book.cells
    assert re.match(r"# .+\n\nThis notebook shows ", first.source)
    assert last.source.startswith("## What could go wrong\n")
    code = [cell for cell in book.cells if cell.cell_type == "code"]
    assert not any(cell.outputs or cell.execution_count for cell in code)
    assert sum(cell.source.count("assert ") for cell in code) >= 2
    ids = [cell.id for cell in book.cells]
    assert len(set(ids)) == len(ids)
    long = [
        line
        for cell in book.cells
        for line in cell.source.splitlines()
        if len(line) > LENGTH[cell.cell_type]
    ]
    assert not long


@pytest.mark.parametrize("name", NAMES)
def test_a_notebook_runs_and_its_assertions_hold(name, tmp_path):
    """A cell that raises ends the test with its traceback; lines of progress have vanished."""
    book = read(name)
    where = {"metadata": {"path": str(tmp_path / "work")}}
    NotebookClient(book, timeout=900, kernel_name="python3", resources=where).execute()
    outputs = [one for cell in book.cells if cell.cell_type == "code" for one in cell.outputs]
    gone = [one for one in outputs if one.get("data", {}).get("text/html") == ""]
    assert 0 < len(gone) <= MOST_PROGRESS
    assert "<progress" not in str(outputs)
    shown = [one.text for one in outputs if one.output_type == "stream" and one.name == "stderr"]
    assert not re.search(r"\d%", "".join(shown))


@pytest.fixture
def kernel(tmp_path):
    """A kernel in an empty folder, and the client that speaks with it."""
    manager, client = start_new_kernel(kernel_name="python3", cwd=str(tmp_path / "work"))
    yield manager, client
    client.stop_channels()
    manager.shutdown_kernel(now=True)
    manager.cleanup_resources()


def messages(client, code):
    """Kind and content of what a kernel publishes while it executes some code."""
    number = client.execute(code)
    while True:
        try:
            message = client.get_iopub_msg(timeout=60)
        except Empty:
            pytest.fail("the kernel is silent")
        if message["parent_header"].get("msg_id") == number:
            yield message["msg_type"], message["content"]
            if message["content"].get("execution_state") == "idle":
                return


RUN = """
from silo2d import SiloCase, run
run(SiloCase.load("A4", {"silo.outlet": "60 mm"})).outcome
"""


def test_a_kernel_shows_one_line_that_goes_on_and_answers_an_interrupt(kernel):
    """Interrupted in the discharge, it answers soon and the same call goes on, and finishes."""
    manager, client = kernel
    parts, error, sent = [], None, None
    displays = set()
    for kind, content in messages(client, RUN):
        if kind in ("display_data", "update_display_data"):
            displays.add(content["transient"]["display_id"])
            found = re.search(r": (\d+)% (.*)", content["data"]["text/plain"])
            if found:
                parts.append(int(found[1]))
            if found and found[2].startswith("discharging") and sent is None:
                sent = time.monotonic()
                manager.interrupt_kernel()
        elif kind == "error":
            error = content
        assert kind != "stream" or "%" not in content["text"]
    assert error["ename"] == "KeyboardInterrupt"
    assert "go on with: silo2d run --resume" in error["evalue"]
    assert time.monotonic() - sent < SOON
    assert len(displays) == 1
    assert parts == sorted(parts)
    assert len(parts) > 3
    results = [content["data"] for kind, content in messages(client, RUN) if "result" in kind]
    assert results == [{"text/plain": "'clogged'"}]
