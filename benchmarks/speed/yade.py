"""The damper's bed in YADE (Šmilauer et al. 2021, doi:10.5281/zenodo.5705394): its cost.

The Debian package yade; yade_bed.py runs inside its process. Hertz, Mindlin's history and Tsuji's
dashpot, as here; the round wall is of flat facets.
"""

import json
import re
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks.speed.liggghts import Material

if TYPE_CHECKING:
    from lammps_damper import Scene

_SCRIPT = Path(__file__).with_name("yade_bed.py")


class Yade:
    """A scene in YADE; ImportError where it is not installed."""

    def __init__(self, scene: "Scene") -> None:
        if not shutil.which("yade"):
            raise ImportError("yade")
        assert scene.enclosure.radius is not None
        self._cpu_s = 0.0
        with tempfile.NamedTemporaryFile("w", suffix=".json", delete=False) as file:
            json.dump({
                "position": scene.position.tolist(), "radius": scene.radius,
                "density": scene.density, "time_step": scene.time_step,
                "gravity": [float(g) for g in scene.gravity],
                "amplitude": scene.amplitude, "omega": scene.omega,
                "enclosure": [scene.enclosure.radius, scene.enclosure.height],
                **vars(Material(scene.pair_law)),
            }, file)  # fmt: skip
        self._process = subprocess.Popen(
            ["yade", "-n", "-j1", str(_SCRIPT), file.name], text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        self._tell("cpu")
        Path(file.name).unlink()

    @staticmethod
    def version() -> str | None:
        """Its version; None where it is not installed."""
        if not shutil.which("yade"):
            return None
        done = subprocess.run(["yade", "--version"], capture_output=True, text=True, check=False)
        found = re.search(r"version: (\S+)", done.stdout + done.stderr)
        return found[1] if found else None

    def __exit__(self, *_: object) -> None:
        """End the process."""
        self._process.communicate("end\n")

    def _tell(self, command: str) -> None:
        inlet, outlet = self._process.stdin, self._process.stdout
        assert inlet is not None
        assert outlet is not None
        inlet.write(command + "\n")
        inlet.flush()
        for line in outlet:
            if line.startswith("cpu "):
                self._cpu_s = float(line.split()[1])
                return
        raise RuntimeError("YADE ended")

    def run(self, n_steps: int) -> None:
        """So many steps further."""
        self._tell(f"run {n_steps}")

    def start(self, *, measured: bool = False) -> None:
        """Begin to move as a sine; work of the walls is not measured."""
        assert not measured
        self._tell("start")

    def cpu_s(self) -> float:
        """CPU time of its process so far [s], of all its threads."""
        return self._cpu_s
