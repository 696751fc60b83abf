"""Cases on the page: the same files, refusals and digests as on the command line."""

import shutil
import signal
import time
import tomllib
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from refusals import assert_refuses
from small_damper import damper3d
from small_silo import CASE, SHAPES, silo2d, write_case
from studio_server import Studio
from waiting import wait_until

from damper3d.case.case import DamperCase
from damper3d.run.sweep import DAMPER
from granulab.campaign.runs.folder import RunFolder
from granulab.errors import InputError
from granulab.studio.desk import Desk
from granulab.studio.folder import Folder
from granulab.studio.forms import document, texts_of, to_toml
from granulab.studio.rooms import damper, drawings, silo
from granulab.studio.rooms.simulator import Bench
from silo2d.case.case import SiloCase
from silo2d.case.settings import Settings
from silo2d.run.sweep import SILO

BENCHES = {"silo2d": silo.bench(), "damper3d": damper.bench()}
LOADED = {"silo2d": (SiloCase, SILO), "damper3d": (DamperCase, DAMPER)}


@pytest.mark.parametrize(
    ("command", "name"),
    [(command, name) for command, bench in BENCHES.items() for name in bench.presets()],
)
def test_a_case_saved_and_opened_again_has_the_digest_of_the_command_line(tmp_path, command, name):
    bench, folder = BENCHES[command], Folder(tmp_path)
    texts = bench.texts(folder, name)
    shown = bench.check(folder, texts)
    assert shown["refused"] == ""
    saved = bench.save(folder, texts, replace=False)
    assert saved == {"file": shown["file"], "exists": False, "run": shown["run"]}
    case, simulator = LOADED[command]
    of_file = case.load(tmp_path / saved["file"])
    assert simulator.digest(of_file) == shown["digest"]
    assert simulator.run_folder(of_file, tmp_path / "runs").path.name == shown["run"]
    again = bench.check(folder, bench.texts(folder, saved["file"]))
    assert again["digest"] == shown["digest"]


REFUSED = {
    "silo2d": [
        {"silo": {"preset": "A9"}},
        {"silo": {"outlet": "60"}},
        {"silo": {"outlet": "60 kg", "angle": "45 deg"}},
        {"silo": {"outline": "[[0, 0], [100, 5], [100, 300], [0, 300]]"}},
        {"silo": {"outline": "[[0, 0], [100, 0]"}},
        {"silo": {"outline": "a circle"}},
        {"silo": {"preset": "A4"}, "run": {"seed": "-1"}},
        {"silo": {"preset": "A4"}, "run": {"seed": "true"}},
        {"silo": {"preset": "A4"}, "fill": {"level": "2 m"}},
        {"silo": {"preset": "A4"}, "fill": {"friction": "nan"}},
        {"silo": {"preset": "A4"}, "law": {"mu_wall": "much"}},
        {"silo": {"preset": "A4"}, "particles": {"shapes": "wood20"}},
        {"silo": {"preset": "A4"}, "sieve": {"mesh": "5 mm"}},
    ],
    "damper3d": [
        {"enclosure": {"diameter": "-4 mm"}},
        {"enclosure": {"shape": "cone"}},
        {"motion": {"frequency": "40 kg"}},
        {"particles": {"count": "many"}},
        {"particles": {"count": "20000"}},
        {"host": {"mass": "1 kg"}},
        {"excitation": {"kind": "random", "psd": "[[20, 0.1]]"}},
    ],
}


@pytest.mark.parametrize(
    ("command", "case"), [(name, case) for name, cases in REFUSED.items() for case in cases]
)
def test_a_refusal_is_the_line_that_the_command_says_of_the_file(
    tmp_path, monkeypatch, command, case
):
    monkeypatch.chdir(tmp_path)
    shown = BENCHES[command].check(Folder(tmp_path), case)
    Path("case.toml").write_text(shown["toml"])
    run = {"silo2d": silo2d, "damper3d": damper3d}[command]
    said = run("run", "case.toml", "--dry-run")
    assert said.code == 2
    assert shown["refused"] == said.err.removeprefix(f"{command}: ").rstrip("\n")


@pytest.mark.parametrize("command", BENCHES)
def test_texts_of_a_form_are_the_values_of_the_file(command):
    """Every key of the schema as `init` writes it, from TOML to texts and back."""
    bench = BENCHES[command]
    tables = bench.preset("example" if command == "silo2d" else "damper")
    tables = {name: table for name, table in tables.items() if table != {}}
    assert document(bench.settings, texts_of(tables)) == tables
    assert tomllib.loads(to_toml(tables, 1, "head")) == {"schema": 1, **tables}


