"""A shaken enclosure of spheres in LAMMPS, with the constants of granulab/contact/hertz.py.

LAMMPS (Thompson et al. 2022, Comput. Phys. Commun. 271, 108171), pair granular and
fix wall/gran/region. What is matched and what is not stands in docs/verification/lammps-damper.md.
"""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from against_lammps import load_lammps

from damper3d.engine.enclosures import Enclosure
from granulab.contact.hertz import HertzLaw

_QUIET = ["-log", "none", "-screen", "none", "-nocite"]
_SKIN = 4e-4  # [m] of the neighbour list; the fastest of 0.1-1 mm for 5 mm spheres


@dataclass(frozen=True)
class Scene:
    """Equal solid spheres in an enclosure that moves along its axis z.

    position    (n, 3) of the centres in the enclosure's frame [m]
    velocity    (n, 3) in the lab [m/s]; spin (n, 3) [rad/s]; None: at rest
    gravity     (3,) [m/s2]
    amplitude   of the sine that the enclosure's displacement is [m]; omega [rad/s]
    curved      whether the law takes the curvature of the round wall
    """

    position: np.ndarray
    radius: float
    density: float
    enclosure: Enclosure
    pair_law: HertzLaw
    wall_law: HertzLaw
    time_step: float
    velocity: np.ndarray | None = None
    spin: np.ndarray | None = None
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    amplitude: float = 0.0
    omega: float = 1.0
    curved: bool = False

    @property
    def sphere_mass(self) -> float:
        """Of one sphere [kg]."""
        return self.density * 4 / 3 * math.pi * self.radius**3

    @property
    def mass(self) -> float:
        """Of the bed [kg]."""
        return len(self.position) * self.sphere_mass

    def efficiency(self, energy: float, cycles: float) -> float:
        """Of so much energy [J] dissipated in so many cycles (thesis, eqs 6.8-6.10)."""
        return energy / (cycles * 4 * (self.amplitude * self.omega) ** 2 * self.mass)


class Bed(NamedTuple):
    """Where the spheres are: relative to the enclosure, velocities in the lab."""

    position: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray


class Cycles(NamedTuple):
    """What was measured, cycle by cycle (cycles,), and at their borders (cycles + 1,)."""

    wall_work: np.ndarray  # by the enclosure on the bed [J]
    kinetic: np.ndarray  # with the spin's [J]
    potential: np.ndarray  # in the field of gravity [J]


def restitution(law: HertzLaw) -> float:
    """What the law's damping gives where a contact ends at zero overlap (eq. 5.31)."""
    return math.exp(-math.pi * law.damping / math.sqrt(1 - law.damping**2))


def as_lammps(law: HertzLaw, factor: float = 1.0) -> str:
    """The law in LAMMPS's words, its stiffnesses times a factor.

    hertz K e: elastic force F = K sqrt(R) d^1.5; damping coeff_restitution: the dashpot
    sqrt(5) b sqrt(m F/d), which is eq. 5.32; tangential mindlin K_t x mu: a spring
    K_t sqrt(R d) and a dashpot that is x times the normal one; limit_damping: no attraction.
    """
    history = "mindlin/force" if law.stored_force else "mindlin"
    constants = factor * law.hertz * law.tangential, law.tangential_damping / math.sqrt(5), law.mu
    return (
        f"granular hertz {float(factor * law.hertz)!r} {restitution(law)!r} "
        f"tangential {history} {' '.join(repr(float(x)) for x in constants)} "
        f"damping coeff_restitution{'' if law.pulls else ' limit_damping'}"
    )


