"""Test files of all folders have names of their own: pytest imports them side by side."""

from collections import Counter
from pathlib import Path


def test_no_two_test_files_have_the_same_name():
    """But for conftest.py, which pytest finds by its folder."""
    names = Counter(path.name for path in Path(__file__).parents[1].rglob("*.py"))
    assert [n for n, count in names.items() if count > 1 and n != "conftest.py"] == []
