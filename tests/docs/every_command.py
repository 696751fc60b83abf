"""Every command of the pages run once: how it ends, and after how long.

    python tests/docs/every_command.py [--only WORD]... [--write docs/results/commands.csv]

--only: those of pages whose name holds one of the words; the rows of the others stay.

The commands of a page run in their order in a folder of their own, which begins with one run of a
silo and one of a damper (for RUN), and links to data and docs; files that the page says to write
are there, and what its Python commands make. `end` is: done; planned, of many runs, with --dry-run;
left out, of a published table; refused (one line and exit code 2: mostly for a reader's own file);
longer than LIMIT; or failed, with the exit code, which makes that of this script 1.
"""

import argparse
import csv
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / name) for name in ("docs", "tests/docs", "tests/helpers")]
from pages import files_of, plain_environment  # noqa: E402
from test_commands_of_pages import PAGES, commands  # noqa: E402

COLUMNS = ("page", "command", "end", "lasts_s")
LIMIT = 60  # [s]
MANY = ("sweep", "clog", "map", "design", "field", "compress", "shear")  # runs of a command
FIRST = ("silo2d run A2 --no-figures", "damper3d run --cycles 5 --discard 2 --no-figures")


def run(words: list[str], folder: Path) -> tuple[str, float]:
    """How a command ends, and for how long it goes on [s]; with it end the processes it began."""
    environment = plain_environment() | {"OPENBLAS_NUM_THREADS": "1", "BROWSER": "true"}
    began = time.monotonic()
    with subprocess.Popen(
        words, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE, text=True, start_new_session=True,
    ) as process:  # fmt: skip
        try:
            said = process.communicate(timeout=LIMIT)[1]
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            return "longer", float(LIMIT)
    lasted = time.monotonic() - began
    if process.returncode == 0:
        return "done", lasted
    lines = said.strip().splitlines()
    if process.returncode == 2 and "Traceback" not in said and lines:
        return f"refused: {lines[-1].replace(f'{ROOT}/', '')}", lasted
    return f"failed: exit code {process.returncode}", lasted


def of_page(page: str, own: list[list[str]], begun: Path, folder: Path) -> list[dict]:
    """A row for each command of a page, run in a copy of the folder that was begun."""
    shutil.copytree(begun, folder, symlinks=True)
    text = (ROOT / page).read_text(encoding="utf-8")
    for name, content in files_of(text).items():
        (folder / name).write_text(content, encoding="utf-8")
    for command in re.findall(r"^\$ (python (?!-m pytest).*)$", text, re.MULTILINE):
        run(shlex.split(command), folder)
    rows = []
    for words in own:
        kind = "A2" if words[0] == "silo2d" else "thesis"
        first = min(folder.glob(f"runs/{kind}*"), key=lambda run: run.stat().st_mtime)
        own_words = [_there(word, first, folder) for word in words]
        planned = words[1:2] and words[1] in MANY and "--dry-run" not in words
        if words[1:2] == ["reproduce"] and len(words) > 2:
            end, lasted = "left out", 0.0
        else:
            end, lasted = run([*own_words, *(["--dry-run"] if planned else [])], folder)
        end = "planned" if planned and end == "done" else end
        command = shlex.join(words)
        rows.append({"page": page, "command": command, "end": end, "lasts_s": f"{lasted:.0f}"})
        print(f"{page}: {command}: {end}, {lasted:.1f} s", flush=True)
    return rows


def _there(word: str, first: Path, folder: Path) -> str:
    """A word of a command in a folder: RUN is its first run, a pattern the newest path."""
    if word == "RUN":
        return str(first)
    found = [path for path in folder.glob(word) if path.suffix != ".png"] if "*" in word else []
    if found:
        return str(max(found, key=lambda path: path.stat().st_mtime).relative_to(folder))
    return re.sub("^DATA/", "data/", word)


def of_other_pages(file: Path, pages: dict[str, list[list[str]]]) -> list[dict]:
    """Rows of a table that is there, of pages whose commands were not run this time."""
    if not file.exists():
        return []
    with file.open(encoding="utf-8", newline="") as there:
        return [row for row in csv.DictReader(there) if row["page"] not in pages]


def main() -> int:
    """Run them and write the table; 1 where one failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", action="append")
    parser.add_argument("--write", type=Path)
    options = parser.parse_args()
    pages: dict[str, list[list[str]]] = {}
    for page, words in commands():
        if (ROOT / page).is_file() and any(word in str(page) for word in options.only or [""]):
            pages.setdefault(str(page), []).append(words)
    rows, began = [], time.monotonic()
    with tempfile.TemporaryDirectory() as name:
        begun = Path(name) / "begun"
        begun.mkdir()
        for link in ("data", "docs"):
            (begun / link).symlink_to(ROOT / link)
        for command in FIRST:
            subprocess.run(
                [Path(sys.executable).parent / command.split()[0], *command.split()[1:]],
                cwd=begun, check=True, capture_output=True,
            )  # fmt: skip
        for k, (page, own) in enumerate(pages.items()):
            rows += of_page(page, own, begun, Path(name) / str(k))
            shutil.rmtree(Path(name) / str(k))
    if options.write:
        rows = sorted(of_other_pages(options.write, pages) + rows, key=lambda row: row["page"])
        with options.write.open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
    print(f"{len(rows)} commands of {len(PAGES)} pages, {time.monotonic() - began:.0f} s")
    return int(any(row["end"].startswith("failed") for row in rows))


if __name__ == "__main__":
    sys.exit(main())
