"""Runs and what they leave behind: folders, provenance, frames, checkpoints, progress; no physics.

The names load on first use, so that a command which only prints its help stays quick.
"""

from granulab.lazy import public

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
    "read_trajectory": "runs.trajectory",
    "resume_run": "runs.folder",
    "run_tasks": "sweeps.engine",
    "save_checkpoint": "runs.checkpoint",
}

__all__ = sorted(_HOME)
__getattr__, __dir__ = public(__name__, _HOME)
