"""Compiled kernels on disk: damaged ones are made again, a full disk costs their compilation."""

import collections
import errno
import importlib.util
from pathlib import Path

import numpy as np
import pytest
from numba import types

from granulab.contact.compiled import kept
from granulab.contact.compiled.handed import Handed, handed
from granulab.contact.compiled.linked import LinkedLibrary

KERNEL = """
from granulab.contact.jit import njit

@njit
def added(a, b):
    return a + b
"""

World = collections.namedtuple("World", ["law"])

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

HANDED = """
from typing import Any, NamedTuple
from granulab.contact.compiled.handed import handed
from granulab.contact.jit import inner, uncounted

class Within(NamedTuple):
    rows: Any
    law: Any

class World(NamedTuple):
    number: float
    within: Within
    counts: Any
    left_out: Any

@inner
def counted(world, k):
    world.counts[k] += 1
    return world.number * world.within.rows[k, 1] + world.within.law[1]

@inner
def again(world):
    return counted(handed(world), 0) - counted(world, 1)

@uncounted
def first(world):
    return again(handed(world))

@uncounted
def by_value(world):
    return again(world)
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


def test_tuples_of_two_classes_of_one_name_are_handed_on_as_two_types():
    """As motions or laws may be that were registered from two files."""
    worlds = []
    for _ in range(2):
        law = collections.namedtuple("Numbers", ["stiffness"])
        worlds.append(types.NamedTuple([types.NamedTuple([types.float64], law)], World))
    first, second = map(Handed, worlds)
    assert str(worlds[0]) == str(worlds[1])
    assert first != second
    assert second[0].instance_class is not first[0].instance_class
    assert Handed(worlds[0]) == first


@pytest.mark.parametrize("call", ["first", "by_value"])
def test_a_tuple_that_is_handed_on_by_its_place_has_the_fields_of_the_tuple(loaded, tmp_path, call):
    """2 (5 - 1) = 8 with each field from where it lies, kept on disk and not; Python likewise."""
    (tmp_path / "kernel_of_a_test.py").write_text(HANDED, encoding="utf-8")
    rows = np.arange(8.0).reshape(2, 4)[:, ::2][::-1] + np.array([[0.0, -1.0]])
    for _ in range(2):
        module = loaded.module()
        counts = np.zeros(2, int)
        world = module.World(2.0, module.Within(rows, (True, 0.5)), counts, None)
        assert getattr(module, call)(world) == 2.0 * (rows[0, 1] - rows[1, 1]) == 8.0
        assert counts.tolist() == [1, 1]
        assert handed(world) is world
