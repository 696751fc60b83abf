"""Inputs that are wrong, at the edge, or damaged, and what the programs make of each.

    python tests/fuzz/campaign.py [--times 1.0] [--only KIND] [--seed 18] [--write FILE]
    python tests/fuzz/campaign.py --only "silo case" --again 123   (that input alone; it stays)

A refusal is one line and the exit code 2 or 3; an answer lies within what physics allows
(data/ranges.toml). Bad are tracebacks, hangs, more than a line of refusal, wrong exit codes,
impossible answers, NaN, and an answer of a damaged run folder that is not the undamaged one's.
An input is made again from its kind, number and seed.
"""

import argparse
import collections
import contextlib
import io
import json
import os
import select
import shutil
import signal
import sys
import tempfile
import time
from dataclasses import asdict, dataclass, field
from pathlib import Path
from random import Random
from unittest import mock

sys.path.insert(0, str(Path(__file__).parents[1] / "helpers"))

from forking import fork
from in_process import ThisProcess
from judged import LIMIT, Verdict, answer_of, verdict
from kinds import KINDS, Call, main_of, reads
from small_silo import run_command
from stock import make_stock, runs_of

CHUNK = 50  # inputs a process
SEED = 18
Expected = dict[tuple[str, tuple[str, ...]], str]


@dataclass
class Ledger:
    """What the inputs of each kind came to."""

    seed: int
    counts: dict[str, collections.Counter[str]] = field(default_factory=dict)
    bad: list[tuple[str, int, str]] = field(default_factory=list)
    slowest: dict[str, float] = field(default_factory=dict)

    def add(self, kind: str, number: int, found: Verdict) -> None:
        """Count a verdict; a bad one is printed at once."""
        self.counts.setdefault(kind, collections.Counter())[found.what] += 1
        self.slowest[kind] = max(self.slowest.get(kind, 0.0), found.seconds)
        if (n := sum(map(collections.Counter.total, self.counts.values()))) % 500 == 0:
            print(f"{n} inputs, {len(self.bad)} of them bad", file=sys.stderr, flush=True)
        if found.what == "bad":
            self.bad.append((kind, number, found.why))
            print(f"bad: {kind} {number} (seed {self.seed}): {found.why}", flush=True)

    def table(self) -> str:
        """The counts, a line a kind, and every bad input."""
        columns = ["tried", "refused", "answered", "stopped", "bad"]
        lines = [
            "".join(
                ["input".ljust(20), *(name.rjust(10) for name in columns), "slowest s".rjust(12)]
            )
        ]
        total: collections.Counter[str] = collections.Counter()
        for kind, count in self.counts.items():
            total += count
            lines.append(_row(kind, count, columns, f"{self.slowest[kind]:.1f}"))
        lines.append(_row("all", total, columns, f"{max(self.slowest.values(), default=0.0):.1f}"))
        lines += [f"bad: {kind} {number}: {why}" for kind, number, why in sorted(self.bad)]
        return "\n".join(lines)


def _row(name: str, count: collections.Counter[str], columns: list[str], slowest: str) -> str:
    numbers = [count.total(), *(count[column] for column in columns[1:])]
    return name.ljust(20) + "".join(f"{n:10d}" for n in numbers) + slowest.rjust(12)


def tried(
    kind: str, number: int, seed: int, stock: Path, work: Path, expected: Expected
) -> Verdict:
    """The verdict on one input, in a fresh folder that is left to be looked at."""
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    with contextlib.chdir(work):
        call = KINDS[kind].make(Random(f"{kind}/{seed}/{number}"), stock)
        return verdict_on(call, expected)


def verdict_on(call: Call, expected: Expected) -> Verdict:
    """The verdict on a command in the working folder; sweeps run in this process."""
    right = expected.get(call.expected) if call.expected else None
    with mock.patch("granulab.campaign.sweeps.engine._pool", ThisProcess):
        found = verdict(call.program, main_of(call.program), call.arguments, call.patience, right)
    if found.what == "bad":
        found = Verdict("bad", f"{found.why} [{call.program} {call.arguments}]", found.seconds)
    return found


def prepared(root: Path, kinds: list[str]) -> tuple[Path, Expected]:
    """What the inputs of these kinds are made from, and the answers of undamaged run folders."""
    stock, of_runs = root / "stock", any(KINDS[kind].of_runs for kind in kinds)
    stock.mkdir()
    make_stock(stock, of_runs)
    return stock, undamaged(stock, root / "work") if of_runs else {}


def undamaged(stock: Path, work: Path) -> Expected:
    """The answers of the run folders as they are; the kernels are loaded with that."""
    found: Expected = {}
    for program in ("silo2d", "damper3d"):
        for run in runs_of(stock / "runs", program).values():
            for asked in reads(program, run.name):
                shutil.rmtree(work, ignore_errors=True)
                work.mkdir()
                shutil.copytree(run.parent, work / "runs")
                with contextlib.chdir(work):
                    result = run_command(program, main_of(program), *asked)
                if result.code == 0:  # the impulse engine has no contacts to be measured
                    found[program, asked] = answer_of(result)
                elif asked[0] == "run":
                    raise SystemExit(f"{asked}: {result.err}")
    return found


