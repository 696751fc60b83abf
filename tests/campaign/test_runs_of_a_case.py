"""Runs of a case: results that stay true when a process is cut off, whatever it did."""

import dataclasses

import pytest

from granulab.campaign.runs.folder import RunFolder
from silo2d.case.case import SiloCase
from silo2d.run.protocol import RUNS

CASE = SiloCase.load("A4")


class Read:
    """A result that is the folder itself."""

    @classmethod
    def read(cls, folder, *, reused):
        return folder


@pytest.mark.parametrize("file", ["summary", "provenance"])
def test_results_that_a_kill_left_half_measured_are_measured_again(tmp_path, monkeypatch, file):
    """Cut off as it is about to write a file, another version's numbers never pass for today's."""
    runs = dataclasses.replace(
        RUNS, result=Read, compute=lambda *_: {"answer": 1}, measured=lambda *_: {"answer": 2}
    )
    folder = runs.run(CASE, out=tmp_path)
    folder.write_provenance({**folder.read_provenance(), "measures_digest": "of another version"})

    def cut_off(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(RunFolder, f"write_{file}", cut_off)
        with pytest.raises(KeyboardInterrupt):
            runs.run(CASE, out=tmp_path)
    assert runs.run(CASE, out=tmp_path).read_summary()["answer"] == 2
    assert folder.read_provenance()["measures_digest"] == RUNS.measures.digest
