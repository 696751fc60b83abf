"""Errors that reach a user, each as one line; what no one foresaw is another exception.

A command ends with the exit code 2 after an InputError or a FolderError, with 3 after a
SimulationError and with 130 after Stopped. Imports nothing, so that an engine may raise them.
"""


class InputError(ValueError):
    """An input that cannot be used; one line that names field, value, unit and cure."""


class SimulationError(RuntimeError):
    """A simulation that cannot go on; one line that says when, and what to try."""


class Stopped(Exception):
    """Raised by a run that was stopped and has kept its state; says how to go on."""


class Failed(Exception):
    """Raised by a task that fails for a reason which one line gives."""


class FolderError(ValueError):
    """A run folder or a file in it that cannot be used; one line that says what would do."""


class DamagedError(FolderError):
    """A file of a run folder that holds something else than was written to it."""
