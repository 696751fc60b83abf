"""Many dampers at once on a GPU beside the cores of the same machine: rate, repeat, agreement.

    python benchmarks/gpu.py [--packings 3] [--write gpu.txt]

Runs the thesis's map (nine frequencies, nineteen Gammas, vertical, 358 spheres; 8 cycles, no
frames) of some packings by `--engine cuda` and by processes, a part of it twice, and prints a
table: time, particles times steps in a second of the kernel and of the whole sweep, whether the
part that was repeated has the same digests, the ratio of efficiencies, and the energy balances.
Fillings and compilation come before the clock starts. Less than 8 minutes on 16 cores.
"""

import argparse
import dataclasses
import itertools
import os
import platform
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from damper3d.case.case import DamperCase
from damper3d.engine.batch import device, loop
from damper3d.engine.batch.slots import STEP
from damper3d.run import sweep
from damper3d.run.device import going_on
from damper3d.run.protocol import get_packing
from damper3d.studies.map.grid import FREQUENCIES, GAMMAS
from granulab.campaign.sweeps.sweep import over_seeds, run_labelled

LONGEST = 8  # minutes
CHAPTER = 5472  # runs: 9 x 19 points of 32 maps


class Timed:
    """A device whose time of work and particles times steps are counted."""

    worked_s = 0.0
    particle_steps = 0

    def __init__(self, kind, slots) -> None:
        self._device, self._slots = kind(slots), slots
        self.bring, self.fetch = self._device.bring, self._device.fetch

    def go_on(self, clock, which, most) -> None:
        """See batch.Device."""
        before, begun = clock[which, STEP].copy(), time.perf_counter()
        self._device.go_on(clock, which, most)
        Timed.worked_s += time.perf_counter() - begun
        Timed.particle_steps += int(((clock[which, STEP] - before) * clock[which, 0]).sum())


def conditions(n_packings: int, frequencies, gammas):
    """Labelled cases of the thesis's map, with each packing."""
    cases = []
    for frequency, gamma in itertools.product(frequencies, gammas):
        changes = {"motion.frequency": frequency, "motion.gamma": gamma, "output.frames": 0,
                   "output.keep": "summary"}  # fmt: skip
        case = DamperCase.load("thesis", changes)
        labels = {"frequency_hz": frequency, "gamma": gamma}
        cases += over_seeds(labels, case, range(1, n_packings + 1))
    return cases


def timed(what: str, simulator, cases, out: Path, **engine):
    """Rows of the cases, and the time that they took [s]."""
    print(f"{what}: {len(cases)} runs ...", file=sys.stderr, flush=True)
    begun = time.perf_counter()
    rows = run_labelled(simulator, cases, out=out, quiet=True, **engine)
    failed = [row for row in rows if row["state"] != "done"]
    if failed:
        sys.exit(f"{len(failed)} runs failed, the first: {failed[0]['reason']}")
    return rows, time.perf_counter() - begun


def compared(gpu, cpu, n_packings: int) -> list[str]:
    """Lines that compare efficiencies and energy balances, condition by condition."""
    eta = [np.array([row["efficiency_with_settling"] for row in rows]).reshape(-1, n_packings)
           for rows in (gpu, cpu)]  # fmt: skip
    ratio = eta[0].mean(axis=1) / eta[1].mean(axis=1)
    half = 1.96 * ratio.std(ddof=1) / np.sqrt(len(ratio))
    lines = [
        f"efficiency, GPU over cores      {ratio.mean():.4f} +- {half:.4f}, {ratio.min():.3f} to "
        f"{ratio.max():.3f} (of {len(ratio)} conditions, {n_packings} packings each)"
    ]
    if n_packings > 1:
        scatter = np.sqrt((eta[0].var(axis=1, ddof=1) + eta[1].var(axis=1, ddof=1)) / n_packings)
        off = np.abs(eta[0].mean(axis=1) - eta[1].mean(axis=1)) / np.maximum(scatter, 1e-12)
        pooled = np.sqrt((scatter**2 / eta[1].mean(axis=1) ** 2).mean()) * eta[1].mean(axis=1)
        far = np.abs(eta[0].mean(axis=1) - eta[1].mean(axis=1)) / np.maximum(pooled, 1e-12)
        lines.append(f"beyond 3 sigma of the packings  {(off > 3).sum()} conditions by their own "
                     f"scatter, {(far > 3).sum()} by the relative scatter of all")  # fmt: skip
    for name, rows in (("GPU", gpu), ("cores", cpu)):
        closure = max(abs(row["energy_closure"]) for row in rows)
        lines.append(f"energy balance, {name:5}           closed to {closure:.2e} at worst")
    return lines


