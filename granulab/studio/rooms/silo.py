"""Silos on the page: the preview of a case, frames of a run, shapes, drawings, materials."""

import json
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.trajectory import Trajectory, read_trajectory
from granulab.contact.files.datafile import case_names, data_file
from granulab.errors import FolderError
from granulab.studio.rooms.simulator import Bench
from silo2d.case.case import SiloCase, outline_of
from silo2d.case.filling import Layer, layers_of
from silo2d.case.outline import PRESETS, Outline
from silo2d.case.plan import expected_particles
from silo2d.case.settings import Settings, check_settings, read_settings
from silo2d.case.shape import ShapeSet
from silo2d.run.pour import rain
from silo2d.run.result import Result
from silo2d.run.sweep import SILO
from silo2d.view import report
from silo2d.view.player import player_page

_MOST_PARTICLES = 20_000  # that a page draws
_DIGITS = 6  # of metres and radians that are sent


def bench() -> Bench:
    """Silos, for the page."""
    return Bench(
        command="silo2d",
        settings=Settings,
        presets=lambda: [*PRESETS, *case_names("silo")],
        preset=_preset,
        read=read_settings,
        resolve=SiloCase.resolve,
        simulator=SILO,
        echo=partial(report.echo, dry_run=True),
        preview=preview,
        sketch=sketch,
        frame=frame,
        report=lambda run: report.report(Result.read(RunFolder(run), reused=False)),
        compare=compare,
        player=player_page,
    )


def _preset(name: str) -> dict[str, Any]:
    if name in PRESETS:
        return {"name": name, "silo": {"preset": name}}
    path = data_file("cases", name)
    assert path is not None
    return read_settings(path)


def preview(case: SiloCase) -> dict[str, Any]:
    """The silo [m], its shapes, and the particles as they will be poured, before they fall.

    Those are the first of the filling's own random numbers: kinds, positions and angles by which
    the run of this seed begins; none where there are too many to draw.
    """
    layer, expected = case.settings.fill.layer, expected_particles(case)
    kinds, poses = np.zeros(0, np.int64), np.zeros((0, 3))
    if expected <= _MOST_PARTICLES:
        first = Layer(*layers_of(case.settings.fill)[0], 0.0)
        kinds, poses, _ = rain(case, np.random.default_rng(case.settings.run.seed), first)
    return {
        **_walls(case.outline),
        "level": case.settings.fill.level,
        "shapes": outlines_of(case.shapes),
        "particles": {"kind": kinds.tolist(), "pose": _rounded(poses)},
        "expected": expected,
        "poured": f"the first layer of {layer:g} m" if layer else "all at once",
    }


def sketch(tables: dict[str, Any], file: str) -> dict[str, Any]:
    """The silo [m] of a case that is refused for something else; InputError where it is none."""
    own: dict[str, Any] = {name: tables[name] for name in ("name", "silo") if name in tables}
    return _walls(outline_of(check_settings(own, file), file))


def _walls(outline: Outline) -> dict[str, Any]:
    return {
        "outline": _rounded(outline.polygon),
        "lips": [list(lip) for lip in outline.lips],
        "inserts": [_rounded(insert) for insert in outline.inserts],
        "outlets": [_rounded(ends) for ends in outline.outlets],
    }


def outlines_of(shapes: ShapeSet) -> list[dict[str, Any]]:
    """Rounded outlines [m] of the shapes of a set, with their names and shares."""
    return [
        {"name": shape.name, "share": share, "outline": _rounded(shape.rounded_outline())}
        for shape, share in zip(shapes.shapes, shapes.shares, strict=True)
    ]


def frame(run: Path) -> dict[str, Any]:
    """The last stored frame of a run: time, particles inside and out, and their poses."""
    last = read_trajectory(run, lambda name, stored: slice(-1, None))
    if "time" not in last or "shape_points" not in last.static:
        raise FolderError(f"{run}: no frame yet")
    inside = last["inside"][-1]
    names = json.loads(last.attributes["wall_names"])
    stands = [not name.startswith("door") for name in names]
    poses = np.column_stack([last[name][-1][inside] for name in ("x", "y", "angle")])
    return {
        "time": float(last["time"][-1]),
        "out": int(last["n_out"][-1]),
        "of": len(last.static["kind"]),
        "shapes": [{"outline": _rounded(part)} for part in _outlines(last)],
        "walls": _rounded(last.static["wall_segments"][stands]),
        "particles": {
            "kind": last.static["kind"][inside].tolist(),
            "layer": last.static["layer"][inside].tolist(),
            "pose": _rounded(poses),
        },
    }


def compare(first: Path, second: Path) -> tuple[str, Path]:
    """Two runs side by side: a table, and a picture in the first's folder."""
    from granulab.campaign.output.figure import write_figure
    from silo2d.view import compare as comparison

    pairs = [comparison.compare(first, second)]
    picture = first / "figures" / f"beside-{second.name}.png"
    write_figure(picture, lambda: comparison.draw(pairs))
    return comparison.table(pairs), picture


def _outlines(found: Trajectory) -> list[np.ndarray]:
    return np.split(found.static["shape_points"], found.static["shape_start"][1:-1])


def _rounded(values: np.ndarray) -> list[Any]:
    return np.round(values, _DIGITS).tolist()
