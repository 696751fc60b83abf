"""What every command has in common: folders that cannot be written, faults that nobody foresaw."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from refusals import assert_refused
from small_damper import damper3d
from small_silo import silo2d, the_run, write_case

from granulab.campaign.output.terminal import INTERVAL
from granulab.contact.files.datafile import data_root

STUDIES = data_root() / "studies"
WRITING = {
    silo2d: ["run A4", "run A4 --again", "packing A4", f"sweep {STUDIES / 'friction.toml'}",
             "compare --engines dem,pymunk A4"],
    damper3d: ["run", "map --frequencies 20 --gammas 1", "shear", "compress", "pack", "predict",
               "contact force", "shape --prolate 2", f"sweep {STUDIES / 'damper.toml'}"],
}  # fmt: skip


@pytest.mark.parametrize(
    ("command", "line"), [(command, line) for command, lines in WRITING.items() for line in lines]
)
def test_a_folder_that_cannot_be_written_is_refused_before_all_else(
    command, line, tmp_path, monkeypatch
):
    """One line, before the case is echoed, kernels are compiled or anything is computed."""
    monkeypatch.setattr(
        "granulab.campaign.output.files.os.access", lambda path, mode: path != tmp_path
    )  # permissions do not bind root
    result = command(*line.split(), "-o", tmp_path / "runs")
    assert (result.code, result.out) == (2, "")
    assert re.fullmatch(rf"\w+: {tmp_path}\S* cannot be written .*--out\n", result.err), result.err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("command", [silo2d, damper3d])
@pytest.mark.parametrize("options", [(), ("--verify",)])
def test_a_folder_with_a_name_longer_than_any_is_refused(command, options):
    assert_refused(command("list", *options, "-o", "x" * 300), "xxx", "longer than", "shorter")


def test_a_finished_run_is_given_from_a_folder_that_takes_no_new_ones(
    finished, tmp_path, monkeypatch
):
    """The run's own folder can be written, and its lock is taken there."""
    monkeypatch.setattr(
        "granulab.campaign.output.files.os.access", lambda path, mode: path != finished
    )
    case = ["run", write_case(tmp_path), "-o", finished, "--no-figures"]
    assert silo2d(*case, "--json").json["reused"]
    assert silo2d(*case, "--again").code == 2


@pytest.mark.parametrize(
    ("command", "case"),
    [(silo2d, "silo2d.case.case.SiloCase"), (damper3d, "damper3d.case.case.DamperCase")],
)
def test_a_fault_that_nobody_foresaw_is_one_line(command, case, tmp_path, monkeypatch):
    """A numerical library's exception: kind, position and where the traceback is kept."""

    def no_load(*_arguments):
        return np.linalg.inv(np.zeros((2, 2)))

    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr(f"{case}.load", no_load)
    result = command("run") if command is damper3d else command("run", "A4")
    assert_refused(result, "LinAlgError: Singular matrix (at ", code=3)
    assert re.search(r"\.commands\.run:\d+ in run, raised in numpy", result.err)
    kept = Path(result.err.rpartition(" in ")[2].strip())
    text = kept.read_text(encoding="utf-8")
    assert text.startswith(f"{result.err.partition(':')[0]} run")
    assert "Traceback (most recent call last)" in text
    assert "no_load" in text


def test_a_traceback_that_cannot_be_kept_is_no_second_fault(tmp_path, monkeypatch):
    """The temporary folder is gone: the line says so."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "none"))
    monkeypatch.setattr("damper3d.case.case.DamperCase.load", lambda *_: {}["key"])
    result = damper3d("run")
    assert result.code == 3
    assert "KeyError: 'key' (at damper3d.commands.run:" in result.err
    assert "could not be kept" in result.err


@pytest.mark.parametrize("streams", [("stdout", "stderr"), ("stderr",)])
def test_a_run_ends_in_good_order_when_the_reader_of_its_words_goes_away(tmp_path, streams):
    """As with `2>&1 | head -4`: it goes on in silence, keeps its result and ends with 0."""
    reading, writing = os.pipe()
    command = ["-m", "silo2d", "run", str(write_case(tmp_path)), "-o", str(tmp_path / "runs")]
    whither = {"stdout": subprocess.PIPE, **dict.fromkeys(streams, writing)}
    process = subprocess.Popen(
        [sys.executable, *command, "--no-figures"], env={**os.environ, INTERVAL: "0.1"}, **whither
    )
    os.close(writing)
    with os.fdopen(reading) as reader:
        for _ in range(4):
            reader.readline()
    out, _ = process.communicate(timeout=300)
    assert process.returncode == 0
    assert the_run(tmp_path / "runs").state == "finished"
    assert out is None or b"particles out" in out


def test_a_list_ends_with_0_when_its_reader_has_gone():
    reading, writing = os.pipe()
    os.close(reading)
    process = subprocess.Popen(
        [sys.executable, "-m", "silo2d", "list"], stdout=writing, stderr=subprocess.PIPE
    )
    os.close(writing)
    assert process.communicate(timeout=100) == (None, b"")
    assert process.returncode == 0
