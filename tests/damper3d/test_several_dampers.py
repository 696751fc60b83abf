"""Several dampers on one host: its modes take what all beds push, and each bed moves as it does."""

import json
import random
from typing import Any

import numpy as np
import pytest
from refusals import assert_refuses
from same_run import assert_same_run
from small_damper import damper3d
from small_silo import the_run

from damper3d.case.case import DamperCase
from damper3d.run import protocol, vibration
from damper3d.run.sweep import load_study
from damper3d.view.scene import read_scene
from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.trajectory import read_trajectory
from granulab.errors import InputError, Stopped

MODES = """\
frequency [Hz],damping_ratio,shape_tip [kg^-0.5],shape_middle [kg^-0.5],force_shape [kg^-0.5]
80,0.02,3.0,1.5,2.0
250,0.02,2.5,-2.8,2.0
"""
SMALL: dict[str, dict[str, Any]] = {
    "enclosure": {"diameter": "20 mm", "height": "25 mm"},
    "particles": {"shape": "sphere:5mm", "count": 20},
    "law": {"youngs_modulus": "0.1 GPa"},
    "fill": {"settle_time": "20 ms"},
    "run": {"cycles": 4, "discard": 2, "time_step": "5 us"},
    "output": {"samples": 50, "frames": 10},
}
SINGLE = {"mass": "0.1 kg", "frequency": 80.0, "damping_ratio": 0.02, "force": "2 N"}
SEVERAL = {"modes": "modes.csv", "force": "2 N"}
UNLIKE = [
    {"at": "tip"},
    {"at": "middle", "particles": {"count": 12}, "enclosure": {"height": "20 mm"}},
]


def written(host, dampers, **tables) -> dict[str, Any]:
    """The document of a case with dampers on a host."""
    document: dict[str, Any] = {"name": "several", **SMALL, "host": host}
    if dampers is not None:
        document["damper"] = dampers
    for name, table in tables.items():
        document[name] = {**document.get(name, {}), **table}
    return document


def case(folder, host, dampers, **tables) -> DamperCase:
    (folder / "modes.csv").write_text(MODES, encoding="utf-8")
    return DamperCase.resolve(written(host, dampers, **tables), "several", folder)


def test_two_like_dampers_move_a_host_as_one_moves_half_of_it(tmp_path):
    """M x'' + c x' + k x = f + 2 F is M/2 x'' + ... = f/2 + F where both beds move alike.

    Without dashpots, which take the mass behind a wall into account. Their rounding differs, and
    grows with every impact: the first two cycles are compared.
    """
    short = {"run": {"cycles": 2, "discard": 0}, "law": {"restitution": 1.0}}
    twins = case(tmp_path, SINGLE, [{"seed": 1}, {"seed": 1}], **short)
    one = case(tmp_path, {**SINGLE, "mass": "0.05 kg", "force": "1 N"}, None, **short)
    protocol.run(twins, out=tmp_path / "twins")
    protocol.run(one, out=tmp_path / "one")
    folder = the_run(tmp_path / "twins").path
    own, alone = read_trajectory(folder), read_trajectory(the_run(tmp_path / "one").path)
    other = read_trajectory(folder / "damper-2")
    for name in ("displacement", "velocity", "wall_work"):
        size = np.abs(alone[name]).max()
        np.testing.assert_allclose(own[name], alone[name], atol=1e-7 * size, rtol=0)
        np.testing.assert_array_equal(own[name], other[name])
    work = np.abs(alone["host_work"]).max()
    np.testing.assert_allclose(own["host_work"], 2 * alone["host_work"], atol=1e-7 * work, rtol=0)


def test_the_step_of_two_dampers_goes_by_the_load_of_both(tmp_path):
    """As that of one on half the host; a host too light for both is refused."""
    run = {"time_step": None}
    of_both = case(tmp_path, SINGLE | {"mass": "2 g"}, [{}, {}], run=run).steps
    of_one = case(tmp_path, SINGLE | {"mass": "1 g"}, None, run=run).steps
    assert of_both.limit == pytest.approx(of_one.limit, rel=1e-12)
    alone = case(tmp_path, SINGLE | {"mass": "2 g"}, None, run=run).steps
    assert of_one.limit < 0.9 * alone.limit
    light = {"mass": "20 mg"}
    case(tmp_path, SINGLE | light, None, run=run)
    assert_refuses(["the host's mass", "fewer particles"], case, tmp_path, SINGLE | light, [{}, {}])


