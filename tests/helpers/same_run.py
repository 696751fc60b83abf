"""Two runs of the same case: the same results, and the same bits in every frame."""

from typing import Any

import numpy as np

from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.trajectory import read_trajectory, stored_tables

# Of the machine, not of the particles.
COSTS = {"cpu_s", "cpu_us_per_step"}


def results(folder: RunFolder) -> dict[str, Any]:
    """The summary of a run without what it cost."""
    return {k: v for k, v in folder.read_summary().items() if k not in COSTS}


def assert_same_run(run: RunFolder, other: RunFolder) -> None:
    """Same results, and the same bits in every frame, sample, table and record."""
    assert results(run) == results(other)
    frames = [read_trajectory(folder.path) for folder in (run, other)]
    assert frames[0].keys() == frames[1].keys()
    for name in frames[0]:
        # Equal as bytes: NaN, of those that stay, equals NaN.
        assert frames[0][name].tobytes() == frames[1][name].tobytes(), name
    for name, array in frames[0].static.items():
        np.testing.assert_array_equal(array, frames[1].static[name], err_msg=name)
    first, second = (stored_tables(folder.path) for folder in (run, other))
    assert first.keys() == second.keys()
    for name, table in first.items():
        assert table.frame.tobytes() == second[name].frame.tobytes(), name
        assert table.length.tobytes() == second[name].length.tobytes(), name
        for key, column in table.columns.items():
            assert column.tobytes() == second[name].columns[key].tobytes(), (name, key)
    records = [folder.path / "records.csv" for folder in (run, other)]
    assert records[0].exists() == records[1].exists()
    if records[0].exists():
        assert records[0].read_bytes() == records[1].read_bytes()
