"""A measure from outside the package: registered by a public call, made by `damper3d observe`."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from small_damper import damper3d, write_damper

from damper3d import register_measure
from damper3d.measures import MEASURES
from granulab.campaign.output.measures import Measure
from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.trajectory import read_trajectory
from granulab.errors import InputError


def spread(folder: Path) -> dict[str, float]:
    """Scatter in time of the bed's mean height in the enclosure [m]."""
    height = read_trajectory(folder)["mean_position"][:, 2]
    return {"spread_m": float(np.std(height)), "mean_m": float(np.mean(height))}


def draw_spread(folder: Path) -> Figure:
    figure = Figure()
    figure.subplots().plot(read_trajectory(folder)["mean_position"][:, 2])
    return figure


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> Path:
    """A finished run of the small damper."""
    folder = tmp_path_factory.mktemp("observed")
    result = damper3d(
        "run", write_damper(folder), "-o", folder / "runs", "--no-figures", "--quiet", "--json"
    )
    return Path(result.json["run_folder"])


@pytest.fixture
def registered():
    """The measure, only as long as a test lasts."""
    measure = Measure("scatter of the bed's mean height", "m", spread, draw_spread)
    register_measure("spread", measure)
    yield "spread"
    MEASURES.remove("spread")


def test_a_measure_from_outside_is_listed_made_and_drawn(run, registered):
    assert "spread          scatter of the bed's mean height [m]" in damper3d("observe", run).out
    result = damper3d("observe", run, registered, "--json")
    assert result.json == spread(run)
    picture = run / "figures" / "spread.png"
    assert str(picture) in result.err
    assert picture.stat().st_size > 1000
    with pytest.raises(InputError, match="there is one of that name"):
        register_measure("spread", MEASURES.find("spread"))


@pytest.mark.parametrize("name", ["efficiency", "phases", "response"])
def test_a_shipped_measure_says_what_the_summary_says(run, name):
    """To the last bit: a run's results are made by the same functions."""
    summary = RunFolder(run).read_summary()
    result = damper3d("observe", run, name, "--json")
    assert result.json
    for key, value in result.json.items():
        assert summary[key] == value
    assert (run / "figures" / f"{name}.png").stat().st_size > 1000


def test_an_unknown_measure_and_what_is_no_run_are_refused(run, tmp_path):
    assert "did you mean 'efficiency'?" in damper3d("observe", run, "efficency").err
    assert damper3d("observe", tmp_path, "efficiency").code == 2
