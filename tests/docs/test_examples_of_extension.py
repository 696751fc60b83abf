"""The examples that extend the packages from outside: each runs as it stands, and is short."""

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.docs

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples" / "extend"


def printed(name, folder):
    """The words of the last line that an example prints."""
    command = [sys.executable, EXAMPLES / f"{name}.py"]
    ended = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    return ended.stdout.splitlines()[-1].split()


@pytest.mark.parametrize("name", ["law", "enclosure", "motion"])
def test_a_run_with_a_part_from_outside_closes_its_energy_balance(name, tmp_path):
    """To 1 % of what is dissipated, as is asked of every run (tests of the engines)."""
    assert abs(float(printed(name, tmp_path)[-1])) < 0.01


def test_a_chain_of_three_spheres_has_their_sphericity(tmp_path):
    """cbrt(36 pi V^2)/S of n equal spheres is n^(-1/3) (eq. 8.3)."""
    assert float(printed("shape", tmp_path)[-1]) == pytest.approx(3 ** (-1 / 3), rel=1e-12)


def test_a_bed_lies_in_its_enclosure_by_the_measure_from_outside(tmp_path):
    """358 spheres fill 0.466 of 40 mm: half of the height they fill when close packed, or more."""
    *_, mean = printed("measure", tmp_path)
    assert 0.5 * 0.466 / 0.64 * 0.04 < float(mean.rstrip("}")) < 0.02


def test_every_example_has_its_test_and_fits_on_a_page():
    lengths = {path.stem: len(path.read_text().splitlines()) for path in EXAMPLES.glob("*.py")}
    assert lengths.keys() == {"measure", "law", "shape", "enclosure", "motion"}
    assert max(lengths.values()) <= 65
