"""Many dampers at once go as each does by itself; on numba's simulator of a GPU too."""

import dataclasses
import json
import math
import os
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
from damper_beds import DOWN, NOWHERE, acrylic, bed
from refusals import assert_refused
from small_damper import CASE, damper3d, write_damper
from small_silo import silo2d

from damper3d.case.case import DamperCase
from damper3d.engine.batch.batch import Batch, Batched
from damper3d.engine.batch.loop import Processor
from damper3d.engine.batch.slots import (
    STEP,
    Slots,
    empty,
    lacks_room,
    put,
    reason_against,
    take,
)
from damper3d.engine.motions import Sines
from damper3d.engine.simulation import Simulation
from damper3d.engine.state import N_BALANCE, N_COLUMNS
from damper3d.run.device import going_on
from damper3d.run.fill import resting
from damper3d.run.sweep import DAMPER, run_cases
from granulab.campaign.sweeps.sweep import over_seeds, run_labelled
from granulab.errors import SimulationError

HELPERS = Path(__file__).parent.parent / "helpers"
# Sums are rounded in another order. Rounding grows with each impact, by the diameter over the
# overlap or so; in 2 ms a sphere has two or three, and 2e-13 is found. Mistakes are larger than
# the overlaps, 1e-3, in something.
ROUNDING = 1e-9
BEDS = {
    "cylinder": ("cylinder", {"direction": (0.0, 0.6, 0.8)}),
    "tilted box": ("box", {"direction": (0.6, 0.0, 0.8), "gravity": (1.0, -9.0, 3.0)}),
    "stored force": ("box", {"pair_law": acrylic(tangential="force"), "gravity": NOWHERE}),
    "no pull": ("cylinder", {"wall_law": acrylic(0.3, 0.7, end="force"), "speed": 1.0}),
    "yielding": ("box", {"pair_law": acrylic(yielding=True), "speed": 3.0}),
    "two sines that grow": (
        "cylinder",
        {"shaker": Sines(np.array([1e-3, 4e-4]), np.array([600.0, 1500.0]), np.ones(2), 2e-3)},
    ),
}


def made(name: str, n: int = 36, **options):
    shape, own = BEDS[name]
    usual = {"gravity": DOWN, "speed": 0.5, "steps_per_sample": 100}
    return bed(shape, n, **{**usual, **own, **options})


def slot_for(sim, wanted: int, **options) -> Slots:
    slots = empty(1, sim.n_particles + 2, 7, **{"n_sines": 3, "rows": wanted, **options})
    assert put(slots, 0, sim, wanted)
    return slots


def gone_on(slots: Slots, most: int = 10**9) -> Slots:
    """The slots after so many steps at most, by one thread."""
    device = Processor(slots)
    device.bring(0, slots)
    device.go_on(slots.clock, np.array([0]), most)
    device.fetch(slots, Slots._fields[1:])
    return slots


def assert_same(found, expected, within: float = 0.0):
    """Arrays by name, to so much of the largest value."""
    assert found.keys() == expected.keys()
    for name, array in expected.items():
        scale = np.abs(array).max(initial=0.0)
        assert np.abs(np.asarray(found[name], float) - array).max(initial=0.0) <= within * scale, (
            name
        )


@pytest.mark.parametrize("name", BEDS)
def test_a_slot_goes_as_the_engine_of_one_bed(name):
    """All samples, then motion, histories and books; from a state with contacts that last."""
    alone, other = made(name, steps_per_sample=10), made(name, steps_per_sample=10)
    while not len(alone.save()["pairs"]):
        for sim in (alone, other):
            sim.run(1)
    for sim in (alone, other):
        sim.steps_per_sample = 100
    expected = alone.run(15)
    found = other.named(take(gone_on(slot_for(other, 15)), 0, other)[:, : len(other.room(1)[0])])
    assert (
        expected["contacts_particle_wall"].max() > 0 < expected["contacts_particle_particle"].max()
    )
    assert_same(found, expected, ROUNDING)
    assert_same(other.save(), alone.save(), ROUNDING)


def test_the_curvature_of_a_round_wall_enters_the_law_in_a_slot_too():
    alone, other = (made("cylinder") for _ in range(2))
    for sim in (alone, other):
        sim.world = sim.world._replace(walls=sim.world.walls._replace(curved=True))
    flat = made("cylinder").run(20)
    expected = alone.run(20)
    assert np.abs(expected["wall_force"] - flat["wall_force"]).max() > 1e-3
    found = other.named(take(gone_on(slot_for(other, 20)), 0, other)[:, : len(other.room(1)[0])])
    assert_same(found, expected, ROUNDING)


