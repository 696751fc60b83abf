"""Runs and what they leave behind: folders, provenance, frames, checkpoints, progress; no physics.

The names load on first use, so that a command which only prints its help stays quick.
"""

from typing import TYPE_CHECKING

from granulab.lazy import public

if TYPE_CHECKING:
    from granulab.campaign.output.results import read_results
    from granulab.campaign.output.statistics import wilson
    from granulab.campaign.output.terminal import Progress, StopRequest
    from granulab.campaign.runs.checkpoint import load_checkpoint, save_checkpoint
    from granulab.campaign.runs.folder import (
        FolderError,
        RunFolder,
        digest,
        open_run,
        resume_run,
    )
    from granulab.campaign.runs.trajectory import (
        Trajectory,
        TrajectoryWriter,
        read_tables,
        read_trajectory,
    )
    from granulab.campaign.sweeps.engine import run_tasks
    from granulab.campaign.sweeps.task import EngineError

_HOME = {
    "EngineError": "sweeps.task",
    "FolderError": "runs.folder",
    "Progress": "output.terminal",
    "RunFolder": "runs.folder",
    "StopRequest": "output.terminal",
    "Trajectory": "runs.trajectory",
    "TrajectoryWriter": "runs.trajectory",
    "digest": "runs.folder",
    "load_checkpoint": "runs.checkpoint",
    "open_run": "runs.folder",
    "read_results": "output.results",
    "read_tables": "runs.trajectory",
    "read_trajectory": "runs.trajectory",
    "resume_run": "runs.folder",
    "run_tasks": "sweeps.engine",
    "save_checkpoint": "runs.checkpoint",
    "wilson": "output.statistics",
}

__all__ = [
    "EngineError",
    "FolderError",
    "Progress",
    "RunFolder",
    "StopRequest",
    "Trajectory",
    "TrajectoryWriter",
    "digest",
    "load_checkpoint",
    "open_run",
    "read_results",
    "read_tables",
    "read_trajectory",
    "resume_run",
    "run_tasks",
    "save_checkpoint",
    "wilson",
]
__getattr__, __dir__ = public(__name__, _HOME)