class Lammps:
    """A scene in LAMMPS. Close it, or use it in a with statement."""

    def __init__(self, scene: Scene, *, skin: float = _SKIN):
        """Put the spheres where they are; the enclosure stands still until start()."""
        self.scene, self.steps = scene, 0
        self.engine: Any = load_lammps().lammps(cmdargs=_QUIET)
        self._started, self._moves = False, False
        n, box = len(scene.position), scene.enclosure
        reach = max(box.width, box.depth, box.height) + scene.amplitude + 0.01
        self.engine.commands_string(f"""
            units si
            atom_style sphere
            atom_modify map array sort 1000 0
            boundary f f f
            newton off
            comm_modify vel yes
            region space block {-reach} {reach} {-reach} {reach} {-reach} {reach}
            create_box 1 space
            neighbor {skin!r} bin
            neigh_modify delay 0 every 1 check yes
            pair_style granular
            pair_coeff * * {as_lammps(scene.pair_law).removeprefix("granular ")}
            fix move all nve/sphere
            timestep {scene.time_step!r}
            variable u equal 0
        """)
        self.engine.create_atoms(n, list(range(1, n + 1)), [1] * n, scene.position.ravel().tolist())
        self.engine.command(f"set group all diameter {2 * scene.radius!r}")
        self.engine.command(f"set group all density {scene.density!r}")
        self._put("v", scene.velocity)
        self._put("omega", scene.spin)
        size = math.hypot(*scene.gravity)
        if size > 0:
            along = " ".join(repr(float(g) / size) for g in scene.gravity)
            self.engine.command(f"fix weight all gravity {size!r} vector {along}")
        self._add_walls()

    def __enter__(self) -> "Lammps":
        """Itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Free the memory."""
        self.engine.close()

    def _put(self, name: str, values: np.ndarray | None) -> None:
        if values is not None:
            rows = self.engine.numpy.extract_atom("id")[: len(values)] - 1
            self.engine.numpy.extract_atom(name)[: len(values)] = values[rows]

    def _add_walls(self) -> None:
        """One region; or bottom and top, and a round wall that is flat to the law.

        LAMMPS takes 1/R = 1/r - 1/D for a sphere in a cylinder of diameter D, the mean curvature;
        the thesis takes R = r. The spheres are alike, so a stiffness times sqrt(r/R) is its law.
        """
        box, law = self.scene.enclosure, as_lammps(self.scene.wall_law)
        top = repr(box.height)
        if box.radius is None:
            x, y = box.width / 2, box.depth / 2
            self._add_wall("all_walls", f"block {-x!r} {x!r} {-y!r} {y!r} 0 {top}", law)
        elif self.scene.curved:
            self._add_wall("all_walls", f"cylinder z 0 0 {box.radius!r} 0 {top}", law)
        else:
            self._add_wall("bottom", "plane 0 0 0 0 0 1", law)
            self._add_wall("top", f"plane 0 0 {top} 0 0 -1", law)
            factor = math.sqrt(1 - self.scene.radius / (2 * box.radius))
            tube = f"cylinder z 0 0 {box.radius!r} -1 {box.height + 1!r} open 1 open 2"
            self._add_wall("side", tube, as_lammps(self.scene.wall_law, factor))

    def _add_wall(self, name: str, shape: str, law: str) -> None:
        self.engine.command(f"region {name} {shape} move NULL NULL v_u")
        self.engine.command(f"fix {name} all wall/gran/region {law} region {name}")

    @property
    def time(self) -> float:
        """Since the last start [s]."""
        return self.steps * self.scene.time_step

    @property
    def displacement(self) -> float:
        """Of the enclosure [m]."""
        return self.scene.amplitude * math.sin(self.scene.omega * self.time) if self._moves else 0.0

    def run(self, n_steps: int) -> None:
        """So many steps further."""
        self.engine.command(f"run {n_steps} pre {'no' if self._started else 'yes'} post no")
        self._started = True
        self.steps += n_steps

    def start(self, *, measured: bool = True) -> None:
        """Begin to move as a sine; if measured, sum the walls' power after every step."""
        scene, began = self.scene, self.engine.extract_global("ntimestep")
        phase = f"{scene.omega!r}*{scene.time_step!r}*(step-{began})"
        self.engine.command(f"variable u equal {scene.amplitude!r}*sin({phase})")
        if measured:
            # Forces between spheres cancel in the sum over all; what is left is the walls' and the
            # weight.
            weight = scene.mass * scene.gravity[2]
            self.engine.commands_string(f"""
                compute pull all reduce sum fz
                variable speed equal {scene.amplitude * scene.omega!r}*cos({phase})
                variable power equal (c_pull-({weight!r}))*v_speed
                fix work all ave/time 1 1 1 v_power ave running
            """)
        self._started, self._moves, self.steps = False, True, 0

    @property
    def wall_work(self) -> float:
        """By the enclosure on the bed since start() [J]."""
        # The mean is over the steps' ends and the beginning.
        return (
            float(self.engine.extract_fix("work", 0, 0)) * (self.steps + 1) * self.scene.time_step
        )

    def cycles(self, n_cycles: int, steps: int) -> Cycles:
        """Of so many steps each, right after start()."""
        rows = [(0.0, *self.energy())]
        for _ in range(n_cycles):
            self.run(steps)
            rows.append((self.wall_work, *self.energy()))
        work, kinetic, potential = np.array(rows).T
        return Cycles(np.diff(work), kinetic, potential)

    def bed(self) -> Bed:
        """Where the spheres are now."""
        n, get = len(self.scene.position), self.engine.numpy.extract_atom
        order = np.argsort(get("id")[:n])
        x, v, spin = (get(name)[:n][order].copy() for name in ("x", "v", "omega"))
        x[:, 2] -= self.displacement
        return Bed(x, v, spin)

    def energy(self) -> tuple[float, float]:
        """Kinetic and potential energy now [J], the latter in the lab."""
        scene, n, get = self.scene, len(self.scene.position), self.engine.numpy.extract_atom
        v, spin, x = (get(name)[:n] for name in ("v", "omega", "x"))
        inertia = 0.4 * scene.sphere_mass * scene.radius**2
        kinetic = 0.5 * (scene.sphere_mass * (v**2).sum() + inertia * (spin**2).sum())
        return float(kinetic), -scene.sphere_mass * float((x @ np.array(scene.gravity)).sum())
