"""A measure from outside the package: registered by a public call, made by `silo2d observe`."""

from pathlib import Path

import pytest
from fake_run import write_fake_run
from matplotlib.figure import Figure
from small_silo import silo2d

from granulab.campaign.output.measures import Measure
from granulab.campaign.runs.trajectory import read_trajectory
from granulab.errors import InputError
from silo2d import register_measure
from silo2d.measures import MEASURES


def half_out(folder: Path) -> dict[str, float]:
    """Return when half of the particles were out [s]."""
    run = read_trajectory(folder)
    return {"half_out_s": float(run["time"][run["n_out"] >= run["n_out"][-1] / 2][0])}


def draw_half_out(folder: Path) -> Figure:
    """Draw the discharge curve up to there."""
    run, figure = read_trajectory(folder), Figure()
    figure.subplots().plot(run["time"], run["n_out"])
    return figure


@pytest.fixture
def registered():
    """The measure, only as long as a test lasts."""
    register_measure("half", Measure("when half of the particles are out", "s", half_out,
                                     draw_half_out))  # fmt: skip
    yield "half"
    MEASURES.remove("half")


def test_a_measure_from_outside_is_listed_made_and_drawn(tmp_path, registered):
    run = write_fake_run(tmp_path).path
    assert "half            when half of the particles are out [s]" in silo2d("observe", run).out
    result = silo2d("observe", run, registered, "--json")
    assert result.json == half_out(run)
    assert 0 < result.json["half_out_s"] < read_trajectory(run)["time"][-1]
    picture = run / "figures" / "half.png"
    assert str(picture) in result.err
    assert picture.stat().st_size > 1000
    with pytest.raises(InputError, match="there is one of that name"):
        register_measure("arch", MEASURES.find("half"))
