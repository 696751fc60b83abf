"""A study file of silos as labelled cases, and their runs."""

from pathlib import Path
from typing import Any

from granulab.campaign.sweeps.cases import LabelledStudy, label_study
from granulab.campaign.sweeps.cases import run_study as run_labelled_study
from granulab.contact.files.keys import Keys
from silo2d.case.case import SiloCase
from silo2d.case.settings import Settings
from silo2d.run.sweep import SILO


def load_study(path: str | Path) -> LabelledStudy:
    """The cases of a study file; see granulab.campaign.sweeps.cases.label_study.

    Raises InputError or StudyError, one line that names the file, the key and what would do.
    """
    return label_study(path, Keys(Settings), SiloCase.load)


def run_study(
    loaded: LabelledStudy, *, out: Path, **options: Any
) -> tuple[Path, list[dict[str, Any]]]:
    """Run a study and keep its table; see granulab.campaign.sweeps.cases.run_study."""
    return run_labelled_study(SILO, loaded, out=out, **options)
