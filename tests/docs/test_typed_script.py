"""A user's own script under a strict type checker: the packages' public names have their types."""

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.docs

SCRIPT = Path(__file__).parents[2] / "docs" / "examples" / "typed.py"


@pytest.mark.parametrize(("change", "found"), [
    (("", ""), ""),
    (("-> float | None:", "-> float:"), "Incompatible return value"),
    (('{"motion.gamma": gamma}', "[gamma]"), "Argument 2"),
])  # fmt: skip
def test_a_script_passes_and_a_wrong_one_is_told_why(change, found, tmp_path):
    script = tmp_path / "typed.py"
    script.write_text(SCRIPT.read_text(encoding="utf-8").replace(*change), encoding="utf-8")
    ended = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--cache-dir", tmp_path, script],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (ended.returncode == 0) is (found == ""), ended.stdout
    assert found in ended.stdout
