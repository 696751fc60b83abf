"""The damper's bed in LIGGGHTS (Kloss et al. 2012, Prog. Comput. Fluid Dyn. 12, 140): its cost.

The Debian package liggghts; a process that takes commands on its standard input. Hertz, Mindlin's
history and Tsuji's dashpot, as here. Its primitive walls stand still: the spheres are in the frame
of the enclosure, with the force of inertia, which is the same motion.
"""

import math
import re
import shutil
import subprocess
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lammps_damper import Scene

    from granulab.contact.hertz import HertzLaw

_SKIN = 4e-4  # [m] of the neighbour list, as of LAMMPS's


class Material:
    """Young's modulus [Pa] and Poisson's ratio of two equal materials that a law follows from.

    4/3 E* = hertz, with E = 2 (1 - nu^2) E*; kt/kn = 6 G*/E* with G*/E* = (1 - nu)/(2 (2 - nu)),
    eqs 5.6 and 5.14 of the thesis.
    """

    def __init__(self, law: "HertzLaw") -> None:
        ratio = law.tangential / 6
        self.poisson = float((1 - 4 * ratio) / (1 - 2 * ratio))
        self.young = float(2 * (1 - self.poisson**2) * 0.75 * law.hertz)
        b = law.damping
        self.restitution = math.exp(-math.pi * b / math.sqrt(1 - b * b))  # of eq. 5.32
        self.friction = float(law.mu)


class Liggghts:
    """A scene in LIGGGHTS; ImportError where it is not installed."""

    def __init__(self, scene: "Scene") -> None:
        if not shutil.which("liggghts"):
            raise ImportError("liggghts")
        self.scene, self._started, self._marks, self._steps = scene, False, 0, 0
        self._process = subprocess.Popen(
            ["stdbuf", "-oL", "liggghts", "-log", "none"], text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip
        self.tell(self.deck)

    @staticmethod
    def version() -> str | None:
        """Its version; None where it is not installed."""
        if not shutil.which("liggghts"):
            return None
        done = subprocess.run(["liggghts", "-log", "none"], input="quit\n", capture_output=True,
                              text=True, check=False)  # fmt: skip
        found = re.search(r"LIGGGHTS-PUBLIC ([\d.]+)", done.stdout)
        return found[1] if found else None

    def __exit__(self, *_: object) -> None:
        """End the process."""
        self._process.communicate("quit\n")

    @cached_property
    def deck(self) -> str:
        """Its input: the spheres at rest, the enclosure still."""
        scene, box, one = self.scene, self.scene.enclosure, Material(self.scene.pair_law)
        assert scene.pair_law == scene.wall_law
        assert box.radius is not None
        reach = max(box.width, box.depth, box.height) + 0.01
        wall = "wall/gran model hertz tangential history primitive type 1"
        atoms = "\n".join(
            f"create_atoms 1 single {x!r} {y!r} {z!r}" for x, y, z in scene.position.tolist()
        )
        return f"""
            units si
            hard_particles yes
            atom_style granular
            atom_modify map array sort 1000 0
            boundary f f f
            newton off
            communicate single vel yes
            region space block {-reach} {reach} {-reach} {reach} {-reach} {reach}
            create_box 1 space
            neighbor {_SKIN!r} bin
            neigh_modify delay 0 every 1 check yes
            fix m1 all property/global youngsModulus peratomtype {one.young!r}
            fix m2 all property/global poissonsRatio peratomtype {one.poisson!r}
            fix m3 all property/global coefficientRestitution peratomtypepair 1 {one.restitution!r}
            fix m4 all property/global coefficientFriction peratomtypepair 1 {one.friction!r}
            pair_style gran model hertz tangential history
            pair_coeff * *
            {atoms}
            set group all diameter {2 * scene.radius!r} density {scene.density!r}
            fix bottom all {wall} zplane 0.0
            fix top all {wall} zplane {box.height!r}
            fix side all {wall} zcylinder {box.radius!r} 0.0 0.0
            fix weight all gravity {-float(scene.gravity[2])!r} vector 0 0 -1
            fix move all nve/sphere
            timestep {scene.time_step!r}
            thermo 1000000
        """

    def tell(self, commands: str) -> None:
        """Give commands and wait until they are done; RuntimeError where they are refused."""
        self._marks += 1
        mark = f"done-{self._marks}"
        inlet, outlet = self._process.stdin, self._process.stdout
        assert inlet is not None
        assert outlet is not None
        inlet.write(f'{commands}\nprint "{mark}"\n')
        inlet.flush()
        for line in outlet:
            if line.strip() == mark:
                return
            if line.startswith("ERROR"):
                raise RuntimeError(f"LIGGGHTS: {line.strip()}")
        raise RuntimeError("LIGGGHTS ended")

    def run(self, n_steps: int) -> None:
        """So many steps further."""
        self.tell(f"run {n_steps} pre {'no' if self._started else 'yes'} post no")
        self._started = True
        self._steps += n_steps

    def start(self, *, measured: bool = False) -> None:
        """Begin to move as a sine; work of the walls is not measured."""
        scene = self.scene
        assert not measured
        phase = f"{float(scene.omega)!r}*{scene.time_step!r}*(step-v_began)"
        inertia = float(scene.sphere_mass * scene.amplitude * scene.omega**2)
        self.tell(f"""
            variable began equal {self._steps}
            variable push equal {inertia!r}*sin({phase})
            velocity all set NULL NULL {-float(scene.amplitude * scene.omega)!r} sum yes
            fix push all addforce 0 0 v_push
        """)
        self._started = False

    def cpu_s(self) -> float:
        """CPU time of its process so far [s]."""
        tasks = Path(f"/proc/{self._process.pid}/task").glob("*/schedstat")
        return 1e-9 * sum(int(task.read_text().split()[0]) for task in tasks)
