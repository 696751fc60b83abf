"""Pages with commands behind "$": these are run, and print what stands there.

In a folder with the project's `data` and `docs`. A block that follows "`NAME`:" is that file, a
diff is applied. Behind "$" stands a command and the others are lines that it prints, in their
order; "..." stands for what is left out. Words must be the same. Numbers of runs may be 10 % apart:
other processors round differently, so that a packing is another draw of its kind
(docs/runs/folders.md); printed in the same form they are compared one by one.
"""

import re
import shutil
import subprocess
from pathlib import Path

import pytest
from pages import PROGRAMS, plain_environment

from granulab.contact.files.datafile import data_root

pytestmark = pytest.mark.docs

DOCS = Path(__file__).parents[2] / "docs"
FIRST_CHANGE = "reference/first-change.md"
BEHIND_A_PROMPT = re.compile(rf"^\$ (?:{'|'.join(PROGRAMS)}) ", re.MULTILINE)
PAGES = [
    name
    for path in sorted(DOCS.glob("*/*.md"))
    if (name := path.relative_to(DOCS).as_posix()) != FIRST_CHANGE
    and BEHIND_A_PROMPT.search(path.read_text(encoding="utf-8"))
]
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
CLOSE = 0.1


def steps(text):
    """The files to write and the commands with the lines they print, in the order of a page."""
    found = []
    for before, kind, body in re.findall(r"([^\n]*)\n+```(\w+)\n(.*?)```", text, re.S):
        named = re.search(r"`([^`]+)`:$", before)
        if named and kind != "console":
            found.append(("file", named.group(1), body))
        elif kind == "diff":
            found.append(("file", "change.diff", body))
            found.append(("command", "git apply change.diff", []))
        elif kind == "console":
            one_line = re.sub(r"\s*\\\n\s*", " ", body)
            for part in re.split(r"^\$ ", one_line, flags=re.M)[1:]:
                command, _, printed = part.partition("\n")
                found.append(("command", command, printed.splitlines()))
    return found


def alike(shown, printed):
    """Whether a printed line is the one that is shown: the same words, numbers close by."""
    head = shown.removesuffix("...").split() if shown.endswith("...") else shown.split()
    words = printed.split()
    if not shown.endswith("...") and len(words) != len(head):
        return False
    return len(words) >= len(head) and all(map(same_word, head, words))


def same_word(shown, printed):
    if NUMBER.sub("#", shown) != NUMBER.sub("#", printed):
        return False
    pairs = zip(NUMBER.findall(shown), NUMBER.findall(printed), strict=True)
    return all(abs(float(a) - float(b)) <= CLOSE * abs(float(a)) for a, b in pairs)


def lacking(shown, output):
    """The first shown line that the output has not, after those before it; None: it has all."""
    lines = iter(output.splitlines())
    for line in shown:
        if line.strip() != "..." and not any(alike(line, one) for one in lines):
            return line
    return None


@pytest.mark.parametrize("page", PAGES)
def test_commands_of_a_page_print_what_stands_there(page, tmp_path):
    for name in ("data", "docs"):
        (tmp_path / name).symlink_to(DOCS.parent / name, target_is_directory=True)
    go_through(page, tmp_path)


def test_first_change_goes_as_it_stands(tmp_path):
    """In a copy of the tracked files, whose packages come first on the path."""
    if shutil.which("git") is None:
        pytest.skip("no git")
    names = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=DOCS.parent, capture_output=True, text=True, check=False,
    )  # fmt: skip
    if names.returncode or "pyproject.toml" not in names.stdout.split("\0"):
        pytest.skip("not a git checkout")
    for name in filter(None, names.stdout.split("\0")):
        if (DOCS.parent / name).is_file():
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(DOCS.parent / name, tmp_path / name)
    go_through(FIRST_CHANGE, tmp_path, PYTHONPATH=str(tmp_path))


def go_through(page, tmp_path, **environment):
    """Write the files of a page and run its commands in a folder; each prints its lines."""
    done = steps((DOCS / page).read_text(encoding="utf-8"))
    assert any(kind == "command" for kind, _, _ in done)
    for kind, what, content in done:
        if kind == "file":
            (tmp_path / what).write_text(content, encoding="utf-8")
            continue
        command = what.replace("DATA/", f"{data_root()}/")
        ended = subprocess.run(
            command, shell=True, cwd=tmp_path, capture_output=True, text=True, check=False,
            env=plain_environment() | environment,
        )  # fmt: skip
        refused = bool(content) and content[0].startswith(f"{what.split()[0]}: ")
        assert (ended.returncode == 2) is refused, f"{what}\n{ended.stdout}{ended.stderr}"
        assert ended.returncode in (0, 2), ended.stderr
        output = ended.stderr if refused else ended.stdout
        lost = lacking(content, output)
        assert lost is None, f"{what}\nlacks: {lost}\n{output}"


def test_a_line_is_found_by_its_words_and_close_numbers():
    assert alike("discharge time 1.040 s", "  discharge time   1.09 s")
    assert not alike("discharge time 1.040 s", "discharge time 1.2 s")
    assert not alike("discharge time 1.040 s", "discharge rate 1.040 s")
    assert not alike("605 of 605 out", "605 of 605 particles out")
    assert alike("friction 0.38; by ...", "friction 0.381; by me and others")
    assert lacking(["a 1", "...", "b 2"], "a 1\nx\nb 2") is None
    assert lacking(["b 2", "a 1"], "a 1\nb 2") == "a 1"