def test_the_energy_of_a_host_with_two_dampers_is_closed(tmp_path):
    """Work of the force = what the modes hold and damp and both beds take; one alone leaves a gap.

    The bound is that of one damper with these soft spheres and steps.
    """
    both = case(tmp_path, SEVERAL, UNLIKE, run={"cycles": 10, "discard": 2})
    result = protocol.run(both, out=tmp_path / "runs")
    assert abs(result.host["energy_closure"]) < 2e-2
    assert [row["at"] for row in result.dampers] == ["tip", "middle"]
    assert [row["n_particles"] for row in result.dampers] == [20, 12]
    taken = sum(row["dissipated_power_w"] for row in result.dampers)
    assert 0 < result.dampers[1]["dissipated_power_w"] < taken
    folder = the_run(tmp_path / "runs").path
    other = json.loads((folder / "damper-2" / "summary.json").read_text(encoding="utf-8"))
    assert other["dampers"] == result.dampers
    assert other["host"]["amplitude_m"] == result.dampers[1]["amplitude_m"]
    tip, middle = read_trajectory(folder), read_trajectory(folder / "damper-2")
    np.testing.assert_array_equal(tip["host_energy"], middle["host_energy"])
    # What moves at both places are two modes: the difference from the first alone is the second.
    assert np.abs(tip["displacement"] - 2 * middle["displacement"]).max() > 0


def test_a_place_moves_by_its_shape(tmp_path):
    """Of one mode displacements at two places have the ratio of its shapes, at every moment."""
    text = "\n".join(MODES.splitlines()[:2])
    (tmp_path / "one.csv").write_text(text, encoding="utf-8")
    both = case(
        tmp_path, {"modes": "one.csv", "force": "2 N"}, UNLIKE, run={"cycles": 2, "discard": 0}
    )
    protocol.run(both, out=tmp_path / "runs")
    folder = the_run(tmp_path / "runs").path
    tip, middle = read_trajectory(folder), read_trajectory(folder / "damper-2")
    size = np.abs(tip["displacement"]).max()
    np.testing.assert_allclose(
        middle["displacement"], tip["displacement"] / 2, atol=1e-12 * size, rtol=0
    )


@pytest.mark.validation
def test_dampers_stopped_many_times_end_with_the_same_bits_whichever_is_shown(
    tmp_path, monkeypatch
):
    """A checkpoint holds the state of all; seen from the other damper it is the same run."""
    monkeypatch.setattr(vibration, "CHECKPOINT_WORK", 10 * 32 * 50 + 1)  # every ten samples
    both = case(tmp_path, SEVERAL, UNLIKE)
    whole = protocol.run(both, out=tmp_path / "whole")
    chance, stops, result = random.Random(5), 0, None
    while result is None:
        try:
            result = protocol.run(both, out=tmp_path / "parts", stop=lambda: chance.random() < 0.1)
        except Stopped:
            stops += 1
    assert stops > 3
    first, second = the_run(tmp_path / "whole"), the_run(tmp_path / "parts")
    assert_same_run(second, first)
    assert_same_run(RunFolder(second.path / "damper-2"), RunFolder(first.path / "damper-2"))
    protocol.run(case(tmp_path, {**SEVERAL, "shown": 2}, UNLIKE), out=tmp_path / "other")
    other = the_run(tmp_path / "other")
    for mine, theirs in (
        (other.path, first.path / "damper-2"),
        (other.path / "damper-1", first.path),
    ):
        a, b = read_trajectory(mine), read_trajectory(theirs)
        for name in a:
            assert a[name].tobytes() == b[name].tobytes(), name
    again = DamperCase.load(first.path / "damper-2" / "case.toml")
    assert protocol.run_digest(again) == protocol.run_digest(both.shown(1))
    assert whole.state_digest == result.state_digest


@pytest.mark.validation
def test_the_folder_of_another_damper_is_shown_as_a_run(tmp_path):
    """The commands that measure, draw and report take it."""
    protocol.run(case(tmp_path, SEVERAL, UNLIKE), out=tmp_path / "runs")
    folder = the_run(tmp_path / "runs").path / "damper-2"
    observed = json.loads(damper3d("observe", folder, "host", "--json").out)
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    assert observed["energy_closure"] == summary["host"]["energy_closure"]
    scene = read_scene(folder)
    other = case(tmp_path, SEVERAL, UNLIKE).dampers[1]
    assert scene.enclosure.height == other.enclosure.height == 0.02
    assert scene.settings.motion.gamma == other.settings.motion.gamma
    assert scene.title.startswith("middle: 12 spheres of 5 mm")
    assert summary["cpu_s"] > 0
    shown = damper3d("show", folder)
    assert shown.code == 0
    assert "12 of sphere:5mm" in shown.out
    assert damper3d("render", folder, "--no-film").code == 0
    assert (folder / "figures" / "host.png").stat().st_size > 10_000


def test_a_seed_is_that_of_all_dampers_of_a_run(tmp_path):
    """As given with --seed: the first has it, another its own, or one that is far from it."""
    both = case(tmp_path, SEVERAL, [*UNLIKE, {"at": "tip", "seed": 3}])
    seeded = [one.settings.run.seed for one in both.with_seed(7).dampers]
    assert seeded == [7, 10_007, 3]
    again = case(tmp_path, SEVERAL, [*UNLIKE, {"at": "tip", "seed": 3}], run={"seed": 7})
    assert protocol.run_digest(both.with_seed(7)) == protocol.run_digest(again)
    assert (
        DamperCase.resolve(written({}, None), "one", tmp_path).with_seed(4).settings.run.seed == 4
    )