def test_a_form_has_every_key_with_its_words():
    form = {section["name"]: section for section in BENCHES["silo2d"].form()}
    assert list(form) == [name for name in Settings.model_fields if name != "name"]
    level = next(key for key in form["fill"]["keys"] if key["name"] == "level")
    assert level["usual"] == "475 mm"
    assert level["unit"] == "m"
    assert "height of the filling" in level["meaning"]
    keep = next(key for key in form["law"]["keys"] if key["name"] == "keep_ratios")
    assert keep["choices"] == ["true", "false"]


def test_a_file_of_another_kind_is_opened_nowhere_else(tmp_path):
    folder = Folder(tmp_path)
    BENCHES["silo2d"].save(folder, {"name": "s", "silo": {"preset": "A4"}}, replace=False)
    shaken = {"name": "d", "motion": {"gamma": "5"}}  # all else is the thesis's
    BENCHES["damper3d"].save(folder, shaken, replace=False)
    assert BENCHES["damper3d"].texts(folder, "d.toml")["motion"] == {"gamma": "5"}
    (tmp_path / "stones.toml").write_text(SHAPES)
    for command, name, held in (
        ("damper3d", "s.toml", "a case of silo2d"),
        ("silo2d", "d.toml", "a case of damper3d"),
        ("silo2d", "stones.toml", "shapes, no case of silo2d"),
    ):
        assert_refuses([name, held], BENCHES[command].texts, folder, name)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (SHAPES, "same.toml: holds shapes, no case of silo2d; give the case another name"),
        ('schema = 1\n[material.wood]\ndensity = "0.45 g/cm3"\n', "same.toml: holds materials"),
        ("schema = 1\n[motion]\ngamma = 5\n", "same.toml: holds a case of damper3d"),
        ("no [[ TOML", "same.toml: not valid TOML"),
    ],
)
def test_a_case_does_not_replace_a_file_of_something_else(tmp_path, content, words):
    (tmp_path / "same.toml").write_text(content)
    desk = Desk(tmp_path)
    case = {"name": "same", "silo": {"preset": "A4"}}
    if content == SHAPES:
        case["particles"] = {"shapes": "same.toml"}
    with pytest.raises(InputError) as refused:
        desk.orders["save"]("silo2d", case, replace=True)
    assert desk.without_root(str(refused.value)).startswith(words)
    assert (tmp_path / "same.toml").read_text() == content


def test_shapes_do_not_replace_a_case(tmp_path):
    BENCHES["silo2d"].save(Folder(tmp_path), {"name": "s", "silo": {"preset": "A4"}}, replace=False)
    before = (tmp_path / "s.toml").read_text()
    square = {"name": "1", "outline": [[0, 0], [8, 0], [8, 8], [0, 8]]}
    words = ["s.toml: holds no shapes; give these another name"]
    drawn = Folder(tmp_path), "s", "1 mm", [square], True
    assert_refuses(words, drawings.draw_shapes, *drawn)
    assert (tmp_path / "s.toml").read_text() == before


def test_a_case_written_by_hand_keeps_its_comments_where_nothing_has_changed(tmp_path):
    bench, folder = BENCHES["silo2d"], Folder(tmp_path)
    assert silo2d("init", tmp_path / "mine.toml").code == 0
    before = (tmp_path / "mine.toml").read_text()
    texts = bench.texts(folder, "mine.toml")
    saved = bench.save(folder, texts, replace=False)
    assert saved["exists"] is False
    assert saved["run"] == SILO.run_folder(SiloCase.load(tmp_path / "mine.toml"), "runs").path.name
    assert (tmp_path / "mine.toml").read_text() == before
    texts["run"]["seed"] = "7"
    assert bench.save(folder, texts, replace=False)["exists"] is True


def test_a_silo_that_is_refused_for_something_else_is_shown(tmp_path):
    bench, folder = BENCHES["silo2d"], Folder(tmp_path)
    silo_alone = {"preset": "A4", "inserts": "[[[-40, 180], [40, 180], [0, 250]]]"}
    fine = bench.check(folder, {"silo": silo_alone})["preview"]
    for wrong in ({"fill": {"level": "999 mm"}}, {"law": {"mu_wall": "much"}}):
        refused = bench.check(folder, {"silo": silo_alone, **wrong})
        assert refused["refused"]
        walls = ("outline", "lips", "inserts", "outlets")
        assert refused["preview"] == {name: fine[name] for name in walls}
    assert "preview" not in bench.check(folder, {"silo": {"preset": "A9"}})


