"""Parts of a damper's case from its settings: enclosure, count, gravity; and what cannot be."""

import dataclasses
import math
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from damper3d.case.host.modes import given
from damper3d.case.oscillation import DEEPEST
from damper3d.case.random_packing import close_packing
from damper3d.case.settings import MOST_PARTICLES, Kind, Motion, Particles, Settings
from damper3d.case.settings import Enclosure as EnclosureKeys
from damper3d.engine.enclosures import ENCLOSURES, Cavity, Cells, Enclosure, Polyhedron, cylinder
from damper3d.engine.motions import MOTIONS
from damper3d.shapes.mesh import unit_of
from damper3d.shapes.multisphere import MultiSphere
from damper3d.shapes.particle import Particle, usual
from damper3d.shapes.surfaces.mesh_check import outward
from damper3d.shapes.surfaces.mesh_data import as_obj, read_triangles
from granulab.contact.files.datafile import is_file
from granulab.contact.files.units import located, nearest, to_si
from granulab.errors import InputError

GRAVITY = 9.81  # [m/s2]
# The thesis keeps the volume of 700 spheres of 4 mm in 40 mm x 40 mm: a fill ratio of 7/15, with
# which 3, 5 and 6 mm are 1659, 358 and 207 spheres (Table 6.1).
USUAL_FILL_RATIO = 7 / 15
SHAPED_CYCLES = 18  # of which 3 are left out: chapter 8 of the thesis, of all its particles

_Shaped = TypeVar("_Shaped", Particles, Kind)
_Number = TypeVar("_Number", float, NDArray[np.float64])


def amplitude_of(gamma: _Number, frequency: _Number) -> _Number:
    """Amplitude [m] of a motion of Gamma at a frequency [Hz], Gamma g / omega^2 (eq. 6.2)."""
    return gamma * GRAVITY / (2.0 * math.pi * frequency) ** 2


def gamma_at(amplitude: _Number, frequency: _Number) -> _Number:
    """Gamma of a motion of an amplitude [m] at a frequency [Hz]."""
    return amplitude * (2.0 * math.pi * frequency) ** 2 / GRAVITY


def enclosure_of(settings: Settings, where: str, folder: Path) -> Enclosure:
    """Return the enclosure; InputError where its sizes are not those of its shape.

    folder: where the file of a cavity is looked for first.
    """
    given = settings.enclosure
    chosen = ENCLOSURES[given.shape]
    sizes = {**given.model_dump(exclude=_OF_ALL, exclude_none=True)}
    own = chosen.units()
    if "height" not in own and "height" not in given.model_fields_set:
        del sizes["height"]
    for name, other in ENCLOSURES.items():
        strange = [key for key in other.units() if key not in own]
        if any(key in sizes for key in strange):
            goes = " and ".join(strange) + (" go" if len(strange) > 1 else " goes")
            raise InputError(
                f"{where}: [enclosure] {goes} with shape = {name!r}; a {given.shape} has "
                f"{', '.join(own)}"
            )
    if chosen is Cavity:
        return cavity_of(sizes, where, folder)
    own_sizes = {key: sizes[key] for key in own if key in sizes}
    if chosen is Polyhedron:
        own_sizes = rows_in_si(sizes, where)
    return with_cells(made(chosen, own_sizes, own, where), given, where)


_OF_ALL = {"shape", "material", "walls", "cells", "cell_wall"}  # keys of no shape of its own


def rows_in_si(sizes: dict[str, Any], where: str) -> dict[str, tuple[tuple[float, ...], ...]]:
    """Corners and faces of a polyhedron in metres; InputError where they are not such."""
    found, factor = {}, length_of(sizes, where) if "unit" in sizes else None
    for key, length, example in (("vertices", 3, [0, 0, 40]), ("faces", 4, [0, 0, 1, 40])):
        if key not in sizes:
            continue
        if factor is None:
            raise InputError(f"{where}: [enclosure] unit is missing; give that of {key}, as 'mm'")
        for k, row in enumerate(sizes[key], 1):
            if len(row) != length:
                raise InputError(
                    f"{where}: [enclosure] {key}: number {k} has {len(row)} numbers; write "
                    f"{length}, such as {example}"
                )
        scale = np.array([factor] * 3 if length == 3 else [1.0, 1.0, 1.0, factor])
        found[key] = tuple(tuple((scale * row).tolist()) for row in sizes[key])
    return found


