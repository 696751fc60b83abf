"""Dampers on the page: the enclosure and the start of a case, frames of a run."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from damper3d.case.case import PRESETS, DamperCase
from damper3d.case.settings import EXAMPLES, Settings, read_settings
from damper3d.engine.enclosures import Enclosure
from damper3d.measures.efficiency import in_words
from damper3d.run.fill import random_start
from damper3d.run.result import Result
from damper3d.run.sweep import DAMPER
from damper3d.view import compare as comparison
from damper3d.view import report
from damper3d.view.player.page import player_page
from damper3d.view.player.walls import edges_of
from damper3d.view.scene import read_scene
from granulab.campaign.output.figure import write_figure
from granulab.campaign.runs.folder import RunFolder
from granulab.contact.files.datafile import case_names, data_file
from granulab.studio.rooms.simulator import Bench

_DIGITS = 7  # of metres that are sent
_MOST_SPHERES = 20_000  # that a page draws
_MOST_PARTICLES = 3000  # whose random start is computed for a look


def bench() -> Bench:
    """Dampers, for the page."""
    return Bench(
        command="damper3d",
        settings=Settings,
        presets=lambda: [*PRESETS, *EXAMPLES, *case_names("enclosure")],
        preset=_preset,
        read=read_settings,
        resolve=DamperCase.resolve,
        simulator=DAMPER,
        echo=partial(report.echo, dry_run=True),
        preview=preview,
        start=start,
        frame=frame,
        report=_report,
        compare=compare,
        player=player_page,
    )


def _preset(name: str) -> dict[str, Any]:
    if name in PRESETS:
        return {"name": name, **PRESETS[name]}
    if name not in EXAMPLES:
        path = data_file("cases", name)
        assert path is not None
        return read_settings(path)
    tables: dict[str, Any] = {"name": name}
    for key, value in EXAMPLES[name].items():
        section, _, own = key.partition(".")
        if value is not None:
            tables.setdefault(section, {})[own] = value
    return tables


def _report(run: Path) -> str:
    """The results of a run in words."""
    result = Result.read(RunFolder(run), reused=False)
    return report.report(result)


def preview(case: DamperCase) -> dict[str, Any]:
    """The enclosure [m] and numbers of a case; its particles are another question."""
    return {
        "walls": walls_of(case.enclosure),
        "up": _rounded(-case.gravity / (np.linalg.norm(case.gravity) or 1.0)),
        "along": _rounded(case.direction),
        "expected": case.count,
        "fill_ratio": case.fill_ratio,
    }


def start(tables: dict[str, Any], file: str, folder: Path) -> dict[str, Any]:
    """The particles of a case where its filling lets them go: grown at random, without overlap.

    Empty where there are too many for a look. InputError where they do not fit, as the run would
    refuse them.
    """
    case = DamperCase.resolve(tables, file, folder)
    if case.count > _MOST_PARTICLES:
        return {}
    centres, orientations = random_start(case, case.count)
    if orientations is None or case.bed is not None:
        return _spheres(centres, case.radii, np.arange(case.count))
    return _spheres(*_of_many(centres, orientations, case))


def _of_many(
    centres: np.ndarray, orientations: np.ndarray, case: DamperCase
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Spheres of multi-sphere particles: centres [m], radii [m], number of the particle."""
    offsets, radii, n = case.particle.offsets, case.particle.radii, len(centres)
    w, about = orientations[:, None, :1], orientations[:, None, 1:]
    first = np.cross(about, offsets[None])  # r + 2 w (q x r) + 2 q x (q x r), q a unit quaternion
    rotated = offsets[None] + 2.0 * w * first + 2.0 * np.cross(about, first)
    places = (centres[:, None] + rotated).reshape(-1, 3)
    return places, np.tile(radii, n), np.repeat(np.arange(n), len(radii))


def walls_of(enclosure: Enclosure) -> dict[str, Any]:
    """Edges of an enclosure: ends (e, 2, 3) [m], and normals of the faces beside each."""
    ends, normals = edges_of([points for _, points in enclosure.polygons])
    return {"ends": _rounded(ends), "normals": _rounded(normals)}


def frame(run: Path) -> dict[str, Any]:
    """The last stored frame of a run, in the frame of the enclosure."""
    scene = read_scene(run)
    cycles = scene.time[-1] / scene.period
    found = {
        "time": float(scene.time[-1]),
        "words": f"{cycles:.1f} cycles, t = {scene.time[-1]:.3f} s",
        "walls": walls_of(scene.enclosure),
        "up": _rounded(-scene.gravity / (np.linalg.norm(scene.gravity) or 1.0)),
        "along": _rounded(scene.direction),
    }
    if len(scene.tables):
        last = len(scene.tables) - 1
        offset, radius, which = scene.spheres(last)
        particles = scene.particles(last)
        speed = np.linalg.norm(particles.velocity, axis=1)
        found |= _spheres(particles.position[which] + offset, radius, which)
        found["speed"] = np.round(speed / (speed.max(initial=0.0) or 1.0), 3).tolist()
    if scene.summary:
        found["words"] = in_words(scene.summary)
    return found


def _spheres(centres: np.ndarray, radii: np.ndarray, which: np.ndarray) -> dict[str, Any]:
    if len(centres) > _MOST_SPHERES:
        return {}
    return {
        "spheres": _rounded(np.column_stack([centres, radii])),
        "which": which.tolist(),
    }


def compare(first: Path, second: Path) -> tuple[str, Path]:
    """Two runs side by side: a table, and a picture in the first's folder."""
    found = comparison.compare(first, second)
    picture = first / "figures" / f"beside-{second.name}.png"
    write_figure(picture, lambda: comparison.draw(found))
    return comparison.table(found), picture


def _rounded(values: Any) -> list[Any]:
    return np.round(np.asarray(values, dtype=float), _DIGITS).tolist()
