"""Refusals: one line on stderr, an exit code, nothing on stdout, no traceback."""

from collections.abc import Callable
from typing import Any

import pytest
from small_silo import Completed

from granulab.errors import InputError


def assert_refused(result: Completed, *words: str, code: int = 2) -> None:
    """One line that names the command and holds the words, and nothing on stdout."""
    assert (result.code, result.out) == (code, ""), result
    assert result.err.startswith(("silo2d: ", "damper3d: ", "calibrate: ")), result.err
    assert result.err.count("\n") == 1, result.err
    for word in words:
        assert word in result.err, (word, result.err)


def refusal(call: Callable[..., Any], *arguments: Any, **options: Any) -> str:
    """The one line with which a function refuses its input."""
    with pytest.raises(InputError) as refused:
        call(*arguments, **options)
    line = str(refused.value)
    assert line, "refused without a word"
    assert "\n" not in line, line
    return line


def assert_refuses(words: list[str], call: Callable[..., Any], *arguments: Any, **options: Any):
    """A function refuses its input in one line that holds the words."""
    line = refusal(call, *arguments, **options)
    for word in words:
        assert word in line, (word, line)
