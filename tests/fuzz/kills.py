"""Runs that are killed, and surroundings that fail: nothing is lost, one line says what is wrong.

    python tests/fuzz/kills.py [--kills 100] [--seed 18] [--only WORK] [--write FILE]

kill -9 at random moments over both simulators (checkpoints so often that a run goes on from one
again and again), sweeps on processes and on Dask, and a fit; what is gone on with must end with
the bits of what was never killed. Then full disks, read-only folders, no home, two at once.
"""

import argparse
import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from random import Random
from unittest import mock

sys.path.insert(0, str(Path(__file__).parents[1] / "helpers"))

from calibrating import calibrate
from damper_runs import OFTEN, small
from forking import Forked, killed_at
from in_process import ThisProcess
from judged import judge
from same_run import assert_same_run
from small_damper import damper3d, write_damper
from small_fit import run_here, write_fit
from small_silo import SLOW, Completed, silo2d, the_run, write_case

from damper3d.run import protocol as damper
from damper3d.run import vibration
from silo2d.case.case import SiloCase
from silo2d.run import protocol as silo

SEED = 18
KILLS_EACH = 6  # of one run, which then goes on to its end
STUDY = 'schema = 1\ncase = "small.toml"\nseeds = 2\n[vary]\nlaw.mu_wall = [0.2, 0.3]\n'
SHARES = {"silo": 30, "damper": 30, "sweep": 14, "sweep on Dask": 12, "fit": 14}


@dataclass
class Count:
    """Kills of a work, how often it was gone on with to its end, and how often to other bits."""

    kills: int = 0
    whole: int = 0
    bad: int = 0


def _until_killed(
    chance: Random, kills: int, length: float, folder: Path,
    work: Callable[[Path], object], same: Callable[[Path], None], count: Count,
) -> None:  # fmt: skip
    """Kill a work until it was killed so often; length [s]: about that of all of it."""
    number = 0
    while count.kills < kills:
        number += 1
        root = folder / str(number)
        root.mkdir(parents=True)
        for _ in range(KILLS_EACH):
            moment = time.monotonic() + chance.uniform(0.0, 0.7 * length)
            if count.kills == kills or not killed_at(
                partial(_is_over, moment), 0.0, partial(work, root)
            ):
                break
            count.kills += 1
        work(root)
        _compared(partial(same, root), count)


def _compared(same: Callable[[], None], count: Count) -> None:
    try:
        same()
        count.whole += 1
    except AssertionError as error:
        count.bad += 1
        print(f"bad: {str(error)[:600]}", flush=True)


def _is_over(moment: float) -> bool:
    return time.monotonic() >= moment


def _timed(work: Callable[[Path], object], folder: Path) -> float:
    """Time [s] that a work takes whose kernels are there; what it makes is in whole/."""
    work(folder / "warm")
    begun = time.monotonic()
    work(folder / "whole")
    return time.monotonic() - begun


def _kill_run(chance: Random, kills: int, folder: Path, run: Callable[[Path], object]) -> Count:
    """Kills of a run in the folder that it is given."""
    whole, count = folder / "whole", Count()
    length = _timed(run, folder)
    _until_killed(
        chance, kills, length, folder, run,
        lambda root: assert_same_run(the_run(root), the_run(whole)), count,
    )  # fmt: skip
    return count


def kill_silo(chance: Random, kills: int, folder: Path) -> Count:
    """Kills while a silo is filled and emptied."""
    case = SiloCase.load(write_case(folder, SLOW))
    return _kill_run(chance, kills, folder, lambda root: silo.run(case, out=root))


def kill_damper(chance: Random, kills: int, folder: Path) -> Count:
    """Kills while a damper is filled and shaken."""
    case = small()
    with mock.patch.object(vibration, "CHECKPOINT_WORK", OFTEN):
        return _kill_run(chance, kills, folder, lambda root: damper.run(case, out=root))


def kill_fit(chance: Random, kills: int, folder: Path) -> Count:
    """Kills while a fit runs its simulations."""
    file, count = write_fit(folder), Count()
    options = ("--json", "--no-figures", "--quiet")

    def fit(root: Path) -> Completed:
        with mock.patch("calibration.inverse.fit.run_labelled", run_here):
            return calibrate("inverse", file, "-o", root, *options)

    length = _timed(fit, folder)
    right = _answer(fit(folder / "whole"))

    def same(root: Path) -> None:
        assert _answer(fit(root)) == right

    _until_killed(chance, kills, length, folder, fit, same, count)
    return count


def _answer(done: Completed) -> dict[str, object]:
    places = {"folder", "table", "figures"}
    return {k: v for k, v in done.json.items() if k not in places}


def _digests(root: Path) -> dict[str, str]:
    return {
        path.parent.name: json.loads(path.read_text(encoding="utf-8"))["state_digest"]
        for path in root.glob("*-seed*/summary.json")
    }