@pytest.mark.parametrize("given", [3, {"at": "tip"}])
def test_dampers_that_are_no_list_are_refused(given, tmp_path):
    with pytest.raises(InputError, match=r"several: damper = .*: must be a list, in brackets"):
        DamperCase.resolve({"damper": given}, "several", tmp_path)


def study(folder, *vary):
    (folder / "modes.csv").write_text(MODES, encoding="utf-8")
    (folder / "arm.toml").write_text(
        'schema = 1\n[host]\nmodes = "modes.csv"\nforce = "2 N"\n[[damper]]\nat = "tip"\n'
        '[[damper]]\nat = "middle"\n', encoding="utf-8",
    )  # fmt: skip
    path = folder / "study.toml"
    lines = ["schema = 1", 'case = "arm.toml"', "[vary]", *vary]
    path.write_text("\n".join(lines), encoding="utf-8")
    return load_study(path)


def test_a_study_varies_keys_of_one_damper(tmp_path):
    """By name or number, with quotes or without; a quantity is a column with its unit."""
    loaded = study(
        tmp_path, "damper.tip.particles.count = [100, 200]",
        '"damper.2.enclosure.height" = { start = "30 mm", stop = "40 mm", number = 2 }',
    )  # fmt: skip
    labels, last = loaded.cases[-1]
    assert [one.count for one in last.dampers] == [200, 358]
    assert [one.enclosure.height for one in last.dampers] == [0.04, 0.04]
    assert [one.enclosure.height for one in loaded.cases[0][1].dampers] == [0.04, 0.03]
    assert labels["damper.2.enclosure.height_m"] == 0.04
    assert len({protocol.run_digest(each) for _, each in loaded.cases}) == 4


@pytest.mark.parametrize(
    ("vary", "words"),
    [
        ("damper.top.particles.count = [1]", ["no damper is called 'top'", "tip, middle"]),
        ("damper.3.particles.count = [1]", ["'3'", "tip, middle"]),
        ("damper.2.motion.gamma = [1]", ["damper.2.motion.gamma", "enclosure, particles, law"]),
        ("damper.2.particles.cont = [1]", ["particles.cont", "particles.count"]),
        ('damper.2.enclosure.height = ["3 kg"]', ["damper.2.enclosure.height", "unit is wrong"]),
    ],
)
def test_keys_that_no_damper_has_are_refused(tmp_path, vary, words):
    assert_refuses(words, study, tmp_path, vary)


@pytest.mark.parametrize(
    ("host", "dampers", "tables", "words"),
    [
        ({}, UNLIKE, {}, ["[[damper]]", "give [host] too"]),
        (SEVERAL, [{"at": "top"}, {"at": "tip"}], {}, ["shape_top", "tip, middle"]),
        (SINGLE, UNLIKE, {}, ["[[damper]] 1", "at = 'tip'", "give [host] modes"]),
        (SEVERAL, [{}, {}], {}, ["'shape' is missing", "at = 'tip'"]),
        ({**SEVERAL, "shown": 3}, UNLIKE, {}, ["shown = 3", "there are 2 dampers"]),
        ({**SEVERAL, "at": "tip"}, UNLIKE, {}, ["at is of a single damper"]),
        (
            SEVERAL,
            [{"at": "tip"}, {"at": "middle", "particles": {"materials": "mine.toml"}}],
            {},
            ["[[damper]] 2", "materials", "one file"],
        ),
        (
            SEVERAL,
            [{"at": "tip"}, {"at": "middle", "enclosure": {"shape": "box", "width": "20 mm",
                                                           "depth": "20 mm", "diameter": None}}],
            {},
            ["[[damper]] 2", "enclosure box, of the first cylinder"],
        ),
        (
            SEVERAL,
            [{"at": "tip"}, {"at": "middle", "particles": {"kind": [
                {"shape": "sphere:5mm", "mass_fraction": 0.5},
                {"shape": "prolate:1.5", "equal_volume_radius": "2 mm", "mass_fraction": 0.5}]}}],
            {},
            ["[[damper]] 2", "of several shapes or sizes, of the first spheres"],
        ),
        (
            SEVERAL,
            [{"at": "tip"}, {"at": "middle", "particles": {"count": 0}}],
            {},
            ["[[damper]] 2", "count = 0"],
        ),
        (SEVERAL, [{"at": "tip"}, {"at": "middle", "mass": 1}], {}, ["unknown key 'mass'"]),
        (SEVERAL, [{"at": "tip"}], {}, ["damper", "at least 2"]),
        (
            {
                "inertia": "1e-6 kg m2",
                "frequency": 80.0,
                "damping_ratio": 0.02,
                "torque": "1e-3 N m",
            },
            UNLIKE,
            {},
            ["inertia", "one damper"],
        ),
    ],
)  # fmt: skip
def test_dampers_that_cannot_be_together_are_refused(host, dampers, tables, words, tmp_path):
    assert_refuses(words, case, tmp_path, host, dampers, **tables)
