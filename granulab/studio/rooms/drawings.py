"""Outlines, shapes and materials on the page: from drawings, photographs, the mouse and files."""

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from granulab.contact.files.casefile import toml_value
from granulab.contact.files.datafile import data_file, data_names
from granulab.errors import InputError
from granulab.studio.folder import Folder
from granulab.studio.rooms.silo import outlines_of
from silo2d.case.shapefile import load_shapes
from silo2d.drawings.outline import outline_changes
from silo2d.drawings.shapes import import_shapes, positive_length

Ends = tuple[float, float, float, float]


def outline(folder: Folder, file: str, unit: str = "", layer: str = "") -> dict[str, Any]:
    """The corners [mm] of the silo in a drawing of the folder, and its outlet between two sides."""
    found = outline_changes(folder.file(file), unit or None, layer or None)
    return {
        key: found.get(f"silo.{key}") for key in ("outline", "outlet", "outlet_centre")
    }  # None: the whole lowest edge


def shapes(folder: Folder, name: str) -> dict[str, Any]:
    """The shapes of a shipped set, or of a shape file in the folder."""
    path = name if name in data_names("shapes") else folder.file(name)
    found = load_shapes(path)
    return {"shapes": outlines_of(found), "mean_area_m2": found.mean_area}


def particles(
    folder: Folder, file: str, *, spheroradius: str = "", tolerance: str = "", unit: str = "",
    layer: str = "", scale: str = "", bar: str = "", bar_at: Sequence[float] | None = None,
    name: str = "", replace: bool = False,
) -> dict[str, Any]:  # fmt: skip
    """The particles of a drawing or photograph of the folder, over the shapes that they become.

    Lengths are texts with units. name: of the shape file that is written of them; "": none.
    """
    if bar_at is not None and len(bar_at) != 4:
        raise InputError("the scale bar has two ends; mark both")
    found = import_shapes(
        folder.file(file), spheroradius=_length(spheroradius, "spheroradius"),
        tolerance=_length(tolerance, "tolerance"), unit=unit or None, layer=layer or None,
        scale=_length(scale, "length of a pixel"), bar_length=_length(bar, "length of the bar"),
        bar=tuple(bar_at) if bar_at is not None else None,  # type: ignore[arg-type]
    )  # fmt: skip
    taken = found.photograph
    return {
        "lines": found.lines(),
        "bar": taken and taken.bar,
        "size": taken and taken.size,
        "scale_m": taken and taken.scale,
        "outlines": [np.round(one, 6).tolist() for one in found.outlines],
        "rounded": [np.round(one.rounded, 6).tolist() for one in found.shapes],
        **(_written(folder, name, found.text(), replace) if name else {}),
    }


def draw_shapes(
    folder: Folder, name: str, spheroradius: str, shapes: Sequence[Mapping[str, Any]],
    replace: bool = False,
) -> dict[str, Any]:  # fmt: skip
    """Write a shape file of outlines [mm] that were drawn, once it is one that a case can read.

    name: of the file; "": none is written, and a shape that no case can read is refused all the
    same.
    """
    lines = [
        "# Drawn in granulab studio.", "schema = 1", f"spheroradius = {toml_value(spheroradius)}",
        'unit = "mm"',
    ]  # fmt: skip
    for shape in shapes:
        lines += ["", "[[shape]]"]
        lines += [
            f"{key} = {toml_value(shape[key])}" for key in ("name", "outline") if key in shape
        ]
    return _written(folder, name, "\n".join(lines) + "\n", replace)


def materials(folder: Folder, name: str) -> dict[str, Any]:
    """The values of a materials file with their sources, and what simulators still need of it."""
    from calibration.files.provenance import read_values, shown
    from granulab.contact.material import PROPERTIES

    _, values, needs = read_values(data_file("materials", name) or folder.file(name))
    return {
        "values": [
            {
                "section": section, "key": key,
                "value": shown(value, PROPERTIES[key].unit_in_files),
                "meaning": PROPERTIES[key].meaning, "trials": value.trials, "method": value.method,
                "source": value.source, "date": value.date and value.date.isoformat(),
                "before": len(value.history),
            }
            for (section, key), value in values.items()
        ],
        "lacking": needs,
    }  # fmt: skip


def _length(text: str, name: str) -> float | None:
    return positive_length(text if text.strip() else None, name)


def _written(folder: Folder, name: str, text: str, replace: bool) -> dict[str, Any]:
    """Keep a shape file that can be read; whether another stands under its name.

    InputError where something else than shapes stands there.
    """
    file = name if name.endswith(".toml") else f"{name or 'shapes'}.toml"
    with tempfile.TemporaryDirectory() as place:
        tried = Path(place) / "shapes.toml"
        tried.write_text(text, encoding="utf-8", newline="\n")
        try:
            load_shapes(tried)
        except InputError as error:
            raise InputError(str(error).replace(str(tried), file)) from None
    if not name:
        return {}
    if folder.path(file).is_file():
        try:
            load_shapes(folder.path(file))
        except InputError:
            raise InputError(f"{file}: holds no shapes; give these another name") from None
    return {"file": file, "exists": not folder.write(file, text, replace)}
