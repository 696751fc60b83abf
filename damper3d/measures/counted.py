"""The samples of a run folder, and which of its cycles count."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from damper3d.case.parts import GRAVITY
from damper3d.engine.records import Samples, cut
from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.trajectory import read_trajectory
from granulab.errors import FolderError

if TYPE_CHECKING:
    from damper3d.case.case import DamperCase


@dataclass(frozen=True)
class Cycles:
    """Whole cycles of a run."""

    case: "DamperCase"
    samples: Samples  # of all whole cycles, see records.cut
    first: int  # cycles that do not count: the start-up

    @property
    def per_cycle(self) -> int:
        """Samples a cycle."""
        return self.case.settings.output.samples

    @property
    def counted(self) -> Samples:
        """The samples of the cycles that count."""
        return cut(self.samples, self.per_cycle, self.first)

    @property
    def amplitude(self) -> float:
        """Amplitude of the enclosure [m]: as prescribed, or the first harmonic on a host."""
        if self.case.modes is None:
            return self.case.amplitude
        return float(abs(harmonics(self.counted["displacement"], self.per_cycle).mean()))

    @property
    def peak_speed(self) -> float:
        """Its largest velocity [m/s], of the first harmonic on a host."""
        if self.case.modes is None:
            return self.case.peak_speed
        return 2.0 * math.pi / self.case.period * self.amplitude

    @property
    def gamma(self) -> float:
        """Its amplitude of acceleration over g; of a decay or an excitation that of the case."""
        case = self.case
        if case.modes is None or case.is_decay or case.excitation is not None:
            return case.settings.motion.gamma
        return (2.0 * math.pi / case.period) ** 2 * self.amplitude / GRAVITY

    @property
    def references(self) -> np.ndarray:
        """4 V^2 M of each cycle [J] (eq. 6.10); of a free decay with each cycle's own V.

        Under an excitation that is no sine the mean of `most_energy` over the windows that count.
        """
        n_cycles = (len(self.samples["time"]) - 1) // self.per_cycle
        if self.case.excitation is not None:
            each = np.diff(most_energy(self))
            return np.full(n_cycles, each[self.first :].mean())
        speeds = np.full(n_cycles, self.peak_speed)
        if self.case.is_decay:
            sizes = np.abs(harmonics(self.samples["displacement"], self.per_cycle))
            speeds = 2.0 * math.pi / self.case.period * sizes
        return np.asarray(4.0 * speeds**2 * self.case.mass)


def most_energy(cycles: Cycles) -> np.ndarray:
    """The most that the bed can have dissipated by the end of each window (n + 1,) [J].

    E_max = (M/2) times the largest sum of (v(t_{k+1}) - v(t_k))^2 over any choice of times of the
    enclosure's velocity: one body without restitution that always meets the wall at the worst
    moment, a definition of this project. A sine gives 4 M V^2 a cycle. Of two directions the sum;
    of a rotation with the velocity of the rim.
    """
    case, per_cycle = cycles.case, cycles.per_cycle
    own, velocity = case.excitation, cycles.samples["velocity"]
    rim = None if own is None else own.rim_velocity(cycles.samples["time"])
    total = largest_sum(velocity if rim is None else rim, per_cycle)
    across = None if own is None else own.across(cycles.samples["time"])
    if across is not None:
        total = total + largest_sum(across[1], per_cycle)
    return np.asarray(0.5 * case.mass * total)


def largest_sum(velocity: np.ndarray, per_cycle: int) -> np.ndarray:
    """Largest sum of (v_j - v_i)^2 over successive times chosen up to each window's end (k + 1,).

    Dynamic programming over the extremes of v, and the ends of windows:
    f(j) = max over i < j of f(i) + (v_j - v_i)^2. Extremes are those of parabolas through three
    samples, but where a value lasts.
    """
    v = np.asarray(velocity, float)
    rise = np.diff(v)
    moving = np.flatnonzero(rise)
    up = rise[moving] > 0.0  # a product of two rises may underflow
    turning = up[1:] != up[:-1]
    turns = moving[1:][turning]
    ends = np.arange(0, len(v), per_cycle)
    at = np.union1d(turns, ends)
    top = v[at]
    sharp = np.isin(at, turns[rise[turns - 1] != 0])
    k = at[sharp]
    bend, slope = rise[k] - rise[k - 1], 0.5 * (rise[k] + rise[k - 1])
    top[sharp] -= 0.5 * slope**2 / bend
    best = np.zeros(len(at))
    for j in range(1, len(at)):
        best[j] = (best[:j] + (top[j] - top[:j]) ** 2).max()
    return np.maximum.accumulate(best)[np.searchsorted(at, ends)]


def harmonics(column: np.ndarray, per_cycle: int) -> np.ndarray:
    """First harmonic X of each cycle (n_cycles,), x = Re(X e^(i omega t)); a column as cut."""
    turned = np.exp(-2j * np.pi * np.arange(1, per_cycle + 1) / per_cycle)
    return np.asarray(2.0 / per_cycle * (column[1:].reshape(-1, per_cycle) @ turned))


def discarded(run: RunFolder) -> int | None:
    """Cycles that do not count, as the summary of a finished run says; None while it goes on."""
    return int(run.read_summary()["discarded"]) if run.state == "finished" else None


def read_cycles(folder: str | Path) -> Cycles:
    """The whole cycles of a run folder, finished or not.

    Raises FolderError where it holds no run or a damaged one, kept its summary only, or has no
    cycle that counts yet.
    """
    from damper3d.case.case import DamperCase

    run = RunFolder(Path(folder))
    first = discarded(run)
    if first is not None and not (run.path / "trajectory.h5").exists():
        raise FolderError(
            f'{run.path}: only its summary was kept (output.keep = "summary"), nothing to measure; '
            'run it with output.keep = "all"'
        )
    case, samples = DamperCase.load(run.case_file), read_trajectory(run.path)
    first = case.settings.run.discard if first is None else first
    per_cycle = case.settings.output.samples
    if (len(samples["time"]) - 1) // per_cycle <= first:
        raise FolderError(f"{run.path}: no cycle that counts yet; wait until one is computed")
    return Cycles(case, cut(samples, per_cycle, 0), first)