def test_cases_are_checked_one_at_a_time(tmp_path, monkeypatch):
    """Each may take seconds and much memory; a page asks for another while one is on its way."""
    desk, now, most = Desk(tmp_path), [], []

    def check(bench, folder, texts):
        now.append(1)
        most.append(len(now))
        time.sleep(0.02)
        now.pop()
        return {"refused": "slow"}

    monkeypatch.setattr(Bench, "check", check)
    with ThreadPoolExecutor(4) as together:
        for one in [together.submit(desk.orders["check"], "silo2d", {}) for _ in range(4)]:
            one.result()
    assert most == [1, 1, 1, 1]


def test_a_file_of_another_case_is_replaced_only_when_told(tmp_path):
    bench, folder = BENCHES["silo2d"], Folder(tmp_path)
    bench.save(folder, {"name": "one", "silo": {"preset": "A4"}}, replace=False)
    before = (tmp_path / "one.toml").read_text()
    other = {"name": "one", "silo": {"preset": "B4"}}
    assert bench.save(folder, other, replace=False) == {"file": "one.toml", "exists": True}
    assert (tmp_path / "one.toml").read_text() == before
    assert bench.save(folder, other, replace=True)["exists"] is False
    assert 'preset = "B4"' in (tmp_path / "one.toml").read_text()


def small(folder: Path, **changes: dict) -> dict:
    """The texts of the small silo, with its shapes in a folder."""
    (folder / "small_shapes.toml").write_text(SHAPES)
    tables: dict = {"name": "small"}
    for key, value in CASE.items():
        section, _, name = key.partition(".")
        tables.setdefault(section, {})[name] = value
    for section, table in changes.items():
        tables[section] = {**tables.get(section, {}), **table}
    return texts_of(tables)


def test_the_preview_of_a_silo_is_what_its_filling_begins_with(tmp_path, monkeypatch):
    """Kinds, positions and angles of the rain, as the run of this seed pours it."""
    from silo2d.run import pour

    bench, folder = BENCHES["silo2d"], Folder(tmp_path)
    shown = bench.check(folder, small(tmp_path, run={"seed": 3}))["preview"]
    poured = {}

    class Begun(Exception):
        pass

    def begin(case, kinds, poses, outline):
        poured.update(kinds=kinds, poses=poses)
        raise Begun

    monkeypatch.setattr(pour, "pouring", begin)
    case = SiloCase.load(write_case(tmp_path, {"run.seed": 3}))
    with pytest.raises(Begun):
        pour.pour(case, 3, lambda *_: None)
    assert shown["particles"]["kind"] == poured["kinds"].tolist()
    assert np.allclose(shown["particles"]["pose"], poured["poses"], rtol=0, atol=5e-7)
    assert len(shown["shapes"]) == len(case.shapes.shapes)


def test_the_start_of_a_damper_fits_and_does_not_overlap(tmp_path):
    tables = {"particles": {"shape": "sphere:4mm", "count": 60}, "enclosure": {"diameter": "30 mm"}}
    found = damper.start({"name": "d", **tables}, "d.toml", tmp_path)
    spheres = np.array(found["spheres"])
    assert spheres.shape == (60, 4)
    apart = np.linalg.norm(spheres[:, None, :3] - spheres[None, :, :3], axis=2)
    np.fill_diagonal(apart, 1.0)
    assert apart.min() > 0.98 * 4e-3  # growth ends with overlaps of a part of a per cent
    assert np.hypot(*spheres[:, :2].T).max() <= 15e-3 - 0.98 * 2e-3


@pytest.fixture(scope="module")
def studio(tmp_path_factory, reference):
    """The studio on a folder that has the finished run of the small silo, and a copy of it."""
    folder = tmp_path_factory.mktemp("cases, größer")
    for name in (reference.path.name, "copy"):
        shutil.copytree(reference.path, folder / "runs" / name)
    running = Studio(folder)
    yield running
    running.close()


def until(studio: Studio, run: str, reached: Callable[[dict], bool]) -> None:
    """Wait until a run is in a state."""
    wait_until(lambda: reached(studio.ask("run", run=run)), 90.0)


