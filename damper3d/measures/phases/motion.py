"""Motion of the particles in the counted cycles of a run, as a few plain arrays.

The coordinate along the enclosure's motion is called z here, whatever its direction: the first two
columns of positions and velocities lie across it. An end is what stops the bed along z.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.case.parts import orientation_of
from damper3d.case.random_packing import CLOSE_PACKING, LOOSE_PACKING, close_packing
from damper3d.measures.counted import discarded

if TYPE_CHECKING:
    from damper3d.case.case import DamperCase
    from damper3d.engine.enclosures import Enclosure
    from granulab.campaign.runs.ragged import Tables

# Columns of the tables that are read: about half of what a run keeps.
_STORED = {"particles": ("x", "y", "z", "vx", "vy", "vz"), "contacts": ("body_1", "body_2")}
_TIGHT = 0.01  # of the length, that a bed is taken to have free whatever its packing [-]
_STEEP = np.sqrt(0.5)  # of a normal along the motion, above which a wall is an end
FEWEST_FRAMES = 8  # a cycle: an eighth of it is as far as a particle may go unseen


@dataclass(frozen=True)
class Motion:
    """Whole cycles of a run: C of them, of S samples and n frames each; SI.

    The frames are at equal times over the cycles, with the one that the first cycle starts from
    where the run kept it: F = C n + 1, or C n.
    """

    period: float
    gravity: np.ndarray  # (3,) in the axes of x
    length: float  # between the two ends [m]
    clearance: float  # what a loose packing would leave free of it [m] (eq. 6.13)
    radius: np.ndarray  # (N,) of the spheres around the particles
    mass: np.ndarray  # (N,)
    push: np.ndarray  # (C, S, 2) on the bed by the lower and the upper end, inwards [N]
    speed: np.ndarray  # (C, S) of the enclosure [m/s]
    bed_height: np.ndarray  # (C, S) mean z of the bed's mass, relative to the enclosure
    n: int  # frames a cycle
    x: np.ndarray  # (F, N, 3) positions relative to the enclosure's lower end
    v: np.ndarray  # (F, N, 3) velocities in the laboratory
    touching: np.ndarray  # (F,) share of the particles in contact with anything
    displacement: np.ndarray  # (F,) of the enclosure, at the frames
    frame_speed: np.ndarray  # (F,) likewise its velocity
    cell: np.ndarray | float = 0.0  # (N, 3) to its own of equal cells, from the first, where x is

    @property
    def peak_speed(self) -> float:
        """The enclosure's largest speed [m/s]; Gamma g / omega for one sine."""
        return float(np.abs(self.speed).max())

    @property
    def orientation(self) -> str:
        """vertical, horizontal or none: how gravity points to the motion."""
        return orientation_of(self.gravity, np.array([0.0, 0.0, 1.0]))


def clearance(fill_ratio: float, length: float, shape: str = "sphere") -> float:
    """Free length above a loose packing (eq. 6.13) [m], of particles of a shape.

    Never less than half of what a close packing of the shape would leave: a bed poured tighter than
    0.55 can still move; and of one packed closer than at random never less than _TIGHT.
    """
    known = close_packing(shape)
    close = CLOSE_PACKING if known is None else known.value
    left = 1.0 - fill_ratio / LOOSE_PACKING, 0.5 * (1.0 - fill_ratio / close)
    return length * max(*left, _TIGHT)


def take(
    case: "DamperCase",
    samples: Mapping[str, np.ndarray],
    frames: Mapping[str, np.ndarray],
    *,
    discard: int | None = None,
) -> Motion | None:
    """The counted cycles of a run in memory.

    samples     columns of the run (records.py), one row a sample and one before the first
    frames      "row" (F,) of the sample that each frame came with; "x", "v" (F, N, 3) in the
                enclosure's axes; "touching" (F,) share of the particles in contact;
                "radius", "mass" (N,)
    discard     cycles that do not count; the case's where None

    None where no whole cycle counts or fewer than eight frames a cycle were kept, and of a motion
    that has no phases, which go by the cycles of one sine along a direction: under an excitation of
    another kind, or on a host that twists.
    """
    if case.excitation is not None or case.arc is not None:
        return None
    per_cycle = case.settings.output.samples
    first = (case.settings.run.discard if discard is None else discard) * per_cycle
    rows = np.asarray(frames["row"])
    n_cycles = (len(samples["time"]) - 1 - first) // per_cycle
    last = first + n_cycles * per_cycle
    chosen = (rows >= first) & (rows <= last)
    n = round((chosen & (rows > first)).sum() / max(n_cycles, 1))
    if n_cycles < 1 or n < FEWEST_FRAMES or chosen.sum() <= n:  # none a cycle apart
        return None
    axes = _axes(case.direction)
    low, length = _ends(case, axes)
    counted = slice(first + 1, last + 1)
    shape = (n_cycles, per_cycle)
    push = _pushes(samples["wall_force"][counted], case.enclosure, axes)
    at, x = rows[chosen], np.asarray(frames["x"][chosen], float)
    mass, cell = np.asarray(frames["mass"], float), _from_first(case.enclosure.cells, x[0])
    position = samples["mean_position"][counted] - mass @ cell / mass.sum()
    return Motion(
        period=case.period,
        gravity=axes @ case.gravity,
        length=length,
        clearance=clearance(case.fill_ratio, length, case.particle.name),
        radius=np.asarray(frames["radius"], float),
        mass=mass,
        push=push.reshape(*shape, 2),
        speed=samples["velocity"][counted].reshape(shape),
        bed_height=(position @ axes[2] - low).reshape(shape),
        n=n,
        x=(x - cell) @ axes.T - [0.0, 0.0, low],
        v=np.asarray(frames["v"][chosen], float) @ axes.T,
        touching=np.asarray(frames["touching"], float)[chosen],
        displacement=np.asarray(samples["displacement"][at], float),
        frame_speed=np.asarray(samples["velocity"][at], float),
        cell=cell @ axes.T,
    )


