"""A study file of dampers as labelled cases, and their runs."""

from pathlib import Path
from typing import Any

from damper3d.case.case import DamperCase
from damper3d.case.settings import Settings
from damper3d.run.sweep import DAMPER
from granulab.campaign.sweeps.cases import LabelledStudy, label_study
from granulab.campaign.sweeps.cases import run_study as run_labelled_study
from granulab.contact.files.keys import Keys


def load_study(path: str | Path) -> LabelledStudy:
    """The cases of a study file; see granulab.campaign.sweeps.cases.label_study.

    Raises InputError or StudyError, one line that names the file, the key and what would do.
    """
    return label_study(path, Keys(Settings), DamperCase.load)


def run_study(
    loaded: LabelledStudy, *, out: Path, **options: Any
) -> tuple[Path, list[dict[str, Any]]]:
    """Run a study and keep its table; see granulab.campaign.sweeps.cases.run_study."""
    return run_labelled_study(DAMPER, loaded, out=out, **options)
