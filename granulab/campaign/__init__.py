"""Runs and what they leave behind: folders, provenance, frames, checkpoints, progress; no physics.

The names load on first use, so that a command which only prints its help stays quick.
"""

from importlib import import_module

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


def __getattr__(name: str):
    if name not in _HOME:
        raise AttributeError(f"module 'granulab.campaign' has no attribute {name!r}")
    return getattr(import_module(f"granulab.campaign.{_HOME[name]}"), name)