def table(options: argparse.Namespace) -> list[str]:
    """The lines of the table."""
    kind, name = (
        (loop.Processor, "one thread") if options.processor else (device.Gpu, device.name())
    )
    frequencies, gammas = (FREQUENCIES, GAMMAS) if not options.brief else ((160, 320), (5, 20))
    on_gpu = dataclasses.replace(
        sweep.DAMPER, device=lambda cases: going_on(cases, lambda s: Timed(kind, s), name)
    )
    cases = conditions(options.packings, frequencies, gammas)
    part = slice(None, None, max(len(cases) // 12, 1))  # that is repeated
    with tempfile.TemporaryDirectory() as folder:
        out = [Path(folder) / name for name in ("gpu", "cores", "again")]
        first = cases[: options.packings]
        timed("kernels of the cores, fillings", sweep.DAMPER, first, out[1])
        timed("kernel of the GPU", on_gpu, first[:1], Path(folder) / "compile", engine="cuda")
        for (_, case), place in itertools.product(first, (out[0], out[2])):
            get_packing(case, place, lambda done, words: None)
        Timed.worked_s, Timed.particle_steps = 0.0, 0
        gpu, gpu_s = timed("GPU", on_gpu, cases, out[0], engine="cuda")
        worked, done = Timed.worked_s, Timed.particle_steps
        again, _ = timed("GPU again", on_gpu, cases[part], out[2], engine="cuda")
        cpu, cpu_s = timed("cores", sweep.DAMPER, cases, out[1])
    same = all(a["state_digest"] == b["state_digest"]
               for a, b in zip(gpu[part], again, strict=True))  # fmt: skip
    return [
        f"machine                         {platform.processor() or platform.machine()}, "
        f"{os.cpu_count()} cores; {name}",
        f"runs                            {len(cases)}: {len(frequencies)} frequencies x "
        f"{len(gammas)} Gammas x {options.packings} packings, 358 spheres, 8 cycles",
        f"GPU, whole sweep                {gpu_s:.1f} s, {done / gpu_s:.2e} particle-steps/s",
        f"GPU, kernel alone               {worked:.1f} s, {done / worked:.2e} particle-steps/s",
        f"cores, whole sweep              {cpu_s:.1f} s, {done / cpu_s:.2e} particle-steps/s",
        f"cores over GPU, time            {cpu_s / gpu_s:.2f} whole, {cpu_s / worked:.2f} kernel",
        f"{CHAPTER:,} runs as these (chapter) {CHAPTER * gpu_s / len(cases) / 60:.1f} min, "
        f"{CHAPTER * worked / len(cases) / 60:.1f} min of them in the kernel",
        f"repeated on the GPU             {len(again)} runs, "
        f"{'the same digests' if same else 'OTHER DIGESTS'}",
        *compared(gpu, cpu, options.packings),
    ]  # fmt: skip


def main() -> None:
    """Print the table, or what is missing."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--packings", type=int, default=3)
    parser.add_argument("--write", type=Path)
    parser.add_argument("--brief", action="store_true", help="four conditions")
    parser.add_argument("--processor", action="store_true", help="one thread in place of the GPU")
    options = parser.parse_args()
    if not options.processor and (lacks := device.missing()):
        sys.exit(f"benchmarks/gpu.py: this machine lacks {lacks}; no rate was measured")
    text = "\n".join(table(options)) + "\n"
    print(text, end="")
    if options.write:
        options.write.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
