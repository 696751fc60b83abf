"""What cannot be run: one line on stderr, exit code 2 or 3, no traceback, nothing overwritten."""

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import pytest
from refusals import assert_refused
from resealed import resealed
from small_silo import DRY, NARROWEST, DischargeStop, contents, silo2d, the_run, write_case

from granulab.campaign.runs.checkpoint import load_checkpoint, save_checkpoint
from granulab.contact.files.datafile import data_file
from granulab.errors import Stopped
from silo2d.case.case import SiloCase
from silo2d.engine import state
from silo2d.measures import MEASURES
from silo2d.run import protocol

# The command line


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "A5"], ["'A5'", "did you mean 'A", "known: A1, A2"]),
        (["run", "exampel"], ["did you mean 'example'"]),
        (["show", "wod19"], ["'wod19'", "did you mean 'wood19'"]),
        (["run", "A4", "--kn", "1e4"], ["A4: [law] kn = '1e4'", "unit is missing", "N/mm"]),
        (["run", "A4", "--kn", "1e4 N"], ["kn = '1e4 N'", "unit is wrong", "N/mm"]),
        (["run", "A4", "--outlet", "-1 cm"], ["[silo] outlet = '-1 cm'", "greater than 0"]),
        (["run", "A4", "--mu", "0.3 mm"], ["mu_particle = '0.3 mm'", "unit is wrong"]),
        (["run", "A4", "--seed", "one"], ["[run] seed = 'one'", "whole number"]),
        (["run", "A4", "--seed=--5"], ["[run] seed = '--5'", "whole number"]),
        (["run", "A4", "--damping", "measured"], ["'measured'", "'published' or 'restitution'"]),
        (["run", "A4", "--time-step", "1 ms"], ["[run] time_step = 1000 us", "at most"]),
        (["run", "A4", "--shapes", "wood18"], ["wood18", "did you mean 'wood19'"]),
        (["run", "A4", "--materials", "wod"], ["wod", "did you mean 'wood'"]),
        (["run", "A4", "--outlett", "1 cm"], ["'--outlett'", "'--outlet'"]),
        (["run", "A4", "--resume", "runs"], ["--resume", "one of them"]),
        (["run"], ["give a case", "--resume DIR"]),
        (["run", ""], ["no such preset or file"]),
        (["run", "--resume", "nowhere"], ["nowhere", "not a run folder"]),
        (["run", "--resume", "nowhere", "--kn", "1e4 N/mm"], ["leave other options out"]),
        (["render", "nowhere"], ["nowhere", "not a run folder"]),
        (["rum", "A4"], ["'rum'", "'run'"]),
        (["packing"], ["CASE"]),
        (["packing", "A7"], ["'A7'", "did you mean"]),
    ],
)
def test_a_bad_command_line(arguments, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert_refused(silo2d(*arguments), *words)
    assert not list(tmp_path.iterdir())


# The case file

SQUARE = [[0, 0], [50, 0], [50, 80], [0, 80]]
HOPPER = ["silo.angle", "silo.outlet", "silo.width", "silo.height"]
POLYGON: dict[str, Any] = dict.fromkeys(HOPPER)  # without the keys of a hopper
BAD_CASES: list[tuple[dict[str, Any], list[str]]] = [
    # names
    ({"silo.orifice": "5 cm"}, ["[silo] unknown key 'orifice'", "known: preset, angle"]),
    ({"silo.outlat": "5 cm"}, ["unknown key 'outlat'", "did you mean 'outlet'?"]),
    ({"sillo.outlet": "5 cm"}, ["unknown key 'sillo'", "did you mean 'silo'?"]),
    ({"run.door_speed": "1e-300 m/s"}, ["door_speed = ", "1e-300 m/s", "0.000001"]),
    ({"silo.preset": "A44", "silo.angle": None}, ["'A44'", "did you mean 'A4'?"]),
    ({"particles.material": "wod"}, ["no material 'wod'", "did you mean 'wood'?"]),
    ({"particles.shapes": "small.toml"}, ["small.toml", "unknown key"]),
    ({"name": "up/down"}, ["name = 'up/down'", "run folder"]),
    ({"name": "two\nlines"}, ["name = 'two\\nlines'", "run folder"]),
    ({"name": "a:b"}, ["name = 'a:b'", "Windows", "leave out"]),
    ({"name": 4}, ["name = 4", "must be a text"]),
    (
        {**POLYGON, "silo.outline": [*SQUARE[:3], [0, "80 mm"]]},
        ["outline.3.1 = '80 mm'", "must be a number, without quotation marks or a unit"],
    ),
    ({"silo.inserts": [[-10, 0]]}, ["inserts.0.0 = -10", "a list", "such as inserts = [[["]),
    ({"particles.scale": 0.01, "silo.height": "9 m", "fill.level": "8 m"}, ["at most 10,000,000"]),
    ({"name": 255 * "a" + "b"}, ["256 bytes", "at most 200"]),
    ({"silo": 4, **POLYGON}, ["[silo] expected a table"]),
    # units
    ({"silo.outlet": 50}, ["[silo] outlet = 50", "unit is missing", "'475 mm'"]),
    ({"silo.outlet": "50"}, ["[silo] outlet = '50'", "unit is missing", "'475 mm'"]),
    ({"silo.outlet": "50 kg"}, ["outlet = '50 kg'", "unit is wrong", "'475 mm'"]),
    ({"silo.outlet": "50 mn"}, ["outlet = '50 mn'", "unknown unit 'mn'"]),
    ({"silo.outlet": "5,0 cm"}, ["outlet = '5,0 cm'", "not a quantity"]),
    ({"silo.angle": "45"}, ["angle = '45'", "unit is missing", "'60 deg'"]),
    ({"law.kn": "1e4 N"}, ["[law] kn = '1e4 N'", "unit is wrong", "N/mm"]),
    ({"law.mu_wall": "0.4 mm"}, ["mu_wall = '0.4 mm'", "unit is wrong", "'0.38'"]),
    ({"fill.level": [50]}, ["level = [50]", "expected a quantity"]),
    # ranges
    ({"silo.outlet": "0 mm"}, ["outlet", "greater than 0"]),
    ({"silo.width": "-80 mm"}, ["width", "greater than 0"]),
    ({"silo.height": "0 m"}, ["height", "greater than 0"]),
    ({"fill.level": "-1 mm"}, ["level", "greater than 0"]),
    ({"fill.level": "90 mm"}, ["level = 90 mm", "at most the silo's height, 80 mm"]),
    ({"fill.level": "10 mm"}, ["level = 10 mm", "above the largest particle"]),
    ({"law.kn": "0 N/m"}, ["kn", "greater than 0"]),
    ({"law.mu_wall": -0.1}, ["mu_wall", "greater than or equal to 0"]),
    ({"law.gamma_n": "-1 1/s"}, ["gamma_n", "greater than or equal to 0"]),
    ({"run.time_step": "0 s"}, ["time_step", "greater than 0"]),
    ({"run.max_time": "1e999 s"}, ["max_time", "not a finite number"]),
    ({"run.seed": -1}, ["seed = -1", "greater than or equal to 0"]),
    ({"run.seed": 1.5}, ["seed = 1.5", "whole number"]),
    ({"output.layer_height": "0 mm"}, ["layer_height", "greater than 0"]),
    ({"output.layer_height": "1e-300 m"}, ["layer_height = 1e-300 m", "check the unit"]),
    ({"output.layer_height": "1e-9 m"}, ["layer_height", "greater than or equal to 0.000001"]),
    ({"pymunk.iterations": True}, ["[pymunk] iterations = true", "give a number"]),
    ({"run.seed": True}, ["seed = true", "give a number"]),
    ({"silo.angle": "90 deg"}, ["[silo]", "angle = 90 deg"]),
    ({"silo.angle": "-5 deg"}, ["[silo]", "angle = -5 deg"]),
    ({"silo.angle": "85 deg"}, ["[silo]", "angle = 85 deg", "at most"]),
    ({"silo.outlet": "90 mm"}, ["[silo]", "outlet = 90 mm", "80 mm"]),
    ({"silo.outlet": "4.9 mm"}, ["[silo] outlet = 4.9 mm", "narrowest particle, 5 mm"]),
    ({"run.time_step": "20 us"}, ["[run] time_step = 20 us", "at most 14.1 us", "leave it out"]),
    # outlines
    ({"silo.angle": None}, ["[silo] needs a preset", "angle and outlet"]),
    (POLYGON, ["[silo] is missing", "preset = 'A4'"]),
    ({"silo.outline": SQUARE}, ["[silo] angle", "outline", "leave one of them out"]),
    (
        {**POLYGON, "silo.outline": SQUARE[::-1]},
        ["[silo] outline", "clockwise", "counter-clockwise"],
    ),
    (
        {**POLYGON, "silo.outline": [[0, 0], [50, 0], [0, 80], [50, 80]]},
        ["[silo] outline", "crosses", "in order"],
    ),
    ({**POLYGON, "silo.outline": SQUARE[:2]}, ["[silo] outline", "at least 3"]),
    ({**POLYGON, "silo.outline": [[0, 0], [50]]}, ["[silo] outline", "list"]),
    ({**POLYGON, "silo.outline": [[0, 0], [50, 1], [50, 80], [0, 80]]}, ["not horizontal"]),
    ({**POLYGON, "silo.outline": SQUARE, "silo.outline_unit": "s"}, ["outline_unit", "wrong"]),
    (
        {**POLYGON, "silo.outline": SQUARE, "silo.outlet": "60 mm"},
        ["outlet = 60 mm", "at most 50 mm"],
    ),
    (
        {**POLYGON, "silo.outline": SQUARE, "silo.outlet": "20 mm", "silo.outlet_centre": "5 mm"},
        ["outlet_centre = 5 mm", "from 10 mm to 40 mm"],
    ),
    # what no material, and nobody's patience, can have
    ({"law.kn": "1e20 N/m", "run.time_step": None}, ["kn = 1e+20 N/m", "stiffer than any"]),
    ({"law.gamma_n": "1e9 1/s", "run.time_step": None}, ["gamma_n = 1e+09", "overdamped"]),
    ({"law.gamma_t": "1e9 1/s", "run.time_step": None}, ["gamma_t = 1e+09", "overdamped"]),
    ({"run.time_step": "1e-30 s"}, ["time_step = 1e-30 s", "6.0e+30 steps", "nobody can wait"]),
    ({"run.max_time": "1e12 s"}, ["1e+12 s take", "steps", "max_time"]),
    ({"run.max_time": "1e-9 s"}, ["max_time = 1e-09 s", "shorter than a step"]),
    (
        {"run.engine": "pymunk", "pymunk.time_step": "1 ns"},
        ["[pymunk] time_step = 1e-09", "nobody can wait"],
    ),
    (
        {"output.frame_interval": "1 us", "run.max_time": "60 s"},
        ["frame_interval = 1e-06 s", "no disk keeps"],
    ),
    ({"law.mu_wall": 1e6, "law.mu_particle": None}, ["mu_wall = 1000000.0", "equal to 1000"]),
    ({"fill.settled": 1e12}, ["settled", "less than or equal to 1"]),
    ({"run.seed": 10**300}, ["[run] seed", "9223372036854775807"]),
    ({"run.door_speed": "1e12 m/s"}, ["door_speed", "less than or equal to 1000"]),
    ({"silo.outlet_centre": "0 mm"}, ["outlet_centre goes with an outline"]),
    ({"silo.outline_unit": "s"}, ["outline_unit = '1 s'", "wrong"]),
    # names
    ({"name": "n" * 300}, ["name = ", "300 bytes", "at most 200"]),
    ({"name": ".."}, ["name = '..'"]),
    ({"particles.shapes": "a\x00b"}, ["zero byte"]),
    # what the materials file lacks
    (
        {"particles.wall": "steel"},
        ["wood.toml", "[material.steel] density", "[pair.wood-steel.linear] kt", "known: wood,"],
    ),
    (
        {"particles.materials": "steel"},
        ["steel.toml", "missing: [material.steel] length [mm]; [pair.steel-steel] restitution"],
    ),
    (
        {"particles.materials": "steel", "particles.material": "wood"},
        ["steel.toml", "no material 'wood'", "or youngs_modulus and poisson of both materials"],
    ),
    (
        {"particles.material": "methacrylate"},
        ["[material.methacrylate] length [mm]", "[pair.methacrylate-methacrylate] friction"],
    ),
    (
        {"law.damping": "restitution", "law.gamma_n": "5 1/s"},
        ["[law] gamma_n", "leave one of them out"],
    ),
]


@pytest.mark.parametrize(("changes", "words"), BAD_CASES)
def test_a_bad_case_file(changes, words, tmp_path):
    """The line names the file, the section and key, the value, and what would do."""
    case = write_case(tmp_path, changes)
    before = contents(tmp_path)
    assert_refused(silo2d("run", case, "-o", tmp_path / "runs", "--quiet"), *words)
    assert contents(tmp_path) == before
    assert not (tmp_path / "runs").exists()


def test_an_outlet_as_wide_as_the_narrowest_particle_is_tried(tmp_path):
    """The refusal is for what cannot come out at all."""
    case = SiloCase.load(write_case(tmp_path, {"silo.outlet": f"{NARROWEST} m"}))
    assert case.outline.outlet == NARROWEST


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (b"", ["schema is missing", "schema = 1"]),
        (b"schema = 2\n", ["schema = 2", "this version reads 1"]),
        (b"schema = 1\n", ["[silo] is missing"]),
        (b"schema = 1\n[silo\n", ["not valid TOML"]),
        (b"\xff\xfe\x00", ["not valid TOML"]),
        (b"x = " + b"[" * 5000 + b"]" * 5000, ["nested more than 50 deep"]),
        (b"[" + b".".join([b"a"] * 5000) + b"]\n", ["nested more than 50 deep"]),
    ],
)
def test_a_file_that_is_no_case(text, words, tmp_path):
    path = tmp_path / "case.toml"
    path.write_bytes(text)
    assert_refused(silo2d("run", path, "-o", tmp_path / "runs", "--quiet"), str(path), *words)
    assert_refused(silo2d("show", path), str(path))
    assert [path] == list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("cut", "words"),
    [
        (
            "[pair.wood-methacrylate.linear]",
            ["[pair.wood-methacrylate.linear] kt [N/mm], gamma_n [1/s]"],
        ),
        ("[pair.wood-methacrylate]", ["no pair 'wood-methacrylate'", "known: wood-wood"]),
        ("friction", ["[pair.wood-wood] friction; [pair.wood-methacrylate] friction"]),
        ("kt", ["[pair.wood-wood.linear] kt [N/mm]; [pair.wood-methacrylate.linear] kt"]),
        ("density", ["[material.wood] density [g/cm3]", "init --materials"]),
    ],
)
def test_a_materials_file_without_what_is_needed(cut, words, tmp_path):
    """Wood's file without a table, or without the lines of a key."""
    wood = data_file("materials", "wood")
    assert wood is not None
    lines = wood.read_text(encoding="utf-8").splitlines()
    if cut.startswith("["):
        lines = lines[: lines.index(cut)]
    lines = [line for line in lines if not line.startswith(f"{cut} = ")]
    (tmp_path / "mine.toml").write_text("\n".join(lines), encoding="utf-8")
    case = write_case(tmp_path, {"particles.materials": "mine.toml"})
    assert_refused(silo2d("run", case, "--dry-run"), "mine.toml", *words)


