"""Compare the shown results of two revisions: python tests/helpers/compare_results.py REVISION.

The old ones are those of a git revision (by default HEAD), the new ones lie in docs/results. Table
by table, kept columns must be equal to the last bit, the verdict on every claim the same, and no
number of a report may be gone; columns that are gone or new, and new numbers, are listed. Ends with
code 1 where anything differs.
"""

import argparse
import csv
import io
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parents[2]
RESULTS = Path("docs/results")
_VERDICT = re.compile(r"^(?:  )?(PASS|FAIL|----) ")
_AGREES = re.compile(r": (agrees|does not agree)(?=[: ])")  # of the displacement profiles, once
_NUMBER = re.compile(r"(?<![\w.])[+-]?\d[\d.]*(?:[eE][+-]?\d+)?")


def old(revision: str, path: Path) -> str | None:
    """A file of a revision; None where it has none."""
    words = ["git", "show", f"{revision}:{path.as_posix()}"]
    found = subprocess.run(words, cwd=ROOT, capture_output=True, check=False)
    return found.stdout.decode("utf-8") if found.returncode == 0 else None


def columns(text: str) -> dict[str, list[str]]:
    """The columns of a table as they are written: equal texts are equal bits."""
    rows = list(csv.reader(line for line in io.StringIO(text) if not line.startswith("#")))
    return {name: [row[k] for row in rows[1:]] for k, name in enumerate(rows[0])}


def body(text: str) -> list[str]:
    """The lines of a report below the head that says where it comes from."""
    return [line for line in text.splitlines() if not line.startswith("# ")]


def checks(text: str) -> list[str]:
    """PASS, FAIL or ---- of every check of a report, in its order."""
    found = []
    for line in body(text):
        if match := _VERDICT.match(line):
            found.append(match[1])
        elif match := _AGREES.search(line):
            found.append("PASS" if match[1] == "agrees" else "FAIL")
    return found


def claims(text: str) -> list[str]:
    """PASS, FAIL or ---- of every claim of a report, in its order.

    A claim with several checks, a line each below its sentence, fails where one does and is not
    known where one is not.
    """
    found: list[list[str]] = []
    for line in body(text):
        match = _VERDICT.match(line)
        if not line.startswith(" "):
            found.append([])
        if match:
            found[-1].append(match[1])
    return [_of_all(own) for own in found if own]


def _of_all(own: list[str]) -> str:
    return next((word for word in ("FAIL", "----") if word in own), "PASS")


def numbers(text: str) -> Counter[str]:
    """All numbers of a report with how often each stands there."""
    return Counter(number for line in body(text) for number in _NUMBER.findall(line))


def compare_tables(before: str, after: str) -> tuple[list[str], bool]:
    """Lines on the columns of a table, and whether what was kept is the same."""
    first, second = columns(before), columns(after)
    kept = [name for name in first if name in second]
    unlike = [name for name in kept if first[name] != second[name]]
    lines = [
        f"  {len(kept)} columns kept, {len(kept) - len(unlike)} equal to the last bit, "
        f"{len(next(iter(second.values())))} rows; {len(before):,} -> {len(after):,} bytes"
    ]
    for word, names in (
        ("DIFFER", unlike),
        ("dropped", [name for name in first if name not in second]),
        ("added", [name for name in second if name not in first]),
    ):
        if names:
            lines.append(f"  {word}: {', '.join(names)}")
    return lines, not unlike


def compare_reports(before: str, after: str) -> tuple[list[str], bool]:
    """Lines on a report, and whether its verdicts are the same and its numbers are all there."""
    same = claims(before) == claims(after) or checks(before) == checks(after)
    gone, new = numbers(before) - numbers(after), numbers(after) - numbers(before)
    count = ", ".join(f"{n} {word}" for word, n in sorted(Counter(claims(after)).items()))
    lines = [f"  verdicts {'equal' if same else 'DIFFER'}: {count or 'none'}; "
             f"numbers {'GONE' if gone else 'all there'}"]  # fmt: skip
    if gone or new:
        lines.append(f"  numbers gone: {dict(gone)}; new: {dict(new)}")
    if body(before) != body(after):
        lines.append(f"  words differ in {len(set(body(before)) ^ set(body(after)))} lines")
    return lines, same and not gone


def main() -> int:
    """Print the comparison; 1 where a kept column, a verdict or a number differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("revision", nargs="?", default="HEAD")
    revision = parser.parse_args().revision
    listed = subprocess.run(["git", "ls-tree", "-r", "--name-only", revision, str(RESULTS)],
                            cwd=ROOT, capture_output=True, check=True)  # fmt: skip
    paths = [Path(line) for line in listed.stdout.decode().splitlines()]
    alike = True
    for path in paths:
        compare = {".csv": compare_tables, ".txt": compare_reports}.get(path.suffix)
        before = old(revision, path) if compare else None
        if compare is None or before is None:
            continue
        new = ROOT / path
        if not new.is_file():
            print(f"{path}: GONE")
            alike = False
            continue
        lines, same = compare(before, new.read_text(encoding="utf-8"))
        alike &= same
        print("\n".join([f"{path}: {'same' if same else 'NOT THE SAME'}", *lines]))
    return 0 if alike else 1


if __name__ == "__main__":
    sys.exit(main())
