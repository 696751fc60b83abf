"""A gate that closes, a feeder, refilling, plates and vibration of whole runs; what is refused."""

import random
from pathlib import Path

import numpy as np
import pytest
from refusals import assert_refuses
from small_silo import DischargeStop, write_case

from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.trajectory import read_trajectory
from granulab.contact.files.datafile import data_file
from granulab.errors import Stopped
from silo2d.case.case import SiloCase
from silo2d.engine.simulation import Simulation
from silo2d.measures import residence, stickslip
from silo2d.measures.basics.particles import in_silo
from silo2d.run import discharge
from silo2d.run.beds.acts import Acts
from silo2d.run.discharge import check_rim, open_door
from silo2d.run.ending import Clock
from silo2d.run.packing import Packing
from silo2d.run.protocol import run, run_digest, world_behind_door
from silo2d.view.charts import discharge_chart
from silo2d.view.report import echo, report
from silo2d.view.scene import read_scene


def result_of(folder, **changes):
    """A run of the small silo, its energies closed: to 0.5 % of what is dissipated without acts.

    A store brings twice the particles, a feeder takes them before they have lost much.
    """
    folder.mkdir(exist_ok=True)
    path = write_case(folder, {key.replace("__", "."): value for key, value in changes.items()})
    result = run(SiloCase.load(path), out=folder / "runs")
    assert abs(result.energy_closure) < 0.015
    return result, read_trajectory(result.run_folder)


def test_nothing_leaves_while_the_gate_is_closed(tmp_path):
    """Those that stand in it leave with it; none after, until it opens again."""
    result, frames = result_of(tmp_path, flow__gate_times=["0.05 s", "0.2 s"])
    out = np.sort(frames["out_time"][-1])
    assert not ((out > 0.05 + 1e-9) & (out < 0.2)).any()
    assert (out < 0.05 + 1e-9).sum() > 0
    assert (out > 0.2).sum() > 20
    assert result.outcome == "empty"


def test_a_feeder_takes_its_rate(tmp_path):
    """One particle every 1/rate: the k-th at k/rate, to a step, while some lie over the outlet."""
    result, frames = result_of(tmp_path, flow__feed_rate="100 1/s", run__max_time="0.4 s")
    out = np.sort(frames["out_time"][-1])[: result.n_out]
    expected = np.arange(1, result.n_out + 1) / 100
    assert 35 <= result.n_out <= 40
    np.testing.assert_allclose(out, expected, atol=result.time_step_s)


def test_a_store_keeps_the_number_and_is_used_up(tmp_path):
    result, frames = result_of(tmp_path, flow__refill=40)
    inside = frames["inside"].sum(axis=1)
    at_first = result.n_particles
    assert (inside[0], result.n_store) == (at_first, 40)
    assert result.mass_out_kg == pytest.approx(result.mass_kg + result.mass_store_kg, rel=1e-9)
    assert f"of {at_first} particles and 40 in store out" in report(result)
    assert result.n_refilled == 40
    (axes,) = discharge_chart(read_scene(result.run_folder)).axes
    assert axes.texts[0].get_text() == f"all {at_first} and 40 in store"
    used_up = frames["inside"][:, at_first:].any(axis=1)
    # A look every 10 ms: what left between two looks may be missing.
    while_there = frames["n_out"] < 30
    assert (inside[while_there] >= at_first - 12).all()
    assert used_up.any()
    assert result.n_out > at_first
    assert result.outcome == "empty"


def test_a_store_that_is_not_used_up_says_what_it_gave(tmp_path):
    """What stands in the way of a run that ends before, or of one with no way to the surface."""
    result, frames = result_of(tmp_path, flow__refill=40, run__max_time="0.1 s")
    put = frames["inside"][:, result.n_particles :].any(axis=0).sum()
    assert put <= result.n_refilled < 40  # after the last frame some more may have been
    said = f"and 40 in store, of which {result.n_refilled or 'none'} were put on top, out"
    assert said in report(result)