def test_all_that_a_materials_file_lacks_comes_in_one_answer(tmp_path):
    """The file that then has what was named is enough: one attempt, not one a key."""
    mine = tmp_path / "mine.toml"
    mine.write_text("schema = 1\n[material.wood]\npoisson = 0.3\n[pair.wood-wood]\n")
    changes = {"particles.materials": "mine.toml", "law.kn": None, "law.kt": "650 N/mm"}
    case = write_case(tmp_path, {**changes, "run.time_step": None})
    refused = silo2d("run", case, *DRY)
    assert_refused(refused, "mine.toml: missing: [material.wood] density [g/cm3], length [mm]")
    named = re.findall(r"\[([\w.-]+)\] ([a-z_]+(?: \[[^]]+\])?(?:, [a-z_]+(?: \[[^]]+\])?)*)",
                       refused.err)  # fmt: skip
    values = {"density": "0.5", "length": "20", "friction": "0.4", "kn": "1e4", "gamma_n": "6e3",
              "gamma_t": "3"}  # fmt: skip
    tables = {"material.wood": ["poisson = 0.3"], "pair.wood-wood": []}
    for where, keys in named:
        for one in keys.split(", "):
            key, _, unit = one.partition(" ")
            value = f'"{values[key]} {unit[1:-1]}"' if unit else values[key]
            tables.setdefault(where, []).append(f"{key} = {value}")
    text = "\n".join(f"[{where}]\n" + "\n".join(lines) for where, lines in tables.items())
    mine.write_text(f"schema = 1\n{text}\n")
    done = silo2d("run", case, *DRY)
    assert done.code == 0, done.err