def length_of(sizes: dict[str, Any], where: str) -> float:
    """The length [m] that one stands for in lists and files of an enclosure; InputError else."""
    if "unit" not in sizes:
        raise InputError(f"{where}: [enclosure] unit is missing; give that of the file, as 'mm'")
    with located(f"{where}: [enclosure]"):
        return unit_of(sizes["unit"], "unit")


def cavity_of(sizes: dict[str, Any], where: str, folder: Path) -> Cavity:
    """A cavity from its file; InputError where its triangles do not close, or face inwards."""
    if "file" not in sizes:
        raise InputError(
            f"{where}: [enclosure] file is missing; give that of the cavity's triangles"
        )
    factor, path = length_of(sizes, where), folder / sizes["file"]
    with located(f"{where}: [enclosure]"):
        surface = outward(read_triangles(path if is_file(path) else Path(sizes["file"])), str(path))
    return Cavity(sizes["file"], sizes["unit"], factor * surface.vertices, surface.triangles)


def with_cells(enclosure: Enclosure, given: EnclosureKeys, where: str) -> Enclosure:
    """The enclosure, or as many of it as cells asks for; InputError where it cannot be a cell."""
    if given.cells is None and given.cell_wall is None:
        return enclosure
    if enclosure.shape not in ("cylinder", "box"):
        raise InputError(
            f"{where}: [enclosure] cells and cell_wall go with shape = 'cylinder' or 'box', not "
            f"with {enclosure.shape!r}"
        )
    for key in ("cells", "cell_wall"):
        if getattr(given, key) is None:
            raise InputError(f"{where}: [enclosure] {key} is missing; cells need both, as [2, 2] "
                             "and '1 mm'")  # fmt: skip
    assert given.cells is not None
    assert given.cell_wall is not None
    n_x, n_y = given.cells
    return Cells(enclosure, n_x, n_y, given.cell_wall)


def check_enclosure(
    enclosure: Enclosure, particle: MultiSphere, settings: Settings, where: str
) -> None:
    """Raise InputError where walls, cells or a cavity do not go with the rest of the case."""
    for name in settings.enclosure.walls or {}:
        if name not in enclosure.wall_names:
            raise InputError(
                f"{where}: [enclosure.walls] {name!r}: {nearest(name, enclosure.wall_names)}"
            )
    law = settings.law
    if isinstance(enclosure, Cavity) and not particle.is_sphere and law.contact_treatment != "sum":
        raise InputError(
            f"{where}: [law] contact_treatment = {law.contact_treatment!r} takes all contacts of a "
            "particle with one wall together, and a cavity is one wall all round; give 'sum'"
        )
    if isinstance(enclosure, Cavity) and (law.rolling_friction or law.cohesion):
        key = "rolling_friction" if law.rolling_friction else "cohesion"
        raise InputError(
            f"{where}: [law] {key}: not in a cavity of triangles, over whose seams its state is "
            "not handed on; leave it out, or give another shape"
        )
    # Spheres on both sides of a wall may each overlap with it by DEEPEST of their radius.
    thinnest = 2.0 * DEEPEST * particle.smallest_radius
    if isinstance(enclosure, Cells) and enclosure.thickness < thinnest:
        raise InputError(
            f"{where}: [enclosure] cell_wall = {1e3 * enclosure.thickness:g} mm: spheres of two "
            f"cells could touch through it; give at least {1e3 * thinnest:.3g} mm"
        )


CAVITY_FILE = "enclosure-cavity.obj"  # in a run folder


def cavity_copy(enclosure: Enclosure) -> dict[str, str]:
    """The triangles of a cavity as a file for the run folder, in metres; of others none."""
    if not isinstance(enclosure, Cavity):
        return {}
    return {CAVITY_FILE: as_obj(enclosure.points[enclosure.triangles])}


def made(
    chosen: type[Enclosure], sizes: dict[str, Any], units: dict[str, str], where: str
) -> Enclosure:
    """Return an enclosure of these sizes; InputError where one is missing or wrong."""
    with located(f"{where}: [enclosure]"):
        in_si = {key: to_si(size, units[key], key) if isinstance(size, str) else size
                 for key, size in sizes.items()}  # fmt: skip
    for key in chosen.required():
        if key not in in_si:
            raise InputError(
                f"{where}: [enclosure] {key} is missing; give it for shape = {chosen.shape!r}, "
                "like '40 mm'"
            )
    try:
        return chosen(**in_si)
    except ValueError as error:
        raise InputError(f"{where}: [enclosure] {error}") from None


