"""A study file of silos as labelled cases, and their runs."""

from pathlib import Path
from typing import Any

from campaign.cases import LabelledStudy, label_study
from campaign.cases import run_study as run_labelled_study
from contact.keys import Keys
from silo2d.case import SiloCase
from silo2d.settings import Settings
from silo2d.sweep import SILO


def load_study(path: str | Path) -> LabelledStudy:
    """The cases of a study file; see campaign.cases.label_study.

    Raises InputError or StudyError, one line that names the file, the key and what would do.
    """
    return label_study(path, Keys(Settings), SiloCase.load)


def run_study(
    loaded: LabelledStudy, *, out: Path, **options: Any
) -> tuple[Path, list[dict[str, Any]]]:
    """Run a study and keep its table; see campaign.cases.run_study."""
    return run_labelled_study(SILO, loaded, out=out, **options)