def test_no_bit_depends_on_where_a_slot_is_interrupted():
    """Lists are made anew where a part begins: no force depends on when."""
    sim, whole = made("cylinder"), slot_for(made("cylinder"), 8)
    gone_on(whole)
    parts = slot_for(sim, 8)
    device = Processor(parts)
    device.bring(0, parts)
    while parts.clock[0, STEP] < 800:
        device.go_on(parts.clock, np.array([0]), 37)
    device.fetch(parts, Slots._fields[1:])
    for name in ("rows", "position", "velocity", "spin", "books"):
        assert (getattr(parts, name) == getattr(whole, name)).all(), name


def test_threads_of_a_gpu_come_to_the_bits_of_one(tmp_path):
    """On numba's simulator: a sphere a thread, or three; with a barrier left out they differ."""
    both = empty(2, 8, 6, rows=3)
    for s, name in enumerate(("tilted box", "cylinder")):
        one = empty(1, 8, 6, rows=1)
        assert put(one, 0, made(name, 8 - s, steps_per_sample=5, speed=3.0), 3)
        for array, own in zip(both[:-1], one[:-1], strict=True):
            array[s] = own[0]
    np.savez(tmp_path / "given.npz", **both._asdict())
    surroundings = {"NUMBA_ENABLE_CUDASIM": "1", "NUMBA_DISABLE_JIT": "1"}
    for threads in (8, 3):
        subprocess.run(
            [sys.executable, HELPERS / "simulated_gpu.py", tmp_path / "given.npz", str(threads),
             "15", tmp_path / "result.npz"],
            env=os.environ | surroundings, check=True,
        )  # fmt: skip
        with np.load(tmp_path / "result.npz") as found:
            assert found["clock"][:, STEP].tolist() == [15, 15]
            columns = slice(N_COLUMNS + N_BALANCE + 3 * 3)  # which both have: three walls
            assert (found["rows"][..., columns] == found["rows_alone"][..., columns]).all()
            for name in ("clock", "position", "velocity_now", "spin_now", "velocity", "spin",
                         "books", "listed", "near", "history", "lasting"):  # fmt: skip
                assert (found[name] == found[f"{name}_alone"]).all(), (threads, name)


# Together


@pytest.fixture
def batch():
    slots = empty(3, 38, 7, n_sines=3, rows=7)
    batch = Batch(Processor(slots), slots, "one thread")
    yield batch
    batch.close()


def test_beds_of_a_batch_go_on_from_threads_and_what_has_no_slot_by_itself(batch):
    """Four beds in three slots, more samples at once than these hold, and looks between."""
    names = list(BEDS)[:4]
    expected = {name: made(name) for name in names}
    beds = {name: Batched(made(name), batch) for name in names}
    rows, looks = {}, {}
    all_joined = threading.Barrier(len(names))

    def go(name: str) -> None:
        first = beds[name].run(10)
        all_joined.wait()
        looks[name] = beds[name].frame(), beds[name].contacts()
        second = beds[name].run(5)
        rows[name] = {key: np.concatenate([first[key], second[key]]) for key in first}

    threads = [threading.Thread(target=go, args=(name,)) for name in names]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    left = [beds[name].leave() for name in names]
    assert sorted(map(str, left)) == ["None"] + ["one thread"] * 3
    assert batch.refused == {"all slots were taken": 1}
    for name in names:
        first, second = expected[name].run(10), None
        frame, contacts = expected[name].frame(), expected[name].contacts()
        second = expected[name].run(5)
        whole = {key: np.concatenate([first[key], second[key]]) for key in first}
        assert_same(rows[name], whole, ROUNDING)
        assert_same(looks[name][0], frame, ROUNDING)
        assert_same(looks[name][1], contacts, ROUNDING)
        assert_same(beds[name].save(), expected[name].save(), ROUNDING)


def test_a_bed_with_more_neighbours_than_a_slot_holds_goes_on_by_itself():
    """From the middle of a sample on."""
    for room in (1, 2):
        slots = empty(1, 36, 3, room=room, rows=20)
        batch = Batch(Processor(slots), slots)
        sim, expected = Batched(made("cylinder"), batch), made("cylinder")
        assert_same(sim.run(20), expected.run(20), ROUNDING)
        assert_same(sim.save(), expected.save(), ROUNDING)
        assert sum(batch.refused.values()) == 1
        batch.close()


def test_a_step_that_is_too_long_fails_as_it_does_alone(batch):
    sim = Batched(made("cylinder", speed=60.0, time_step=2e-5), batch)
    with pytest.raises(SimulationError, match=r"try a shorter --time-step"):
        sim.run(500)
    sim.leave()