def motion_of(motion: Motion, where: str) -> Any:
    """Return the numbers of the enclosure's motion; InputError where they cannot be."""
    kind = MOTIONS[motion.kind]
    own = motion.model_extra or {}
    with located(f"{where}: [motion]"):
        values = {key: to_si(value, kind.units[key], key) for key, value in own.items()}
    try:
        return kind.of_case(motion.gamma, motion.frequency, GRAVITY, motion.ramp, **values)
    except (TypeError, ValueError) as error:
        raise InputError(f"{where}: [motion] kind = {motion.kind!r}: {error}") from None


def count_of(enclosure: Enclosure, particle: MultiSphere, particles: Particles, where: str) -> int:
    """The number of particles, by count or fill ratio; InputError where they cannot be inside."""
    given, ratio = particles.count, particles.fill_ratio
    size = 2.0 * particle.bounding_radius
    if enclosure.narrowest < size:
        unit = ", or the unit of the mesh (mesh_unit)" if particle.kind == "mesh" else ""
        raise InputError(
            f"{where}: [enclosure] {1e3 * enclosure.narrowest:.6g} mm at the narrowest, "
            f"{enclosure.narrowest_place}: smaller than a particle, {1e3 * size:g} mm; give a "
            f"larger enclosure or smaller particles{unit}"
        )
    capacity = enclosure.volume / particle.volume
    wanted = usual_fill_ratio(particle.kind) if ratio is None else ratio
    count = max(round(wanted * capacity), 1)
    if given is not None and ratio is not None and given != count:
        raise InputError(
            f"{where}: [particles] count = {given} and fill_ratio = {ratio:g}: the ratio makes "
            f"{count}; leave one of them out"
        )
    count = count if given is None else given
    close = close_packing(particle.name)
    most = close.value if close else 1.0  # of a shape that is not known, the filling says
    fit = max(math.floor(most * capacity), 1)
    if count > fit:
        above = f"random close packing, {most:.3g}" if close else "1"
        said = f"count = {count}: fill ratio {count / capacity:.3f}"
        if given is None and ratio is not None:
            said = f"fill_ratio = {ratio:g}: {count} particles"
        raise InputError(f"{where}: [particles] {said}, above {above}; at most {fit} fit")
    if count > MOST_PARTICLES:
        source = "the usual fill ratio" if ratio is None else f"fill_ratio = {ratio:g}"
        raise InputError(
            f"{where}: [particles] count = {count}, from {source}: must be at most "
            f"{MOST_PARTICLES}; check the units of sizes, or give a count"
        )
    return count


def usual_fill_ratio(*kinds: str) -> float:
    """That of the thesis's 90 spheroids, 110 toroids or 358 spheres in 40 mm x 40 mm.

    kinds: of the shapes; of several it is that of spheres.
    """
    kind, *others = set(kinds)
    if others or kind == "sphere":
        return USUAL_FILL_RATIO
    sphere = 4.0 / 3.0 * math.pi * usual(kind).radius ** 3
    return usual(kind).count * sphere / cylinder(0.04, 0.04).volume


def particle_wanted(particles: Particles | Kind, folder: Path) -> Particle:
    """Shape that [particles] or a kind requests; folder: looked through first for a mesh."""
    wanted = Particle(
        particles.shape, particles.equal_volume_radius, particles.sub_spheres,
        particles.tolerance, particles.mesh_unit, folder,
    )  # fmt: skip
    if wanted.mesh is None or is_file(wanted.mesh):
        return wanted
    return dataclasses.replace(wanted, folder=Path())


def mesh_copy(wanted: Particle) -> dict[str, str]:
    """The mesh of a particle as a file for the run folder: its name and text; none has none."""
    if wanted.mesh is None:
        return {}
    return {name_of_copy(wanted): as_obj(read_triangles(wanted.mesh))}


def name_of_copy(wanted: Particle) -> str:
    """The name of that file."""
    return f"{Path(wanted.values).stem}.obj"


def with_copies(particles: Particles) -> Particles:
    """The keys of [particles], with the files of the run folder in place of meshes."""
    if particles.kind is not None:
        return particles.model_copy(update={"kind": [_with_copy(kind) for kind in particles.kind]})
    return _with_copy(particles)


def _with_copy(given: _Shaped) -> _Shaped:
    wanted = Particle(given.shape)
    if wanted.mesh is None:
        return given
    return given.model_copy(update={"shape": f"mesh:{name_of_copy(wanted)}"})