def test_damping_from_restitution_takes_no_damping_of_the_file(tmp_path):
    """gamma_n follows from the restitution; the tangential one is 0 where nobody gives one."""
    wood = data_file("materials", "wood").read_text(encoding="utf-8").splitlines()
    kept = [line for line in wood if not line.startswith("gamma_")]
    (tmp_path / "mine.toml").write_text("\n".join(kept), encoding="utf-8")
    changes = {
        "particles.materials": "mine.toml", "law.damping": "restitution", "run.time_step": None
    }  # fmt: skip
    case = SiloCase.load(write_case(tmp_path, changes))
    shipped = SiloCase.load(write_case(tmp_path, {**changes, "particles.materials": "wood"}))
    assert case.particle_law.gamma_n == shipped.particle_law.gamma_n
    assert (case.particle_law.gamma_t, case.wall_law.gamma_t) == (0, 0)
    del changes["law.damping"]
    case = write_case(tmp_path, changes)
    assert_refused(silo2d("run", case, "--dry-run"), "[pair.wood-wood.linear] gamma_n [1/s], gam")


# Folders and files that cannot be used


def test_a_folder_that_cannot_be_written(tmp_path, monkeypatch):
    """Below a file nobody can make a folder; that is found out before the silo is filled."""
    monkeypatch.setattr("silo2d.run.protocol.pour", None)
    case = write_case(tmp_path)
    occupied = tmp_path / "notes.txt"
    occupied.write_text("mine", encoding="utf-8")
    before = contents(tmp_path)
    for command in ("run", "packing"):
        result = silo2d(command, case, "-o", occupied, "--quiet")
        assert_refused(result, str(occupied), "cannot be written", "--out")
    assert contents(tmp_path) == before


