"""The wheel: what an installed GranuLab has to hold."""

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
KINDS = (".py", ".js", ".css", ".html")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> zipfile.ZipFile:
    """A wheel built from the tree, without a network."""
    pytest.importorskip("hatchling", reason="hatchling builds the wheel")
    folder = tmp_path_factory.mktemp("wheel")
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)],
        cwd=ROOT,
        check=True,
        capture_output=True,
    )
    (path,) = folder.glob("granulab-*.whl")
    return zipfile.ZipFile(path)


def test_the_wheel_holds_the_packages_whole(wheel):
    """Every module and part of a page, byte for byte, and no tests, runs or caches."""
    names = wheel.namelist()
    for package in ("granulab", "silo2d", "damper3d", "calibration"):
        sources = [s for s in (ROOT / package).rglob("*.*") if s.suffix in KINDS]
        for source in sources:
            assert wheel.read(source.relative_to(ROOT).as_posix()) == source.read_bytes()
    assert "granulab/campaign/output/page/parts/player.js" in names
    tops = {name.partition("/")[0] for name in names if ".dist-info/" not in name}
    assert tops == {"granulab", "silo2d", "damper3d", "calibration"}
    assert not [name for name in names if "__pycache__" in name or "/." in name]


def test_the_wheel_holds_the_data_files_inside_a_package(wheel):
    """granulab/data is where files.datafile looks first; "data" would be everybody's."""
    sources = [path for path in (ROOT / "data").rglob("*") if path.is_file()]
    assert len(sources) > 10
    for source in sources:
        name = f"granulab/data/{source.relative_to(ROOT / 'data').as_posix()}"
        assert wheel.read(name) == source.read_bytes()


def test_the_wheel_installs_the_commands(wheel):
    (points,) = [name for name in wheel.namelist() if name.endswith("/entry_points.txt")]
    packages = {"silo2d": "silo2d", "damper3d": "damper3d", "calibrate": "calibration"}
    for command, package in packages.items():
        assert f"{command} = {package}.commands.main:main" in wheel.read(points).decode()
    assert "granulab = granulab.studio.main:main" in wheel.read(points).decode()


def test_the_wheel_holds_the_page_of_the_studio(wheel):
    """Scripts, style and icon are data of the package: nothing is loaded from elsewhere."""
    parts = [path for path in (ROOT / "granulab/studio/page").iterdir() if path.is_file()]
    assert {"index.html", "studio.css", "main.js", "icon.svg"} <= {path.name for path in parts}
    for part in parts:
        assert wheel.read(part.relative_to(ROOT).as_posix()) == part.read_bytes()


def test_an_unpacked_wheel_finds_its_data(wheel, tmp_path):
    """Away from the checkout: isolated (-I), so that only the unpacked wheel is on the path."""
    wheel.extractall(tmp_path)
    program = (
        f"import sys; sys.path.insert(0, {str(tmp_path)!r})\n"
        "sys.argv = ['silo2d', 'run', 'A4', '--dry-run']\n"
        "from silo2d.commands import main; print(main.__file__); main.main()"
    )
    done = subprocess.run(
        [sys.executable, "-I", "-c", program], capture_output=True, text=True, check=False,
        cwd=tmp_path,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(str(tmp_path))
    assert "outlet 0.15 m" in done.stdout
