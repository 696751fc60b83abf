"""Words of the pages: spelt right, and the project's own where there is more than one."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.docs

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("**/*.md"))]
# Left out of the pages, and what is said in their place (docs/reference/notation.md).
OTHERS = {
    "anew": "again", "leeway": "skin", "roomier": "larger",
    "agitation": "normalised kinetic energy",
    "rubbed": "frictional dissipation", "booked": "accounted", "doubts": "warnings",
    "heat of a body": "dissipated energy",
}  # fmt: skip


def test_words_are_spelt_right():
    """codespell knows common misspellings; names and terms that look like one are in pyproject."""
    found = subprocess.run(
        [sys.executable, "-m", "codespell_lib", *PAGES],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert found.returncode == 0, found.stdout


def test_one_word_a_thing():
    said = [
        f"{page.relative_to(ROOT)}: {word!r}, say {OTHERS[word]!r}"
        for page in PAGES
        for word in OTHERS
        if re.search(rf"\b{word}\b", page.read_text(encoding="utf-8"), re.IGNORECASE)
    ]
    assert said == []
