"""The table of `make bench`: its arithmetic, and what the check refuses; nothing is timed."""

import copy
import importlib
import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.speed import table
from benchmarks.speed.__main__ import main
from benchmarks.speed.liggghts import Material
from benchmarks.speed.stages import Step, put_clocks
from benchmarks.speed.timing import BOUND, HERE, Contest, Scene, measured, quartiles
from damper3d.case.case import DamperCase

KEPT = Path(__file__).parents[2] / "docs/results/bench.json"


def made(ratio=0.2, bound=4.0, machine="one"):
    """A record of one scene."""
    against = {
        "LAMMPS": {"cost": 60.0, "ratio": ratio, "low": 0.19, "high": 0.21},
        BOUND: {"cost": 3.0, "ratio": bound, "low": 3.9, "high": 4.1},
    }
    row = {"scene": "spheres", "unit": "us a step", "here": 12.0, "repeats": 5,
           "against": against, "missing": ["YADE"]}  # fmt: skip
    return {
        "machine": machine, "versions": {"Python": "3.11"}, "date": "2026-01-01",
        "command": "python -m benchmarks.speed", "pair_ns": 4.0, "row_ns": 1234.5,
        "scenes": [row], "stages": {"damper3d": {"spheres": {"law": 0.25, "rest": 0.75}}},
    }  # fmt: skip


def test_stretches_take_turns_and_ratios_are_of_neighbours():
    """By hand: costs here 2, 3, 10 over 10, 10, 20 there are 0.2, 0.3, 0.5, whose median is 0.3.

    The ratio of the medians is 0.3, too; that of the means is not. Of three numbers the quartiles
    are the means of neighbours.
    """
    order, here, there = [], iter([2.0, 3.0, 10.0]), iter([10.0, 10.0, 20.0])

    def run(name, costs):
        order.append(name)
        return next(costs)

    runs = {HERE: lambda: run("h", here), "other": lambda: run("o", there)}
    closed = []
    scene = Scene("made", "s", lambda: Contest(runs, ["YADE"], lambda: closed.append(True)))
    row = measured(scene, 3)
    assert "".join(order) == "hohoho"
    assert (row["here"], row["missing"], closed) == (3.0, ["YADE"], [True])
    assert row["against"]["other"] == pytest.approx(
        {"cost": 10.0, "ratio": 0.3, "low": 0.25, "high": 0.4}
    )


def test_a_scene_says_how_often_it_is_repeated_and_ends_its_engines_where_one_fails():
    closed = []

    def fails():
        raise RuntimeError("ended")

    scene = Scene("made", "s", lambda: Contest({HERE: fails}, close=lambda: closed.append(True)))
    with pytest.raises(RuntimeError, match="ended"):
        measured(scene, 3)
    assert closed == [True]
    assert measured(Scene("one", "s", lambda: Contest({HERE: lambda: 1.0}), 1), 5)["repeats"] == 1
    assert quartiles([7.0]) == (7.0, 7.0, 7.0)


@pytest.mark.parametrize(("ratio", "n_lines"), [(0.2, 0), (0.2199, 0), (0.2201, 1), (0.1, 0)])
def test_a_ratio_that_is_more_than_a_tenth_above_the_kept_one_is_refused(ratio, n_lines):
    assert len(table.slower(made(ratio), made(0.2))) == n_lines


def test_the_line_names_scene_engine_and_both_ratios():
    (line,) = table.slower(made(0.3), made(0.2))
    assert line == "spheres: 0.3 of LAMMPS, more than 10% above the 0.2 that is kept"


def test_the_bound_is_compared_on_the_same_processor_only():
    assert len(table.slower(made(bound=5.0), made())) == 1
    assert table.slower(made(bound=5.0, machine="two"), made()) == []


def test_a_check_that_compares_nothing_fails():
    other = copy.deepcopy(made())
    other["scenes"][0]["scene"] = "unknown"
    with pytest.raises(ValueError, match="nothing was compared"):
        table.slower(other, made())


def test_a_row_has_a_line_for_each_engine_the_missing_and_the_bound():
    lines = table.text(made()["scenes"][0]).splitlines()
    assert [line.split()[:1] for line in lines] == [["spheres"], ["YADE"], ["bound"]]
    assert re.search(r"12 us a step +LAMMPS +60 +0\.2 +0\.19 to 0\.21$", lines[0])
    assert lines[1].endswith("not installed")


def test_the_page_has_every_scene_stage_and_version():
    text = table.markdown(made())
    for words in ("| spheres | 12 us a step | LAMMPS | 60 | 0.2 | 0.19 to 0.21 |", "| 25% | 75% |",
                  "Python 3.11", "4 ns a pair", "1234 ns a row"):  # fmt: skip
        assert words in text
    heads = [line.count("|") for line in text.splitlines() if line.startswith("|")]
    assert set(heads) == {7, 4}  # all lines of a table have the columns of its head


def test_the_kept_table_passes_its_own_check():
    kept = json.loads(KEPT.read_text(encoding="utf-8"))
    assert table.slower(kept, kept) == []
    names = [row["scene"] for row in kept["scenes"]]
    assert len(set(names)) == len(names)
    for scenes in kept["stages"].values():
        for shares in scenes.values():
            assert sum(shares.values()) == pytest.approx(1.0)


def test_a_scene_that_is_not_there_is_named_by_those_that_are(monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["speed", "--only", "nothing there"])
    with pytest.raises(SystemExit):
        main()
    assert "no such scene; there are silo2d --help, " in capsys.readouterr().err


def test_materials_of_the_other_engines_give_the_law_back():
    """The thesis's eqs 5.6 and 5.14, with two equal materials; acrylic is 3.3 GPa and 0.37."""
    law = DamperCase.load("thesis").pair_law
    one = Material(law)
    reduced = one.young / (2 * (1 - one.poisson**2))
    shear = one.young / (4 * (2 - one.poisson) * (1 + one.poisson))
    np.testing.assert_allclose([4 / 3 * reduced, 6 * shear / reduced], [law.hertz, law.tangential])
    np.testing.assert_allclose([one.young, one.poisson], [3.3e9, 0.37])


def test_clocks_are_put_into_the_stages_and_change_no_result(monkeypatch, tmp_path):
    """Two stages of a made step, ten times: both take time, and the sum is 10 (10 + 1)/2 = 55."""
    (tmp_path / "made_step.py").write_text(STEP, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    module = importlib.import_module("made_step")
    before = module.go
    counts = put_clocks(Step(["made_step"], {"adding": ["add"], "growing": ["grow", "absent"]}))
    del sys.modules["made_step"]
    assert module.go is not before
    assert module.go(np.zeros(2), 10) == 55.0
    assert all(count[0] > 0 for count in counts.values())


STEP = """
from granulab.contact.jit import njit

@njit
def add(state):
    state[0] += state[1]

@njit
def grow(state, by):
    state[1] += by

@njit
def go(state, n):
    for _ in range(n):
        grow(state, 1.0)
        add(state)
    return state[0]
"""