def test_plates_slow_the_discharge(tmp_path):
    bare, _ = result_of(tmp_path / "bare")
    rubbed, _ = result_of(tmp_path / "rubbed", law__mu_plates=0.5, law__plates_ratio=0.4)
    assert rubbed.mean_rate_per_s < bare.mean_rate_per_s


def test_acts_gone_on_with_end_with_the_same_bits(tmp_path):
    """Gate, store and vibration follow from steps and state: stops at looks change no bit."""
    changes = {
        "flow.gate_times": ["0.05 s", "0.1 s"], "flow.refill": 20,
        "flow.vibration_amplitude": "0.2 mm", "flow.vibration_frequency": "50 Hz",
    }  # fmt: skip
    case = SiloCase.load(write_case(tmp_path, changes))
    whole = run(case, out=tmp_path / "whole")
    assert read_trajectory(whole.run_folder)["given_to_door"][-1] < 0.0  # the walls gave energy
    chance, stops, result = random.Random(3), 0, None
    stop = DischargeStop(lambda: chance.random() < 0.2)
    while result is None:
        try:
            result = run(case, out=tmp_path / "parts", progress=stop.progress, stop=stop)
        except Stopped:
            stops += 1
    assert stops >= 3
    assert result.state_digest == whole.state_digest
    assert result.n_out == whole.n_out


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"law.mu_plates": 0.4}, ["[law] mu_plates", "plates_ratio = 0.4"]),
        ({"law.plates_ratio": 0.4}, ["[law] plates_ratio", "mu_plates"]),
        ({"flow.gate_times": ["0.3 s", "0.2 s"]}, ["gate_times", "ascend"]),
        ({"flow.gate_times": ["0.3 mm"]}, ["gate_times = '0.3 mm'", "unit"]),
        ({"flow.feed_rate": "5 1/s"}, ["feed_rate = 5 1/s", "at rest", "13.3"]),
        ({"flow.feed_rate": "0 1/s"}, ["feed_rate", "greater than 0"]),
        ({"flow.feed_rate": "3e5 1/s"}, ["feed_rate = 300000 1/s", "a time step", "at most 2e+05"]),
        (
            {"flow.feed_rate": "50 1/s", "flow.gate_times": ["1 s"]},
            ["feed_rate", "does not go with [flow] gate_times"],
        ),
        ({"flow.refill": -1}, ["refill = -1", "greater than or equal to 0"]),
        ({"flow.vibration_amplitude": "1 mm"}, ["vibration_frequency = '30 Hz'"]),
        (
            {"flow.vibration_amplitude": "1 mm", "flow.vibration_frequency": "500 Hz"},
            ["vibration_frequency = 500 Hz", "at most 50 g"],
        ),
        (
            {"flow.vibration_amplitude": "1e-9 m", "flow.vibration_frequency": "20 kHz"},
            ["vibration_frequency = 20000 Hz", "20 time steps a period", "at most 1e+04 Hz"],
        ),
        (
            {"flow.vibration_amplitude": "30 mm", "flow.vibration_frequency": "1 Hz"},
            ["vibration_amplitude = 30 mm", "narrowest particle"],
        ),
        (
            {"flow.gate_times": ["1 s"], "run.door_speed": "1 m/s"},
            ["gate_times does not go with [run] door_speed"],
        ),
        ({"flow.refill": 10, "run.engine": "pymunk"}, ["[flow] refill", "engine = 'dem'"]),
        (
            {"output.wall_interval": "1 ms", "run.engine": "pymunk"},
            ["[output] wall_interval", "engine = 'dem'"],
        ),
    ],
)
def test_an_act_that_cannot_be(changes, words):
    assert_refuses(["A4", *words], SiloCase.load, "A4", changes)


