"""What a person who asks a package for its names is shown: the public ones, loaded on first use."""

import importlib
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ["silo2d", "damper3d", "calibration", "granulab.contact", "granulab.campaign"]


@pytest.mark.parametrize("package", PACKAGES)
def test_dir_lists_the_public_names_and_each_is_there_and_explained(package):
    module = importlib.import_module(package)
    shown = [name for name in dir(module) if not name.startswith("_")]
    assert shown == sorted(module.__all__)
    for name in shown:
        assert inspect.getdoc(getattr(module, name)), name


@pytest.mark.parametrize("package", PACKAGES)
def test_a_name_that_is_not_there_is_an_attribute_error(package):
    with pytest.raises(AttributeError, match=f"{package}' has no attribute 'nothing'"):
        importlib.import_module(package).nothing  # noqa: B018


def test_importing_the_packages_loads_no_kernels():
    """--help prints at once because numba is imported by the first name that needs it."""
    lines = [f"import {package}; dir({package})" for package in PACKAGES]
    check = "import sys; assert not {'numba', 'numpy', 'pydantic'} & sys.modules.keys()"
    subprocess.run([sys.executable, "-c", "\n".join([*lines, check])], check=True, cwd=ROOT)


@pytest.mark.parametrize("package", ["silo2d", "damper3d", "calibration", "granulab"])
def test_packages_say_that_they_are_typed(package):
    """PEP 561: without the file a user's type checker ignores the annotations."""
    assert (ROOT / package / "py.typed").exists()
