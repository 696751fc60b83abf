"""Run folders of shaken dampers, and of slow tests."""

import tomllib
from pathlib import Path

from granulab.campaign.runs.folder import RunFolder, resume_run
from granulab.errors import FolderError


def is_slow_test(folder: RunFolder) -> bool:
    """True for a run of `shear` or `compress`, whose case has a table [slow_test]."""
    try:
        return "slow_test" in tomllib.loads(folder.read_case())
    except (FolderError, ValueError):
        return False  # what reads the case says what is wrong with it


def shaken(path: str | Path) -> RunFolder:
    """The folder of a damper's run; FolderError where it is none, or of a slow test."""
    folder = resume_run(path)
    if is_slow_test(folder):
        raise FolderError(
            f"{path}: of damper3d shear or compress, which keep a force and a displacement but no "
            "particles; damper3d show reports them, and the command that made it goes on with it"
        )
    return folder