def test_init_overwrites_nothing(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("mine", encoding="utf-8")
    assert_refused(silo2d("init", path), str(path), "exists")
    assert_refused(silo2d("init", tmp_path / "none" / "mine.toml"), "cannot be written")
    assert path.read_text(encoding="utf-8") == "mine"
    assert [path] == list(tmp_path.iterdir())


def _truncated(data: bytes) -> bytes:
    return data[: len(data) // 2]


def _bit_flipped(data: bytes) -> bytes:
    middle = 2 * len(data) // 3
    return data[:middle] + bytes([data[middle] ^ 1]) + data[middle + 1 :]


def _of_another_schema(data: bytes) -> bytes:
    return data.replace(b"schema 1\n", b"schema 9\n", 1)


DAMAGES = {
    "truncated": (_truncated, "damaged"),
    "bit flipped": (_bit_flipped, "damaged"),
    "of another schema": (_of_another_schema, "schema 9 of another version"),
    "emptied": (lambda data: b"", "damaged"),
}


@pytest.fixture
def unfinished(runs, tmp_path) -> Path:
    """The folder of a run that was stopped at the second look."""
    looks = iter([False, True])
    stop = DischargeStop(lambda: next(looks, True))
    case = SiloCase.load(write_case(tmp_path))
    with pytest.raises(Stopped):
        protocol.run(case, out=runs, progress=stop.progress, stop=stop)
    return the_run(runs).path


def test_a_checkpoint_of_another_schema(unfinished, tmp_path):
    """It is refused and left as it is."""
    checkpoint = unfinished / "checkpoint.h5"
    checkpoint.write_bytes(_of_another_schema(checkpoint.read_bytes()))
    before = contents(unfinished)
    same = ["run", write_case(tmp_path), "-o", unfinished.parent]
    for command in (same, ["run", "--resume", unfinished]):
        result = silo2d(*command, "--quiet", "--no-figures")
        assert_refused(result, str(checkpoint), "schema 9 of another version", "delete the file")
        assert contents(unfinished) == before


def test_the_cure_for_a_damaged_checkpoint_works(unfinished, reference):
    (unfinished / "checkpoint.h5").unlink()
    table = silo2d("run", "--resume", unfinished, "--quiet", "--no-figures", "--json").json
    assert table["state_digest"] == reference.read_summary()["state_digest"]


@pytest.mark.parametrize("lost", ["row", "slip", "books"])
def test_a_checkpoint_of_another_case(unfinished, lost):
    """Whole, but of other arrays: it does not fit."""
    checkpoint = unfinished / "checkpoint.h5"
    arrays, meta = load_checkpoint(checkpoint)
    for others in ({**arrays, lost: arrays[lost][:-1]}, {**arrays, lost: None}):
        kept = {name: array for name, array in others.items() if array is not None}
        save_checkpoint(checkpoint, kept, meta)
        before = contents(unfinished)
        result = silo2d("run", "--resume", unfinished, "--quiet")
        assert_refused(result, str(checkpoint), "does not fit this case", "delete it")
        assert contents(unfinished) == before


@pytest.mark.parametrize("damage", ["truncated", "bit flipped", "emptied", "of another schema"])
def test_a_damaged_packing(runs, tmp_path, damage):
    """It is refused, not filled over; once it is deleted, the same one is filled."""
    (packing,) = runs.glob("packings/*/packing.h5")
    whole, harm = packing.read_bytes(), DAMAGES[damage][0]
    packing.write_bytes(harm(whole))
    harmed = packing.read_bytes()
    for command in ("run", "packing"):
        result = silo2d(command, write_case(tmp_path), "-o", runs, "--quiet")
        assert_refused(result, str(packing), "damaged", "delete it")
    assert packing.read_bytes() == harmed


@pytest.mark.parametrize(
    "harm",
    [
        lambda text: text[: len(text) // 2],
        lambda text: "",
        lambda text: "[]",
        lambda text: text.replace('"schema": 1', '"schema": 9'),
        lambda text: text.replace('"n_out"', '"n_0ut"'),
        lambda text: text.replace('"empty"', '"emptx"'),
        lambda text: text.replace('"steps": ', '"steps": 0.'),
    ],
)
def test_a_damaged_summary(finished, tmp_path, harm):
    """It is refused and left as it is; --again computes the run in a new folder."""
    run = the_run(finished)
    summary = run.path / "summary.json"
    text = harm(summary.read_text(encoding="utf-8"))
    assert text != summary.read_text(encoding="utf-8")
    summary.write_text(text, encoding="utf-8")
    before = contents(finished)
    same = ["run", write_case(tmp_path), "-o", finished, "--quiet", "--no-figures"]
    for command in (same, ["run", "--resume", run.path, "--quiet"], ["show", run.path]):
        assert_refused(silo2d(*command), str(summary), "--again")
    assert "damaged" in silo2d("list", "-o", finished).out
    assert contents(finished) == before


def test_the_cure_for_a_damaged_summary_works(finished, tmp_path):
    summary = the_run(finished).path / "summary.json"
    digest = json.loads(summary.read_text(encoding="utf-8"))["state_digest"]
    summary.write_text("{", encoding="utf-8")
    arguments = ["-o", finished, "--quiet", "--no-figures", "--json", "--again"]
    table = silo2d("run", write_case(tmp_path), *arguments).json
    assert (table["state_digest"], table["reused"]) == (digest, False)


def _without(name: str) -> Callable[[h5py.File], None]:
    def harm(file: h5py.File) -> None:
        del file[name]

    return harm


def _of_a_later_schema(file: h5py.File) -> None:
    file.attrs["schema"] = 9


def _nameless(file: h5py.File) -> None:
    del file.attrs["wall_names"]


def _with_a_particle_less(file: h5py.File) -> None:
    angle = file["frames/angle"][:, :-1]
    del file["frames/angle"]
    file["frames/angle"] = angle


HARMS: list[tuple[Callable[[h5py.File], None], list[str]]] = [
    (_of_a_later_schema, ["trajectory.h5", "schema 9 of another version"]),
    (_without("frames/spin"), ["damaged (no spin)"]),
    (_without("static/kind"), ["damaged (no kind)"]),
    (_without("frames"), ["trajectory.h5", "damaged"]),
    (_with_a_particle_less, ["damaged (angle is not of"]),
    (_nameless, ["damaged (no wall_names)"]),
]


@pytest.mark.parametrize(("harm", "words"), HARMS)
def test_a_trajectory_that_lacks_something(finished, tmp_path, harm, words):
    """Neither drawn nor exported."""
    folder = the_run(finished).path
    with resealed(folder / "trajectory.h5") as file:
        harm(file)
    before = contents(finished)
    for command in (["render", folder, "--no-film"], ["export", folder, "--to", "vtkhdf"]):
        assert_refused(silo2d(*command), str(folder), *words, "--again")
    assert contents(finished) == before


def test_damaged_contacts_are_not_taken_for_none(finished):
    folder = the_run(finished).path
    with resealed(folder / "trajectory.h5") as file:
        del file["tables/contacts/length"]
    for to in ("vtkhdf", "csv"):
        result = silo2d("export", folder, "--to", to)
        assert_refused(result, "trajectory.h5", "damaged", "--again")
    assert not (folder / "export").exists()


@pytest.mark.parametrize("command", [["render"], ["export", "--to", "csv"]])
def test_a_damaged_summary_is_neither_drawn_nor_exported(finished, command):
    folder = the_run(finished).path
    for text in ("{", '{"schema": 1, "n_out": 3}', '{"schema": 1, "outcome": 3}'):
        (folder / "summary.json").write_text(text, encoding="utf-8")
        result = silo2d(command[0], folder, *command[1:])
        assert_refused(result, "summary.json", "damaged", "--again")
    assert not (folder / "figures").exists()
    assert not (folder / "export").exists()


def test_a_finished_run_without_its_summary_counts_as_unfinished(finished, tmp_path):
    """What is there is exported; the same command would go on with it."""
    folder = the_run(finished).path
    (folder / "summary.json").unlink()
    assert silo2d("export", folder, "--to", "csv").code == 0
    assert "unfinished" in silo2d("show", folder).out


def test_nothing_is_measured_of_a_damaged_run(finished):
    """Each measure refuses it in one line, and makes no picture."""
    trajectory = the_run(finished).path / "trajectory.h5"
    whole = trajectory.read_bytes()
    for harm, words in HARMS[:3]:
        trajectory.write_bytes(whole)
        with resealed(trajectory) as file:
            harm(file)
        for what in MEASURES:
            result = silo2d("observe", trajectory.parent, what)
            assert_refused(result, str(trajectory.parent), *words, "--again")
    trajectory.write_bytes(_truncated(whole))
    for what in MEASURES:
        result = silo2d("observe", trajectory.parent, what)
        assert_refused(result, str(trajectory), "damaged", "--again")
    assert not (trajectory.parent / "figures").exists()


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (["render"], ["damaged", "--again"]),
        (["export", "--to", "vtkhdf"], ["damaged", "--again"]),
        (["export", "--to", "csv"], ["damaged", "--again"]),
    ],
)
def test_a_truncated_trajectory(finished, command, words):
    folder = the_run(finished).path
    trajectory = folder / "trajectory.h5"
    trajectory.write_bytes(_truncated(trajectory.read_bytes()))
    assert_refused(silo2d(command[0], folder, *command[1:]), str(trajectory), *words)
    trajectory.unlink()
    assert_refused(silo2d(command[0], folder, *command[1:]), "no trajectory here")
    shutil.rmtree(folder)
    assert_refused(silo2d(command[0], folder, *command[1:]), "not a run folder")
    assert_refused(silo2d("show", folder), "no such preset, file or run")


# A simulation that fails


@pytest.mark.parametrize(
    ("column", "value"),
    [(state.X, float("nan")), (state.UY, float("inf")), (state.VX, 1e6), (state.VY, 40.0)],
)
def test_a_state_that_is_no_longer_possible(unfinished, column, value):
    """NaN, infinite, or with energy from nowhere: exit code 3, the time, and what to try.

    A particle at 40 m/s has some 1000 times the energy that the whole silo can give off. The last
    checkpoint and the frames before it stay.
    """
    checkpoint = unfinished / "checkpoint.h5"
    arrays, meta = load_checkpoint(checkpoint)
    arrays["row"][0, column] = value
    save_checkpoint(checkpoint, arrays, meta)
    before = contents(unfinished)
    result = silo2d("run", "--resume", unfinished, "--quiet", "--no-figures")
    del before["provenance.json"]  # which says now that the run failed, and why
    words = ["the simulation failed at t = 0.0", "in steps of 10 us"]
    assert_refused(result, *words, code=3)
    after = contents(unfinished)
    assert {name: after[name] for name in before} == before


def _with_pipe(folder: Path) -> Path:
    pipe = folder / "pipe.toml"
    os.mkfifo(pipe)
    return pipe


@pytest.mark.parametrize("where", ["--materials", "particles.shapes", "sweep"])
def test_a_pipe_given_as_a_file_is_refused_and_not_waited_for(tmp_path, where):
    pipe = _with_pipe(tmp_path)
    if where == "sweep":
        result = silo2d("sweep", pipe, "--dry-run")
    elif where == "--materials":
        result = silo2d("run", "A4", where, pipe, "--dry-run")
    else:
        result = silo2d("run", write_case(tmp_path, {where: pipe.name}), "--dry-run")
    assert_refused(result, str(pipe), "a pipe or device")


@pytest.mark.parametrize("name", ["case.toml", "summary.json", "provenance.json", "trajectory.h5"])
def test_a_pipe_in_a_run_folder_is_refused_and_not_waited_for(finished, name):
    folder = the_run(finished).path
    (folder / name).unlink()
    os.mkfifo(folder / name)
    resume = ["run", "--resume", folder, "--no-figures", "--quiet"]
    for command in (["show", folder], ["observe", folder, "curve"], resume):
        result = silo2d(*command)
        if result.code:
            assert_refused(result, str(folder))
    assert silo2d("list", "--verify", "-o", finished).code == 2


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"name": "a\0b"}, ["name", "letters, digits"]),
        ({"particles.shapes": "a\0b"}, ["shapes", "zero byte"]),
    ],
)
def test_a_name_that_no_file_can_have(tmp_path, changes, words):
    assert_refused(silo2d("run", write_case(tmp_path, changes), "--dry-run"), *words)  # fmt: skip


def test_an_output_that_is_full_is_one_line_with_an_exit_code():
    """/dev/full takes nothing."""
    command = [sys.executable, "-m", "silo2d", "list"]
    with Path("/dev/full").open("wb") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 2
    assert "output cannot be written (No space left on device)" in done.stderr
    assert done.stderr.count("\n") == 1