def test_a_run_goes_on_after_the_studio_has_ended_to_the_bits_of_one_never_stopped(
    tmp_path, reference
):
    """Ending the studio ends its runs in good order; another studio goes on with them."""
    case = small(tmp_path, output={"checkpoint_interval": "5 ms"})
    first = Studio(tmp_path)
    begun = first.order("begin", simulator="silo2d", case=case, figures=False)
    run = begun["run"]
    again = first.order("begin", simulator="silo2d", case=case)
    assert again["run"] == run, "it is watched, not begun again"
    assert first.order("check", simulator="silo2d", case=case)["state"] == "running"

    def has_a_frame(state: dict) -> bool:
        return "time" in first.ask("frame", run=run) or state["state"] != "running"

    until(first, run, has_a_frame)
    frame = first.ask("frame", run=run)
    assert frame["of"] > frame["out"] >= 0
    # A particle counts as out from y = 0 on, and is drawn until its bounding circle is below.
    heights = [y for _, y, _ in frame["particles"]["pose"]]
    assert sum(y >= 0.0 for y in heights) == frame["of"] - frame["out"]
    code, err = first.close()
    assert (code, err.count("\n")) == (0, 1), err

    folder = RunFolder(tmp_path / "runs" / run)
    second = Studio(tmp_path)
    if folder.state == "unfinished":  # it may have been faster
        assert folder.checkpoint.exists()
        with folder.lock():
            pass  # nobody computes in it any more
        assert second.order("resume", run=run) == {"run": run, "simulator": "silo2d"}
        until(second, run, lambda state: state["state"] == "finished")
    assert "nothing to stop" in second.order("stop", run=run)["refusal"]
    second.close()
    own, never_stopped = folder.read_summary(), reference.read_summary()
    assert own["state_digest"] == never_stopped["state_digest"]


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_no_run_outlives_a_studio_that_is_ended_or_loses_its_terminal(tmp_path, number):
    one = Studio(tmp_path)
    run = one.order("begin", simulator="silo2d", case=small(tmp_path), figures=False)["run"]
    folder = RunFolder(tmp_path / "runs" / run)
    wait_until(lambda: folder.state != "new", 90.0)
    assert one.close(number)[0] == -number
    with folder.lock():
        pass  # nobody computes in it any more


def test_a_finished_run_shows_results_player_and_its_case(studio, reference):
    """Opened again from its folder, the case has the run's own digest."""
    run = reference.path.name
    assert {one["run"] for one in studio.ask("runs")} == {run, "copy"}
    found = studio.ask("results", run=run)
    assert "particles out" in found["words"]
    assert str(studio.folder) not in found["words"]
    again = studio.order("check", simulator="silo2d", case=found["case"])
    assert (again["refused"], again["run"], again["state"]) == ("", run, "finished")
    player = studio.request("GET", f"player/{run}", origin="")
    assert player.body.lower().startswith(b"<!doctype html>")
    assert player.headers["content-security-policy"].startswith("sandbox allow-scripts;")


def test_two_runs_are_compared(studio, reference):
    """A run and a copy of it leave at the same times."""
    both = studio.order("compare", first=reference.path.name, second="copy")
    assert "curves 0.000 s apart in the mean" in both["words"]
    (picture,) = both["figures"]
    assert (studio.folder / picture).read_bytes().startswith(b"\x89PNG")


def test_what_is_no_run_is_refused(studio):
    for question in ("run", "results"):
        assert "no run" in studio.ask(question, run="none")["refusal"]
        assert "refusal" in studio.ask(question, run="../runs")
    assert studio.ask("frame", run="small") == studio.ask("run", run="small")


def test_materials_come_with_their_sources(studio):
    found = studio.ask("materials", name="wood")
    rows = {(one["section"], one["key"]): one for one in found["values"]}
    friction = rows["pair.wood-wood", "friction"]
    assert friction["value"].startswith("0.38")
    assert friction["source"]
    assert friction["meaning"]


def test_particles_that_are_drawn_become_a_shape_file_or_are_refused(studio):
    square = [[0, 0], [8, 0], [8, 8], [0, 8]]
    one = {"name": "1", "outline": square}
    done = studio.order("draw_shapes", name="mine", spheroradius="1 mm", shapes=[one])
    assert done == {"file": "mine.toml", "exists": False}
    (shown,) = studio.ask("shapes", name="mine.toml")["shapes"]
    assert shown["name"] == "1"
    hollow = {"name": "1", "outline": [[0, 0], [8, 0], [2, 2], [0, 8]]}
    refused = studio.order("draw_shapes", name="other", spheroradius="1 mm", shapes=[hollow])
    assert refused["refusal"].startswith("other.toml: [shape 1] outline: concave")
    assert not (studio.folder / "other.toml").exists()
    tried = studio.order("draw_shapes", name="", spheroradius="1 mm", shapes=[hollow])
    assert tried["refusal"].startswith("shapes.toml: [shape 1] outline: concave")
    assert studio.order("draw_shapes", name="", spheroradius="1 mm", shapes=[one]) == {}
    again = studio.order("draw_shapes", name="mine", spheroradius="2 mm", shapes=[one])
    assert again["exists"] is True
