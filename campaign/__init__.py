"""Runs and what they leave behind: folders, provenance, frames, checkpoints, progress; no physics.

The names load on first use, so that a command which only prints its help stays quick.
"""

from importlib import import_module

_HOME = {
    "EngineError": "task",
    "FolderError": "folder",
    "Progress": "terminal",
    "RunFolder": "folder",
    "StopRequest": "terminal",
    "Trajectory": "trajectory",
    "TrajectoryWriter": "trajectory",
    "digest": "folder",
    "load_checkpoint": "checkpoint",
    "open_run": "folder",
    "read_trajectory": "trajectory",
    "resume_run": "folder",
    "run_tasks": "engine",
    "save_checkpoint": "checkpoint",
}

__all__ = sorted(_HOME)


def __getattr__(name: str):
    if name not in _HOME:
        raise AttributeError(f"module 'campaign' has no attribute {name!r}")
    return getattr(import_module(f"campaign.{_HOME[name]}"), name)