@pytest.mark.parametrize(
    ("changes", "published"),
    [
        ({"flow.refill": 50}, None),
        ({"flow.gate_times": ["0.3 s"]}, None),
        ({"flow.vibration_amplitude": "1 mm", "flow.vibration_frequency": "5 Hz"}, None),
        ({"law.mu_plates": 0.4, "law.plates_ratio": 0.5}, "A4"),
        ({"particles.shapes": "shares.toml"}, "A4"),
    ],
)
def test_a_silo_with_what_the_paper_has_not_bears_another_name(
    changes, published, tmp_path, monkeypatch
):
    """Times of a discharge with a gate, a store or vibration are none to compare with."""
    monkeypatch.chdir(tmp_path)
    wood = data_file("shapes", "wood19").read_text(encoding="utf-8")
    Path("shares.toml").write_text(wood.replace("[[shape]]", "[[shape]]\nshare = 7", 1))
    case = SiloCase.load("A4", changes)
    assert (case.label, case.published_name) == ("A4 (changed)", published)


@pytest.mark.parametrize(
    "changes", [{"flow.vibration_direction": "horizontal"}, {"flow.gate_times": ["7 s", "8 s"]}]
)
def test_what_never_acts_makes_no_other_silo(changes):
    """A direction without vibration, and a gate after the end of the run."""
    case = SiloCase.load("A4", changes)
    assert (case.label, run_digest(case)) == ("A4", run_digest(SiloCase.load("A4")))


def test_a_silo_whose_outlet_is_out_of_the_middle_is_not_the_papers():
    flat = SiloCase.load("D1").outline.polygon * 1e3
    silo = {"outline": flat.tolist(), "outlet": "40 mm"}
    names = [
        SiloCase.resolve({"name": "x", "silo": silo | more}, "x", Path()).silo_name
        for more in ({}, {"outlet_centre": "20 mm"})
    ]
    assert names == ["D1", None]


def test_nothing_is_at_rest_while_its_walls_vibrate(tmp_path):
    """However weak: the run ends at its time, and whether it clogged is not known."""
    result, _ = result_of(
        tmp_path, flow__vibration_amplitude="0.1 um", flow__vibration_frequency="20 Hz",
        run__rest_time="20 ms", run__max_time="0.6 s", law__mu_particle=1.0,
    )  # fmt: skip
    assert (result.outcome, result.clogged) == ("time_limit", None)
    assert_refuses(["its walls vibrate"], stickslip.measure, Path(result.run_folder))


def test_the_echo_names_what_acts_besides(tmp_path):
    (tmp_path / "curve.csv").write_text("overlap,force\n0.01 mm,50 N\n0.02 mm,150 N\n")
    changes = {
        "silo.inserts": [[[-40, 180], [40, 180], [0, 250]]], "law.mu_plates": 0.4,
        "law.plates_ratio": 0.5, "law.kn_curve": str(tmp_path / "curve.csv"), "flow.refill": 9,
        "flow.gate_times": ["0.3 s"], "flow.vibration_amplitude": "1 mm",
        "flow.vibration_frequency": "5 Hz",
    }  # fmt: skip
    text = echo(SiloCase.load("A4", changes), dry_run=True)
    for words in ("CurveLaw: kn 1e+07", "1 inserts, 1 outlets", "plates: mu 0.4", "0.3 s", "5 Hz"):
        assert words in text
    assert "  besides  " not in echo(SiloCase.load("A4"), dry_run=True)


DISCS = """
schema = 1

[[shape]]
name = "disc"
form = "disc"
size = "8 mm"
"""


def of_discs(folder, **changes):
    folder.mkdir(exist_ok=True)
    (folder / "discs.toml").write_text(DISCS, encoding="utf-8")
    return result_of(folder, particles__shapes="discs.toml", **changes)


def test_a_gate_closes_among_discs_without_energy_from_nothing(tmp_path):
    """Their spheroradius is all of them: a tenth of it, left in the gate, was a deep overlap."""
    result, _ = of_discs(tmp_path, flow__gate_times=["0.05 s", "0.15 s"])
    assert result.time_step_halvings == 0


def test_discs_of_one_size_have_another_bed_for_each_seed(tmp_path):
    """No angle tells them apart: by their places alone the seeds differ."""
    times = {of_discs(tmp_path, run__seed=seed)[0].discharge_time_s for seed in (1, 2, 3)}
    assert len(times) == 3


