"""Kernels compiled by one worker of pytest only: the others wait for it and read its machine code.

Compilation is a good part of the first run of the tests, and workers begin with the same kernels.
A lock for each kernel and signature lets them share the work: who comes second finds the first
one's code in the cache on disk. Locks are taken in the order of calls, which has no circles.
"""

import hashlib
from pathlib import Path

from filelock import FileLock


def share_compilation(folder: Path) -> None:
    """Let the processes that call this with the same folder compile no kernel twice."""
    from numba.core.compiler_lock import global_compiler_lock
    from numba.core.dispatcher import Dispatcher

    compile_kernel = Dispatcher.compile
    folder.mkdir(parents=True, exist_ok=True)

    def compile_once(self: Dispatcher, signature: object) -> object:
        function = self.py_func
        name = f"{function.__module__}.{function.__qualname__}{signature}"
        lock = folder / hashlib.sha256(name.encode()).hexdigest()[:16]
        # Of threads first, as numba itself takes it: two threads would else wait for each other.
        with global_compiler_lock, FileLock(lock, is_singleton=True):
            return compile_kernel(self, signature)

    Dispatcher.compile = compile_once
