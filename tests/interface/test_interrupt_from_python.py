"""Interrupt of a run or a sweep that Python called: answered soon, its state kept, gone on with."""

import os
import signal
import threading
import time
from contextlib import contextmanager

import pytest

from damper3d import Grid, efficiency_map
from silo2d import SiloCase, run, sweep

SOON = 5.0  # [s] a second on a machine that is not busy


@contextmanager
def interrupted_once(there):
    """Send Ctrl-C once `there` is true, and give when; nothing is sent after the block."""
    sent, over = [], threading.Event()

    def watch():
        while not over.wait(0.05):
            if there():
                sent.append(time.monotonic())
                os.kill(os.getpid(), signal.SIGINT)
                return

    watching = threading.Thread(target=watch)
    watching.start()
    try:
        yield sent
    finally:
        over.set()
        watching.join()


def filling(out):
    """Whether a worker has begun to fill a silo or a damper, which takes it seconds."""
    return lambda: any(path.is_dir() for path in (out / "packings").glob("*"))


def test_interrupted_run_answers_soon_and_ends_as_the_one_that_was_not(tmp_path, reference):
    """To the same bits: the state digest is that of the run that was left alone."""
    case = SiloCase.load(reference.case_file)
    shown, discharging = [], threading.Event()

    def progress(fraction, words):
        shown.append(fraction)
        if words.startswith("discharging") and not discharging.is_set():
            discharging.set()
            time.sleep(0.2)  # for the watcher to see it

    with interrupted_once(discharging.is_set) as sent:  # noqa: SIM117
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
    with interrupted_once(filling(tmp_path)) as sent:  # noqa: SIM117
        with pytest.raises(KeyboardInterrupt, match="of 2 runs are not finished"):
            sweep(study, out=tmp_path)
    assert time.monotonic() - sent[0] < SOON


@pytest.mark.usefixtures("damper_reference")  # has the kernels compiled, which is not cut short
def test_interrupted_map_is_no_map(tmp_path):
    grid = Grid(frequencies=(40.0,), gammas=(5.0, 20.0))
    with interrupted_once(filling(tmp_path)) as sent:  # noqa: SIM117
        with pytest.raises(KeyboardInterrupt, match="of 2 runs are not finished"):
            efficiency_map("thesis", {}, grid, out=tmp_path, quiet=True)
    assert time.monotonic() - sent[0] < SOON
