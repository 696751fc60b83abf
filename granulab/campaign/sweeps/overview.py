"""Words on many runs: their cost, the plan before them, and the summary after them."""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from granulab.campaign.output import room
from granulab.campaign.output.layout import fitted, wrapped
from granulab.campaign.output.statistics import mean_sd
from granulab.campaign.sweeps.cases import LabelledStudy, study_folder
from granulab.campaign.sweeps.sweep import Labelled, Simulator

Rows = list[dict[str, Any]]


def cost(simulator: Simulator, cases: Sequence[Labelled]) -> str:
    """Return what cases will cost if nothing of them is there, in words."""
    distinct = {simulator.digest(case): case for _, case in cases}
    packings: dict[Path, float] = {}
    runs = 0.0
    for case in distinct.values():
        packing, run = simulator.expected_cpu_s(case)
        packings[simulator.packing_file(case, Path())] = packing
        runs += run
    cpu = in_minutes(sum(packings.values()) + runs)
    shortest = min(case.time_step for case in distinct.values())
    return (
        f"{len(distinct)} runs of {len(packings)} packings, about {cpu} min of CPU time if "
        f"none is there yet; the shortest time step is {shortest * 1e6:.2g} us"
    )


def in_minutes(seconds: float) -> str:
    """A time that is known to a factor of two, as a number of minutes."""
    minutes = max(seconds / 60, 0.1)
    return f"{minutes:.1g}" if minutes < 1 else f"{minutes:,.0f}"


def plan(simulator: Simulator, loaded: LabelledStudy, out: Path) -> dict[str, Any]:
    """Return what running a study would do; nothing is written."""
    folders = [simulator.run_folder(case, out) for _, case in loaded.cases]
    todo = {
        folder.path: case
        for folder, (_, case) in zip(folders, loaded.cases, strict=True)
        if folder.state != "finished"
    }
    packings = {simulator.packing_file(case, out) for case in todo.values()}
    return {
        "study": loaded.study.name,
        "folder": str(study_folder(simulator, loaded, out).path),
        "runs": len(loaded.cases),
        "finished": sum(folder.state == "finished" for folder in folders),
        "packings_to_fill": sum(not file.exists() for file in packings),
        "disk_bytes_at_most": simulator.disk_of(list(todo.values())),
        "disk_free_bytes": room.free(out),
        "rows": [
            {**labels, "run_folder": str(folder.path), "state": folder.state}
            for folder, (labels, _) in zip(folders, loaded.cases, strict=True)
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
            f"{planned['packings_to_fill']} packings to fill",
            f"each with {_plural(len(loaded.study.seeds), 'seed')}:",
            fitted(columns, cells, len(columns)),
            room.line(planned),
            f"table       {planned['folder']}/table.csv",
        ]
    )


def summary(
    simulator: Simulator, loaded: LabelledStudy, folder: Path, rows: Rows
) -> dict[str, Any]:
    """Return the results of a study: counts, and means and deviations over seeds by combination."""
    groups: dict[tuple[Any, ...], Rows] = {}
    for row in rows:
        groups.setdefault(_key(loaded.columns, row), []).append(row)
    states = Counter(row["state"] for row in rows)
    failures = [f"{_labels(loaded, row)}: {row['reason']}" for row in _of(rows, "failed")]
    lost = (r["reason"] for r in _of(rows, "interrupted") if r["reason"].endswith("went away"))
    return {
        "study": loaded.study.name,
        "folder": str(folder),
        "table": str(folder / "table.csv"),
        "runs": len(rows),
        "done": states["done"],
        "reused": sum(row.get("reused", False) for row in rows),
        "failed": states["failed"],
        "interrupted": states["interrupted"],
        "why_interrupted": next(lost, "stopped"),
        "failures": failures,
        "combinations": [
            {**dict(zip(loaded.columns, key, strict=True)), **_means(simulator, group)}
            for key, group in groups.items()
        ],
    }


def _means(simulator: Simulator, rows: Rows) -> dict[str, Any]:
    """Over the runs that are done: how they ended, mean and standard deviation; None for none."""
    done = _of(rows, "done")
    table: dict[str, Any] = {"runs": len(done)}
    table |= {word: sum(map(is_one, done)) for word, is_one in simulator.counted.items()}
    for name in simulator.means:
        found = mean_sd([row[name] for row in done if row[name] is not None])
        table[f"{name}.mean"], table[f"{name}.sd"] = found.mean, found.sd
    return table


def as_text(table: dict[str, Any]) -> str:
    """A summary in words: a line for every combination."""
    rows = table["combinations"]
    names, cells = _with_spreads(rows)
    counts = ", ".join(f"{table[name]} {name}" for name in ("done", "failed", "interrupted"))
    return "\n".join(
        [
            fitted(names, cells, names.index("runs")),
            *(wrapped(f"failed: {line}", 8) for line in table["failures"]),
            f"{table['study']}: {_plural(table['runs'], 'run')}: {counts} ({table['reused']} were "
            "there before)",
            f"table       {table['table']}",
        ]
    )


def _with_spreads(rows: Rows) -> tuple[list[str], list[list[str]]]:
    """Names and cells of a table, a mean and its standard deviation as one: "0.341 +- 0.003"."""
    means = [name.removesuffix(".mean") for name in rows[0] if name.endswith(".mean")]
    others = [name for name in rows[0] if name.removesuffix(".sd").removesuffix(".mean") == name]

    def spread(row: dict[str, Any], name: str) -> str:
        mean, sd = row[f"{name}.mean"], row[f"{name}.sd"]
        return _number(mean) + ("" if sd is None else f" +- {sd:.2g}")

    cells = [
        [*(_number(row[name]) for name in others), *(spread(row, name) for name in means)]
        for row in rows
    ]
    return others + means, cells


def _key(columns: tuple[str, ...], row: dict[str, Any]) -> tuple[Any, ...]:
    return tuple(repr(row[name]) if isinstance(row[name], list) else row[name] for name in columns)


def _of(rows: Rows, state: str) -> Rows:
    return [row for row in rows if row["state"] == state]


def _labels(loaded: LabelledStudy, row: dict[str, Any]) -> str:
    return ", ".join(f"{name} {_number(row[name])}" for name in (*loaded.columns, "seed"))


def _number(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _plural(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"