def test_a_shaken_silo_is_not_called_clear(tmp_path):
    """It has no rest, by which a clog is told: whether it clogged is not known."""
    still = {"silo__outlet": "12 mm", "run__max_time": "0.4 s"}
    shaken = {"flow__vibration_amplitude": "0.05 mm", "flow__vibration_frequency": "50 Hz"}
    assert result_of(tmp_path, **still)[0].clogged is True
    result, _ = result_of(tmp_path, **still, **shaken)
    assert (result.outcome, result.clogged) == ("time_limit", None)


def test_particles_of_the_store_are_in_no_measure_before_they_are_in_the_silo(tmp_path):
    """Residence is of those that were there at the opening; none waits in a band or a column."""
    result, frames = result_of(tmp_path, flow__refill=40)
    folder, filled = RunFolder(result.run_folder).path, result.n_particles
    found = residence.measure(folder)
    assert found["n_out"] + found["n_staying"] == filled
    assert sum(one["n_out"] for one in found["by_column"]) == found["n_out"]
    assert not (in_silo(read_scene(folder)) & ~frames["inside"]).any()


SHAKEN = {"flow.vibration_amplitude": "6 mm", "flow.vibration_frequency": "45 Hz"}


def opened(changes, *poses):
    """A4 with particles of its first kind at poses, just opened: case, simulation and acts."""
    case = SiloCase.load("A4", changes)
    packing = Packing(np.zeros(len(poses), np.int64), np.array(poses), None, 0.0, "dem", 0.0)
    sim = Simulation(world_behind_door(case, packing))
    open_door(sim, case, packing, Clock())
    return case, sim, Acts.of(case, packing, sim)


def test_a_gate_that_vibrates_takes_what_stands_where_it_closes():
    """After a quarter period the door is 6 mm above its place, and 3 mm deep in the particle."""
    shape = SiloCase.load("A4").shapes.shapes[0]
    foot = shape.spheroradius - shape.core[:, 1].min()
    quarter = 1 / 45 / 4
    _, sim, acts = opened(SHAKEN | {"flow.gate_times": [f"{quarter} s"]}, (0.0, foot + 3e-3, 0.0))
    sim.run(acts.gate[0])
    acts.act(sim)
    assert (sim.n_out, len(sim.live)) == (1, 0)


def test_what_is_put_on_a_shaken_bed_keeps_clear_of_the_walls():
    """By the amplitude: they come so far."""
    flat = {"silo.angle": "0 deg", "silo.outlet": "60 mm", "flow.refill": 9}
    case, _, acts = opened(SHAKEN | flat, (0.0, 0.1, 0.0))
    radius = case.shapes.bounding_radius
    found = acts.surface.places(np.zeros((0, 2)), np.zeros(0), np.full(99, radius))
    assert np.abs(found[:, 0]).max() <= 0.15 - radius - 6e-3
    assert found[:, 1].min() >= radius + 6e-3


WINDOW = [[[150, 200], [150, 270]]]


@pytest.mark.parametrize(
    ("changes", "pose", "thrown"),
    [
        ({}, (0.2, 0.3, 0.0), True),
        ({}, (-0.2, 0.01, 0.0), True),
        ({}, (0.14, 0.6, 0.0), False),  # above the rim, in the silo's width
        (SHAKEN, (0.154, 0.3, 0.0), False),  # at a wall that has moved
        ({"silo.outlets": WINDOW}, (0.2, 0.25, 0.0), False),  # out of the window
        ({"silo.outlets": WINDOW}, (0.2, 0.4, 0.0), True),
    ],
)
def test_a_particle_that_left_over_the_rim_is_not_discharged(changes, pose, thrown, monkeypatch):
    """It ends the run at the next look, long before it has fallen to y = 0.

    Its height is from nowhere here, which another check of a look would find first.
    """
    monkeypatch.setattr(discharge, "check_energy_balance", lambda *_: None)
    case, sim, acts = opened(changes, pose)
    if not thrown:
        check_rim(sim, case)
        return
    look = discharge._look
    assert_refuses(
        ["A4: [silo] height = 500 mm", "leave over the open top (1 by", "a higher silo"],
        look, sim, case, acts.packing, Clock(), acts,
    )  # fmt: skip
