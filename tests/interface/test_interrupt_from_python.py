"""Interrupt of a run or a sweep that Python called: answered soon, its state kept, gone on with."""

import os
import signal
import threading
import time

import pytest

from silo2d import SiloCase, run, sweep

SOON = 5.0  # [s] a second on a machine that is not busy


def interrupt(after, sent):
    """Send Ctrl-C after some seconds, and note when."""

    def send():
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    threading.Timer(after, send).start()


def test_interrupted_run_answers_soon_and_ends_as_the_one_that_was_not(tmp_path, reference):
    """To the same bits: the state digest is that of the run that was left alone."""
    case = SiloCase.load(reference.case_file)
    sent = []
    shown = []

    def progress(fraction, words):
        shown.append(fraction)
        if words.startswith("discharging") and not sent:
            interrupt(0.0, sent)
            time.sleep(0.1)

    with pytest.raises(KeyboardInterrupt, match="--resume"):
        run(case, out=tmp_path, progress=progress)
    assert time.monotonic() - sent[0] < SOON
    assert shown == sorted(shown)
    (folder,) = tmp_path.glob(f"{case.name}-seed*")
    assert (folder / "checkpoint.h5").exists()
    assert not (folder / "summary.json").exists()
    result = run(case, out=tmp_path)
    assert not result.reused
    assert result.run_folder == str(folder)
    assert result.state_digest == reference.read_summary()["state_digest"]


def test_interrupted_sweep_is_no_table(tmp_path):
    study = tmp_path / "study.toml"
    study.write_text(
        'schema = 1\nname = "two"\ncase = "A4"\nseeds = 2\n[vary]\nsilo.outlet = ["150 mm"]\n'
    )
    sent = []
    interrupt(3.0, sent)  # no seed is discharged by then: A4 takes longer to be filled
    with pytest.raises(KeyboardInterrupt, match="of 2 runs are not finished"):
        sweep(study, out=tmp_path / "runs")
    assert time.monotonic() - sent[0] < SOON
