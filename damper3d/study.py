"""A study file of dampers as labelled cases, and their runs."""

from pathlib import Path
from typing import Any

from campaign.cases import LabelledStudy, label_study
from campaign.cases import run_study as run_labelled_study
from contact.keys import Keys
from damper3d.case import DamperCase
from damper3d.settings import Settings
from damper3d.sweep import DAMPER


def load_study(path: str | Path) -> LabelledStudy:
    """The cases of a study file; see campaign.cases.label_study.

    Raises InputError or StudyError, one line that names the file, the key and what would do.
    """
    return label_study(path, Keys(Settings), DamperCase.load)


def run_study(
    loaded: LabelledStudy, *, out: Path, **options: Any
) -> tuple[Path, list[dict[str, Any]]]:
    """Run a study and keep its table; see campaign.cases.run_study."""
    return run_labelled_study(DAMPER, loaded, out=out, **options)