def thrown_down(**changes) -> Simulation:
    """Three spheres that fly to the floor at 3 m/s, without gravity."""
    case = DamperCase.load("thesis", {"particles.count": 3, **changes})
    sim = resting(case, np.array([[-0.01, 0.0, 0.003], [0.0, 0.0, 0.003], [0.01, 0.0, 0.003]]))
    sim.begin_phase(gravity=np.zeros(4))
    sim.set_velocity(np.array([[0.0, 0.0, -3.0]] * 3))
    sim.steps_per_sample = 20
    return sim


def test_a_sphere_half_in_a_wall_fails_in_a_slot_too(batch):
    """Acrylic of 30 kPa gives way by more than half a radius; the slot says so, and lets go."""
    soft = {"law.youngs_modulus": "30 kPa"}
    for sim in (thrown_down(**soft), Batched(thrown_down(**soft), batch)):
        with pytest.raises(SimulationError, match="overlap reached half a radius"):
            sim.run(100)
    assert sum(batch.refused.values()) == 1


def test_a_slot_takes_no_more_contacts_than_a_number_has_bits():
    """24 neighbours and 42 walls: bits beyond the 63rd got lost, and with them contacts."""
    around = 2 * np.pi * np.arange(40) / 40
    faces = [[math.cos(a), math.sin(a), 0, 20] for a in around] + [[0, 0, 1, 40], [0, 0, -1, 0]]
    walls = {"shape": "polyhedron", "faces": faces, "unit": "mm"}
    sim = thrown_down(**{f"enclosure.{key}": value for key, value in walls.items()})
    assert "walls" in (lacks_room(empty(1, 3, 42), sim) or "")
    assert lacks_room(empty(1, 3, 42, room=21), sim) is None


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"particles.shape": "prolate:1.5", "particles.count": 4}, "particles of several spheres"),
        ({"law.rolling_friction": 0.1, "law.rolling_stiffness": "1e5 N/m"}, "rolling resistance"),
        ({"enclosure.shape": "sphere", "enclosure.height": None}, "curved walls other than"),
    ],
)
def test_what_a_slot_does_not_have_is_said(changes, words, tmp_path):
    case = DamperCase.load(write_damper(tmp_path, changes))
    sim = resting(case, np.array([[0.0, 0.0, 0.01]] * case.count))
    assert words in (reason_against(sim) or "")


# A sweep


def labelled():
    cases = []
    for gamma in (5, 12):
        changes = {**CASE, "motion.gamma": gamma, "output.keep": "summary"}
        cases += over_seeds({"gamma": gamma}, DamperCase.load("thesis", changes), [1, 2])
    return cases


def test_a_sweep_on_a_device_has_the_rows_of_one_on_cores_and_repeats_its_digests(tmp_path):
    """To rounding, which three cycles of twenty soft spheres let grow to 1e-6 at most."""
    expected = run_cases(labelled(), out=tmp_path / "cores", quiet=True, workers=1)
    on_device = dataclasses.replace(
        DAMPER, device=lambda cases: going_on(cases, Processor, "one thread")
    )
    found = [
        run_labelled(on_device, labelled(), out=tmp_path / name, quiet=True, engine="cuda",
                     workers=workers)
        for name, workers in (("first", None), ("second", 1))
    ]  # fmt: skip
    for rows in zip(expected, *found, strict=True):
        assert [row["state"] for row in rows] == ["done"] * 3, rows
        assert rows[1]["state_digest"] == rows[2]["state_digest"]
        for key in ("efficiency_with_settling", "dissipated_power_w", "peak_wall_force_n"):
            assert rows[1][key] == pytest.approx(rows[0][key], rel=1e-6)
        assert rows[1]["phase"] == rows[0]["phase"]
        origin = json.loads((Path(rows[1]["run_folder"]) / "provenance.json").read_text())
        assert origin["device"] == "one thread"
        origin = json.loads((Path(rows[0]["run_folder"]) / "provenance.json").read_text())
        assert "device" not in origin


def test_engine_cuda_without_a_gpu_is_refused_before_anything_is_computed(tmp_path, monkeypatch):
    monkeypatch.setattr("damper3d.engine.batch.device.missing", lambda: "an NVIDIA GPU")
    monkeypatch.chdir(tmp_path)
    refused = damper3d("map", "--engine", "cuda", "--frequencies", "40", "--gammas", "5")
    assert_refused(refused, "engine cuda: this machine lacks an NVIDIA GPU", "without --engine")
    refused = silo2d("reproduce", "discharge", "--engine", "cuda", "--out", tmp_path)
    assert_refused(refused, "--engine", "'cuda'", "'processes', 'dask'")
