"""What tests measure: the largest difference from what is expected, beside what is allowed.

    PYTHONPATH=tests/helpers python -m pytest -p measured --measured FILE.csv ...

A pytest plugin: each comparison by pytest.approx and numpy's assert_allclose is noted as it is
made. FILE has a row for each test, over all of its parameters: the comparison that comes closest
to its tolerance. A comparison that fails is not noted, as a test may ask for a difference.
"""

import csv
import functools
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

Scalar = type(pytest.approx(1.0))  # which the comparisons of lists and arrays consist of
REAL = (int, float, np.integer, np.floating)
COLUMNS = ("test", "comparisons", "expected", "difference", "allowed")
_noted: list[tuple[float, float, float]] = []  # expected, difference, allowed; of the running test


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--measured", metavar="FILE.csv", help="Where the measured differences go.")


def pytest_configure(config: pytest.Config) -> None:
    Scalar.__eq__ = _noting(Scalar.__eq__)
    np.testing.assert_allclose = _noting_all(np.testing.assert_allclose)
    if not hasattr(config, "workerinput") and config.getoption("measured"):
        config.pluginmanager.register(_Writer(Path(config.getoption("measured"))))


def _noting(equal: Any) -> Any:
    """A scalar's comparison that notes what it compares."""

    @functools.wraps(equal)
    def compared(self: Any, actual: Any) -> bool:
        same = bool(equal(self, actual))
        if same and isinstance(self.expected, REAL) and np.isfinite(self.expected):
            _note(self.expected, actual, self.tolerance)
        return same

    return compared


def _noting_all(assert_allclose: Any) -> Any:
    """The comparison of arrays, its worst element noted."""

    @functools.wraps(assert_allclose)
    def compared(actual: Any, desired: Any, rtol: float = 1e-7, atol: float = 0, **options: Any):
        assert_allclose(actual, desired, rtol, atol, **options)
        found, wanted = np.broadcast_arrays(np.asarray(actual), np.asarray(desired))
        for one, other in zip(found.ravel(), wanted.ravel(), strict=True):
            _note(other, one, atol + rtol * abs(other))

    return compared


def _note(expected: Any, actual: Any, allowed: float) -> None:
    """Note a comparison of real numbers; others, of truths and complex numbers, are left out."""
    if isinstance(actual, REAL) and not isinstance(actual, bool):
        values = float(expected), abs(float(actual) - float(expected)), float(allowed)
        if np.isfinite(values).all():
            _noted.append(values)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Any:
    _noted.clear()
    try:
        return (yield)
    finally:
        if _noted:
            worst = max(_noted, key=lambda one: one[1] / one[2] if one[2] else float(one[1] > 0))
            item.user_properties.append(("measured", (len(_noted), *worst)))


class _Writer:
    """Collects the worst of each test, from all workers, and writes the table."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.rows: dict[str, tuple[int, float, float, float]] = {}

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.when != "call" or not report.passed:
            return
        for name, (count, *worst) in report.user_properties:
            if name == "measured":
                test = re.sub(r"\[.*", "", report.nodeid)
                before = self.rows.get(test, (0, 0.0, 0.0, 1.0))
                kept = max(worst, before[1:], key=lambda one: one[1] / (one[2] or 1.0))
                self.rows[test] = (before[0] + count, *kept)

    def pytest_sessionfinish(self, exitstatus: int) -> None:
        if exitstatus != pytest.ExitCode.OK:
            return  # some tests are not among the rows: the table of before stays
        with self.path.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(COLUMNS)
            for test, (count, *worst) in sorted(self.rows.items()):
                writer.writerow([test, count, *(f"{value:.3g}" for value in worst)])
