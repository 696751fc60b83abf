"""Two damper runs compared: numbers, table, picture, bad input."""

import json

import numpy as np
import pytest
from fake_damper_run import EFFICIENCY, LAW_GAIN, SHARES, write_fake_damper_run
from small_damper import damper3d

from damper3d.view.compare import compare, draw, labels, table
from granulab.campaign.runs.folder import RunFolder


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Of 5 and of 7 cycles, at Gamma 20 and 5."""
    root = tmp_path_factory.mktemp("pair")
    write_fake_damper_run(root / "one")
    write_fake_damper_run(root / "other", gamma=5.0, cycles=7)
    return [root / "one", root / "other"]


def test_efficiencies_and_shares_are_set_side_by_side(runs):
    """Their difference, also over the root of both half widths squared (0.02 each)."""
    found = compare(*runs)
    one, other = (row["efficiency"] for row in found["runs"])
    assert one == pytest.approx((1 - LAW_GAIN) * np.mean(EFFICIENCY[3:]))
    assert other == pytest.approx((1 - LAW_GAIN) * np.mean([*EFFICIENCY[3:], *EFFICIENCY[-1:] * 2]))
    difference = found["difference"]
    assert difference["efficiency"] == pytest.approx(other - one)
    over = difference["efficiency_over_interval"]
    assert over == pytest.approx((other - one) / (0.02 * np.sqrt(2)))
    assert difference["shares"]["particle_wall"]["friction"] == 0.0


def test_a_run_compared_with_itself_does_not_differ(runs):
    difference = compare(runs[0], runs[0])["difference"]
    assert difference["efficiency"] == difference["efficiency_over_interval"] == 0.0
    rows = compare(runs[0], runs[0])["runs"]
    assert labels(rows) == ["one", "one"]


def test_runs_on_hosts_are_compared_by_their_response_first(runs, tmp_path):
    """What they are for: amplitude over that of the bare structure, then the bed's efficiency."""
    pair = []
    for name, reduction in (("a", 0.75), ("b", 1.6)):
        write_fake_damper_run(tmp_path / name)
        run = RunFolder(tmp_path / name)
        host = {"reduction": reduction, "amplitude_m": 1e-3 * reduction, "rms_m": 7e-4,
                "added_damping_ratio": None}  # fmt: skip
        run.write_summary(run.read_summary() | {"host": host})
        pair.append(tmp_path / name)
    lines = table(compare(*pair)).splitlines()
    assert lines[1].split() == ["amplitude", "over", "bare", "0.7500", "1.6000"]
    assert lines[4].split() == ["added", "damping", "ratio", "none", "none"]
    assert "over bare" not in table(compare(pair[0], runs[0]))


def test_runs_without_an_interval_are_compared_all_the_same(runs, tmp_path):
    """One counted cycle has none."""
    write_fake_damper_run(tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    run.write_summary(run.read_summary() | {"efficiency_interval": None})
    found = compare(runs[0], tmp_path / "run")
    assert found["difference"]["efficiency_over_interval"] is None
    assert damper3d("compare", runs[0], tmp_path / "run", "--no-figures").code == 0


def test_the_picture_has_both_runs_in_every_panel(runs):
    """Histories over 4 V^2 M and over V, so that runs of any motion can be laid together."""
    figure = draw(compare(*runs))
    loss, bed, cycles, shares = figure.axes
    ends = [line.get_ydata()[-1] for line in loss.lines]
    means = [np.mean(EFFICIENCY[3:]), np.mean([*EFFICIENCY[3:], *EFFICIENCY[-1:] * 2])]
    np.testing.assert_allclose(ends, means, rtol=1e-9)
    named = [line.get_label() for line in bed.lines]
    assert named == ["Γ = 20", "Γ = 5", "enclosure"]
    np.testing.assert_allclose(bed.lines[2].get_ydata()[[0, 20]], [1.0, -1.0])
    assert [len(line.get_ydata()) for line in cycles.lines] == [5, 7]
    widths = [bar.get_width() for bar in shares.patches]
    assert sorted(widths[:6]) == pytest.approx(sorted(100 * np.array(list(SHARES.values()))))


def test_command_prints_a_table_and_makes_a_picture(runs):
    result = damper3d("compare", *runs)
    assert result.code == 0
    assert result.err.strip() == str(runs[0] / "figures" / "beside-other.png")
    for words in ("Γ = 20", "efficiency", "0.4896", "50.0%", "bouncing bed", "half widths"):
        assert words in result.out
    alone = damper3d("compare", *runs, "--json", "--no-figures")
    assert alone.json == json.loads(json.dumps(compare(*runs)))
    assert alone.err == ""


def test_numbers_are_compared_where_only_the_summary_was_kept(runs, tmp_path):
    """The table stands; one line says why there is no picture."""
    write_fake_damper_run(tmp_path / "bare", keep="summary")
    result = damper3d("compare", runs[0], tmp_path / "bare")
    assert result.code == 0
    assert "efficiency" in result.out
    assert result.err.startswith("no picture: ")
    assert len(result.err.splitlines()) == 1


def test_runs_that_are_not_finished_or_damaged_are_refused(runs, tmp_path):
    write_fake_damper_run(tmp_path / "half", finished=False)
    result = damper3d("compare", runs[0], tmp_path / "half")
    assert result.code == 2
    assert "not finished; go on with: damper3d run --resume" in result.err
    write_fake_damper_run(tmp_path / "damaged")
    run = RunFolder(tmp_path / "damaged")
    kept = run.read_summary()
    del kept["shares"]
    run.write_summary(kept)
    result = damper3d("compare", tmp_path / "damaged", runs[0])
    assert result.code == 2
    assert "damaged (no shares); use --again" in result.err
    result = damper3d("compare", runs[0])
    assert (result.code, len(result.err.splitlines())) == (2, 1)
