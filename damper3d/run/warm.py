"""Compiles every kernel once, before many processes need them at the same time."""

import tempfile
from pathlib import Path

from damper3d.case.case import DamperCase
from damper3d.engine import ENGINE
from damper3d.run.protocol import run
from granulab.campaign.runs.lock import once
from granulab.contact.jit import cache_folder

# A few spheres in a small enclosure: all kernels of a filling and of a cycle.
_SMALL = {
    "enclosure.diameter": "20 mm",
    "enclosure.height": "20 mm",
    "particles.count": 10,
    "fill.settle_time": "1 ms",
    "run.cycles": 1,
    "run.discard": 0,
    "output.keep": "summary",
}


def compile_kernels() -> None:
    """Compile what is not compiled yet, while other processes that need it wait."""

    def shake_a_small_damper() -> None:
        with tempfile.TemporaryDirectory() as place:
            run(DamperCase.load("thesis", _SMALL), out=place)

    once(Path(cache_folder(ENGINE)), "damper-compiled", shake_a_small_damper)
