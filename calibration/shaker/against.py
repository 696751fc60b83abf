"""Phases from force and acceleration against those that runs have from their particles.

Run folders are read as files: summary.json has the phase, and export/shaker.csv with
export/shaker-empty.csv, which `damper3d export RUN --to shaker` writes, what would be measured.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from calibration.shaker.measure import dissipation
from calibration.shaker.phases import (
    BOUNCING,
    FLUIDISED,
    GRAVITY,
    RIDES,
    SOLID,
    STRUCK,
    BedPhase,
)
from calibration.shaker.record import read_record
from granulab.campaign.output.figure import BLUE, GREY, ORANGE, VERMILION, headline
from granulab.campaign.output.layout import columns
from granulab.campaign.runs.folder import RunFolder
from granulab.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAMES = (SOLID, FLUIDISED, BOUNCING)
# Of the phases in docs/damper/phases.md those that signals tell apart; the others are fluidised.
_COUNTED = {"solid_like": SOLID, "bouncing_bed": BOUNCING}
_COLOURS = {SOLID: GREY, FLUIDISED: BLUE, BOUNCING: VERMILION}
_MARKS = {SOLID: "s", FLUIDISED: "o", BOUNCING: "*"}


@dataclass(frozen=True)
class Compared:
    """A run: its phase from the particles, and from the signals."""

    run: str
    frequency_hz: float
    gamma: float
    counted: str  # as in its summary
    signals: BedPhase
    efficiency: float
    efficiency_of_run: float  # the shaker's work

    @property
    def of_particles(self) -> str:
        """The one of NAMES that the counted phase is."""
        return _COUNTED.get(self.counted, FLUIDISED)


@dataclass(frozen=True)
class Confusion:
    """Runs by their phase from the particles, and from the signals."""

    runs: tuple[Compared, ...]
    left_out: tuple[str, ...]  # why, a line each

    def count(self, counted: str, found: str) -> int:
        """Runs of one phase by their particles and another (or the same) by their signals."""
        return sum(r.of_particles == counted and r.signals.name == found for r in self.runs)

    @property
    def agreement(self) -> tuple[float, float]:
        """Share of the runs where both agree, and its binomial sigma."""
        n, right = len(self.runs), sum(self.count(name, name) for name in NAMES)
        return right / n, float(np.sqrt(max(right * (n - right), 1) / n) / n)

    def off(self, percentile: float) -> float:
        """Percentile of the efficiencies' relative differences from those of the runs."""
        off = [abs(r.efficiency / r.efficiency_of_run - 1.0) for r in self.runs]
        return float(np.percentile(off, percentile))

    def to_dict(self) -> dict[str, Any]:
        """The object that --json prints."""
        share, sigma = self.agreement
        return {
            "agreement": {"value": share, "sigma": sigma},
            "confusion": {a: {b: self.count(a, b) for b in NAMES} for a in NAMES},
            "runs": [asdict(r) | {"signals": r.signals._asdict()} for r in self.runs],
            "left_out": list(self.left_out),
            "warnings": [],
        }

    def text(self) -> str:
        """The matrix, and below it the counted phases that were taken for others."""
        rows = [[f"  {a}", *(str(self.count(a, b)) for b in NAMES)] for a in NAMES]
        share, sigma = self.agreement
        wrong = Counter(
            f"{r.counted.replace('_', ' ')} taken for {r.signals.name}"
            for r in self.runs
            if r.of_particles != r.signals.name
        )
        return "\n".join([
            "from the particles, by row; from force and acceleration, by column",
            columns(["  runs", *NAMES], rows),
            f"alike in {100 * share:.0f} ± {100 * sigma:.0f} % of {len(self.runs)} runs",
            *(f"  {number:3} {what}" for what, number in wrong.most_common()),
            f"efficiency against the shaker's work in the runs: off by {100 * self.off(50):.2g} % "
            f"in half of them, {100 * self.off(95):.2g} % in 19 of 20",
            *(f"left out: {line}" for line in self.left_out),
        ])  # fmt: skip

    def figure(self) -> "Figure":
        """Slip and the weaker end's impulse of every run, by its counted phase."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(6.8, 4.8), layout="constrained")
        axes = figure.subplots()
        for name in NAMES:
            own = [r.signals for r in self.runs if r.of_particles == name]
            ends = [max(min(s.low_impulse, s.high_impulse), 1e-3) for s in own]
            axes.scatter([s.slip for s in own], ends, s=22, color=_COLOURS[name],
                         marker=_MARKS[name], label=name)  # fmt: skip
        axes.axvline(RIDES, color=ORANGE, lw=0.9)
        axes.axhline(STRUCK, color=ORANGE, lw=0.9)
        axes.set(xscale="log", yscale="log", xlabel="slip [-]",
                 ylabel="impulse of the weaker end over 2 M V [-]")  # fmt: skip
        axes.legend(title="from the particles")
        headline(figure, f"Phase from signals: alike in {100 * self.agreement[0]:.0f} %")
        return figure


def against(folders: Sequence[Path]) -> Confusion:
    """Compare the runs in folders; InputError where none has a phase, or one has no record."""
    if not folders:
        raise InputError("--against: no run folder; name some, such as runs/*")
    runs, left_out = [], []
    for folder in folders:
        summary = _summary(folder)
        if summary.get("phase") is None:
            left_out.append(f"{folder}: too few frames for a phase")
            continue
        runs.append(_compared(folder, summary))
    if not runs:
        raise InputError(f"--against: {left_out[0]}, nor has another run one")
    return Confusion(tuple(runs), tuple(left_out))


def _summary(folder: Path) -> Mapping[str, Any]:
    run = RunFolder(folder)
    if run.state != "finished":
        raise InputError(f"{folder}: no finished run (it has no summary.json)")
    found = run.read_summary()
    needed = ("phase", "orientation", "n_particles", "particle_mass_kg", "efficiency_wall_work")
    if missing := [key for key in needed if key not in found]:
        raise InputError(f"{folder}: not of a damper that was shaken (no {missing[0]})")
    return found


def _compared(folder: Path, summary: Mapping[str, Any]) -> Compared:
    full, empty = (folder / "export" / f"{name}.csv" for name in ("shaker", "shaker-empty"))
    if not (full.exists() and empty.exists()):
        raise InputError(f"{folder}: no record; make it: damper3d export {folder} --to shaker")
    mass = summary["n_particles"] * summary["particle_mass_kg"]
    gravity = GRAVITY if summary["orientation"] == "vertical" else 0.0
    found = dissipation(read_record(full), [read_record(empty)], mass, gravity=gravity)
    assert found.phase is not None
    assert found.efficiency is not None
    return Compared(
        str(folder), found.frequency_hz, found.gamma, summary["phase"], found.phase,
        found.efficiency.value, summary["efficiency_wall_work"],
    )  # fmt: skip
