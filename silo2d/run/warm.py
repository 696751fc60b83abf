"""Compiles every kernel once, before many processes need them at the same time."""

import tempfile
from pathlib import Path

from granulab.campaign.runs.lock import once
from granulab.contact.jit import cache_folder
from silo2d.case.case import SiloCase
from silo2d.engine import ENGINE
from silo2d.run import protocol

# Some forty grains that fall a centimetre: all kernels of a filling and a discharge.
_SMALL = {
    "silo.angle": "45 deg",
    "silo.outlet": "60 mm",
    "silo.width": "120 mm",
    "silo.height": "150 mm",
    "fill.level": "100 mm",
    "fill.settled": 1e-2,
    "run.max_time": "20 ms",
}


def compile_kernels(*, drawn: bool = False) -> None:
    """Compile what is not compiled yet, while other processes that need it wait.

    drawn: those for pairs that draw their constants, which are kernels of their own.
    """

    def run_a_small_silo() -> None:
        with tempfile.TemporaryDirectory() as place:
            disorder = {"disorder.per": "pair"} if drawn else {}
            protocol.run(SiloCase.load("A4", _SMALL | disorder), out=place)

    once(
        Path(cache_folder(ENGINE)),
        "silo-drawn-compiled" if drawn else "silo-compiled",
        run_a_small_silo,
    )