def with_usual_cycles(settings: Settings, document: dict[str, Any]) -> Settings:
    """The settings with the thesis's number of cycles for the shape, where the case gives none."""
    spheres = all(Particle(one.shape).kind == "sphere" for one in settings.particles.kinds)
    if spheres or "cycles" in document.get("run", {}):
        return settings
    run = settings.run.model_copy(update={"cycles": SHAPED_CYCLES})
    run.model_fields_set.discard("cycles")  # a host or an excitation has a length of its own
    return settings.model_copy(update={"run": run})


def gravity_of(motion: Motion, where: str) -> tuple[np.ndarray, np.ndarray]:
    """Gravity [m/s2] of the motion and of the settling."""
    found = _gravities(motion, where)
    along = direction_of(motion, f"{where}: [motion] direction")
    if motion.orientation == "horizontal" and orientation_of(found[0], along) != "horizontal":
        raise InputError(
            f"{where}: [motion] orientation = 'horizontal': by the gravity or direction that is "
            "given the motion is vertical; leave orientation out, or these"
        )
    return found


def _gravities(motion: Motion, where: str) -> tuple[np.ndarray, np.ndarray]:
    if motion.gravity is not None:
        if motion.orientation == "none":
            raise InputError(
                f"{where}: [motion] gravity is given, and orientation = 'none' has none; leave one "
                "of them out"
            )
        vector = GRAVITY * unit_vector(motion.gravity, f"{where}: [motion] gravity")
        return vector, vector
    down = np.array([0.0, 0.0, -GRAVITY])
    across = np.array([-GRAVITY, 0.0, 0.0])
    if motion.orientation == "none":
        return np.zeros(3), down
    return (across, across) if motion.orientation == "horizontal" else (down, down)


def direction_of(motion: Motion, what: str) -> np.ndarray:
    """Direction (3,) of the motion, of length one; InputError, on `what`, where it has none."""
    return unit_vector(motion.direction or [0.0, 0.0, 1.0], what)


def orientation_of(gravity: np.ndarray, direction: np.ndarray) -> str:
    """Direction of gravity (3,) to the motion, a unit vector (3,): vertical, horizontal or none.

    Gravity is vertical where it is nearer to the axis of the motion than to the plane across it.
    """
    size = float(np.linalg.norm(gravity))
    if size == 0.0:
        return "none"
    return "vertical" if abs(gravity @ direction) > size * math.sqrt(0.5) else "horizontal"


def unit_vector(vector: list[float], what: str) -> np.ndarray:
    """The vector at length one; InputError where it has no direction."""
    largest = max(abs(x) for x in vector)
    if not 0.0 < largest < math.inf:
        raise InputError(f"{what} = {vector}: has no direction; write such as [0, 0, 1]")
    scaled = np.array(vector) / largest  # squares neither overflow nor vanish
    return scaled / np.linalg.norm(scaled)


def check_protocol(settings: Settings, where: str) -> None:
    """Raise InputError where cycles, samples and frames, or parts of the law, do not fit."""
    if settings.law.yielding and settings.law.contact_treatment == "scaled":
        raise InputError(
            f"{where}: [law] yielding = true goes by the mass and radius of each contact, which "
            "contact_treatment = 'scaled' shares out; give 'sum' or 'deepest', or yielding = false"
        )
    run, output = settings.run, settings.output
    cycles = run.max_cycles if run.steady else run.cycles
    # A host's last cycles count, and discard only says from when on it is judged.
    on_host = run.steady and given(settings.host)
    if run.discard >= cycles and not on_host:
        key = "max_cycles" if run.steady else "cycles"
        raise InputError(
            f"{where}: [run] discard = {run.discard}: must be below {key} = {cycles}, or none is "
            "left to count"
        )
    if settings.motion.ramp > cycles:
        raise InputError(
            f"{where}: [motion] ramp = {settings.motion.ramp:g} cycles: the amplitude would not be "
            f"reached in {cycles}; give less, or more cycles"
        )
    if output.frames and output.samples % output.frames:
        near = [n for n in range(1, output.samples + 1) if output.samples % n == 0]
        best = min(near, key=lambda n: abs(n - output.frames))
        raise InputError(
            f"{where}: [output] frames = {output.frames}: must divide samples = {output.samples}; "
            f"give {best}, or 0 for none"
        )
