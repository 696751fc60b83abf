"""Disk and memory that runs take are reported before them, and are enough."""

import dataclasses
import shutil
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from fake_simulator import FAKE, fake
from small_damper import damper3d
from small_silo import DRY, silo2d

from damper3d.case import plan as damper_plan
from damper3d.case.case import DamperCase
from damper3d.run.fill import resting
from granulab.campaign.output import room
from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.sharing import cores
from granulab.campaign.sweeps.sweep import run_labelled
from silo2d.case import plan as silo_plan
from silo2d.case.case import SiloCase

KEPT = Path(__file__).parents[1] / "data" / "kept"


def bytes_of(run: Path, *patterns: str) -> int:
    return sum(path.stat().st_size for pattern in patterns for path in run.glob(pattern))


@pytest.mark.parametrize(
    ("case_of", "plan", "pattern"),
    [
        (SiloCase, silo_plan, "silo/finished-*"),
        (SiloCase, silo_plan, "silo/pymunk-*"),
        (SiloCase, silo_plan, "silo/begun-*"),
        (DamperCase, damper_plan, "damper/spheres-*f2c032c051bd"),
        (DamperCase, damper_plan, "damper/spheroids-*"),
        (DamperCase, damper_plan, "damper/begun-*"),
    ],
)
def test_what_is_told_is_enough_and_not_far_too_much(case_of, plan, pattern):
    """Of runs to their longest time, a few frames each: the names of arrays count for most."""
    (run,) = (path for path in KEPT.glob(pattern) if (path / "case.toml").exists())
    reported = plan.disk_at_most(case_of.load(RunFolder(run).case_file))
    frames = bytes_of(run, "trajectory.h5", "records.csv", "parts/*")
    assert frames < reported["frames"] + reported["contacts"] < 10 * frames
    assert bytes_of(run, "checkpoint.h5", "checkpoints/*") < reported["checkpoints"]


def test_a_contact_a_frame_and_a_sample_are_as_long_as_told():
    """Bytes of a row of each in the kept runs, which the sums are made of."""
    (silo,) = KEPT.glob("silo/finished-*")
    (damper,) = KEPT.glob("damper/spheroids-*")
    with h5py.File(silo / "trajectory.h5") as file:
        frames, n = file["frames"], len(file["static/mass"])
        case = SiloCase.load(RunFolder(silo).case_file)
        per_frame = sum(data.nbytes for data in frames.values()) / len(frames["time"])
        assert per_frame <= n * silo_plan._OF_A_PARTICLE + 8 * silo_plan._numbers(case)
        columns = file["tables/contacts/columns"].values()
        row = sum(data.nbytes for data in columns) / len(next(iter(columns)))
        assert row == silo_plan._OF_A_CONTACT
    with h5py.File(damper / "trajectory.h5") as file:
        _, _, of_sample, of_frame, _ = damper_plan._kept(
            DamperCase.load(RunFolder(damper).case_file)
        )
        samples = file["frames"]
        assert sum(d.nbytes for d in samples.values()) / len(samples["time"]) <= of_sample
        particles = file["tables/particles/columns"].values()
        assert sum(d.nbytes for d in particles) / len(file["tables/particles/frame"]) == of_frame
        columns = file["tables/contacts/columns"].values()
        row = sum(data.nbytes for data in columns) / len(next(iter(columns)))
        assert row == damper_plan._OF_A_CONTACT


def test_a_hundred_times_the_frames_take_a_hundred_times_the_disk():
    """Most of the memory is the program's; what waits for a checkpoint adds to it."""
    few = SiloCase.load("A4")
    many = SiloCase.load("A4", {"output.frame_interval": "0.1 ms"})
    each = [
        silo_plan.disk_at_most(case)["frames"] - 60 * room._OF_A_FILE - room._OF_THE_WHOLE
        for case in (few, many)
    ]
    assert each[1] / each[0] == pytest.approx(100, rel=0.02)  # the first and the last besides
    rare = SiloCase.load(
        "A4", {"output.checkpoint_interval": "6 s", "output.frame_interval": "1 ms"}
    )
    frames = 6000 * silo_plan._kept(rare)[-1]
    assert silo_plan.memory_at_most(rare) > silo_plan.memory_at_most(few) + frames


@pytest.mark.parametrize(
    ("scale", "given", "intervals"),
    [
        (1.0, {}, (0.01, 0.05)),
        (0.2, {}, (0.01, 0.05)),  # A4 has 614: 15,400
        (0.17, {}, (0.02, 0.1)),  # 21,200
        (0.1, {}, (0.04, 0.2)),  # 61,400
        (0.1, {"output.frame_interval": "10 ms"}, (0.01, 0.2)),
        (0.1, {"output.contact_interval": "40 ms"}, (0.04, 0.04)),
    ],
)
def test_more_than_twenty_thousand_particles_have_fewer_frames(scale, given, intervals):
    """A frame for every 20,000 of them takes 10 ms more: no more than 2 million positions a second;
    what the case says stays."""
    case = SiloCase.load("A4", {"particles.scale": scale, **given})
    assert case.intervals == pytest.approx(intervals)
    told = silo2d("run", "A4", "--scale", scale, *DRY).out
    assert ("  frames  " in told) == (scale < 0.2)


