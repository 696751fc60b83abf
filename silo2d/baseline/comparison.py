"""The same packings discharged by several engines."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from granulab.campaign.runs.protocol import Progress
from granulab.contact.files.units import nearest
from granulab.errors import InputError
from silo2d.case.case import SiloCase
from silo2d.run.protocol import get_packing, run

ENGINES = ["dem", "pymunk"]


def engine_pair(text: str) -> list[str]:
    """Two engines of a list such as "dem,pymunk"; InputError for any other."""
    engines = [name.strip() for name in text.split(",")]
    for name in engines:
        if name not in ENGINES:
            raise InputError(f"--engines {text}: no engine {name!r}; {nearest(name, ENGINES)}")
    if len(engines) != 2 or engines[0] == engines[1]:
        raise InputError(f"--engines {text}: give two that differ, such as dem,pymunk")
    return engines


def run_engines(
    name: str,
    changes: dict[str, Any],
    engines: Sequence[str],
    seeds: Sequence[int],
    out: Path,
    progress: Progress,
    stop: Callable[[], bool],
) -> list[list[str]]:
    """Run folders, for each seed one of each engine, in their order.

    The packing is filled before either, so that the filling counts for neither's time.
    """
    folders = []

    def part(k: int) -> Progress:
        """Progress of the packing or run number k, of three a seed."""
        return lambda fraction, words: progress((k + fraction) / (3 * len(seeds)), words)

    for number, seed in enumerate(seeds):
        cases = [
            SiloCase.load(name, {**changes, "run.seed": seed, "run.engine": engine})
            for engine in engines
        ]
        get_packing(cases[0], out, part(3 * number), stop)
        runs = (
            run(case, out=out, progress=part(3 * number + k), stop=stop)
            for k, case in enumerate(cases, 1)
        )
        folders.append([result.run_folder for result in runs])
    return folders
