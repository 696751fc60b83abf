"""Which sources make a damper run."""

from pathlib import Path

from campaign.provenance import Sources

SOURCES = Sources(Path(__file__).parent, Path(__file__).parent.parent / "contact")
