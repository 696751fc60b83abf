"""Several dampers on one host: a run folder for each but the shown one, and results of all.

The folder of another damper lies in that of the run and is one itself: its case is the same, with
that damper shown, so that all that shows or measures a run takes it.
"""

from collections.abc import Sequence
from typing import Any

from damper3d.case.case import DamperCase
from damper3d.case.host.several import name_of
from damper3d.measures.host import closure_of
from damper3d.run.sources import MEASURES
from damper3d.run.vibration import BESIDE, Shaken
from granulab.campaign.output.files import write_atomic, writing
from granulab.campaign.runs.folder import RESULTS, RunFolder, digest, seals_of
from granulab.campaign.runs.trajectory import read_trajectory

_SHOWN = ("particles", "n_particles", "mass_kg", "fill_ratio", "efficiency", "dissipated_power_w",
          "peak_wall_force_n")  # fmt: skip


def folder_beside(folder: RunFolder, case: DamperCase, k: int) -> RunFolder:
    """The folder of damper number k (from 0) in that of a run, begun if it is not yet."""
    own, shown = RunFolder(folder.path / f"{BESIDE}{k + 1}"), case.shown(k)
    if own.state != "new":
        return own
    with writing(own.path):
        own.path.mkdir(exist_ok=True)
    text = shown.to_toml()
    for name, content in case.files.items():
        write_atomic(own.path / name, content)
    origin = folder.read_provenance()
    seals = seals_of({**case.files, "case.toml": text})
    own.write_provenance({**origin, "run_digest": digest(shown.identity()), **seals})
    own.write_case(text)
    return own


def beside(dampers: Sequence[Shaken], ended: Sequence[dict[str, Any]], lead: Shaken) -> None:
    """Complete the results of dampers on one host, and write those of all but the lead's folder.

    Each has a row for all, the energy of the host and all beds, and the cost of a step of all.
    """
    trajectories = [read_trajectory(one.folder.path) for one in dampers]
    closed = closure_of(trajectories, [one.case.weight for one in dampers])
    assert lead.case.together is not None
    lead_number = lead.case.number
    names = [name_of(one, k) for k, one in enumerate(lead.case.together.damper or [])]
    rows = [
        {
            "at": name,
            **{key: results[key] for key in _SHOWN},
            "amplitude_m": results["host"]["amplitude_m"],
            "rms_m": results["host"]["rms_m"],
            "reduction": results["host"]["reduction"],
            "folder": "." if one is lead else one.folder.path.name,
        }
        for name, one, results in zip(names, dampers, ended, strict=True)
    ]
    for one, results in zip(dampers, ended, strict=True):
        results["host"]["energy_closure"] = closed
        results["dampers"] = rows
        results |= {name: ended[lead_number][name] for name in ("cpu_us_per_step", "cpu_s")}
        if one is not lead:
            origin = {**one.folder.read_provenance(), "measures_digest": MEASURES.digest}
            one.folder.write_provenance(one.folder.with_seals(origin, RESULTS))
            one.folder.write_summary(results)
