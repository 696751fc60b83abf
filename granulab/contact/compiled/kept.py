"""Compiled kernels on disk: sealed by SHA-256, and made again where they are damaged.

numba unpickles what it finds there, and runs it. A file that is cut short or damaged would end
every command from then on, and a flipped bit in machine code would compute something else.
"""

import hashlib
import pickle
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.serialize import dumps

from granulab.contact.compiled.linked import InnerCompiler, LinkedCache

_SEAL_BYTES = 32  # of a SHA-256
_said: set[str] = set()


def _say_once(what: str, line: str) -> None:
    """Warn a person on stderr; of many kernels once."""
    if what not in _said:
        _said.add(what)
        print(f"warning: {line}", file=sys.stderr)


class _SealedFiles(IndexDataCacheFile):
    """The files of one kernel: an index, and the machine code for each of its signatures."""

    def _load(self, path: str | Path) -> Any:
        data = Path(path).read_bytes()
        if hashlib.sha256(data[_SEAL_BYTES:]).digest() != data[:_SEAL_BYTES]:
            raise pickle.UnpicklingError("not what was kept")
        return pickle.loads(data[_SEAL_BYTES:])

    def _save(self, path: str, content: Any) -> None:
        data = dumps(content)
        with self._open_for_write(path) as file:
            file.write(hashlib.sha256(data).digest() + data)

    def _load_index(self) -> dict[Any, str]:
        try:
            version, stamp, overloads = self._load(self._index_path)
        except FileNotFoundError:
            return {}
        known: dict[Any, str] = overloads
        return known if (version, stamp) == (self._version, self._source_stamp) else {}

    def _save_index(self, overloads: dict[Any, str]) -> None:
        self._save(self._index_path, (self._version, self._source_stamp, overloads))

    def _load_data(self, name: str) -> Any:
        return self._load(self._data_path(name))

    def _save_data(self, name: str, data: Any) -> None:
        self._save(self._data_path(name), data)

    def remove(self) -> None:
        """Remove all files of the kernel."""
        for path in Path(self._cache_path).glob(f"{Path(self._index_path).stem}.*"):
            path.unlink(missing_ok=True)


class _KeptKernel(FunctionCache):
    """One kernel's compiled code; what goes wrong with it costs its compilation, no more."""

    def __init__(self, function: Any, is_inner: bool) -> None:
        if is_inner:
            self._impl_class = LinkedCache
        super().__init__(function)
        plain = self._cache_file
        self._files = _SealedFiles(plain._cache_path, self._impl.filename_base, plain._source_stamp)
        self._cache_file = self._files

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        try:
            return super().load_overload(sig, target_context)
        except Exception as error:  # unpickling raises whatever the bytes happen to call
            what = getattr(error, "strerror", None) or "damaged"
            _say_once("load", f"compiled kernels in {Path(self.cache_path).parent} cannot be used "
                      f"({what}) and are made again, which takes a while")  # fmt: skip
            with suppress(OSError):
                self._files.remove()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        try:
            super().save_overload(sig, data)
        except OSError as error:
            _say_once("save", f"compiled kernels cannot be kept in {Path(self.cache_path).parent} "
                      f"({error.strerror}); they are compiled again the next time")  # fmt: skip


def keep(dispatcher: Any) -> None:
    """Have the compiled code of a kernel kept in numba's folder, where it can be."""
    try:
        is_inner = dispatcher._compiler.pipeline_class is InnerCompiler
        dispatcher._cache = _KeptKernel(dispatcher.py_func, is_inner)
    except (OSError, RuntimeError):  # numba finds no folder that it can write to
        _say_once("save", "compiled kernels cannot be kept on this disk; they are compiled again "
                  "the next time")  # fmt: skip
