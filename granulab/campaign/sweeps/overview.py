"""Words on many runs before them: their cost, and what there is to do."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from granulab.campaign.output import room
from granulab.campaign.output.layout import fitted
from granulab.campaign.sweeps.cases import LabelledStudy, study_folder
from granulab.campaign.sweeps.report.axes import key_of
from granulab.campaign.sweeps.sweep import Labelled, Simulator, names_in


def cost(simulator: Simulator, cases: Sequence[Labelled]) -> str:
    """Return what cases will cost if nothing of them is there, in words."""
    distinct = {simulator.digest(case): case for _, case in cases}
    if not distinct:
        return "0 runs: the table that is there has all of them"
    packings, runs = expected_cpu_s(simulator, distinct.values(), Path())
    cpu = in_minutes(sum(packings.values()) + runs)
    shortest = min(case.time_step for case in distinct.values())
    return (
        f"{len(distinct)} runs of {len(packings)} packings, about {cpu} min of CPU time if "
        f"none is there yet; the shortest time step is {shortest * 1e6:.2g} us"
    )


def expected_cpu_s(
    simulator: Simulator, cases: Iterable[Any], out: Path
) -> tuple[dict[Path, float], float]:
    """CPU time [s] of each packing of unlike cases, by its file below `out`, and of all runs."""
    packings: dict[Path, float] = {}
    runs = 0.0
    for case in cases:
        packing, run = simulator.expected_cpu_s(case)
        packings[simulator.packing_file(case, out)] = packing
        runs += run
    return packings, runs


def in_minutes(seconds: float) -> str:
    """A time that is known to a factor of two, as a number of minutes."""
    minutes = max(seconds / 60, 0.1)
    return f"{minutes:.1g}" if minutes < 1 else f"{minutes:,.0f}"


def plan(simulator: Simulator, loaded: LabelledStudy, out: Path) -> dict[str, Any]:
    """Return what running a study would do; nothing is written."""
    there = names_in(out)
    folders = [simulator.run_folder(case, out, there) for _, case in loaded.cases]
    states = [folder.state if folder.path.name in there else "new" for folder in folders]
    todo = {
        folder.path: case
        for folder, state, (_, case) in zip(folders, states, loaded.cases, strict=True)
        if state != "finished"
    }
    packings, runs = expected_cpu_s(simulator, todo.values(), out)
    lacking = [seconds for file, seconds in packings.items() if not file.exists()]
    return {
        "study": loaded.study.name,
        "folder": str(study_folder(simulator, loaded, out).path),
        "runs": len(loaded.cases),
        "finished": states.count("finished"),
        "packings_to_fill": len(lacking),
        "expected_cpu_s": runs + sum(lacking),
        "disk_bytes_at_most": simulator.disk_of(list(todo.values())),
        "disk_free_bytes": room.free(out),
        "rows": [
            {**labels, "run_folder": str(folder.path), "state": state}
            for folder, state, (labels, _) in zip(folders, states, loaded.cases, strict=True)
        ],
    }


def plan_as_text(loaded: LabelledStudy, planned: dict[str, Any]) -> str:
    """A plan in words: a line for every combination."""
    columns = loaded.columns
    combinations = {_key(columns, row): row for row in planned["rows"]}
    cells = [[_number(row[name]) for name in columns] for row in combinations.values()]
    return "\n".join(
        [
            f"{planned['study']}: {planned['runs']} runs, {planned['finished']} of them finished; "
            f"{planned['packings_to_fill']} packings to fill; about "
            f"{in_minutes(planned['expected_cpu_s'])} min of CPU time to go",
            f"each with {_plural(len(loaded.study.seeds), 'seed')}:",
            fitted(columns, cells, len(columns)),
            room.line(planned),
            f"table       {planned['folder']}/table.csv",
            *picture_line(planned),
        ]
    )


def picture_line(planned: dict[str, Any]) -> list[str]:
    """The line on the picture of a plan, where there is one."""
    return [f"picture     {planned['picture']}"] if planned.get("picture") else []


def _key(columns: tuple[str, ...], row: dict[str, Any]) -> tuple[Any, ...]:
    return tuple(key_of(row[name]) for name in columns)


def _number(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _plural(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"
