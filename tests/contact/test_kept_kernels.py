"""Compiled kernels on disk: damaged ones are made again, a full disk costs their compilation."""

import errno
import importlib.util
from pathlib import Path

import pytest

from granulab.contact.compiled import kept
from granulab.contact.compiled.linked import LinkedLibrary

KERNEL = """
from granulab.contact.jit import njit

@njit
def added(a, b):
    return a + b
"""


INNER = """
from granulab.contact.jit import inner, njit

@inner
def twice(a):
    return a + a

@inner
def fourfold(a):
    return twice(twice(a))

@njit
def first(a):
    return fourfold(a) + 1.0

@njit
def second(a):
    return fourfold(a) - 1.0
"""


@pytest.fixture
def loaded(tmp_path, monkeypatch):
    """Loads the kernel's module as a new process does, and says what was warned of."""
    monkeypatch.setattr(kept, "_said", set())
    file = tmp_path / "kernel_of_a_test.py"
    file.write_text(KERNEL, encoding="utf-8")

    def load():
        spec = importlib.util.spec_from_file_location("kernel_of_a_test", file)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        kept._said.clear()
        return module

    def load_kernel():
        return load().added

    load_kernel.module = load
    return load_kernel


def files_of(kernel) -> list[Path]:
    return sorted(Path(kernel.stats.cache_path).glob("kernel_of_a_test.*"))


@pytest.mark.parametrize("ending", [".nbi", ".nbc"])
def test_a_damaged_kernel_is_made_again(loaded, capsys, ending):
    """Cut short, of other bytes, and with one bit flipped, which nothing but the seal notices."""
    loaded()(1.0, 2.0)
    (path,) = [path for path in files_of(loaded()) if path.suffix == ending]
    whole = path.read_bytes()
    flipped = whole[:-40] + bytes([whole[-40] ^ 1]) + whole[-39:]
    for damaged in (whole[:50], b"", b"garbage", flipped):
        path.write_bytes(damaged)
        kernel = loaded()
        assert kernel(1.0, 2.0) == 3.0
        said = capsys.readouterr().err
        assert said.startswith("warning: compiled kernels in ")
        assert "(damaged) and are made again" in said
        assert said.count("\n") == 1
        again = loaded()
        assert again(1.0, 2.0) == 3.0
        assert sum(again.stats.cache_hits.values()) == 1
        assert capsys.readouterr().err == ""


def test_a_full_disk_under_the_kernels_is_one_line(loaded, capsys, monkeypatch):
    def full(self, path, content):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(kept._SealedFiles, "_save", full)
    kernel = loaded()
    assert kernel(1, 2) == 3
    assert kernel(1.0, 2.0) == 3.0
    said = capsys.readouterr().err
    assert "cannot be kept" in said
    assert "No space left on device" in said
    assert said.count("\n") == 1


def test_what_only_kernels_call_is_linked_into_them_and_kept_for_others(loaded, tmp_path):
    """Without machine code of its own; a kernel of a later process takes in what was kept."""
    (tmp_path / "kernel_of_a_test.py").write_text(INNER, encoding="utf-8")
    module = loaded.module()
    assert module.first(2.0) == 9.0
    (made,) = module.fourfold.overloads.values()
    assert isinstance(made.library, LinkedLibrary)
    assert made.library.get_pointer_to_function(made.fndesc.mangled_name) == 0
    again = loaded.module()
    assert again.second(2.0) == 7.0
    assert sum(again.fourfold.stats.cache_hits.values()) == 1
    assert not again.twice.overloads  # what takes it in was kept with it
    assert again.first(2.0) == 9.0
    assert sum(again.first.stats.cache_hits.values()) == 1