def _descendants(pid: int) -> list[int]:
    """Processes below one, youngest last."""
    found = []
    with contextlib.suppress(OSError):
        for task in Path(f"/proc/{pid}/task").iterdir():
            for child in (task / "children").read_text().split():
                found += [int(child), *_descendants(int(child))]
    return found


def _kill_sweep(
    chance: Random, kills: int, folder: Path, engine: list[str], others: Callable[[], list[int]]
) -> Count:
    """Kill the command of a sweep, or one of the processes that work for it."""
    write_case(folder, SLOW)
    study, count = folder / "study.toml", Count()
    study.write_text(STUDY, encoding="utf-8")
    with mock.patch("granulab.campaign.sweeps.engine._pool", ThisProcess):
        assert silo2d("sweep", study, "-o", folder / "whole", "--quiet").code == 0
    right, number = _digests(folder / "whole"), 0
    assert len(right) == 4
    while count.kills < kills:
        number += 1
        root = folder / str(number)
        command = [sys.executable, "-m", "silo2d", "sweep", str(study), "-o", str(root), "--quiet"]
        for _ in range(KILLS_EACH):
            process = subprocess.Popen([*command, *engine], stdout=subprocess.DEVNULL,
                                       stderr=subprocess.DEVNULL)  # fmt: skip
            time.sleep(chance.uniform(1.0, 12.0))
            if count.kills < kills and process.poll() is None:
                victim = chance.choice([process.pid, *(others() or _descendants(process.pid))])
                with contextlib.suppress(ProcessLookupError):
                    os.kill(victim, signal.SIGKILL)
                    count.kills += 1
                if victim == process.pid:
                    process.wait()
                    continue
            process.wait(timeout=600)  # who loses a worker goes on without
        done = subprocess.run([*command, *engine], capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, done.stderr

        def same(root: Path = root) -> None:
            assert _digests(root) == right, (root, _digests(root), right)

        _compared(same, count)
    return count


def kill_sweep(chance: Random, kills: int, folder: Path) -> Count:
    """Kills of a sweep on processes of this machine."""
    return _kill_sweep(chance, kills, folder, ["--workers", "2"], list)


def kill_dask(chance: Random, kills: int, folder: Path) -> Count:
    """Kills of a sweep on a Dask cluster of two workers, on the loopback alone."""
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1",
        silence_logs=50,
    ) as cluster:  # fmt: skip
        engine = ["--engine", "dask", "--scheduler", cluster.scheduler_address]

        def workers() -> list[int]:
            return [one.pid for one in cluster.workers.values() if one.pid]

        return _kill_sweep(chance, kills, folder, engine, workers)


KILLS = {
    "silo": kill_silo, "damper": kill_damper, "sweep": kill_sweep, "sweep on Dask": kill_dask,
    "fit": kill_fit,
}  # fmt: skip


# Surroundings. Each gives the words for what went wrong; nothing where all was well.


def _refused(name: str, done: Completed) -> list[str]:
    what, why = judge(name, done, quiet=True)
    return [] if what == "refused" else [f"{what}: {why} {done.err[:300]}"]


@contextlib.contextmanager
def _disk(folder: Path, size: str) -> Iterator[Path]:
    """A disk of its own in memory."""
    folder.mkdir(parents=True)
    mount = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", folder]
    subprocess.run(mount, check=True, stderr=subprocess.DEVNULL)
    try:
        yield folder
    finally:
        subprocess.run(["umount", folder], check=True)


def _may_mount(folder: Path) -> bool:
    try:
        with _disk(folder / "disk", "1M"):
            return True
    except (OSError, subprocess.CalledProcessError):
        return False


def _remount(folder: Path, option: str) -> None:
    subprocess.run(["mount", "-o", f"remount,{option}", folder], check=True)


PAIRS = {"silo2d": (silo2d, write_case), "damper3d": (damper3d, write_damper)}


def full_disk(folder: Path) -> Iterator[str]:
    """Disks that are full at several moments of a run; with room it ends with the same bits."""
    for name, (command, write) in PAIRS.items():
        case = write(folder)
        options = ("--no-figures", "--quiet")
        assert command("run", case, "-o", folder / name, *options).code == 0
        for size in (4, 20, 60, 100, 150):
            with _disk(folder / f"{name}-{size}", f"{size}k") as disk:
                yield from _refused(name, command("run", case, "-o", disk, *options))
                _remount(disk, "size=100M")
                done = command("run", case, "-o", disk, *options)
                if done.code or _digests(disk) != _digests(folder / name):
                    yield f"{name} {size}k: not the same once there is room: {done}"


