"""An enclosure from outside the package: the closed cone that docs/examples/extend describes.

The same goes for any other: a frozen dataclass with the sizes, a named tuple with the numbers of
its curved walls, a function for their geometry, and one call of register_enclosure. A process of
its own runs it, see extended_damper.py, so that the enclosure is not known to the other tests.
"""

import importlib
import sys
from pathlib import Path
from typing import Any

import numpy as np

from damper3d import DamperCase
from damper3d.case.settings import read_settings
from damper3d.engine import ENGINE
from damper3d.run.fill import resting
from damper3d.run.packing import load_packing, packing_folder
from granulab.contact.jit import cache_folder, extensions
from granulab.errors import InputError

EXAMPLE = Path(__file__).parents[2] / "docs" / "examples" / "extend" / "enclosure.py"


def register():
    """Make it known to this process, which the example does where it is imported."""
    sys.path.insert(0, str(EXAMPLE.parent))
    importlib.import_module(EXAMPLE.stem)


CASE = {
    "enclosure.shape": "cone",
    "enclosure.diameter": "30 mm",
    "enclosure.lid_diameter": "16 mm",
    "enclosure.height": "25 mm",
    "particles.count": 24,
    "fill.settle_time": "20 ms",
    "run.cycles": 2,
    "run.discard": 1,
    "output.samples": 40,
    "output.frames": 10,
}


def clear(case, x):
    """Least distance (n,) [m] of points from any wall, by another formula than the engine's."""
    cone = case.enclosure
    corners = np.array([[cone.diameter / 2, 0.0], [cone.lid_diameter / 2, cone.height]])
    along = (corners[1] - corners[0]) / np.linalg.norm(corners[1] - corners[0])
    from_corner = np.stack([np.hypot(x[:, 0], x[:, 1]), x[:, 2]], axis=1) - corners[0]
    side = along[0] * from_corner[:, 1] - along[1] * from_corner[:, 0]
    return np.min([side, x[:, 2], cone.height - x[:, 2]], axis=0)


WRONG = {
    "lid_diameter is missing": {"enclosure.lid_diameter": None},
    "unit is wrong": {"enclosure.lid_diameter": "16 s"},
    "width and depth go with shape = 'box'": {"enclosure.width": "3 cm"},
    "unknown key 'lid_diameter'": {"enclosure.shape": "cylinder"},
    "unknown key 'top'; known: ": {"enclosure.top": "3 cm"},
}


def refused(change):
    """The line that refuses a case with a change; a key that is None is left out."""
    changes = {key: value for key, value in {**CASE, **change}.items() if value is not None}
    try:
        DamperCase.load("thesis", changes)
    except InputError as error:
        return str(error)
    return "nothing is wrong"


def found(case, result, out) -> dict[str, Any]:
    """What became of a case that is filled and shaken in it, with all runs in `out`."""
    file = Path(result.run_folder) / "case.toml"
    packing = load_packing(packing_folder(case, Path(out)))
    sim = resting(case, packing.state["position"][:, :3])
    sim.begin_phase(shaker=case.shaker)
    least = []
    for _ in range(20):
        sim.step(500)
        least.append(clear(case, sim.frame()["x"]).min())
    return {
        "again": DamperCase.load(file).enclosure == case.enclosure,
        "written": read_settings(file)["enclosure"], "least": min(least), "bed": packing.fraction,
        "refused": [refused(change) for change in WRONG.values()],
        "extends": EXAMPLE.resolve() in extensions(ENGINE), "kept": cache_folder(ENGINE),
    }  # fmt: skip


def test_a_case_runs_in_it(extended_damper):
    """The balance of energy closes, and no sphere of 5 mm gets further into a wall than a bit."""
    found = extended_damper["enclosure"]
    assert abs(extended_damper["closure"]) < 0.02
    assert extended_damper["efficiency"] > 0.01
    assert found["least"] > 0.98 * 2.5e-3
    assert 0.1 < found["bed"] < 0.65


def test_the_case_is_kept_with_its_own_keys(extended_damper):
    found = extended_damper["enclosure"]
    assert found["again"]
    assert found["written"]["lid_diameter"] == "16 mm"


def test_its_file_counts_as_a_source(extended_damper):
    """Kernels are kept by it: a process that does not know it uses another folder."""
    found = extended_damper["enclosure"]
    assert found["extends"]
    assert found["kept"] != cache_folder(ENGINE)


def test_what_is_wrong_is_one_line(extended_damper):
    for words, line in zip(WRONG, extended_damper["enclosure"]["refused"], strict=True):
        assert words in line
        assert "\n" not in line
