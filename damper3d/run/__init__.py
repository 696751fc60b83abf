"""Runs of dampers: filling and shaking, with checkpoints; one, or many.

`damper3d.run(case)` runs a case: the folder has the name of the function, and stands in for it.
"""

import sys
from types import ModuleType
from typing import Any


class _Room(ModuleType):
    def __call__(self, *arguments: Any, **options: Any) -> Any:
        """Run a case; see damper3d.run.protocol.run."""
        from damper3d.run.protocol import run

        return run(*arguments, **options)


sys.modules[__name__].__class__ = _Room