def test_samples_do_not_pile_up_in_the_memory_of_a_run_of_few_particles():
    """Steps are cheap, and by their cost alone a checkpoint would come after 800,000 samples.

    What grows with the run is what its measures take at the end, of 20 frames a cycle; its first
    sample is one more than its cycles have.
    """
    changes = {"particles.count": 1, "output.keep": "summary"}
    short, long = (DamperCase.load("thesis", {**changes, "run.cycles": n}) for n in (1000, 9000))
    assert damper_plan.checkpoint_interval(long) == 10_000
    grows = damper_plan.memory_at_most(long) - damper_plan.memory_at_most(short)
    assert grows == pytest.approx(8000 * 20 * damper_plan._MEASURED, rel=1e-3)


def test_checkpoints_of_large_beds_are_two_thousand_steps_apart():
    """One costs as much as some tens of steps of its bed: as small a part of them at any size."""
    for count, steps in ((1_000, 200_000), (50_000, 4000), (100_000, 2000), (1_000_000, 2000)):
        case = DamperCase.load("thesis", {
            "enclosure.shape": "box", "enclosure.width": "2.2 m", "particles.count": count,
            "run.cycles": 1000,
        })  # fmt: skip
        assert damper_plan.checkpoint_interval(case) * case.steps_per_sample == steps


@pytest.mark.parametrize("shape", [{}, {"particles.shape": "prolate:1.5"}])
def test_the_memory_of_a_large_bed_counts_the_arrays_of_its_steps(shape):
    """A particle's part in them is the same in a small bed; many take GB."""
    few, many = (
        DamperCase.load("thesis", {
            "enclosure.shape": "box", "enclosure.width": width, "particles.count": count,
            "output.frames": 0, **shape,
        })
        for count, width in ((400, "7 cm"), (20_000, "1 m"))
    )  # fmt: skip
    centres = np.random.default_rng(1).uniform(-0.03, 0.03, size=(few.count, 3))
    turned = np.tile([1.0, 0.0, 0.0, 0.0], (few.count, 1)) if shape else None
    own = bytes_of_arrays(resting(few, centres, turned).world) / few.count
    grows = damper_plan.memory_at_most(many) - damper_plan.memory_at_most(few)
    assert 0.5 * own < grows / many.count < 2 * own


def bytes_of_arrays(arrays: Any) -> int:
    if isinstance(arrays, tuple):
        return sum(map(bytes_of_arrays, arrays))
    return arrays.nbytes if isinstance(arrays, np.ndarray) else 0


@pytest.mark.parametrize("n_bytes", [0, 12_000, 999_499, 999_500, 1.25e6, 9.96e6, 4.2e9, 3e12])
def test_bytes_are_written_with_a_unit(n_bytes):
    """To two digits or better, and never as nothing."""
    number, unit = room.in_words(n_bytes).replace(",", "").split()
    size = float(number) * {"kB": 1e3, "MB": 1e6, "GB": 1e9}[unit]
    assert size == pytest.approx(n_bytes, rel=0.05)


@pytest.fixture
def nearly_full(monkeypatch):
    usage = shutil.disk_usage("/")._replace(free=1000)
    monkeypatch.setattr(shutil, "disk_usage", lambda path: usage)


@pytest.mark.parametrize("command", [silo2d, damper3d])
def test_a_disk_with_too_little_room_is_warned_of(command, nearly_full, tmp_path):
    case = ["A4"] if command is silo2d else []
    reported = command("run", *case, *DRY, "-o", tmp_path / "runs").out
    words = " ".join(reported.split())
    assert "disk at most" in words
    assert "has 1 kB left" in words
    planned = command("run", *case, *DRY, "--json", "-o", tmp_path / "runs").json
    assert planned["disk_free_bytes"] == 1000
    assert set(planned["disk_bytes_at_most"]) == {"frames", "contacts", "checkpoints"}
    assert planned["memory_bytes_at_most"] > 1e8


def test_many_runs_are_added_up_and_warned_of(nearly_full, tmp_path, capsys):
    hungry = dataclasses.replace(FAKE, disk_at_most=lambda case: {"frames": 2_000_000})
    run_labelled(hungry, [({}, fake(3)), ({}, fake(4))], out=tmp_path, workers=1, quiet=True)
    assert "up to 4.0 MB may be needed" in capsys.readouterr().err


def test_of_runs_that_keep_a_summary_only_those_under_way_take_more():
    whole, stays = 2_000_000, 1_000
    frugal = dataclasses.replace(
        FAKE, disk_at_most=lambda case: {"frames": whole}, stays=lambda case: stays
    )
    cases = [fake(k) for k in range(10)]
    assert frugal.disk_of(cases, at_once=3) == 3 * whole + 7 * stays
    assert frugal.disk_of(cases, at_once=99) == 10 * whole
    assert dataclasses.replace(frugal, stays=FAKE.stays).disk_of(cases, at_once=3) == 10 * whole


def test_a_map_is_told_what_its_summaries_take():
    """Each of a hundred points at most what five files of a block are, and a core one run's."""
    grid = ["--frequencies", "40", "--gammas", ",".join(map(str, range(1, 101)))]
    planned = damper3d("map", *grid, *DRY, "--json").json
    point = damper3d("run", "--gamma", "100", "--keep", "summary", *DRY, "--json").json
    one = sum(point["disk_bytes_at_most"].values())
    assert 100 * 5 * 4096 < planned["disk_bytes_at_most"] < 100 * 5 * 4096 + cores() * one
    (run,) = KEPT.glob("damper/spheres-*f2c032c051bd")
    of_results = ("*.toml", "*.json")
    assert bytes_of(run, *of_results) < damper_plan._OF_A_SUMMARY