def read_only(folder: Path) -> Iterator[str]:
    """A folder that nobody may write to, empty or with a run in it."""
    for name, (command, write) in PAIRS.items():
        case = write(folder)
        with _disk(folder / name, "10M") as disk:
            for option in ("ro", "rw", "ro"):
                _remount(disk, option)
                done = command("run", case, "-o", disk, "--no-figures", "--quiet")
                if option == "ro" and not list(disk.glob("*/summary.json")):
                    yield from _refused(name, done)
                elif done.code:
                    yield f"{name}: {done}"


def no_home(folder: Path) -> Iterator[str]:
    """No HOME, one that is not there, and one that is a file."""
    (folder / "file").touch()
    case = write_case(folder)
    keep = {k: v for k, v in os.environ.items() if k not in ("HOME", "XDG_CACHE_HOME")}
    for home in ({}, {"HOME": "/nowhere"}, {"HOME": str(folder / "file")}):
        done = subprocess.run(
            [sys.executable, "-m", "silo2d", "run", case, "-o", folder / "runs", "--quiet"],
            env=keep | home, capture_output=True, text=True, timeout=900,
        )  # fmt: skip
        what, why = judge(
            "silo2d", Completed(done.returncode, done.stdout, done.stderr), quiet=True
        )
        if what != "answered":
            yield f"{home}: {what} {why} {done.stderr[:300]}"


def full_output(folder: Path) -> Iterator[str]:
    """Answers that are sent to a device that is full."""
    for name, words in (("silo2d", ["run", "A4", "--dry-run"]), ("damper3d", ["list"])):
        with Path("/dev/full").open("w") as full:
            done = subprocess.run([sys.executable, "-m", name, *words], stdout=full,
                                  stderr=subprocess.PIPE, text=True, cwd=folder)  # fmt: skip
        yield from _refused(name, Completed(done.returncode, "", done.stderr))


def two_at_once(folder: Path) -> Iterator[str]:
    """The same run twice at the same time: one computes, the other waits or says so."""
    for name, (command, write) in PAIRS.items():
        case = write(folder, SLOW if name == "silo2d" else None)
        arguments = ("run", case, "--no-figures", "--quiet", "-o")
        assert command(*arguments, folder / name).code == 0
        for wait in (0.0, 0.1, 0.4):
            root = folder / f"{name}-{wait}"
            first = Forked(command, *arguments, root)
            time.sleep(wait)
            second = command(*arguments, root)
            done = [second, first.finish()]
            if not any(one.code == 0 for one in done) or _digests(root) != _digests(folder / name):
                yield f"{name}: {done}"
            for one in done:
                yield from _refused(name, one) if one.code else []


SURROUNDINGS = {
    "full disk": full_disk, "read-only folder": read_only, "no HOME": no_home,
    "full output": full_output, "two at once": two_at_once,
}  # fmt: skip


def _plan(kills: int) -> dict[str, int]:
    """Kills of each work; all of the two simulators where there are few."""
    if kills < 20:
        return {"silo": kills - kills // 2, "damper": kills // 2}
    return {name: round(kills * share / 100) for name, share in SHARES.items()}


def main() -> None:
    """Kill, spoil the surroundings, print the table, and keep it where that is wanted."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--only", action="append", choices=[*KILLS, *SURROUNDINGS])
    parser.add_argument("--write", type=Path)
    args = parser.parse_args()
    lines = [f"python tests/fuzz/kills.py --kills {args.kills} --seed {args.seed}", "",
             f"{'killed':20}{'kills':>10}{'gone on':>10}{'other bits':>12}"]  # fmt: skip
    total = Count()
    folder = Path(tempfile.mkdtemp())
    for name, kills in _plan(args.kills).items():
        if args.only and name not in args.only:
            continue
        (folder / name).mkdir()
        count = KILLS[name](Random(f"{name}/{args.seed}"), kills, folder / name)
        lines.append(f"{name:20}{count.kills:10}{count.whole:10}{count.bad:12}")
        print(lines[-1], flush=True)
        total = Count(total.kills + count.kills, total.whole + count.whole, total.bad + count.bad)
    lines += [f"{'all':20}{total.kills:10}{total.whole:10}{total.bad:12}", ""]
    may_mount = _may_mount(folder)
    for name, tried in SURROUNDINGS.items():
        if (args.only and name not in args.only) or (args.kills < 20 and name == "no HOME"):
            continue
        if tried in (full_disk, read_only) and not may_mount:
            lines.append(f"{name:20}not tried: a disk cannot be mounted here")
            continue
        (folder / name).mkdir()
        found = list(tried(folder / name))
        total.bad += len(found)
        lines += [f"{name:20}{'as it should' if not found else 'bad'}", *(f"  {w}" for w in found)]
        print(*lines[-1 - len(found) :], sep="\n", flush=True)
    print("\n".join(lines))
    if args.write:
        args.write.write_text("\n".join(lines) + "\n", encoding="utf-8")
    shutil.rmtree(folder)
    sys.exit(1 if total.bad else 0)


if __name__ == "__main__":
    main()