def of_run(folder: str | Path, discard: int | None = None) -> Motion | None:
    """The counted cycles of a run folder, finished or not; None as `take`.

    `discard` None: as its summary says, or else its case. Raises FolderError where the folder
    holds no run or a damaged one.
    """
    from damper3d.case.case import DamperCase
    from granulab.campaign.runs.folder import RunFolder
    from granulab.campaign.runs.trajectory import read_trajectory, stored_tables

    run = RunFolder(Path(folder))
    discard = discarded(run) if discard is None else discard
    case, samples = DamperCase.load(run.case_file), read_trajectory(run.path)
    tables = stored_tables(run.path, _STORED)
    if "particles" not in tables:
        return None
    table = tables["particles"]

    def vectors(*names: str) -> np.ndarray:
        columns = [table.columns[name].reshape(len(table), -1) for name in names]
        return np.stack(columns, axis=-1)

    frames = {
        "row": table.frame,
        "x": vectors("x", "y", "z"),
        "v": vectors("vx", "vy", "vz"),
        "touching": touching(tables["contacts"], case.count),
        **spheres_around(case),
    }
    return take(case, samples, frames, discard=discard)


def spheres_around(case: "DamperCase") -> dict[str, Any]:
    """Radius and mass of the case's particles, as `take` requires them."""
    return {
        "radius": np.full(case.count, case.particle.bounding_radius)
        if case.bed is None
        else case.bed.bounding_radius,
        "mass": case.masses,
    }


def touching(contacts: "Tables", count: int) -> np.ndarray:
    """Share of the particles that are in a contact, of each table of contacts (S,)."""
    shares = []
    for k in range(len(contacts)):
        pairs = contacts.at(k)
        both = np.concatenate([pairs["body_1"], pairs["body_2"]])
        shares.append(len(np.unique(both[both < count])) / count)  # walls come after the particles
    return np.array(shares)


def _axes(direction: np.ndarray) -> np.ndarray:
    """Rows: two directions across the motion, and its own (3, 3)."""
    z = np.asarray(direction, float) / np.linalg.norm(direction)
    # Across: the enclosure's x, or its y where the motion runs along x.
    other = np.array([1.0, 0.0, 0.0]) if abs(z[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    x = other - (other @ z) * z
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z])


def _ends(case: "DamperCase", axes: np.ndarray) -> tuple[float, float]:
    """z of the lower end and the length from there to the upper one, through the middle."""
    down, up = case.enclosure.through(axes[2])
    return float(case.enclosure.middle @ axes[2] + down), up - down


def _from_first(cells: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Way (N, 3) [m] from the first cell to that in which each particle is; cells: centres (n, 2).

    All cells lie one over the other by it, so that a bed is measured in its own.
    """
    own = ((x[:, None, :2] - cells) ** 2).sum(axis=2).argmin(axis=1)
    return np.column_stack([cells[own] - cells[0], np.zeros(len(x))])


def _pushes(wall_force: np.ndarray, enclosure: "Enclosure", axes: np.ndarray) -> np.ndarray:
    """Force of the walls below and above on the bed, along the motion, inwards (rows, 2) [N].

    A wall is below where its normal points up by more than 45 degrees; a round one that does so at
    one place and points down at another pushes up from below and down from above, so that its force
    counts by its sign.
    """
    on_bed = -np.asarray(wall_force, float) @ axes[2]  # (rows, walls)
    least, most = _facing(enclosure, axes).T
    below, above = least > _STEEP, most < -_STEEP
    around = on_bed[:, (least < -_STEEP) & (most > _STEEP)]
    up = on_bed[:, below].sum(axis=1) + np.maximum(around, 0.0).sum(axis=1)
    down = -on_bed[:, above].sum(axis=1) + np.maximum(-around, 0.0).sum(axis=1)
    return np.stack([up, down], axis=1)


def _facing(enclosure: "Enclosure", axes: np.ndarray) -> np.ndarray:
    """Least and largest part along the motion of the inward normal of each wall (walls, 2).

    Of a curved wall as seen from about the middle; in a void without flat walls all that there are
    face all ways.
    """
    from damper3d.engine.enclosures import nearest_of

    flat = enclosure.planes[:, :3] @ axes[2]
    curved = len(enclosure.wall_names) - len(flat)
    if not len(flat):
        return np.tile([-1.0, 1.0], (curved, 1))
    surface = enclosure.surface
    nearest: Callable[..., Any] = nearest_of(type(surface))
    about = enclosure.middle + 1e-3 * enclosure.narrowest * np.vstack([axes, -axes])
    found = [[flat_one, flat_one] for flat_one in flat]
    for wall in range(curved):
        normal = np.array([nearest(surface, wall, *point)[1] for point in about])
        inward = -normal @ axes[2]
        found.append([inward.min(), inward.max()])
    return np.array(found)