def _child(
    kind: str, numbers: range, seed: int, stock: Path, expected: Expected, pipe: int
) -> None:
    """Try some inputs in a copy of this process and send the verdicts, a line each."""
    work = stock.parent / f"work-{os.getpid()}"
    null = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):  # libraries print by themselves
        os.dup2(null, stream)
    sys.stdin = io.StringIO()
    for number in numbers:
        found = tried(kind, number, seed, stock, work, expected)
        os.write(pipe, (json.dumps(asdict(found)) + "\n").encode())
    shutil.rmtree(work, ignore_errors=True)


@dataclass
class _Job:
    """A child, what it tries, and what it has said."""

    pid: int
    kind: str
    numbers: range
    done: int = 0
    rest: bytes = b""
    heard: float = 0.0


def campaign(
    plan: dict[str, int], seed: int, jobs: int, ledger: Ledger, root: Path, end: float
) -> None:
    """Try so many inputs of each kind, each in a process that may die of it.

    end: on time.monotonic, after which no further ones are begun.
    """
    stock, expected = prepared(root, list(plan))
    waiting = [
        (kind, range(first, min(first + CHUNK, n)))
        for kind, n in plan.items()
        for first in range(0, n, CHUNK)
    ]
    Random(seed).shuffle(waiting)  # whatever the time takes away, it takes of all kinds
    running: dict[int, _Job] = {}
    while waiting or running:
        if time.monotonic() > end:
            waiting.clear()
        while waiting and len(running) < jobs:
            kind, numbers = waiting.pop()
            read, write = os.pipe()
            child = fork()
            if not child:
                os.close(read)
                try:
                    _child(kind, numbers, seed, stock, expected, write)
                finally:
                    os._exit(0)
            os.close(write)
            running[read] = _Job(child, kind, numbers, heard=time.monotonic())
        for pipe in select.select(list(running), [], [], 1.0)[0]:
            waiting += _heard(pipe, running, ledger)
        for job in running.values():
            if time.monotonic() - job.heard > 2 * LIMIT:  # deaf even to the alarm
                os.kill(job.pid, signal.SIGKILL)
                job.heard = time.monotonic()


def _heard(pipe: int, running: dict[int, _Job], ledger: Ledger) -> list[tuple[str, range]]:
    """Count what a child has said; what is left of its inputs where it has died."""
    job = running[pipe]
    data = os.read(pipe, 1 << 16)
    *lines, job.rest = (job.rest + data).split(b"\n")
    for line in lines:
        ledger.add(job.kind, job.numbers[job.done], Verdict(**json.loads(line)))
        job.done, job.heard = job.done + 1, time.monotonic()
    if data:
        return []
    os.close(pipe)
    del running[pipe]
    code = os.waitstatus_to_exitcode(os.waitpid(job.pid, 0)[1])
    if job.done == len(job.numbers):
        return []
    ledger.add(job.kind, job.numbers[job.done], Verdict("bad", f"its process died: {code}"))
    return [(job.kind, job.numbers[job.done + 1 :])]


def main() -> None:
    """Try the inputs, print the table, and keep it where that is wanted."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--times", type=float, default=1.0, help="share of a full campaign")
    parser.add_argument("--only", action="append", choices=[*KINDS], help="this kind of input")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--minutes", type=float, default=600, help="begin no more after that")
    parser.add_argument("--again", type=int, help="this number alone, of the one kind of --only")
    parser.add_argument("--write", type=Path, help="file for the table")
    args = parser.parse_args()
    kinds = args.only or list(KINDS)
    begun = time.monotonic()
    memory = Path("/dev/shm")
    with tempfile.TemporaryDirectory(dir=memory if memory.is_dir() else None) as folder:
        root, ledger = Path(folder), Ledger(args.seed)
        if args.again is not None:
            stock, expected = prepared(root, kinds[:1])
            work = Path("fuzz-again").resolve()
            print(tried(kinds[0], args.again, args.seed, stock, work, expected))
            return
        plan = {kind: max(round(args.times * KINDS[kind].times), 1) for kind in kinds}
        campaign(plan, args.seed, args.jobs, ledger, root, begun + 60 * args.minutes)
    minutes = (time.monotonic() - begun) / 60
    command = f"python tests/fuzz/campaign.py --times {args.times:g} --seed {args.seed}"
    command += "".join(f' --only "{kind}"' for kind in args.only or [])
    text = f"{command}\n{minutes:.0f} min, {args.jobs} at a time\n\n{ledger.table()}\n"
    print(text)
    if args.write:
        args.write.write_text(text, encoding="utf-8")
    sys.exit(1 if ledger.bad else 0)


if __name__ == "__main__":
    main()
