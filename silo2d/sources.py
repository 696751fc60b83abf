"""Which sources these are, and a word where others made what a run takes up."""

import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path

from campaign.provenance import source_digest

SOURCES = [Path(__file__).parent, Path(__file__).parent.parent / "contact"]

Warn = Callable[[str], None]


def to_stderr(line: str) -> None:
    """A warning for a person."""
    print(f"warning: {line}", file=sys.stderr)


@cache
def own_sources() -> str:
    """The digest of these sources, which runs and packings keep."""
    return source_digest(SOURCES)


def check_sources(what: str, made: str | None, cure: str, warn: Warn) -> None:
    """Warn where `made`, a digest of sources, is not that of these."""
    if made != own_sources():
        warn(f"{what} by another version of the sources ({made}); {cure}")
