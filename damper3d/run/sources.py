"""The sources that decide what a run computes, and those that measure it; no others count."""

from pathlib import Path

from granulab import contact
from granulab.campaign.runs.provenance import Sources

_PACKAGE = Path(__file__).parents[1]
_FOLDERS = [_PACKAGE / name for name in ("engine", "case", "run", "shapes")]
SOURCES = Sources(Path(contact.__file__).parent, *_FOLDERS)
MEASURES = Sources(_PACKAGE / "measures")
