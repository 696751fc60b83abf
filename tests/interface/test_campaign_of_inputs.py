"""The campaign of tests/fuzz sees what is bad and counts it; some of its inputs, each time."""

import sys
import time
from pathlib import Path

import click
import pytest
from hypothesis import given
from hypothesis import strategies as st

sys.path.insert(0, str(Path(__file__).parents[1] / "fuzz"))

import campaign
import judged
from kinds import KINDS

QUICK = ["silo case", "damper case", "silo study", "damper study", "materials", "shapes"]


def said(out: str = "", err: str = "", code: int = 0):
    """A program that says this."""

    def program() -> None:
        click.echo(out, nl=False)
        click.echo(err, nl=False, err=True)
        sys.exit(code)

    return program


def raising() -> None:
    raise KeyError("length")


PLANTED = {
    "a right refusal": (said(err="silo2d: width = -1 m: above 0\n", code=2), "refused", ""),
    "a right answer": (said(out='{"packing_fraction": 0.8}'), "answered", ""),
    "a traceback": (raising, "bad", "KeyError"),
    "unforeseen": (said(err="silo2d: KeyError; nobody foresaw\n", code=3), "bad", "traceback"),
    "two lines": (said(err="silo2d: a\nsilo2d: b\n", code=2), "bad", "not one line"),
    "no line": (said(code=2), "bad", "not one line"),
    "exit code": (said(err="silo2d: a\n", code=1), "bad", "exit code 1"),
    "Ctrl-C that nobody gave": (said(err="silo2d: stopped\n", code=130), "bad", "exit code 130"),
    "NaN in JSON": (said(out='{"t90_s": NaN}'), "bad", "NaN in JSON"),
    "half of JSON": (said(out='{"t90_s": 1'), "bad", "no JSON"),
    "nan in words": (said(out="emptied in nan s"), "bad", "no number"),
    "impossible": (said(out='{"packing_fraction": 1.18}'), "bad", "outside physics"),
    "sigma below 0": (said(out='{"mu": {"value": 1, "sigma": -1}}'), "bad", "below 0"),
    "no plan": (said(out='{"time_step_s": 0.0}'), "bad", "time_step_s"),
    "a warning of Python": (said(err="a.py:3: RuntimeWarning\n"), "bad", "warning of Python"),
    "a hang": (lambda: time.sleep(9.0), "bad", "hung"),
    "another answer": (said(out="outcome clogged"), "bad", "another answer"),
}


@pytest.mark.parametrize("name", PLANTED)
def test_a_planted_answer_is_seen_and_counted(name, monkeypatch, capsys):
    program, what, why = PLANTED[name]
    monkeypatch.setattr(judged, "LIMIT", 0.2)
    expected = "outcome empty" if name == "another answer" else None
    ledger = campaign.Ledger(seed=1)
    ledger.add("planted", 7, judged.verdict("silo2d", program, ("run", "--quiet"), None, expected))
    assert ledger.counts == {"planted": {what: 1}}
    assert why in "".join(reason for _, _, reason in ledger.bad)
    assert ledger.table().splitlines()[-1].startswith("bad: planted 7" if what == "bad" else "all")
    assert ("bad: planted 7 (seed 1)" in capsys.readouterr().out) == (what == "bad")


def test_an_input_is_made_again_from_its_kind_number_and_seed(tmp_path):
    written = []
    for name in ("a", "b"):
        made = campaign.tried("silo case", 5, 18, tmp_path, tmp_path / name, {})
        written.append(((tmp_path / name / "c.toml").read_bytes(), made.what))
    assert written[0] == written[1]


@given(st.sampled_from(QUICK), st.randoms(use_true_random=False))
def test_drawn_files_are_refused_or_answered(tmp_path_factory, kind, chance):
    """Files of the campaign, of which hypothesis finds the smallest that is bad."""
    folder = tmp_path_factory.mktemp("drawn")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        found = campaign.verdict_on(KINDS[kind].make(chance, folder), {})
    assert found.what != "bad", found.why
