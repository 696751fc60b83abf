"""Which sources a simulator is made of, and a word where others made what a run takes up."""

import sys
from collections.abc import Callable
from functools import cached_property
from pathlib import Path

from campaign.provenance import source_digest

Warn = Callable[[str], None]


def to_stderr(line: str) -> None:
    """A warning for a person."""
    print(f"warning: {line}", file=sys.stderr)


class Sources:
    """The package folders that decide what a run computes; runs and packings keep their digest."""

    def __init__(self, *folders: Path) -> None:
        self.folders = folders

    @cached_property
    def digest(self) -> str:
        """Of the sources as they stood when this was first asked."""
        return source_digest(self.folders)

    def check(self, what: str, made: str | None, cure: str, warn: Warn) -> None:
        """Warn where `made`, a digest of sources, is not that of these."""
        if made != self.digest:
            warn(f"{what} by another version of the sources ({made}); {cure}")
