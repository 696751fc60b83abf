"""Remarks of the paper without a table: arches, pauses of the flow, overlaps of soft contacts.

Granular Matter 15 (2013) 811, secs. 4.1, 4.2 and 4.3.1.
"""

import contextlib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from granulab.campaign.claims.claim import claims_of
from granulab.campaign.claims.judge import report_claims
from granulab.campaign.output.figure import BLUE, VERMILION
from granulab.campaign.output.layout import columns, done, not_done, paragraphs
from granulab.errors import FolderError
from silo2d.case.outline import PRESETS, preset
from silo2d.reproduce.quantities.remarks import REMARKS, largest_overlap, pauses, pauses_of_silo

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from granulab.campaign.sweeps.sweep import Labelled
    from silo2d.reproduce import Row

SEEDS = 3
COLUMNS = (
    "silo", "outlet_mm", "kn", "outcome", "n_out", "arch_particles", "pauses", "longest_pause_s",
    "largest_overlap_m",
)  # fmt: skip

_SOFT, _USUAL = 1e3, 1e4  # kn [N/mm]
_OFTEN = {"output.contact_interval": "10 ms", "law.keep_ratios": True}
_NOTE = """\
arch: that of `silo2d observe RUN arch` where a run clogged. Interruptions: none leaves for longer
  than one falls from rest by its size (the root of the mean area), between 10 and 90 % of those
  that leave. Overlap: the largest in the contacts kept, every 10 ms, of A4; kt/kn and
  gamma_n/omega_0 held. `silo2d clog` measures arches and waiting times over many clogs."""


def cases(seeds: Sequence[int]) -> "list[Labelled]":
    """The sixteen silos, then A4 with a stiffness of its own, with all seeds."""
    from granulab.campaign.sweeps.sweep import over_seeds
    from silo2d.case.case import SiloCase

    found = [
        one
        for silo in PRESETS
        for one in over_seeds({"silo": silo, "kn": None}, SiloCase.load(silo), seeds)
    ]
    for kn in (_SOFT, _USUAL):
        own = SiloCase.load("A4", {"law.kn": f"{kn:g} N/mm", **_OFTEN})
        found += over_seeds({"silo": "A4", "kn": kn}, own, seeds)
    return found


def run(
    *, out: Path, seeds: Sequence[int], workers: int | None, quiet: bool, **engine: Any
) -> "list[Row]":
    """A row a run, with what is remarked of it."""
    from silo2d.reproduce.runs import run_all

    runs = run_all(cases(seeds), out=out, workers=workers, quiet=quiet, **engine)
    return [one | measured(one) for one in runs]


def measured(one: "Row") -> "Row":
    """Outlet, arch, pauses and largest overlap of a run; None where it is not looked at for one.

    Nothing of one that failed, or whose row is kept and whose run is elsewhere.
    """
    from granulab.campaign.sweeps.sweep import is_elsewhere
    from silo2d.measures import arch
    from silo2d.measures.basics.particles import leavers
    from silo2d.view.scene import read_scene

    if one["state"] != "done" or is_elsewhere(one):
        return {}
    folder, usual = Path(one["run_folder"]), one["kn"] is None
    found: Row = dict.fromkeys(COLUMNS[5:])
    found["outlet_mm"] = round(1e3 * preset(one["silo"]).outlet)
    if not usual:
        return found | {"largest_overlap_m": _deepest(folder)}
    if one["outcome"].startswith("clogged"):
        with contextlib.suppress(FolderError):  # no chain from wall to wall
            found["arch_particles"] = arch.measure(folder)["n_grains"]
    scene = read_scene(folder)
    waits = pauses(leavers(scene)[0], scene.particle_size)
    return found | {"pauses": len(waits), "longest_pause_s": max(waits, default=None)}


def _deepest(folder: Path) -> float:
    from granulab.campaign.runs.trajectory import read_tables

    return float(read_tables(folder, "contacts").columns["overlap"].max())


def report(rows: "list[Row]") -> str:
    """Arches and pauses by silo, overlaps by stiffness, and the remarks judged."""
    judged = report_claims(REMARKS.judge(claims_of("silo_remarks"), rows))
    flow = {item["silo"]: item for item in pauses_of_silo(rows)}
    lines = [_line(silo, item, rows) for silo, item in flow.items()]
    depths = ", ".join(f"{o['value']:.3f} mm at {o['kn']:g} N/mm" for o in largest_overlap(rows))
    return paragraphs(
        columns(["silo", "clogged", "arch, particles", "interruptions", "longest"], lines),
        f"largest overlap: {depths}" if depths else "",
        _NOTE,
        "\n".join(not_done(rows, ["silo", "kn", "seed"])),
        f"What the paper says, and what these runs show:\n{judged}",
    )


def _line(silo: str, item: dict[str, Any], rows: "list[Row]") -> list[str]:
    own = [row for row in done(rows) if row["silo"] == silo and row["kn"] is None]
    arches = [row["arch_particles"] for row in own if row["arch_particles"] is not None]
    clogged = sum(row["outcome"].startswith("clogged") for row in own)
    return [
        silo,
        f"{clogged} of {len(own)}",
        ", ".join(map(str, arches)) or "-",
        f"{item['value']} in {item['with']} runs" if item["value"] else "-",
        f"{item['longest']:.3f} s" if item["value"] else "-",
    ]


def draw(rows: "list[Row]") -> "Figure":
    """Particles of the arches, and the longest pause of each run, by silo."""
    from matplotlib.figure import Figure

    own = [row for row in done(rows) if row["kn"] is None]
    silos = {silo: k for k, silo in enumerate(dict.fromkeys(row["silo"] for row in own))}
    figure = Figure(figsize=(8.4, 5.4), layout="constrained")
    arches, waits = figure.subplots(2, 1, sharex=True)
    arches.axhline(16, color=VERMILION, lw=1, label="the experiment's largest")
    for axes, key, label in (
        (arches, "arch_particles", "particles of the arch"),
        (waits, "longest_pause_s", "longest interruption [s]"),
    ):
        known = [row for row in own if row[key] is not None]
        axes.plot([silos[row["silo"]] for row in known], [row[key] for row in known], "o",
                  color=BLUE, mfc="none", label="ours, each run")  # fmt: skip
        axes.set_ylabel(label)
        axes.set_ylim(bottom=0)
        axes.grid(axis="y")
    figure.legend(*arches.get_legend_handles_labels(), loc="outside upper right", ncols=2)
    waits.set_xticks(range(len(silos)), list(silos))
    waits.set_xlim(-0.5, len(silos) - 0.5)
    waits.set_xlabel("silo")
    return figure
